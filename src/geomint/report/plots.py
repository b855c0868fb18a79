"""Plots of drifts: how large the deviations get, window by window, and to which side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..drift import ROUNDOFF, Drift
from .style import WIDTH, figure_style, series_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["drift_figure", "panel_figure"]

Runs = Sequence[tuple[str, Mapping[str, Drift]]]
_TIMES = {"t": "t", "tau": "τ"}
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LARGEST = 1e200  # what matplotlib still puts on a logarithmic axis
_MARKED = 40  # series of fewer windows than this show their points


def drift_figure(runs: Runs, time_label: str) -> Figure:
    """Return a figure of the drifts of one or several runs, for print 6.5 inches wide.

    Parameters
    ----------
    runs : sequence of (label, mapping of name to Drift)
    time_label : str
        The time that the drifts are measured in: ``"t"`` or ``"tau"``.

    Notes
    -----
    One run: for each quantity the largest deviation of each window, and the mean of each window
    with its sign. Several runs: the largest deviations of all of them together.
    """
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(name for _, drifts in runs for name in drifts))
    order = {label: i for i, (label, _) in enumerate(runs)}  # one style a run in all panels
    single = len(runs) == 1
    rows = max(1, len(names) if single else -(-len(names) // 2))
    columns = 2 if single or len(names) > 1 else 1
    with figure_style():
        figure = Figure(figsize=(WIDTH, 0.6 + 1.55 * rows), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False)
        if not names:
            grid[0, 0].set_axis_off()
            _say(grid[0, 0], "no quantity was watched")
        for i, name in enumerate(names):
            chosen = [
                ("_" if single else label, drifts[name])  # no legend for a single run
                for label, drifts in runs
                if name in drifts
            ]
            if single:
                draw_sizes(grid[i, 0], name, chosen, time_label)
                draw_means(grid[i, 1], name, chosen, time_label)
            else:
                draw_sizes(grid[i // 2, i % 2], name, chosen, time_label, order)
        used = len(names) * (2 if single else 1)
        for axes in grid.flat[max(used, 1) :]:
            axes.remove()
        for axes in grid.flat[: max(used - 2, 0)]:
            axes.set_xlabel("")  # told by the lowest panel of each column
        if not single:
            _shared_legend(figure, grid)
    return figure


def panel_figure(kind: str, name: str, drift: Drift, time_label: str) -> Figure:
    """Return one panel, ``"sizes"`` or ``"means"``, small enough for a telephone."""
    from matplotlib.figure import Figure

    with figure_style():
        figure = Figure(figsize=(3.6, 2.3), layout="constrained")
        draw = draw_sizes if kind == "sizes" else draw_means
        draw(figure.subplots(), name, [("_", drift)], time_label)
    return figure


def draw_sizes(
    axes: Axes,
    name: str,
    runs: Sequence[tuple[str, Drift]],
    time_label: str,
    order: Mapping[str, int] | None = None,
) -> None:
    """Draw the largest deviation of each window over time, both logarithmic.

    `order` gives the number of each run's style; by default they are counted here.
    """
    axes.set_xlabel(_time(time_label))
    axes.set_ylabel("largest |v − v₀|")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_autoscale_on(False)  # the limits below are drawn from the data
    level = ROUNDOFF * max(drift.scale for _, drift in runs)
    axes.axhline(level, color="0.45", linewidth=0.9, linestyle=(0, (4, 2)), zorder=1)
    heights, reached = [level], []
    notes: dict[str, list[str]] = {}
    for i, (label, drift) in enumerate(runs):
        times, sizes = np.abs(drift.windows.times), drift.windows.maxima
        shown = (sizes > 0.0) & (sizes < _LARGEST)
        axes.plot(
            times,
            np.where(shown, sizes, np.nan),
            label=label,
            **_style(i if order is None else order[label], len(times), len(runs)),
        )
        heights += [float(size) for size in sizes[shown]]
        reached += [float(time) for time in times if time > 0.0]
        for note in _unseen(sizes):
            notes.setdefault(note, []).append(label)
    axes.set_ylim(min(min(heights) / 3.0, max(heights) / 30.0), max(heights) * 3.0)
    if reached:
        axes.set_xlim(min(reached) / 1.5, max(reached) * 1.2)
    _log_ticks(axes)
    _label_level(axes, level)
    told = [
        note if labels == ["_"] else f"{', '.join(labels)}: {note}"
        for note, labels in notes.items()
    ]
    axes.set_title(name, loc="left", fontweight="bold", pad=6.0 + 10.5 * len(told))
    _note(axes, "\n".join(told))


def draw_means(axes: Axes, name: str, runs: Sequence[tuple[str, Drift]], time_label: str) -> None:
    """Draw the mean deviation of each window with its sign, and the line of a clear trend."""
    axes.set_title(name, loc="right", fontweight="bold")
    axes.set_xlabel(_time(time_label))
    axes.set_ylabel("mean v − v₀")
    axes.axhline(0.0, color="0.45", linewidth=0.7, zorder=1)
    for i, (label, drift) in enumerate(runs):
        times, means = drift.windows.times, drift.windows.means
        shown = np.isfinite(means)
        if not len(means):
            _say(axes, "the run is shorter than a window")
            continue
        if not means.any():
            _say(axes, "exactly 0 throughout")
            axes.set_ylim(-ROUNDOFF * drift.scale, ROUNDOFF * drift.scale)
        axes.plot(times[shown], means[shown], label=label, **_style(i, len(times), len(runs)))
        if drift.kind == "linear" and _clear(drift):
            trend = means[shown].mean() + (drift.slope or 0.0) * (times - times[shown].mean())
            axes.plot(times, trend, color="#D55E00", linestyle=(0, (4, 2)), label="trend")
            axes.legend(loc="best")
    axes.ticklabel_format(axis="y", style="sci", scilimits=(-3, 4))
    axes.ticklabel_format(axis="x", style="sci", scilimits=(-3, 6))
    axes.locator_params(axis="x", nbins=5)


def _clear(drift: Drift) -> bool:
    """Tell whether the means have a slope that shows: the growth may be in the amplitude alone."""
    if drift.slope is None or drift.slope_stderr is None:
        return False
    return abs(drift.slope) > 3.0 * drift.slope_stderr


def _style(i: int, windows: int, runs: int) -> dict[str, Any]:
    style = {**series_style(i), "markersize": 3.5}
    if windows >= _MARKED:
        # Some markers along a long line tell runs apart without colour.
        style["markevery"] = sorted({int(n) for n in np.geomspace(1, windows - 1, 8)})
        if runs == 1:
            style["marker"] = ""
    return style


def _unseen(sizes: np.ndarray[Any, np.dtype[np.float64]]) -> list[str]:
    """Say in words what a logarithmic axis cannot show."""
    if not len(sizes):
        return ["the run is shorter than a window"]
    zeros, wild = int((sizes == 0.0).sum()), int((~(sizes < _LARGEST)).sum())
    if zeros == len(sizes):
        return ["exactly 0 throughout"]
    told = [f"exactly 0 in {zeros} of {len(sizes)} windows"] if zeros else []
    return told + ([f"above 1e200 or not finite in {wild} of {len(sizes)} windows"] if wild else [])


def _note(axes: Axes, text: str) -> None:
    """Write below the title, above the axes."""
    axes.annotate(
        text,
        (0.0, 1.0),
        xycoords="axes fraction",
        xytext=(0, 3),
        textcoords="offset points",
        fontsize=8,
        va="bottom",
    )


def _say(axes: Axes, text: str) -> None:
    axes.text(0.5, 0.6, text, transform=axes.transAxes, fontsize=8.5, ha="center", va="center")


def _label_level(axes: Axes, level: float) -> None:
    axes.annotate(
        "32 ε × scale",
        (1.0, level),
        xycoords=("axes fraction", "data"),
        xytext=(-2, 2),
        textcoords="offset points",
        ha="right",
        fontsize=8,
        color="0.3",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5},
    )


def _log_ticks(axes: Axes) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(numticks=6))
        axis.set_major_formatter(FuncFormatter(_power_of_ten))  # half the time of matplotlib's own
        axis.set_minor_locator(NullLocator())


def _power_of_ten(value: float, position: int | None = None) -> str:
    return f"10{str(round(np.log10(value))).translate(_RAISED)}" if value > 0.0 else ""


def _time(label: str) -> str:
    return f"{_TIMES.get(label, label)} (dimensionless)"


def _shared_legend(figure: Figure, grid: Any) -> None:
    found: dict[str, Any] = {}
    for axes in grid.flat:
        handles, labels = axes.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            found.setdefault(label, handle)
    if found:
        figure.legend(
            list(found.values()), list(found), loc="outside upper center", ncols=min(len(found), 5)
        )
