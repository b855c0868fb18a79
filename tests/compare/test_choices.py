"""What a comparison takes from a scene: representation, step and options, and what it refuses."""

from __future__ import annotations

import json
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.compare import runs as compare_module
from geomint.compare.runs import compare

SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 2.0},
    "compare": {"reference": "exact"},
}
MODEL = gi.Scene(**SCENE).model
END = {"t_end": 2.0}
RUN = {"repeats": 1, "observe": False, "reference": "exact"}


@pytest.fixture
def called(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Record what `solve` is called with, and call it."""
    found: list[dict[str, Any]] = []
    solve = compare_module.solve

    def noting(problem: gi.Problem, y0: Any, **given: Any) -> gi.Solution:
        found.append({"problem": problem, **given})
        return solve(problem, y0, **given)

    monkeypatch.setattr(compare_module, "solve", noting)
    return found


def run(methods: list[Any], **given: Any) -> list[Any]:
    return compare(MODEL, END, methods, **{**RUN, **given}).points


@pytest.fixture
def from_scene(tmp_path: Path, blank_pictures: None) -> Any:
    """Return the points of the command."""

    def points(methods: str, **integrate: Any) -> list[Any]:
        (tmp_path / "s.toml").write_text(gi.Scene(**SCENE, integrate=integrate).toml(), "utf-8")
        given = ["compare", str(tmp_path / "s.toml"), "--methods", methods, "--repeats", "1"]
        result = CliRunner().invoke(main, [*given, "--out", str(tmp_path / "out")])
        assert result.exit_code == 2 * ("no result" in result.stderr), result.output
        record = json.loads((tmp_path / "out" / "compare.json").read_text("utf-8"))
        return [SimpleNamespace(**point) for point in record["points"]]

    return points


def test_the_scenes_method_keeps_its_options(called: Any, from_scene: Any) -> None:
    """Only it, and its step, the middle of its ladder: the others have their own defaults."""
    options = {"iteration_tolerance": 1e-6, "max_iterations": 60}
    points = from_scene("gauss-8,rk-4", method="gauss-8", step=0.125, **options)
    own = [p for p in points if p.method == "gauss-8"]
    assert {p.tolerance for p in own} == {1e-6}
    assert [p.step for p in own] == [0.5, 0.25, 0.125, 0.0625, 0.03125]
    for given in called:
        if given["method"].name == "gauss-8":
            assert {k: given["method"].options[k] for k in options} == options
    assert own[2].evaluations < run(["gauss-8"], steps=[0.125])[0].evaluations
    plain = [p.step for p in run(["rk-4"])]
    assert [p.step for p in points if p.method == "rk-4"] == plain
    steps = [p.step for p in from_scene("rk-4", method="rk-4", step=0.03125)]
    assert steps == [0.125, 0.0625, 0.03125, 0.015625, 0.0078125]


@pytest.mark.parametrize("name", ["own", "ball"])
def test_all_run_in_the_representation_asked_for(name: str, called: Any, from_scene: Any) -> None:
    """What does not fit it says so."""
    points = from_scene("rk-4,verlet-2", method="rk-4", step=0.1, representation=name)
    expected = "reduced" if name == "own" else name
    assert {p.representation for p in points} == {expected, ""}
    assert {given["problem"].pieces for given in called} == {MODEL.problems[expected].pieces}
    assert all(p.error < 1e-2 for p in points if p.status == "ok")
    (other,) = [p for p in points if p.method == "verlet-2"]
    assert f"does not fit the representation '{name}'" in other.status


def test_tolerances_are_about_the_methods_own(called: Any) -> None:
    own = gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-6, atol=1e-9, max_step=0.5)
    points = run([own], first_steps={own.name: 0.01})
    assert [p.rtol for p in points] == pytest.approx([1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
    for given in called:
        options = given["method"].options
        assert options["atol"] == pytest.approx(1e-3 * options["rtol"])
        assert options["max_step"] == 0.5
        assert given["step"] == 0.01
    coarse = run([gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-3)])
    assert [p.rtol for p in coarse] == pytest.approx([0.1, 1e-3, 1e-5, 1e-7])
    fine = run([gi.Adaptive(gi.RungeKutta("dop853"), rtol=1e-13)])
    assert fine[-1].rtol == 2.0**-50
    points = run(["dop853-adaptive"])
    assert [p.rtol for p in points] == [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
    for point in points:  # their step is the mean of those taken
        assert point.step * point.steps == pytest.approx(END["t_end"])


def test_a_step_longer_than_the_run_is_no_point() -> None:
    """A run of one shorter step says nothing of that step."""
    long, good = run(["rk-4"], steps=[5.0, 0.125])
    assert long.status == "not measured: the step is longer than the run"
    assert long.error is None
    assert good.status == "ok"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"methods": []}, "at least one method"),
        ({"steps": []}, "at least one step"),
        ({"steps": [-0.1]}, "a positive number"),
        ({"methods": ["dop853-adaptive"], "steps": [0.1]}, "choose their steps"),
        ({"reference": "best"}, "auto"),
        ({"representation": "bal"}, "Did you mean 'ball'"),
        ({"peers": ["scipy-dop85"]}, "scipy-dop853"),
        *(({"repeats": repeats}, "repeats") for repeats in (0, True, 2.5, "3")),
    ],
)
def test_what_says_nothing_is_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(gi.DomainError, match=words):
        run(**{"methods": ["rk-4"], **given})


@pytest.mark.parametrize(
    ("seconds", "asked", "repeats"),
    [(0.125, None, 3), (0.5, None, 2), (2.0, None, 1), (2.0, 2, 2), (0.125, 5, 5), (11.0, 3, 3)],
)
def test_points_are_run_as_often_as_is_asked_or_as_time_allows(
    monkeypatch: pytest.MonkeyPatch, seconds: float, asked: int | None, repeats: int
) -> None:
    """A number that is given is kept to; without one a point that takes long is not run again.

    Of peers too, whose first run is not timed: it compiles what is compiled when it is needed.
    """
    clock = [0.0]

    def passing() -> float:
        clock[0] += seconds
        return clock[0]

    monkeypatch.setattr(time, "perf_counter", passing)
    given = {**RUN, "steps": [0.1], "peers": ["scipy-dop853"], "repeats": asked}
    found = compare(MODEL, END, ["rk-4"], **given).points
    peers = [p for p in found if p.peer]
    assert {p.repeats for p in peers if p.seconds} == {repeats}
    assert {p.seconds for p in peers if p.seconds} == {seconds}
    (own,) = [p for p in found if p.peer is None]
    assert own.repeats == (asked or own.repeats)


def test_repeats_reports_and_drifts(monkeypatch: pytest.MonkeyPatch) -> None:
    """The median of the run times counts; after a second of them there are no more."""
    told: list[str] = []
    given: dict[str, Any] = {"steps": [0.1], "reference": "exact"}
    result = compare(MODEL, END, ["rk-4"], **given, repeats=2, report=told.append)
    assert result.points[0].repeats == 2
    assert any("rk-4, step 0.1" in text for text in told)
    assert [label for label, _ in result.drifts] == ["rk-4"]
    solve, seconds = compare_module.solve, iter([0.3, 0.1, 0.2, 0.6, 0.5, 9.0])

    def timed(*given: Any, **more: Any) -> gi.Solution:
        solution = solve(*given, **more)
        solution.run_seconds, solution.compile_seconds = next(seconds), 1.0
        return solution

    monkeypatch.setattr(compare_module, "solve", timed)
    for expected in ((3, 0.2), (2, 0.55)):
        result = compare(MODEL, END, ["rk-4"], **given, observe=False)
        (point,) = result.points
        assert (point.repeats, point.seconds, result.compile_seconds) == (*expected, expected[0])
        assert not result.drifts
