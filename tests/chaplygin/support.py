"""Random systems of all kinds, and functions of their problems in plain Python, in 40 digits too."""

from __future__ import annotations

import warnings
from typing import Any

import mpmath
import numpy as np
from hypothesis import strategies as st

import chaplygin as ch
import geomint as gi
from tests.paper.algebra import coordinates, skew, wedge

DIMENSIONS = range(2, 8)
mp = mpmath.mp.clone()
mp.dps = 40


# --- functions of problems ------------------------------------------------------------------------


class Rows(np.ndarray):
    """Rows of numbers of any kind, as functions of problems take them."""

    def part(self, start: int, rows: int) -> Any:
        return self[start : start + rows]


def extended(y: Any) -> Any:
    """Return an array as one of mpmath numbers."""
    flat = [mp.mpf(float(v)) for v in np.ravel(y)]
    return np.array(flat, dtype=object).reshape(np.shape(y))


def like(y: Any, values: Any) -> Any:
    return (extended(values) if y.dtype == object else np.array(values, dtype=float)).view(Rows)


def evaluated(problem: gi.Problem, f: Any, y: Any, rows: int = 0) -> Any:
    """Return what a function of the problem returns at a state, or writes to that many rows."""
    y = np.asarray(y)
    out, time = like(y, np.zeros(rows)), like(y, [0.0])[0]
    params, work = like(y, problem.params), like(y, np.zeros(problem.work))
    value = f(params, time, y.copy().view(Rows), *([out] if rows else []), work)
    return out.view(np.ndarray) if rows else value


def generator_of(problem: gi.Problem, y: Any) -> Any:
    """Return the algebra element of the problem's action form."""
    return evaluated(problem, problem.action.generator, y, problem.action.group.algebra_rows)


def value_of(problem: gi.Problem, name: str, y: Any) -> Any:
    return evaluated(problem, problem.diagnostics[name], y)


def close(x: Any, y: Any, size: float = 1.0) -> None:
    np.testing.assert_allclose(np.array(x, float), np.array(y, float), rtol=0, atol=4e-14 * size)


# --- parameters and states ------------------------------------------------------------------------


def rng_for(n: int, seed: int = 0) -> np.random.Generator:
    return np.random.default_rng([n, seed])


def random_special(n: int, seed: int = 0) -> ch.SpecialInertia:
    rng = rng_for(n, seed)
    a = rng.uniform(0.5, 1.6, n)
    largest = np.sort(a)[-1] * np.sort(a)[-2]
    return ch.SpecialInertia(a, largest * rng.uniform(1.05, 3.0))


