"""Default steps where the rate depends on time explicitly, and from states that rest."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.problems.testproblems import pulsating_body
from tests.problems import abc_flow
from tests.run.motions import first, second

RK = gi.find_method("rk-4")
Q_P, Q_P_S = (("q", 1), ("p", 1)), (("q", 1), ("p", 1), ("s", 1))


def time_of(problem: gi.Problem, y0: Any, way: float = 1.0, start: float = 0.0) -> float:
    """Return the characteristic time, of which default steps are a fraction."""
    return RK.default_step(problem, np.asarray(y0), way, start) / RK.step_fraction


@gi.field
def driven(params, t, y, out, work):
    s = params[0] * t
    stiffness = params[1] + params[2] * gi.sin(params[3] * s)
    force = params[4] * gi.sin(params[6] * s) + params[5] * gi.cos(params[6] * s)
    out[0], out[1] = y[1], params[0] * params[0] * (force - stiffness * y[0])


# k, b, ν, a, c, ω of q″ = −(k + b sin νt) q + a sin ωt + c cos ωt; q, p at 0; end.
DRIVEN = {
    "sine from rest": ([0.0, 0.0, 0.0, 1000.0, 0.0, 1000.0], [0.0, 0.0], 0.1),
    "cosine from rest": ([1.0, 0.0, 0.0, 0.0, 300.0, 300.0], [0.0, 0.0], 1.0),
    "parametric": ([1.0, 50.0, 40.0, 0.0, 0.0, 0.0], [1.0, 0.0], 2.0),
    "parametric from 0": ([1.0, 50.0, 40.0, 0.0, 0.0, 0.0], [0.0, 1.0], 2.0),
    "weak and fast": ([1.0, 0.0, 0.0, 0.0, 1e-3, 300.0], [1.0, 0.5], 3.0),
}


@pytest.mark.parametrize("name", DRIVEN)
def test_the_default_step_where_time_drives(name: str) -> None:
    """The step is that of the dependence on time, forwards and backwards, in any unit of time."""
    numbers, y0, end = DRIVEN[name]
    k, b, nu, a, c, omega = numbers

    def rates(t: float, y: Any) -> list[float]:
        force = a * np.sin(omega * t) + c * np.cos(omega * t)
        return [y[1], force - (k + b * np.sin(nu * t)) * y[0]]

    for t, units in ((end, (1e-3, 1.0)), (-end, (1e6,))):
        run = solve_ivp(rates, (0, t), y0, "DOP853", rtol=1e-11, atol=1e-12)
        for unit in units:
            problem, scale = gi.Problem("driven", Q_P, [unit, *numbers], field=driven), [1.0, unit]
            sol = gi.solve(problem, np.multiply(scale, y0), t_end=t / unit)
            errors = np.abs(sol.y[-1] / scale - run.y[:, -1]) / np.max(np.abs(run.y), axis=1)
            assert np.max(errors) < 1e-6
            assert sol.steps < 1000


def time_of_force(force: Any, place: float, end: float = 1.0) -> float:
    """Return the characteristic time of q″ = force(place, t) from rest; 1 without the force."""
    known = gi.helper(force)
    problem = second("forced", lambda p, t, y: known(p[0], t), place)
    return time_of(problem, np.zeros(2), end)


@pytest.mark.nojit
def test_the_default_step_of_forces_with_jumps() -> None:
    """A wave of jumps is resolved; one jump, at 0 or later, and kinks there, cost little."""
    for omega in (10.0, 1e9):
        time = time_of_force(lambda w, t: gi.select(gi.sin(w * t + 0.3) > 0.0, 1.0, -1.0), omega)
        assert 0.05 < omega * time < 5.0
    for place in [0.0, *10.0 ** np.arange(-15.0, 1.0, 5.0)]:
        assert 0.03 < time_of_force(lambda s, t: gi.select(t > s, 1.0, 0.0), place) <= 1.0
    for place in (0.0, 1e-9):
        assert time_of_force(lambda s, t: gi.select(t > s, 1.0 + t, 1.0), place) == 1.0
    assert time_of_force(lambda s, t: gi.sqrt(s + t), 0.0) == 1.0
    with pytest.raises(gi.DomainError, match="smooth in time"):
        time_of_force(lambda w, t: gi.sin(w * t), 1e60)

    def early(omega, t):  # what only drives before time 0 shortens steps backwards alone
        return gi.select(t < 0.0, gi.sin(omega * t), 0.0)

    assert time_of_force(early, 1e3) == 1.0
    assert 0.5 < 1e3 * time_of_force(early, 1e3, -1.0) < 2.0


@pytest.mark.nojit
def test_a_rate_without_derivatives_where_the_run_begins() -> None:
    """√(t − t₀) is as smooth from t₀ on as √t from 0; roundings of times are no smoothness."""
    for start in (1.0, -3.0, 1e-3, 1e12):
        problem = first("root", lambda p, t, y: gi.sqrt(t - p[0]), start)
        assert time_of(problem, np.zeros(2), 1.0, start) == 1.0


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
    form = gi.Hamiltonian(pulled, on_axis, 1)
    mass = gi.Problem("pulled", (("q", 2), ("p", 2)), hamiltonian=form)
    for problem, y0, omega in (
        (body, pulsating_body.INITIAL, 1e3),
        (slow, abc_flow.INITIAL, 2.0),
        (mass, np.zeros(4), 1e3),
    ):
        for form in problem.forms:
            others = {other: None for other in problem.forms if other != form}
            assert 0.5 < omega * time_of(dataclasses.replace(problem, **others), y0) < 5.0


def test_a_tiny_state_and_a_dependence_of_ordinary_speed() -> None:
    """The state's own time is 1/size, and the dependence on time is seen beside it."""
    problem, y0 = pulsating_body.problem(), np.asarray(pulsating_body.INITIAL)
    assert 0.1 < time_of(problem, 1e-20 * y0) / time_of(problem, y0) < 10.0


