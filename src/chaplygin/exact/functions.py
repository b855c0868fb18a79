"""Compiled: from times to angles, from angles to states; for `geomint.pointwise`.

The parameters are packed by `packing`: a header with sizes and where each section begins.

States from θ, without a division where a λ is at its turning point. With γ_g for a component (or ρ),

    γ_g² = Π_k |α_g − λ_k| / Π_{h≠g} |α_g − α_h|,
    p̃_g = −Σ_k d_k sin θ_k √Q_k/(λ_k Π_{s≠k}(λ_k − λ_s)) · γ_g/(λ_k − α_g).

Where α_g is the lower end of the oval of λ_k, the factor α_g − λ_k is 2d sin²(θ_k/2), and γ_g has the
sign of sin(θ_k/2): smooth, and of period 4π; where it is the upper end, cos. Half the sine then cancels
the root of λ_k − α_g in the momentum. Other components keep their sign. All differences are sums of
numbers of one sign, see `torus`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint import part

from .inversion import shift_sums, solve_theta, whole_nearest
from .packing import (
    ANGLES,
    AXES,
    AXIS_GAPS,
    BRANCH_GAPS,
    ELL,
    FIRST,
    HIGH,
    LEAD,
    LOW,
    OVAL_GAPS,
    OVALS,
    PAIR,
    PHYSICAL,
    RADIUS,
    ROWS,
    SCALE,
    SECOND,
    SIGNS,
    SPREAD,
    START,
    TURNS,
    TURNS_LOW,
)

__all__ = ["at_angles", "at_tau", "phases", "shifts", "state_rows", "state_work"]


def state_work(ovals: int, angles: int) -> int:
    """Rows of scratch that the functions of this module need."""
    return ovals * ovals + 6 * ovals + 3 * angles


def state_rows(n: int) -> int:
    """Rows of what `at_tau` writes: the state, and what is left of Newton's last step."""
    return 2 * n + 1


@gi.helper
def beyond(gap: Any, below: Any, above: Any) -> Any:
    """Return λ − b, b not within the oval of λ, from the gap between both; see `Torus`."""
    return gap + below if gap > 0.0 else gap - above


