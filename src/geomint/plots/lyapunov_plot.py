"""Pictures of exponents: how they converge, and how two directions align."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import Array
from .canvas import new_figure
from .style import COLOURS, WIDTH

if TYPE_CHECKING:
    from matplotlib.figure import Figure


REFERENCE = "#666666"


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
