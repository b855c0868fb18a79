"""Lobatto IIIA–IIIB: accepted steps are solved, long runs end, functions of any kind are taken."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from numpy.polynomial import legendre

import chaplygin as ch
import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.lobatto import lobatto_memory
from geomint.methods import Start
from geomint.methods.lobatto import lane_positions
from geomint.problems.testproblems import neumann, sphere_metric
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
    "ball": (BALL, BALL.random_state(3), 0.2),
    "tiny step": (BALL, BALL.random_state(3), 1e-9),
    "backwards": (BALL, BALL.random_state(3), -0.2),
    "tiny momentum": (BALL, BALL.random_state(3) * [1, 1, 1, 1e-150, 1e-150, 1e-150], 0.2),
}


@functools.cache
def tables(s: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """c, a and â in 40 digits: nodes by Legendre's polynomial, a by collocation on powers."""
    with mp.workdps(40):
        rough = legendre.legroots(legendre.legder([0.0] * (s - 1) + [1.0]))

        def slope(x: Any) -> Any:
            return mp.diff(lambda z: mp.legendre(s - 1, z), x)

        x = [mp.mpf(-1), *(mp.findroot(slope, z) for z in np.sort(rough)), mp.mpf(1)]
        c = [(1 + z) / 2 for z in x]
        powers = mp.matrix([[z**k for z in c] for k in range(s)])
        rows = [mp.lu_solve(powers, [z ** (k + 1) / (k + 1) for k in range(s)]) for z in c]
        a = np.array([[row[j] for j in range(s)] for row in rows])
        b = a[-1]
        return tuple(np.array(x, dtype=float) for x in (c, a, b - b * a.T / b[:, None]))


def functions(problem: gi.Problem, t: float, q: np.ndarray, p: np.ndarray) -> tuple[Any, ...]:
    """H_q, H_p, g, G in plain Python."""
    form, n = problem.hamiltonian, len(q)
    dq, dp, g, G = (Block(np.zeros(k)) for k in (n, n, form.constraints, form.constraints * n))
    given, work = Block(problem.params), Block(np.zeros(problem.work))
    form.gradients(given, t, Block(q), Block(p), dq, dp, work)
    form.constraint(given, Block(q), g, G, work)
    return dq.data, dp.data, g.data, G.data.reshape(-1, n)


@pytest.mark.parametrize("stages", range(3, 9))
@pytest.mark.parametrize("case", CASES)
def test_an_accepted_step_is_solved(case: str, stages: int) -> None:
    """The equations evaluated again from what memory holds of stages, the multipliers left free."""
    problem, y0, h = CASES[case]
    t0 = 0.3
    stepper = gi.find_method(f"lobatto-{stages}").start(Start(problem, y0, t0, h, compiled=False))
    assert stepper.advance(0, 1, 2, Block(np.zeros(0))).status == 0
    n, m = problem.rows // 2, problem.hamiltonian.constraints
    layout, at = lobatto_memory(n, m, 0), lane_positions(stages)
    K, L = (gi.section(stepper.memory, layout, x).data.reshape(n, 8)[:, at].T for x in "KL")
    c, a, hat = tables(stages)
    b = a[-1]
    q, p = y0[:n], y0[n:]
    Q, P = q + (a / b) @ K, p + (hat / b) @ L
    sizes = [max(np.abs(x).max(), np.abs(d).max()) for x, d in ((q, K), (p, L))]
    amplified = 64 * EPSILON * max(1.0, 40 * sizes[0] / (abs(h) * max(sizes[1], 1e-300)))
    for i in range(stages):
        dq, dp, g, G = functions(problem, t0 + c[i] * h, Q[i], P[i])
        scale = np.abs(h * b[i]) * np.abs(dp).max()
        assert np.abs(K[i] - h * b[i] * dp).max() <= 64 * EPSILON * (sizes[0] + scale)
        normal = np.linalg.lstsq(G.T, L[i] + h * b[i] * dq, rcond=None)[0]
        left = L[i] + h * b[i] * dq - G.T @ normal
        assert np.abs(left).max() <= min(amplified, 1e-6) * sizes[1]
        assert np.abs(g).max() <= 64 * EPSILON * np.abs(G).max() * sizes[0]
    y = stepper.state
    np.testing.assert_allclose(y[:n], Q[-1], rtol=0, atol=8 * EPSILON * sizes[0])
    np.testing.assert_allclose(y[n:], p + L.sum(axis=0), rtol=0, atol=16 * EPSILON * sizes[1])
    _, dp, _, G = functions(problem, t0 + h, y[:n], y[n:])
    assert np.abs(G @ dp).max() <= 64 * EPSILON * np.abs(G).max() * max(np.abs(dp).max(), 1e-300)


