"""The motions that all cases start from: generic numbers, in any dimension."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array, wedge
from ..systems.ball import GROUP, POISSON
from ..systems.lr import LR
from ..systems.related import CLEBSCH, ELLIPSOID, NEUMANN
from ..systems.rolling import ROLLING
from ..systems.rubber import RUBBER
from ..systems.sphere import REDUCED
from ..systems.veselova import VESELOVA

D = 4.0
QUICK = ("reduced",)  # representations of quick runs, n = 3

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
    p = gi.Sphere(len(gamma)).tangent(gamma, p)
    return np.asarray(2.0 * p / np.linalg.norm(p))


def built(system: gi.System, parameters: Mapping[str, Any], initial: Mapping[str, Any]) -> gi.Model:
    """Return the model of a system, from parameters and states as arrays."""

    def plain(given: Mapping[str, Any]) -> dict[str, Any]:
        return {key: v.tolist() if isinstance(v, np.ndarray) else v for key, v in given.items()}

    arguments = system.parameters(**plain(parameters)), system.initial(**plain(initial))
    return system.build(*arguments)


def only(model: gi.Model, *names: str) -> gi.Model:
    """Return a model with some of its representations."""
    return gi.Model({k: model.problems[k] for k in names}, {k: model.states[k] for k in names})


def sphere(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return a ball without SO(n−1)-momentum in all its representations."""
    return built(REDUCED, {"a": a, "D": d}, {"gamma": gamma, "p": p})


def rolling(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the same ball with attitude and contact point; the representations that carry them."""
    model = built(ROLLING, {"a": a, "D": d}, {"gamma": gamma, "p": p})
    return only(model, "rolling", "contact")


def veselova(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the Veselova problem."""
    return built(VESELOVA, {"a": a, "D": d}, {"gamma": gamma, "p": p})


def ellipsoid(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the geodesic of the ellipsoid with semi-axes √a_i from a point in direction γ."""
    return built(ELLIPSOID, {"a": a}, {"x": gamma, "p": p})


def rubber(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the rubber ball: its D is 1/d, so that a_i a_j → d is the edge of its domain too."""
    return built(RUBBER, {"a": a, "D": 1.0 / d}, {"gamma": gamma, "p": p})


def lr(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the Veselova problem with multipliers; r = 2 from n = 4 on, where that is not free."""
    n = len(gamma)
    g = attitude(gamma)
    r = 2 if n > 3 else 1
    w = wedge(gamma, p) + (0.5 * np.linalg.norm(p) * wedge(g[1], g[-1]) if r > 1 else 0.0)
    return built(LR, {"a": a, "r": r}, {"g": g, "w": w})


def clebsch(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return Clebsch's system; the potential grows with (p, p), so that p has no unit here either."""
    parameters = {"a": a, "strength": float(p @ p) / 4.0, "x": -1.0, "y": 4.0}
    return built(CLEBSCH, parameters, {"q": gamma, "v": p})


def neumann(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return Neumann's system, its potential as that of Clebsch's."""
    return built(NEUMANN, {"a": a, "strength": float(p @ p) / 4.0}, {"q": gamma, "v": p})


def poisson(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the ball in R³ with momentum about the vertical, in the times τ and t."""
    return built(POISSON, {"a": a, "D": d}, {"gamma": gamma, "k": spinning(gamma, p)})


def group(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the ball with momentum about the vertical on T*SO(n)."""
    return built(GROUP, {"a": a, "D": d}, {"gamma": gamma, "k": spinning(gamma, p)})


def bound_body(a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return the classical Veselova problem with f₁ ≠ 0 and moments 1/(a_i a_j)."""
    moments, f1 = a / np.prod(a), 0.25 * float(np.linalg.norm(p))
    return built(VESELOVA, {"moments": moments, "f1": f1}, {"gamma": gamma, "w": p + f1 * gamma})


def spinning(gamma: Array, p: Array) -> Array:
    """Return γ∧p and a part that turns about the vertical (n > 2), as long as p."""
    v = gi.Sphere(len(gamma)).tangent(gamma, np.cos(0.3 + 1.1 * np.arange(len(gamma))))
    return np.asarray(wedge(gamma, p) + 0.5 * wedge(p, v))


def attitude(gamma: Array) -> Array:
    """Return a rotation with γ for its first row."""
    n = len(gamma)
    mirror = gamma.copy()
    mirror[0] += np.copysign(1.0, gamma[0])
    g = np.eye(n) - 2.0 * np.outer(mirror, mirror) / (mirror @ mirror)  # γ to ∓E_1
    g[0] *= -np.copysign(1.0, gamma[0])
    if gamma[0] < 0.0:
        g[-1] *= -1.0
    return np.asarray(g)


MOTIONS: dict[str, Motion] = {
    "sphere": sphere,
    "rolling": rolling,
    "group": group,
    "poisson": poisson,
    "rubber": rubber,
    "veselova": veselova,
    "veselova-classical": bound_body,
    "veselova-lr": lr,
    "ellipsoid": ellipsoid,
    "neumann": neumann,
    "clebsch": clebsch,
}
THREE = ("poisson", "veselova-classical")  # motions that there are for n = 3 alone


def started(motion: Motion, n: int, size: float = 1.0) -> gi.Model:
    """Return a motion with generic numbers, |p| = 2 size."""
    gamma = direction(n)
    return motion(a_values(n), D, gamma, size * momentum(gamma))


def case_of(
    axis: gi.StressAxis,
    name: str,
    n: int,
    value: float,
    build: Callable[[], gi.Model],
    place: str = "",
    quick: bool = False,
    **others: Any,
) -> gi.StressCase:
    """Return a case of a motion; in quick runs is that of the sphere in R³ where it is `quick`."""
    chosen = QUICK if quick and (name, n) == ("sphere", 3) else ()
    others = {"representations": representations(name, n), "quick": chosen, **others}
    return gi.StressCase(f"{name}{place}-n{n}", axis, value, n, build, **others)


def representations(name: str, n: int) -> tuple[str, ...] | None:
    """Return those of a motion that differ: what carries the attitude covers what does not."""
    if name == "group":
        return ("group",)
    if name == "veselova-classical":
        return ("classical", "multiplier")
    if name != "sphere":
        return None
    return (
        "reduced",
        "hamiltonized",
        "ball-attitude",
        *(("classical-attitude",) if n == 3 else ()),
    )
