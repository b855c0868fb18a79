"""Scans of scenes: from Python and from the command line, with what is in the folder."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.plan import plan_scan
from geomint.plots.scan_plot import MOST_PANELS, Chart, scan_figure

SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-hamiltonized", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [0.8, 1.0, -1.5375]},
    "time": {"tau_end": 10.0},
    "integrate": {"step": 0.125},
}
SHOW = ["drift:energy", "frequency:gamma[0]", "exponent"]


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "scan.csv").open() as stream:
        return list(csv.DictReader(stream))


def test_over_one_parameter(tmp_path: Path) -> None:
    """Each member is the scene with that value, to the same bits."""
    many = gi.scan_report(SCENE, tmp_path / "out", paper=True, vary={"D": "2:6:5"}, show=SHOW)
    rows = rows_of(tmp_path / "out")
    assert [float(row["D"]) for row in rows] == [2.0, 3.0, 4.0, 5.0, 6.0]
    for k, D in enumerate([2.0, 3.0, 4.0, 5.0, 6.0]):
        scene = gi.Scene("one", **SCENE).changed(system={"D": D})
        run = gi.solve(scene.problem, scene.state, tau_end=10.0, step=0.125, save_every=1)
        assert np.array_equal(many.final[k], run.y[-1])
        energy = np.array([gi.value(scene.problem, "energy", y) for y in run.y])
        assert float(rows[k]["drift:energy"]) == np.abs(energy - energy[0]).max()
        found = gi.lyapunov(scene.problem, scene.state, tau_end=10.0, step=0.125, count=1)
        assert float(rows[k]["exponent"]) == found.exponents[0]
        assert float(rows[k]["exponent-error"]) == found.errors[0]
    record = json.loads((tmp_path / "out" / "scan.json").read_text("utf-8"))
    assert record["members"] == 5
    assert record["statuses"] == {"success": 5}
    assert list(record["readings"]) == [*SHOW, "exponent-error", "chaotic"]
    assert record["readings"]["exponent"]["known"] == 5
    page = (tmp_path / "out" / "scan.html").read_text("utf-8")
    assert record["verdicts"] == {"regular": [], "undecided": [0, 1, 2, 3, 4], "chaotic": []}
    words = ("Largest exponents: 0 above 0, 0 compatible with 0, 5 undecided", "exponent-error")
    for word in ("5 values of D from 2 to 6", "gauss-8", "frequency:gamma[0]", "Over D", *words):
        assert word in page


@gi.field
def wells(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A pendulum, turned by a force of period 2π."""
    out[0] = y[1]
    out[1] = -gi.sin(y[0]) + params[0] * gi.cos(t)


def test_exponents_are_told_from_zero() -> None:
    """The reading is the verdict of `geomint.lyapunov`, member by member, of one run for all three."""
    problem = gi.Problem("wells", (("q", 1), ("v", 1)), params=[0.0], field=wells)
    forced = [dataclasses.replace(problem, params=[a]) for a in (0.0, 1.0)]
    words = ["exponent", "exponent-error", "chaotic"]
    given: dict[str, Any] = {"t_end": 1000.0, "step": 0.2, "method": "rk-4"}
    many = gi.solve_ensemble(forced, [0.5, 0.0], **given, readings=words)
    for k, verdict in enumerate(("regular", "chaotic")):
        alone = gi.lyapunov(forced[k], [0.5, 0.0], count=1, progress=False, **given)
        assert alone.verdict == verdict
        assert [many.readings[word][k] for word in words] == [
            alone.exponents[0],
            alone.errors[0],
            float(verdict == "chaotic"),
        ]


def test_over_a_list_and_a_component(tmp_path: Path) -> None:
    """p is not tangent for any of these values: told, once, and on the page."""
    vary = {"initial.p[2]": [0.5, -0.5, 1.0], "system.a[1]": "1:1.2:2"}
    told = r"6 of 6 states were changed; with initial.p\[2\] = 0.5.*the state uses the tangent part"
    with pytest.warns(gi.GeomintWarning, match=told) as heard:
        many = gi.scan_report(SCENE, tmp_path / "out", vary=vary, show=["final:gamma[0]"])
    assert len(heard) == 1
    assert "6 of 6 states were changed" in (tmp_path / "out" / "scan.html").read_text("utf-8")
    rows = rows_of(tmp_path / "out")
    pairs = [(float(row["initial.p[2]"]), float(row["system.a[1]"])) for row in rows]
    assert pairs == [(0.5, 1.0), (0.5, 1.2), (-0.5, 1.0), (-0.5, 1.2), (1.0, 1.0), (1.0, 1.2)]
    scene = gi.Scene("one", **SCENE).changed(
        system={"a": [0.8, 1.2, 1.5]}, initial={"p": [0.8, 1.0, -0.5]}
    )
    run = gi.solve(scene.problem, scene.state, tau_end=10.0, step=0.125)
    assert np.array_equal(many.final[3], run.y[-1])
    assert "Map" in (tmp_path / "out" / "scan.html").read_text("utf-8")


