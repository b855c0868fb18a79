"""Plots of a report: each quantity of one run, several runs by kind of quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..plan import MethodRun, SeveralRuns
from ..plots.drift_plots import draw_sizes, drift_figure, grid_figure
from ..plots.panels import Line, draw_lines, line_style, shared_legend, thinned
from ..plots.style import new_figure, series_style
from ..watch.drift import ROUNDOFF
from ..watch.quantities import KINDS, kind_of
from .kinds import conserved_by_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_kind", "draw_quantity", "kinds_figure", "report_figure", "swatch"]


def report_figure(result: SeveralRuns) -> Figure:
    """Return the picture of a report: of one method every quantity, of several each kind."""
    if len(result) > 1:
        return kinds_figure(result)
    return drift_figure([(result[0].label, result[0].drift)], result.time, result.status)


def kinds_figure(result: SeveralRuns) -> Figure:
    """Return a figure with a panel for each kind, a line a method, for print 6.5 inches wide.

    A line shows the largest deviation of the quantities of its kind, each relative to its scale,
    so that one level of round-off holds for all of them.
    """
    kinds = conserved_by_kind(result)
    draws = [partial(draw_kind, result, kind, names) for kind, names in kinds.items()]
    with grid_figure(draws, 2.2) as (figure, grid):
        panels = grid.flat[: len(kinds)]
        for name in ("xlim", "ylim") if kinds else ():  # relative deviations of all kinds compare
            limits = np.array([getattr(axes, f"get_{name}")() for axes in panels])
            for axes in panels:
                getattr(axes, f"set_{name}")(limits[:, 0].min(), limits[:, 1].max())
        for axes in grid[:, 1:].flat:
            axes.set_ylabel("")
        for i, run in enumerate(result):
            if not run.drift:  # nothing to draw, but the legend says what became of it
                grid[0, 0].plot([], [], label=run.title, **line_style(i, 0, len(result)))
        shared_legend(figure, grid)
    return figure


def draw_quantity(result: SeveralRuns, name: str, axes: Axes) -> None:
    """Draw one quantity in its own units, a line a method."""
    if len(result) > 1 and kind_of(name) == "measure":
        draw_kind(result, "measure", [name], axes)
        return
    order = {run.title: i for i, run in enumerate(result)}
    runs = [(run.title, run.drift[name]) for run in result if name in run.drift]
    if len(result) == 1:
        runs, order = [("_", drift) for _, drift in runs], {"_": 0}
    draw_sizes(axes, name, runs, result.time, order)


def draw_kind(result: SeveralRuns, kind: str, names: Sequence[str], axes: Axes) -> None:
    """Draw the quantities of one kind, a line a method."""
    order = {run.title: i for i, run in enumerate(result)}  # one style a method in all panels
    scales = {
        name: max(run.drift[name].scale for run in result if name in run.drift) for name in names
    }
    # The measure is the logarithm of a ratio. Its scale is the noise of its instrument, which is
    # another one for every method: each line has its own level.
    relative = kind != "measure"
    lines = [
        _worst(run, [name for name in names if name in run.drift], scales if relative else None)
        for run in result
        if any(name in run.drift for name in names)
    ]
    words = "" if names == [KINDS[kind].one] else ", ".join(names)
    draw_lines(
        axes,
        KINDS[kind].title,
        [thinned(line) for line in lines],
        ROUNDOFF if relative else None,
        result.time,
        relative=relative,
        order=order,
        subtitle=words or (" " if relative else "not scaled; dashes at the right: noise of each"),
    )


def _worst(run: MethodRun, names: Sequence[str], scales: Mapping[str, float] | None) -> Line:
    """Return the largest deviation of quantities that were watched at the same times.

    Each is relative to its scale; without scales, it is the one quantity as it is.
    """
    first = run.drift[names[0]]
    if scales is None:
        return Line(run.title, first.windows.times, first.windows.maxima, ROUNDOFF * first.scale)
    sizes = [run.drift[name].windows.maxima / scales[name] for name in names]
    return Line(run.title, first.windows.times, np.max(sizes, axis=0))


def swatch(i: int) -> Figure:
    """Return the sample of the i-th method's line that legends of pages show."""
    with new_figure(0.5, 0.16) as figure:
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_xlim(0.0, 2.0)
        axes.plot([0.0, 1.0, 2.0], [0.0, 0.0, 0.0], markevery=[1], markersize=4.5, linewidth=1.4,
                  **series_style(i))  # fmt: skip
    return figure
