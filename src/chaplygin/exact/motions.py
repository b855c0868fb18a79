"""What problems offer as their exact flow; the flow itself is loaded when it is wanted."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..inertia import SpecialInertia
from ..manifold import Array

Motion = Callable[[Array], Any]  # of a state


def exact_sphere(a: Array, D: float, physical: bool) -> Motion:
    """Return y0 ↦ the exact motion of the sphere with the special operator.

    Parameters
    ----------
    a, D
        See `ChaplyginSphere`.
    physical : bool
        Whether states are (γ, p), else (γ, p̃).
    """
    return _exact(a, D, (D, -1.0), physical)


def exact_veselova(a: Array, D: float, physical: bool) -> Motion:
    """Return y0 ↦ the exact motion of the Veselova problem with r = 1; as `exact_sphere`."""
    return _exact(a, D, (0.0, D * D), physical)


def _exact(a: Array, D: float, energy: tuple[float, float], physical: bool) -> Motion:
    def motion(y: Array) -> Any:
        from .flow import ExactFlow
        from .separated_energy import SeparatedEnergy

        return ExactFlow(a, D, SeparatedEnergy(*energy), y, physical)

    return motion


def exact_ball(inertia: Any, D: float) -> Motion:
    """Return y0 ↦ the exact motion of the ball in R³ at any area constant."""

    def motion(y: Array) -> Any:
        from .classical import ExactBall

        return ExactBall(inertia, D, y)

    return motion


def exact_turn(inertia: Any, D: float) -> Motion | None:
    """Return y0 ↦ the exact motion of the ball in (k, γ) or (k, γ, g) if I = s·1, else None."""
    special = isinstance(inertia, SpecialInertia)
    if not special or (inertia.n > 2 and np.ptp(inertia.a) != 0.0):
        return None

    def motion(y: Array) -> Any:
        from .steady import SteadyTurn

        return SteadyTurn(inertia.n, float(inertia.diagonal[0]), D, y)

    return motion


def exact_body(inverse: Array, f1: float) -> Motion:
    """Return y0 ↦ the exact motion of the classical Veselova problem; inverse moments, and f₁."""

    def motion(y: Array) -> Any:
        from .body import ExactBody

        return ExactBody(inverse, f1, y)

    return motion
