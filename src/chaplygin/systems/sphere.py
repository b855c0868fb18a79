"""The Chaplygin sphere without SO(n−1)-momentum, in time t and in time τ."""

from __future__ import annotations

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from .models import sphere_model
from .parameters import Initial, Number, Numbers, Strict

__all__ = ["HAMILTONIZED", "REDUCED"]


class SpecialParameters(Strict):
    """The special inertia operator, eq. (operator)."""

    a: Numbers
    D: Number


def _system(first: str, summary: str) -> gi.System:
    """Return the system whose own representation is `first`."""

    def build(parameters: SpecialParameters, initial: Initial) -> gi.Model:
        sphere = ChaplyginSphere(a=parameters.a, D=parameters.D)
        return sphere_model(sphere, first, initial.gamma, **initial.components())

    return gi.System(f"chaplygin-sphere-{first}", summary, SpecialParameters, Initial, build)


REDUCED = _system(
    "reduced", "the Chaplygin sphere without SO(n−1)-momentum, on T*S^(n−1), in time t"
)
HAMILTONIZED = _system(
    "hamiltonized", "the Hamiltonised Chaplygin sphere, a geodesic flow on T*S^(n−1), in time τ"
)
