"""Pictures of a motion: components over time, a phase plane, the sphere, the contact point.

A motion comes as samples. Where lines between them would not be the motion, there are points alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array
from .canvas import new_figure
from .style import COLOURS, DASHES, WIDTH
from .view import View, great_circles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLUMN = 3.4  # inches, a column of a printed page
HIGH = 1.3  # of a panel over time
CONSTANT = 1e-9  # of its size: what moves less is drawn as constant
FRAME = "#999999"
START, END = "o", "s"
LETTERS = {"gamma": "γ", "omega": "ω", "p_tilde": "p̃", "tau": "τ", "theta": "θ", "phi": "φ"}


@dataclass(frozen=True)
class Heading:
    """What a picture says of the motion.

    Attributes
    ----------
    text : str
        System, method and the interval of time.
    note : str
        What was left out.
    joined : bool
        Whether lines between the samples are the motion.
    """

    text: str
    note: str = ""
    joined: bool = True

    @property
    def lines(self) -> str:
        """Both, one below the other."""
        return self.text + (f"\n{self.note}" if self.note else "")


@dataclass(frozen=True)
class Curves:
    """What one panel shows: numbers over time, one a column.

    Attributes
    ----------
    name, unit : str
    labels : sequence of str
        Of the columns, as readers see them.
    values : array, shape (N, columns)
    """

    name: str
    labels: Sequence[str]
    values: Array = field(repr=False)
    unit: str = "dimensionless"


def symbol(name: str, *index: int) -> str:
    """Return a piece, or one of its components, counted as in code: γ[0] for gamma and 0."""
    return LETTERS.get(name, name) + (f"[{', '.join(map(str, index))}]" if index else "")


def motion_figure(
    times: Array, panels: Sequence[Curves], time_label: str, heading: Heading
) -> Figure:
    """Return a figure of components over time, a panel a piece, for a page 6.5 inches wide."""
    height = 0.6 + 0.18 * bool(heading.note) + HIGH * len(panels)
    with new_figure(WIDTH, height, layout="constrained") as figure:
        grid = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
        for axes, curves in zip(grid, panels, strict=True):
            draw_curves(axes, times, curves, heading.joined)
        grid[-1].set_xlabel(time_label)
        grid[0].set_title(heading.lines, loc="left")
    return figure


def draw_curves(axes: Axes, times: Array, curves: Curves, joined: bool = True) -> None:
    """Draw the columns over time, and what they are beside the panel."""
    for i, (label, column) in enumerate(zip(curves.labels, curves.values.T, strict=True)):
        style = _style(i, joined)
        axes.plot(times, column, label=label, **style)
    _no_noise(axes, y=curves.values)
    axes.set_ylabel(f"{curves.name}\n({curves.unit})", fontsize=8)
    axes.margins(x=0.0 if joined else 0.02)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.6, labelspacing=0.3)


def _style(i: int, joined: bool) -> dict[str, Any]:
    colour = COLOURS[i % len(COLOURS)]
    if not joined:
        return {"color": colour, "linestyle": "none", "marker": ".", "markersize": 3.0}
    return {"color": colour, "linestyle": DASHES[i // 2 % len(DASHES)], "linewidth": 1.0}


def _no_noise(axes: Axes, **shown: Array) -> None:
    """Give what is constant but for rounding, on the axis x or y, limits that do not show it."""
    for side, values in shown.items():
        low, high = float(values.min()), float(values.max())
        size = max(abs(low), abs(high))
        if high - low <= CONSTANT * size or size == 0.0:
            pad = 0.1 * size or 1.0
            axes.set(**{f"{side}lim": (low - pad, high + pad)})


def plane_figure(
    points: Array, labels: tuple[str, str], heading: Heading, equal: bool = False
) -> Figure:
    """Return a figure of a path in a plane, for a column 3.4 inches wide."""
    with new_figure(COLUMN, COLUMN, layout="constrained") as figure:
        axes = figure.subplots()
        draw_plane(axes, points, labels, heading.joined, equal)
        _titled(figure, heading)
    return figure


def draw_plane(
    axes: Axes, points: Array, labels: tuple[str, str], joined: bool, equal: bool = False
) -> None:
    """Draw a path in a plane; `equal`: a unit is as long to the right as upwards."""
    style: dict[str, Any] = {"linewidth": 0.8}
    if not joined:
        style = {"linestyle": "none", "marker": ".", "markersize": 3}
    axes.plot(*points.T, color=COLOURS[0], rasterized=len(points) > 20_000, **style)
    if joined:
        _ends(axes, points)
        axes.legend(loc="best", handletextpad=0.1)
    _no_noise(axes, x=points[:, 0], y=points[:, 1])
    axes.set(xlabel=labels[0], ylabel=labels[1])
    if equal:
        axes.set_aspect("equal", adjustable="datalim")


def sphere_figure(points: Array, name: str, heading: Heading, view: View) -> Figure:
    """Return a figure of directions on the unit sphere, for a column 3.4 inches wide."""
    with new_figure(COLUMN, COLUMN, layout="constrained") as figure:
        draw_sphere(figure.subplots(), points, name, heading.joined, view)
        _titled(figure, heading)
    return figure


def draw_sphere(axes: Axes, points: Array, name: str, joined: bool, view: View) -> None:
    """Draw unit vectors on the sphere, hidden parts faint, with the axes and three great circles."""
    draw_globe(axes, view)
    if joined:
        view.draw_curve(axes, points, color=COLOURS[0], linewidth=0.9)
        _ends(axes, view(points)[:, :2])
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, 0.03), ncols=2, handletextpad=0.1,
                    borderaxespad=0.0)  # fmt: skip
    else:
        shown = view(points)
        for part, dark in ((shown[:, 2] < 0.0, 0.3), (shown[:, 2] >= 0.0, 1.0)):
            axes.plot(*shown[part, :2].T, ".", color=COLOURS[0], alpha=dark, markersize=3)
    label_axes(axes, name, view)
    axes.set(xlim=(-1.25, 1.25), ylim=(-1.25, 1.25))


def draw_globe(axes: Axes, view: View) -> None:
    """Draw the outline of the unit sphere and three great circles."""
    from matplotlib.patches import Circle

    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=FRAME, linewidth=0.8))
    for circle in great_circles():
        view.draw_curve(axes, circle, color=FRAME, linewidth=0.5)
    axes.set_aspect("equal")
    axes.set_axis_off()


def label_axes(axes: Axes, name: str, view: View) -> None:
    """Mark where the axes of the body leave the sphere, with the name of the component."""
    for i in range(3):
        x, y, near = view(np.eye(3)[i])
        size = float(np.hypot(x, y)) or 1.0
        dark = "black" if near >= 0.0 else FRAME
        axes.plot(x, y, ".", color=dark, markersize=3.5, zorder=4)
        ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.3}
        axes.text(x + 0.13 * x / size, y + 0.13 * y / size, symbol(name, i), color=dark, fontsize=9,
                  ha="center", va="center", zorder=6, bbox=ground)  # fmt: skip


def _ends(axes: Axes, points: Array) -> None:
    """Mark where a path begins and where it ends."""
    for at, marker, words in ((0, START, "start"), (-1, END, "end")):
        axes.plot(*points[at], marker, color=COLOURS[1], markersize=4.5, zorder=5, label=words,
                  linestyle="none", markerfacecolor="white" if at else COLOURS[1])  # fmt: skip


def _titled(figure: Figure, heading: Heading) -> None:
    """Write the heading in lines that fit a column."""
    import textwrap

    text = "\n".join(line for part in heading.lines.split("\n") for line in textwrap.wrap(part, 46))
    figure.suptitle(text, x=0.02, ha="left", fontsize=9)
