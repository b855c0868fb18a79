"""States of the rolling ball: upright attitudes, velocities that satisfy the constraint, m and ρ."""

from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector
from geomint.arguments import switch

from ..inertia import GeneralInertia, Inertia, SpecialInertia, positive_number
from ..initial_states import initial_momentum
from ..manifold import (
    REPAIRED,
    SILENT,
    Array,
    length,
    skew_components,
    skew_matrix,
    solved,
    upright,
    warn,
    wedge,
)


def mass_and_radius(D: float, m: Any, rho: Any) -> tuple[float, float]:
    """Return m and ρ with mρ² = D; one of them may be None.

    Raises
    ------
    geomint.DomainError
        If both are None, or disagree with D.
    """
    if m is None and rho is None:
        raise gi.DomainError("rho", rho, "the radius, the mass m, or both")
    if m is None:
        radius = positive_number("rho", rho)
        return positive_number("D/rho**2", D / radius / radius), radius
    mass = positive_number("m", m)
    if rho is None:
        return mass, positive_number("sqrt(D/m)", np.sqrt(D / mass))
    radius = positive_number("rho", rho)
    _scale(mass, radius, D)
    return mass, radius


def rolling_scale(inertia: Inertia, m: Any, rho: Any) -> float:
    """Return D = mρ², which must be the D of a special operator, or raise."""
    expected = inertia.D if isinstance(inertia, SpecialInertia) else None
    return _scale(positive_number("m", m), positive_number("rho", rho), expected)


def _scale(m: float, rho: float, expected: float | None) -> float:
    D = positive_number("m*rho**2", m * rho * rho)
    if expected is None:
        return D
    if abs(D - expected) > SILENT * expected:
        raise gi.DomainError("m*rho**2", D, f"D = {expected!r}")
    return expected


def initial_attitude(gamma: Any, g: Any, n: int) -> tuple[Array, Array]:
    """Return (γ, flat g) with γ = g⁻¹E_n, the last row of g, from either of them or both.

    Raises
    ------
    geomint.DomainError
        If both are None, if g is no rotation, or if gγ is not E_n.
    """
    if g is None:
        if gamma is None:
            raise gi.DomainError("gamma", ..., f"{n} numbers, or the attitude g")
        vertical = gi.Sphere(n).point(gamma)
        return vertical, upright(vertical).reshape(-1)
    attitude = gi.Rotations(n).point(g)
    if gamma is not None:
        admit_vertical(gi.Sphere(n).point(gamma), attitude)
    return attitude[-n:].copy(), attitude


def has_attitude(attitude: Any, k0: Any) -> bool:
    """Return whether a problem carries the attitude, which a spatial momentum k_0 needs."""
    if not switch("attitude", attitude) and k0 is not None:
        raise gi.DomainError("k0", k0, "None, or attitude=True: without g nothing is in space")
    return bool(attitude)


def own_attitude(g: Any, attitude: bool, n: int) -> list[Array]:
    """Return the flat g of a problem that carries the attitude, 1 unless given; of another nothing."""
    if attitude:
        return [gi.Rotations(n).point(g)]
    if g is not None:
        raise gi.DomainError("g", g, "no attitude: this problem has attitude=False")
    return []


def admit_vertical(gamma: Array, g: Array) -> Array:
    """Return the γ of a flat state that has g as well, repaired if need be; see `manifold`."""
    row = g[-len(gamma) :]
    defect = float(np.max(np.abs(gamma - row)))
    if defect <= SILENT:
        return gamma
    if defect > REPAIRED:
        expected = f"g⁻¹E_n, the last row of g; they differ by {defect:.3g}"
        raise gi.DomainError("gamma", gamma, expected)
    warn(f"gamma differs from the last row of g by {defect:.3g}: the state uses g", "gamma", defect)
    return row.copy()


def momentum_inverted(inertia: Inertia, D: float, gamma: Array, k: Array) -> Array:
    """Return the flat triangle of ω from that of k, by the n×n system of `angular_velocity`."""
    n, diagonal = inertia.n, inertia.diagonal

    def inverse(x: Any) -> Array:
        if diagonal is not None:
            return x / diagonal
        assert isinstance(inertia, GeneralInertia)
        return solved(inertia.matrix, x)

    columns = [skew_matrix(inverse(wedge(e, gamma)), n) @ gamma for e in np.eye(n)]
    matrix = np.eye(n) + D * np.array(columns).T
    v = solved(matrix, skew_matrix(inverse(k), n) @ gamma)
    return inverse(k - D * wedge(v, gamma))


def initial_rolling(
    inertia: Inertia, D: float, gamma: Array, **components: Any
) -> tuple[Array, Array]:
    """Return the flat triangles of k and ω from one of p, p_tilde, k, omega."""
    _, k = initial_momentum(inertia, D, gamma, **components)
    if components.get("omega") is not None:
        return k, skew_components("omega", components["omega"], inertia.n)
    return k, momentum_inverted(inertia, D, gamma, k)


def initial_position(r: Any, n: int) -> Array:
    """Return the horizontal coordinates of the contact point; the origin for None."""
    return np.zeros(n - 1) if r is None else as_vector("r", r, n - 1)


def rolling_velocity(rho: float, g: Array, omega: Array) -> Array:
    """Return the velocity v = ρ gωγ of the centre, eq. (ch-constr), n−1 components."""
    n = round(len(g) ** 0.5)
    matrix = g.reshape(n, n)
    return rho * (matrix[:-1] @ (skew_matrix(omega, n) @ matrix[-1]))


def admit_velocity(v: Array, rho: float, g: Array, omega: Array) -> Array:
    """Return a v, repaired if need be; defects are relative to ρ|ω| and |v|; see `manifold`.

    Raises
    ------
    geomint.DomainError
        If the ball slips: with the velocity of the contact point.
    """
    expected = rolling_velocity(rho, g, omega)
    size = max(length(v), rho * length(omega))
    slip = length(v - expected)
    if slip <= SILENT * size:
        return v
    if slip > REPAIRED * size:
        text = f"rho g omega gamma = {expected.tolist()}: the contact point slips at {slip:.3g}"
        raise gi.DomainError("v", v, text)
    text = f"the contact point of the state slips at {slip:.3g}: v projected to rho g omega gamma"
    warn(text, "v", slip / size)
    return expected
