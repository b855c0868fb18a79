"""Plots of comparisons: run time against error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..plots.canvas import new_figure
from ..plots.style import WIDTH, series_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..compare.point import Point

__all__ = ["work_precision_figure"]


def work_precision_figure(points: Sequence[Point]) -> Figure:
    """Return a figure of run time against error, a line a method, both logarithmic.

    Points that failed have no place in it; the page lists them. Those that the reference cannot
    judge are hollow, at what their error is at most. Lines of peers are thin.
    An error of exactly 0 is drawn at 1e-17, below what float64 resolves.
    """
    with new_figure(WIDTH, 4.2, layout="constrained") as figure:
        axes = figure.subplots()
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("error at the end, relative (dimensionless)")
        axes.set_ylabel("run time (s), without compilation")
        names = {point.method: point.peer is not None for point in points}
        for i, (name, peer) in enumerate(names.items()):
            own = [
                (max(point.bound, 1e-17), point.seconds, point.error is None)
                for point in points
                if point.method == name and point.bound is not None and point.seconds is not None
            ]
            if own:
                errors, seconds, _ = zip(*own, strict=True)
                style = series_style(i) | ({"linewidth": 0.6, "alpha": 0.75} if peer else {})
                label = f"{name} (peer)" if peer else name
                axes.plot(errors, seconds, label=label, markersize=4.5, **style)
                at_most = [point for point in own if point[2]]
                if at_most:
                    errors, seconds, _ = zip(*at_most, strict=True)
                    style.update(linestyle="none", markerfacecolor="white")
                    axes.plot(errors, seconds, markersize=4.5, **style)
        if axes.get_legend_handles_labels()[0]:
            columns = min(len(names), 4 if any(names.values()) else 5)
            figure.legend(loc="outside upper center", ncols=columns)
        else:
            axes.text(0.5, 0.5, "no method reached the end", transform=axes.transAxes, ha="center")
    return figure
