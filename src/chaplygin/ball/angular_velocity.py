"""The angular velocity ω of the ball from k and γ, for three kinds of inertia operator.

k = Iω + D(ωγγᵀ + γγᵀω)/(γ, γ), eq. (K) with γ normalised: ω depends on the direction of γ alone, so
that round-off in |γ| does not enter, and ½⟨k, ω⟩ is kept wherever γ ≠ 0.

* Special operator: with s = I⁻¹(k)γ and c = As/U, U = (γ, A⁻¹γ),

      ω = I⁻¹(k − c∧γ).                                                               O(n²)

  Where the a_i differ much, k and c∧γ cancel in the components of small moments: the error is ε
  times the square of the largest a_i/a_j. With b = A⁻¹γ, T_ijm = γ_m k_ij − γ_j k_im + γ_i k_jm, which
  is 0 for k = γ∧p, and v = Akγ/D the cancellation is done by hand,

      ω = I⁻¹(X), X_ij = (Σ_m b_m T_ijm + v_iγ_j − v_jγ_i)/U.                         O(n³)

* Any operator: with D′ = D/(γ, γ) and M e_j = I⁻¹(e_j∧γ)γ, symmetric and positive,

      (1 + D′M) v = s,   ω = I⁻¹(k − D′ v∧γ),

  one n×n system, solved by LDLᵀ without pivots (it is positive definite: no branches). For
  diagonal I⁻¹ with entries C_ij: M = diag(Cγ²) − C∘γγᵀ. O(n³); for a full matrix O(n⁴).

Parameters are D; of the special operator a_i and 1/a_i; and C, the N = n(n−1)/2 entries of a diagonal
I⁻¹, or all of it row after row.

The measure of the ball has the density ϱ = det(I + D pr)^(−1/2), eq. (mu*), a function of γ. Up to a
constant ϱ² = 1/det(1 + D′M), the product of the pivots of LDLᵀ; and for the special operator
ϱ² = U^(2−n).
"""

import functools
from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import log, part, section

from ..inertia import Inertia, SpecialInertia
from ..integrable import inner, weighted
from ..manifold import Array

Operator = namedtuple("Operator", "D a b C")
GENERAL = Operator(D=1, a=0, b=0, C=gi.REST)  # the layout of the parameters; see `special_rows`

SPREAD = 4.0  # largest a_i/a_j up to which the formula in O(n²) is accurate enough


def omega_for(inertia: Inertia, D: float) -> tuple[Any, Array]:
    """Return the function that writes ω for that operator, and its parameters."""
    if isinstance(inertia, SpecialInertia):
        a, C = inertia.a, 1.0 / inertia.diagonal
        form = spread_omega if np.max(a) > SPREAD * np.min(a) else special_omega
        return form, gi.packed(special_rows(inertia.n), D=D, a=a, b=1.0 / a, C=C).data
    if inertia.diagonal is not None:
        form, C = diagonal_omega, 1.0 / inertia.diagonal
    else:
        inverse = np.linalg.inv(inertia.matrix)
        form, C = full_omega, 0.5 * (inverse + inverse.T)
    return form, gi.packed(GENERAL, D=D, a=(), b=(), C=C).data


