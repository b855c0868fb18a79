"""Geodesics of the ellipsoid (x, A⁻¹x) = 1 in R^n, A = diag(a): semi-axes √a_i.

H = ½(p, p), a separable Hamiltonian on T*E. The field is the extended one: with N = |A⁻¹x|²,

    ẋ = p − μA⁻¹x,                     μ = (A⁻¹x, p)/N,
    ṗ = −((p, A⁻¹p)/N) A⁻¹x + μA⁻¹p,

which is ẋ = p, ṗ = −λA⁻¹x on T*E, and keeps (x, A⁻¹x), (A⁻¹x, p) and H wherever x ≠ 0. All three are
quadratic: a Gauss method keeps them to round-off.

Beside H there are Joachimsthal's integral J = (p, A⁻¹p) N and those of Jacobi and Chasles. The
coefficients F_k of z^k in the polynomial of `commuting_integrals` with P(z) = Π(z − a_l),

    F(z) = Σ_i p_i² P(z)/(z − a_i) + Σ_{i<j} (x_i p_j − x_j p_i)² P(z)/((z − a_i)(z − a_j)),

are polynomials for equal a_i too: F_(n−1) = 2H, F_1 = (−1)ⁿ J Πa and F_0 = 0 on T*E.

The symplectic volume of T*E is N δ(c) dx dp with c = ((x, A⁻¹x) − 1, (A⁻¹x, p)), whose Poisson
bracket is 2N.

Under the Gauss map γ = A⁻¹x/|A⁻¹x|, p = ẋ, geodesics become motions of the Veselova problem with
1/a_i for a_i, in the time dt = U^(3/2) ds, U = (γ, Aγ): the remark after eq. (ham:ves), where |Aγ| is
misprinted for |Ax|.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint import log

from ..commuting_integrals import chasles_integral, coefficient_tables, table_rows, tabulated
from ..inertia import positive_vector
from ..manifold import REPAIRED, SILENT, Array, admit_tangent, length, tangent, warn
from ..random_states import random_direction, random_tangent

__all__ = ["ellipsoid_problem"]


@gi.field
def ellipsoid_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Write the extended geodesic flow; params = [1/a…, …], y = (x, p)."""
    n = len(y) // 2
    bx, p = params[0] * y[0], y[n]
    normal, xp, pp = bx * bx, bx * p, params[0] * p * p
    for i in range(1, n):
        bx, p = params[i] * y[i], y[n + i]
        normal += bx * bx
        xp += bx * p
        pp += params[i] * p * p
    mu, lam = xp / normal, pp / normal
    for i in range(n):
        bx = params[i] * y[i]
        out[i] = y[n + i] - mu * bx
        out[n + i] = mu * (params[i] * y[n + i]) - lam * bx


@gi.field
def ellipsoid_gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """Both gradients of ½(p, p)."""
    for i in range(len(q)):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]


@gi.field
def ellipsoid_constraint(params: Any, q: Any, g: Any, G: Any, work: Any) -> None:
    """½((x, A⁻¹x) − 1) and its Jacobian A⁻¹x."""
    total = params[0] * q[0] * q[0]
    for i in range(1, len(q)):
        total += params[i] * q[i] * q[i]
    g[0] = 0.5 * (total - 1.0)
    for i in range(len(q)):
        G[i] = params[i] * q[i]


@gi.observable
def ellipsoid_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """H = ½(p, p)."""
    n = len(y) // 2
    total = y[n] * y[n]
    for i in range(n + 1, 2 * n):
        total += y[i] * y[i]
    return 0.5 * total


