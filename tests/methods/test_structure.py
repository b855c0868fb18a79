"""What methods keep: invariants, constraints, symmetry, and the symplectic form on the manifold."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import neumann, pulsating_body, sphere_metric
from tests.methods.textbook import constraint, gradients
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
METHODS = {name: gi.find_method(name) for name in gi.method_names()}


def late(cases: Iterable[Any], fast: Iterable[Any]) -> list[Any]:
    """Parameters, of which some run in the fast row, the others at night."""
    few = list(fast)
    night = pytest.mark.nightly
    return [
        pytest.param(*(c if isinstance(c, tuple) else (c,)), marks=[night] * (c not in few))
        for c in cases
    ]


def assert_no_drift(drift: gi.Drift, scale: float) -> None:
    """Errors of the size of a random walk of roundings, and no slope beyond the scatter.

    Not every random walk looks like one, even to a rule that errs in few of a hundred.
    """
    assert drift.max_abs_error <= WALK * scale, drift
    assert drift.drift_class in ("roundoff", "bounded", "sqrt", "undetermined"), drift
    assert abs(drift.slope) <= 5 * drift.slope_stderr, drift


# --- invariants -----------------------------------------------------------------------------------

ON_ORBITS = [n for n, m in METHODS.items() if m.needs == "action"]
QUADRATIC = [f"gauss-{s}" for s in (1, 2, 5, 8, 11, 16)]


@pytest.mark.parametrize(
    "name",
    late(
        QUADRATIC + ON_ORBITS,
        [*("gauss-1", "gauss-8", "gauss-11", "cf-4"), *("rkmk-4", "rkmk-cayley-4"), ON_ORBITS[-1]],
    ),
)
def test_quadratic_invariants_are_kept(name: str) -> None:
    """Over 10⁵ steps of a non-autonomous flow; the roundings of coefficients and sums do not add up.

    By Gauss methods all of them, by those of groups lengths and angles of the vectors that turn.
    """
    h = {"gauss-1": 0.05, "gauss-2": 0.1}.get(name, 0.2 if "gauss" in name else 0.05)
    run = {"t_end": h * STEPS, "step": h, "method": name, "observe": "invariants"}
    sol = gi.solve(pulsating_body.problem(), pulsating_body.INITIAL, **run)
    assert sol.steps == STEPS or METHODS[name].adaptive
    for drift in sol.drift.values():
        assert_no_drift(drift, 2.0)


@pytest.mark.parametrize(
    "name", late(("cf-4", "cf-3", "cg-3", "rkmk-4", "rkmk-cayley-4"), ("cf-3",))
)
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


METRIC = sphere_metric.problem(5, pulse=0.0)
FRAME = frame_in_field.problem(season=0.0)
CONSTRAINED = {
    "metric-5": (METRIC, sphere_metric.initial(METRIC)),
    "frame": (FRAME, frame_in_field.initial(FRAME)),
    "double": (double_pendulum.problem(), double_pendulum.INITIAL),
    "pendulum": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "neumann-5": (neumann.problem((0.5, 0.9, 1.4, 2.0, 2.7)), neumann.initial(5)),
}
KEPT = [
    *((name, h, case) for name, h in (("rattle-2", 0.02), ("rattle-4", 0.05), ("rattle-6", 0.1),
      ("lobatto-3", 0.05)) for case in CONSTRAINED if case != "neumann-5"),
    *((name, h, case) for name, h in (("verlet-2", 0.02), ("verlet-4", 0.1))
      for case in ("pendulum", "neumann-5")),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "h", "case"),
    late(KEPT, [("lobatto-3", 0.05, "double"), ("rattle-2", 0.02, "pendulum"), KEPT[-4]]),
)
def test_constraints_and_momenta_are_kept(name: str, h: float, case: str) -> None:
    """Constraints to a few roundings over 10⁵ steps; a quadratic momentum map as a random walk."""
    problem, y0 = CONSTRAINED[case]
    names = [*problem.invariants, *problem.constraints]
    drifts = gi.solve(problem, y0, t_end=h * STEPS, step=h, method=name, observe=names).drift
    # Between two moving points, of scale 5.2, all stages of a pair leave a little more.
    bound = (16 if name.startswith("lobatto") else 8) * EPSILON
    for quantity in problem.constraints:
        assert drifts[quantity].max_abs_error <= bound, drifts[quantity]
    for quantity in problem.invariants:
        if quantity == "angular-momentum":  # kicks and great circles keep it, too
            assert_no_drift(drifts[quantity], 1.0)
        elif case != "metric-5":
            # To the rule a frame's energy is noise: a small trend is not excluded.
            kinds = ("bounded", "undetermined") if case == "frame" else ("bounded",)
            assert drifts[quantity].drift_class in kinds
            assert drifts[quantity].max_abs_error < (1e-3 if "verlet" in name else 2e-4)


# --- symmetry -------------------------------------------------------------------------------------

COMPOSED = ("gauss-1-kahan-li-6", "gauss-1-triple-jump-4", "rattle-yoshida-6", "verlet-yoshida-6")


@pytest.mark.parametrize(
    "name",
    [
        *(n for n, m in METHODS.items() if m.symmetric or (m.needs == "field" and not m.adaptive)),
        *COMPOSED,
    ],
)
def test_symmetric_methods_go_back_and_no_others(name: str) -> None:
    """Ψ₋ₕ ∘ Ψₕ is the identity, to rounding."""
    method, metric = gi.find_method(name), sphere_metric.problem()
    problem, y0 = {
        "field": (lotka_volterra.problem(), lotka_volterra.INITIAL),
        "hamiltonian": (metric, sphere_metric.initial(metric)),
        "splitting": (neumann.problem(season=0.4), neumann.initial()),
    }[method.needs]
    motion = gi.Integrator(problem, y0, method, step=0.2, compiled=False)
    motion.step()
    assert np.max(np.abs(motion.state - y0)) > 0.05
    motion.h = -0.2
    motion.step()
    back = np.max(np.abs(motion.state - y0))
    assert back <= 16 * EPSILON if method.symmetric else back > 5e-13


# --- symplecticity --------------------------------------------------------------------------------


def retract(problem: gi.Problem, y: np.ndarray) -> np.ndarray:
    """A smooth projection on the manifold {g = 0, G ∂H/∂p = 0} at time 0."""
    n = problem.rows // 2
    q, p = y[:n].copy(), y[n:].copy()
    for _ in range(30):
        g, G = constraint(problem, q)
        q -= G.T @ np.linalg.solve(G @ G.T, g)
        if np.max(np.abs(g)) < 1e-15:
            break
    _, G = constraint(problem, q)
    for _ in range(3):
        v = gradients(problem, 0.0, q, p)[1]
        response = np.array([gradients(problem, 0.0, q, p + row)[1] - v for row in G])
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


def symplectic_form(u: np.ndarray) -> np.ndarray:
    """ω(u_i, u_j) of the columns."""
    n = len(u) // 2
    return u[:n].T @ u[n:] - u[n:].T @ u[:n]


def symplectic_defect(
    case: tuple[gi.Problem, np.ndarray], name: str, h: float, steps: int, compiled: bool = False
) -> float:
    """max |ω(DΦ u, DΦ v) − ω(u, v)| over tangent vectors, Φ the map of some steps from time 0."""
    problem, y0 = case[0], retract(*case)
    motion = gi.Integrator(problem, y0, name, step=h, compiled=compiled)

    def phi(y: np.ndarray) -> np.ndarray:
        run = motion.stepper.restarted(y, 0.0, h)
        assert run.advance(0, steps, steps + 1, type(run.memory)(np.zeros(0))).status == 0
        return run.state + run.carry

    columns = [derivative(lambda s, e=e: retract(problem, y0 + s * e)) for e in np.eye(len(y0))]
    u, singular, _ = np.linalg.svd(np.array(columns).T)
    dimension = problem.rows - 2 * problem.hamiltonian.constraints
    assert singular[dimension - 1] > 1e-3 > 1e-9 > singular[dimension]
    basis = u[:, :dimension]
    images = np.array(
        [derivative(lambda s, u=u: phi(retract(problem, y0 + s * u))) for u in basis.T]
    ).T
    omega = symplectic_form(basis)
    assert np.linalg.cond(omega) < 1e3
    assert np.max(np.abs(images - basis)) > 0.1
    return float(np.max(np.abs(symplectic_form(images) - omega)))


BALL, METRIC_3 = gi.load_scene("hamiltonized-n3").problem, sphere_metric.problem()
SEASONS, FRAME_IN_FIELD = neumann.problem(season=0.4), frame_in_field.problem()
ON_MANIFOLDS = {
    "sphere-metric-3": (METRIC_3, sphere_metric.initial(METRIC_3)),
    "sphere-metric-5": (sphere_metric.problem(5), CONSTRAINED["metric-5"][1]),
    "hamiltonized-3": (BALL, BALL.random_state(1)),
    "double-pendulum": CONSTRAINED["double"],
    "frame-in-field": (FRAME_IN_FIELD, frame_in_field.initial(FRAME_IN_FIELD)),
    "neumann-3": (SEASONS, neumann.initial()),
    "neumann-5": CONSTRAINED["neumann-5"],
}
SYMPLECTIC = [
    *((case, name) for case in ON_MANIFOLDS for name in ("rattle-2", "lobatto-3")),
    *((case, f"verlet-{p}") for case in ON_MANIFOLDS for p in (2, 6) if case[0] in "hn"),
    *((case, f"rattle-{p}") for case in ("sphere-metric-5", "double-pendulum") for p in (4, 6)),
    ("double-pendulum", "lobatto-8"),
]


@pytest.mark.parametrize(
    ("case", "name"),
    late(
        SYMPLECTIC,
        [
            *(("sphere-metric-3", "rattle-2"), ("neumann-3", "rattle-2")),
            *(("double-pendulum", "lobatto-3"), ("hamiltonized-3", "verlet-2")),
        ],
    ),
)
def test_methods_are_symplectic_on_the_manifold(case: str, name: str) -> None:
    """Five steps, on the tangent space of T*S^(n−1), also with a metric that changes in time."""
    compiled = case[-1] != "3" or name not in ("rattle-2", "verlet-2")
    assert symplectic_defect(ON_MANIFOLDS[case], name, 0.1, 5, compiled) <= 1e-12


def test_a_method_that_is_not_symplectic_is_noticed() -> None:
    """An explicit method at the same step."""
    assert symplectic_defect(ON_MANIFOLDS["sphere-metric-3"], "rk-4", 0.1, 5) > 1e-7
