"""Initial states given by any of p, p̃, k, ω, and brought to all of them."""

from typing import Any

import numpy as np

import geomint as gi

from .inertia import Inertia, SpecialInertia, angular_momentum
from .manifold import (
    REPAIRED,
    SILENT,
    Array,
    Arrays,
    Named,
    length,
    skew_components,
    skew_matrix,
    warn,
    wedge,
)

TANGENT = ("p", "p_tilde")
KEYS = (*TANGENT, "k", "omega")
FITTING = {  # which other system takes what this one refuses
    "momentum": ". The ball in (k, γ), system 'chaplygin-ball', takes any momentum",
    "velocity": ". At n = 3 the classical problem takes it, with f1 = (w, gamma)",
}


def one_of(components: Named, known: tuple[str, ...] = KEYS) -> str:
    """Return the name of the only momentum given, or raise `geomint.DomainError`."""
    for name, value in components.items():
        if name not in known:
            raise gi.DomainError(name, value, f"one of gamma, {', '.join(known)}")
    given = [name for name in known if components.get(name) is not None]
    if len(given) != 1:
        raise gi.DomainError("momentum", given, f"exactly one of {', '.join(known)}")
    return given[0]


def initial_momentum(
    inertia: Inertia, D: float, gamma: Any, vector: bool = False, **components: Any
) -> tuple[Array, Array]:
    """Return (γ, flat triangle of k) from γ and one of p, p_tilde, k, omega.

    With `vector` (n = 3), k and ω are 3-vectors. Warns where it projects; see `manifold`.

    Raises
    ------
    geomint.DomainError
        For anything that does not describe a state.
    """
    name, n = one_of(components), inertia.n
    vertical = gi.Sphere(n).point(gamma)
    if name in TANGENT:
        return vertical, wedge(vertical, _p(inertia, vertical, name, components[name]))
    value = skew_components(name, components[name], n, vector)
    return vertical, value if name == "k" else angular_momentum(inertia, D, vertical, value)


def initial_tangent(
    inertia: Inertia, D: float, gamma: Any, **components: Any
) -> tuple[Array, Array]:
    """Return (γ, p) from γ and one of p, p_tilde, k, omega; the last two without momentum.

    Raises
    ------
    geomint.DomainError
        Also if k or omega have an SO(n−1)-momentum: T*S^(n−1) has no such states.
    """
    name = one_of(components)
    if name in TANGENT:
        vertical = gi.Sphere(inertia.n).point(gamma)
        return vertical, _p(inertia, vertical, name, components[name])
    vertical, k = initial_momentum(inertia, D, gamma, **components)
    return vertical, tangent_of_momentum(vertical, k, name)


def _p(inertia: Inertia, gamma: Array, name: str, value: Any) -> Array:
    if isinstance(inertia, SpecialInertia):
        return given_tangent(inertia.a, inertia.D, gamma, name, value)
    if name == "p_tilde":
        raise gi.DomainError(name, value, "p instead: p_tilde needs the special inertia operator")
    return gi.TangentSphere(inertia.n).vector(gamma, value, name)


def given_tangent(a: Array, D: float, gamma: Array, name: str, value: Any) -> Array:
    """Return p ⟂ γ from p or p_tilde = p/(D√U)."""
    result = gi.TangentSphere(len(gamma)).vector(gamma, value, name)
    return result if name == "p" else result * multiplier(a, D, gamma)


def multiplier(a: Array, D: float, gamma: Array) -> float:
    """Return D√U = p/p̃ = dt/dτ, eqs. (CM) and (mapping)."""
    return float(D * np.sqrt(gamma @ (gamma / a)))


def tangent_of_momentum(
    gamma: Array, k: Array, name: str = "k", symbol: str = "k", noun: str = "momentum"
) -> Array:
    """Return the p ⟂ γ with k = γ∧p, namely −kγ, or raise if k has an SO(n−1)-momentum.

    Parameters
    ----------
    gamma, k : array
    name : str
        What the user gave, for messages.
    symbol, noun : str
        What k is called and is, for messages: w, the velocity, in the Veselova problem.
    """
    p, defect = _split(gamma, k)
    if defect > REPAIRED:
        expected = f"zero SO(n−1)-{noun} ({symbol} = gamma∧x); |pr {symbol}|/|{symbol}| is "
        raise gi.DomainError(name, k, f"{expected}{defect:.3g}{FITTING[noun]}")
    if defect > SILENT:
        said = f"|pr {symbol}|/|{symbol}| of {name} is {defect:.3g}, not 0"
        warn(f"{said}: the state uses {symbol} = gamma∧x", name, defect)
    return p


def tangent_arrays(y: Array, scale: float = 1.0) -> Arrays:
    """Return γ and k = γ∧p of a flat state (γ, p/scale): what other forms of the motion give too."""
    gamma, p = np.array(np.split(y, 2))
    return {"gamma": gamma, "k": wedge(gamma, scale * p)}


def momentum_free(gamma: Array, k: Array) -> Array | None:
    """Return the p ⟂ γ with k = γ∧p, or None if k has an SO(n−1)-momentum beyond round-off."""
    p, defect = _split(gamma, k)
    return p if defect <= SILENT else None


def _split(gamma: Array, k: Array) -> tuple[Array, float]:
    """Return p = −kγ and |k − γ∧p|/|k|."""
    size = length(k)
    if size == 0.0:
        return np.zeros(len(gamma)), 0.0
    p = -skew_matrix(k / size, len(gamma)) @ gamma
    p -= (gamma @ p) * gamma
    return size * p, length(k / size - wedge(gamma, p))
