"""Lobatto IIIA–IIIB: accepted steps are solved, long runs end, functions of any kind are taken."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.methods.lobatto import lane_positions
from geomint.problems.testproblems import neumann, sphere_metric
from tests.methods.textbook import constraint, gradients, lobatto_tables
from tests.problems import double_pendulum, frame_in_field, spherical_pendulum

EPSILON = 2.0**-52
METRIC, FRAME = sphere_metric.problem(), frame_in_field.problem()
BALL = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
UP = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)
README = BALL.state(gamma=UP, p=np.cross(UP, [2.0, 1.0, -3.0]))
CASES = {
    "one constraint": (spherical_pendulum.problem(), spherical_pendulum.INITIAL, 0.1),
    "two": (double_pendulum.problem(), double_pendulum.INITIAL, 0.05),
    "three": (FRAME, frame_in_field.initial(FRAME), 0.1),
    "depending on time": (METRIC, sphere_metric.initial(METRIC), 0.1),
    "at rest": (neumann.problem(), neumann.initial() * [1, 1, 1, 0, 0, 0], 0.1),
    "tiny step": (BALL, BALL.random_state(3), 1e-9),
    "backwards": (BALL, BALL.random_state(3), -0.2),
    "tiny momentum": (BALL, BALL.random_state(3) * [1, 1, 1, 1e-150, 1e-150, 1e-150], 0.2),
}


@pytest.mark.parametrize(
    "stages",
    [pytest.param(s, marks=[pytest.mark.nightly] * (s not in (3, 8))) for s in range(3, 9)],
)
@pytest.mark.parametrize("case", CASES)
def test_an_accepted_step_is_solved(case: str, stages: int) -> None:
    """The equations evaluated again from what memory holds of stages, the multipliers left free."""
    problem, y0, h = CASES[case]
    t0, name = 0.3, f"lobatto-{stages}"
    motion = gi.Integrator(problem, y0, name, step=abs(h), time=t0, compiled=False)
    motion.h = h
    motion.step()
    n, m = problem.rows // 2, problem.hamiltonian.constraints
    lanes = motion.stepper.memory.data[-8 * (2 * n + m) : -8 * m].reshape(2, n, 8)
    K, L = lanes[:, :, lane_positions(stages)].transpose(0, 2, 1)
    c, a, hat = lobatto_tables(stages)
    b = a[-1]
    q, p = y0[:n], y0[n:]
    Q, P = q + (a / b) @ K, p + (hat / b) @ L
    sizes = [max(np.abs(x).max(), np.abs(d).max()) for x, d in ((q, K), (p, L))]
    amplified = 64 * EPSILON * max(1.0, 40 * sizes[0] / (abs(h) * max(sizes[1], 1e-300)))
    for i in range(stages):
        (dq, dp), (g, G) = gradients(problem, t0 + c[i] * h, Q[i], P[i]), constraint(problem, Q[i])
        scale = np.abs(h * b[i]) * np.abs(dp).max()
        assert np.abs(K[i] - h * b[i] * dp).max() <= 64 * EPSILON * (sizes[0] + scale)
        normal = np.linalg.lstsq(G.T, L[i] + h * b[i] * dq, rcond=None)[0]
        left = L[i] + h * b[i] * dq - G.T @ normal
        assert np.abs(left).max() <= min(amplified, 1e-6) * sizes[1]
        assert np.abs(g).max() <= 64 * EPSILON * np.abs(G).max() * sizes[0]
    y = motion.state
    np.testing.assert_allclose(y[:n], Q[-1], rtol=0, atol=8 * EPSILON * sizes[0])
    np.testing.assert_allclose(y[n:], p + L.sum(axis=0), rtol=0, atol=16 * EPSILON * sizes[1])
    dp, (_, G) = gradients(problem, t0 + h, y[:n], y[n:])[1], constraint(problem, y[:n])
    assert np.abs(G @ dp).max() <= 64 * EPSILON * np.abs(G).max() * max(np.abs(dp).max(), 1e-300)


@pytest.mark.parametrize("end", [4.0, pytest.param(5_000.0, marks=pytest.mark.nightly)])
def test_a_long_run_ends(end: float) -> None:
    """Steps as long as they can be: the rounding of constraints is not iterated for ever."""
    run = {"step": 0.25, "method": "lobatto-8", "observe": ["energy", "constraints"]}
    sol = gi.solve(BALL, README, tau_end=end, clock=False, compiled=end > 100.0, **run)
    assert sol.drift["norm"].max_abs_error <= 8 * EPSILON
    assert sol.drift["tangency"].max_abs_error <= 8 * EPSILON
    assert sol.drift["energy"].max_abs_error < 2e-12


def test_order_of_the_clock() -> None:
    """Physical time has the order of the method, as the state has."""
    run = {"tau_end": 2.0, "compiled": False}
    truth = gi.solve(BALL, README, step=0.2, method="gauss-8", **run)
    cases = ("lobatto-8", 0.1, 2e-13), ("lobatto-4", 0.2, 1e-4), ("lobatto-4", 0.1, 2e-6)
    late = []
    for name, step, error in cases:
        sol = gi.solve(BALL, README, step=step, method=name, **run)
        np.testing.assert_allclose(sol.y[-1], truth.y[-1], rtol=0, atol=error)
        late.append(abs(sol.t[-1] - truth.t[-1]))
    assert late[0] < 2e-13
    assert math.log2(late[1] / late[2]) == pytest.approx(6.0, abs=0.35)


def branching(slopes: Any) -> Any:
    """Gradients with a choice that eight numbers cannot make at once."""

    @gi.field
    def one(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
        slopes(params, t, q, p, dq, dp, work)
        if q[0] > 2.0:
            dq[0] = dq[0] + 1.0

    return one


def test_functions_that_take_one_number_at_a_time() -> None:
    """The same states, with a warning, compiled and not."""
    problem, y0, step = CASES["two"]
    slopes = branching(problem.hamiltonian.gradients)
    form = dataclasses.replace(problem.hamiltonian, gradients=slopes)
    slow = dataclasses.replace(problem, hamiltonian=form)
    given = {"t_end": 3 * step, "step": step, "method": "lobatto-3"}
    expected = gi.solve(problem, y0, **given)
    with pytest.warns(gi.GeomintWarning, match="takes one number at a time"):
        found = gi.solve(slow, y0, **given)
    for run in (found, gi.solve(slow, y0, **given, compiled=False)):
        np.testing.assert_array_equal(run.y, expected.y)


def test_failures_say_where() -> None:
    """Too large a step, the cap, and functions that are not finite."""
    with pytest.raises(gi.ConvergenceError, match=r"t = 0 .*too large") as caught:
        gi.solve(BALL, README, tau_end=90.0, step=9.0, method="lobatto-8", compiled=False)
    assert (caught.value.step, caught.value.t) == (0, 0.0)
    assert caught.value.residual > 0.0
    run = {"tau_end": 1.0, "step": 0.2, "compiled": False}
    with pytest.raises(gi.ConvergenceError) as caught:
        gi.solve(BALL, README, method=gi.Lobatto(4, max_iterations=3), **run)
    assert caught.value.iterations == 3
    with pytest.raises(gi.NonFiniteError):
        gi.solve(BALL, README * [1, 1, 1, 1e200, 1e200, 1e200], method="lobatto-8", **run)
