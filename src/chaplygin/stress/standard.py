"""The motions that all cases start from: generic numbers, in any dimension."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array
from ..systems.related import ELLIPSOID
from ..systems.rolling import ROLLING
from ..systems.sphere import REDUCED
from ..systems.veselova import VESELOVA

__all__ = [
    "MOTIONS",
    "QUICK",
    "D",
    "Motion",
    "a_values",
    "direction",
    "momentum",
    "representations",
]

D = 4.0
QUICK = ("reduced", "hamiltonized", "classical-attitude")  # representations of quick runs, n = 3

Motion = Callable[[Array, float, Array, Array], gi.Model]


def a_values(n: int) -> Array:
    """Return a_i in (0.7, 1.5): all products are less than D."""
    return np.asarray(1.1 + 0.4 * np.sin(1.0 + 1.7 * np.arange(n)))


def direction(n: int) -> Array:
    """Return a unit vector without small components."""
    gamma = 1.0 + 0.6 * np.cos(1.0 + 1.9 * np.arange(n))
    return np.asarray(gamma / np.linalg.norm(gamma))


def momentum(gamma: Array) -> Array:
    """Return a p ⟂ γ with |p| = 2."""
    p = np.sin(0.4 + 2.3 * np.arange(len(gamma)))
    for _ in range(2):
        p = p - (gamma @ p) / (gamma @ gamma) * gamma
    return np.asarray(2.0 * p / np.linalg.norm(p))


def _built(
    system: gi.System, parameters: Mapping[str, Any], initial: Mapping[str, Any]
) -> gi.Model:
    def plain(given: Mapping[str, Any]) -> dict[str, Any]:
        return {key: v.tolist() if isinstance(v, np.ndarray) else v for key, v in given.items()}

    arguments = system.parameters(**plain(parameters)), system.initial(**plain(initial))
    return system.build(*arguments)


def sphere(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return a ball without SO(n−1)-momentum in all its representations."""
    return _built(REDUCED, {"a": a, "D": d}, {"gamma": gamma, "p": p})


def rolling(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the same ball with attitude and contact point; the representations that carry them."""
    model = _built(ROLLING, {"a": a, "D": d}, {"gamma": gamma, "p": p})
    names = ("rolling", "contact")
    return gi.Model({k: model.problems[k] for k in names}, {k: model.states[k] for k in names})


def veselova(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the Veselova problem."""
    return _built(VESELOVA, {"a": a, "D": d}, {"gamma": gamma, "p": p})


def ellipsoid(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the geodesic of the ellipsoid with semi-axes √a_i from a point in direction γ."""
    return _built(ELLIPSOID, {"a": a}, {"x": gamma, "p": p})


MOTIONS: dict[str, Motion] = {
    "sphere": sphere,
    "rolling": rolling,
    "veselova": veselova,
    "ellipsoid": ellipsoid,
}


def representations(name: str, n: int) -> tuple[str, ...] | None:
    """Return those of a motion that differ: what carries the attitude covers what does not."""
    if name != "sphere":
        return None
    return (
        "reduced",
        "hamiltonized",
        "ball-attitude",
        *(("classical-attitude",) if n == 3 else ()),
    )
