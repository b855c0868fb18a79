"""Runs to a physical end in τ end: with it, or with a typed error."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numba.core import config

import geomint as gi
from geomint.run import driver

pytestmark = [
    pytest.mark.nojit,
    pytest.mark.skipif(config.DISABLE_JIT, reason="too many steps for plain Python"),
]
STEP = 0.125


@gi.field
def circle(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = 1.0 * y[1], -y[0]


# dt/dτ = c exp(dτ) + e − f sin τ: one function, so that it is compiled once.
@gi.observable
def rate(params: Any, t: Any, y: Any, work: Any) -> Any:
    power = 1.0
    for _ in range(64):  # (1 + dτ/64)^64
        power = power * (1.0 + params[1] * t / 64.0)
    return params[0] * power + params[2] - params[3] * gi.sin(t)


def turning(c: float = 0.0, d: float = 0.0, e: float = 0.0, f: float = 0.0) -> gi.Problem:
    return gi.Problem("turning", (("y", 2),), [c, d, e, f], circle, time="tau", clock=rate)


START = np.array([0.6, 0.8])
NEVER = {
    "0": turning(),
    "negative": turning(e=-1.0),
    "tending to 0": turning(c=1.0, d=-1e-3),
    "its mean is 0": turning(f=1.0),
}
FORWARDS = ("tending to 0", "slow at first")  # these are other clocks backwards


def both_ways(names: dict[str, Any]) -> list[tuple[str, float]]:
    return [(name, sign) for name in names for sign in (1.0, -1.0)[: 1 + (name not in FORWARDS)]]


@pytest.mark.parametrize(("name", "sign"), both_ways(NEVER))
def test_a_clock_that_does_not_get_there_is_an_error(name: str, sign: float) -> None:
    with pytest.raises(gi.ClockError, match="physical time does not get to its end") as caught:
        gi.solve(NEVER[name], START, t_end=sign * 1e5, method="rk-4", step=STEP)
    error = caught.value
    assert error.step == error.partial.steps > 500
    assert error.t == error.partial.tau[-1] == pytest.approx(sign * STEP * error.step)
    assert error.residual == pytest.approx(abs(sign * 1e5 - error.partial.t[-1]))


GETS_THERE = {
    "even": (turning(e=1.0), 1000.0),
    "resting at times": (turning(e=1.0, f=1.0), 1000.0),
    "backwards at times": (turning(e=0.25, f=1.0), 100.0),
    "slow at first": (turning(c=1e-9, d=0.05), 100.0),
    "tiny": (turning(e=1e-12), 1e-9),
    "slower and slower": (turning(c=1.0, d=-1e-3, e=1e-3), 1010.0),
}


@pytest.mark.parametrize(("name", "sign"), both_ways(GETS_THERE))
def test_a_clock_that_gets_there_is_none(name: str, sign: float, monkeypatch: Any) -> None:
    """The last half of all steps counts, even where the clock is looked at after every step."""
    problem, end = GETS_THERE[name]
    if name == "backwards at times":
        monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
    sol = gi.solve(problem, START, t_end=sign * end, method="rk-4", step=STEP)
    assert sol.success
    assert sol.t[-1] == sign * end
    assert math.isfinite(sol.tau[-1])


def test_no_more_steps_than_there_are_times() -> None:
    """With an end in physical time as with one in the problem's own."""
    for end, step in ((1e300, STEP), (1.0, 1e-300), (-1e18, 1.0)):
        for time in ("t_end", "tau_end"):
            with pytest.raises(gi.DomainError, match="in fewer than 2⁵³ steps"):
                gi.solve(turning(e=1.0), START, **{time: end}, method="rk-4", step=step)
