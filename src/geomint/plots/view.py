"""Space seen from afar: an orthographic projection, and curves on spheres with hidden parts faint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array, finite
from ..errors import DomainError

if TYPE_CHECKING:
    from matplotlib.axes import Axes


FAINT = 0.25
POINTS = 73  # of a great circle


@dataclass(frozen=True)
class View:
    """Where one looks from.

    Parameters
    ----------
    azimuth, elevation : float
        In degrees, |azimuth| ≤ 360 and |elevation| ≤ 90; E_3 points upwards.

    Raises
    ------
    DomainError
    """

    azimuth: float = -55.0
    elevation: float = 28.0

    def __post_init__(self) -> None:
        for name, most in (("azimuth", 360.0), ("elevation", 90.0)):
            given, expected = getattr(self, name), f"degrees from {-most:g} to {most:g}"
            angle = finite(name, given, expected)
            if abs(angle) > most:
                raise DomainError(name, given, expected)
            object.__setattr__(self, name, angle)

    @property
    def axes(self) -> Array:
        """The directions to the right, upwards and towards the eye, as rows."""
        a, e = np.radians([self.azimuth, self.elevation])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        return np.stack([right, np.cross(eye, right), eye])

    def __call__(self, points: Array) -> Array:
        """Return (right, up, towards the eye) of points, shape (..., 3)."""
        return points @ self.axes.T

    def draw_curve(self, axis: Axes, points: Array, **style: Any) -> None:
        """Draw a curve on a sphere about the origin: what is behind is faint."""
        shown = self(points)
        front = np.where(shown[:, 2:] >= 0.0, shown[:, :2], np.nan)
        back = np.where(shown[:, 2:] < 0.0, shown[:, :2], np.nan)
        axis.plot(*back.T, alpha=FAINT, zorder=1, **{**style, "label": None})
        axis.plot(*front.T, zorder=3, **style)


def great_circles() -> list[Array]:
    """Return the circles across the three axes on the unit sphere, points one a row."""
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(POINTS)], axis=-1)
    return [np.roll(circle, shift, axis=1) for shift in (1, 2, 0)]
