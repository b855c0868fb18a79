"""The picture: a panel for each axis, methods by values, coloured by verdict."""

from __future__ import annotations

import math
import textwrap
from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..plots.canvas import new_figure
from ..plots.style import WIDTH
from .judge import FORBIDDEN, VERDICTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


CellRecord = Mapping[str, Any]  # as in ``stress.json``
Cells = Sequence[CellRecord]
Place = tuple[str, str]  # a method, the label of a value

# Okabe and Ito's orange and black; blues for what works, as dark as the error is large.
COLOURS = dict(zip(VERDICTS[1:], ["#c9c9c9", "#e69f00", "#ffffff", *["#000000"] * 3], strict=True))
SYMBOLS = dict(zip(VERDICTS[1:], "~∘–×!∞", strict=True))
LIGHT, DARK = (0.87, 0.93, 0.97), (0.19, 0.51, 0.74)
EXPONENTS = (-16.0, -1.0)  # of the errors at the ends of the blues
ROW, HEAD = 0.082, 1.1  # inches: a method; a panel's title, its ticks and their quantity
TINY, SMALL = 5.2, 6.5  # sizes of letters
NARROWEST, WIDEST = 6.0, 29.0  # columns: as wide as a title needs; of a line that is filled
ROOM, GAP = 51.0, 1.5  # columns that a line has room for, and those between two panels


def stress_figure(
    cells: Cells,
    methods: Sequence[str],
    families: Mapping[str, str],
    axes: Sequence[Mapping[str, str]],
) -> Figure:
    """Return the figure, for print 6.5 inches wide.

    Parameters
    ----------
    cells : sequence of mappings
        As in ``stress.json``.
    methods : sequence of str
        In the order of the rows.
    families : mapping of method to family
        Families are set apart by lines.
    axes : sequence of mappings
        With ``name``, ``title`` and ``quantity``.

    Notes
    -----
    A square of one colour: the verdict on all systems, with the largest error. Else its upper left
    half is the best verdict, the lower right half the worst.
    """
    panels = [_Panel.of(axis, cells) for axis in axes]
    count = math.ceil(sum(panel.width + GAP for panel in panels) / ROOM) or 1
    height = count * (HEAD + ROW * len(methods)) + 0.55
    with new_figure(WIDTH, height, layout="constrained") as figure:
        lines = figure.add_gridspec(count, 1)
        for row, chosen in enumerate(np.array_split(np.arange(len(panels)), count)):
            widths = [panels[i].width for i in chosen]
            widths.append(max(WIDEST - sum(widths), 0.01))  # few columns do not fill the line
            places = lines[row].subgridspec(1, len(widths), width_ratios=widths)
            for number, i in enumerate(chosen):
                drawn = figure.add_subplot(places[number])
                _draw_panel(drawn, panels[i], {name: families[name] for name in methods})
                drawn.tick_params("y", which="major", labelleft=number == 0)
        _legend(figure)
    return figure


class _Panel(NamedTuple):
    """An axis, its cells, and the labels of its values in their order."""

    axis: Mapping[str, str]
    cells: Cells
    columns: list[str]

    @classmethod
    def of(cls, axis: Mapping[str, str], cells: Cells) -> _Panel:
        own = [cell for cell in cells if cell["axis"] == axis["name"]]
        values = {cell["label"]: cell["value"] for cell in own}
        return cls(axis, own, sorted(values, key=values.__getitem__))

    @property
    def width(self) -> float:
        return max(NARROWEST, len(self.columns))

    def wrapped(self, what: str, size: float) -> str:
        letters = int(self.width * 12.0 / size)
        return "\n".join(textwrap.wrap(self.axis[what], letters, break_long_words=False))


def _draw_panel(axes: Axes, panel: _Panel, families: Mapping[str, str]) -> None:
    from matplotlib.collections import PolyCollection

    places, methods = defaultdict(list), list(families)
    for cell in panel.cells:
        if cell["method"] in methods:
            places[cell["method"], cell["label"]].append(cell)
    squares, colours = [], []
    for (method, label), found in places.items():
        x, y = panel.columns.index(label), methods.index(method)
        best, worst = min(found, key=_rank), max(found, key=_rank)
        squares.append([(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)])
        colours.append(colour_of(worst))
        if best["verdict"] != worst["verdict"]:
            squares.append([(x, y), (x + 1, y), (x, y + 1)])
            colours.append(colour_of(best))
        if worst["verdict"] in SYMBOLS:
            symbol, ink = SYMBOLS[worst["verdict"]], 1.0 * (worst["verdict"] in FORBIDDEN)
            at = x + 0.68, y + 0.66
            axes.text(*at, symbol, size=4.2, color=str(ink), ha="center", va="center")
    axes.add_collection(PolyCollection(squares, facecolors=colours, linewidths=0))
    columns, rows = len(panel.columns), len(methods)
    axes.set(xlim=(0, columns), ylim=(rows, 0), axisbelow=False)
    axes.set_xticks(np.arange(columns) + 0.5, panel.columns, rotation=90, size=TINY)
    axes.set_yticks(np.arange(rows) + 0.5, methods, size=TINY)
    axes.set_xticks(range(1, columns), minor=True)
    axes.set_yticks(range(1, rows), minor=True)
    axes.tick_params(which="both", length=0, pad=1.5)
    axes.grid(visible=False)
    axes.grid(which="minor", color="white", linewidth=0.3, alpha=1.0)
    for i, (one, other) in enumerate(pairwise(families.values()), 1):
        if one != other:
            axes.axhline(i, color="0.25", linewidth=0.5)
    axes.spines[:].set(visible=True, linewidth=0.5)
    axes.set_title(panel.wrapped("title", SMALL), fontsize=SMALL, pad=4)
    axes.set_xlabel(panel.wrapped("quantity", TINY), fontsize=TINY, labelpad=1.5)


def _rank(cell: CellRecord) -> tuple[int, float]:
    """Order cells from best to worst; among the same verdicts, by the error."""
    return VERDICTS.index(cell["verdict"]), cell["error"] or 0.0


def colour_of(cell: CellRecord) -> Any:
    """Return the colour of a cell: of one that is ok by its error."""
    return COLOURS.get(cell["verdict"]) or shade(cell["error"] or 0.0)


def shade(error: float) -> Any:
    """Return the shade of an error."""
    at = np.interp(math.log10(max(error, 1e-300)), EXPONENTS, (0.0, 1.0))
    return tuple((1.0 - at) * np.array(LIGHT) + at * np.array(DARK))


def _legend(figure: Figure) -> None:
    from matplotlib.patches import Patch

    low, high = EXPONENTS
    words = ", ".join(f"{SYMBOLS[verdict]} {verdict}" for verdict in FORBIDDEN)
    found = {
        f"ok, relative error 1e{exponent:.0f}": shade(10.0**exponent)
        for exponent in (low, 0.5 * (low + high) - 0.5, high)
    }
    found |= {f"{SYMBOLS[v]}  {v}": COLOURS[v] for v in ("unresolved", "failed", "refused")}
    found[f"forbidden: {words}"] = COLOURS["wrong"]
    figure.legend(
        handles=[Patch(facecolor=c, ec="0.4", lw=0.4, label=told) for told, c in found.items()],
        loc="outside lower center",
        ncols=4,
        fontsize=6.0,
        handlelength=1.2,
        columnspacing=1.2,
    )
