"""One report on several methods: comparable ends and times, failures that end nothing, one page."""

import dataclasses
import json
import math
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.plan import Plan
from geomint.plots.panels import Line, thinned
from geomint.report import drift_sections
from geomint.report.kind_plots import kinds_figure, swatch
from geomint.report.kinds import kinds_in_words, names_by_kind
from geomint.report.text import duration, number, short_slope
from geomint.watch.kinds import KINDS
from geomint.watch.quantities import kind_of

METHODS = ["gauss-8", "rk-4:0.02", "rk-4:0.04", "cf-4", "rattle-4", "lobatto-3:40"]
LABELS = ["gauss-8", "rk-4:0.02", "rk-4:0.04", "cf-4", "rattle-4", "lobatto-3"]
SCENE = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 20.0})


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("several")
    return folder, gi.drift_report(SCENE, folder, False, methods=METHODS)


@pytest.fixture(scope="module")
def result(report):
    return report[1]


@pytest.fixture(scope="module")
def record(report):
    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    return json.loads((report[0] / "drift.json").read_text("utf-8"), parse_constant=refuse)


@pytest.fixture(scope="module")
def page(report):
    return (report[0] / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("blank_pictures")
def test_a_cell_says_how_long_it_was_watched(tmp_path):
    observe = {"quantities": ["energy", "measure"], "measure": {"steps": 8}}
    scene = SCENE.changed(time={"tau_end": 5.0}, observe=observe)
    gi.drift_report(scene, tmp_path, False, methods=["gauss-8:0.1", "gauss-2:0.1"])
    text = (tmp_path / "report.html").read_text("utf-8")
    assert text.count("(to τ = 0.8)") == 4  # in the table of methods, and in that of each


def test_every_method_in_what_suits_it(result):
    assert [run.label for run in result] == LABELS
    chosen = {run.label: run.plan.route.name for run in result}
    assert chosen["gauss-8"] == chosen["rattle-4"] == "hamiltonized"
    assert chosen["cf-4"] == "reduced"
    assert result["gauss-8"].solution.step == 0.25  # the scene's own
    assert result["rk-4:0.04"].solution.step == 0.04


def test_a_single_run_gives_the_same_numbers(result):
    for label, method in (("gauss-8", None), ("rattle-4", "rattle-4")):
        plan = gi.make_plan(SCENE.changed_integration(method), "drift")
        alone = plan.solve(progress=False)
        for name, drift in alone.drift.items():
            assert result[label].drift[name].as_json() == drift.as_json()


def test_methods_in_t_end_where_the_scene_ends(result):
    own = SCENE.changed_integration("gauss-8", 0.1)
    end = gi.run_scene(own, progress=False)
    assert result.physical_end == pytest.approx(end.t[-1], rel=1e-12)
    for label in ("gauss-8", "cf-4"):
        solution = result[label].solution
        state = solution.problem.physical_state(solution.y[-1])
        expected = end.problem.physical_state(end.y[-1])
        np.testing.assert_allclose(state["gamma"], expected["gamma"], atol=1e-6)


def test_all_drifts_are_over_the_scenes_time(result):
    assert result.time == "tau"
    for run in result:
        for drift in run.drift.values():
            assert drift.windows.times[-1] == pytest.approx(20.0, rel=0.02)
            assert run.solution.drift_time == "tau"
    # The slope is per unit of τ: that of the run in t, times the mean rate dt/dτ.
    end = result.physical_end
    alone = gi.make_plan(
        SCENE.changed(time={"t_end": end}).changed_integration("cf-4"), "drift"
    ).solve(progress=False)
    slope = result["cf-4"].drift["energy"].slope
    assert slope == pytest.approx(alone.drift["energy"].slope * end / 20.0, rel=1e-9)


def test_a_failure_ends_nothing(result, record, page):
    failed = result["lobatto-3"]
    assert failed.status == "failed"
    assert "did not converge" in failed.message
    assert failed.drift == {}
    assert result.status == "success"
    assert record["methods"]["lobatto-3"]["status"] == "failed"
    assert record["methods"]["lobatto-3"]["quantities"] == {}
    assert "lobatto-3: failed." in page
    assert not any("lobatto-3" in words for _, words in kinds_in_words(result))


def test_a_method_that_fits_nothing_is_told_why(tmp_path):
    scene = gi.load_scene("ball-3d").changed(time={"t_end": 2.0})
    runs = gi.drift_report(scene, tmp_path, False, methods=["cf-4", "rattle-4"])
    assert runs["cf-4"].status == "success"
    assert runs["rattle-4"].plan is runs["rattle-4"].solution is None
    assert "no form 'hamiltonian'" in runs["rattle-4"].message
    assert "no form &#39;hamiltonian&#39;" in (tmp_path / "report.html").read_text("utf-8")


@pytest.mark.parametrize("methods", [["rattle-4"], ["rattle-2", "rattle-4"]])
def test_where_no_method_begins_there_is_no_report(methods, tmp_path):
    scene = gi.load_scene("ball-3d").changed(time={"t_end": 2.0})
    with pytest.raises(gi.FormError, match=methods[0]):
        gi.drift_report(scene, tmp_path, False, methods=methods)
    assert not list(tmp_path.iterdir())


def test_where_every_method_fails_the_report_failed(tmp_path):
    integrate = {"step": 40.0, "iteration": "fixed-point"}
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 80.0}, integrate=integrate)
    runs = gi.drift_report(scene, tmp_path, False)
    assert runs.status == "failed"
    assert isinstance(runs[0].error, gi.ConvergenceError)
    assert "No step was watched" in (tmp_path / "report.html").read_text("utf-8")


