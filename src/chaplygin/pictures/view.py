"""Space seen from afar: an orthographic projection, and curves with their hidden parts faint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..manifold import Array

__all__ = ["COLOURS", "View", "draw_curve"]

# Okabe and Ito's: colour-blind readers distinguish them.
COLOURS = {"blue": "#0072b2", "orange": "#d55e00", "green": "#009e73", "grey": "#999999"}
FAINT = 0.25


@dataclass(frozen=True)
class View:
    """Where one looks from.

    Parameters
    ----------
    azimuth, elevation : float
        In degrees; E_3 points upwards.
    """

    azimuth: float = -55.0
    elevation: float = 28.0

    @property
    def axes(self) -> Array:
        """The directions to the right, upwards and towards the eye, as rows."""
        a, e = np.radians([self.azimuth, self.elevation])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        return np.stack([right, np.cross(eye, right), eye])

    def __call__(self, points: Array) -> Array:
        """Return (right, up, towards the eye) of points, shape (..., 3)."""
        return np.asarray(points @ self.axes.T)


def draw_curve(axis: Any, view: View, points: Array, **style: Any) -> None:
    """Draw a curve on a sphere about the origin: what is behind is faint."""
    shown = view(points)
    front = np.where(shown[:, 2:] >= 0.0, shown[:, :2], np.nan)
    back = np.where(shown[:, 2:] < 0.0, shown[:, :2], np.nan)
    axis.plot(*back.T, alpha=FAINT, zorder=1, **{**style, "label": None})
    axis.plot(*front.T, zorder=3, **style)
