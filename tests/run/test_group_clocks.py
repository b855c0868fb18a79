"""Physical time beside group methods: to the order of the method, and the motion as without it."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.families import PROBLEMS, pairs


@gi.observable
def rate(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 2.0 + y[0] * gi.sin(3.0 * t) + y[1] * y[0]


def in_tau(name: str) -> tuple[gi.Problem, Any]:
    """A problem whose generator depends on time and does not commute, with a clock that does too."""
    problem, y0 = PROBLEMS[name]
    return dataclasses.replace(problem, time="tau", clock=rate), y0


END = 1.0
FEW = [("cf-4", "pulsating-body"), ("rkmk-dormand-prince-5", "pulsating-body")]
ALL = [*FEW, ("cf-3", "pulsating-body"), ("rkmk-4", "pulsating-body"), ("rkmk-4", "so-4")]
ALL += [(name, "so-4") for name in ("cg-2", "cg-3", "rkmk-cayley-4")]


def truth(name: str, **end: Any) -> gi.Solution:
    """By a Gauss method on the field."""
    return gi.solve(*in_tau(name), **end, step=0.01, method="gauss-8")


@pairs(ALL, FEW)
def test_the_clock_has_the_order_of_the_method(name: str, problem: str) -> None:
    p, y0 = in_tau(problem)
    order, known = gi.find_method(name).order, truth(problem, tau_end=END).t[-1]
    counts = (20, 40, 80) if order < 5 else (8, 16, 32)
    errors = []
    for count in counts:
        run = {"tau_end": END, "step": END / count, "method": name}
        with_clock, without = (gi.solve(p, y0, clock=clock, **run) for clock in (True, False))
        np.testing.assert_allclose(with_clock.y, without.y, rtol=0, atol=1e-15)
        errors.append(abs(with_clock.t[-1] - known))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert order - 0.4 < slopes[-1] < order + 0.7, errors


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_ends_and_states_at_physical_times(sign: float) -> None:
    problem, y0 = in_tau("pulsating-body")
    times = sign * np.array([0.5, 1.25, 2.0])
    run = {"t_end": times[-1], "t_eval": times}
    found = gi.solve(problem, y0, step=0.002, method="rkmk-dormand-prince-5", **run)
    expected = truth("pulsating-body", **run)
    np.testing.assert_array_equal(found.t, times)
    np.testing.assert_allclose(found.tau, expected.tau, rtol=1e-10)
    np.testing.assert_allclose(found.y, expected.y, atol=1e-9)


def test_adaptive_steps_carry_the_clock() -> None:
    """It is a piece of its own, whose error counts as well."""
    problem, y0 = in_tau("pulsating-body")
    method = gi.Adaptive(gi.RKMK("dormand-prince-5"), rtol=1e-10)
    runs = [gi.solve(problem, y0, tau_end=END, method=method, clock=c) for c in (True, False)]
    assert runs[0].steps >= runs[1].steps > 5
    np.testing.assert_allclose(runs[0].y, runs[1].y, rtol=0, atol=1e-8)
    assert abs(runs[0].t[-1] - truth("pulsating-body", tau_end=END).t[-1]) < 1e-8


@pytest.mark.filterwarnings("ignore:field and action:geomint.DeclarationWarning")  # one has changed
def test_at_rest_the_clock_goes_on() -> None:
    problem, y0 = in_tau("pulsating-body")
    still = dataclasses.replace(
        problem, action=dataclasses.replace(problem.action, generator=gi.helper(no_turn))
    )
    solution = gi.solve(still, y0, tau_end=END, step=0.125, method="rkmk-4")
    np.testing.assert_array_equal(solution.y[-1], y0)
    expected = (2.0 + y0[1] * y0[0]) * END + y0[0] * (1.0 - np.cos(3.0 * END)) / 3.0
    assert solution.t[-1] == pytest.approx(expected, rel=1e-5)


def no_turn(params: Any, t: Any, y: Any, xi: Any, work: Any) -> None:
    xi[0] = 0.0 * y[0]
    xi[1] = 0.0 * y[0]
    xi[2] = 0.0 * y[0]