def test_ctrl_c_leaves_what_was_computed(monkeypatch, tmp_path):
    solve = Plan.solve

    def interrupted(plan, progress):
        if plan.scene.method.name == "rk-4":
            raise KeyboardInterrupt
        return solve(plan, progress)

    monkeypatch.setattr(Plan, "solve", interrupted)
    runs = gi.drift_report(SCENE, tmp_path, False, methods=["gauss-8", "rk-4", "cf-4"])
    assert [run.status for run in runs] == ["success", "interrupted", "not run"]
    assert runs.status == "interrupted"
    assert runs["gauss-8"].drift["energy"].windows.samples == 80
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "rk-4: interrupted." in page
    assert "cf-4: not run." in page


def test_ctrl_c_before_any_step_leaves_no_report(monkeypatch, tmp_path):
    def interrupted(plan, progress):
        raise KeyboardInterrupt

    monkeypatch.setattr(Plan, "solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        gi.drift_report(SCENE, tmp_path, False, methods=["gauss-8", "rk-4"])
    assert not list(tmp_path.iterdir())


def test_sections_are_a_list_of_functions_and_a_folder_of_templates():
    folder = Path(drift_sections.__file__).parent / "templates" / "drift"
    names = [section.__name__ for section in drift_sections.SECTIONS]
    assert sorted(names) == sorted(path.name.removesuffix(".html.j2") for path in folder.iterdir())


def test_sections_of_one_and_of_several_methods(result, page):
    """Facts are in the sections of one method, and unfolded in the table of each of several."""
    one = dataclasses.replace(result, runs=[result["cf-4"]])
    shown = {f.__name__ for f in drift_sections.SECTIONS if f(one) is not None}
    several = {f.__name__ for f in drift_sections.SECTIONS if f(result) is not None}
    assert shown - several == {"facts"}
    assert several - shown == {"kinds", "methods", "costs"}
    for run in result:
        for drift in run.drift.values():
            assert number(drift.final_error) in page
    facts = sum(bool(run.drift) for run in result) + 1  # the parameters
    assert page.count('<dl class="facts">') == facts


def test_what_was_watched_to_the_end_is_not_said_to_be_shorter(page):
    """Of methods in t either, whose drifts are shown over τ."""
    assert "(to τ" not in page


def test_the_contract(record):
    assert list(record["methods"]) == LABELS
    for entry in record["methods"].values():
        for quantity in entry["quantities"].values():
            assert math.isfinite(quantity["max_abs_error"])
            assert quantity["class"]
    assert record["kinds"] == {
        "energy": "energy",
        "K": "integrals",
        "norm": "constraints",
        "tangency": "constraints",
        "measure": "measure",
    }
    assert record["methods"]["cf-4"]["run"]["steps"] > 100
    assert record["provenance"]["scene_toml"]


def test_quantities_that_a_representation_lacks_are_told(tmp_path):
    scene = gi.Scene(
        system={"name": "chaplygin-ball", "moments": [1.0, 2.0, 3.0], "D": 1.0},
        initial={"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
        time={"t_end": 2.0},
        observe={"quantities": ["energy", "area"]},
    )
    runs = gi.drift_report(scene, tmp_path, False, methods=["cf-4", "rattle-2"])
    assert list(runs["rattle-2"].missing) == ["area"]
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "hamiltonized has no such quantity" in page
    entry = json.loads((tmp_path / "drift.json").read_text("utf-8"))["methods"]["rattle-2"]
    assert "area" in entry["missing"]


class Tags(HTMLParser):
    def __init__(self):
        super().__init__()
        self.images, self.links = [], []

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        assert tag not in ("script", "link", "iframe", "object", "embed")
        self.links += [named[key] for key in ("src", "href") if key in named]
        if tag == "img":
            self.images.append(named)


def test_the_page_needs_nothing_but_itself(page):
    tags = Tags()
    tags.feed(page)
    assert all(link.startswith("data:image/svg+xml;base64,") for link in tags.links)
    pictures = 4 + 5 + 2  # four kinds, five quantities, the motion
    assert len(tags.images) == 2 * len(METHODS) + pictures  # lines twice
    for words in ("Kinds of drift", "time per step", "What it cost", "other integrals", "hash"):
        assert words in page


def test_the_picture_has_a_panel_for_each_kind(result):
    figure = kinds_figure(result)
    figure.canvas.draw()
    drawn = [axes for axes in figure.axes if axes.axison]
    titles = [axes.get_title(loc="left") for axes in drawn]
    assert titles == ["energy", "other integrals", "constraints", "invariant measure"]
    assert len({axes.get_ylim() for axes in drawn}) == 1
    assert {axes.get_yscale() for axes in drawn} == {"log"}
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert set(legend) == {run.title for run in result}
    assert "lobatto-3 (failed)" in legend
    styles = {(line.get_color(), line.get_linestyle()) for line in drawn[0].lines[1:]}
    assert len(styles) >= 5
    sizes = [t.get_fontsize() for t in figure.findobj(lambda a: hasattr(a, "get_fontsize"))]
    assert min(sizes) >= 8.0
    assert swatch(3).get_size_inches()[0] == 0.5


def test_kinds_are_data(result):
    problem = SCENE.problem
    assert list(names_by_kind(result)) == ["energy", "integrals", "constraints", "measure"]
    assert kind_of("energy", problem) == "energy"
    assert kind_of("measure", problem) == "measure"
    assert kind_of("something of the user's", problem) == "others"
    assert set(map(kind_of, ["norm", "K"], [problem] * 2)) <= set(KINDS)
    words = dict(kinds_in_words(result))
    assert words["constraints"].startswith("no larger than 32 ε × scale: gauss-8, cf-4, rattle-4")


def test_what_is_not_conserved_is_no_drift(tmp_path):
    """It is in the table and has a plot, but no panel, and nobody is said to have lost it."""
    scene = gi.load_scene("rolling-ball-n3").changed(
        time={"t_end": 1.0}, observe={"quantities": ["energy", "contact-1"]}
    )
    runs = gi.drift_report(scene, tmp_path, False, methods=["gauss-8"])
    assert list(names_by_kind(runs)) == ["energy", "others"]
    assert [kind for kind, _ in kinds_in_words(runs)] == ["energy"]
    assert len([axes for axes in kinds_figure(runs).axes if axes.axison]) == 1
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "contact-1" in page
    assert "not conserved" in page


@pytest.mark.usefixtures("blank_pictures")
def test_methods_of_the_scene(tmp_path):
    scene = SCENE.changed(drift={"methods": ["gauss-8", "gauss-4:0.1"]})
    runs = gi.drift_report(scene, tmp_path, progress=False)
    assert [run.label for run in runs] == ["gauss-8", "gauss-4"]
    assert runs["gauss-4"].solution.step == 0.1


@pytest.mark.parametrize(
    ("drift", "words"),
    [
        ({"methods": ["gauss-8", "gaus-4"]}, "Did you mean 'gauss-4'"),
        ({"methods": ["gauss-8:-1"]}, "the step of 'gauss-8' = -1.0"),
        ({"methods": ["gauss-8:x"]}, "the step of 'gauss-8' = 'x'"),
        ({"methods": []}, "at least 1 item"),
        ({"methods": ["gauss-8"], "step": 1.0}, "NAME:STEP"),
        ({"quantities": ["enrgy"]}, "Did you mean 'energy'"),
    ],
)
def test_flaws_of_the_scene(drift, words):
    with pytest.raises(gi.SceneError, match="drift") as caught:
        SCENE.changed(drift=drift)
    assert words in str(caught.value)


def test_flaws_of_the_call(tmp_path):
    with pytest.raises(gi.MethodError, match="Did you mean"):
        gi.drift_report(SCENE, tmp_path, False, methods=["gauss-8", "gaus-4"])
    with pytest.raises(gi.DomainError, match="a list of names"):
        gi.drift_report(SCENE, tmp_path, False, methods="gauss-8")
    with pytest.raises(gi.DomainError, match="at least one"):
        gi.drift_report(SCENE, tmp_path, False, methods=[])
    assert not list(tmp_path.iterdir())


def test_thinned_lines_keep_the_largest():
    times = np.arange(1.0, 1001.0)
    sizes = np.random.default_rng(1).random(1000)
    line = thinned(Line("a", times, sizes))
    assert len(line.times) <= 60
    assert line.sizes.max() == sizes.max()
    assert line.times[-1] == 1000.0
    assert line.sizes[-1] >= sizes[-1]
    assert thinned(Line("a", -times, sizes)).times[-1] == 1000.0
    few = thinned(Line("a", times[:5], sizes[:5]))
    np.testing.assert_array_equal(few.sizes, sizes[:5])
    assert len(thinned(Line("a", times[:0], sizes[:0])).times) == 0


def test_durations_and_slopes():
    assert duration(0.0) == "–"
    assert duration(1.25e-6) == "1.25\u202fµs"
    assert duration(0.034) == "34\u202fms"
    assert duration(3e-9) == "3\u202fns"
    assert short_slope(1.0, 1e-5) == "1"
    assert short_slope(1.0, 0.5) == "(1.00 ± 0.50)e+00"
    assert short_slope(None, None) == "—"