def omega_work(omega: Any, n: int) -> int:
    """Rows of scratch that a function of this module needs."""
    if omega in (special_omega, spread_omega):
        return n
    return n + n * n + (n * n * (n - 1) // 2 if omega is full_omega else 0)


def log_density_after(omega: Any) -> Any:
    """Return f(n, params, gamma, work) -> log ϱ that reads the scratch that `omega` has left."""
    special = omega in (special_omega, spread_omega)
    return special_log_density if special else pivots_log_density


@gi.helper
def apply_to_gamma(n, triangle, gamma, out):
    """Write Xγ for the skew matrix X of a flat triangle."""
    for i in range(n):
        out[i] = 0.0 * gamma[i]
    at = 0
    for i in range(n):
        x, total = gamma[i], out[i]
        for j in range(i + 1, n):
            total += triangle[at] * gamma[j]
            out[j] -= triangle[at] * x
            at += 1
        out[i] = total


@functools.cache
def wedge_sum(n: int, r: int) -> Any:
    """Return ``f(x, p, out)``, which writes the flat triangle of Σ x_s∧p_s, over r vectors of R^n."""

    def wedges(x, p, out):
        pair = 0
        for i in range(n):
            for j in range(i + 1, n):
                total = x[i] * p[j] - p[i] * x[j]
                for s in range(n, r * n, n):
                    total += x[s + i] * p[s + j] - p[s + i] * x[s + j]
                out[pair] = total
                pair += 1

    return gi.helper(wedges)


@gi.helper
def about_vertical(n, triangle, gamma, work):
    """Return |X − (Xγ)∧γ|², the square of the part of X that fixes the unit vector γ."""
    image = part(work, 0, n)
    apply_to_gamma(n, triangle, gamma, image)
    total = 0.0 * gamma[0]
    pair = 0
    for i in range(n):
        for j in range(i + 1, n):
            entry = triangle[pair] - (image[i] * gamma[j] - gamma[i] * image[j])
            total += entry * entry
            pair += 1
    return total


@gi.helper
def special_rows(n):
    """Return the layout of the parameters of the special operator."""
    return Operator(D=1, a=n, b=n, C=gi.REST)


@gi.helper
def special_parts(params, n):
    """Return the blocks of D, a_i, 1/a_i and the entries of I⁻¹."""
    rows = special_rows(n)
    a, b = section(params, rows, "a"), section(params, rows, "b")
    return section(params, rows, "D"), a, b, section(params, rows, "C")


@gi.helper
def special_omega(n, params, k, gamma, omega, work):
    """Write ω for the special operator."""
    _, a, b, C = special_parts(params, n)
    for i in range(len(k)):
        omega[i] = C[i] * k[i]
    apply_to_gamma(n, omega, gamma, work)
    r = 1.0 / weighted(n, b, gamma, gamma)
    for i in range(n):
        work[i] = a[i] * r * work[i]
    at = 0
    for i in range(n):
        c, x = work[i], gamma[i]
        for j in range(i + 1, n):
            omega[at] -= C[at] * (c * gamma[j] - x * work[j])
            at += 1


@gi.helper
def spread_omega(n, params, k, gamma, omega, work):
    """Write ω for the special operator, without cancellation."""
    D, a, b, C = special_parts(params, n)
    apply_to_gamma(n, k, gamma, work)
    for i in range(n):
        work[i] = a[i] / D[0] * work[i]
    at = 0
    for i in range(n):
        v, x = work[i], gamma[i]
        for j in range(i + 1, n):
            omega[at] = v * gamma[j] - x * work[j]
            at += 1
    ij = 0
    for i in range(n):
        x = gamma[i]
        bi = b[i] * x
        for j in range(i + 1, n):
            y, kij, total = gamma[j], k[ij], omega[ij]
            bj = b[j] * y
            im, jm = ij + 1, j * (2 * n - j - 1) // 2
            for m in range(j + 1, n):
                z = gamma[m]
                t = z * kij - y * k[im] + x * k[jm]
                total += b[m] * z * t
                omega[im] -= bj * t
                omega[jm] += bi * t
                im += 1
                jm += 1
            omega[ij] = total
            ij += 1
    r = 1.0 / weighted(n, b, gamma, gamma)
    for i in range(len(k)):
        omega[i] = C[i] * (r * omega[i])


@gi.helper
def special_log_density(n, params, gamma, work):
    """Return log ϱ = −(n − 2)/2 log U."""
    _, _, b, _ = special_parts(params, n)
    return -0.5 * (n - 2) * log(weighted(n, b, gamma, gamma))


@gi.helper
def solve_in_place(n, s, v):
    """Replace v by S⁻¹v for a positive definite S, and the diagonal of S by its inverse pivots.

    Reads and overwrites the lower triangle of S.
    """
    for j in range(n):
        r = 1.0 / s[j * n + j]
        s[j * n + j] = r
        x = v[j]
        for i in range(n - 1, j, -1):
            m = s[i * n + j] * r
            for c in range(j + 1, i + 1):
                s[i * n + c] -= m * s[c * n + j]
            s[i * n + j] = m
            v[i] -= m * x
    for j in range(n - 1, -1, -1):
        total = v[j] * s[j * n + j]
        for i in range(j + 1, n):
            total -= s[i * n + j] * v[i]
        v[j] = total


@gi.helper
def pivots_log_density(n, params, gamma, work):
    """Return log ϱ = −½ log det(1 + D′M), from the inverse pivots that the solve has left in `work`."""
    total = log(work[n])
    for i in range(1, n):
        total += log(work[n + i * (n + 1)])
    return 0.5 * total


@gi.helper
def diagonal_omega(n, params, k, gamma, omega, work):
    """Write ω for a diagonal operator."""
    D, C = section(params, GENERAL, "D"), section(params, GENERAL, "C")
    v, s = part(work, 0, n), part(work, n, n * n)
    for i in range(len(k)):
        omega[i] = C[i] * k[i]
    apply_to_gamma(n, omega, gamma, v)
    q = D[0] / inner(n, gamma, gamma)
    for i in range(n):
        s[i * n + i] = 1.0 + 0.0 * q
    at = 0
    for i in range(n):
        x = gamma[i]
        qx = q * x
        total = s[i * n + i]
        for j in range(i + 1, n):
            y, c = gamma[j], C[at]
            total += c * (q * y * y)
            s[j * n + j] += c * (qx * x)
            s[j * n + i] = -c * (qx * y)
            at += 1
        s[i * n + i] = total
    solve_in_place(n, s, v)
    at = 0
    for i in range(n):
        c, x = q * v[i], q * gamma[i]
        for j in range(i + 1, n):
            omega[at] -= C[at] * (c * gamma[j] - x * v[j])
            at += 1


@gi.helper
def full_omega(n, params, k, gamma, omega, work):
    """Write ω for any operator."""
    D, C = section(params, GENERAL, "D"), section(params, GENERAL, "C")
    rows = len(k)
    v, s, g = part(work, 0, n), part(work, n, n * n), part(work, n + n * n, rows * n)
    zero = 0.0 * gamma[0]
    for r in range(rows):  # row r of g: the coefficients of I⁻¹(v∧γ) as a function of v
        total = zero
        for i in range(n):
            g[r * n + i] = zero
        pair = 0
        for i in range(n):
            x, entry = gamma[i], g[r * n + i]
            for j in range(i + 1, n):
                c = C[r * rows + pair]
                total += c * k[pair]
                entry += c * gamma[j]
                g[r * n + j] -= c * x
                pair += 1
            g[r * n + i] = entry
        omega[r] = total
    apply_to_gamma(n, omega, gamma, v)
    q = D[0] / inner(n, gamma, gamma)
    for i in range(n * n):
        s[i] = zero
    r = 0
    for i in range(n):
        for j in range(i + 1, n):
            x, y = q * gamma[i], q * gamma[j]
            for c in range(n):
                s[i * n + c] += y * g[r * n + c]
                s[j * n + c] -= x * g[r * n + c]
            r += 1
    for i in range(n):
        s[i * n + i] += 1.0
    solve_in_place(n, s, v)
    for r in range(rows):
        omega[r] -= q * inner(n, part(g, r * n, n), v)