@gi.helper
def normal_squared(params: Any, y: Any) -> Any:
    """Return N = |A⁻¹x|²."""
    bx = params[0] * y[0]
    total = bx * bx
    for i in range(1, len(y) // 2):
        bx = params[i] * y[i]
        total += bx * bx
    return total


@gi.observable
def joachimsthal(params: Any, t: Any, y: Any, work: Any) -> Any:
    """J = (p, A⁻¹p)(A⁻¹x, A⁻¹x)."""
    n = len(y) // 2
    total = params[0] * y[n] * y[n]
    for i in range(1, n):
        total += params[i] * y[n + i] * y[n + i]
    return total * normal_squared(params, y)


@gi.observable
def ellipsoid_equation(params: Any, t: Any, y: Any, work: Any) -> Any:
    """(x, A⁻¹x) − 1."""
    total = params[0] * y[0] * y[0]
    for i in range(1, len(y) // 2):
        total += params[i] * y[i] * y[i]
    return total - 1.0


@gi.observable
def ellipsoid_tangency(params: Any, t: Any, y: Any, work: Any) -> Any:
    """(A⁻¹x, p)."""
    n = len(y) // 2
    total = params[0] * y[0] * y[n]
    for i in range(1, n):
        total += params[i] * y[i] * y[n + i]
    return total


@gi.field
def ellipsoid_conditions(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """(x, A⁻¹x) − 1 and (A⁻¹x, p)."""
    out[0] = ellipsoid_equation(params, t, y, work)
    out[1] = ellipsoid_tangency(params, t, y, work)


@gi.observable
def ellipsoid_log_density(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return log N, the symplectic volume by N δ(c) dx dp."""
    return log(normal_squared(params, y))


def ellipsoid_problem(a: Any) -> gi.Problem:
    """Return the geodesics of the ellipsoid (x, A⁻¹x) = 1.

    State: ``x`` (n,) on the ellipsoid and ``p`` (n,) = ẋ with (A⁻¹x, p) = 0. Time t. Forms: ODE and
    separable Hamiltonian with one constraint. ``state(x=…, p=…)``: x as a direction, and p, are
    projected with a warning if need be. The integrals of Jacobi and Chasles go by "F2" … "F(n−2)".

    Parameters
    ----------
    a : array_like, shape (n,)
        The squares of the semi-axes, a_i > 0, n ≥ 2; equal ones are welcome.

    Raises
    ------
    geomint.DomainError
        For other a; from ``state`` and ``canonical`` for what describes no state.
    """
    squares = positive_vector("a", a)
    n = len(squares)
    degrees = tabulated(n, range(2, n - 1))
    integrals = {
        f"F{k}": chasles_integral(n, n + at * table_rows(n)) for at, k in enumerate(degrees)
    }

    def make_state(x: Any = None, p: Any = None) -> Array:
        position = _on_ellipsoid(squares, x)
        return np.concatenate([position, tangent(_normal(squares, position), p, "p", "normal")])

    def make_random(rng: np.random.Generator) -> dict[str, Any]:
        x = random_direction(rng, n)
        x = x / np.sqrt(x @ (x / squares))
        return {"x": x, "p": random_tangent(rng, x / squares)}

    def admit(y: Array) -> Array:
        position = _admit_position(squares, y[:n])
        normal = _normal(squares, position)
        return np.concatenate([position, admit_tangent(normal, y[n:], "p", "normal")])

    return gi.Problem(
        name="ellipsoid",
        pieces=(("x", n), ("p", n)),
        params=np.concatenate([1.0 / squares, coefficient_tables(squares, degrees, 0)]),
        field=ellipsoid_field,
        hamiltonian=gi.Hamiltonian(ellipsoid_gradients, ellipsoid_constraint, 1, separable=True),
        invariants={"energy": ellipsoid_energy, "joachimsthal": joachimsthal, **integrals},
        constraints={"ellipsoid": ellipsoid_equation, "tangency": ellipsoid_tangency},
        measure=gi.Measure(ellipsoid_log_density, ellipsoid_conditions, 2),
        make_state=make_state,
        make_random=make_random,
        admit=admit,
        physical=lambda y: {"x": np.array(y[:n]), "p": np.array(y[n:])},
        parameters={"a": squares.tolist()},
    )


def _normal(a: Array, x: Array) -> Array:
    """Return the unit normal at x."""
    normal = x / a
    return np.asarray(normal / length(normal))


def _on_ellipsoid(a: Array, x: Any) -> Array:
    """Return the point of the ellipsoid in the direction of `x`; warn if that is not `x` itself."""
    given = gi.as_vector("x", x, len(a))
    largest = float(np.max(np.abs(given)))
    if largest == 0.0:
        raise gi.DomainError("x", x, "a vector that is not zero")
    direction = given / largest
    size = length(direction / np.sqrt(a))
    if abs(size * largest - 1.0) <= 0.5 * SILENT:
        return given
    warn(f"√(x, x/a) is {size * largest!r}, not 1: the state uses x over it")
    return np.asarray(direction / size)


def _admit_position(a: Array, x: Array) -> Array:
    """Return an x of a flat state, repaired if need be; see `manifold`."""
    size = length(x / np.sqrt(a))
    defect = abs(size - 1.0) * (size + 1.0)
    if defect <= SILENT:
        return x
    if defect > REPAIRED:
        raise gi.DomainError("x", x, f"a point of the ellipsoid; (x, x/a) − 1 is {defect:.3g}")
    warn(f"(x, x/a) − 1 of the state is {defect:.3g}: projected to 0")
    return np.asarray(x / size)
