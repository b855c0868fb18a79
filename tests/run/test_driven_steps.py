"""Default steps where the rate depends on time explicitly."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.problems.testproblems import pulsating_body
from geomint.problems.time_scale import characteristic_time
from tests.problems import abc_flow

Array = Any


@gi.field
def driven(params, t, y, out, work):
    s = params[0] * t
    stiffness = params[1] + params[2] * gi.sin(params[3] * s)
    force = params[4] * gi.sin(params[6] * s) + params[5] * gi.cos(params[6] * s)
    out[0] = y[1]
    out[1] = params[0] * params[0] * (force - stiffness * y[0])


# k, b, ν, a, c, ω of q″ = −(k + b sin νt) q + a sin ωt + c cos ωt; q, p at 0; end.
DRIVEN = {
    "sine from rest": ([0.0, 0.0, 0.0, 1000.0, 0.0, 1000.0], [0.0, 0.0], 0.1),
    "cosine from rest": ([1.0, 0.0, 0.0, 0.0, 300.0, 300.0], [0.0, 0.0], 1.0),
    "parametric": ([1.0, 50.0, 40.0, 0.0, 0.0, 0.0], [1.0, 0.0], 2.0),
    "parametric from 0": ([1.0, 50.0, 40.0, 0.0, 0.0, 0.0], [0.0, 1.0], 2.0),
    "weak and fast": ([1.0, 0.0, 0.0, 0.0, 1e-3, 300.0], [1.0, 0.5], 3.0),
}


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3, 1e6])
@pytest.mark.parametrize("name", list(DRIVEN))
def test_the_default_step_where_time_drives(name: str, unit: float) -> None:
    """The step is that of the dependence on time, forwards and backwards, in any unit of time."""
    numbers, y0, end = DRIVEN[name]
    scale = np.array([1.0, unit])
    problem = gi.Problem("driven", (("q", 1), ("p", 1)), params=[unit, *numbers], field=driven)
    for t in (end, -end):
        run = solve_ivp(
            lambda t, y: rates_of_driven(numbers, t, y),
            (0, t),
            y0,
            "DOP853",
            rtol=1e-12,
            atol=1e-13,
        )
        sol = gi.solve(problem, scale * y0, t_end=t / unit)
        errors = np.abs(sol.y[-1] / scale - run.y[:, -1]) / np.max(np.abs(run.y), axis=1)
        assert np.max(errors) < 1e-6
        assert sol.steps < 1000


def rates_of_driven(numbers: list[float], t: float, y: Array) -> list[float]:
    k, b, nu, a, c, omega = numbers
    force = a * np.sin(omega * t) + c * np.cos(omega * t)
    return [y[1], force - (k + b * np.sin(nu * t)) * y[0]]


def time_of_force(force: Any, place: float, end: float = 1.0) -> float:
    """Return the characteristic time of q″ = force(place, t) from rest; 1 without the force."""
    force = gi.helper(force)

    @gi.field
    def forced(params, t, y, out, work):
        out[0] = y[1]
        out[1] = force(params[0], t)

    problem = gi.Problem("forced", (("q", 1), ("p", 1)), params=[place], field=forced)
    return characteristic_time(problem, np.zeros(2), end)


@pytest.mark.nojit
def test_the_default_step_of_forces_with_jumps() -> None:
    """A wave of jumps is resolved; one jump, at 0 or later, and kinks there, cost little."""
    for omega in (10.0, 1e3, 1e6, 1e12):
        time = time_of_force(lambda w, t: gi.select(gi.sin(w * t + 0.3) > 0.0, 1.0, -1.0), omega)
        assert 0.05 < omega * time < 5.0
    for place in [0.0, *10.0 ** np.arange(-15.0, 1.0, 0.25)]:
        assert 0.03 < time_of_force(lambda s, t: gi.select(t > s, 1.0, 0.0), place) <= 1.0
    for place in (0.0, 1e-9):
        assert time_of_force(lambda s, t: gi.select(t > s, 1.0 + t, 1.0), place) == 1.0
    assert time_of_force(lambda s, t: gi.sqrt(s + t), 0.0) == 1.0


@pytest.mark.nojit
@pytest.mark.parametrize("start", [1.0, -3.0, 1e-3, 1e12])
def test_a_rate_without_derivatives_where_the_run_begins(start: float) -> None:
    """√(t − t₀) is as smooth from t₀ on as √t from 0; roundings of times are no smoothness."""

    @gi.field
    def root(params, t, y, out, work):
        out[0] = gi.sqrt(t - params[0])

    problem = gi.Problem("root", (("y", 1),), params=[start], field=root)
    assert characteristic_time(problem, np.zeros(1), 1.0, start) == 1.0


@pytest.mark.nojit
def test_the_default_step_sees_where_it_goes() -> None:
    """What only drives before time 0 shortens steps backwards alone."""

    def early(omega, t):
        return gi.select(t < 0.0, gi.sin(omega * t), 0.0)

    assert time_of_force(early, 1e3) == 1.0
    assert 0.5 < 1e3 * time_of_force(early, 1e3, -1.0) < 2.0


@pytest.mark.nojit
def test_no_default_step_where_nothing_is_smooth() -> None:
    with pytest.raises(gi.DomainError, match="smooth in time"):
        time_of_force(lambda w, t: gi.sin(w * t), 1e60)


@gi.field
def pulled(params, t, q, p, dq, dp, work):
    dq[0] = -gi.sin(1e3 * t)
    dq[1] = 0.0 * q[1]
    dp[0] = p[0]
    dp[1] = p[1]


@gi.field
def on_axis(params, q, g, G, work):
    g[0] = q[1]
    G[0] = 0.0 * q[0]
    G[1] = 1.0


@pytest.mark.nojit
def test_the_default_step_in_every_form() -> None:
    """Field, generator, gradients and flows tell that they depend on time."""
    body = pulsating_body.problem(frequencies=(1e3, 1e3, 1e3))
    flow = abc_flow.problem()
    slow = dataclasses.replace(flow, params=flow.params * np.array([1e-3, 1e-3, 1e-3, 1.0]))
    pieces, form = (("q", 2), ("p", 2)), gi.Hamiltonian(pulled, on_axis, 1)
    mass = gi.Problem("pulled", pieces, hamiltonian=form)
    for problem, y0, omega in (
        (body, pulsating_body.INITIAL, 1e3),
        (slow, abc_flow.INITIAL, 2.0),
        (mass, np.zeros(4), 1e3),
    ):
        for form in problem.forms:
            others = {other: None for other in problem.forms if other != form}
            only = dataclasses.replace(problem, **others)
            assert 0.5 < omega * characteristic_time(only, y0) < 5.0


@pytest.mark.parametrize("size", [1e-20, 1e-100, 1e-150])
def test_a_tiny_state_and_a_dependence_of_ordinary_speed(size: float) -> None:
    """The state's own time is 1/size, and the dependence on time is seen beside it."""
    problem = pulsating_body.problem()
    ordinary = characteristic_time(problem, np.asarray(pulsating_body.INITIAL))
    time = characteristic_time(problem, size * np.asarray(pulsating_body.INITIAL))
    assert 0.1 < time / ordinary < 10.0