@pytest.mark.usefixtures("short_chains", "blank_pictures")
def test_draws(tmp_path: Path) -> None:
    """Random states on the scene's level of energy, the same in every run; each value has its own."""
    many = gi.scan_report(SCENE, tmp_path / "out", draws=4, vary={"D": [2.0, 4.0]}, seed=3)
    rows = rows_of(tmp_path / "out")
    assert [row["draw"] for row in rows] == ["0", "1", "2", "3"] * 2
    assert len({tuple(y) for y in many.states}) == 8
    for k, y in enumerate(many.states):
        problem = many.problems[k]
        scene = gi.Scene("one", **SCENE).changed(system={"D": [2.0, 4.0][k // 4]})
        energy = gi.value(scene.problem, "energy", scene.state)
        assert gi.value(problem, "energy", y) == pytest.approx(energy, rel=1e-9)
    again = plan_scan(gi.Scene("one", **SCENE), draws=4, vary={"D": [2.0, 4.0]}, seed=3)
    assert np.array_equal(again.states, many.states)
    other = plan_scan(gi.Scene("one", **SCENE), draws=4, vary={"D": [2.0, 4.0]}, seed=4)
    assert not np.array_equal(other.states, many.states)


@pytest.mark.usefixtures("blank_pictures")
def test_the_section_of_a_scene_says_it_all(tmp_path: Path) -> None:
    section = {"vary": {"D": "2:6:3"}, "show": ["final:gamma[1]"]}
    many = gi.scan_report({**SCENE, "ensemble": section}, tmp_path / "out")
    assert list(many.readings) == ["final:gamma[1]"]
    other = gi.scan_report({**SCENE, "ensemble": section}, tmp_path / "out", show=["lowest:K"])
    assert list(other.readings) == ["lowest:K"]


def fixed_directions(multipliers: bool, show: str) -> dict[str, Any]:
    """Return a scene of a key that is a whole number, r."""
    system = {"name": "veselova-lr", "a": [1.0, 1.2, 1.5, 1.9], "multipliers": multipliers}
    w = [0.3, -0.2, 0.5, 0.0, 0.0, 0.0]
    scene = {"system": system, "initial": {"w": w}, "time": {"t_end": 0.5}, "save": {"every": 1}}
    return {**scene, "ensemble": {"vary": {"r": "1:3:3"}, "show": [show]}}


def test_over_a_whole_number() -> None:
    plan = plan_scan(gi.Scene("r", **fixed_directions(True, "drift:energy")))
    for r, problem, state in zip((1, 2, 3), plan.problems, plan.states, strict=True):
        scene = fixed_directions(True, "drift:energy")
        scene["system"]["r"] = r
        alone = gi.Scene("r", **scene).model
        assert np.array_equal(state, alone.states[plan.route.name])
        assert np.array_equal(problem.params, alone.problems[plan.route.name].params)


def test_members_with_other_pieces_are_refused() -> None:
    with pytest.raises(gi.SceneError, match="r = 2: the state has other pieces than with r = 1"):
        plan_scan(gi.Scene("r", **fixed_directions(False, "drift:energy")))


@pytest.mark.filterwarnings("ignore:.*states were changed:geomint.GeomintWarning")
def test_of_members_that_fail_page_and_json_tell(tmp_path: Path) -> None:
    """A step much too long for one value of a parameter, which hurts no other."""
    scene = {**SCENE, "integrate": {"step": 1.5}}
    vary = {"initial.p[0]": [0.1, 400.0], "initial.p[1]": [0.1]}
    many = gi.scan_report(scene, tmp_path / "out", vary=vary)
    assert list(many.status) == ["success", "failed"]
    record = json.loads((tmp_path / "out" / "scan.json").read_text("utf-8"))
    assert record["failures"] == 1
    assert record["failed"][0]["member"] == 1
    assert record["failed"][0]["initial.p[0]"] == 400.0
    page = (tmp_path / "out" / "scan.html").read_text("utf-8")
    assert "1 of 2" in page
    assert rows_of(tmp_path / "out")[1]["drift:energy"] == "nan"


@pytest.mark.usefixtures("blank_pictures")
def test_command(tmp_path: Path) -> None:
    given = ["scan", "hamiltonized-n3", "--tau-end", "5", "--vary", "D=2:6:3"]
    out = tmp_path / "out"
    result = CliRunner().invoke(main, [*given, "--out", str(out), "--show", "exponent,final:K"])
    assert result.exit_code == 0, result.output
    assert "3 members (D: 3 values): 3 success" in result.output
    assert "exponent" in result.output
    quiet = CliRunner().invoke(main, [*given, "--out", str(out), "--quiet"])
    assert quiet.stdout == ""


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.filterwarnings("always")
def test_warnings_are_lines_of_the_command(tmp_path: Path) -> None:
    given = ["hamiltonized-n3", "--tau-end", "2", "--vary", "D=4", "--show", "mean:K"]
    result = CliRunner().invoke(main, ["scan", *given, "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "\ngeomint: warning: 1 of 1 members have fewer" in result.stderr
    assert ".py" not in result.stderr


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "nothing varies"),
        ({"vary": {"E": "1:2:3"}}, "no such key"),
        ({"vary": {"DD": "1:2:3"}}, "'D'"),
        ({"vary": {"D": "1:2"}}, "A:B:N"),
        ({"vary": {"D": "1:2:0"}}, "A:B:N"),
        ({"vary": {"D": "0:2:3:log"}}, "A:B:N"),
        ({"vary": {"D": "1,x"}}, "A:B:N"),
        ({"vary": {"D": []}}, "A:B:N"),
        ({"vary": {"gamma": "0:1:3"}}, r"gamma\[0\]"),
        ({"vary": {"gamma[3]": "0:1:3"}}, "from 0 to 2"),
        ({"vary": {"D[0]": "0:1:3"}}, "no list"),
        ({"vary": {"D": "1:2:3", "system.D": "1:2:3"}}, "once"),
        ({"vary": {"D": "1:2:3", "a[0]": "1:2:3", "a[1]": "1:2:3"}}, "at most 2"),
        ({"vary": {"D": [2.0, -1.0]}}, "D = -1"),
        ({"vary": {"D": "2:3:2"}, "show": ["drift:enrgy"]}, "energy"),
        ({"vary": {"D": "2:3:2"}, "show": []}, "show"),
        ({"draws": 0}, "draws"),
        ({"vary": {"D": "2:3:2"}, "keep": ["K"]}, r"keep = \['K'\].*--draws"),
        ({"vary": {"D": "2:3:2"}, "temperature": 0.1}, "temperature.*--draws"),
        ({"vary": {"D": "2:3:2"}, "seed": 1}, "seed = 1.*--draws"),
        ({"draws": 3, "keep": ["enrgy"]}, "energy"),
    ],
)
def test_what_makes_no_sense(given: dict[str, Any], said: str, tmp_path: Path) -> None:
    with pytest.raises((gi.SceneError, gi.DomainError, gi.FormError), match=said):
        gi.scan_report(SCENE, tmp_path / "out", **given)
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("short_chains")
def test_where_nothing_is_asked_for_the_first_invariant_is_shown() -> None:
    assert list(plan_scan(gi.Scene("one", **SCENE), draws=2).readings) == ["drift:energy"]


def chart(keys: int, draws: int = 1) -> Chart:
    sizes = [3, 4][:keys]
    values = [np.linspace(1.0, 2.0, size) for size in sizes]
    shape = (*sizes, draws)
    wide = np.geomspace(1e-9, 1.0, int(np.prod(shape))).reshape(shape)
    wide.flat[-1] = np.nan
    readings = {
        "wide": wide.ravel(),
        "none": np.full(wide.size, np.nan),
        "flat": np.ones(wide.size),
    }
    return Chart(["x", "y"][:keys], values, readings)


@pytest.mark.parametrize("keys", [0, 1, 2])
@pytest.mark.parametrize("draws", [1, 5])
def test_pictures(keys: int, draws: int) -> None:
    """Labels, logarithmic axes where numbers are far apart, words where there is no number."""
    figure = scan_figure(chart(keys, draws))
    panels = [a for a in figure.axes if a.get_title(loc="left")]
    assert [a.get_title(loc="left") for a in panels] == ["wide", "none", "flat"]
    figure.canvas.draw()
    if keys == 1:
        assert panels[0].get_yscale() == "log"
        assert panels[-1].get_xlabel() == "x"
    if keys == 0 and draws > 1:
        assert panels[0].get_xscale() == "log"
    if keys == 2:
        assert panels[0].get_xlabel() == "y"
        assert panels[0].get_ylabel() == "x"


def test_a_picture_has_room_for_some_readings_only() -> None:
    many = Chart([], [], {str(k): np.arange(3.0) for k in range(MOST_PANELS + 3)})
    assert len(scan_figure(many).axes) == MOST_PANELS
