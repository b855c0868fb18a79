"""Problems of all systems at random states, and their functions run in plain Python.

Numbers are float64 or, as object arrays, mpmath's with 40 digits: a central difference with spacing
1e-15 is then exact far beyond float64.
"""

from __future__ import annotations

import tomllib
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import skew_matrix, vector_of_triangle
from chaplygin.related.ellipsoid import Ellipsoid
from chaplygin.veselova.stiefel_states import allowed_part
from geomint.kernels.numbers.blocks import Block
from geomint.scene.load import builtin_scenes

DIMENSIONS = range(2, 8)
mp = mpmath.mp.clone()
mp.dps = 40


def extended(y: Any) -> Any:
    """Return an array as one of mpmath numbers."""
    return np.array([mp.mpf(float(v)) for v in y], dtype=object)


def _like(y: Any, values: Any) -> Any:
    return extended(values) if y.dtype == object else np.array(values, dtype=np.float64)


def _blocks(problem: gi.Problem, y: Any) -> tuple[Block, Any, Block, Block]:
    work = Block(_like(y, np.zeros(problem.work)))
    return Block(_like(y, problem.params)), _like(y, [0.0])[0], Block(y), work


def field_of(problem: gi.Problem, y: Any) -> Any:
    """Return ẏ by the problem's ODE form."""
    params, t, state, work = _blocks(problem, y)
    out = _like(y, np.zeros(len(y)))
    problem.field(params, t, state, Block(out), work)
    return out


def value_of(problem: gi.Problem, name: Any, y: Any) -> Any:
    """Return a diagnostic of the problem, by name, or another recorded function."""
    params, t, state, work = _blocks(problem, y)
    f = problem.diagnostics[name] if isinstance(name, str) else name
    return f(params, t, state, work)


def generator_of(problem: gi.Problem, y: Any) -> Any:
    """Return the algebra element of the problem's action form."""
    params, t, state, work = _blocks(problem, y)
    out = _like(y, np.zeros(problem.action.group.algebra_rows))
    problem.action.generator(params, t, state, Block(out), work)
    return out


def acted(problem: gi.Problem, xi: Any, y: Any) -> Any:
    """Return exp(ξ)·y − y."""
    group = problem.action.group
    out, work = _like(y, np.zeros(len(y))), Block(_like(y, np.zeros(group.work)))
    group.act(Block(_like(y, group.layout)), Block(xi), Block(y), Block(out), work)
    return out


def gradients_of(problem: gi.Problem, y: Any) -> tuple[Any, Any]:
    """Return ∂H/∂q and ∂H/∂p of the problem's Hamiltonian form."""
    params, t, _, work = _blocks(problem, y)
    n = len(y) // 2
    dq, dp = _like(y, np.zeros(n)), _like(y, np.zeros(n))
    q, p = Block(y[:n]), Block(y[n:])
    problem.hamiltonian.gradients(params, t, q, p, Block(dq), Block(dp), work)
    return dq, dp


def rate(problem: gi.Problem, name: Any, y: Any, velocity: Any) -> float:
    """Return the derivative of a diagnostic at y in the direction of `velocity`."""
    y, h = extended(y), mp.mpf("1e-15")
    above, below = (value_of(problem, name, y + s * h * velocity) for s in (1, -1))
    return float((above - below) / (2 * h))


def conditions_of(problem: gi.Problem, y: Any) -> Any:
    """Return c(y), which vanishes on the manifold of the problem's measure."""
    params, t, state, work = _blocks(problem, y)
    out = _like(y, np.zeros(problem.measure.conditions))
    problem.measure.manifold(params, t, state, Block(out), work)
    return out


