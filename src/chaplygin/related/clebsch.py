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
`chaplygin.correspondence`. Sources: C. Neumann (1859), A. Clebsch (1871), J. Moser, *Geometry of
quadrics and spectral theory* (1980).
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import geomint as gi

from ..commuting_integrals import coefficient_tables, neumann_integral, table_rows, tabulated
from ..inertia import positive_vector
from ..manifold import Array

__all__ = ["clebsch_problem", "neumann_problem"]

HEADER = 1  # the parameters begin with σ; then come d_i and c_ij, then the tables of the integrals


@gi.field
def neumann_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Write the flow of ½|m|² + ½(q, dq); params = [σ, d…, …]."""
    n = len(y) // 2
    qq, qv, vv, qf = y[0] * y[0], y[0] * y[n], y[n] * y[n], params[1] * y[0] * y[0]
    for i in range(1, n):
        q, v = y[i], y[n + i]
        qq += q * q
        qv += q * v
        vv += v * v
        qf += params[1 + i] * q * q
    lam = qf / qq - vv
    for i in range(n):
        q, v = y[i], y[n + i]
        out[i] = qq * v - qv * q
        out[n + i] = qv * v + (lam - params[1 + i]) * q


@gi.field
def neumann_force(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    """Write dq, the gradient of ½(q, dq)."""
    for i in range(len(q)):
        out[i] = params[1 + i] * q[i]


@gi.field
def neumann_gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    """Both gradients of ½(p, p) + ½(q, dq)."""
    for i in range(len(q)):
        dq[i] = params[1 + i] * q[i]
        dp[i] = 1.0 * p[i]


@functools.cache
def clebsch_forms(n: int) -> dict[str, Any]:
    """Return field, gradients and energy; params = [σ, d…, c…, …]."""
    first = HEADER + n

    @gi.helper
    def turned(params: Any, q: Any, v: Any, dq: Any, dv: Any) -> None:
        """Write −Wq and −Wv."""
        for i in range(n):
            dq[i] = 0.0 * q[i]
            dv[i] = 0.0 * q[i]
        at = first
        for i in range(n):
            for j in range(i + 1, n):
                w = params[at] * (q[i] * v[j] - q[j] * v[i])
                dq[i] = dq[i] - w * q[j]
                dq[j] = dq[j] + w * q[i]
                dv[i] = dv[i] - w * v[j]
                dv[j] = dv[j] + w * v[i]
                at += 1

    def clebsch_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        q, v = gi.part(y, 0, n), gi.part(y, n, n)
        turned(params, q, v, gi.part(out, 0, n), gi.part(out, n, n))
        qq, qf = q[0] * q[0], params[1] * q[0] * q[0]
        for i in range(1, n):
            qq += q[i] * q[i]
            qf += params[1 + i] * q[i] * q[i]
        lam = qf / qq
        for i in range(n):
            out[n + i] = out[n + i] + (lam - params[1 + i]) * q[i]

    def clebsch_gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
        """Both gradients of H + ½(q, p)², whose hidden constraint is (q, p) = 0."""
        turned(params, q, p, dp, dq)
        qp = q[0] * p[0]
        for i in range(1, n):
            qp += q[i] * p[i]
        for i in range(n):
            dp[i] = dp[i] + qp * q[i]
            dq[i] = params[1 + i] * q[i] + qp * p[i] - dq[i]

    def clebsch_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
        """Return H."""
        total = 0.0 * y[0]
        at = first
        for i in range(n):
            total += params[1 + i] * (y[i] * y[i])
            for j in range(i + 1, n):
                m = y[i] * y[n + j] - y[j] * y[n + i]
                total += params[at] * (m * m)
                at += 1
        return 0.5 * total

    return {
        "field": gi.field(clebsch_field),
        "gradients": gi.field(clebsch_gradients),
        "energy": gi.observable(clebsch_energy),
    }


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
        np.ones(n * (n - 1) // 2),
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
    start = np.concatenate([[sigma], d, c])
    rows = table_rows(n)
    integrals = {
        f"N{k}": neumann_integral(n, len(start) + at * rows) for at, k in enumerate(degrees)
    }

    return gi.Problem(
        name=name,
        space=space(n),
        params=np.concatenate([start, coefficient_tables(a, degrees, 0)]),
        invariants={"energy": energy, **integrals},
        measure=gi.Measure(),
        physical=lambda y: {"q": np.array(y[:n]), "v": np.array(y[n:])},
        parameters={"a": a.tolist(), **parameters},
        **forms,
    )