def random_diagonal(n: int, seed: int = 0) -> ch.GeneralInertia:
    return ch.GeneralInertia(rng_for(n, seed).uniform(0.3, 3.0, n * (n - 1) // 2))


def random_full(n: int, seed: int = 0) -> ch.GeneralInertia:
    size = n * (n - 1) // 2
    m = rng_for(n, seed).normal(size=(size, size))
    return ch.GeneralInertia(m @ m.T + 0.3 * np.eye(size))


MAKERS = {"special": random_special, "diagonal": random_diagonal, "full": random_full}
kinds = st.sampled_from(sorted(MAKERS))
dimensions = st.integers(2, 7)
seeds = st.integers(0, 10**6)


def operator_of(kind: str, n: int, seed: int = 0) -> tuple[Any, float]:
    """Return a random operator and D, that of the special one."""
    inertia = MAKERS[kind](n, seed)
    return inertia, getattr(inertia, "D", 1.3)


def random_direction(n: int, seed: int = 0) -> Any:
    return gi.Sphere(n).random(rng_for(n, seed + 1000))["gamma"]


def random_tangent(n: int, seed: int = 0) -> tuple[Any, Any]:
    gamma = random_direction(n, seed)
    return gamma, gi.Sphere(n).tangent(gamma, rng_for(n, seed + 2000).normal(size=n))


def random_triangle(n: int, seed: int = 0) -> Any:
    """Return a random skew matrix as the flat triangle of its entries."""
    return rng_for(n, seed + 7).normal(size=n * (n - 1) // 2)


def random_rotation(n: int, seed: int = 0) -> Any:
    return gi.Rotations(n).random(rng_for(n, seed + 3000))["g"].reshape(n, n)


def random_body(n: int, seed: int = 0) -> ch.Veselova:
    rng = rng_for(n, seed + 4000)
    return ch.Veselova(rng.uniform(0.4, 2.0, n), rng.uniform(0.5, 3.0))


def flat_wedge(x: Any, y: Any) -> Any:
    return coordinates(wedge(x, y))


def triangle_of(vector: Any) -> Any:
    """Return the flat triangle of the matrix with X v = x⃗ × v, eq. (iso)."""
    x, y, z = vector
    return np.array([-z, y, -x])


def allowed_part(vectors: Any, triangle: Any) -> Any:
    """Return the part of a skew matrix in span{e_s∧R^n}, for orthonormal vectors e_s."""
    X = np.atleast_2d(vectors)
    rest = np.eye(X.shape[1]) - X.T @ X
    full = skew(triangle, len(rest))
    return coordinates(full - rest @ full @ rest)


def quiet_state(problem: gi.Problem, **components: Any) -> Any:
    """Return a state that must not need projecting."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return problem.state(**components)


def pieces(problem: gi.Problem, y: Any) -> dict[str, Any]:
    return {name: y[where] for name, where in problem.slices.items()}


# --- problems -------------------------------------------------------------------------------------


def of_operator(kind: str, n: int, seed: int = 0) -> dict[str, gi.Problem]:
    """Return every problem that has an operator of that kind, or of any."""
    inertia, D = operator_of(kind, n, seed)
    m, rho = D / 0.7**2, 0.7
    rubber = ch.RubberSphere(inertia, D)
    found = {
        "reduced": ch.reduced_problem(inertia, D),
        "ball": ch.ball_problem(inertia, D),
        "attitude": ch.ball_problem(inertia, D, True),
        "group": ch.cotangent_problem(inertia, D),
        "rolling": ch.rolling_problem(inertia, m, rho),
        "contact": ch.contact_problem(inertia, m, rho),
        "rubber": rubber.rolling(m, rho),
    }
    for r in range(1, n):
        body = ch.VeselovaLR(inertia, r)
        found |= {f"lr-{r}": body.lr(), f"stiefel-{r}": body.stiefel()}
    if n == 3:
        found["poisson"] = ch.poisson_problem(inertia, D)
        found["classical"] = ch.classical_problem(inertia, D)
        found["classical-attitude"] = ch.classical_problem(inertia, D, True)
    return found


def of_parameters(n: int, seed: int = 0, equal: int = 1) -> dict[str, gi.Problem]:
    """Return every problem with parameters a_1, …, a_n, of which the first few may be equal."""
    body, (_, tangent) = random_body(n, seed), random_tangent(n, seed)
    a = body.a.copy()
    a[:equal] = a[0]
    sphere = ch.ChaplyginSphere(a, 1.3 * np.max(a) ** 2)
    body = ch.Veselova(a, body.D)
    found = {
        "sphere-reduced": sphere.reduced(),
        "sphere-hamiltonized": sphere.hamiltonized(),
        "body-reduced": body.reduced(),
        "body-hamiltonized": body.hamiltonized(),
        "ellipsoid": ch.ellipsoid_problem(a),
        "neumann": ch.neumann_problem(a, 1.3),
        "clebsch": ch.clebsch_problem(a, -0.7, 0.4, 1.1),
    }
    if n == 3:
        f1 = float(tangent[0])
        found |= {"body-classical": body.classical(f1), "body-multiplier": body.multiplier(f1)}
    return found
