"""Scans of scenes: from Python and from the command line, with what is in the folder."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure

import geomint as gi
from geomint.cli import find_command, main
from geomint.reports.files import write

SCAN = find_command("scan")
QUIET = SimpleNamespace(progress=False)
SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-hamiltonized", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [0.8, 1.0, -1.5375]},
    "time": {"tau_end": 10.0},
    "integrate": {"method": "rk-4", "step": 0.125},
}
SHOW = ["drift:energy", "frequency:gamma[0]", "exponent"]


def plan_scan(scene: gi.Scene, **keys: Any) -> Any:
    return SCAN.plan(SCAN.scene(scene, keys))


def rows_of(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "scan.csv").read_text("utf-8").splitlines()))


@pytest.mark.usefixtures("blank_pictures")
def test_over_one_parameter(tmp_path: Path) -> None:
    """Each member is the scene with that value, to the same bits."""
    many = gi.scan_report(SCENE, tmp_path / "out", paper=True, vary={"D": "2:6:3"}, show=SHOW)
    rows = rows_of(tmp_path / "out")
    assert [float(row["D"]) for row in rows] == [2.0, 4.0, 6.0]
    for k, D in enumerate([2.0, 4.0, 6.0]):
        scene = gi.Scene("one", **SCENE).changed(system={"D": D})
        given = {"tau_end": 10.0, "step": 0.125, "method": "rk-4"}
        run = gi.solve(scene.problem, scene.state, save_every=1, **given)
        assert np.array_equal(many.final[k], run.y[-1])
        energy = np.array([gi.value(scene.problem, "energy", y) for y in run.y])
        assert float(rows[k]["drift:energy"]) == np.abs(energy - energy[0]).max()
        found = gi.lyapunov(scene.problem, scene.state, count=1, **given)
        assert float(rows[k]["exponent"]) == found.exponents[0]
        assert float(rows[k]["exponent-error"]) == found.errors[0]
    record = json.loads((tmp_path / "out" / "scan.json").read_text("utf-8"))
    assert (record["members"], record["statuses"]) == (3, {"success": 3})
    assert list(record["readings"]) == [*SHOW, "exponent-error", "chaotic"]
    assert record["readings"]["exponent"]["known"] == 3
    page = (tmp_path / "out" / "scan.html").read_text("utf-8")
    assert record["verdicts"] == {"regular": [], "undecided": [0, 1, 2], "chaotic": []}
    words = ("Largest exponents: 0 above 0, 0 compatible with 0, 3 undecided", "exponent-error")
    for word in ("3 values of D from 2 to 6", "rk-4", "frequency:gamma[0]", "Over D", *words):
        assert word in page


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
    changes = {"system": {"a": [0.8, 1.2, 1.5]}, "initial": {"p": [0.8, 1.0, -0.5]}}
    scene = gi.Scene("one", **SCENE).changed(**changes)
    run = gi.solve(scene.problem, scene.state, tau_end=10.0, step=0.125, method="rk-4")
    assert np.array_equal(many.final[3], run.y[-1])
    assert "Map" in (tmp_path / "out" / "scan.html").read_text("utf-8")


@pytest.mark.usefixtures("short_chains", "blank_pictures")
def test_draws(tmp_path: Path) -> None:
    """Random states on the scene's level of energy, the same in every run; each value has its own."""
    given = {"draws": 4, "vary": {"D": [2.0, 4.0]}}
    many = gi.scan_report(SCENE, tmp_path / "out", seed=3, **given)
    assert [row["draw"] for row in rows_of(tmp_path / "out")] == ["0", "1", "2", "3"] * 2
    assert len({tuple(y) for y in many.states}) == 8
    for k, y in enumerate(many.states):
        problem = many.problems[k]
        scene = gi.Scene("one", **SCENE).changed(system={"D": [2.0, 4.0][k // 4]})
        energy = gi.value(scene.problem, "energy", scene.state)
        assert gi.value(problem, "energy", y) == pytest.approx(energy, rel=1e-9)
    for seed in (3, 4):
        again = plan_scan(gi.Scene("one", **SCENE), seed=seed, **given)
        assert np.array_equal(again.states, many.states) == (seed == 3)


@pytest.mark.usefixtures("short_chains")
def test_the_section_of_a_scene_says_it_all() -> None:
    """Arguments say otherwise; where nothing is asked for the first invariant is shown."""
    section = {"vary": {"D": "2:6:3"}, "show": ["final:gamma[1]"]}
    scene = gi.Scene("one", **SCENE, ensemble=section)
    assert list(plan_scan(scene).readings) == ["final:gamma[1]"]
    assert plan_scan(scene).variations[0].values.tolist() == [2.0, 4.0, 6.0]
    assert list(plan_scan(scene, show=["lowest:K"]).readings) == ["lowest:K"]
    assert list(plan_scan(gi.Scene("one", **SCENE), draws=2).readings) == ["drift:energy"]


def fixed_directions(multipliers: bool, show: str) -> dict[str, Any]:
    """Return a scene of a key that is a whole number, r."""
    system = {"name": "veselova-lr", "a": [1.0, 1.2, 1.5, 1.9], "multipliers": multipliers}
    w = [0.3, -0.2, 0.5, 0.0, 0.0, 0.0]
    scene = {"system": system, "initial": {"w": w}, "time": {"t_end": 0.5}, "save": {"every": 1}}
    return {**scene, "ensemble": {"vary": {"r": "1:3:3"}, "show": [show]}}


def test_over_a_whole_number() -> None:
    """Members with other pieces are refused."""
    scene = fixed_directions(True, "drift:energy")
    plan = plan_scan(gi.Scene("r", **scene))
    for r, problem, state in zip((1, 2, 3), plan.problems, plan.states, strict=True):
        scene["system"]["r"] = r
        alone = gi.Scene("r", **scene).model
        assert np.array_equal(state, alone.states[plan.route.name])
        assert np.array_equal(problem.params, alone.problems[plan.route.name].params)
    with pytest.raises(gi.SceneError, match="r = 2: the state has other pieces than with r = 1"):
        plan_scan(gi.Scene("r", **fixed_directions(False, "drift:energy")))


@pytest.mark.filterwarnings("ignore:.*states were changed:geomint.GeomintWarning")
def test_of_members_that_fail_page_and_json_tell(tmp_path: Path) -> None:
    """A step much too long for one value of a parameter, which hurts no other."""
    scene = {**SCENE, "integrate": {"method": "rk-4", "step": 0.3}}
    vary = {"initial.p[0]": [0.1, 400.0], "initial.p[1]": [0.1]}
    many = gi.scan_report(scene, tmp_path / "out", vary=vary)
    assert list(many.status) == ["success", "failed"]
    record = json.loads((tmp_path / "out" / "scan.json").read_text("utf-8"))
    (failed,) = record["failed"]
    assert (record["failures"], failed["member"], failed["initial.p[0]"]) == (1, 1, 400.0)
    page = (tmp_path / "out" / "scan.html").read_text("utf-8")
    assert "1 of 2" in page
    assert rows_of(tmp_path / "out")[1]["drift:energy"] == "nan"


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.filterwarnings("always")
def test_command(tmp_path: Path) -> None:
    """Warnings are lines of it."""
    given = ["scan", "hamiltonized-n3", "--tau-end", "2", "--vary", "D=2:6:3", "--method", "rk-4"]
    given += ["--out", str(tmp_path), "--show", "exponent,mean:K", "--step", "0.25"]
    result = CliRunner().invoke(main, given)
    assert result.exit_code == 0, result.output
    assert "3 members (D: 3 values): 3 success" in result.output
    assert "exponent" in result.output
    assert "\ngeomint: warning: 3 of 3 members have fewer" in result.stderr
    assert ".py" not in result.stderr
    assert CliRunner().invoke(main, [*given, "--quiet"]).stdout == ""


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "nothing varies"),
        ({"vary": {"E": "1:2:3"}}, "no such key"),
        ({"vary": {"DD": "1:2:3"}}, "'D'"),
        *(({"vary": {"D": no}}, "A:B:N") for no in ("1:2", "1:2:0", "0:2:3:log", "1,x", [])),
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


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """The figure of a scan whose members have these readings."""
    found: list[Figure] = []

    def note(figure: Figure, to: Any, **_: Any) -> None:
        found.append(figure)
        if not hasattr(to, "write"):
            Path(to).touch()

    def figure(given: dict[str, Any], readings: dict[str, Any]) -> Figure:
        plan = plan_scan(gi.Scene("one", **SCENE).changed(time={"tau_end": 0.5}), **given)
        many = SCAN.run(plan, QUIET)
        many.found.readings.clear()
        many.found.readings.update({name: make(len(many)) for name, make in readings.items()})
        write(SCAN.report(plan, many, None), tmp_path)
        return found[-1]

    monkeypatch.setattr(Figure, "savefig", note)
    return figure


D, A = {"D": [2.0, 8.0, 4.0]}, {"a[1]": [1.1, 1.0, 1.2, 1.15]}


@pytest.mark.usefixtures("short_chains")
@pytest.mark.parametrize(("vary", "draws"), [({}, 5), (D, None), ({**D, **A}, 5)])
def test_pictures(drawn: Any, vary: dict[str, Any], draws: int | None) -> None:
    """Labels, logarithmic axes where numbers are far apart, words where there is no number."""
    shape = (*[3, 4][: len(vary)], draws or 1)
    wide = np.geomspace(1e-9, 1.0, int(np.prod(shape)))
    wide[-1] = np.nan
    readings = {"wide": lambda n: wide, "none": lambda n: np.full(n, np.nan), "flat": np.ones}
    figure = drawn({"vary": vary, "draws": draws}, readings)
    panels = [a for a in figure.axes if a.get_title(loc="left")]
    assert [a.get_title(loc="left") for a in panels] == list(readings)
    words = [[t.get_text() for t in a.texts] for a in panels]
    assert words == [[], ["no member has a value"], []]
    middle = np.ma.filled(np.ma.median(np.ma.masked_invalid(wide.reshape(shape)), -1), np.nan)
    first = panels[0]
    if not vary:
        assert first.get_xscale() == "log"
        shown = np.c_[wide[:-1], [0.25, 0.5, 0.75, 1.0]]
        np.testing.assert_allclose(first.lines[0].get_xydata(), shown)
    elif len(vary) == 1:
        assert (first.get_yscale(), panels[-1].get_xlabel()) == ("log", "D")
        shown = np.c_[vary["D"], middle]
        np.testing.assert_allclose(first.lines[-1].get_xydata(), shown)
    else:
        assert (first.get_xlabel(), first.get_ylabel()) == ("a[1]", "D")
        cells = first.collections[0].get_array()
        np.testing.assert_allclose(np.ma.filled(cells, np.nan), middle[[0, 2, 1]][:, [1, 0, 3, 2]])


def test_a_picture_has_room_for_some_readings_only(drawn: Any) -> None:
    """Exponents have bars, not panels, for their errors."""
    readings = {f"exponent{k}": np.ones for k in range(11)}
    assert len(drawn({"vary": {"D": "2:4:2"}}, readings).axes) == 8
    readings = {"exponent": np.ones, "exponent-error": lambda n: np.full(n, 0.25)}
    (axes,) = drawn({"vary": {"D": "2:4:2"}}, readings).axes
    assert axes.get_ylabel() == "per unit of τ"
    (bars,) = axes.containers
    drawn_bars = [x.tolist() for x in bars[2][0].get_segments()]
    assert drawn_bars == [[[x, 0.75], [x, 1.25]] for x in (2.0, 4.0)]
