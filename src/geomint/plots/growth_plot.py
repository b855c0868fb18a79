"""Growth over time: rms and quantiles over the members of an ensemble, and exponents of one motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array
from .canvas import new_figure
from .panels import say, time_name
from .style import COLOURS, WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PALE = (0.12, 0.22)  # how dark bands are, from the widest in
REFERENCE = "#666666"


def growth_figure(
    name: str,
    time: str,
    t: Array,
    rms: Array,
    bands: Sequence[tuple[float, Array]],
    fit: tuple[float, float, float],
) -> Figure:
    """Return a figure of the rms of a deviation over members, between bands of quantiles.

    Parameters
    ----------
    bands : sequence of (level, array)
        Rising, with the median in the middle: the outer ones are bands.
    fit : tuple of float
        Exponent, its standard error, and the rms at the end; NaN for none.
    """
    with new_figure(WIDTH, 0.42 * WIDTH, layout="constrained") as figure:
        axes = figure.subplots()
        axes.set_title(name, loc="left", fontweight="bold")
        axes.set(xlabel=time_name(time), ylabel="rms deviation")
        if not rms.any():
            say(axes, "exactly 0 throughout")
            return figure
        for i, dark in zip(range(len(bands) // 2), PALE, strict=False):
            (low, below), (high, above) = bands[i], bands[-1 - i]
            label = f"{low:.0%} to {high:.0%} of the members"
            axes.fill_between(
                t, _shown(below), _shown(above), color=COLOURS[0], alpha=dark, lw=0, label=label
            )
        axes.plot(t, _shown(bands[len(bands) // 2][1]), color=COLOURS[0], lw=0.8, label="median")
        axes.plot(t, _shown(rms), "o", color=COLOURS[1], markersize=3, label="rms over members")
        exponent, error, size = fit
        if np.isfinite(exponent):
            ends = t[[0, -1]]
            label = f"t^b, b = {exponent:.2f} ± {error:.2g}"
            axes.plot(
                ends, size * (ends / ends[-1]) ** exponent, "--", color=REFERENCE, label=label
            )
        axes.set(xscale="log", yscale="log")
        figure.legend(loc="outside right upper")
        return figure


def _shown(values: Array) -> Array:
    """Return values for a logarithmic axis."""
    return np.where(values > 0.0, values, np.nan)


def lyapunov_figure(t: Array, running: Array, sali: Array | None) -> Figure:
    """Return a figure of |λ_k| over time beside ln t / t, and below it of the alignment index."""
    panels = 1 if sali is None else 2
    with new_figure(WIDTH, 0.42 * WIDTH * panels, layout="constrained") as figure:
        rows = np.atleast_1d(figure.subplots(panels, sharex=True))
        first = rows[0]
        marker = "." if len(t) == 1 else ""  # no line leads to a single sample
        for k in range(running.shape[1]):
            style = "-" if k < (running.shape[1] + 1) // 2 else "--"
            colour = COLOURS[k % len(COLOURS)]
            label = f"$|\\lambda_{{{k + 1}}}|$"
            first.plot(t, np.abs(running[:, k]), style, marker=marker, color=colour, label=label)
        late = t > math.e
        first.plot(t[late], np.log(t[late]) / t[late], ":", color=REFERENCE, label="ln t / t")
        first.set(ylabel="exponents, per unit of time")
        if len(t):  # logarithmic axes want something above 0
            first.set(xscale="log", yscale="log" if running.any() else "linear")
        first.legend(ncols=3)
        if sali is not None:
            rows[1].plot(t, np.maximum(sali, 1e-300), marker=marker, color=COLOURS[0])
            rows[1].set(yscale="log" if len(t) else "linear", ylabel="alignment index")
            rows[1].set_ylim(
                max(float(sali.min(initial=2.0)) * 0.3, 1e-20), 3.0
            )  # it is at most √2
        rows[-1].set_xlabel("time since the beginning")
        return figure
