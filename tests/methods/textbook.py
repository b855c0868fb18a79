"""One step of every kind of method as textbooks write it, in numpy: what kernels are held to.

Tableaux are verified exactly in `tests.tableaux`; a method that takes the steps of its tableau has
its order.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
from numpy.polynomial import legendre
from scipy.special import bernoulli, factorial

import geomint as gi
from geomint.tableaux import gauss_legendre

Array = Any


class Rows(np.ndarray):
    """An array that functions of problems read and write as they do blocks."""

    def part(self, start: int, rows: int) -> Rows:
        return self[start : start + rows]


def rows(numbers: Any) -> Rows:
    return np.array(numbers, dtype=float).view(Rows)


def called(f: Any, sizes: tuple[int, ...], work: int, *given: Any) -> tuple[Array, ...]:
    """Call a recorded function in plain Python; what it writes to rows of those sizes."""
    outs = [rows(np.zeros(size)) for size in sizes]
    with np.errstate(all="ignore"):
        f.function(*given, *outs, rows(np.zeros(work)))
    return tuple(np.asarray(out) for out in outs)


def solved(equations: Callable[[Array], Array], x: Array) -> Array:
    """The root near x, by the slopes there: each step leaves a small part of what was off."""
    units = 1e-6 * np.eye(len(x))
    slopes = np.array([(equations(x + d) - equations(x - d)) / 2e-6 for d in units]).T
    inverse = np.linalg.inv(slopes)
    for _ in range(40):
        x = x - inverse @ equations(x)
    return x


# --- fields ---------------------------------------------------------------------------------------


def explicit(table: Any, problem: gi.Problem, t: float, y: Array, h: float) -> Array:
    """A Runge–Kutta method."""
    A, b, c = ([*map(float, row)] for row in (sum(table.A, ()), table.b, table.c))
    K: list[Array] = []
    for i in range(len(c)):
        Y = y + h * sum(a * k for a, k in zip(A[i * len(c) :], K, strict=False))
        K.append(gi.derivative(problem, np.array(Y), t + c[i] * h, "field"))
    return y + h * np.array(b) @ np.array(K)


def implicit(stages: int, problem: gi.Problem, t: float, y: Array, h: float) -> Array:
    """Gauss collocation: fixed points of L_i = h b_i f(t + c_i h, y + Σ μ_ij L_j)."""
    table = gauss_legendre(stages)
    L = np.zeros((stages, len(y)))
    for _ in range(200):
        Y = y + table.mu @ L
        F = [gi.derivative(problem, Y[i], t + table.c[i] * h, "field") for i in range(stages)]
        L, before = h * table.b[:, None] * np.array(F), L
        if np.array_equal(L, before):
            break
    return y + L.sum(axis=0)


# --- groups ---------------------------------------------------------------------------------------


class Turning:
    """The action of a problem by matrices: of `so_n_flow`, or on the pulsating body's two vectors."""

    def __init__(self, problem: gi.Problem) -> None:
        self.problem, self.n = problem, problem.parameters.get("n", 3)
        self.vectors = problem.name == "pulsating-body"

    def skew(self, flat: Array) -> Array:
        """The matrix of an element of the algebra: of a triangle, or of what vectors turn about."""
        matrix = np.zeros((self.n, self.n))
        matrix[np.triu_indices(self.n, 1)] = flat * [1, -1, 1] if self.vectors else flat
        return (matrix - matrix.T) * (-1.0 if self.vectors else 1.0)

    def generator(self, t: float, y: Array) -> Array:
        problem, size = self.problem, self.n * (self.n - 1) // 2
        given = (rows(problem.params), t, rows(y))
        (flat,) = called(problem.action.generator, (size,), problem.work, *given)
        return self.skew(flat[::-1] if self.vectors else flat)

    def moved(self, g: Array, y: Array) -> Array:
        n, size = self.n, self.n * (self.n - 1) // 2
        if self.vectors:
            return (y.reshape(2, n) @ g.T).ravel()
        k = g @ self.skew(y[:size]) @ g.T
        frame = y[size + n :].reshape(-1, n) @ g.T
        return np.concatenate([k[np.triu_indices(n, 1)], g @ y[size : size + n], frame.ravel()])


def expm(skew: Array) -> Array:
    """The exponential of a skew matrix, by its eigenvectors."""
    angles, vectors = np.linalg.eigh(1j * skew)
    return ((vectors * np.exp(-1j * angles)) @ vectors.conj().T).real


def commutator_free(table: Any, on: Turning, t: float, y: Array, h: float) -> Array:
    """Products of exponentials of sums of generators, each flow from the value of a stage."""
    values, K = [y], []
    for i, (start, exponentials) in enumerate(table.flows):
        Y = values[start]
        for weights in exponentials:
            total = sum(float(a) * k for a, k in zip(weights, K, strict=False))
            Y = on.moved(expm(h * total), Y)
        values.append(Y)
        if i < len(table.stages):
            K.append(on.generator(t + float(table.c[i]) * h, Y))
    return values[-1]


