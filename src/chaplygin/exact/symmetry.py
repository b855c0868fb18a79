"""What is left of a state when the symmetries of equal a_i are taken away.

With equal a_i in a group G of indices H does not change under rotations of R^G, and the bivector
γ_G∧p̃_G is constant: both vectors stay in one plane. In polar coordinates of that plane,

    γ_G = ρ (cos ψ e_1 + sin ψ e_2),   π = (γ_G, p̃_G)/ρ,   ℓ = |γ_G∧p̃_G|,

the group counts as one axis with component ρ and momentum π, and ℓ is constant. Such a group is called
a *pair*. Where ℓ = 0 it moves along a line through the origin and counts as an axis of its own, as does
a single index. Groups in which γ and p̃ are both 0 stay so, and are left out.

That covers all motions at once: different a_i, Lagrange's case and other equal a_i, motions within
coordinate planes, and the great circles of equal a_i, where one pair and no other degree of freedom
is left.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..manifold import Array, length

PARALLEL = 4.0 * 2.0**-52  # roundings of the angle of γ_G and p̃_G with which they count as parallel
TINY = 1e-300


@dataclass(frozen=True)
class ReducedAxes:
    """The axes of a motion in which equal a_i are taken together.

    Parameters
    ----------
    alpha : array, shape (q,)
        Different a_i that take part, ascending.
    members : array of bool, shape (q, n)
        Which indices they stand for.
    paired : array of bool, shape (q,)
        Whether an axis is a pair.
    first, second : array, shape (q, n)
        e_1 and e_2; of an axis that is no pair the direction and 0.
    """

    alpha: Array
    members: Array
    paired: Array
    first: Array
    second: Array

    def components(self, gamma: Array, p_tilde: Array) -> tuple[Array, Array, Array, Array]:
        """Return γ or ρ, p̃ or π, and of the pairs ψ and ℓ; shapes (q,), (q,), (pairs,), (pairs,)."""
        x, y = self.first @ gamma, self.second @ gamma
        u, v = self.first @ p_tilde, self.second @ p_tilde
        radius = np.hypot(x, y)
        safe = np.where(radius > 0.0, radius, 1.0)
        cos, sin = x / safe, y / safe
        position = np.where(self.paired, radius, x)
        momentum = np.where(self.paired, cos * u + sin * v, u)
        psi = np.arctan2(y, x)[self.paired]
        return position, momentum, psi, (radius * (cos * v - sin * u))[self.paired]


def power_of_two(x: Any) -> float:
    """Return a power of two near x > 0: in such units nothing overflows, and nothing is rounded."""
    return float(np.ldexp(1.0, int(np.frexp(x)[1]))) if x > 0.0 else 1.0


def unit_of(v: Array) -> Array:
    """Return v/|v|, also where the squares of v underflow."""
    scaled = v / np.max(np.abs(v))
    return scaled / np.linalg.norm(scaled)


def reduced_axes(a: Array, gamma: Array, p_tilde: Array) -> ReducedAxes:
    """Return the axes of the motion through a state; a_i count as equal only if they are.

    Parameters
    ----------
    a, gamma, p_tilde : array, shape (n,)
    """
    n = len(a)
    rows = []
    for value in sorted(set(a.tolist())):
        inside = a == value
        if np.count_nonzero(inside) == 1:
            direction = (
                np.sign(gamma) * inside if np.any(gamma[inside]) else np.sign(p_tilde) * inside
            )
            if np.any(direction):
                rows.append((value, inside, False, direction, np.zeros(n)))
            continue
        g, p = np.where(inside, gamma, 0.0), np.where(inside, p_tilde, 0.0)
        if not np.any(g) and not np.any(p):
            continue
        along = unit_of(g) if np.any(g) else unit_of(p)
        turning = unit_of(p) if np.any(p) else along
        across = turning - (along @ turning) * along
        across -= (along @ across) * along
        # What a rounding of γ and p̃ makes of the sine of the angle: their parts may be small.
        share = length(gamma) / max(length(g), TINY) + length(p_tilde) / max(length(p), TINY)
        paired = bool(np.any(g) and np.any(p) and length(across) > PARALLEL * share)
        rows.append((value, inside, paired, along, unit_of(across) if paired else np.zeros(n)))
    values, members, flags, first, second = (np.array(column) for column in zip(*rows, strict=True))
    return ReducedAxes(values, members, flags, first, second)
