"""Plots of drifts: how large the deviations get, window by window, and to which side."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..watch.drift import ROUNDOFF, Drift
from .canvas import new_figure
from .panels import Line, draw_lines, line_style, say, shared_legend, thinned, time_name
from .style import WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HUGE = 1e307  # differences of larger numbers overflow

Runs = Sequence[tuple[str, Mapping[str, Drift]]]
Draw: TypeAlias = "Callable[[Axes], None]"


def drift_figure(
    runs: Runs, time: str, status: str = "success", unit: Callable[[str], str] = lambda name: ""
) -> Figure:
    """Return a figure of the drifts of one or several runs, for print 6.5 inches wide.

    Parameters
    ----------
    runs : sequence of (label, mapping of name to Drift)
    time : str
        The time that the drifts are measured in: ``"t"`` or ``"tau"``.
    status : str
        Of the run, written above the panels if it is not ``"success"``.
    unit : callable
        Returns that of a quantity.

    Notes
    -----
    One run: for each quantity the largest deviation of each window, and the mean of each window
    with its sign. Several runs: the largest deviations of all of them together.
    """
    names = list(dict.fromkeys(name for _, drifts in runs for name in drifts))
    draws = []
    for name in names:
        given: dict[str, Any] = {"name": name, "time": time, "unit": unit(name)}
        if len(runs) == 1:
            drift = runs[0][1][name]  # no legend for a single run
            draws.append(partial(draw_sizes, runs=[(0, "_", drift)], **given))
            draws.append(partial(draw_means, drift=drift, **given))
        else:
            chosen = [(i, label, d[name]) for i, (label, d) in enumerate(runs) if name in d]
            draws.append(partial(draw_sizes, runs=chosen, **given))
    with grid_figure(draws, 1.55) as (figure, grid):
        if status != "success":
            figure.suptitle(f"run {status}", color="#b00020", weight="bold")
        if len(runs) > 1:
            shared_legend(figure, grid)
    return figure


@contextmanager
def grid_figure(draws: Sequence[Draw], height: float) -> Iterator[tuple[Figure, Any]]:
    """Give a figure of panels in two columns, for print 6.5 inches wide, and their grid."""
    rows = max(1, -(-len(draws) // 2))
    with new_figure(WIDTH, 0.6 + height * rows, layout="constrained") as figure:
        grid = figure.subplots(rows, min(max(len(draws), 1), 2), squeeze=False)
        for axes, draw in zip(grid.flat, draws, strict=False):
            draw(axes)
        for axes in grid.flat[max(len(draws), 1) :]:
            axes.remove()
        for axes in grid.flat[: max(len(draws) - 2, 0)]:
            axes.set_xlabel("")  # the lowest panel of each column has it
        if not draws:
            grid[0, 0].set_axis_off()
            say(grid[0, 0], "no quantity was watched")
        yield figure, grid


# Margins that hold all labels: finding them anew would draw each of a dozen panels twice.
_PANEL = {"left": 0.2, "right": 0.96, "bottom": 0.2, "top": 0.86}


def panel_figure(draw: Draw, roomy: bool = False, square: bool = False) -> Figure:
    """Return one panel, small enough for a telephone.

    `roomy`: with room for words below its title; `square`: as high as wide without its labels.
    """
    height = 3.0 if square else 2.6 if roomy else 2.3
    with new_figure(3.6, height, layout="constrained" if roomy else None) as figure:
        if not roomy:
            figure.subplots_adjust(**_PANEL)
        draw(figure.subplots())
    return figure


def draw_sizes(
    axes: Axes, name: str, runs: Sequence[tuple[int, str, Drift]], time: str, unit: str = ""
) -> None:
    """Draw the largest deviation of each window over time, both logarithmic.

    A run is the number of its style, its label, and the drift.
    """
    level = ROUNDOFF * max(drift.scale for _, _, drift in runs)
    lines = [Line(label, d.windows.times, d.windows.maxima, i) for i, label, d in runs]
    if len(lines) > 1:
        lines = [thinned(line) for line in lines]
    draw_lines(axes, name, lines, level, time, label=runs[0][2].label, unit=unit)


def draw_means(axes: Axes, name: str, drift: Drift, time: str, unit: str = "") -> None:
    """Draw the mean deviation of each window with its sign, and the line of a clear trend."""
    axes.set_title(name, loc="right", fontweight="bold")
    axes.set(xlabel=time_name(time), ylabel=f"mean {drift.label}{f' ({unit})' if unit else ''}")
    axes.axhline(0.0, color="0.45", linewidth=0.7, zorder=1)
    times, means = drift.windows.times, drift.windows.means
    shown = np.abs(means) < HUGE
    if not len(means):
        say(axes, "the run is shorter than a window")
    elif not means.any():
        say(axes, "exactly 0 throughout")
        axes.set_ylim(-ROUNDOFF * drift.scale, ROUNDOFF * drift.scale)
    axes.plot(times[shown], means[shown], label="_", **line_style(0, len(times), 1))
    slope, error = drift.slope or 0.0, drift.slope_stderr
    # The growth may be in the amplitude alone.
    if drift.drift_class == "linear" and error is not None and abs(slope) > 3.0 * error:
        trend = means[shown].mean() + slope * (times - times[shown].mean())
        axes.plot(times, trend, color="#D55E00", linestyle=(0, (4, 2)), label="trend")
        axes.legend(loc="best")
    for when, what in ((drift.jump_time, "jump"), (drift.not_finite_from, "not finite")):
        if when is not None and drift.drift_class == what:
            axes.axvline(when, color="#D55E00", linestyle=(0, (1, 1.5)), label=what)
            axes.legend(loc="best")
    axes.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4))
    axes.ticklabel_format(axis="x", style="sci", scilimits=(-3, 6))
    axes.locator_params(axis="x", nbins=5)
