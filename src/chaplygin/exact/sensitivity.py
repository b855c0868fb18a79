"""How rounding errors of a state grow with time: derivatives of the frequencies.

Let C be the constants of a motion: R on the middles of the ovals, and the ℓ_g. The means over one turn
of θ_k, of the differentials of `torus`, are ∂J_k/∂C_i, J the actions. With the second derivatives of
μ_k,

    S_k,ij = mean of ∂²μ_k/∂C_i∂C_j dλ_k/dθ_k,

where the singular ends of the oval are passed at a distance, in the complex plane of θ_k, the rule
Σ_k ω_k ∂J_k/∂c_j = ∂H/∂c_j = const gives ∂ω/∂C, and with the gradients of C it gives those of the
frequencies. That is no bound but the derivative: it says that nearly equal a_i and narrow ovals do no
harm, and how much separatrices do.
"""

from __future__ import annotations

import itertools

import numpy as np

from ..manifold import Array
from .branch_points import Separation
from .separated_energy import SeparatedEnergy
from .symmetry import ReducedAxes
from .torus import Torus, distances

__all__ = ["frequency_gradients"]

WIDEST = 1.5  # of strips: half of it is far enough from all that is singular
FINENESS = 12.0  # points over 1/distance: e^−12 is far more exact than an estimate must be


def frequency_gradients(
    axes: ReducedAxes,
    separation: Separation,
    torus: Torus,
    energy: SeparatedEnergy,
    gamma: Array,
    p_tilde: Array,
) -> Array:
    """Return the lengths of the gradients of all frequencies by γ and by p̃/|p̃|, shape (d + pairs,)."""
    size, paired = len(torus.middle), np.flatnonzero(axes.paired)
    # In units of time in which nothing overflows.
    unit = float(np.max(np.abs(torus.frequencies))) or 1.0
    turning = np.array([energy.turning(separation.alpha[g]) / unit for g in paired])
    gradients = _constants(axes, torus, gamma, p_tilde)
    omega, means = torus.frequencies[:size] / unit, torus.means
    second = np.zeros((size + len(paired),) * 2)
    for k in range(size):
        second += omega[k] * _second_derivatives(axes, separation, torus, k)
    changed = second @ gradients
    separated = -np.linalg.solve(means[:, :size].T, changed[:size])
    pairs = turning[:, None] * gradients[size:] - changed[size:] - means[:, size:].T @ separated
    return np.asarray(unit * np.linalg.norm(np.concatenate([separated, pairs]), axis=1))


def _second_derivatives(axes: ReducedAxes, separation: Separation, torus: Torus, k: int) -> Array:
    """Return S_k: −h_i h_j λP/(8 d² sin²θ Q^(3/2)), and −½ αP/((λ − α)²√Q) for a pair's ∂²/∂ℓ².

    h_i is Lagrange's polynomial, or 2αℓP/(λ − α)².
    """
    radius, size = torus.radius[k], len(torus.middle)
    shift = 0.5 * min(float(torus.strips[k]), WIDEST)
    count = int(np.ceil(FINENESS / shift)) + 4
    theta = 2.0 * np.pi * np.arange(count) / count + 1j * shift
    sine = np.sin(0.5 * theta) ** 2
    branch = distances(torus.branch_gaps[k, :, None], radius, sine)
    axis = distances(torus.axis_gaps[k, :, None], radius, sine)
    lam, product = branch[0], np.prod(axis, axis=0)
    roots = np.sqrt(np.where(torus.branch_gaps[k, :, None] < 0.0, -branch, branch))
    root_q = np.sqrt(torus.lead) * np.prod(roots, axis=0)
    rows = []
    for j in range(size):
        row = np.asarray(1.0 + 0.0 * sine)
        for s in range(size):
            if s != j:
                row = row * _from_middle(torus, k, s, sine) / _between_middles(torus, j, s)
        rows.append(row)
    for g in np.flatnonzero(axes.paired):
        momentum = 2.0 * separation.alpha[g] * separation.ell[g, 0]
        rows.append(momentum * product / axis[g] ** 2)
    h = np.array(rows)
    ends = 4.0 * radius * radius * sine * (1.0 - sine)
    # In an order in which neither gaps of 1e-16 between ten a_i nor their quotients are too small.
    weight = -lam * (product / root_q) / root_q / (8.0 * ends * count) / root_q
    result = ((h * weight) @ h.T).real
    for i, g in enumerate(np.flatnonzero(axes.paired), start=size):
        own = separation.alpha[g] * product / (axis[g] ** 2 * root_q)
        result[i, i] -= 0.5 * float(np.mean(own.real))
    return np.asarray(result)


