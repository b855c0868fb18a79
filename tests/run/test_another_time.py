"""``method="auto"`` takes another time where a long motion is uneven, and there alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.run.motions import kepler

END = 6000.0
ASKED: dict[str, Any] = {"method": "auto", "tolerance": 1e-9, "progress": False}
AT_ONCE = gi.Event("q[1]", terminal=True)  # ends a run whose time alone is looked at


@gi.field
def shaken(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    kepler(params, t, y, out, work)
    out[2] = out[2] + 1e-5 * gi.cos(t)


@gi.helper
def pulse(t: Any) -> Any:
    """In the middle of the run; below a rounding at its beginning."""
    d = (t - 3000.0) / 50.0
    d4 = d * d * d * d
    return 1.0 / (1.0 + d4 * d4 * d4 * d4)


@gi.field
def pushed_once(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    kepler(params, 0.0 * t, y, out, work)
    out[2] = out[2] + 1e-4 * pulse(t)


@gi.field
def with_growth(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    kepler(params, t, y, out, work)
    out[4], out[5] = y[4] * (params[1] + params[2] * y[4]), 0.0 * y[5]


def beside(rate: float, square: float) -> gi.Problem:
    """Return the orbit with numbers beside it: dw/dt = rate w + square w², and a constant."""
    pieces = (("q", 2), ("v", 2), ("w", 1), ("c", 1))
    return gi.Problem("beside", pieces, [1.0, rate, square], with_growth)


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    r = gi.sqrt(y[0] * y[0] + y[1] * y[1])
    return 0.5 * (y[2] * y[2] + y[3] * y[3]) - params[0] / r


def orbit(field: Any = kepler, **more: Any) -> gi.Problem:
    invariants = {"energy": energy} if field is kepler else {}
    return gi.Problem("orbit", (("q", 2), ("v", 2)), [1.0], field, invariants=invariants, **more)


def start(e: float, side: int) -> np.ndarray:
    """Return the state at the pericentre (−1) or the apocentre (1)."""
    return np.array([1.0 + side * e, 0.0, 0.0, np.sqrt((1.0 - side * e) / (1.0 + side * e))])


def there(e: float, side: int, t: float) -> np.ndarray:
    """Return the state by Kepler's equation."""
    mean, e = t % (2.0 * np.pi), side * e
    u = mean
    for _ in range(100):
        u += (mean - e * np.sin(u) - u) / (1.0 + e * np.cos(u))
    r, b = 1.0 + e * np.cos(u), np.sqrt(1.0 - e * e)
    return np.array([np.cos(u) + e, b * np.sin(u), -np.sin(u) / r, b * np.cos(u) / r])


def off(found: Any, e: float, side: int, t: float) -> float:
    """Return the error of a state, relative to the largest numbers of its pieces."""
    sizes = np.repeat([1.0 + e, np.sqrt((1.0 + e) / (1.0 - e))], 2)
    return float(np.max(np.abs(found - there(e, side, t)) / sizes))


LATE = [pytest.param(*x, marks=pytest.mark.nightly) for x in ((-1, END), (-1, -END), (1, END))]


@pytest.mark.parametrize(("side", "end"), [(1, -END), *LATE])
def test_a_long_uneven_motion(side: int, end: float) -> None:
    e = 0.97
    sol = gi.solve(orbit(), start(e, side), t_end=end, observe=["energy"], **ASKED)
    assert sol.problem.name == "orbit-by-speed"
    assert "another time" in sol.accuracy.reason
    assert sol.t[-1] == end
    error = off(sol.y[-1], e, side, end)
    assert error < 1e-8
    assert sol.end_error.error > 0.1 * error
    assert sol.drift["energy"].max_abs_error < 1e-11
    own = gi.solve(orbit(), start(e, side), t_end=0.1 * end, **{**ASKED, "method": "gauss-8"})
    assert own.problem.name == "orbit"
    assert 10.0 * own.iterations > 5.0 * sol.iterations  # an iteration is dearer, with σ


