"""Sections of scenes: from Python and from the command line, with what lies in the folder."""

from __future__ import annotations

import base64
import csv
import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib as mpl
import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import find_command, main
from geomint.reports.files import write

SECTION = find_command("section")
QUIET = SimpleNamespace(progress=False)
SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 2.0},
    "integrate": {"step": 0.5},
    "events": {"equator": {"what": "gamma[2]", "direction": "up"}},
    "section": {"points": 12, "motions": 3},
}


def plan_section(scene: gi.Scene, **keys: Any) -> Any:
    return SECTION.plan(SECTION.scene(scene, keys))


@pytest.mark.usefixtures("blank_pictures")
def test_report(tmp_path: Path) -> None:
    """Every file, and what is in it."""
    section = gi.section_report(SCENE, tmp_path / "out", paper=True)
    record = json.loads((tmp_path / "out" / "section.json").read_text("utf-8"))
    assert (record["points"], len(section), record["complete"]) == (36, 36, True)
    assert [m["points"] for m in record["motions"]] == [12, 12, 12]
    assert [*record["event"].values()] == ["equator", "gamma[2]", "up", 0.0]
    for kept in record["kept"].values():
        assert kept["deviation"] < 1e-13 * max(1.0, kept["size"])
    rows = list(csv.reader((tmp_path / "out" / "section.csv").read_text("utf-8").splitlines()))
    assert len(rows) == 37
    np.testing.assert_array_equal(np.array(rows[1:], float)[:, 3:], section.y)
    page = (tmp_path / "out" / "section.html").read_text("utf-8")
    page += (tmp_path / "out" / "section-caption.tex").read_text("utf-8")
    told = "gauss-8, order 16, step 0.5 in t~", "p)[2], a colour a motion: 36 points of 3 motions"
    for word in (*told, "gamma[2] rises through 0", "energy"):
        assert word in page
    energies = section.values("energy")
    np.testing.assert_allclose(energies, energies[0], rtol=1e-11)


def test_pictures_do_not_depend_on_the_users_settings(tmp_path: Path) -> None:
    """Page and files show the same; a file has a ground of its own, as viewers may be dark."""
    plan = plan_section(gi.Scene(**SCENE))
    section, made = SECTION.run(plan, QUIET), []
    theirs = {"text.usetex": True, "savefig.format": "pdf", "savefig.bbox": "tight"}
    theirs |= {"svg.fonttype": "none", "path.simplify": False, "figure.facecolor": "red"}
    for settings in ({}, theirs):
        with mpl.rc_context(settings):
            page = write(SECTION.report(plan, section, None), tmp_path).read_text("utf-8")
        files = [(tmp_path / f"section.{ending}").read_bytes() for ending in ("png", "svg")]
        shown = base64.b64decode(re.search('src="data:image/svg[^,]*,([^"]*)', page)[1])
        made.append((*files, shown))
    assert made[0] == made[1]
    png, svg, shown = made[0]
    assert len(png) > 10_000
    ground = b'<rect width="100%" height="100%" fill="#ffffff"/>'
    assert ground not in shown
    assert svg.replace(ground, b"", 1) == shown


def test_the_scene_says_as_much_as_the_arguments() -> None:
    """Events decide what is computed, and so the hash; sections do not."""
    scene = gi.Scene(**SCENE)
    keys = {"event": "gamma[1]", "direction": "down", "level": 0.25, "points": 4}
    given, written = plan_section(scene, **keys), plan_section(scene.changed(section=keys))
    assert given.event[1] == written.event[1] == gi.Event("gamma[1]", "down", level=0.25)
    assert given.scene.content == written.scene.content
    assert gi.Scene(**given.scene.sections).content == given.scene.content
    assert scene.hash == gi.Scene(**{**SCENE, "section": {"points": 5}}).hash
    assert scene.hash != gi.Scene(**{**SCENE, "events": {}}).hash


def test_what_is_integrated() -> None:
    """The cheapest representation that contains what is named; in the scene's own time."""
    ball = gi.load_scene("ball-3d")
    assert "g" in ball.problem.slices
    cheap = plan_section(ball, event="gamma[2]")
    assert set(cheap.route.problem.slices) == {"k", "gamma"}
    np.testing.assert_array_equal(cheap.states[0][3:], [0.6, 0.0, 0.8])
    whole = plan_section(ball, event="gamma[2]", axes=["g[0]", "k[1]"])
    assert whole.route.problem is ball.problem
    hamiltonized = plan_section(gi.load_scene("hamiltonized-n3"), event="gamma[2]")
    assert hamiltonized.route.problem.time == "tau"


def test_the_exact_flow() -> None:
    """Without steps, at the points of a run with steps; refused where there is none."""
    asked = {"section": {"event": "gamma[2]", "points": 15}, "time": {"tau_end": 12.0}}
    asked |= {"observe": {"quantities": []}, "events": {"equator": {"what": "gamma[2]"}}}
    scene = gi.load_scene("hamiltonized-n3").changed(**asked)
    given = scene.changed(integrate={"exact": True})
    exact, steps = (SECTION.run(plan_section(s), QUIET) for s in (given, scene))
    assert (exact.steps, exact.method.name) == (0, "exact")
    np.testing.assert_allclose(exact.y, steps.y, rtol=0, atol=1e-9)
    run = gi.make_plan(given).solve(progress=False)
    met = run.events["equator"]
    assert (run.steps, 5 < len(met) <= 15) == (0, True)
    np.testing.assert_allclose(met.y, exact.y[: len(met)], rtol=0, atol=1e-9)
    other = gi.load_scene("control-momentum-n4").changed(integrate={"exact": True})
    with pytest.raises(gi.FormError, match="no exact flow"):
        plan_section(other, event="gamma[2]")


