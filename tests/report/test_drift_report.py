"""The drift report of one method: ``drift.json``, and a page that needs nothing but itself.

It opens with the motion; what is within round-off is folded.
"""

from __future__ import annotations

import base64
import copy
import dataclasses
import json
import math
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.figure import Figure

import geomint as gi
from geomint.cli import find_command
from geomint.reports.files import write
from geomint.reports.kinds import by_roundoff
from geomint.reports.motion_panels import motion_draws
from geomint.reports.text import duration, number, parameters_told, short_slope, with_error

SCENE = gi.load_scene("ball-3d").changed(time={"t_end": 40.0})


class Page(HTMLParser):
    """Links and images of a page, and those that are folded."""

    def __init__(self, folder):
        super().__init__()
        self.text = (folder / "report.html").read_text("utf-8")
        self.links, self.images, self.folded, self.folds = [], [], [], 0
        self.feed(self.text)

    def handle_starttag(self, tag, attributes):
        named = dict(attributes)
        assert tag not in ("script", "link", "iframe", "object", "embed")
        self.links += [named[key] for key in ("src", "href", "action", "data") if key in named]
        self.folds += tag == "details"
        if tag == "img":
            (self.folded if self.folds else self.images).append(named)

    def handle_endtag(self, tag):
        self.folds -= tag == "details"


def record_of(folder):
    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    return json.loads((folder / "drift.json").read_text("utf-8"), parse_constant=refuse)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    return gi.drift_report(SCENE, folder, progress=False), record_of(folder), Page(folder)


report, record, page = (
    pytest.fixture(name=name)(lambda made, i=i: made[i])
    for i, name in enumerate(("report", "record", "page"))
)


def test_parameters_are_those_given(page):
    """Under their keys and symbols, in their order; what the equations have beside follows."""
    told = re.findall(r"<dt>([^<]*)</dt><dd>([^<]*)</dd>", page.text)
    names = [name for name, _ in told]
    first = names.index("moments (I)")
    assert told[first : first + 2] == [("moments (I)", "1, 2, 3"), ("D", "1")]
    assert "a" not in names[:first]
    ball = {"name": "rolling-ball", "moments": [0.4, 0.5, 0.7], "m": 2.0, "rho": 0.5}
    state = {"gamma": [0.48, 0.6, 0.64], "omega": [1.0, -2.0, 1.5]}
    scene = gi.Scene("r", system=ball, initial=state, time={"t_end": 1.0})
    told = parameters_told(scene, scene.problem)
    expected = {"moments (I)": "0.4, 0.5, 0.7", "m": "2", "rho (ρ)": "0.5"}
    assert list(told.items())[:3] == list(expected.items())
    assert "D" in told  # of the equations


def test_the_numbers_are_those_of_the_solution(record, report):
    """Finite, under their names, and of what they say: the largest is no less than the last."""
    assert (record["status"], record["time"], record["physical_end"]) == ("success", "t", None)
    (entry,), drifts = record["methods"].values(), report["cf-4"].solution.drift
    assert set(entry["quantities"]) == set(record["kinds"]) == set(drifts)
    assert set(drifts) == {"energy", "K", "area", "norm", "spatial-momentum", "measure"}
    for name, quantity in entry["quantities"].items():
        assert quantity["class"] == drifts[name].drift_class
        for key in ("initial", "max_abs_error", "scale", "final_error", "slope", "trend_bound"):
            assert quantity[key] == getattr(drifts[name], key)
            assert math.isfinite(quantity[key])
        initial, largest = quantity["initial"], quantity["max_abs_error"]
        relative = pytest.approx(largest / abs(initial), rel=1e-12) if initial else None
        assert quantity["max_rel_error"] == relative
        assert abs(quantity["final_error"]) <= largest
        assert quantity["scale"] > 0


def test_provenance_is_complete(record):
    provenance, run = record["provenance"], record["methods"]["cf-4"]["run"]
    assert all(provenance["versions"][key] for key in ("geomint", "python", "numpy", "numba"))
    assert all(provenance[key] for key in ("cpu", "platform", "date", "scene_toml", "scene_hash"))
    assert (run["step"], run["method"], run["status"]) == (0.02, "cf-4", "success")
    assert run["field_evaluations"] == 4 * run["steps"] == 8000


