"""Neumann's and Clebsch's systems on T*S^(n−1): integrable motions in quadratic potentials.

With m_ij = q_i v_j − q_j v_i and the weights x, y of two commuting flows,

    H = ½ Σ_{i<j} c_ij m_ij² + ½ Σ d_i q_i²,   c_ij = x + y/(a_i a_j),   d_i = σ(x a_i − y/a_i).

x = 1, y = 0 is Neumann's system: a point on the sphere in the potential ½σ(q, Aq). At n = 3,
M⃗ = q⃗ × v⃗ has Kirchhoff's equations of a body in an ideal fluid in Clebsch's case, with the area
constant (M⃗, q⃗) = 0. Both have the n − 1 integrals N_k, the coefficients of z^k in

    N(z) = Σ_{i<j} m_ij² P(z)/((z − a_i)(z − a_j)) + σ Σ_i q_i² P(z)/(z − a_i),   P(z) = Π(z − a_i),

polynomials for equal a_i too; H = ½x (N_(n−2) + σ tr A) + ½(−1)ⁿ y N_0/Πa, N_(n−1) = σ.

The equations, which keep (q, q), (q, v) and H off the manifold too, are with W_ij = c_ij m_ij

    q′ = −Wq,   v′ = −Wv − f + ((q, f)/(q, q)) q,   f_i = d_i q_i.

On N_0 = 0 they are the Hamiltonised Veselova problem and Chaplygin sphere: see
`chaplygin.correspondence`.
"""

import functools
from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import section

from ..commuting_integrals import coefficient_tables, table, tabulated, weighted_minors
from ..inertia import positive_vector
from ..integrable import inner, weighted
from ..literature import CLEBSCH, NEUMANN
from ..manifold import Array, Named, triangle_rows

Clebsch = namedtuple("Clebsch", "sigma d c tables")


