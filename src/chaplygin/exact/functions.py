"""Compiled: from times to angles, from angles to states; for `geomint.pointwise`.

The parameters are packed by `packing`.

States from θ, without a division where a λ is at its turning point. With γ_g for a component (or ρ),

    γ_g² = Π_k |α_g − λ_k| / Π_{h≠g} |α_g − α_h|,
    p̃_g = −Σ_k d_k sin θ_k √Q_k/(λ_k Π_{s≠k}(λ_k − λ_s)) · γ_g/(λ_k − α_g).

Where α_g is the lower end of the oval of λ_k, the factor α_g − λ_k is 2d sin²(θ_k/2), and γ_g has the
sign of sin(θ_k/2): smooth, and of period 4π; where it is the upper end, cos. Half the sine then cancels
the root of λ_k − α_g in the momentum. Other components keep their sign. All differences are sums of
numbers of one sign, see `torus`.
"""

import numpy as np

import geomint as gi
from geomint import part, section

from ..operators import after
from .inversion import solve_theta, whole_nearest
from .packing import torus_rows, torus_sizes


def state_work(ovals: int, angles: int) -> int:
    """Rows of scratch that the functions of this module need."""
    return ovals * ovals + 6 * ovals + 3 * angles


def state_rows(n: int) -> int:
    """Rows of what `at_tau` writes: the state, and what is left of Newton's last step."""
    return 2 * n + 1


@gi.helper
def beyond(gap, below, above):
    """Return λ − b, b not within the oval of λ, from the gap between both; see `Torus`."""
    return gap + below if gap > 0.0 else gap - above


@gi.helper
def fill_state(params, theta, psi, out, work):
    """Write (γ, p̃), or (γ, p) where the parameters say so, at θ and ψ."""
    ovals, _, axes, n = torus_sizes(params)
    rows = torus_rows(params)
    radius, signs = section(params, rows, "radius"), section(params, rows, "signs")
    spread, low = section(params, rows, "spread"), section(params, rows, "low")
    high, pair, ell = (
        section(params, rows, "high"),
        section(params, rows, "pair"),
        section(params, rows, "ell"),
    )
    first, second = section(params, rows, "first"), section(params, rows, "second")
    branch_gaps, axis_gaps = (
        section(params, rows, "branch_gaps"),
        section(params, rows, "axis_gaps"),
    )
    oval_gaps, lead = section(params, rows, "oval_gaps"), section(params, rows, "lead")[0]
    below, above = part(work, 0, ovals), part(work, ovals, ovals)
    sin, cos = part(work, 2 * ovals, ovals), part(work, 3 * ovals, ovals)
    weights = part(work, 4 * ovals, ovals)
    physical, scale = section(params, rows, "physical")[0] > 0.0, section(params, rows, "scale")[0]
    for k in range(ovals):
        sin[k], cos[k] = gi.sin(0.5 * theta[k]), gi.cos(0.5 * theta[k])
        below[k] = 2.0 * radius[k] * sin[k] * sin[k]
        above[k] = 2.0 * radius[k] * cos[k] * cos[k]
    for k in range(ovals):
        at = k * (2 * ovals - 1)
        lam = branch_gaps[at] + below[k]  # the first branch point is 0
        q, apart = lead * lam, 1.0
        for b in range(1, 2 * ovals - 1):
            q *= abs(beyond(branch_gaps[at + b], below[k], above[k]))
        for s in range(ovals):
            gap = oval_gaps[k * ovals + s]
            if s < k:
                apart *= gap + (below[k] + above[s])
            elif s > k:
                apart *= gap - (above[k] + below[s])
        weights[k] = -gi.sqrt(q) * radius[k] / (lam * apart)
        if physical:
            scale *= gi.sqrt(lam)
    for i in range(2 * n):
        out[i] = 0.0
    for g in range(axes):
        own = int(max(low[g], high[g]))
        square, momentum = spread[g], 0.0
        for s in range(ovals):
            if s != own:
                gap = beyond(axis_gaps[s * axes + g], below[s], above[s])
                square *= abs(gap)
                momentum += 2.0 * weights[s] * sin[s] * cos[s] / gap
        value = signs[g] * gi.sqrt(square)
        if own >= 0:
            wave, other = sin[own], cos[own]
            if high[g] >= 0:
                wave, other = cos[own], -sin[own]
            value *= gi.sqrt(2.0 * radius[own])
            # 2 sin cos · wave/(± 2d wave²) = ± other/d, the sign being that of the gap.
            momentum = value * wave * momentum + value * weights[own] * other / radius[own]
            value *= wave
        else:
            momentum *= value
        x, y, u, v = value, 0.0, momentum, 0.0
        if pair[g] >= 0:
            angle = psi[int(pair[g])]
            c, s1 = gi.cos(angle), gi.sin(angle)
            across = ell[g] / value
            x, y = value * c, value * s1
            u, v = momentum * c - across * s1, momentum * s1 + across * c
        for i in range(n):
            e1, e2 = first[g * n + i], second[g * n + i]
            out[i] += x * e1 + y * e2
            out[n + i] += scale * (u * e1 + v * e2)


@gi.helper
def phases(params, tau, phi):
    """Write φ₀ + ωτ modulo 4π, reduced as turns, in two parts."""
    rows = torus_rows(params)
    turns, low = section(params, rows, "turns"), section(params, rows, "turns_low")
    start = section(params, rows, "start")
    for j in range(len(turns)):
        product = tau * turns[j]
        error = gi.fma(tau, turns[j], -product)
        rest = product - whole_nearest(product) + (error + tau * low[j])
        phi[j] = start[j] + 4.0 * np.pi * (rest - whole_nearest(rest))


@gi.helper
def state_at(params, phi, out, work):
    """Write the state at linear angles (φ, Φ); return what is left of Newton's last step."""
    ovals, angles, _, _ = torus_sizes(params)
    theta, shift = part(work, 0, ovals), part(work, ovals, angles)
    rest = part(work, ovals + angles, ovals * ovals + 5 * ovals)
    left = solve_theta(params, phi, theta, shift, rest)
    psi = part(shift, ovals, angles - ovals)
    for j in range(angles - ovals):
        psi[j] = phi[ovals + j] - psi[j]
    fill_state(params, theta, psi, out, rest)
    return left


@gi.field
def at_tau(params, t, x, out, work):
    """(τ) ↦ state, what is left of Newton's last step."""
    _, angles, _, n = torus_sizes(params)
    phi = part(work, 0, angles)
    phases(params, x[0], phi)
    out[2 * n] = state_at(params, phi, out, after(work, angles))


@gi.field
def at_angles(params, t, x, out, work):
    """(φ, Φ) ↦ state, what is left of Newton's last step."""
    _, _, _, n = torus_sizes(params)
    out[2 * n] = state_at(params, x, out, work)