def divergence(problem: gi.Problem, y: Any, log_density: Any = None) -> float:
    """Return the divergence of the field on c(y) = 0 with respect to μ δ(c) dy.

    With T an orthonormal basis of the tangent space and δ(c) dy = dσ/√det(c_y c_yᵀ), dσ the
    Euclidean volume, it is tr(Tᵀ X_y T) + X(log μ − ½ log det(c_y c_yᵀ)). Only derivatives along
    the manifold enter, so that it does not matter how X goes on off it.
    """
    y, h = extended(y), mp.mpf("1e-15")
    velocity = field_of(problem, y)

    def log_volume(state: Any) -> Any:
        jacobian = mp.matrix(conditions_jacobian(problem, state))
        gram = jacobian * jacobian.T
        return mp.log(mp.det(gram)) / 2 if gram.rows else mp.mpf(0)

    def log_mu(state: Any) -> Any:
        return value_of(problem, log_density or problem.measure.log_density, state)

    def along(direction: Any, f: Any) -> Any:
        return (f(y + h * direction) - f(y - h * direction)) / (2 * h)

    total = along(velocity, log_mu) - along(velocity, log_volume)
    for column in tangent_basis(conditions_jacobian(problem, y)):
        total += column @ along(column, lambda state: field_of(problem, state))
    return float(total)


def conditions_jacobian(problem: gi.Problem, y: Any) -> Any:
    """Return c_y: central differences, exact for quadratic c whatever the spacing."""
    h = mp.mpf("0.125")
    rows = [
        (conditions_of(problem, y + h * e) - conditions_of(problem, y - h * e)) / (2 * h)
        for e in (extended(e) for e in np.eye(len(y)))
    ]
    return np.array(rows).T


def tangent_basis(jacobian: Any) -> list[Any]:
    """Return an orthonormal basis of the vectors that c_y takes to 0, by Householder's reflections.

    A row that depends on those before it counts for nothing.
    """
    normals: list[Any] = []
    for row in jacobian:
        vector = row.copy()
        for normal in normals:
            vector = vector - 2 * (normal @ vector) * normal
        at = len(normals)
        vector[:at] = 0 * vector[:at]
        size = mp.sqrt(vector @ vector)
        if size > 1e-6:
            vector[at] += size if vector[at] > 0 else -size
            normals.append(vector / mp.sqrt(vector @ vector))
    found = []
    for vector in [extended(e) for e in np.eye(jacobian.shape[1])[len(normals) :]]:
        for normal in reversed(normals):
            vector = vector - 2 * (normal @ vector) * normal
        found.append(vector)
    return found


@dataclass(frozen=True)
class Case:
    """One problem at one state; `sphere` is what it describes, with its dimension n."""

    label: str
    sphere: Any
    problem: gi.Problem
    y: Any

    def __repr__(self) -> str:
        return self.label


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


def random_direction(n: int, seed: int = 0) -> Any:
    return gi.Sphere(n).random(rng_for(n, seed + 1000))["gamma"]


def random_tangent(n: int, seed: int = 0) -> tuple[Any, Any]:
    gamma = random_direction(n, seed)
    return gamma, gi.Sphere(n).tangent(gamma, rng_for(n, seed + 2000).normal(size=n))


def random_rotation(n: int, seed: int = 0) -> Any:
    return gi.Rotations(n).random(rng_for(n, seed + 3000))["g"].reshape(n, n)


def random_frame(gamma: Any) -> Any:
    """Return a random rotation whose last row is γ."""
    n = len(gamma)
    rows = np.vstack([gamma, random_rotation(n)[1:]])
    for i in range(1, n):
        for _ in range(2):
            rows[i] -= (rows[:i] @ rows[i]) @ rows[:i]
        rows[i] /= np.sqrt(rows[i] @ rows[i])
    rows[1] *= np.linalg.det(np.vstack([rows[1:], rows[:1]]))
    return np.vstack([rows[1:], rows[:1]])


def random_body(n: int, seed: int = 0) -> ch.Veselova:
    rng = rng_for(n, seed + 4000)
    return ch.Veselova(rng.uniform(0.4, 2.0, n), rng.uniform(0.5, 3.0))


def random_geodesic(a: Any, seed: int = 0) -> tuple[Any, Any]:
    """Return a point x of the ellipsoid (x, A⁻¹x) = 1 and a tangent p."""
    space = gi.TangentBundle(Ellipsoid(tuple(a)), "p")
    x, p = space.random(rng_for(len(a), seed + 5000)).values()
    return x, p