def in_algebra(method: gi.RKMK, on: Turning, t: float, y: Array, h: float) -> Array:
    """Runge–Kutta for u̇ = dψ_u⁻¹ ξ; dexp⁻¹ as far as the order needs, on SO(3) all of it."""
    table, one = method.table, np.eye(on.n)
    terms = 40 if on.n == 3 else max(table.order - 1, 1)
    series = bernoulli(terms - 1 if terms > 1 else 1)[:terms] / factorial(np.arange(terms))

    def group(u: Array) -> Array:
        return expm(u) if method.coordinates == "exp" else np.linalg.solve(one - u / 2, one + u / 2)

    def inverse(u: Array, xi: Array) -> Array:
        if method.coordinates == "cayley":
            return (one - u / 2) @ xi @ (one + u / 2)
        total, power = 0.0 * xi, xi
        for weight in series:
            total, power = total + weight * power, u @ power - power @ u
        return total

    K: list[Array] = []
    for a, c in zip(table.A, table.c, strict=True):
        u = h * sum((float(x) * k for x, k in zip(a, K, strict=False)), 0.0 * one)
        K.append(inverse(u, on.generator(t + float(c) * h, on.moved(group(u), y))))
    return on.moved(group(h * sum(float(b) * k for b, k in zip(table.b, K, strict=True))), y)


# --- Hamiltonians with constraints, splittings --------------------------------------------------------


def gradients(problem: gi.Problem, t: float, q: Array, p: Array) -> tuple[Array, Array]:
    """H_q and H_p."""
    form, n = problem.hamiltonian, len(q)
    return called(form.gradients, (n, n), problem.work, rows(problem.params), t, rows(q), rows(p))


def constraint(problem: gi.Problem, q: Array) -> tuple[Array, Array]:
    """The constraints g and their Jacobian G."""
    m, n = problem.hamiltonian.constraints, len(q)
    g, G = called(
        problem.hamiltonian.constraint, (m, m * n), problem.work, rows(problem.params), rows(q)
    )
    return g, G.reshape(m, n)


@functools.cache
def lobatto_tables(s: int) -> tuple[Array, Array, Array]:
    """c, a and â in 40 digits: nodes by Legendre's polynomial, a by collocation on powers."""
    with mp.workdps(40):
        rough = legendre.legroots(legendre.legder([0.0] * (s - 1) + [1.0]))

        def slope(x: Any) -> Any:
            return mp.diff(lambda z: mp.legendre(s - 1, z), x)

        x = [mp.mpf(-1), *(mp.findroot(slope, z) for z in np.sort(rough)), mp.mpf(1)]
        c = [(1 + z) / 2 for z in x]
        powers = mp.matrix([[z**k for z in c] for k in range(s)])
        solutions = [mp.lu_solve(powers, [z ** (k + 1) / (k + 1) for k in range(s)]) for z in c]
        a = np.array([[row[j] for j in range(s)] for row in solutions])
        b = a[-1]
        return tuple(np.array(x, dtype=float) for x in (c, a, b - b * a.T / b[:, None]))


def on_manifold(stages: int, problem: gi.Problem, t: float, y: Array, h: float) -> Array:
    """Lobatto IIIA–IIIB with multipliers (Jay 1996); with two stages RATTLE."""
    c, a, hat = lobatto_tables(stages)
    b, n, m = a[-1], len(y) // 2, problem.hamiltonian.constraints
    q, p = y[:n], y[n:]

    def stage_rates(x: Array) -> tuple[Array, ...]:
        K, L = x[: 2 * stages * n].reshape(2, stages, n)
        return K, L, q + h * a @ K, p + h * hat @ L, x[2 * stages * n :].reshape(stages, m)

    def equations(x: Array) -> Array:
        K, L, Q, P, forces = stage_rates(x)
        left = []
        for i in range(stages):
            (dq, dp), (g, G) = (
                gradients(problem, t + c[i] * h, Q[i], P[i]),
                constraint(problem, Q[i]),
            )
            left += [K[i] - dp, L[i] + dq + G.T @ forces[i], g / h if i else []]
        end = gradients(problem, t + h, Q[-1], p + h * b @ L)[1]
        return np.concatenate([*left, constraint(problem, Q[-1])[1] @ end])

    x = solved(equations, np.zeros(stages * (2 * n + m)))
    K, L, *_ = stage_rates(x)
    return np.concatenate([q + h * b @ K, p + h * b @ L])


def split(problem: gi.Problem, t: float, y: Array, h: float) -> Array:
    """Half flows of all parts but the last, its whole one, and back, at the middle time."""
    splitting, middle = problem.splitting, t + 0.5 * h
    last = splitting.parts - 1
    for k in (*range(last), last, *reversed(range(last))):
        length = h if k == last else 0.5 * h
        given = (k, rows(problem.params), middle, length, rows(y))
        y = y + called(splitting.flow, (len(y),), problem.work, *given)[0]
    return y


# --- all of them --------------------------------------------------------------------------------------


def step(method: gi.Method, problem: gi.Problem, t: float, y: Array, h: float) -> Array:
    """One step of any method of fixed steps."""
    if isinstance(method, gi.Compose):
        scheme = method.scheme
        for begin, part in zip(scheme.starts, scheme.gamma, strict=True):
            y = step(method.base, problem, t + begin * h, y, part * h)
        return y
    if isinstance(method, gi.RungeKutta):
        return explicit(method.table, problem, t, y, h)
    if isinstance(method, gi.Gauss):
        return implicit(method.stages, problem, t, y, h)
    if isinstance(method, gi.Verlet):
        return split(problem, t, y, h)
    if isinstance(method, gi.Rattle):
        return on_manifold(getattr(method, "stages", 2), problem, t, y, h)
    on = Turning(problem)
    if isinstance(method, gi.RKMK):
        return in_algebra(method, on, t, y, h)
    return commutator_free(method.tableau, on, t, y, h)
