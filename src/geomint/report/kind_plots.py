"""Plots of several runs by kind of quantity: energy, other integrals, constraints, measure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..plan.several import MethodRun, SeveralRuns
from ..plots.drift_plots import draw_sizes
from ..plots.panels import Line, draw_lines, line_style, say, shared_legend, thinned
from ..plots.style import WIDTH, new_figure, series_style
from ..watch.drift import ROUNDOFF
from ..watch.quantities import KINDS
from .kinds import conserved_by_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["kind_figure", "kinds_figure", "quantity_figure", "swatch"]


def kinds_figure(result: SeveralRuns) -> Figure:
    """Return a figure with a panel for each kind, a line a method, for print 6.5 inches wide.

    A line shows the largest deviation of the quantities of its kind, each relative to its scale,
    so that one level of round-off holds for all of them.
    """
    kinds = conserved_by_kind(result)
    rows = max(1, -(-len(kinds) // 2))
    columns = 2 if len(kinds) > 1 else 1
    with new_figure(WIDTH, 0.6 + 2.2 * rows, layout="constrained") as figure:
        grid = figure.subplots(rows, columns, squeeze=False)
        for axes, kind in zip(grid.flat, kinds, strict=False):
            draw_kind(axes, result, kind, kinds[kind])
        _share_limits(grid.flat[: len(kinds)])
        for axes in grid.flat[len(kinds) :]:
            axes.set_axis_off()
        for axes in grid.flat[: max(len(kinds) - 2, 0)]:
            axes.set_xlabel("")  # the lowest panel of each column has it
        for axes in grid[:, 1:].flat:
            axes.set_ylabel("")
        for i, run in enumerate(result):
            if not run.drift:  # nothing to draw, but the legend says what became of it
                grid[0, 0].plot([], [], label=run.title, **line_style(i, 0, len(result.runs)))
        shared_legend(figure, grid)
        if not kinds:
            grid[0, 0].set_axis_off()
            say(grid[0, 0], "no quantity was watched")
    return figure


def _share_limits(panels: Iterable[Axes]) -> None:
    """Give all panels the same axes: relative deviations of all kinds compare."""
    panels = list(panels)
    for name in ("xlim", "ylim"):
        limits = [getattr(axes, f"get_{name}")() for axes in panels]
        if limits:
            lower, upper = zip(*limits, strict=True)
            for axes in panels:
                getattr(axes, f"set_{name}")(min(lower), max(upper))


def kind_figure(result: SeveralRuns, kind: str, names: Sequence[str]) -> Figure:
    """Return one panel, small enough for a telephone."""
    with new_figure(3.6, 2.6, layout="constrained") as figure:
        draw_kind(figure.subplots(), result, kind, names)
    return figure


def quantity_figure(result: SeveralRuns, name: str) -> Figure:
    """Return the panel of one quantity, in its own units."""
    order = {run.title: i for i, run in enumerate(result)}
    runs = [(run.title, run.drift[name]) for run in result if name in run.drift]
    with new_figure(3.6, 2.6, layout="constrained") as figure:
        if runs[0][1].own_noise:
            draw_kind(figure.subplots(), result, runs[0][1].kind, [name])
        else:
            draw_sizes(figure.subplots(), name, runs, result.time, order)
    return figure


def draw_kind(axes: Axes, result: SeveralRuns, kind: str, names: Sequence[str]) -> None:
    """Draw the quantities of one kind, a line a method."""
    order = {run.title: i for i, run in enumerate(result)}  # one style a method in all panels
    scales = {
        name: max(run.drift[name].scale for run in result if name in run.drift) for name in names
    }
    # Where the scale is the noise of an instrument it is another one for every method, and each line
    # has its own level.
    own = len(names) == 1 and any(
        run.drift[names[0]].own_noise for run in result if names[0] in run.drift
    )
    relative = not own
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
