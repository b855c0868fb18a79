"""The Hamiltonised Chaplygin sphere: a geodesic flow on T*S^(n−1) in time τ, special inertia.

dτ = dt/(D√U), p̃ = p/(D√U), U = (γ, A⁻¹γ): eqs. (CM), (mapping). The field is the extended one,

    γ′ = D U p̃ − Ap̃ − μγ,            μ = (D U (γ, p̃) − (γ, Ap̃))/(γ, γ),
    p̃′ = −D (p̃, p̃) A⁻¹γ + (p̃, Ap̃) γ/(γ, γ) + μp̃,

eqs. (ham_q), (ham_p). With the factors 1/(γ, γ) it keeps (γ, γ), (γ, p̃) and H wherever γ ≠ 0;
without them (γ, p̃) grows with the defect of |γ|.

The Hamiltonian form is that of H̃ = H + (γ, p̃)(γ, Ap̃), which agrees with
H = ½(D U (p̃, p̃) − (p̃, Ap̃)), eq. (hamiltonian*), on T*S^(n−1): as (γ, ∂H̃/∂p̃) is
(D U + (γ, Aγ))(γ, p̃), the hidden constraint of the method is (γ, p̃) = 0.
"""

from typing import Any

import numpy as np

import geomint as gi
from geomint import fma, part

from ..exact.motions import exact_sphere
from ..inertia import SpecialInertia, parameters_of
from ..initial_states import initial_tangent, multiplier, tangent_arrays
from ..integrable import factors, inner, physical_scale, special_parameters, weighted
from ..literature import BALL
from ..manifold import Array, Arrays
from .hamiltonized_splitting import hamiltonized_splitting, splitting_parameters
from .path import integrated_path


@gi.field
def hamiltonized_field(params, t, y, out, work):
    """Eqs. (ham_q), (ham_p); y = (γ, p̃)."""
    n = len(y) // 2
    D, b, a = factors(params, n)
    g, p = y[0], y[n]
    ap = a[0] * p
    rest, u, pp = fma(-g, g, 1.0), b[0] * g * g, p * p
    gp, gap, pap = g * p, g * ap, p * ap
    for i in range(1, n):
        g, p = y[i], y[n + i]
        ap = a[i] * p
        rest = fma(-g, g, rest)
        u += b[i] * g * g
        pp += p * p
        gp += g * p
        gap += g * ap
        pap += p * ap
    # 1/(γ, γ) = 1 + excess. Near 1 the rounding of (γ, γ) and of its inverse is biased, and makes
    # (γ, p̃) drift by 3e-17 a unit of τ; 1 − (γ, γ) by fused multiply-adds is not.
    excess = rest / (1.0 - rest)
    du = D[0] * u
    mu = du * gp - gap
    mu += mu * excess
    lam = pap + pap * excess
    dpp = D[0] * pp
    # a_i p_i and b_i γ_i are the products of the sums above, rounded alike, so that what they lack
    # cancels in (γ, p̃). D U − a_i would round the last digits of a_i the same way in every step, and
    # (γ, p̃) drift by 6e-18 a unit of τ.
    for i in range(n):
        g, p = y[i], y[n + i]
        out[i] = fma(du, p, -(a[i] * p)) - mu * g
        out[n + i] = fma(lam, g, -(dpp * (b[i] * g))) + mu * p


@gi.observable
def hamiltonized_clock(params, t, y, work):
    """dt/dτ = D√U, eq. (CM)."""
    n = len(y) // 2
    return physical_scale(n, params, y)


@gi.observable
def hamiltonized_energy(params, t, y, work):
    """H = ½(D U (p̃, p̃) − (p̃, Ap̃)), eq. (hamiltonian*)."""
    n = len(y) // 2
    D, b, a = factors(params, n)
    p = part(y, n, n)
    return 0.5 * (D[0] * weighted(n, b, y, y) * inner(n, p, p) - weighted(n, a, p, p))


@gi.observable
def hamiltonized_k(params, t, y, work):
    """K = D²U (p̃, p̃) = (p, p) = ⟨k, k⟩."""
    n = len(y) // 2
    D, b, _ = factors(params, n)
    p = part(y, n, n)
    return D[0] * D[0] * weighted(n, b, y, y) * inner(n, p, p)


@gi.field
def hamiltonized_gradients(params, t, q, p, dq, dp, work):
    """Both gradients of H̃ = H + (γ, p̃)(γ, Ap̃)."""
    n = len(q)
    D, b, a = factors(params, n)
    x, z = q[0], p[0]
    az = a[0] * z
    u, pp, gp, gap = b[0] * x * x, z * z, x * z, x * az
    for i in range(1, n):
        x, z = q[i], p[i]
        az = a[i] * z
        u += b[i] * x * x
        pp += z * z
        gp += x * z
        gap += x * az
    du, dpp = D[0] * u, D[0] * pp
    for i in range(n):
        x, z, bi, ai = q[i], p[i], b[i], a[i]
        dq[i] = dpp * bi * x + (gap + gp * ai) * z
        dp[i] = (du - ai) * z + (gap + gp * ai) * x


def hamiltonized_problem(inertia: SpecialInertia) -> gi.Problem:
    """Return the Hamiltonised flow of a sphere with the special inertia operator.

    State: ``gamma`` (n,) and ``p_tilde`` (n,) ⟂ γ. Time τ, with the clock dt/dτ = D√U. Forms:
    ODE, Hamiltonian with the constraint |γ| = 1, and splitting.
    ``state(gamma=…, p_tilde=…)``; instead of p_tilde also p, or k or omega with zero
    SO(n−1)-momentum.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a γ or p̃ that describes no state; see `manifold`.
    """
    n, D = inertia.n, inertia.D
    params, integrals = special_parameters(inertia.a, D, False, splitting_parameters(inertia))

    space = gi.TangentSphere(n, ("gamma", "p_tilde"))

    def make_state(gamma: Any = None, **components: Any) -> Array:
        vertical, p = initial_tangent(inertia, D, gamma, **components)
        return np.concatenate([vertical, p / multiplier(inertia.a, D, vertical)])

    def physical(y: Array) -> Arrays:
        return tangent_arrays(y, multiplier(inertia.a, D, y[:n]))

    return gi.Problem(
        name="chaplygin-sphere-hamiltonized",
        equations=(
            "H = ½(D U (p̃, p̃) − (p̃, Ap̃)),  U = (γ, A⁻¹γ)",
            "γ′ = D U p̃ − Ap̃ − μγ,  p̃′ = −D(p̃, p̃)A⁻¹γ + (p̃, Ap̃)γ + μp̃,  μ = −(γ, Ap̃)",
            "′ = d/dτ,  dτ = dt/(D√U)",
        ),
        space=space,
        params=params,
        field=hamiltonized_field,
        hamiltonian=space.hamiltonian(hamiltonized_gradients),
        splitting=hamiltonized_splitting(n),
        time="tau",
        clock=hamiltonized_clock,
        invariants={"energy": hamiltonized_energy, "K": hamiltonized_k, **integrals},
        measure=gi.Measure(),
        make_state=make_state,
        make_random=gi.TangentSphere(n).random,
        make_exact=exact_sphere(inertia.a, D, False),
        make_path=integrated_path(inertia, D, physical),
        physical=physical,
        parameters=parameters_of(inertia, D),
        references=BALL,
    )
