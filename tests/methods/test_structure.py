"""What methods keep: invariants, constraints, symmetry, and the symplectic form on the manifold."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.gauss import gauss_coefficients
from geomint.methods import Start, methods
from geomint.methods.gauss import lane_positions
from geomint.methods.stepper import Stepper
from geomint.problems.testproblems import neumann, pulsating_body, sphere_metric
from geomint.tableaux import COMMUTATOR_FREE, RUNGE_KUTTA
from tests.problems import (
    double_pendulum,
    frame_in_field,
    lotka_volterra,
    so_n_flow,
    spherical_pendulum,
)

EPSILON = 2.0**-52
STEPS = 10**5
WALK = EPSILON * STEPS**0.5


def assert_no_drift(drift: gi.Drift, scale: float) -> None:
    """Errors of the size of a random walk of roundings, and no slope beyond the scatter.

    Not every random walk looks like one, even to a rule that errs in few of a hundred.
    """
    assert drift.max_abs_error <= WALK * scale, drift
    assert drift.drift_class in ("roundoff", "bounded", "sqrt", "undetermined"), drift
    assert drift.slope is not None
    assert drift.slope_stderr is not None
    assert abs(drift.slope) <= 5 * drift.slope_stderr, drift


# --- invariants -----------------------------------------------------------------------------------


@pytest.mark.parametrize("stages", [1, 2, 5, 8, 11, 16])
def test_gauss_keeps_quadratic_invariants(stages: int) -> None:
    """Over 10⁵ steps of a non-autonomous flow; the roundings of coefficients and sums do not add up."""
    h = {1: 0.05, 2: 0.1}.get(stages, 0.2)
    sol = gi.solve(
        pulsating_body.problem(),
        pulsating_body.INITIAL,
        t_end=h * STEPS,
        step=h,
        method=f"gauss-{stages}",
        observe="invariants",
    )
    assert sol.steps == STEPS
    for drift in sol.drift.values():
        assert_no_drift(drift, 2.0)


def test_a_last_bit_of_a_coefficient_matters() -> None:
    """μ_ij + μ_ji = 1 + 2⁻⁵² instead of 1: quadratic invariants drift."""
    problem, y0 = pulsating_body.problem(), pulsating_body.INITIAL
    method = gi.find_method("gauss-3")
    stepper = method.start(Start(problem, y0, 0.0, 0.2))
    at = lane_positions(3, 8)
    layout = gauss_coefficients(problem.rows, 1, 1)
    mu = gi.section(stepper.coefficients, layout, "mu").data.reshape(8, 8)
    assert mu[at[0], at[1]] + mu[at[1], at[0]] == 1.0
    mu[at[0], at[1]] += 2.0**-52

    class Spoiled(gi.Gauss):
        def start(self, s: Start) -> Any:
            return stepper

    sol = gi.solve(
        problem, y0, t_end=0.2 * STEPS, step=0.2, method=Spoiled(3), observe=["direction-squared"]
    )
    assert sol.drift["direction-squared"].drift_class in ("linear", "faster")
    assert sol.drift["direction-squared"].max_abs_error > 2 * WALK


def test_other_methods_drift() -> None:
    """The flow leaves the invariants to the method: an explicit one loses them."""
    problem, y0 = pulsating_body.problem(), pulsating_body.INITIAL
    sol = gi.solve(problem, y0, t_end=2000.0, step=0.1, method="dop853", observe="invariants")
    for drift in sol.drift.values():
        assert drift.drift_class == "linear"
        assert drift.max_abs_error > 1e-12


ACTION_METHODS = [name for name, method in methods().items() if method.needs == "action"]


@pytest.mark.parametrize("name", ACTION_METHODS)
def test_group_methods_keep_orbits(name: str) -> None:
    """Lengths and angles of the vectors that the group turns."""
    sol = gi.solve(
        pulsating_body.problem(),
        pulsating_body.INITIAL,
        t_end=0.05 * STEPS,
        step=0.05,
        method=name,
        observe="invariants",
    )
    for drift in sol.drift.values():
        assert_no_drift(drift, 2.0)


@pytest.mark.parametrize("name", ["cf-4", "cf-3", "cg-3", "rkmk-4", "rkmk-cayley-4"])
def test_group_methods_keep_spectra_and_frames(name: str) -> None:
    """The spectrum of k, gᵀg, and what g carries into space: gγ and gkgᵀ."""
    problem, y0 = so_n_flow.problem(3, frame=True), so_n_flow.initial(3, frame=True)
    steps = 20000
    sol = gi.solve(problem, y0, t_end=0.05 * steps, step=0.05, method=name)
    carried = []
    for y in (y0, sol.y[-1]):
        k = np.zeros((3, 3))
        k[np.triu_indices(3, 1)] = y[:3]
        k -= k.T
        g = y[6:].reshape(3, 3)
        spectrum = np.sort(np.linalg.eigvals(k).imag)
        carried.append(
            np.concatenate([spectrum, (g.T @ g).ravel(), g @ y[3:6], (g @ k @ g.T).ravel()])
        )
    np.testing.assert_allclose(carried[1], carried[0], rtol=0, atol=8 * EPSILON * steps**0.5)
    assert np.max(np.abs(sol.y[-1] - y0)) > 0.1


@pytest.mark.parametrize(
    ("name", "h"),
    [
        pytest.param("rattle-2", 0.02, marks=pytest.mark.nightly),
        pytest.param("rattle-4", 0.05, marks=pytest.mark.nightly),
        ("lobatto-3", 0.05),
        pytest.param("rattle-6", 0.1, marks=pytest.mark.nightly),
    ],
)
def test_rattle_keeps_constraints_and_momenta(name: str, h: float) -> None:
    """Constraints to a few roundings over 10⁵ steps; a quadratic momentum map as a random walk.

    Of the two in the fast row either takes two of the problems.
    """
    metric, frame = sphere_metric.problem(5, pulse=0.0), frame_in_field.problem(season=0.0)
    every = [
        (frame, frame_in_field.initial(frame)),
        (double_pendulum.problem(), double_pendulum.INITIAL),
        (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
        (metric, sphere_metric.initial(metric)),
    ]
    for problem, y0 in {"rattle-4": every[::3], "lobatto-3": every[1:3]}.get(name, every):
        names = [*problem.invariants, *problem.constraints]
        sol = gi.solve(problem, y0, t_end=h * STEPS, step=h, method=name, observe=names)
        # Between two moving points, of scale 5.2, all stages of a pair leave a little more.
        bound = (16 if name.startswith("lobatto") else 8) * EPSILON
        for quantity in problem.constraints:
            assert sol.drift[quantity].max_abs_error <= bound, sol.drift[quantity]
        if "angular-momentum" in problem.invariants:
            assert_no_drift(sol.drift["angular-momentum"], 1.0)
            irregular = problem is frame  # noise to the rule: a small trend is not excluded
            kinds = ("bounded", "undetermined") if irregular else ("bounded",)
            assert sol.drift["energy"].drift_class in kinds
            assert sol.drift["energy"].max_abs_error < 2e-4


# --- abelian groups -------------------------------------------------------------------------------


@gi.field
def turning(params, t, y, out, work):
    out[0] = params[0] * gi.cos(t) + y[0] * (1.0 + y[1]) + params[1] * y[1]


@gi.field
def turning_angle(params, t, y, out, work):
    c, s = gi.cos(y[0]), gi.sin(y[0])
    # The triangle element ξ turns against the angle: v̇ = (ξ v₂, −ξ v₁).
    out[0] = -(params[0] * gi.cos(t) + c * (1.0 + s) + params[1] * s)


PLANE = gi.Problem(
    "plane",
    (("v", 10),),  # five times the same: more than 8 rows have the stepper of all groups SO(n)
    [0.7, -0.4],
    action=gi.GroupAction(turning, gi.so_n(2, *["vector"] * 5)),
)
ANGLE = gi.Problem("angle", (("angle", 1),), [0.7, -0.4], field=turning_angle)


EXPONENTIAL = [n for n in ACTION_METHODS if "cayley" not in n and not gi.find_method(n).adaptive]


@pytest.mark.parametrize("name", EXPONENTIAL)
def test_on_an_abelian_group_they_are_runge_kutta_methods(name: str) -> None:
    """SO(2): all commutators vanish, exponents add; the angle is what the tableau makes of it."""
    if name in COMMUTATOR_FREE:
        classical = gi.RungeKutta(COMMUTATOR_FREE[name].classical)
    else:
        table = "rk-4" if name == "rkmk-4" else name.removeprefix("rkmk-")
        classical = gi.RungeKutta(RUNGE_KUTTA[table])
    y0 = [1.0, 0.0] * 5
    on_group = gi.solve(PLANE, y0, t_end=5.0, step=0.1, method=name, save_every=1)
    angles = gi.solve(ANGLE, [0.0], t_end=5.0, step=0.1, method=classical, save_every=1).y[:, 0]
    expected = np.tile(np.stack([np.cos(angles), np.sin(angles)], axis=1), 5)
    assert np.ptp(angles) > 1.0
    np.testing.assert_allclose(on_group.y, expected, rtol=0, atol=2e-14)


# --- symmetry -------------------------------------------------------------------------------------

SYMMETRIC = [
    *(name for name, method in methods().items() if method.symmetric),
    "gauss-1-kahan-li-6",
    "gauss-1-triple-jump-4",
    "rattle-yoshida-6",
    "verlet-yoshida-6",
]


@cache
def symmetric_problem(form: str) -> tuple[gi.Problem, np.ndarray]:
    metric = sphere_metric.problem()
    return {
        "field": (lotka_volterra.problem(), lotka_volterra.INITIAL),
        "hamiltonian": (metric, sphere_metric.initial(metric)),
        "splitting": (neumann.problem(season=0.4), neumann.initial()),
    }[form]


def there_and_back(name: str, h: float = 0.2) -> float:
    """The distance from the start after a step forth and a step back."""
    method = gi.find_method(name)
    problem, y0 = symmetric_problem(method.needs)
    forth = method.start(Start(problem, y0, 0.0, h))
    y1 = forth.single_step(y0, 0.0, h)
    back = forth.single_step(y1, h, -h)
    assert np.max(np.abs(y1 - y0)) > 0.05
    return float(np.max(np.abs(back - y0)))


@pytest.mark.parametrize("name", SYMMETRIC)
def test_symmetric_methods_go_back(name: str) -> None:
    """Ψ₋ₕ ∘ Ψₕ is the identity, to rounding."""
    assert there_and_back(name) <= 16 * EPSILON


@pytest.mark.parametrize(
    "name", [n for n, m in methods().items() if not m.symmetric and m.needs == "field"]
)
def test_others_do_not(name: str) -> None:
    """The test can tell."""
    assert there_and_back(name) > 5e-13


# --- symplecticity --------------------------------------------------------------------------------


def hamiltonian_functions(
    problem: gi.Problem,
) -> tuple[Callable[..., np.ndarray], Callable[..., tuple[np.ndarray, np.ndarray]]]:
    """∂H/∂p(t, q, p) and (g, G)(q), in plain Python."""
    form = problem.hamiltonian
    n = problem.rows // 2
    params, work = Block(problem.params), Block(np.zeros(problem.work))

    def velocity(t: float, q: np.ndarray, p: np.ndarray) -> np.ndarray:
        dq, dp = Block(np.zeros(n)), Block(np.zeros(n))
        form.gradients(params, np.float64(t), Block(q), Block(p), dq, dp, work)
        return dp.data

    def constraint(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        g, G = Block(np.zeros(form.constraints)), Block(np.zeros(form.constraints * n))
        form.constraint(params, Block(q), g, G, work)
        return g.data, G.data.reshape(-1, n)

    return velocity, constraint


def retract(problem: gi.Problem, y: np.ndarray) -> np.ndarray:
    """A smooth projection on the manifold {g = 0, G ∂H/∂p = 0} at time 0."""
    velocity, constraint = hamiltonian_functions(problem)
    n = problem.rows // 2
    q, p = y[:n].copy(), y[n:].copy()
    for _ in range(30):
        g, G = constraint(q)
        q -= G.T @ np.linalg.solve(G @ G.T, g)
    _, G = constraint(q)
    for _ in range(3):
        v = velocity(0.0, q, p)
        response = np.array([velocity(0.0, q, p + row) - v for row in G])
        p -= G.T @ np.linalg.solve(G @ response.T, G @ v)
    return np.concatenate([q, p])


# Central differences of order 8.
NODES = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SPACING = 4e-3


def derivative(f: Callable[[float], np.ndarray]) -> np.ndarray:
    """f′(0), to about 1e-14."""
    values = [w * f(k * SPACING) for k, w in zip(NODES, WEIGHTS, strict=True)]
    return np.sum(values, axis=0) / SPACING


def tangent_basis(problem: gi.Problem, y: np.ndarray) -> np.ndarray:
    """Columns that span the tangent space at a point of the manifold."""
    columns = [derivative(lambda s, e=e: retract(problem, y + s * e)) for e in np.eye(len(y))]
    u, singular, _ = np.linalg.svd(np.array(columns).T)
    dimension = problem.rows - 2 * problem.hamiltonian.constraints
    assert singular[dimension - 1] > 1e-3 > 1e-9 > singular[dimension]
    return u[:, :dimension]


def symplectic_form(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """ω(u_i, v_j) of the columns."""
    n = len(u) // 2
    return u[:n].T @ v[n:] - u[n:].T @ v[:n]


def symplectic_defect(
    problem: gi.Problem, y0: np.ndarray, stepper: Stepper, h: float, steps: int
) -> float:
    """max |ω(DΦ u, DΦ v) − ω(u, v)| over tangent vectors, Φ the map of some steps from time 0."""
    y0 = retract(problem, y0)

    def phi(y: np.ndarray) -> np.ndarray:
        run = stepper.restarted(y, 0.0, h)
        result = run.advance(0, steps, steps, Block(np.zeros(run.rows)))
        assert result.status == 0
        return run.state + run.carry

    basis = tangent_basis(problem, y0)
    images = np.array(
        [derivative(lambda s, u=u: phi(retract(problem, y0 + s * u))) for u in basis.T]
    ).T
    before = np.array([derivative(lambda s, u=u: retract(problem, y0 + s * u)) for u in basis.T]).T
    np.testing.assert_allclose(before, basis, rtol=0, atol=1e-12)
    omega = symplectic_form(basis, basis)
    assert np.linalg.cond(omega) < 1e3
    assert np.max(np.abs(images - basis)) > 0.1
    return float(np.max(np.abs(symplectic_form(images, images) - omega)))


def hamiltonized(n: int) -> tuple[gi.Problem, np.ndarray]:
    ball = ch.ChaplyginSphere(a=np.linspace(0.8, 1.5, n), D=4.0)
    problem = ball.hamiltonized()
    gamma = np.cos(np.arange(n) + 0.5)
    gamma /= np.linalg.norm(gamma)
    p = 0.5 * np.sin(1.3 * np.arange(n) + 0.2)
    return problem, problem.state(gamma=gamma, p_tilde=p - gamma * (gamma @ p))


def metric(n: int) -> tuple[gi.Problem, np.ndarray]:
    problem = sphere_metric.problem(n)
    return problem, sphere_metric.initial(problem)


def frame(problem: gi.Problem) -> tuple[gi.Problem, np.ndarray]:
    return problem, frame_in_field.initial(problem)


ON_MANIFOLDS = {
    "sphere-metric-3": lambda: metric(3),
    "sphere-metric-5": lambda: metric(5),
    "hamiltonized-3": lambda: hamiltonized(3),
    "hamiltonized-5": lambda: hamiltonized(5),
    "double-pendulum": lambda: (double_pendulum.problem(), double_pendulum.INITIAL),
    "frame-in-field": lambda: frame(frame_in_field.problem()),
    "neumann-3": lambda: (neumann.problem(season=0.4), neumann.initial()),
    "neumann-5": lambda: (neumann.problem((2.0, 0.3, 1.1, 2.7, 0.8)), neumann.initial(5)),
}


COMPOSED = ("sphere-metric-5", "double-pendulum")
SPLIT = ("hamiltonized-3", "hamiltonized-5", "neumann-3", "neumann-5")
SYMPLECTIC = [  # what has the kernel of another method, on some of its problems
    *((case, "rattle-2") for case in ON_MANIFOLDS),
    *((case, "lobatto-3") for case in ON_MANIFOLDS if case[-1] != "5"),
    *((case, "verlet-2") for case in SPLIT),
    *((case, name) for name in ("rattle-4", "rattle-6") for case in COMPOSED),
    *((case, "lobatto-8") for case in COMPOSED),
    ("neumann-3", "verlet-6"),
]


@pytest.mark.parametrize(("case", "name"), SYMPLECTIC)
def test_methods_are_symplectic_on_the_manifold(case: str, name: str) -> None:
    """Five steps, on the tangent space of T*S^(n−1), also with a metric that changes in time."""
    problem, y0 = ON_MANIFOLDS[case]()
    h = 0.1
    stepper = gi.find_method(name).start(Start(problem, y0, 0.0, h))
    assert symplectic_defect(problem, y0, stepper, h, 5) <= 1e-12


def test_a_method_that_is_not_symplectic_is_noticed() -> None:
    """An explicit method at the same step; Gauss methods of the ODE are not on T*S either."""
    problem, y0 = metric(3)
    for name, size in (("rk-4", 1e-7), ("gauss-1", 1e-6)):
        stepper = gi.find_method(name).start(Start(problem, y0, 0.0, 0.1))
        assert symplectic_defect(problem, y0, stepper, 0.1, 5) > size


def test_gauss_methods_are_not_symplectic_on_the_manifold() -> None:
    """The defect of the Hamiltonised flow is of order h^(2s+1) a step, and no plan says symplectic."""
    problem, y0 = hamiltonized(3)
    method = gi.find_method("gauss-1")
    coarse, fine = (
        symplectic_defect(problem, y0, method.start(Start(problem, y0, 0.0, h)), h, steps)
        for h, steps in ((0.1, 5), (0.05, 10))
    )
    assert coarse > 1e-3
    assert math.log2(coarse / fine) == pytest.approx(2.0, abs=0.2)  # of a time, one order less
    assert method.structure(problem) == "symmetric"
    for name in ("rattle-2", "verlet-2"):
        assert gi.find_method(name).structure(problem) == "symmetric and symplectic"


def test_the_naive_hamiltonian_has_another_constraint() -> None:
    """RATTLE's hidden constraint is (q, ∂H/∂p) = 0; the metric problem's is not (q, p) = 0."""
    problem, y0 = metric(3)
    sol = gi.solve(problem, y0, t_end=1.0, step=0.05, method="rattle-2", observe="constraints")
    q, p = sol.y[-1][:3], sol.y[-1][3:]
    assert abs(q @ p) > 1e-3
    assert sol.drift["tangency"].max_abs_error < 8 * EPSILON