def quiet_state(problem: gi.Problem, **components: Any) -> Any:
    """Return a state that must not need projecting."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return problem.state(**components)


def full_matrix_path(inertia: ch.SpecialInertia | ch.GeneralInertia) -> ch.GeneralInertia:
    """Return the same operator with an off-diagonal entry too small to matter."""
    matrix = np.array(inertia.matrix) if isinstance(inertia, ch.GeneralInertia) else None
    matrix = np.diag(inertia.diagonal) if matrix is None else matrix
    if len(matrix) > 1:
        matrix[0, 1] = matrix[1, 0] = matrix[0, 1] + 1e-200
    return ch.GeneralInertia(matrix)


def _inertias(n: int) -> dict[str, Any]:
    found: dict[str, Any] = {"special": random_special(n), "diagonal": random_diagonal(n)}
    if n > 2:
        found["full"] = random_full(n)
    return found


def ball_cases() -> list[Case]:
    """Return every problem of every ball, n = 2 … 7, each at a random admissible state."""
    cases = []
    for n in DIMENSIONS:
        gamma, p = random_tangent(n)
        k = rng_for(n, 7).normal(size=n * (n - 1) // 2)
        g = random_frame(gamma)
        for kind, inertia in _inertias(n).items():
            D = inertia.D if kind == "special" else 1.7

            def add(name: str, problem: gi.Problem, n=n, kind=kind, inertia=inertia, **state: Any):
                y = quiet_state(problem, **state)
                cases.append(Case(f"{name}-{kind}-n{n}", inertia, problem, y))

            add("reduced", ch.reduced_problem(inertia, D), gamma=gamma, p=p)
            if kind == "special":
                add("hamiltonized", ch.hamiltonized_problem(inertia), gamma=gamma, p=p)
            add("ball", ch.ball_problem(inertia, D), gamma=gamma, k=k)
            add("ball-attitude", ch.ball_problem(inertia, D, True, k), gamma=gamma, k=k, g=g)
            add("group", ch.cotangent_problem(inertia, D, g @ skew_matrix(k, n) @ g.T), g=g, k=k)
            if n == 3:
                x = vector_of_triangle(k)
                add("poisson", ch.poisson_problem(inertia, D), gamma=gamma, k=x)
                add("classical", ch.classical_problem(inertia, D), gamma=gamma, k=x)
                carrying = ch.classical_problem(inertia, D, True, x)
                add("classical-attitude", carrying, gamma=gamma, k=x, g=g)
    return cases


def veselova_cases(n: int) -> list[Case]:
    """Return the problems of a body in R^n; the classical one with the f₁ of any k."""
    body, (gamma, p) = random_body(n), random_tangent(n)
    named = {"reduced": body.reduced(), "hamiltonized": body.hamiltonized()}
    cases = [
        Case(f"veselova-{name}-n{n}", body, problem, quiet_state(problem, gamma=gamma, p=p))
        for name, problem in named.items()
    ]
    if n == 3:
        x = vector_of_triangle(rng_for(n, 7).normal(size=3))
        problem = body.classical(gamma @ x)
        y = quiet_state(problem, gamma=gamma, k=x)
        cases.append(Case("veselova-classical-n3", body, problem, y))
        problem = body.multiplier(gamma @ x)
        y = quiet_state(problem, gamma=gamma, k=x)
        cases.append(Case("veselova-multiplier-n3", body, problem, y))
    return cases


def ellipsoid_case(n: int) -> Case:
    a = random_body(n).a
    x, p = random_geodesic(a)
    problem = ch.ellipsoid_problem(a)
    return Case(f"ellipsoid-n{n}", SimpleNamespace(n=n), problem, quiet_state(problem, x=x, p=p))


def equal_cases(n: int) -> list[Case]:
    """Return the sphere and Veselova's body with groups of equal parameters, n ≥ 3."""
    cases, (gamma, p) = [], random_tangent(n)
    for groups in ([2, n - 2], [n - 1, 1]):
        a = np.repeat(random_body(n).a[: len(groups)], groups)
        sphere, body = ch.ChaplyginSphere(a=a, D=1.3 * np.max(a) ** 2), ch.Veselova(a, 1.7)
        named = {
            "reduced": sphere.reduced(),
            "hamiltonized": sphere.hamiltonized(),
            "veselova-reduced": body.reduced(),
            "veselova-hamiltonized": body.hamiltonized(),
        }
        for name, problem in named.items():
            label = f"{name}-equal-{groups[0]}-n{n}"
            cases.append(Case(label, body, problem, quiet_state(problem, gamma=gamma, p=p)))
    return cases