@gi.field
def swing_and_clock(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -gi.sin(y[0])
    out[2] = 1.0 + 0.0 * y[0]


RUNAWAY = first("runaway", lambda p, t, y: 1.0 + y[0] * y[0])
FRICTION = second("friction", lambda p, t, y: 1.0 - 1000.0 * y[1])
SWING = gi.Problem("swing", Q_P_S, field=swing_and_clock)
# A problem, its state with a tiny part e, and between what its characteristic time is.
RESTING = [
    (RUNAWAY, lambda e: [e, 1.0], 0.5, 1.0),
    (SWING, lambda e: [1.2, e, 0.7 * e], 0.5, 1.5),
    (abc_flow.problem(), lambda e: e * np.array(abc_flow.INITIAL), 0.4, 1.2),
    (FRICTION, lambda e: [1.2, e], 2e-4, 2e-3),
]


@pytest.mark.nojit
@pytest.mark.parametrize("tiny", [1e-2, 1e-5, 1e-16, 1e-100, 0.0])
def test_the_default_step_does_not_shrink_with_what_rests(tiny: float) -> None:
    """However small a piece is from which the state sets out; x = tan(t + arctan x(0)) is met."""
    for problem, state, least, most in RESTING:
        assert least < time_of(problem, state(tiny)) <= most
    sol = gi.solve(RUNAWAY, [tiny, 1.0], t_end=1.0)
    assert sol.steps < 100
    assert sol.y[-1, 0] == pytest.approx(np.tan(1.0 + np.arctan(tiny)), rel=1e-9)


FAST = first("fast", lambda p, t, y: -p[0] * y[0] * p[1])


@pytest.mark.nojit
def test_a_step_that_is_too_short() -> None:
    """Is told as what was given, or as the default one."""
    for rates, step, name, said in (
        ([1e30, 1.0], None, "end", "default 3e-32: give a step"),
        ([1e30, 1.0], 1e-30, "step", "step = 1e-30"),
        ([1e300, 1e23], None, "end", "default 0: give a step"),
    ):
        problem = dataclasses.replace(FAST, params=rates)
        with pytest.raises(gi.DomainError, match=said) as caught:
            gi.solve(problem, [1e-15, 1.0], t_end=1.0, method="rk-4", step=step)
        assert caught.value.name == name
