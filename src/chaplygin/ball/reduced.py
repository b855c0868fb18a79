"""The reduced Chaplygin sphere on T*S^(n−1) in time t.

γ̇ = −ωγ, ṗ = −ωp, eqs. (r1), (r2), for k = γ∧p. For the special inertia operator, with
U = (γ, A⁻¹γ) and q = (γ, γ) p − (γ, p) γ, which is p itself on T*S^(n−1),

    ω = (A⁻¹γ∧q − γ∧Aq/D)/(DU),

at the cost of O(n) an evaluation:

    γ̇ = q/D − (γ, γ) Aq/(D²U) + (γ, Aq) γ/(D²U),
    ṗ = (A⁻¹γ, p) q/(DU) − (γ, p) Aq/(D²U) − (q, p) A⁻¹γ/(DU) + (p, Aq) γ/(D²U).

This is eqs. (ro1), (ro2) on T*S^(n−1), but not off it: the equations as printed have p for q. Both
keep (γ, γ), (γ, p) and (p, p) wherever γ ≠ 0; only with q is ω that of the momentum k = γ∧p, so
that the energy ½⟨k, ω⟩ is kept as well. With p for q round-off in (γ, p), which grows like t, makes
the energy drift like t² (n = 3, t = 8000: by 1.4e-11 instead of 7e-14).

Any other operator takes ω from k = γ∧p as the ball does (`angular_velocity`): O(n³).
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import log, part

from ..exact.motions import exact_sphere
from ..inertia import Inertia, SpecialInertia, parameters_of
from ..initial_states import initial_tangent, tangent_arrays
from ..integrable import factors, inner, special_parameters, weighted
from ..literature import BALL
from ..manifold import Array, Named, triangle_rows
from ..operators import in_two
from .angular_velocity import log_density_after, omega_for, omega_work, wedge_sum
from .fields import BallForms, turn_vectors, turning_forms
from .path import integrated_path


@gi.field
def reduced_field(params, t, y, out, work):
    """Eqs. (ro1), (ro2) with q for p in ω; y = (γ, p)."""
    n = len(y) // 2
    D, b, a = factors(params, n)
    g, p = y[0], y[n]
    bg, ag, ap = b[0] * g, a[0] * g, a[0] * p
    g2, u, pp, gp, bgp = g * g, bg * g, p * p, g * p, bg * p
    gag, gap, pap = g * ag, g * ap, p * ap
    for i in range(1, n):
        g, p = y[i], y[n + i]
        bg, ag, ap = b[i] * g, a[i] * g, a[i] * p
        g2 += g * g
        u += bg * g
        pp += p * p
        gp += g * p
        bgp += bg * p
        gag += g * ag
        gap += g * ap
        pap += p * ap
    s = 1.0 / (D[0] * D[0] * u)
    r = D[0] * s
    gaq, paq, pq = s * (g2 * gap - gp * gag), s * (g2 * pap - gp * gap), r * (g2 * pp - gp * gp)
    ru, rbgp, sg2, sgp = r * u, r * bgp, s * g2, s * gp
    for i in range(n):
        g, bi, ai = y[i], b[i], a[i]
        q = g2 * y[n + i] - gp * g
        out[i] = (ru - sg2 * ai) * q + gaq * g
        out[n + i] = (rbgp - sgp * ai) * q + (paq - pq * bi) * g


@gi.field
def reduced_generator(params, t, y, out, work):
    """ξ = −ω = (γ∧Aq/D − A⁻¹γ∧q)/(DU)."""
    n = len(y) // 2
    D, b, a = factors(params, n)
    g2, gp, u = inner(n, y, y), inner(n, y, part(y, n, n)), weighted(n, b, y, y)
    r = 1.0 / (D[0] * u)
    s = r / D[0]
    pair = 0
    for i in range(n):
        x, q, bi, ai = y[i], g2 * y[n + i] - gp * y[i], b[i], a[i]
        for j in range(i + 1, n):
            z, other = y[j], g2 * y[n + j] - gp * y[j]
            # One factor for both products: b_i and −a_j/D cancel where a_i a_j → D.
            out[pair] = (s * a[j] - r * bi) * (x * other) - (s * ai - r * b[j]) * (z * q)
            pair += 1


@gi.observable
def reduced_energy(params, t, y, work):
    """H = ½⟨k, ω⟩ = (D U K − (q, Aq))/(2D²U), eq. (hamiltonian) with q for p."""
    n = len(y) // 2
    D, b, a = factors(params, n)
    p = part(y, n, n)
    g2, gp, pp = inner(n, y, y), inner(n, y, p), inner(n, p, p)
    u, gag = weighted(n, b, y, y), weighted(n, a, y, y)
    gap, pap = weighted(n, a, y, p), weighted(n, a, p, p)
    qaq = g2 * (g2 * pap - gp * gap) - gp * (g2 * gap - gp * gag)
    return 0.5 * (D[0] * u * (g2 * pp - gp * gp) - qaq) / (D[0] * D[0] * u)


@gi.observable
def reduced_k(params, t, y, work):
    """K = (γ, γ)(p, p) − (γ, p)² = ⟨k, k⟩, eq. (IK)."""
    n = len(y) // 2
    p = part(y, n, n)
    gp = inner(n, y, p)
    return inner(n, y, y) * inner(n, p, p) - gp * gp


@gi.observable
def reduced_log_density(params, t, y, work):
    """Return log μ = −(n − 2)/2 log U, eq. (DENSITY)."""
    n = len(y) // 2
    _, b, _ = factors(params, n)
    return -0.5 * (n - 2) * log(weighted(n, b, y, y))


@functools.cache
def general_forms(omega: Any, n: int) -> BallForms:
    """Return the functions for an operator whose ω `omega` writes; y = (γ, p), eqs. (r1), (r2).

    The measure, eq. (mu*), is that which the ball's induces where the momentum is zero.
    """
    size = triangle_rows(n)
    log_density, wedge = log_density_after(omega), wedge_sum(n, 1)

    def reduced_velocity(params, y, work):
        w, k, rest = in_two(work, size)
        wedge(part(y, 0, n), part(y, n, n), k)
        omega(n, params, k, part(y, 0, n), w, rest)
        return k, w, rest

    def reduced_density(params, y, rest):
        return log_density(n, params, part(y, 0, n), rest)

    return turning_forms(n, turn_vectors, gi.helper(reduced_velocity), gi.helper(reduced_density))


def reduced_problem(inertia: Inertia, D: float) -> gi.Problem:
    """Return the reduced system, which describes a ball without SO(n−1)-momentum.

    State: ``gamma`` (n,) and ``p`` (n,) ⟂ γ, with k = γ∧p. Time t. Forms: ODE and action of
    SO(n).
    ``state(gamma=…, p=…)``; instead of p also p_tilde (special operator), or k or omega with zero
    SO(n−1)-momentum.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a γ or p that describes no state; see `manifold`.
    """
    n = inertia.n
    integrals: Named = {}
    exact = None
    if isinstance(inertia, SpecialInertia):
        exact = exact_sphere(inertia.a, D, True)
        field, generator, energy = reduced_field, reduced_generator, reduced_energy
        log_density, work = reduced_log_density, 0
        params, integrals = special_parameters(inertia.a, D, True)
    else:
        omega, params = omega_for(inertia, D)
        field, generator, energy, log_density = general_forms(omega, n)
        work = n * (n - 1) + omega_work(omega, n)

    space = gi.TangentSphere(n)

    def make_state(gamma: Any = None, **components: Any) -> Array:
        return np.concatenate(initial_tangent(inertia, D, gamma, **components))

    return gi.Problem(
        name="chaplygin-sphere-reduced",
        equations=(
            "γ̇ = −ωγ,  ṗ = −ωp",
            "k = γ∧p = Iω + D(ωγγᵀ + γγᵀω)",
        ),
        space=space,
        params=params,
        field=field,
        action=space.action(generator),
        work=work,
        invariants={"energy": energy, "K": reduced_k, **integrals},
        measure=gi.Measure(log_density),
        make_state=make_state,
        make_exact=exact,
        make_path=integrated_path(inertia, D, tangent_arrays),
        physical=tangent_arrays,
        parameters=parameters_of(inertia, D),
        references=BALL,
    )
