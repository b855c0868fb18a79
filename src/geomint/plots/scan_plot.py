"""Pictures of scans: what was read off members, over one number, over two, or how it is distributed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array
from .canvas import new_figure
from .panels import say
from .style import COLOURS, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST_PANELS = 8
WIDE = 100.0  # times: what spreads further is drawn on a logarithmic axis
FEW = 40  # points that have marks
NONE = "#bbbbbb"  # cells of a map without a value
BAND = (0.05, 0.25, 0.75, 0.95)  # quantiles of draws


@dataclass(frozen=True)
class Chart:
    """What a picture shows: readings of members, whose numbers vary in a grid.

    Attributes
    ----------
    keys : sequence of str
        The numbers that vary, none, one or two.
    values : sequence of array
        Their values; members are all combinations, the last changing fastest, and of each its draws.
    readings : mapping of str to array, shape (members,)
    time : str
        ``"t"`` or ``"tau"``: of frequencies and exponents.
    bars : mapping of str to array, shape (members,)
        Standard errors of readings that have some.
    """

    keys: Sequence[str]
    values: Sequence[Array]
    readings: Mapping[str, Array]
    time: str = "t"
    bars: Mapping[str, Array] = field(default_factory=dict)

    @property
    def drawn(self) -> list[str]:
        """The readings that there is room for."""
        return list(self.readings)[:MOST_PANELS]

    def grid(self, name: str) -> Array:
        """Return a reading with an axis for each number that varies, and one of draws."""
        sizes = [len(values) for values in self.values]
        return self.readings[name].reshape(*sizes, -1)

    def unit(self, name: str) -> str:
        """Return the unit of frequencies and exponents; others have that of the scene."""
        per = f"per unit of {'τ' if self.time == 'tau' else 't'}"
        if name.startswith("exponent"):
            return per
        return f"radians {per}" if name.startswith("frequency:") else ""


def scan_figure(chart: Chart) -> Figure:
    """Return a figure with a panel for every reading, for print 6.5 inches wide.

    Over one number: the reading, with one standard error where it has one; of draws the median and
    where 50 and 90 of 100 are. Over two: a map of it, of draws of the median. Over none: which part of
    the members has at most so much.
    """
    names, maps = chart.drawn, len(chart.keys) == 2
    columns = 2 if maps and len(names) > 1 else 1
    rows = -(-len(names) // columns)
    height = (0.42 if columns == 2 else 0.6 if maps else 0.36) * WIDTH * rows
    with new_figure(WIDTH, height, layout="constrained") as figure:
        panels = figure.subplots(rows, columns, squeeze=False, sharex=len(chart.keys) == 1)
        for panel, name in zip(panels.flat, names, strict=False):
            draw = (_distribution, _curve, _map)[len(chart.keys)]
            draw(panel, chart, name)
            panel.set_title(name, loc="left")
        for panel in list(panels.flat)[len(names) :]:
            panel.remove()
        return figure


def _distribution(panel: Axes, chart: Chart, name: str) -> None:
    known = np.sort(chart.readings[name][np.isfinite(chart.readings[name])])
    panel.set(xlabel=chart.unit(name), ylabel="part of the members", ylim=(0, 1))
    if not len(known):
        say(panel, "no member has a value")
        return
    panel.step(known, np.arange(1, len(known) + 1) / len(known), where="post", color=COLOURS[0])
    if _wide(known):
        panel.set_xscale("log")


def _curve(panel: Axes, chart: Chart, name: str) -> None:
    x, y = chart.values[0], chart.grid(name)
    panel.set_ylabel(chart.unit(name))
    if panel.get_subplotspec().is_last_row():  # type: ignore[union-attr]
        panel.set_xlabel(chart.keys[0])
    if not np.isfinite(y).any():
        say(panel, "no member has a value")
        return
    marker = "o" if len(x) <= FEW else ""
    style: dict[str, Any] = {"color": COLOURS[0], "marker": marker, "markersize": 3.0}
    if y.shape[1] == 1 and name in chart.bars:
        panel.errorbar(x, y[:, 0], yerr=chart.bars[name], elinewidth=0.8, capsize=1.5, **style)
    elif y.shape[1] == 1:
        panel.plot(x, y[:, 0], **style)
    else:
        low, inner, outer, high = _quantiles(y, BAND)
        panel.fill_between(x, low, high, color=COLOURS[0], alpha=0.15, linewidth=0, label="90 %")
        panel.fill_between(x, inner, outer, color=COLOURS[0], alpha=0.3, linewidth=0, label="50 %")
        panel.plot(x, _quantiles(y, (0.5,))[0], label=f"median of {y.shape[1]}", **style)
        if name == chart.drawn[0]:
            panel.legend(ncols=3)
    if _wide(y[np.isfinite(y)]):
        panel.set_yscale("log")
    if _wide(x) and np.allclose(np.diff(np.log(x)), np.log(x[1] / x[0])):
        panel.set_xscale("log")


def _map(panel: Axes, chart: Chart, name: str) -> None:
    from matplotlib.colors import LogNorm

    x, y = chart.values[1], chart.values[0]
    z = _quantiles(chart.grid(name), (0.5,))[0]
    panel.set(xlabel=chart.keys[1], ylabel=chart.keys[0], facecolor=NONE)
    panel.grid(False)
    if not np.isfinite(z).any():
        say(panel, "no member has a value")
        return
    order = np.argsort(y), np.argsort(x)
    z = z[order[0]][:, order[1]]
    norm = LogNorm() if _wide(z[np.isfinite(z)]) else None
    edges = _edges(x[order[1]]), _edges(y[order[0]])
    shown = panel.pcolormesh(*edges, z, cmap="viridis", norm=norm, rasterized=True)
    panel.figure.colorbar(shown, ax=panel, label=chart.unit(name))


def _quantiles(values: Array, parts: Sequence[float]) -> Array:
    """Return quantiles over the draws, without those that have no value; NaN where none has."""
    known = np.isfinite(values).any(axis=-1)
    found = np.full((len(parts), *known.shape), np.nan)
    whole = np.where(np.isfinite(values), values, np.nan)
    found[:, known] = np.nanquantile(whole[known], parts, axis=-1)
    return found


def _edges(centres: Array) -> Array:
    """Return the edges of cells around values: half way between them, geometrically if they are so."""
    if len(centres) == 1:
        return centres[0] + np.array([-0.5, 0.5])
    geometric = _wide(centres) and np.allclose(
        np.diff(np.log(centres)), np.log(centres[1] / centres[0])
    )
    at = np.log(centres) if geometric else centres
    middle = 0.5 * (at[1:] + at[:-1])
    edges = np.concatenate([[2 * at[0] - middle[0]], middle, [2 * at[-1] - middle[-1]]])
    return np.exp(edges) if geometric else edges


def _wide(values: Array) -> bool:
    """Tell whether numbers are above 0 and spread so far that only a logarithmic axis shows them."""
    return bool(len(values) and values.min() > 0.0 and values.max() > WIDE * values.min())
