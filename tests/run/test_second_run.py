"""What is promised of the end holds, as a second run tells, or a warning comes."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.growth import end_error, hopeless
from tests.run.motions import first, pulsed, second

QUIET: dict[str, Any] = {"progress": False}
HENON = henon_heiles.problem(), henon_heiles.INITIAL


def saddle(p: Any, t: Any, y: Any) -> Any:
    return p[0] * y[0] - y[0] * y[0] * y[0]


def chirp(p: Any, t: Any, y: Any) -> Any:
    w = 1.0 + p[0] * t
    return -w * w * y[0]


def switched(p: Any, t: Any, y: Any) -> Any:
    return -y[0] + gi.select(t > p[0], 0.01, 0.0)


MOTIONS: dict[str, tuple[Any, float, list[float], float]] = {
    "out of a saddle": (saddle, 1.0, [1e-4, 0.0], 24.0),
    "over a saddle and back": (saddle, 1.0, [0.9, 0.4], -40.0),
    "faster and faster": (chirp, 1.3, [0.7, 0.3], 20.0),
    "a force that switches": (switched, 7.3, [0.7, 0.3], 15.0),
    "at rest": (saddle, -1.0, [0.0, 0.0], 30.0),
}
PROBLEMS = {
    force: second("moved", force, 1.0, pieces=(("y", 2),)) for force, *_ in MOTIONS.values()
}


def moved(force: Any, param: float) -> gi.Problem:
    return gi.Problem("moved", (("y", 2),), [param], field=PROBLEMS[force].field)


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_end_is_as_promised(motion: str) -> None:
    """By default, by a tolerance, and by variable steps."""
    force, param, y0, end = MOTIONS[motion]
    fine: dict[str, Any] = {"method": "gauss-8", "step": 0.005, "save_every": 1, **QUIET}
    fine |= {"breaks": [param]} if force is switched else {}
    truth = gi.solve(moved(force, param), y0, t_end=end, **fine).y
    for tolerance, more in (
        (1e-9, {}),
        (1e-7, {"tolerance": 1e-7, "method": "auto"}),
        (1e-8, {"tolerance": 1e-8, "method": "dop853-adaptive"}),
    ):
        if motion == "out of a saddle" or len(more) < 2 or more["method"] == "auto":
            sol = gi.solve(moved(force, param), y0, t_end=end, **QUIET, **more)
            size = max(np.abs(truth).max(), 1e-9)
            assert np.abs(sol.y[-1] - truth[-1]).max() / size < 30.0 * tolerance
            assert not sol.warnings


@pytest.mark.parametrize("asked", [{}, {"tolerance": 1e-7, "method": "auto"}], ids=["none", "auto"])
def test_the_end_of_motions_with_an_edge(asked: dict[str, Any]) -> None:
    """Up to a pole errors are as promised; a rate that is infinite at the end hides none."""
    pole = first("pole", lambda p, t, y: p[0] * y[0] * y[0], 1.0)
    sol = gi.solve(pole, [2.0, 1.0], t_end=0.499, **QUIET, **asked)
    assert sol.y[-1, 0] == pytest.approx(2.0 / (1.0 - 2.0 * 0.499), rel=3e-6 if asked else 3e-8)
    edge = first("edge", lambda p, t, y: 1.0 / gi.sqrt(p[0] - t) + 0.0 * y[0], 3.0)
    with pytest.warns(gi.GeomintWarning, match="end"):
        sol = gi.solve(edge, [0.0, 1.0], t_end=3.0, **QUIET, **asked)
    assert sol.end_error.error > 1e-4
    assert sol.end_error.until == 0.0


def test_what_ends_tell() -> None:
    """√(r^p − 1) errors where few enough are left, or three runs agree; one where errors grow."""
    sol = gi.solve(*HENON, t_end=40.0, step=0.8, **QUIET)
    local = sol.local_error

    def found(apart: float, wanted: float = 1e-16, other: float = 0.0) -> Any:
        return end_error(sol, apart, wanted, 0.0, 50.0, other)

    assert found(1e-17).error <= max(local.total, 1e-17) * 1.1
    regular = 20.0 * local.total
    assert found(regular).error == pytest.approx(max(regular / 7.0, local.total), rel=0.3)
    grown = found(1e4 * 50.0 * local.total)
    more = 2500.0 * local.total  # errors grow 50 times, so that the order alone is not trusted
    for expected, part in ((0.0, 1.0), (0.1, 1.0), (1.5, 1 / 7), (4.0, 1.0)):
        agreed = found(more, 0.1 * more, expected * more)
        assert agreed.error == pytest.approx(part * more, rel=0.3)
    assert grown.error == pytest.approx(5e5 * local.total, rel=0.3)
    assert grown.grown == pytest.approx(1e4, rel=0.5)
    assert 0.0 <= grown.until < 40.0
    sol.end_error = grown
    assert hopeless(sol, 1e-16, sol)
    assert not hopeless(sol, 1e-6, sol)


@pytest.mark.parametrize(("end", "few"), [(25.0, True), (60.0, False)])
def test_two_runs_of_few_steps_may_agree_by_chance(end: float, few: bool) -> None:
    """Of so few what steps err by counts, however near the ends of both runs are."""
    sol = gi.solve(*HENON, t_end=end, method="auto", tolerance=1e-6)
    assert (6 < sol.steps <= 20) is few
    total = sol.local_error.total
    error = end_error(sol, 0.02 * total, 0.04 * total, 0.0, 10.0, 0.0).error
    assert error == pytest.approx(total if few else 0.02 * total, rel=0.5)


def test_it_is_of_the_end_whatever_is_saved() -> None:
    whole, some = (gi.solve(*HENON, t_end=50.0, t_eval=x, **QUIET) for x in (None, [3.0]))
    assert whole.end_error[1:] == some.end_error[1:]
    assert some.end_error.error < 1e-13
    assert gi.solve(*HENON, t_end=50.0, method="gauss-8", **QUIET).end_error is None


def test_ctrl_c_while_a_run_is_confirmed_leaves_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(*_: Any) -> None:
        raise KeyboardInterrupt

    ranked: Any = gi.solve(*HENON, t_end=20.0, **QUIET).ranked
    monkeypatch.setattr(type(ranked.second), "state", pressed)
    sol = gi.solve(*HENON, t_end=20.0, **QUIET)
    assert (sol.success, sol.end_error) == (True, None)


@gi.field
def hump(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A rotation that is fast about time 10: Newton's method finds its steps there."""
    z = (t - 10.0) / params[0]
    w = 1.0 + params[1] / (1.0 + z * z)
    out[0], out[1] = w * y[1], -w * y[0]