@gi.field
def runaway(params, t, y, out, work):
    out[0] = 1.0 + y[0] * y[0]


@gi.field
def swing_and_clock(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gi.sin(y[0])
    out[2] = 1.0 + 0.0 * y[0]


@gi.field
def friction(params, t, y, out, work):
    out[0] = y[1]
    out[1] = 1.0 - 1000.0 * y[1]


ABC = abc_flow.problem()
Q_P, Q_P_S = (("q", 1), ("p", 1)), (("q", 1), ("p", 1), ("s", 1))
# A problem, its state with a tiny part e, and between what its characteristic time is.
RESTING = {
    "one": (gi.Problem("runaway", (("x", 1),), field=runaway), lambda e: [e], 0.5, 1.0),
    "two": (
        *(gi.Problem("swing", Q_P_S, field=swing_and_clock), lambda e: [1.2, e, 0.7 * e]),
        *(0.5, 1.5),
    ),
    "vector": (ABC, lambda e: (e * np.array(abc_flow.INITIAL)).tolist(), 0.4, 1.2),
    "damped": (gi.Problem("friction", Q_P, field=friction), lambda e: [1.2, e], 2e-4, 2e-3),
}


@pytest.mark.nojit
@pytest.mark.parametrize("tiny", [1e-2, 1e-3, 1e-5, 1e-8, 1e-16, 1e-100, 1e-300, 0.0])
@pytest.mark.parametrize("name", RESTING)
def test_the_default_step_does_not_shrink_with_what_rests(name: str, tiny: float) -> None:
    """However small a piece is from which the state sets out."""
    problem, state, least, most = RESTING[name]
    assert least < characteristic_time(problem, np.array(state(tiny))) <= most


def test_accuracy_at_the_default_step_from_rest() -> None:
    """x = tan(t + arctan x(0)), from tiny x(0) on."""
    problem = RESTING["one"][0]
    for tiny in (1e-1, 1e-2, 1e-3, 1e-5, 1e-8, 1e-100, 1e-300, 0.0):
        sol = gi.solve(problem, [tiny], t_end=1.0)
        assert sol.steps < 100
        assert sol.y[-1, 0] == pytest.approx(np.tan(1.0 + np.arctan(tiny)), rel=1e-9)


@pytest.mark.nojit
def test_a_default_step_that_is_too_short_is_told_as_such() -> None:
    """Not as a step that nobody gave."""
    for step, name in ((None, "end"), (1e-30, "step")):
        problem = gi.Problem("fast", (("x", 1),), [1e30], field=fast)
        with pytest.raises(
            gi.DomainError, match="give a step" if step is None else "step"
        ) as caught:
            gi.solve(problem, [1.0], t_end=1.0, step=step)
        assert caught.value.name == name


@gi.field
def fast(params, t, y, out, work):
    out[0] = -params[0] * y[0]