@gi.helper
def clebsch_rows(n):
    """Return the layout of the parameters: σ, d_i, c_ij, and the tables of the integrals."""
    return Clebsch(sigma=1, d=n, c=n * (n - 1) // 2, tables=gi.REST)


@gi.helper
def quadratic(params, n):
    """Return the blocks of d_i and c_ij."""
    return section(params, clebsch_rows(n), "d"), section(params, clebsch_rows(n), "c")


@gi.field
def neumann_field(params, t, y, out, work):
    """Write the flow of ½|m|² + ½(q, dq)."""
    n = len(y) // 2
    d, _ = quadratic(params, n)
    v = gi.part(y, n, n)
    qq, qv = inner(n, y, y), inner(n, y, v)
    lam = weighted(n, d, y, y) / qq - inner(n, v, v)
    for i in range(n):
        out[i] = qq * v[i] - qv * y[i]
        out[n + i] = qv * v[i] + (lam - d[i]) * y[i]


@gi.field
def neumann_force(params, t, q, out, work):
    """Write dq, the gradient of ½(q, dq)."""
    d, _ = quadratic(params, len(q))
    for i in range(len(q)):
        out[i] = d[i] * q[i]


@gi.field
def neumann_gradients(params, t, q, p, dq, dp, work):
    """Both gradients of ½(p, p) + ½(q, dq)."""
    d, _ = quadratic(params, len(q))
    for i in range(len(q)):
        dq[i] = d[i] * q[i]
        dp[i] = 1.0 * p[i]


@functools.cache
def clebsch_forms(n: int) -> Named:
    """Return field, gradients and energy."""

    @gi.helper
    def turned(c, q, v, dq, dv):
        """Write −Wq and −Wv."""
        for i in range(n):
            dq[i] = 0.0 * q[i]
            dv[i] = 0.0 * q[i]
        at = 0
        for i in range(n):
            for j in range(i + 1, n):
                w = c[at] * (q[i] * v[j] - q[j] * v[i])
                dq[i] -= w * q[j]
                dq[j] += w * q[i]
                dv[i] -= w * v[j]
                dv[j] += w * v[i]
                at += 1

    def clebsch_field(params, t, y, out, work):
        q, v = gi.part(y, 0, n), gi.part(y, n, n)
        d, c = quadratic(params, n)
        turned(c, q, v, gi.part(out, 0, n), gi.part(out, n, n))
        lam = weighted(n, d, q, q) / inner(n, q, q)
        for i in range(n):
            out[n + i] += (lam - d[i]) * q[i]

    def clebsch_gradients(params, t, q, p, dq, dp, work):
        """Both gradients of H + ½(q, p)², whose hidden constraint is (q, p) = 0."""
        d, c = quadratic(params, n)
        turned(c, q, p, dp, dq)
        qp = inner(n, q, p)
        for i in range(n):
            dp[i] += qp * q[i]
            dq[i] = d[i] * q[i] + qp * p[i] - dq[i]

    def clebsch_energy(params, t, y, work):
        """Return H."""
        d, c = quadratic(params, n)
        total, at = 0.0 * y[0], 0
        for i in range(n):
            total += d[i] * (y[i] * y[i])
            for j in range(i + 1, n):
                m = y[i] * y[n + j] - y[j] * y[n + i]
                total += c[at] * (m * m)
                at += 1
        return 0.5 * total

    return {
        "field": gi.field(clebsch_field),
        "gradients": gi.field(clebsch_gradients),
        "energy": gi.observable(clebsch_energy),
    }


@functools.cache
def neumann_integral(n: int, k: int) -> Any:
    """Return σ Σ d_i q_i² + Σ c_ij m_ij² with the weights of the k-th table."""

    def neumann_coefficient(params, t, y, work):
        """Return a coefficient of the polynomial with s_i = σ q_i²."""
        rows = clebsch_rows(n)
        sigma = section(params, rows, "sigma")[0]
        d, c = table(n, section(params, rows, "tables"), k)
        total = weighted_minors(n, c, y)
        for i in range(n):
            total += sigma * d[i] * (y[i] * y[i])
        return total

    return gi.observable(neumann_coefficient)


def space(n: int) -> gi.TangentBundle:
    """T*S^(n−1) with positions q and velocities v."""
    return gi.TangentSphere(n, ("q", "v"))


def clebsch_problem(a: Any, strength: Any, x: Any, y: Any) -> gi.Problem:
    """Return Clebsch's system on T*S^(n−1), a flow that commutes with Neumann's.

    State: ``q`` (n,) and ``v`` (n,) ⟂ q. Time t. Forms: ODE and Hamiltonian with the constraint
    |q| = 1. ``state(q=…, v=…)``, projected with a warning if need be. The integrals besides H go by
    "N0" … "N(n−2)".

    Parameters
    ----------
    a : array_like, shape (n,)
        a_i > 0; equal ones are welcome.
    strength : float
        σ; may be negative.
    x, y : float
        Weights; x = 1, y = 0 is Neumann's system.

    Raises
    ------
    geomint.DomainError
        For other a; from ``state`` and ``canonical`` for what describes no state.
    """
    values = positive_vector("a", a)
    n = len(values)
    sigma, wx, wy = (
        float(gi.as_vector(*pair, 1)[0]) for pair in (("strength", strength), ("x", x), ("y", y))
    )
    i, j = np.triu_indices(n, 1)
    forms = clebsch_forms(n)
    return _problem(
        "clebsch",
        values,
        sigma,
        sigma * (wx * values - wy / values),
        wx + wy / (values[i] * values[j]),
        forms["energy"],
        {"strength": sigma, "x": wx, "y": wy},
        field=forms["field"],
        hamiltonian=space(n).hamiltonian(forms["gradients"]),
    )


def neumann_problem(a: Any, strength: Any = 1.0) -> gi.Problem:
    """Return Neumann's system: a point on S^(n−1) in the potential ½σ(q, Aq).

    State: ``q`` (n,) and ``v`` (n,) ⟂ q, the velocity. Time t. Forms: ODE, separable Hamiltonian with
    the constraint |q| = 1, and the splitting into kicks and great circles.
    ``state(q=…, v=…)``, projected with a warning if need be. The integrals besides H go by "N0" …
    "N(n−3)"; N_(n−2) is 2H − σ tr A.

    Parameters
    ----------
    a : array_like, shape (n,)
        a_i > 0; equal ones are welcome.
    strength : float
        σ; may be negative.

    Raises
    ------
    geomint.DomainError
        For other a; from ``state`` and ``canonical`` for what describes no state.
    """
    values = positive_vector("a", a)
    n = len(values)
    sigma = float(gi.as_vector("strength", strength, 1)[0])
    return _problem(
        "neumann",
        values,
        sigma,
        sigma * values,
        np.ones(triangle_rows(n)),
        clebsch_forms(n)["energy"],
        {"strength": sigma},
        field=neumann_field,
        hamiltonian=space(n).hamiltonian(neumann_gradients, separable=True),
        splitting=gi.natural_on_sphere(neumann_force),
    )


def _problem(
    name: str,
    a: Array,
    sigma: float,
    d: Array,
    c: Array,
    energy: Any,
    parameters: dict[str, float],
    **forms: Any,
) -> gi.Problem:
    """Return the problem with those d_i and c_ij."""
    n = len(a)
    degrees = tabulated(n, range(n - 2 if name == "neumann" else n - 1))
    tables = coefficient_tables(a, degrees, 0)
    integrals = {f"N{k}": neumann_integral(n, at) for at, k in enumerate(degrees)}
    return gi.Problem(
        name=name,
        equations=(
            "q′ = −Wq,  v′ = −Wv − f + (q, f)q,  W_ij = c_ij(q_i v_j − q_j v_i),  f_i = d_i q_i",
            "c_ij = x + y/(a_i a_j),  d_i = σ(x a_i − y/a_i)",
        ),
        space=space(n),
        params=gi.packed(clebsch_rows(n), sigma=sigma, d=d, c=c, tables=tables).data,
        invariants={"energy": energy, **integrals},
        measure=gi.Measure(),
        physical=lambda y: {"q": np.array(y[:n]), "v": np.array(y[n:])},
        parameters={"a": a.tolist(), **parameters},
        references=NEUMANN if name == "neumann" else CLEBSCH,
        **forms,
    )
