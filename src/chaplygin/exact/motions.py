"""What problems offer as their exact flow; the flow itself is loaded when it is wanted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..manifold import Array

__all__ = ["exact_ball", "exact_sphere", "exact_veselova"]


def exact_sphere(a: Array, D: float, physical: bool) -> Callable[[Array], Any]:
    """Return y0 ↦ the exact motion of the sphere with the special operator.

    Parameters
    ----------
    a, D
        See `ChaplyginSphere`.
    physical : bool
        Whether states are (γ, p), else (γ, p̃).
    """

    def motion(y: Array) -> Any:
        from .flow import ExactFlow, sphere_weights
        from .great_circle import ExactGreatCircle

        if np.ptp(a) == 0.0:
            return ExactGreatCircle(float(a[0]), D, D / float(a[0]) - float(a[0]), y, physical)
        return ExactFlow(a, D, sphere_weights(a, D), y, physical)

    return motion


def exact_veselova(a: Array, D: float, physical: bool) -> Callable[[Array], Any]:
    """Return y0 ↦ the exact motion of the Veselova problem with r = 1; as `exact_sphere`."""

    def motion(y: Array) -> Any:
        from .flow import ExactFlow, veselova_weights
        from .great_circle import ExactGreatCircle

        if np.ptp(a) == 0.0:
            return ExactGreatCircle(float(a[0]), D, D * D * float(a[0]), y, physical)
        return ExactFlow(a, D, veselova_weights(a, D), y, physical)

    return motion


def exact_ball(inertia: Any, D: float) -> Callable[[Array], Any]:
    """Return y0 ↦ the exact motion of the ball in R³ at any area constant."""

    def motion(y: Array) -> Any:
        from ..ball.sphere import ChaplyginSphere
        from .classical import ExactBall

        return ExactBall(ChaplyginSphere(inertia=inertia, D=D), y)

    return motion