@pytest.mark.usefixtures("blank_pictures")
def test_the_scene_of_the_provenance_gives_the_same_numbers(record, tmp_path):
    """Also from Python, step by step; the page names the command that it is given."""
    (tmp_path / "again.toml").write_text(record["provenance"]["scene_toml"], encoding="utf-8")
    scene = gi.load_scene(tmp_path / "again.toml").for_drift()
    runs = gi.run_methods(scene, ["cf-4"], False)
    page = write(find_command("drift").report(None, runs, "geomint drift x"), tmp_path)
    assert "geomint drift x" in page.read_text("utf-8")
    again = record_of(tmp_path)
    quantities, others = (r["methods"]["cf-4"]["quantities"] for r in (record, again))
    assert quantities == others
    assert again["provenance"]["scene_hash"] == record["provenance"]["scene_hash"]


def test_the_page_loads_nothing(page):
    """Its images are pictures with words for those who cannot see them."""
    assert page.links
    assert all(link.startswith("data:image/svg+xml;base64,") for link in page.links)
    text = re.sub(r'"data:[^"]*"', "", page.text)
    assert not {words for words in ("http", "@import", "url(") if words in text}
    assert len(page.images) == 8  # motion 4, two kinds beyond round-off
    assert len(page.folded) == 2
    for image in (*page.images, *page.folded):
        svg = base64.b64decode(image["src"].split(",", 1)[1]).decode("utf-8")
        assert image["alt"] and "<svg" in svg  # noqa: PT018
        # Names of namespaces and licences aside, nothing in a picture points outside.
        assert not re.findall(r'(?:href|src)="(?!#)', svg)


def test_the_page_tells_what_was_done(page, record):
    words = ["Classical Chaplygin ball", "cf-4, order 4", "0.02 in t", "2\u202f000", "(scale "]
    words += ["spatial-momentum", "trend ≤", "slope per unit of t", "@media print"]
    words += ["No larger than round-off: K, area", "The window means", "color-scheme: dark"]
    words += [record["provenance"]["scene_hash"]]
    assert [word for word in words if word not in page.text] == []
    for quantity in record["methods"]["cf-4"]["quantities"].values():
        assert f'<span class="kind {quantity["class"]}">' in page.text


def test_the_motion_comes_first(page, report):
    """It is that of the run, by the same method and step."""
    said = " | ".join(image["alt"] for image in page.images)
    paths = "the path of gamma on the unit sphere | the path of the contact point in the plane"
    assert said.startswith(f"{paths} | γ[0], γ[1], γ[2] over time")
    assert page.text.index("The motion") < page.text.index("What was kept")
    assert "k̇ = k × ω,  γ̇ = γ × ω" in page.text
    stretch, plan = report.motion.stretch, report[0].plan
    assert f"The first turns, t = 0 … {stretch.times[-1]:.4g}, by cf-4." in page.text
    assert stretch.joined
    given = {"t_end": 40.0, "method": "cf-4", "step": 0.02, "t_eval": stretch.times}
    run = gi.solve(plan.problem, plan.state, **given)
    np.testing.assert_allclose(stretch.states, run.y, atol=1e-13)


def test_what_is_within_roundoff_is_folded(page, report):
    """Their figures are in the table; one quantity beyond round-off shows its whole kind."""
    shown, folded = by_roundoff(report)
    assert list(shown) == ["energy", "measure"]
    for images, kinds in ((page.images, shown), (page.folded, folded)):
        alts = " ".join(image["alt"] for image in images)
        assert all(name in alts for names in kinds.values() for name in names)
    assert "No larger than round-off: K, area, norm, spatial-momentum</summary>" in page.text
    run = report[0]
    for name in ("K", "area", "norm", "spatial-momentum"):
        assert run.drift[name].within_roundoff
        assert f"{run.drift[name].max_abs_error:.3g}" in page.text
    solution = copy.copy(run.solution)
    lost = dataclasses.replace(run.drift["norm"], max_abs_error=1.0)
    solution.drift = {**run.drift, "norm": lost}
    result = gi.SeveralRuns(report.scene, [dataclasses.replace(run, solution=solution)])
    shown, folded = by_roundoff(result)
    assert shown["constraints"] == ["norm", "spatial-momentum"]
    assert "constraints" not in folded


