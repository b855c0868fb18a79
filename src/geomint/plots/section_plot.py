"""Pictures of sections: the points of several motions in a plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array, Booleans, Integers
from .canvas import new_figure
from .panels import say
from .style import COLOURS, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


BEYOND, EDGE = "#e6e6e6", "#666666"
Boundary = tuple[
    Array, Array, Array, float
]  # sides of a grid, the least energy on it, the motions'
MARGIN = 0.06  # of what the energy allows: so much is shown beyond
MOST = 60_000  # points that a vector graphic can bear; more are drawn as an image


def section_figure(
    points: tuple[Array, Array],
    motions: Integers,
    axes: tuple[str, str],
    title: str,
    boundary: Boundary | None = None,
) -> Figure:
    """Return a figure of points (x, y), a colour for each motion, for print 6.5 inches wide."""
    with new_figure(WIDTH, 0.8 * WIDTH, layout="constrained") as figure:
        panel = figure.subplots()
        draw_section(panel, points, motions, axes, boundary)
        count = len(motions)
        panel.set_title(f"{title}: {count} point{'' if count == 1 else 's'}")
        return figure


def draw_section(
    panel: Axes,
    points: tuple[Array, Array],
    motions: Integers,
    axes: tuple[str, str],
    boundary: Boundary | None = None,
) -> None:
    """Draw points (x, y), a colour for each motion.

    With a boundary the line around where the energy allows points, and what lies beyond in grey.
    """
    x, y = points
    if boundary is not None:
        _draw_boundary(panel, boundary)
    size = float(np.clip(3000.0 / max(len(x), 1), 0.5, 6.0))
    for motion in np.unique(motions):
        which = motions == motion
        colour = COLOURS[int(motion) % len(COLOURS)]
        panel.plot(
            x[which], y[which], linestyle="none", marker="o", markersize=size**0.5,
            markeredgewidth=0.0, color=colour, rasterized=len(x) > MOST,
        )  # fmt: skip
    panel.set(xlabel=axes[0], ylabel=axes[1])
    if not len(x):
        say(panel, "no points")


def _draw_boundary(panel: Axes, boundary: Boundary) -> None:
    """Draw where the least energy is that of the motions."""
    x, y, least, energy = boundary
    levels = [energy, max(float(least.max()), energy) + 1.0]
    grid = x, y, least
    panel.contourf(*grid, levels=levels, colors=[BEYOND])
    if least.min() < energy < least.max():
        panel.contour(*grid, levels=[energy], colors=[EDGE], linewidths=0.8)
    inside = least <= energy
    if inside.any():
        panel.set(xlim=_around(x, inside, 0), ylim=_around(y, inside, 1))


def _around(values: Array, inside: Booleans, across: int) -> tuple[float, float]:
    """Return limits of an axis: what is inside, and a little beyond where there is a beyond."""
    allowed = np.flatnonzero(inside.any(axis=across))
    low, high = float(values[allowed[0]]), float(values[allowed[-1]])
    more = MARGIN * (high - low)
    return max(low - more, float(values[0])), min(high + more, float(values[-1]))
