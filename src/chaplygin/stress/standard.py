"""The motions that all cases start from: generic numbers, in any dimension."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import geomint as gi

from ..manifold import Array, Named, wedge
from ..systems.ball import GROUP, POISSON
from ..systems.lr import LR
from ..systems.related import CLEBSCH, ELLIPSOID, NEUMANN
from ..systems.rolling import ROLLING
from ..systems.rubber import RUBBER
from ..systems.sphere import REDUCED
from ..systems.veselova import VESELOVA

D = 4.0
QUICK = ("reduced",)  # representations of quick runs, n = 3

SYSTEMS = {
    "sphere": REDUCED,
    "rolling": ROLLING,
    "group": GROUP,
    "poisson": POISSON,
    "rubber": RUBBER,
    "veselova": VESELOVA,
    "veselova-classical": VESELOVA,
    "veselova-lr": LR,
    "ellipsoid": ELLIPSOID,
    "neumann": NEUMANN,
    "clebsch": CLEBSCH,
}  # of motions by name
THREE = ("poisson", "veselova-classical")  # motions that there are for n = 3 alone


def a_values(n: int) -> Array:
    """Return a_i in (0.7, 1.5): all products are less than D."""
    return 1.1 + 0.4 * np.sin(1.0 + 1.7 * np.arange(n))


def direction(n: int) -> Array:
    """Return a unit vector without small components."""
    gamma = 1.0 + 0.6 * np.cos(1.0 + 1.9 * np.arange(n))
    return gamma / np.linalg.norm(gamma)


def momentum(gamma: Array) -> Array:
    """Return a p ⟂ γ with |p| = 2."""
    p = np.sin(0.4 + 2.3 * np.arange(len(gamma)))
    p = gi.Sphere(len(gamma)).tangent(gamma, p)
    return 2.0 * p / np.linalg.norm(p)


def built(system: gi.System, parameters: Mapping[str, Any], initial: Mapping[str, Any]) -> gi.Model:
    """Return the model of a system, from parameters and states as arrays."""

    def plain(given: Mapping[str, Any]) -> Named:
        return {key: v.tolist() if isinstance(v, np.ndarray) else v for key, v in given.items()}

    arguments = system.parameters(**plain(parameters)), system.initial(**plain(initial))
    return system.build(*arguments)


def only(model: gi.Model, *names: str) -> gi.Model:
    """Return a model with some of its representations."""
    return gi.Model({k: model.problems[k] for k in names}, {k: model.states[k] for k in names})


def motion(name: str, a: Array, d: float, gamma: Array, p: Array) -> gi.Model:
    """Return a motion from γ with p ⟂ γ.

    ``sphere`` is a ball without SO(n−1)-momentum in all its representations; ``rolling`` is the same
    ball with attitude and contact point: the representations that carry them; ``poisson`` and
    ``group`` have momentum about the vertical. The D of ``rubber`` is 1/d, so that a_i a_j → d is the
    edge of its domain too. ``veselova-classical`` has f₁ ≠ 0 and moments 1/(a_i a_j), ``veselova-lr``
    r = 2 from n = 4 on, where that is not free. ``ellipsoid`` has semi-axes √a_i, and begins in
    direction γ. The potentials of ``neumann`` and ``clebsch`` grow with (p, p), so that p has no unit
    there either.
    """
    numbers = {"a": a, "D": d}
    state = {"gamma": gamma, "p": p}
    if name in ("group", "poisson"):
        state = {"gamma": gamma, "k": spinning(gamma, p)}
    elif name == "rubber":
        numbers["D"] = 1.0 / d
    elif name == "veselova-classical":
        f1 = 0.25 * float(np.linalg.norm(p))
        numbers = {"moments": a / np.prod(a), "f1": f1}
        state = {"gamma": gamma, "w": p + f1 * gamma}
    elif name == "veselova-lr":
        g, w, r = attitude(gamma), wedge(gamma, p), 2 if len(gamma) > 3 else 1
        w = w + (0.5 * np.linalg.norm(p) * wedge(g[1], g[-1]) if r > 1 else 0.0)
        numbers, state = {"a": a, "r": r}, {"g": g, "w": w}
    elif name == "ellipsoid":
        numbers, state = {"a": a}, {"x": gamma, "p": p}
    elif name in ("neumann", "clebsch"):
        numbers, state = {"a": a, "strength": float(p @ p) / 4.0}, {"q": gamma, "v": p}
        if name == "clebsch":
            numbers |= {"x": -1.0, "y": 4.0}
    model = built(SYSTEMS[name], numbers, state)
    return only(model, "rolling", "contact") if name == "rolling" else model


def spinning(gamma: Array, p: Array) -> Array:
    """Return γ∧p and a part that turns about the vertical (n > 2), as long as p."""
    v = gi.Sphere(len(gamma)).tangent(gamma, np.cos(0.3 + 1.1 * np.arange(len(gamma))))
    return wedge(gamma, p) + 0.5 * wedge(p, v)


def attitude(gamma: Array) -> Array:
    """Return a rotation with γ for its first row."""
    n = len(gamma)
    mirror = gamma.copy()
    mirror[0] += np.copysign(1.0, gamma[0])
    g = np.eye(n) - 2.0 * np.outer(mirror, mirror) / (mirror @ mirror)  # γ to ∓E_1
    g[0] *= -np.copysign(1.0, gamma[0])
    if gamma[0] < 0.0:
        g[-1] *= -1.0
    return g


def started(name: str, n: int, size: float = 1.0) -> gi.Model:
    """Return a motion with generic numbers, |p| = 2 size."""
    gamma = direction(n)
    return motion(name, a_values(n), D, gamma, size * momentum(gamma))


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
