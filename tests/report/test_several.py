"""One report on several methods: comparable ends and times, failures that end nothing, one page."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from matplotlib.text import Text

import geomint as gi
from geomint.cli import find_command
from geomint.plan import Plan
from geomint.reports.files import write
from geomint.reports.kind_plots import kinds_figure, swatch
from geomint.reports.kinds import kinds_in_words, names_by_kind
from geomint.reports.text import number

METHODS = ["gauss-8", "rk-4:0.02", "cf-4", "gauss-8:20"]
LABELS = ["gauss-8", "rk-4", "cf-4", "gauss-8:20"]
SCENE = gi.load_scene("hamiltonized-n3").changed(
    time={"tau_end": 20.0}, integrate={"iteration": "fixed-point"}
)
BALL = gi.load_scene("ball-3d").changed(time={"t_end": 2.0})
blank = pytest.mark.usefixtures("blank_pictures")


MADE = []


@pytest.fixture
def made(blank_pictures, tmp_path_factory):
    if not MADE:
        folder = tmp_path_factory.mktemp("several")
        MADE.append(gi.drift_report(SCENE, folder, progress=False, methods=METHODS))
        MADE.extend([json.loads((folder / "drift.json").read_text("utf-8")), page_of(folder)])
    return MADE


result, record, page = (
    pytest.fixture(name=name)(lambda made, i=i: made[i])
    for i, name in enumerate(("result", "record", "page"))
)


def page_of(folder):
    return (folder / "report.html").read_text("utf-8")


def test_every_method_in_what_suits_it(result, record):
    assert [run.label for run in result] == list(record["methods"]) == LABELS
    chosen = {run.label: run.plan.route.name for run in result}
    assert list(chosen.values()) == ["hamiltonized", "hamiltonized", "reduced", "hamiltonized"]
    steps = {run.label: run.solution.step for run in result}
    assert steps["gauss-8"] == 0.25  # the scene's own
    assert (steps["rk-4"], steps["gauss-8:20"]) == (0.02, 20.0)
    kinds = {"energy": ["energy"], "integrals": ["K"], "constraints": ["norm", "tangency"]}
    kinds["measure"] = ["measure"]
    assert names_by_kind(result) == kinds
    assert record["kinds"] == {name: kind for kind, names in kinds.items() for name in names}
    words = dict(kinds_in_words(result))["constraints"]
    assert words.startswith("no larger than round-off: gauss-8, cf-4")


def test_a_single_run_gives_the_same_numbers(result):
    """Methods in t end where the scene ends in τ; all drifts are over its time, per unit of it."""
    own = gi.make_plan(SCENE.changed_integration("gauss-8"), "drift").solve(progress=False)
    in_t = SCENE.changed(time={"t_end": result.physical_end}).changed_integration("cf-4")
    alone = gi.make_plan(in_t, "drift").solve(progress=False)
    end = gi.run_scene(SCENE.changed_integration("gauss-8"), progress=False)
    assert result.physical_end == pytest.approx(end.t[-1], rel=1e-12)
    for name, drift in own.drift.items():
        assert result["gauss-8"].drift[name].as_json() == drift.as_json()
    expected = own.problem.physical_state(own.y[-1])["gamma"]
    for run in result:
        for drift in run.drift.values():
            assert drift.windows.times[-1] == pytest.approx(20.0, rel=0.02)
            assert math.isfinite(drift.max_abs_error)
        if run.drift:
            state = run.solution.problem.physical_state(run.solution.y[-1])
            np.testing.assert_allclose(state["gamma"], expected, atol=1e-4)
            assert run.solution.drift_time == result.time == "tau"
    # The slope is per unit of τ: that of the run in t, times the mean rate dt/dτ.
    slope = alone.drift["energy"].slope * result.physical_end / 20.0
    assert result["cf-4"].drift["energy"].slope == pytest.approx(slope, rel=1e-9)


def test_a_failure_ends_nothing(result, record, page):
    failed, entry = result["gauss-8:20"], record["methods"]["gauss-8:20"]
    assert (failed.status, failed.drift, result.status) == ("failed", {}, "success")
    assert (entry["status"], entry["quantities"]) == ("failed", {})
    assert "did not converge" in failed.message
    assert "gauss-8:20: failed." in page
    assert not any("gauss-8:20" in words for _, words in kinds_in_words(result))


@blank
def test_where_a_run_fails_there_is_what_was_reached(tmp_path):
    """Of no step at all nothing; where every method fails, so has the report."""
    scene = SCENE.changed(drift={"quantities": ["energy"]})
    runs = gi.drift_report(scene, tmp_path, progress=False, methods=["rk-4:2", "rk-4:0.04"])
    assert [run.status for run in runs] == ["failed", "success"]
    assert runs.motion.stretch.times[-1] == 2.0
    assert "The motion" in page_of(tmp_path)
    runs = gi.drift_report(scene, tmp_path, progress=False, methods=["rk-4:2"])
    assert runs.status == "failed"
    assert isinstance(runs[0].error, gi.NonFiniteError)
    runs = gi.drift_report(scene.changed_integration("gauss-8", 20.0), tmp_path, progress=False)
    assert (runs.status, runs.motion) == ("failed", None)
    assert "No step was watched" in page_of(tmp_path)


@blank
def test_what_a_method_lacks_is_told(tmp_path):
    """Quantities of another representation, and a form that the system does not have."""
    ball = BALL.changed(
        system={"attitude": False},
        initial={"k": [-0.8, 1.0, 0.6]},  # of which there is a Hamiltonian form
        drift={"quantities": ["energy", "area"]},
    ).changed_integration("rk-4", 0.1)
    scenes = [ball.changed_integration(representation=r) for r in ("classical", "hamiltonized")]
    one, other = (next(iter(gi.run_methods(s.for_drift(), ["rk-4"], False))) for s in scenes)
    other = dataclasses.replace(other, label="other")
    assert (list(one.missing), list(other.missing)) == ([], ["area"])
    write(find_command("drift").report(None, gi.SeveralRuns(ball, [one, other]), None), tmp_path)
    assert '<span class="small">hamiltonized has no such quantity' in page_of(tmp_path)
    record = json.loads((tmp_path / "drift.json").read_text("utf-8"))
    assert "area" in record["methods"]["other"]["missing"]
    runs = gi.drift_report(BALL, tmp_path, progress=False, methods=["cf-4", "rattle-4"])
    assert runs["cf-4"].status == "success"
    assert runs["rattle-4"].plan is runs["rattle-4"].solution is None
    assert "no form 'hamiltonian'" in runs["rattle-4"].message
    assert "no form &#39;hamiltonian&#39;" in page_of(tmp_path)


def test_where_no_method_begins_there_is_no_report(tmp_path):
    """Nor for calls that make no sense."""
    for scene, methods, error, words in (
        (BALL, ["rattle-2", "rattle-4"], gi.FormError, "rattle-2"),
        (SCENE, ["gauss-8", "gaus-4"], gi.SceneError, "Did you mean"),
        (SCENE, "gauss-8", gi.SceneError, "expected a list"),
        (SCENE, [], gi.SceneError, "at least 1"),
    ):
        with pytest.raises(error, match=words):
            gi.drift_report(scene, tmp_path, progress=False, methods=methods)
    assert not list(tmp_path.iterdir())


@blank
def test_ctrl_c_leaves_what_was_computed(monkeypatch, tmp_path):
    """Before any step: nothing."""
    solve = Plan.solve

    def interrupted(plan, progress):
        if plan.scene.method.name == "rk-4":
            raise KeyboardInterrupt
        return solve(plan, progress)

    monkeypatch.setattr(Plan, "solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        gi.drift_report(SCENE, tmp_path, progress=False, methods=["rk-4", "gauss-8"])
    assert not list(tmp_path.iterdir())
    runs = gi.drift_report(SCENE, tmp_path, progress=False, methods=["gauss-8", "rk-4", "cf-4"])
    assert [run.status for run in runs] == ["success", "interrupted", "not run"]
    assert runs.status == "interrupted"
    assert runs["gauss-8"].drift["energy"].windows.samples == 80
    page = page_of(tmp_path)
    assert "rk-4: interrupted." in page
    assert "cf-4: not run." in page


def test_sections_of_one_and_of_several_methods(result, page):
    """Facts are in the sections of one method, and unfolded in the table of each of several."""
    few = ["Facts", "Kinds of drift", "Method by method", "What it cost, and errors"]
    one = dataclasses.replace(result, runs=[result["cf-4"]])
    several = dataclasses.replace(result, runs=result.runs[:2])
    reports = [find_command("drift").report(None, runs, None) for runs in (one, several)]
    shown = [[getattr(b, "heading", type(b).__name__) for b in report.blocks] for report in reports]
    assert [[name for name in few if name in headings] for headings in shown] == [few[:1], few[1:]]
    assert all(number(x.final_error) in page for run in result for x in run.drift.values())
    facts = sum(bool(run.drift) for run in result) + 1  # the parameters
    assert page.count('<dl class="facts">') == facts
    pictures = 4 + 5 + 2  # four kinds, five quantities, the motion
    assert page.count("<img ") == 2 * len(METHODS) + pictures  # lines twice
    for words in ("Kinds of drift", "time per step", "What it cost", "other integrals", "hash"):
        assert words in page


@blank
def test_a_cell_says_how_long_it_was_watched(page, tmp_path):
    """What was watched to the end is not said to be shorter: of methods in t either."""
    assert "(to τ" not in page
    observe = {"quantities": ["energy", "measure"], "measure": {"steps": 8}}
    drift = {"quantities": ["energy", "measure"], "methods": ["gauss-8:0.1", "rk-4:0.1"]}
    scene = SCENE.changed(time={"tau_end": 5.0}, drift=drift).changed(observe=observe)
    runs = gi.drift_report(scene, tmp_path, progress=False)  # by the methods of the scene
    assert [(run.label, run.solution.step) for run in runs] == [("gauss-8", 0.1), ("rk-4", 0.1)]
    assert page_of(tmp_path).count("(to τ = 0.8)") == 4  # in the table of methods, of each


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
    assert "gauss-8:20 (failed)" in legend
    styles = {(line.get_color(), line.get_linestyle()) for line in drawn[0].lines[1:]}
    assert len(styles) >= len(METHODS) - 1
    assert min(text.get_fontsize() for text in figure.findobj(Text)) >= 8.0
    assert swatch(3).get_size_inches()[0] == 0.5


@blank
def test_what_is_not_conserved_is_no_drift(tmp_path):
    """It is in the table and has a plot, but no panel, and nobody is said to have lost it."""
    seen = gi.observable(lambda params, t, y, work: y[0])
    scene = SCENE.changed(time={"tau_end": 1.0}, drift={"quantities": ["energy", "observables"]})
    (name, problem), *_ = scene.model.problems.items()
    scene.model.problems[name] = dataclasses.replace(problem, observables={"seen": seen})
    runs = gi.drift_report(scene, tmp_path, progress=False, methods=["rk-4:0.02"])
    assert list(names_by_kind(runs)) == ["energy", "others"]
    assert [kind for kind, _ in kinds_in_words(runs)] == ["energy"]
    assert len([axes for axes in kinds_figure(runs).axes if axes.axison]) == 1
    page = page_of(tmp_path)
    assert [word in page for word in ("seen", "not conserved")] == [True, True]