def bound_cases(n: int) -> list[Case]:
    """Return the Veselova problem for every r, and the rubber ball, with general operators."""
    cases, g = [], random_frame(random_direction(n))
    for kind, inertia in _inertias(n).items():
        w = rng_for(n, 7).normal(size=n * (n - 1) // 2)
        for r in range(1, n):
            body = ch.VeselovaLR(inertia, r)
            inside = allowed_part(g[:r], w)
            for name, problem in (("lr", body.lr()), ("stiefel", body.stiefel())):
                key = "g" if name == "lr" else problem.pieces[0][0]
                y = quiet_state(problem, **{key: g if name == "lr" else g[:r], "w": inside})
                cases.append(Case(f"{name}-{r}-{kind}-n{n}", body, problem, y))
        ball = ch.RubberSphere(inertia, None if kind == "special" else 1.7)
        omega = allowed_part(g[-1:], w)
        problem = ball.rolling(rho=0.7)
        y = quiet_state(problem, g=g, r=np.arange(1.0, n), omega=omega)
        cases.append(Case(f"rubber-{kind}-n{n}", ball, problem, y))
    return cases


def rolling_cases(n: int) -> list[Case]:
    """Return the rolling ball in (g, r, ω, v) and (k, γ, g, r)."""
    cases, g = [], random_frame(random_direction(n))
    for kind, inertia in _inertias(n).items():
        m = getattr(inertia, "D", 1.7) / 0.7**2
        omega = rng_for(n, 7).normal(size=n * (n - 1) // 2)
        problems = {
            "rolling": ch.rolling_problem(inertia, m, 0.7),
            "contact": ch.contact_problem(inertia, m, 0.7),
        }
        for name, problem in problems.items():
            y = quiet_state(problem, g=g, r=np.arange(1.0, n), omega=omega)
            cases.append(Case(f"{name}-{kind}-n{n}", inertia, problem, y))
    return cases


def related_cases(n: int) -> list[Case]:
    """Return Neumann's and Clebsch's systems."""
    a, (q, v) = random_body(n).a, random_tangent(n)
    named = {
        "neumann": ch.neumann_problem(a, 1.3),
        "clebsch": ch.clebsch_problem(a, -0.7, 0.4, 1.1),
    }
    return [
        Case(f"{name}-n{n}", SimpleNamespace(n=n), problem, quiet_state(problem, q=q, v=v))
        for name, problem in named.items()
    ]


OF_CASES = {  # systems whose problems the functions above make
    *("chaplygin-sphere-reduced", "chaplygin-sphere-hamiltonized", "chaplygin-ball"),
    *("homogeneous-ball", "ball-on-group", "ball-poisson", "rolling-ball", "rubber-ball"),
    *("veselova", "veselova-lr", "ellipsoid", "neumann", "clebsch"),
}


def scene_cases() -> Iterator[Case]:
    """Yield the problems of all other systems, as their scenes have them, at random states."""
    for scene, path in builtin_scenes().items():
        if tomllib.loads(path.read_text("utf-8"))["system"]["name"] not in OF_CASES:
            for name, problem in gi.load_scene(scene).model.problems.items():
                n = problem.space.factors[0].n if problem.space else 3
                label = f"{scene}-{name}-n{n}"
                yield Case(label, SimpleNamespace(n=n), problem, problem.random_state(n))


MADE = [
    *ball_cases(),
    *(
        case
        for n in DIMENSIONS
        for case in (
            *veselova_cases(n),
            ellipsoid_case(n),
            *(equal_cases(n) if n > 2 else []),
            *related_cases(n),
        )
    ),
    *(case for n in range(2, 5) for case in (*bound_cases(n), *rolling_cases(n))),
]
CASES = [*MADE, *scene_cases()]
