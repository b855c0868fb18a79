"""Plots of a report: each quantity of one run, several runs by kind of quantity."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..plan import SeveralRuns
from ..plots.canvas import new_figure
from ..plots.drift_plots import draw_means, draw_sizes, grid_figure
from ..plots.panels import Line, draw_lines, line_style, shared_legend, thinned
from ..plots.style import series_style
from ..watch.drift import ROUNDOFF
from ..watch.kinds import KINDS
from .kinds import by_roundoff, conserved_by_kind
from .motion_panels import motion_draws
from .text import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "draw_kind",
    "draw_means_of",
    "draw_own_kind",
    "draw_quantity",
    "kinds_figure",
    "report_figure",
    "swatch",
    "worst",
]


def report_figure(result: SeveralRuns) -> Figure:
    """Return the picture of a report.

    Of one method the first turns of the motion, and the kinds of quantities beyond round-off, with
    the mean of the one that is lost most; of several methods each kind.
    """
    if len(result) > 1:
        return kinds_figure(result)
    shown, folded = by_roundoff(result)
    draws = [each.draw for each in motion_draws(result)]
    draws = draws[: len(draws) // 2 * 2]  # in pairs
    for kind, names in shown.items():
        draws.append(partial(draw_own_kind, result, kind, names))
        draws.append(partial(draw_means_of, result, worst(result, names)))
    with grid_figure(draws, 1.9) as (figure, _):
        if result.status != "success":
            figure.suptitle(f"run {result.status}", color="#b00020", weight="bold")
        if folded:
            drift = result[0].drift
            words = [f"{n} {number(drift[n].max_abs_error)}" for ns in folded.values() for n in ns]
            told = textwrap.fill(f"No larger than round-off: {', '.join(words)}", 100)
            figure.supxlabel(told, fontsize=8)
    return figure


def draw_means_of(result: SeveralRuns, name: str, axes: Axes) -> None:
    """Draw the means of a quantity of one run."""
    draw_means(axes, name, result[0].drift[name], result.time_label, result.unit(name))


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


def worst(result: SeveralRuns, names: Sequence[str]) -> str:
    """Return the quantity of one run that is lost most, measured by its scale."""
    drift = result[0].drift
    return max(names, key=lambda name: drift[name].max_abs_error / (drift[name].scale or 1.0))


def draw_own_kind(result: SeveralRuns, kind: str, names: Sequence[str], axes: Axes) -> None:
    """Draw the quantities of one kind of one run, a line each, relative to their scales.

    One quantity alone is in its own units.
    """
    if len(names) == 1:
        draw_quantity(result, names[0], axes)
        return
    drift = result[0].drift
    lines = [
        thinned(Line(name, d.windows.times, d.windows.maxima / (d.scale or 1.0), i))
        for i, (name, d) in enumerate((name, drift[name]) for name in names)
    ]
    title = KINDS[kind].title
    draw_lines(axes, title, lines, ROUNDOFF, result.time_label, relative=True)
    axes.legend(loc="lower left", ncols=2 if len(lines) > 3 else 1, fontsize=7)


def draw_quantity(result: SeveralRuns, name: str, axes: Axes) -> None:
    """Draw one quantity in its own units, a line a method."""
    drift = next(run.drift[name] for run in result if name in run.drift)
    if len(result) > 1 and drift.own_noise:
        draw_kind(result, drift.kind, [name], axes)
        return
    label = "_" if len(result) == 1 else None
    runs = [
        (i, label or run.title, run.drift[name])
        for i, run in enumerate(result)
        if name in run.drift
    ]
    draw_sizes(axes, name, runs, result.time_label, result.unit(name))


def draw_kind(result: SeveralRuns, kind: str, names: Sequence[str], axes: Axes) -> None:
    """Draw the quantities of one kind, a line a method: the largest deviation, relative to its scale.

    Where the scale is the noise of an instrument, it is another one for every method: each line has
    its own level, and is as it is.
    """
    relative = len(names) > 1 or not any(
        run.drift[name].own_noise for name in names for run in result if name in run.drift
    )
    scales = {n: max(run.drift[n].scale for run in result if n in run.drift) for n in names}
    lines = []
    for i, run in enumerate(result):
        drifts = {name: run.drift[name] for name in names if name in run.drift}
        if drifts:  # watched at the same times
            first = next(iter(drifts.values()))
            level = None if relative else ROUNDOFF * first.scale
            sizes = [d.windows.maxima / (scales[n] if relative else 1.0) for n, d in drifts.items()]
            line = Line(run.title, first.windows.times, np.max(sizes, axis=0), i, level)
            lines.append(thinned(line))
    words = "" if names == [KINDS[kind].one] else ", ".join(names)
    draw_lines(
        axes,
        KINDS[kind].title,
        lines,
        ROUNDOFF if relative else None,
        result.time_label,
        relative=relative,
        subtitle=words or (" " if relative else "not scaled; dashes at the right: noise of each"),
    )


def swatch(i: int) -> Figure:
    """Return the sample of the i-th method's line that legends of pages show."""
    with new_figure(0.5, 0.16) as figure:
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_axis_off()
        axes.set_xlim(0.0, 2.0)
        axes.plot([0.0, 1.0, 2.0], [0.0, 0.0, 0.0], markevery=[1], markersize=4.5, linewidth=1.4,
                  **series_style(i))  # fmt: skip
    return figure