@pytest.mark.usefixtures("blank_pictures")
def test_titles_are_escaped_and_runs_go_backwards(tmp_path):
    title, own = "<script>alert(1)</script> & co", gi.load_scene("hamiltonized-n3")
    scene = own.changed(title=title, time={"t_end": -50.0}, drift={"quantities": ["energy"]})
    (run,) = gi.drift_report(scene, tmp_path, progress=False)
    assert run.solution.t[-1] == pytest.approx(-50.0, rel=1e-12)
    assert run.drift["energy"].slope is not None
    text = Page(tmp_path).text
    assert "&lt;script&gt;alert(1)&lt;/script&gt; &amp; co" in text
    # Of a problem in τ whose end is in t, drifts are per unit of t.
    assert run.solution.drift_time == record_of(tmp_path)["time"] == "t"
    assert "slope per unit of t" in text
    scene = own.changed(time={"tau_end": 1.0}, drift={"quantities": []})
    gi.drift_report(scene, tmp_path, progress=False)
    assert record_of(tmp_path)["methods"]["gauss-8"]["quantities"] == {}
    assert "No quantity was watched" in Page(tmp_path).text


OTHERS = [name for name in gi.scene_names() if name != "homogeneous-n4"]


@pytest.mark.parametrize(
    ("name", "method"),
    [("homogeneous-n4", "rk-4"), *(pytest.param(n, "", marks=pytest.mark.nightly) for n in OTHERS)],
)
def test_every_scene_has_equations_and_a_picture(name, method):
    """Where equal parameters are integrated in fewer dimensions, all are shown."""
    scene = gi.load_scene(name)
    for problem in scene.model.problems.values():
        assert problem.equations, problem.name
    end = {key: end / 50 for key, end in scene.sections["time"].items() if key.endswith("end")}
    runs = gi.run_methods(scene.changed(time=end).for_drift(), [method or scene.method.name], False)
    motion = runs.motion
    assert motion.stretch.joined
    assert motion.stretch.states.shape == (len(motion.stretch.times), motion.problem.rows)
    assert len(motion.stretch.times) <= 20_000
    assert len(motion_draws(runs)) >= 2


@pytest.mark.parametrize("rows", [(1,), (2,), (1, 1), (9,)])
def test_systems_without_a_sphere(rows, report):
    """Of one number there is no plane; units are those of the problem."""
    pieces = tuple((f"y{i}", count) for i, count in enumerate(rows))
    falling = gi.field(lambda params, t, y, out, work: None)
    problem = gi.Problem("falling", pieces, field=falling, units={"t": "s", "y": "m"})
    times = np.linspace(0.0, 2.0, 5)
    states = np.exp(-np.outer(times, 1.0 + np.arange(sum(rows))))
    stretch = dataclasses.replace(report.motion.stretch, times=times, own=times, states=states)
    motion = dataclasses.replace(report.motion, problem=problem, stretch=stretch)
    draws = motion_draws(gi.SeveralRuns(SCENE, motion=motion))
    assert sum(each.square for each in draws) == (sum(rows) > 1)
    for each in draws:
        axes = Figure().subplots()
        each.draw(axes)
        assert "(m)" in axes.get_ylabel()
        assert axes.get_xlabel() in ("t (s)", "y0[0] (m)", "y0 (m)")
        drawn = axes.get_lines()[0].get_xydata()
        x = times if axes.get_xlabel() == "t (s)" else states[:, 0]
        np.testing.assert_array_equal(drawn, np.c_[x, states[:, int(x is not times)]])
    assert motion_draws(gi.SeveralRuns(SCENE)) == []


def test_numbers_for_readers():
    assert [number(x) for x in (None, math.nan, -1.234e-11, 0.0)] == [
        "—", "not finite", "−1.23e-11", "0",
    ]  # fmt: skip
    for value, error, told, short in (
        (9.599333e-15, 2.3e-20, "(9.599333 ± 0.000023)e-15", "9.6e-15"),
        (-1.0e-20, 1.7e-20, "(−1.0 ± 1.7)e-20", "(−1.0 ± 1.7)e-20"),
        (1.0, 1e-5, "(1.000000 ± 0.000010)e+00", "1"),
        (1.0, 0.5, "(1.00 ± 0.50)e+00", "(1.00 ± 0.50)e+00"),
        (1.0, 0.0, "(1.00 ± 0.00)e+00", "(1.00 ± 0.00)e+00"),
        (0.0, 0.0, "0", "0"),
        (None, None, "—", "—"),
    ):
        assert (with_error(value, error), short_slope(value, error)) == (told, short)
    for seconds, told in ((0.0, "–"), (1.25e-6, "1.25\u202fµs"), (0.034, "34\u202fms"),
                          (3e-9, "3\u202fns"), (5.6, "5.6\u202fs")):  # fmt: skip
        assert duration(seconds) == told
