"""Initial states of the Veselova problem, given by any of p, p̃, k, w."""

from typing import Any

import geomint as gi

from ..initial_states import TANGENT, given_tangent, one_of, tangent_of_momentum
from ..manifold import SILENT, Array, length, repaired, skew_components, warn

KEYS = (*TANGENT, "k", "w")


def veselova_tangent(a: Array, D: float, gamma: Any, **components: Any) -> tuple[Array, Array]:
    """Return (γ, p) from γ and one of p, p_tilde, k = γ∧p, and the angular velocity w ∈ γ∧R^n.

    Warns where it projects.

    Raises
    ------
    geomint.DomainError
        For anything that does not describe a state; also if k or w are not in γ∧R^n.
    """
    n, name = len(a), one_of(components, KEYS)
    vertical, value = gi.Sphere(n).point(gamma), components[name]
    if name in TANGENT:
        return vertical, given_tangent(a, D, vertical, name, value)
    triangle = skew_components(name, value, n)
    if name == "k":
        return vertical, tangent_of_momentum(vertical, triangle)
    velocity = tangent_of_momentum(vertical, triangle, name, "w", "velocity")
    return vertical, momentum_of_velocity(a, vertical, velocity)


def momentum_of_velocity(a: Array, gamma: Array, velocity: Array) -> Array:
    """Return p = U A⁻¹γ̇ − (A⁻¹γ, γ̇) A⁻¹γ, the derivative of the reduced Lagrangian by γ̇.

    w = γ∧γ̇, so that L = ½⟨𝓘w, w⟩ = ½(U (γ̇, A⁻¹γ̇) − (A⁻¹γ, γ̇)²).
    """
    b, v = gamma / a, velocity / a
    return (gamma @ b) * v - (b @ velocity) * b


def on_level(gamma: Array, v: Array, f1: float, name: str) -> Array:
    """Return the v with (γ, v) = f₁ nearest to the given one; warn if that is another one."""
    defect = _defect(gamma, v, f1)
    if defect <= SILENT:
        return v
    text = f"({name}, gamma) is {float(gamma @ v)!r}, not f1 = {f1!r}: the state is projected to it"
    warn(text, name, defect)
    return _moved(gamma, v, f1)


def admit_on_level(gamma: Array, k: Array, f1: float) -> Array:
    """Return the k of a flat state, repaired if need be; see `manifold`."""
    defect, expected = _defect(gamma, k, f1), f"a vector with (k, gamma) = f1 = {f1!r}"
    said = "|(k, gamma) − f1| over the larger of |k| and |f1|"
    return repaired("k", k, defect, said, expected, lambda: _moved(gamma, k, f1))


def _defect(gamma: Array, v: Array, f1: float) -> float:
    """Return |(γ, v) − f₁| relative to the larger of |v| and |f₁|."""
    size = max(length(v), abs(f1))
    return 0.0 if size == 0.0 else abs(float(gamma @ (v / size)) - f1 / size)


def _moved(gamma: Array, v: Array, f1: float) -> Array:
    """Return v with its component along γ replaced; twice, so that it is f₁ to round-off."""
    for _ in range(2):
        v = v + (f1 - gamma @ v) * gamma
    return v