@gi.helper
def fill_state(params: Any, theta: Any, psi: Any, out: Any, work: Any) -> None:
    """Write (γ, p̃), or (γ, p) where the parameters say so, at θ and ψ."""
    ovals, axes, n = int(params[OVALS]), int(params[AXES]), int(params[ROWS])
    radius, signs, spread = int(params[RADIUS]), int(params[SIGNS]), int(params[SPREAD])
    low, high, first = int(params[LOW]), int(params[HIGH]), int(params[FIRST])
    second, pair, ell = int(params[SECOND]), int(params[PAIR]), int(params[ELL])
    branch_gaps, axis_gaps = int(params[BRANCH_GAPS]), int(params[AXIS_GAPS])
    oval_gaps = int(params[OVAL_GAPS])
    below, above = part(work, 0, ovals), part(work, ovals, ovals)
    sin, cos = part(work, 2 * ovals, ovals), part(work, 3 * ovals, ovals)
    weights = part(work, 4 * ovals, ovals)
    physical, scale = params[PHYSICAL] > 0.0, params[SCALE]
    for k in range(ovals):
        sin[k], cos[k] = gi.sin(0.5 * theta[k]), gi.cos(0.5 * theta[k])
        below[k] = 2.0 * params[radius + k] * sin[k] * sin[k]
        above[k] = 2.0 * params[radius + k] * cos[k] * cos[k]
    for k in range(ovals):
        at = branch_gaps + k * (2 * ovals - 1)
        lam = params[at] + below[k]  # the first branch point is 0
        q, apart = params[LEAD] * lam, 1.0
        for b in range(1, 2 * ovals - 1):
            q *= abs(beyond(params[at + b], below[k], above[k]))
        for s in range(ovals):
            gap = params[oval_gaps + k * ovals + s]
            if s < k:
                apart *= gap + (below[k] + above[s])
            elif s > k:
                apart *= gap - (above[k] + below[s])
        weights[k] = -gi.sqrt(q) * params[radius + k] / (lam * apart)
        if physical:
            scale *= gi.sqrt(lam)
    for i in range(2 * n):
        out[i] = 0.0
    for g in range(axes):
        own = int(max(params[low + g], params[high + g]))
        square, momentum = params[spread + g], 0.0
        for s in range(ovals):
            if s != own:
                gap = beyond(params[axis_gaps + s * axes + g], below[s], above[s])
                square *= abs(gap)
                momentum += 2.0 * weights[s] * sin[s] * cos[s] / gap
        value = params[signs + g] * gi.sqrt(square)
        if own >= 0:
            wave, other = sin[own], cos[own]
            if params[high + g] >= 0:
                wave, other = cos[own], -sin[own]
            value *= gi.sqrt(2.0 * params[radius + own])
            # 2 sin cos · wave/(± 2d wave²) = ± other/d, the sign being that of the gap.
            momentum = value * wave * momentum + value * weights[own] * other / params[radius + own]
            value *= wave
        else:
            momentum *= value
        x, y, u, v = value, 0.0, momentum, 0.0
        if params[pair + g] >= 0:
            angle = psi[int(params[pair + g])]
            c, s1 = gi.cos(angle), gi.sin(angle)
            across = params[ell + g] / value
            x, y = value * c, value * s1
            u, v = momentum * c - across * s1, momentum * s1 + across * c
        for i in range(n):
            e1, e2 = params[first + g * n + i], params[second + g * n + i]
            out[i] += x * e1 + y * e2
            out[n + i] += scale * (u * e1 + v * e2)


@gi.helper
def phases(params: Any, tau: Any, phi: Any) -> None:
    """Write φ₀ + ωτ modulo 4π, reduced as turns, in two parts."""
    turns, low, start = int(params[TURNS]), int(params[TURNS_LOW]), int(params[START])
    for j in range(int(params[ANGLES])):
        product = tau * params[turns + j]
        error = gi.fma(tau, params[turns + j], -product)
        rest = product - whole_nearest(product) + (error + tau * params[low + j])
        phi[j] = params[start + j] + 4.0 * np.pi * (rest - whole_nearest(rest))


@gi.helper
def state_at(params: Any, phi: Any, out: Any, work: Any) -> Any:
    """Write the state at linear angles (φ, Φ); return what is left of Newton's last step."""
    ovals, angles = int(params[OVALS]), int(params[ANGLES])
    theta, shift = part(work, 0, ovals), part(work, ovals, angles)
    rest = part(work, ovals + angles, ovals * ovals + 5 * ovals)
    left = solve_theta(params, phi, theta, shift, rest)
    psi = part(shift, ovals, angles - ovals)
    for j in range(angles - ovals):
        psi[j] = phi[ovals + j] - psi[j]
    fill_state(params, theta, psi, out, rest)
    return left


@gi.field
def at_tau(params: Any, t: Any, x: Any, out: Any, work: Any) -> None:
    """(τ) ↦ state, what is left of Newton's last step."""
    angles, n = int(params[ANGLES]), int(params[ROWS])
    phi = part(work, 0, angles)
    phases(params, x[0], phi)
    out[2 * n] = state_at(params, phi, out, part(work, angles, len(work) - angles))


@gi.field
def at_angles(params: Any, t: Any, x: Any, out: Any, work: Any) -> None:
    """(φ, Φ) ↦ state, what is left of Newton's last step."""
    out[2 * int(params[ROWS])] = state_at(params, x, out, work)


@gi.field
def shifts(params: Any, t: Any, x: Any, out: Any, work: Any) -> None:
    """(θ) ↦ (φ, Φ) − (θ, ψ)."""
    shift_sums(params, x, out, work)
