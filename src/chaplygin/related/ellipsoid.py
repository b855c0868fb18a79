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

import functools
from collections import namedtuple
from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi
from geomint import log, part, section

from ..commuting_integrals import coefficient_tables, table, tabulated, weighted_minors
from ..inertia import positive_vector
from ..integrable import inner, weighted
from ..literature import ELLIPSOID
from ..manifold import SILENT, Array, Arrays, Named, length, repaired, warn

Parts = namedtuple("Parts", "b tables")


@gi.helper
def ellipsoid_rows(n):
    """Return the layout of the parameters: 1/a_i, and the tables of the integrals."""
    return Parts(b=n, tables=gi.REST)


@gi.helper
def inverse_squares(params, n):
    """Return the block of 1/a_i."""
    return section(params, ellipsoid_rows(n), "b")


@gi.field
def ellipsoid_field(params, t, y, out, work):
    """Write the extended geodesic flow; y = (x, p)."""
    n = len(y) // 2
    b = inverse_squares(params, n)
    bx, p = b[0] * y[0], y[n]
    normal, xp, pp = bx * bx, bx * p, b[0] * p * p
    for i in range(1, n):
        bx, p = b[i] * y[i], y[n + i]
        normal += bx * bx
        xp += bx * p
        pp += b[i] * p * p
    mu, lam = xp / normal, pp / normal
    for i in range(n):
        bx = b[i] * y[i]
        out[i] = y[n + i] - mu * bx
        out[n + i] = mu * (b[i] * y[n + i]) - lam * bx


@gi.field
def ellipsoid_gradients(params, t, q, p, dq, dp, work):
    """Both gradients of ½(p, p)."""
    for i in range(len(q)):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]


@gi.field
def ellipsoid_constraint(params, q, g, G, work):
    """½((x, A⁻¹x) − 1) and its Jacobian A⁻¹x."""
    b = inverse_squares(params, len(q))
    g[0] = 0.5 * (weighted(len(q), b, q, q) - 1.0)
    for i in range(len(q)):
        G[i] = b[i] * q[i]


@gi.observable
def ellipsoid_energy(params, t, y, work):
    """H = ½(p, p)."""
    n = len(y) // 2
    p = part(y, n, n)
    return 0.5 * inner(n, p, p)


@gi.observable
def squared_normal(params, t, y, work):
    """N = |A⁻¹x|²: with dt = N dτ the squares of the coordinates are quotients of theta functions."""
    return normal_squared(params, y)


