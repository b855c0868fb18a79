"""The Hamiltonised Veselova problem: a geodesic flow on T*S^(n−1) in time τ.

dτ = dt/(D√U), p̃ = p/(D√U), U = (γ, A⁻¹γ): eqs. (CM), (mapping), the same as for the Chaplygin sphere.
The Hamiltonian is 𝓗 = ½D² (p̃, Ap̃), eq. (ham:ves), which is the energy. The field is the extended one,

    γ′ = D² Ap̃ − μγ,                 μ = D² (γ, Ap̃)/(γ, γ),
    p̃′ = −D² (p̃, Ap̃) γ/(γ, γ) + μp̃.

With the factors 1/(γ, γ) it keeps (γ, γ), (γ, p̃) and 𝓗 wherever γ ≠ 0. All three are quadratic: a
Gauss method keeps them to round-off at any step.

The Hamiltonian form is that of 𝓗̃ = 𝓗 − D² (γ, p̃)(γ, Ap̃), which agrees with 𝓗 on T*S^(n−1): as
(γ, ∂𝓗̃/∂p̃) is −D² (γ, Aγ)(γ, p̃) where |γ| = 1, the hidden constraint of the method is (γ, p̃) = 0.
"""

from typing import Any

import numpy as np

import geomint as gi
from geomint import fma, part

from ..ball.hamiltonized import hamiltonized_clock, hamiltonized_k
from ..exact.motions import exact_veselova
from ..initial_states import multiplier, tangent_arrays
from ..integrable import factors, inner, special_parameters, weighted
from ..literature import VESELOVA
from ..manifold import Array, Arrays
from .initial_states import veselova_tangent


@gi.field
def geodesic_field(params, t, y, out, work):
    """Write the flow of 𝓗; y = (γ, p̃)."""
    n = len(y) // 2
    D, _, a = factors(params, n)
    d2 = D[0] * D[0]
    g, p = y[0], y[n]
    ap = a[0] * p
    rest, gap, pap = fma(-g, g, 1.0), g * ap, p * ap
    for i in range(1, n):
        g, p = y[i], y[n + i]
        ap = a[i] * p
        rest = fma(-g, g, rest)
        gap += g * ap
        pap += p * ap
    # 1/(γ, γ) = 1 + excess, without the biased rounding of (γ, γ) and its inverse near 1.
    excess = rest / (1.0 - rest)
    mu = d2 * gap
    mu += mu * excess
    lam = d2 * pap
    lam += lam * excess
    for i in range(n):
        g, p = y[i], y[n + i]
        out[i] = (d2 * a[i]) * p - mu * g
        out[n + i] = mu * p - lam * g


@gi.observable
def geodesic_energy(params, t, y, work):
    """𝓗 = ½D² (p̃, Ap̃), eq. (ham:ves)."""
    n = len(y) // 2
    D, _, a = factors(params, n)
    p = part(y, n, n)
    return 0.5 * D[0] * D[0] * weighted(n, a, p, p)


@gi.field
def geodesic_gradients(params, t, q, p, dq, dp, work):
    """Both gradients of 𝓗̃ = 𝓗 − D² (γ, p̃)(γ, Ap̃)."""
    n = len(q)
    D, _, a = factors(params, n)
    d2 = D[0] * D[0]
    gp, gap = inner(n, q, p), weighted(n, a, q, p)
    for i in range(n):
        x, z, ai = q[i], p[i], a[i]
        dq[i] = -d2 * (gap + gp * ai) * z
        dp[i] = d2 * (ai * z - (gap + gp * ai) * x)


def veselova_hamiltonized_problem(a: Array, D: float) -> gi.Problem:
    """Return the Hamiltonised flow of the Veselova problem with r = 1.

    State: ``gamma`` (n,) and ``p_tilde`` (n,) ⟂ γ. Time τ, with the clock dt/dτ = D√U. Forms:
    ODE and Hamiltonian with the constraint |γ| = 1.
    ``state(gamma=…, p_tilde=…)``; instead of p_tilde also p, k or w.

    Parameters
    ----------
    a, D
        See `Veselova`.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a γ or p̃ that describes no state; see `manifold`.
    """
    n = len(a)
    params, integrals = special_parameters(a, D, False)

    space = gi.TangentSphere(n, ("gamma", "p_tilde"))

    def make_state(gamma: Any = None, **components: Any) -> Array:
        vertical, p = veselova_tangent(a, D, gamma, **components)
        return np.concatenate([vertical, p / multiplier(a, D, vertical)])

    def physical(y: Array) -> Arrays:
        return tangent_arrays(y, multiplier(a, D, y[:n]))

    return gi.Problem(
        name="veselova-hamiltonized",
        equations=(
            "H = ½D²(p̃, Ap̃)",
            "γ′ = D²Ap̃ − μγ,  p̃′ = −D²(p̃, Ap̃)γ + μp̃,  μ = D²(γ, Ap̃)",
            "′ = d/dτ,  dτ = dt/(D√U),  U = (γ, A⁻¹γ)",
        ),
        space=space,
        params=params,
        field=geodesic_field,
        hamiltonian=space.hamiltonian(geodesic_gradients),
        time="tau",
        clock=hamiltonized_clock,
        invariants={"energy": geodesic_energy, "K": hamiltonized_k, **integrals},
        measure=gi.Measure(),
        make_state=make_state,
        make_random=gi.TangentSphere(n).random,
        make_exact=exact_veselova(a, D, False),
        physical=physical,
        parameters={"a": a.tolist(), "D": D},
        references=VESELOVA,
    )
