"""The angular velocity of a body that may turn only in planes through given vectors.

Let X = (x_1, …, x_r) be linearly independent vectors of R^n and 𝔡 = {Σ x_s∧z_s}. For k in so(n),

    w ∈ 𝔡,   ⟨𝓘w − k, x_t∧z⟩ = 0 for all z and t

has one solution, which depends on k and on the span of X alone. It is the angular velocity of the LR
systems of Veselova's kind: their constraints (VC) say w ∈ 𝔡 with x_s = e_s, and k is the part of 𝓘w
in 𝔡, or, for accelerations, [𝓘w, w].

With w = Σ x_s∧z_s and ⟨W, x∧y⟩ = −(Wx, y) the condition reads

    −𝓘(w) x_t = −k x_t,  t = 1 … r,

nr equations. They leave z_s ↦ z_s + Σ S_st x_t with a symmetric S free, which does not change w: c
times the gradient of ¼ Σ ((x_s, z_t) + (x_t, z_s))² is added. That makes the matrix positive
definite, and the right side has no part along the freedom, so that XᵀZ + ZᵀX is 0. The determinant
of the matrix is, where XᵀX = 1, a constant times det(pr_𝔡 𝓘|_𝔡): the density of the invariant measure.

Parameters: c, then the entries of 𝓘 (see `operators`). One system of nr equations
by LDLᵀ without pivots: O(n³r³).
"""

import functools
from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import log, part, section

from ..ball.angular_velocity import apply_to_gamma, solve_in_place, wedge_sum
from ..inertia import GeneralInertia, Inertia
from ..manifold import Array, triangle_rows
from ..operators import after, operator_applied, operator_entries

Bound = namedtuple("Bound", "c inertia")
BOUND = Bound(c=1, inertia=gi.REST)  # the layout of the parameters


def bound_parameters(inertia: Inertia) -> tuple[bool, Array]:
    """Return whether 𝓘 is stored as a matrix, and the parameters of `bound_velocity`."""
    full, entries = operator_entries(inertia)
    diagonal = np.diag(inertia.matrix) if isinstance(inertia, GeneralInertia) else entries
    return full, gi.packed(BOUND, c=np.exp(np.mean(np.log(diagonal))), inertia=entries).data


def bound_work(n: int, r: int) -> int:
    """Rows of scratch that `bound_velocity` needs."""
    return n * r + (n * r) ** 2 + n * (n - 1) + n


@functools.cache
def bound_velocity(full: bool, n: int, r: int) -> Any:
    """Return ``f(params, k, x, w, work)``, which writes the triangle of w; `params` are its own.

    k is a flat triangle, x the vectors x_1, …, x_r one after another. The scratch begins with the
    nr numbers z_s and the matrix, whose diagonal holds the inverse pivots: see `log_determinant`.
    """
    size, rows = triangle_rows(n), n * r
    apply, wedges = operator_applied(full, n), wedge_sum(n, r)

    def fill(inertia: Any, x: Any, matrix: Any, work: Any) -> None:
        """Write the matrix for an operator stored as a matrix: column by column."""
        turned, moment = part(work, 0, size), part(work, size, size)
        column = part(work, 2 * size, n)
        for s in range(r):
            for a in range(n):
                pair = 0
                for i in range(n):
                    for j in range(i + 1, n):
                        turned[pair] = 0.0 * x[0]
                        if j == a:
                            turned[pair] = x[s * n + i]
                        if i == a:
                            turned[pair] = -x[s * n + j]
                        pair += 1
                apply(inertia, turned, moment)
                for t in range(r):
                    apply_to_gamma(n, moment, part(x, t * n, n), column)
                    for b in range(n):
                        matrix[(t * n + b) * rows + s * n + a] = -column[b]

    def fill_diagonal(inertia: Any, x: Any, matrix: Any, work: Any) -> None:
        """Write the matrix for diagonal 𝓘."""
        for s in range(r):
            for t in range(r):
                for a in range(n):
                    matrix[(t * n + a) * rows + s * n + a] = 0.0 * x[0]
                pair = 0
                for a in range(n):
                    for b in range(a + 1, n):
                        moment = inertia[pair]
                        pair += 1
                        sa, sb, ta, tb = x[s * n + a], x[s * n + b], x[t * n + a], x[t * n + b]
                        aa, bb = (t * n + a) * rows + s * n + a, (t * n + b) * rows + s * n + b
                        matrix[aa] += moment * (sb * tb)
                        matrix[bb] += moment * (sa * ta)
                        matrix[(t * n + b) * rows + s * n + a] = -moment * (sb * ta)
                        matrix[(t * n + a) * rows + s * n + b] = -moment * (sa * tb)

    filled = gi.helper(fill if full else fill_diagonal)

    def velocity(params, k, x, w, work):
        z, matrix = part(work, 0, rows), part(work, rows, rows * rows)
        rest = after(work, rows + rows * rows)
        filled(section(params, BOUND, "inertia"), x, matrix, rest)
        c = section(params, BOUND, "c")[0]
        for s in range(r):
            for t in range(r):
                for a in range(n):
                    for b in range(n):
                        entry = (t * n + b) * rows + s * n + a
                        matrix[entry] += c * (x[s * n + b] * x[t * n + a])
                        if s == t:
                            for u in range(r):
                                matrix[entry] += c * (x[u * n + b] * x[u * n + a])
        for t in range(r):
            apply_to_gamma(n, k, part(x, t * n, n), part(z, t * n, n))
        for i in range(rows):
            z[i] = -z[i]
        solve_in_place(rows, matrix, z)
        wedges(x, z, w)

    return gi.helper(velocity)


@gi.helper
def log_determinant(rows, work):
    """Return the logarithm of the determinant from the scratch of `bound_velocity`, rows = nr."""
    total = log(work[rows])
    for i in range(1, rows):
        total += log(work[rows + i * (rows + 1)])
    return -total
