"""What a comparison takes from a scene: representation, step and options, and what it refuses."""

from __future__ import annotations

from typing import Any

import pytest

import geomint as gi
from geomint.compare import (
    of_scene,
    peer_runs as peer_module,
    point as points_of,
    runs as compare_module,
)
from geomint.compare.of_scene import compare_scene
from geomint.compare.runs import compare
from geomint.plan import representation_for

SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 2.0},
}
MODEL = gi.Scene(**SCENE).model
END = {"t_end": 2.0}


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
    return compare(MODEL, END, methods, **{"repeats": 1, "observe": False, **given}).points


def from_scene(methods: list[str], **integrate: Any) -> list[Any]:
    """Return the points of the command's function."""
    return compare_scene(gi.Scene(**SCENE, integrate=integrate), methods, repeats=1).points


def test_the_scenes_method_keeps_its_options(called) -> None:
    """Only it: the others have their own defaults."""
    options = {"iteration_tolerance": 1e-6, "max_iterations": 60}
    points = from_scene(["gauss-8", "gauss-4"], method="gauss-8", step=0.125, **options)
    assert {p.tolerance for p in points if p.method == "gauss-8"} == {1e-6}
    assert {p.tolerance for p in points if p.method == "gauss-4"} == {0.0}
    for given in called:
        found = {k: given["method"].options[k] for k in options}
        assert (found == options) == (given["method"].name == "gauss-8")
    exact = run(["gauss-8"], steps=[0.125])[0]
    short = next(p for p in points if p.method == "gauss-8" and p.step == 0.125)
    assert short.evaluations < exact.evaluations


def test_the_scenes_step_is_the_middle_of_its_ladder() -> None:
    given = {"method": "rk-4", "step": 0.03125}
    points = from_scene(["rk-4", "kutta-3"], **given)
    steps = [p.step for p in points if p.method == "rk-4"]
    assert steps == [0.125, 0.0625, 0.03125, 0.015625, 0.0078125]
    plain = [p.step for p in run(["kutta-3"])]
    assert [p.step for p in points if p.method == "kutta-3"] == plain


@pytest.mark.parametrize("name", ["ball", "own", "reduced"])
def test_all_run_in_the_representation_asked_for(name: str, called) -> None:
    points = from_scene(["rk-4", "kutta-3"], method="rk-4", step=0.1, representation=name)
    expected = "reduced" if name == "own" else name
    assert {p.representation for p in points} == {expected}
    assert {id(given["problem"].field) for given in called}
    assert {given["problem"].pieces for given in called} == {MODEL.problems[expected].pieces}
    assert all(p.error < 1e-2 for p in points if p.status == "ok")


def test_a_method_that_does_not_fit_it_says_so() -> None:
    first, last = run(["rattle-2", "rk-4"], representation="ball", steps=[0.1])
    assert "does not fit the representation 'ball'" in first.status
    assert last.status == "ok"
    with pytest.raises(gi.DomainError, match="Did you mean 'ball'"):
        run(["rk-4"], representation="bal")


def test_tolerances_are_about_the_methods_own(called) -> None:
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
    ],
)
def test_what_says_nothing_is_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(gi.DomainError, match=words):
        run(**{"methods": ["rk-4"], **given})


def test_group_methods_reach_any_end_in_their_own_time() -> None:
    """Physical time goes beside the group."""
    model, method = gi.load_scene("ball-poisson").model, gi.find_method("cf-4")
    for end in ({"t_end": 1.0}, {"tau_end": 1.0}):
        assert representation_for(model, method, end)[0] == "poisson"
    with pytest.raises(gi.FormError, match="does not fit the representation 'own'"):
        representation_for(model, gi.find_method("verlet-2"), {"t_end": 1.0}, "own")


@pytest.mark.parametrize(
    ("enough", "asked", "repeats"), [(1e9, None, 3), (0.0, None, 1), (0.0, 2, 2), (1e9, 5, 5)]
)
def test_points_are_run_as_often_as_is_asked_or_as_time_allows(
    monkeypatch: pytest.MonkeyPatch, enough: float, asked: int | None, repeats: int
) -> None:
    """A number that is given is kept to; without one a point that takes long is not run again."""
    monkeypatch.setattr(points_of, "ENOUGH", enough)
    given = {"steps": [0.1], "observe": False, "peers": ["scipy-dop853"], "repeats": asked}
    found = compare(MODEL, END, ["rk-4"], **given).points
    assert [p.repeats for p in found if p.peer is None] == [repeats]
    assert {p.repeats for p in found if p.peer} == {repeats}


@pytest.mark.parametrize(
    ("seconds", "asked", "runs"),
    [(0.1, None, 3), (0.5, None, 2), (2.0, None, 1), (0.5, 3, 3), (11.0, 3, 3)],
)
def test_a_peer_that_takes_long_is_run_less_often(
    monkeypatch: pytest.MonkeyPatch, seconds: float, asked: int | None, runs: int
) -> None:
    """After a first run, which is not timed."""
    timed, count = peer_module._timed, [0]

    def slowly(ready: Any) -> Any:
        count[0] += 1
        return timed(ready)[0], seconds

    monkeypatch.setattr(peer_module, "_timed", slowly)
    monkeypatch.setattr(peer_module, "TOLERANCES", (1e-6,))
    peers = {"peers": ["scipy-dop853"], "steps": [0.1], "observe": False, "repeats": asked}
    points = [p for p in compare(MODEL, END, ["rk-4"], **peers).points if p.peer]
    assert count == [runs]
    assert points[0].seconds == seconds


@pytest.mark.parametrize("repeats", [0, -1, True, 2.5, "3"])
def test_repeats_that_are_no_number(repeats: Any) -> None:
    with pytest.raises(gi.DomainError, match="repeats"):
        compare(MODEL, END, ["rk-4"], steps=[0.1], repeats=repeats)


@pytest.mark.parametrize(
    ("once", "asked", "together"),
    [(0.0, None, 0.0), (0.01, None, 0.03), (0.6, None, 1.2), (9.0, None, 9.0), (9.0, 3, 27.0),
     (9.0, 1000, 36.0)],
)  # fmt: skip
def test_how_long_the_runs_of_a_point_take(once: float, asked: int | None, together: float) -> None:
    assert of_scene._together(once, asked) == pytest.approx(together)


def test_repeats_reports_and_drifts() -> None:
    told: list[str] = []
    result = compare(MODEL, END, ["rk-4"], steps=[0.1], repeats=2, report=told.append)
    assert result.points[0].repeats == 2
    assert any("rk-4, step 0.1" in text for text in told)
    assert [label for label, _ in result.drifts] == ["rk-4"]
    assert not compare(MODEL, END, ["rk-4"], steps=[0.1], repeats=1, observe=False).drifts