def test_the_worst_of_steps_by_newtons_method_is_found() -> None:
    width, step = 2.0, 0.35
    problem = gi.Problem("hump", (("y", 2),), params=[width, 20.0], field=hump)
    sol = gi.solve(problem, [1.0, 0.0], t_end=20.0, method="gauss-8", step=step, **QUIET)
    angle = 20.0 + 40.0 * width * math.atan(10.0 / width)
    off = np.abs(sol.y[-1] - [math.cos(angle), -math.sin(angle)]).max()
    assert abs(sol.local_error.time - 10.0) < 1.0
    assert 0.05 < sol.local_error.total / off < 20.0


@pytest.mark.parametrize(
    "asked", [{}, {"method": "rk-4"}, {"tolerance": 1e-8}, {"method": "dop853", "tolerance": 1e-6}]
)
def test_a_run_that_goes_on_keeps_what_was_promised_or_says_so(
    asked: dict[str, Any], tmp_path: Path
) -> None:
    problem = pulsed(50.0, 0.3, 3000.0)
    started = gi.solve(problem, [1.0, 0.0], t_end=10.0, **asked, **QUIET)
    started.save(tmp_path / "first.nc")
    assert not started.warnings
    for former in (started, gi.load(tmp_path / "first.nc", problem)):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                gi.solve(former, t_end=100.0, **QUIET)
            except gi.ConvergenceError:  # a typed error is no silence
                continue
        assert any("than is promised" in str(warning.message) for warning in told)
    given = gi.solve(problem, [1.0, 0.0], t_end=10.0, step=0.05, **QUIET)
    assert not gi.solve(given, t_end=20.0, **QUIET).warnings
    assert not gi.solve(started, t_end=20.0, **QUIET).warnings


def test_errors_are_those_up_to_an_event_that_ends_the_run() -> None:
    """Steps were ranked up to beyond it, where a wall is met."""

    def contact(p: Any, t: Any, y: Any) -> Any:
        return -1.0 + gi.select(y[0] < 0.0, -p[0] * y[0], 0.0)

    event = gi.Event("x", terminal=True)
    for stiffness, step in ((4.0, None), (4.0, 0.1), (1e4, None)):
        problem = second("fall", contact, stiffness)
        sol = gi.solve(problem, [1.0, 0.0], t_end=10.0, step=step, events=event, **QUIET)
        assert sol.t[-1] == pytest.approx(np.sqrt(2.0), abs=1e-12)
        assert sol.local_error.largest < 1e-14
        assert not sol.warnings


def test_steps_that_are_not_stable_are_shortened() -> None:
    """Such a run is off by more than the motion is large, and says nothing of how errors grow."""
    problem = first("relaxed", lambda p, t, y: -p[0] * (y[0] - gi.cos(t)) - gi.sin(t), 336.0966)
    length, tolerance = 1.688, 9e-4
    for begin in np.linspace(-2.0, 2.0, 9):
        given: dict[str, Any] = {"t0": begin, "t_end": begin + length, "method": "dop853"}
        sol = gi.solve(problem, [0.601332, 1.0], **given, tolerance=tolerance, **QUIET)
        assert abs(sol.y[-1, 0] - math.cos(begin + length)) < 10.0 * tolerance
        assert not sol.warnings