@gi.helper
def normal_squared(params, y):
    """Return N = |A⁻¹x|²."""
    b = inverse_squares(params, len(y) // 2)
    bx = b[0] * y[0]
    total = bx * bx
    for i in range(1, len(y) // 2):
        bx = b[i] * y[i]
        total += bx * bx
    return total


@gi.observable
def joachimsthal(params, t, y, work):
    """J = (p, A⁻¹p)(A⁻¹x, A⁻¹x)."""
    n = len(y) // 2
    b = inverse_squares(params, n)
    p = part(y, n, n)
    return weighted(n, b, p, p) * normal_squared(params, y)


@functools.cache
def weighted_product(n: int, first: int, second: int) -> Any:
    """Return the observable (u, A⁻¹v) of the vectors from those rows on, less 1 if they are one."""

    def weighted_vectors(params, t, y, work):
        b = inverse_squares(params, n)
        total = weighted(n, b, part(y, first, n), part(y, second, n))
        if first == second:
            total -= 1.0
        return total

    return gi.observable(weighted_vectors)


@gi.observable
def ellipsoid_log_density(params, t, y, work):
    """Return log N, the symplectic volume by N δ(c) dx dp."""
    return log(normal_squared(params, y))


@functools.cache
def chasles_integral(n: int, k: int) -> Any:
    """Return Σ d_i p_i² + Σ c_ij m_ij² with the weights of the k-th table."""

    def chasles_coefficient(params, t, y, work):
        """Return a coefficient of the polynomial with s_i = p_i²."""
        d, c = table(n, section(params, ellipsoid_rows(n), "tables"), k)
        total = weighted_minors(n, c, y)
        for i in range(n):
            total += d[i] * (y[n + i] * y[n + i])
        return total

    return gi.observable(chasles_coefficient)


@dataclass(frozen=True)
class Ellipsoid(gi.Space):
    """The ellipsoid (x, A⁻¹x) = 1; its functions read 1/a_i from the first parameters.

    Parameters
    ----------
    a : tuple of float
        The squares of the semi-axes.
    name : str
        Of the piece of the state.
    """

    a: tuple[float, ...]
    name: str = "x"
    codes = None
    normal = "normal"

    def __post_init__(self) -> None:
        self.check_names()

    @property
    def n(self) -> int:  # type: ignore[override]
        """The dimension of R^n."""
        return len(self.a)

    @property
    def pieces(self) -> tuple[tuple[str, int], ...]:
        """One piece."""
        return ((self.name, self.n),)

    @property
    def params(self) -> Array:
        """1/a_i."""
        return 1.0 / np.array(self.a)

    constraint = ellipsoid_constraint

    def constraints_at(self, first: int) -> Named:
        """(x, A⁻¹x) − 1."""
        return {"ellipsoid": weighted_product(self.n, first, first)}

    def tangencies_at(self, first: int, second: int) -> Named:
        """(A⁻¹x, p)."""
        return {"tangency": weighted_product(self.n, first, second)}

    def tangent(self, y: Array, v: Array) -> Array:
        """Return v less its part along the normal A⁻¹x."""
        normal = y / np.array(self.a)
        return gi.Sphere(self.n).tangent(normal / length(normal), v)

    def point(self, value: Any) -> Array:
        """Return the point in the direction of `value`; warn if that is not `value` itself."""
        given = gi.as_vector(self.name, value, self.n)
        largest = float(np.max(np.abs(given)))
        if largest == 0.0:
            raise gi.DomainError(self.name, value, "a vector that is not zero")
        direction = given / largest
        size = length(direction / np.sqrt(self.a))
        if abs(size * largest - 1.0) <= 0.5 * SILENT:
            return given
        x = self.name
        found = size * largest
        warn(f"√({x}, {x}/a) is {found!r}, not 1: the state uses {x} over it", x, abs(found - 1.0))
        return direction / size

    def admit(self, y: Array) -> Array:
        """Return a point of a flat state, repaired if need be."""
        size = length(y / np.sqrt(self.a))
        defect, said = abs(size - 1.0) * (size + 1.0), f"({self.name}, {self.name}/a) − 1"
        return repaired(self.name, y, defect, said, "a point of the ellipsoid", lambda: y / size)

    def random(self, rng: np.random.Generator) -> Arrays:
        """Return a point whose direction is uniform."""
        (x,) = gi.Sphere(self.n).random(rng).values()
        return {self.name: x / np.sqrt(x @ (x / np.array(self.a)))}


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
    n, space = len(squares), gi.TangentBundle(Ellipsoid(tuple(squares.tolist())), "p")
    degrees = tabulated(n, range(2, n - 1))
    tables = coefficient_tables(squares, degrees, 0)
    integrals = {f"F{k}": chasles_integral(n, at) for at, k in enumerate(degrees)}
    return gi.Problem(
        name="ellipsoid",
        equations=(
            "ẋ = p,  ṗ = −λA⁻¹x",
            "(x, A⁻¹x) = 1,  λ = (p, A⁻¹p)/|A⁻¹x|²",
        ),
        space=space,
        params=gi.packed(ellipsoid_rows(n), b=1.0 / squares, tables=tables).data,
        field=ellipsoid_field,
        hamiltonian=space.hamiltonian(ellipsoid_gradients, separable=True),
        invariants={"energy": ellipsoid_energy, "joachimsthal": joachimsthal, **integrals},
        observables={"normal_squared": squared_normal},
        measure=gi.Measure(ellipsoid_log_density),
        physical=lambda y: {"x": np.array(y[:n]), "p": np.array(y[n:])},
        parameters={"a": squares.tolist()},
        references=ELLIPSOID,
    )
