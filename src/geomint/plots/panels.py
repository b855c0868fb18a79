"""One panel of a drift figure: deviations over time, both logarithmic, a line a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import Array
from .style import series_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_TIMES = {"t": "t", "tau": "τ"}
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_SMALLEST, _LARGEST = 1e-300, 1e200  # what matplotlib puts on a logarithmic axis
_DASHED = (0, (4, 2))
_INTERVALS = 60  # points of a line that shares its panel with others
_MARKED = 40  # series of fewer windows than this show their points


class Line(NamedTuple):
    """Deviations ≥ 0 of one run over time. The label ``"_"`` is that of a run without a legend.

    `style` is the number of the run, which has one style in all panels; `level` a round-off level of
    its own, where that of the panel does not hold.
    """

    label: str
    times: Array
    sizes: Array
    style: int = 0
    level: float | None = None


def draw_lines(
    axes: Axes,
    title: str,
    lines: Sequence[Line],
    level: float | None,
    time_label: str,
    *,
    relative: bool = False,
    subtitle: str = "",
    label: str = "deviation",
    unit: str = "",
) -> None:
    """Draw lines over time, the round-off level dashed, and say what the axes cannot show.

    Parameters
    ----------
    level : float or None
        The round-off level; None if each line has its own, then a short dash at the right.
    relative : bool
        Whether the sizes are relative to scales.
    subtitle, label, unit : str
        A line below the title; what the sizes are of, and their unit.
    """
    of = " / scale" if relative else f" ({unit})" if unit else ""
    axes.set(xscale="log", xlabel=time_name(time_label))
    axes.set(yscale="log", ylabel=f"largest {label}{of}")
    axes.set_autoscale_on(False)  # the limits below are drawn from the data
    heights, reached = [] if level is None else [level], []
    notes: dict[str, list[str]] = {}
    for label, times, sizes, number, own_level in lines:
        shown = (sizes > 0.0) & (sizes < _LARGEST)
        style = line_style(number, len(times), len(lines))
        axes.plot(np.abs(times), np.where(shown, sizes, np.nan), label=label, **style)
        heights += [float(size) for size in sizes[shown]]
        if own_level is not None:
            heights.append(own_level)
            axes.axhline(own_level, 0.9, color=style["color"], linewidth=1.4, linestyle=_DASHED)
        reached += [float(abs(time)) for time in times if time != 0.0]
        for note in _unseen(sizes, gaps_are_named=len(lines) == 1):
            notes.setdefault(note, []).append(label)
    if heights:
        heights = [max(height, _SMALLEST) for height in heights]
        axes.set_ylim(min(min(heights) / 3.0, max(heights) / 30.0), max(heights) * 3.0)
    if reached:
        axes.set_xlim(min(reached) / 1.5, max(reached) * 1.2)
    _log_ticks(axes)
    if level is not None:
        axes.axhline(level, color="0.45", linewidth=0.9, linestyle=_DASHED, zorder=1)
        _label_level(axes, level, "round-off")
    words = [subtitle] if subtitle else []
    words += [
        note if labels == ["_"] else f"{', '.join(labels)}: {note}"
        for note, labels in notes.items()
    ]
    # Nothing of a logarithmic axis is in the way of a title: matplotlib need not look for it.
    pad = 6.0 + 10.5 * len(words)
    axes.set_title(title, loc="left", fontweight="bold", pad=pad, y=1.0)
    _note(axes, "\n".join(words))


def thinned(line: Line) -> Line:
    """Return a line with at most `_INTERVALS` points: the largest in equal steps of log time.

    What neighbouring windows do within a hundredth of a decade hides other lines.
    """
    times = np.abs(line.times)
    shown = times > 0.0
    times, sizes = times[shown], line.sizes[shown]
    if len(times) <= _INTERVALS:
        return line._replace(times=times, sizes=sizes)
    edges = np.geomspace(times[0], times[-1], _INTERVALS + 1)[1:-1]
    first = np.unique(np.searchsorted(times, edges, side="right"))
    starts = np.concatenate(([0], first[(first > 0) & (first < len(times))]))
    ends = np.append(starts[1:], len(times)) - 1
    return line._replace(times=times[ends], sizes=np.maximum.reduceat(sizes, starts))


def line_style(i: int, windows: int, runs: int) -> dict[str, Any]:
    """Return the style of the i-th run: some markers along a line distinguish runs without colour."""
    style = {**series_style(i), "markersize": 3.5}
    if windows >= _MARKED:
        style["markevery"] = max(1, windows // 8)
        if runs == 1:
            style["marker"] = ""
    return style


def _unseen(sizes: Array, gaps_are_named: bool) -> list[str]:
    """Say in words what a logarithmic axis cannot show."""
    if not len(sizes):
        return ["the run is shorter than a window"]
    zeros, wild = int((sizes == 0.0).sum()), int((~(sizes < _LARGEST)).sum())
    if zeros == len(sizes):
        return ["exactly 0 throughout"]
    words = [f"exactly 0 in {zeros} of {len(sizes)} windows"] if zeros and gaps_are_named else []
    return words + (
        [f"above 1e200 or not finite in {wild} of {len(sizes)} windows"] if wild else []
    )


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


def say(axes: Axes, text: str) -> None:
    """Write in the middle of an empty panel."""
    axes.text(0.5, 0.6, text, transform=axes.transAxes, fontsize=8.5, ha="center", va="center")


def _label_level(axes: Axes, level: float, text: str) -> None:
    axes.annotate(
        text,
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


def time_name(label: str) -> str:
    """Return the label of a time axis; one that is more than ``"t"`` or ``"tau"`` as it is."""
    return f"{_TIMES[label]} (dimensionless)" if label in _TIMES else label


def shared_legend(figure: Figure, grid: Any) -> None:
    """Put one legend, of all runs in any panel, above the figure."""
    found: dict[str, Any] = {}
    for axes in grid.flat:
        handles, labels = axes.get_legend_handles_labels()
        for handle, label in zip(handles, labels, strict=True):
            found.setdefault(label, handle)
    if found:
        rows = -(-len(found) // 5)
        columns = -(-len(found) // rows)
        figure.legend(list(found.values()), list(found), loc="outside upper center", ncols=columns)