@pytest.mark.parametrize("name", ["sphere-n3", "ball-3d", "veselova-classical", "neumann-n3"])
def test_other_motions_are_on_the_level(name: str) -> None:
    """Admissible, of the same energy, each another, the same for the same seed."""
    scene = gi.load_scene(name)
    piece = "q" if name == "neumann-n3" else "gamma"
    plan = plan_section(scene, event=f"{piece}[2]", motions=5, seed=3)
    problem = plan.route.problem
    energies = [gi.value(problem, "energy", y) for y in plan.states]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-10)
    for y in plan.states:
        np.testing.assert_allclose(problem.canonical(y), y, rtol=0, atol=1e-10)
        for constraint in problem.constraints:
            assert abs(gi.value(problem, constraint, y)) < 1e-9
    assert len(np.unique(plan.states, axis=0)) == 5
    again = plan_section(scene, event=f"{piece}[2]", motions=5, seed=3)
    np.testing.assert_array_equal(again.states, plan.states)
    assert (plan_section(scene, event=f"{piece}[2]", motions=5, seed=4).states != plan.states).any()


@pytest.mark.usefixtures("blank_pictures")
def test_not_all_points(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A motion that does not cross while it is looked at: what there is, and an exit code."""

    def short(problem: gi.Problem, states: Any, events: Any, *_: Any, **more: Any) -> gi.Section:
        return gi.poincare_section(problem, states, events, 12, step=0.5, end=9.0)

    monkeypatch.setitem(SECTION.run.__globals__, "poincare_section", short)
    scene = tmp_path / "s.toml"
    scene.write_text(gi.Scene(**SCENE).toml(), "utf-8")
    given = ["section", str(scene), "--level", "2.0", "--out", str(tmp_path / "o"), "--quiet"]
    result = CliRunner().invoke(main, [*given, "--paper", "--motions", "1"])
    assert result.exit_code == 2
    assert "not all points" in result.stderr
    page = (tmp_path / "o" / "section.html").read_text("utf-8")
    assert [
        words for words in ("Not all points", "0 points of one motion") if words not in page
    ] == []
    assert json.loads((tmp_path / "o" / "section.json").read_text("utf-8"))["points"] == 0
    assert (tmp_path / "o" / "section-paper.tex").exists()


BALL = {**SCENE, "system": {**SCENE["system"], "name": "chaplygin-ball"}}
TWO = {"a": {"what": "gamma[0]"}, "b": {"what": "gamma[1]"}}
CLASSICAL = gi.load_scene("ball-3d").changed(integrate={"representation": "classical"})


@pytest.mark.parametrize(
    ("scene", "keys", "error", "said"),
    [
        (BALL, {"event": "gamma[3]"}, gi.SceneError, r"gamma\[3\].*no such component"),
        (BALL, {"axes": ["gamma[0]", "q"]}, gi.SceneError, r"axes\[1\]"),
        (BALL, {"keep": ["heat"]}, gi.SceneError, r"keep\[0\]"),
        (BALL, {"colour": 1}, gi.ArgumentError, "colour"),
        ({**SCENE, "events": {}}, {}, gi.SceneError, "a component such as"),
        ({**SCENE, "events": TWO}, {}, gi.SceneError, "one of a, b"),
        ({**SCENE, "events": {"a": {"what": "heat"}}}, {}, gi.SceneError, r"\[events.a\]"),
        (CLASSICAL, {"event": "gamma[2]", "axes": ["g[0]", "k[0]"]}, gi.FormError,
         r"classical: has no g\[0\]"),
    ],
)  # fmt: skip
def test_wrong_input(scene: Any, keys: dict[str, Any], error: type, said: str) -> None:
    with pytest.raises(error, match=said):
        plan_section(gi.load_scene(scene), **keys)


def test_events_of_a_run(tmp_path: Path) -> None:
    """`geomint run` looks for them and says so; a drift report does not."""
    scene = gi.Scene(**{**SCENE, "time": {"t_end": 100.0}})
    plan = gi.make_plan(scene)
    assert "equator" in next(c.value for c in plan.choices if c.what == "events")
    run = gi.run_scene(scene)
    equator = {"equator": gi.Event("gamma[2]", "up")}
    alone = gi.solve(scene.problem, scene.state, t_end=100.0, step=0.5, events=equator)
    assert run.events == alone.events
    assert len(run.events["equator"]) > 10
    assert gi.make_plan(scene.for_drift(), "drift").events is None
    # States at events are those of what is asked for: no reduction takes its place.
    system = {"name": "chaplygin-ball", "a": [0.7, 0.9, 1.2, 1.5], "D": 4.0}
    initial = {"gamma": [0.5, -0.5, 0.5, 0.5], "p": [0.7, -0.3, 0.4, -1.4]}
    given = {"time": {"t_end": 5.0}, "observe": {"quantities": ["energy", "K"]}}
    plain = gi.Scene(system=system, initial=initial, **given)
    watched = plain.changed(events={"level": {"what": "gamma[0]"}})
    lifts = [gi.make_plan(s).route.lift is None for s in (plain, watched)]
    assert lifts == [False, True]
    assert gi.make_plan(watched).problem is plain.problem
    ended = gi.run_scene(scene.changed(events={"equator": {"what": "gamma[2]", "terminal": 2}}))
    assert len(ended.events["equator"]) == 2
    path = tmp_path / "s.toml"
    path.write_text(scene.toml(), "utf-8")
    told = CliRunner().invoke(main, ["run", str(path), "--out", str(tmp_path / "r.nc")])
    assert f"events: equator {len(run.events['equator'])}" in told.stdout
    assert len(gi.load(tmp_path / "r.nc").events["equator"]) == len(run.events["equator"])