def test_all_that_may_be_asked_for() -> None:
    e, times = 0.95, np.linspace(0.0, END, 7)
    named = gi.Event("q[1]", direction="up")
    given: dict[str, Any] = {"t_eval": times + 2.0, "t0": 2.0, "t_end": END + 2.0, "dense": True}
    sol = gi.solve(orbit(), start(e, 1), **given, events={"up": named, "e": "energy"}, **ASKED)
    assert sol.problem.name == "orbit-by-speed"
    known = np.array([there(e, 1, t) for t in times])
    assert np.array_equal(sol.t, times + 2.0)
    assert np.abs(sol.y - known).max() < 1e-7
    assert np.abs(sol.sol(times + 2.0) - known).max() < 1e-7
    turns = np.arange(1, int(END / (2.0 * np.pi)) + 1)
    assert np.abs(sol.events["up"].t - 2.0 - 2.0 * np.pi * turns).max() < 1e-7
    assert not len(sol.events["e"])
    further = gi.solve(sol, t_end=END + 12.0)
    assert np.abs(further.y[-1] - there(e, 1, END + 10.0)).max() < 1e-7


def by_time(params: Any, t: Any, y: Any, work: Any) -> Any:
    return y[0] + t


@gi.observable
def late(params: Any, t: Any, y: Any, work: Any) -> Any:
    """What a run that goes on may ask for, where it would be that at t = 0."""
    return y[0] + 0.1 * pulse(t)


OWN: dict[str, tuple[gi.Problem, float, dict[str, Any]]] = {
    "breaks": (orbit(), 0.95, {"breaks": [1.0]}),
    "longest": (orbit(), 0.95, {"longest": 1.0}),
    "callback": (orbit(), 0.95, {"callback": lambda reached: False}),
    "observed": (orbit(), 0.95, {"observe": {"own": by_time}}),
    "events": (orbit(), 0.95, {"events": [gi.event(by_time), AT_ONCE]}),
    "method": (orbit(), 0.95, {"method": gi.Gauss(8)}),
    "begun late": (orbit(), 0.95, {"t0": 1e9, "t_end": 1e9 + END}),
    "short": (orbit(), 0.95, {"t_end": 60.0}),
    "even": (orbit(), 0.3, {"t_end": 10.0 * END}),
    "by time": (orbit(shaken), 0.95, {}),
    "by time, later": (orbit(pushed_once), 0.97, {}),
    "a quantity by time": (orbit(observables={"late": late}), 0.95, {}),
}


@pytest.mark.parametrize("case", OWN)
@pytest.mark.filterwarnings("ignore::geomint.EndWarning")  # the time alone is looked at
def test_what_keeps_its_time(case: str) -> None:
    """What is asked for in it, or depends on it, and motions that are short or even."""
    problem, e, more = OWN[case]
    given: dict[str, Any] = {"t_end": END, "events": AT_ONCE, **ASKED}
    assert gi.solve(problem, start(e, -1), **{**given, **more}).problem.name == "orbit"
    assert gi.solve(orbit(), start(0.95, -1), **given).problem.name == "orbit-by-speed"


def test_what_makes_no_sense_is_said_of_the_problem() -> None:
    for more, words in (
        ({"tau_eval": [1.0]}, "expected t_eval: 'orbit' is in physical time"),
        ({"events": ["nothing"]}, "a component or a quantity of 'orbit'"),
    ):
        with pytest.raises(gi.DomainError, match=words):
            gi.solve(orbit(), start(0.95, -1), t_end=END, **more, **ASKED)


def test_a_run_that_the_other_time_does_not_serve_is_one_in_its_own() -> None:
    """What is tiny at first, and grows, makes σ ever smaller there: 10⁸ steps and more."""
    e, w, end = 0.95, 1e-12, 0.5 * END
    sol = gi.solve(beside(0.01, -0.01), [*start(e, -1), w, 1.0], t_end=end, **ASKED)
    assert sol.problem.name == "beside"
    assert not sol.warnings
    grown = w * np.exp(0.01 * end)
    assert abs(sol.y[-1, 4] - grown / (1.0 - w + grown)) < 1e-8
    assert np.abs(sol.y[-1, :4] - there(e, -1, end)).max() < 1e-7


def test_where_the_motion_ends_there_is_the_error_of_its_own_time() -> None:
    with pytest.raises(gi.StepError) as told:
        gi.solve(beside(0.0, 1.0), [*start(0.95, -1), 1.0 / 5000.0, 1.0], t_end=END, **ASKED)
    assert told.value.t == pytest.approx(5000.0, abs=0.01)