@pytest.mark.parametrize("stages", [3, 8])
def test_a_sphere_at_rest_stays_at_rest(stages: int) -> None:
    for seed in range(20):
        y = BALL.random_state(seed) * [1, 1, 1, 0, 0, 0]
        stepper = gi.find_method(f"lobatto-{stages}").start(
            Start(BALL, y, 0.0, 0.01, compiled=False)
        )
        assert stepper.advance(0, 10, 12, Block(np.zeros(0))).iterations <= 20
        np.testing.assert_array_equal(stepper.state, y)


def test_a_long_run_ends() -> None:
    """10⁵ steps as long as they can be: the rounding of constraints is not iterated for ever."""
    sol = gi.solve(
        BALL, README, tau_end=25_000, step=0.25, method="lobatto-8",
        observe=["energy", "K", "constraints"], save_every=10**5,
    )  # fmt: skip
    assert sol.drift["norm"].max_abs_error <= 8 * EPSILON
    assert sol.drift["tangency"].max_abs_error <= 8 * EPSILON
    assert sol.drift["energy"].max_abs_error < 2e-12


def test_the_exact_flow() -> None:
    """To the exact flow of the Hamiltonised sphere, clock and all."""
    exact = BALL.exact(README)
    for name, step, error in (("lobatto-8", 0.1, 2e-12), ("lobatto-5", 0.05, 1e-9)):
        sol = gi.solve(BALL, README, tau_end=20.0, step=step, method=name)
        np.testing.assert_allclose(sol.y[-1], np.ravel(exact.at_tau(20.0))[:6], rtol=0, atol=error)
        fine = gi.solve(BALL, README, tau_end=20.0, step=0.05, method="gauss-16")
        assert sol.t[-1] == pytest.approx(fine.t[-1], abs=error)


@pytest.mark.parametrize("stages", [3, 4, 5])
def test_order_of_the_clock(stages: int) -> None:
    """Physical time has the order of the method."""
    fine = gi.solve(BALL, README, tau_end=2.0, step=0.02, method="gauss-16").t[-1]
    errors = [
        abs(gi.solve(BALL, README, tau_end=2.0, step=2.0 / k, method=f"lobatto-{stages}").t[-1] - fine)
        for k in (16, 32)
    ]  # fmt: skip
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2 * stages - 2, abs=0.35)


def branching(slopes: Any) -> Any:
    """Gradients with a choice that eight numbers cannot make at once."""

    @gi.field
    def one(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
        slopes(params, t, q, p, dq, dp, work)
        if q[0] > 2.0:
            dq[0] = dq[0] + 1.0

    return one


def test_functions_that_take_one_number_at_a_time() -> None:
    """The same states, with a warning, compiled and not; with a clock, too."""
    for problem, y0, end in (
        (spherical_pendulum.problem(), spherical_pendulum.INITIAL, {"t_end": 1.0}),
        (BALL, README, {"tau_end": 1.0}),
    ):
        form = dataclasses.replace(
            problem.hamiltonian, gradients=branching(problem.hamiltonian.gradients)
        )
        slow = dataclasses.replace(problem, hamiltonian=form)
        given = {**end, "step": 0.1, "method": "lobatto-4"}
        expected = gi.solve(problem, y0, **given)
        with pytest.warns(gi.GeomintWarning, match="takes one number at a time"):
            found = gi.solve(slow, y0, **given)
        np.testing.assert_array_equal(found.y, expected.y)
        np.testing.assert_array_equal(found.t, expected.t)
        plain = gi.solve(slow, y0, **given, compiled=False)
        np.testing.assert_array_equal(plain.y, expected.y)


def test_failures_say_where() -> None:
    """Too large a step, the cap, and functions that are not finite."""
    with pytest.raises(gi.ConvergenceError, match=r"t = 0 .*too large") as caught:
        gi.solve(BALL, README, tau_end=90.0, step=9.0, method="lobatto-8")
    assert (caught.value.step, caught.value.t) == (0, 0.0)
    assert caught.value.residual > 0.0
    with pytest.raises(gi.ConvergenceError) as caught:
        gi.solve(BALL, README, tau_end=1.0, step=0.2, method=gi.Lobatto(4, max_iterations=3))
    assert caught.value.iterations == 3
    with pytest.raises(gi.NonFiniteError):
        gi.solve(
            BALL, README * [1, 1, 1, 1e200, 1e200, 1e200], tau_end=1.0, step=0.2, method="lobatto-8"
        )


def test_tolerance() -> None:
    """Fewer iterations, an error of its size."""
    given = {"tau_end": 5.0, "step": 0.1}
    full = gi.solve(BALL, README, method=gi.Lobatto(8), **given)
    rough = gi.solve(BALL, README, method=gi.Lobatto(8, iteration_tolerance=1e-8), **given)
    assert rough.iterations < 0.75 * full.iterations
    assert 1e-14 < np.abs(rough.y[-1] - full.y[-1]).max() < 1e-6
