"""Fields, generators and energies of the ball in (k, γ) or (k, γ, g), for three kinds of inertia.

See `ball` for the equations; ω is that of `angular_velocity`. `params` starts with n.
"""

from __future__ import annotations

import math
from typing import Any

import geomint as gi
from geomint import part

from .angular_velocity import diagonal_omega, full_omega, omega_work, special_omega

__all__ = ["DIAGONAL", "FULL", "SPECIAL", "ball_work"]


def ball_work(n: int, full: bool) -> int:
    """Rows of scratch that the functions of this module need."""
    return n * (n - 1) // 2 + max(2 * n * n, omega_work(n, full))


# n from the number of parameters, which is a constant where the caller fixes it: loops unroll then
# (measured: 1.5 to 3 times faster than with n = int(params[0]), n = 8 to 3).


@gi.helper
def special_dimension(params: Any) -> Any:
    """Return n from the 2 + n + n² parameters of the special operator."""
    return int(math.sqrt(1.0 * (len(params) - 2)))


@gi.helper
def diagonal_dimension(params: Any) -> Any:
    """Return n from the 2 + n² − n parameters of a diagonal operator."""
    return int(math.sqrt(1.0 * (len(params) - 2))) + 1


@gi.helper
def full_dimension(params: Any) -> Any:
    """Return n from the 2 + N² + N parameters of any operator, N = n(n−1)/2."""
    return int(math.sqrt(2.0 * int(math.sqrt(1.0 * (len(params) - 2))))) + 1


@gi.helper
def unpack(n: int, triangle: Any, full: Any) -> None:
    """Write the n×n matrix of a flat triangle."""
    at = 0
    for i in range(n):
        full[i * n + i] = 0.0 * triangle[0]
        for j in range(i + 1, n):
            full[i * n + j] = triangle[at]
            full[j * n + i] = -triangle[at]
            at += 1


@gi.helper
def turn(n: int, y: Any, out: Any, work: Any) -> None:
    """Write ([k, ω], −ωγ, gω) with the triangle of ω in the first rows of `work`."""
    size = n * (n - 1) // 2
    w, k = part(work, size, n * n), part(work, size + n * n, n * n)
    unpack(n, part(work, 0, size), w)
    unpack(n, part(y, 0, size), k)
    at = 0
    for i in range(n):
        for j in range(i + 1, n):
            total = w[i * n] * k[j * n] - k[i * n] * w[j * n]
            for l in range(1, n):
                total += w[i * n + l] * k[j * n + l] - k[i * n + l] * w[j * n + l]
            out[at] = total
            at += 1
    # γ and the rows of g are vectors that turn alike
    for row in range(size, len(y), n):
        for i in range(n):
            total = -(w[i * n] * y[row])
            for j in range(1, n):
                total -= w[i * n + j] * y[row + j]
            out[row + i] = total


@gi.field
def special_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ = −ω."""
    n = special_dimension(params)
    size = n * (n - 1) // 2
    special_omega(n, params, part(y, 0, size), part(y, size, n), out, work)
    for i in range(size):
        out[i] = -out[i]


@gi.field
def diagonal_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ = −ω."""
    n = diagonal_dimension(params)
    size = n * (n - 1) // 2
    diagonal_omega(n, params, part(y, 0, size), part(y, size, n), out, work)
    for i in range(size):
        out[i] = -out[i]


@gi.field
def full_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ = −ω."""
    n = full_dimension(params)
    size = n * (n - 1) // 2
    full_omega(n, params, part(y, 0, size), part(y, size, n), out, work)
    for i in range(size):
        out[i] = -out[i]


@gi.helper
def velocity_parts(n: int, y: Any, work: Any) -> Any:
    """Return k, γ, the rows of `work` for ω, and the rest of it."""
    size = n * (n - 1) // 2
    rest = part(work, size, len(work) - size)
    return part(y, 0, size), part(y, size, n), part(work, 0, size), rest


@gi.field
def special_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Eqs. (ch-red), (PE), (ch-red2)."""
    n = special_dimension(params)
    k, gamma, omega, rest = velocity_parts(n, y, work)
    special_omega(n, params, k, gamma, omega, rest)
    turn(n, y, out, work)


@gi.field
def diagonal_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Eqs. (ch-red), (PE), (ch-red2)."""
    n = diagonal_dimension(params)
    k, gamma, omega, rest = velocity_parts(n, y, work)
    diagonal_omega(n, params, k, gamma, omega, rest)
    turn(n, y, out, work)


@gi.field
def full_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Eqs. (ch-red), (PE), (ch-red2)."""
    n = full_dimension(params)
    k, gamma, omega, rest = velocity_parts(n, y, work)
    full_omega(n, params, k, gamma, omega, rest)
    turn(n, y, out, work)


@gi.helper
def half_product(k: Any, omega: Any) -> Any:
    """Return ½⟨k, ω⟩."""
    total = k[0] * omega[0]
    for i in range(1, len(k)):
        total += k[i] * omega[i]
    return 0.5 * total


@gi.field
def special_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """½⟨k, ω⟩, the reduced kinetic energy."""
    n = special_dimension(params)
    k, gamma, omega, rest = velocity_parts(n, y, work)
    special_omega(n, params, k, gamma, omega, rest)
    return half_product(k, omega)


@gi.field
def diagonal_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """½⟨k, ω⟩, the reduced kinetic energy."""
    n = diagonal_dimension(params)
    k, gamma, omega, rest = velocity_parts(n, y, work)
    diagonal_omega(n, params, k, gamma, omega, rest)
    return half_product(k, omega)


@gi.field
def full_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """½⟨k, ω⟩, the reduced kinetic energy."""
    n = full_dimension(params)
    k, gamma, omega, rest = velocity_parts(n, y, work)
    full_omega(n, params, k, gamma, omega, rest)
    return half_product(k, omega)


# field, generator, energy
SPECIAL = (special_field, special_generator, special_energy)
DIAGONAL = (diagonal_field, diagonal_generator, diagonal_energy)
FULL = (full_field, full_generator, full_energy)
