"""The Chaplygin sphere without SO(n−1)-momentum, in time t and in time τ."""

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..inertia import SpecialInertia
from ..manifold import skew_components, skew_matrix
from .ball import AnyBall
from .models import sphere_model
from .parameters import Initial, Numbers, Strict, keys_of

SpecialKeys = keys_of(SpecialInertia, __name__, "SpecialKeys", a=Numbers)


def _hamiltonized(parameters: Strict, initial: Initial) -> gi.Model:
    sphere = ChaplyginSphere(**dict(parameters))
    return sphere_model(sphere, "hamiltonized", initial.gamma, **initial.components())


def _reduced(parameters: AnyBall, initial: Initial) -> gi.Model:
    """Return the model; k and omega are vectors in R³ where moments are given."""
    given = initial.components()
    for name in given.keys() & {"k", "omega"} if parameters.moments is not None else ():
        given[name] = skew_matrix(skew_components(name, given[name], 3, vector=True), 3)
    return sphere_model(parameters.sphere(), "reduced", initial.gamma, **given)


REDUCED = gi.System(
    "chaplygin-sphere-reduced",
    "the Chaplygin sphere without SO(n−1)-momentum, any inertia, on T*S^(n−1), in time t",
    AnyBall,
    Initial,
    _reduced,
)
HAMILTONIZED = gi.System(
    "chaplygin-sphere-hamiltonized",
    "the Hamiltonised Chaplygin sphere, a geodesic flow on T*S^(n−1), in time τ",
    SpecialKeys,
    Initial,
    _hamiltonized,
)
