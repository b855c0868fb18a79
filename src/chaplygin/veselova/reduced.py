"""The reduced Veselova problem on T*S^(n−1), r = 1, in time t.

A rigid body in R^n with the inertia operator 𝓘(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j, eq. (inertia_tensor),
turns about a fixed point so that its angular velocity w lies in γ∧R^n, eq. (VC) with γ = e_1. The
momentum is k = γ∧p, the part of 𝓘w in γ∧R^n, and

    γ̇ = −wγ,  ṗ = −wp,  w = γ∧Aq/U,  U = (γ, A⁻¹γ),  q = (γ, γ) p − (γ, p) γ,

where q is p itself on T*S^(n−1). This is

    γ̇ = ((γ, γ) Aq − (γ, Aq) γ)/U,   ṗ = ((γ, p) Aq − (p, Aq) γ)/U,

eqs. (extended1), (extended2) on T*S^(n−1), but for the sign of ṗ, which is misprinted. As for the
Chaplygin sphere (`chaplygin.ball.reduced`), only q makes w a function of k and the direction of γ, so
that not only (γ, γ), (γ, p), (p, p) but the energy ½⟨k, w⟩ too is kept wherever γ ≠ 0.

The measure has the density U^(−(n−2)/2), as that of the Chaplygin sphere.
"""

from typing import Any

import numpy as np

import geomint as gi
from geomint import part

from ..ball.reduced import reduced_k, reduced_log_density
from ..exact.motions import exact_veselova
from ..initial_states import tangent_arrays
from ..integrable import factors, inner, special_parameters, weighted
from ..literature import VESELOVA
from ..manifold import Array
from .initial_states import veselova_tangent


@gi.field
def veselova_field(params, t, y, out, work):
    """γ̇ = −wγ, ṗ = −wp; y = (γ, p)."""
    n = len(y) // 2
    _, b, a = factors(params, n)
    momentum = part(y, n, n)
    g2, gp, u = inner(n, y, y), inner(n, y, momentum), weighted(n, b, y, y)
    gag, gap = weighted(n, a, y, y), weighted(n, a, y, momentum)
    pap = weighted(n, a, momentum, momentum)
    r = 1.0 / u
    gaq, paq = r * (g2 * gap - gp * gag), r * (g2 * pap - gp * gap)
    rg2, rgp = r * g2, r * gp
    for i in range(n):
        g, p = y[i], y[n + i]
        aq = a[i] * (g2 * p - gp * g)
        out[i] = rg2 * aq - gaq * g
        out[n + i] = rgp * aq - paq * g


@gi.field
def veselova_generator(params, t, y, out, work):
    """ξ = −w = Aq∧γ/U."""
    n = len(y) // 2
    _, b, a = factors(params, n)
    g2, gp, u = inner(n, y, y), inner(n, y, part(y, n, n)), weighted(n, b, y, y)
    r = 1.0 / u
    pair = 0
    for i in range(n):
        x, aq = y[i], a[i] * (g2 * y[n + i] - gp * y[i])
        for j in range(i + 1, n):
            z, other = y[j], a[j] * (g2 * y[n + j] - gp * y[j])
            out[pair] = r * (aq * z - x * other)
            pair += 1


@gi.observable
def veselova_energy(params, t, y, work):
    """½⟨𝓘w, w⟩ = ½⟨k, w⟩ = (q, Aq)/(2U), which is (p, Ap)/(2U) on T*S^(n−1)."""
    n = len(y) // 2
    _, b, a = factors(params, n)
    p = part(y, n, n)
    g2, gp, u = inner(n, y, y), inner(n, y, p), weighted(n, b, y, y)
    gag, gap, pap = weighted(n, a, y, y), weighted(n, a, y, p), weighted(n, a, p, p)
    return 0.5 * (g2 * (g2 * pap - gp * gap) - gp * (g2 * gap - gp * gag)) / u


def veselova_reduced_problem(a: Array, D: float) -> gi.Problem:
    """Return the reduced Veselova problem with r = 1.

    State: ``gamma`` (n,) and ``p`` (n,) ⟂ γ, with k = γ∧p. Time t. Forms: ODE and action of
    SO(n).
    ``state(gamma=…, p=…)``; instead of p also p_tilde, k or w.

    Parameters
    ----------
    a, D
        See `Veselova`.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a γ or p that describes no state; see `manifold`.
    """
    n = len(a)
    params, integrals = special_parameters(a, D, True)

    space = gi.TangentSphere(n)

    def make_state(gamma: Any = None, **components: Any) -> Array:
        return np.concatenate(veselova_tangent(a, D, gamma, **components))

    return gi.Problem(
        name="veselova-reduced",
        equations=(
            "γ̇ = −wγ,  ṗ = −wp",
            "w = γ∧Ap/U,  U = (γ, A⁻¹γ)",
        ),
        space=space,
        params=params,
        field=veselova_field,
        action=space.action(veselova_generator),
        invariants={"energy": veselova_energy, "K": reduced_k, **integrals},
        measure=gi.Measure(reduced_log_density),
        make_state=make_state,
        make_exact=exact_veselova(a, D, True),
        physical=tangent_arrays,
        parameters={"a": a.tolist(), "D": D},
        references=VESELOVA,
    )
