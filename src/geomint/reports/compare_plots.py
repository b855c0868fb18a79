"""Plots of comparisons: run time against error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..plots.canvas import new_figure
from ..plots.style import WIDTH, series_style
from .compare_orders import FittedOrder

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..compare.point import Point

__all__ = ["work_precision_figure"]

SLOPE = "0.35"
RING = {"linestyle": "none", "marker": "o", "markersize": 10.0, "markerfacecolor": "none"}
BELOW = 1.35  # times: how far from the line of the method


def work_precision_figure(points: Sequence[Point], orders: Mapping[str, FittedOrder]) -> Figure:
    """Return a figure of run time against error, a line a method, both logarithmic.

    Points that failed have no place in it; the page lists them. Those that the reference cannot
    judge are hollow, at what their error is at most. Lines of peers are thin. An error of exactly 0 is
    drawn at 1e-17, below what float64 resolves. Ringed: Newton's method was at work. Dotted are slopes
    of the orders, time ~ error^(−1/p), beside the asymptotic part of the first method of each.
    """
    with new_figure(WIDTH, 4.2, layout="constrained") as figure:
        axes = figure.subplots()
        axes.set(xscale="log", xlabel="error at the end, relative (dimensionless)")
        axes.set(yscale="log", ylabel="run time (s), without compilation")
        names = {point.method: point.peer is not None for point in points}
        for i, (name, peer) in enumerate(names.items()):
            own = [
                (max(point.bound, 1e-17), point.seconds, point.error is None, point.newton)
                for point in points
                if point.method == name and point.bound is not None and point.seconds is not None
            ]
            if own:
                errors, seconds, *_ = zip(*own, strict=True)
                style = series_style(i) | ({"linewidth": 0.6, "alpha": 0.75} if peer else {})
                label = f"{name} (peer)" if peer else name
                axes.plot(errors, seconds, label=label, markersize=4.5, **style)
                at_most = [point for point in own if point[2]]
                for error, time, _, newton in own:
                    if newton:
                        axes.plot(error, time, **(style | RING))
                if at_most:
                    errors, seconds, *_ = zip(*at_most, strict=True)
                    style.update(linestyle="none", markerfacecolor="white")
                    axes.plot(errors, seconds, markersize=4.5, **style)
        _draw_slopes(axes, points, orders)
        if axes.get_legend_handles_labels()[0]:
            columns = min(len(names), 4 if any(names.values()) else 5)
            figure.legend(loc="outside upper center", ncols=columns)
        else:
            axes.text(0.5, 0.5, "no method reached the end", transform=axes.transAxes, ha="center")
    return figure


def _draw_slopes(axes: Axes, points: Sequence[Point], orders: Mapping[str, FittedOrder]) -> None:
    """Draw for each order, below the first method that shows it, how time and error go together."""
    drawn = set()
    for method, found in orders.items():
        if found.fitted is None or found.order in drawn:
            continue
        drawn.add(found.order)
        own = [
            (p.error, p.seconds)
            for p in points
            if p.method == method and p.step in found.steps and p.error and p.seconds
        ]
        middle, time = np.exp(np.mean(np.log(own), axis=0))
        errors = np.array([own[0][0], own[-1][0]])
        times = time / BELOW * (middle / errors) ** (1.0 / found.order)
        axes.plot(errors, times, color=SLOPE, linewidth=0.9, linestyle=(0, (1, 1.5)), zorder=1)
        axes.annotate(
            f"order {found.order}", (errors[0], times[0]), xytext=(0, -3), ha="right", va="top",
            textcoords="offset points", fontsize=8, color=SLOPE, zorder=1,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5},
        )  # fmt: skip