def _between_middles(torus: Torus, j: int, s: int) -> float:
    """Return m_j − m_s."""
    widths = float(torus.radius[j] + torus.radius[s])
    return float(torus.oval_gaps[j, s]) + (widths if j > s else -widths)


def _from_middle(torus: Torus, k: int, s: int, sine: Array) -> Array:
    """Return λ_k − m_s."""
    if k == s:
        return np.asarray(torus.radius[k] * (2.0 * sine - 1.0))
    gap, radius = torus.oval_gaps[k, s], torus.radius[k]
    beyond = distances(np.asarray(gap), radius, sine)
    return np.asarray(beyond + (torus.radius[s] if k > s else -torus.radius[s]))


def _constants(axes: ReducedAxes, torus: Torus, gamma: Array, p_tilde: Array) -> Array:
    """Return the gradients of R on the middles, then of the ℓ, by γ and p̃/|p̃|, shape (…, 2n).

    R = −(p̃, p̃) Σ A_g P_g + λ Σ_{g<h} (A_gC_h + A_hC_g − 2B_gB_h) P_gh + Σ ℓ_g² P_g,
    P_g = P/(λ − α_g), and A, B, C the products (γ_g, γ_g), (γ_g, p̃_g), (p̃_g, p̃_g).
    """
    members = axes.members.astype(np.float64)
    momentum = float(np.linalg.norm(p_tilde))
    p = p_tilde / momentum
    A, B, C = members @ (gamma * gamma), members @ (gamma * p), members @ (p * p)
    count = len(A)
    rows = []
    for k in range(len(torus.middle)):
        lam = float(torus.middle[k])
        away = (
            torus.axis_gaps[k]
            + np.where(np.signbit(torus.axis_gaps[k]), -1.0, 1.0) * torus.radius[k]
        )
        single = np.array([np.prod(np.delete(away, g)) for g in range(count)])
        double = np.zeros((count, count))
        for i, j in itertools.permutations(range(count), 2):
            double[i, j] = np.prod(np.delete(away, [i, j]))
        pairs = np.where(axes.paired, single, 0.0)
        by_a = -single + lam * (double @ C) + pairs * C
        by_b = -2.0 * lam * (double @ B) - 2.0 * pairs * B
        by_c = -float(A @ single) + lam * (double @ A) + pairs * A
        rows.append(_by_state(by_a @ members, by_b @ members, by_c @ members, gamma, p))
    result = [momentum**2 * row for row in rows]
    for g in np.flatnonzero(axes.paired):
        inside = members[g]
        ell = max(float(np.sqrt(max(A[g] * C[g] - B[g] * B[g], 0.0))), 1e-300)
        row = _by_state(C[g] * inside, -2.0 * B[g] * inside, A[g] * inside, gamma, p)
        result.append(momentum * row / (2.0 * ell))
    return np.array(result).reshape(-1, 2 * len(gamma))


def _by_state(by_a: Array, by_b: Array, by_c: Array, gamma: Array, p: Array) -> Array:
    """Return a gradient by γ and p from that by the products."""
    return np.concatenate([2.0 * by_a * gamma + by_b * p, 2.0 * by_c * p + by_b * gamma])
