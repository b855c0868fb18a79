"""The picture: a panel for each axis, methods by values, coloured by verdict."""

from __future__ import annotations

import math
import textwrap
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

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
COLOURS = {
    "unresolved": "#c9c9c9",
    "failed": "#e69f00",
    "refused": "#ffffff",
    **dict.fromkeys(FORBIDDEN, "#000000"),
}
SYMBOLS = {
    "unresolved": "~",
    "failed": "∘",
    "refused": "–",
    "wrong": "×",
    "untyped": "!",
    "hung": "∞",
}
LIGHT, DARK = (0.87, 0.93, 0.97), (0.19, 0.51, 0.74)
EXPONENTS = (-16.0, -1.0)  # of the errors at the ends of the blues
ROW, LABELS = 0.082, 1.62  # inches: a method, the names
TOP, HEAD = 0.5, 1.1  # inches: a panel's title; that, its ticks and their quantity
TINY = 5.2
GAP = 0.14
NARROWEST, UNIT = 0.58, 0.095  # inches of a panel: what its title needs; of a column
ROOM = WIDTH - LABELS - 0.05  # inches that a line has for its panels


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
    lines = _lines([_Panel.of(axis, cells) for axis in axes])
    height = len(lines) * (HEAD + ROW * len(methods)) + 0.55
    with new_figure(WIDTH, height) as figure:
        for number, line in enumerate(lines):
            top = 1.0 - number * (HEAD + ROW * len(methods)) / height
            _draw_line(figure, line, top, height, methods, families)
        _legend(figure, height)
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


def _lines(panels: Sequence[_Panel]) -> list[list[_Panel]]:
    """Return the panels, line by line: as few lines as there is room in, then even."""
    fewest = _filled(panels, ROOM + GAP)
    for share in range(50, 100):
        even = _filled(panels, 0.01 * share * (ROOM + GAP))
        if len(even) == len(fewest):
            return even
    return fewest


def _filled(panels: Sequence[_Panel], limit: float) -> list[list[_Panel]]:
    """Return panels in lines that are filled up to a limit, each with one at least."""
    lines: list[list[_Panel]] = [[]]
    used = 0.0
    for panel in panels:
        need = GAP + max(NARROWEST, UNIT * len(panel.columns))
        if lines[-1] and used + need > limit:
            lines.append([])
            used = 0.0
        lines[-1].append(panel)
        used += need
    return lines


def _draw_line(
    figure: Figure,
    line: Sequence[_Panel],
    top: float,
    height: float,
    methods: Sequence[str],
    families: Mapping[str, str],
) -> None:
    """Draw panels side by side, as wide as their numbers of columns want."""
    left = LABELS
    for panel, width in zip(line, _widths([len(p.columns) for p in line]), strict=True):
        box = (
            left / WIDTH,
            top - (TOP + ROW * len(methods)) / height,
            width / WIDTH,
            ROW * len(methods) / height,
        )
        axes = figure.add_axes(box)
        _draw_panel(axes, panel, methods, families)
        axes.set_title(_wrapped(panel.axis["title"], width, 6.5), fontsize=6.5, pad=4)
        quantity = _wrapped(panel.axis["quantity"], width, TINY)
        axes.set_xlabel(quantity, fontsize=TINY, labelpad=1.5)
        if panel is not line[0]:
            axes.set_yticklabels([])
        left += width + GAP


def _widths(columns: Sequence[int]) -> list[float]:
    """Return the widths of panels of so many columns: alike, but not too narrow for a title."""
    room = ROOM - GAP * (len(columns) - 1)
    wide = sum(columns)
    for count in sorted(columns):
        if count * room / wide < NARROWEST:
            room, wide = room - NARROWEST, wide - count
    unit = min(room / wide, 2.0 * ROW) if wide else 0.0
    return [max(NARROWEST, unit * count) for count in columns]


def _wrapped(text: str, width: float, size: float) -> str:
    letters = int(width * 130.0 / size)
    return "\n".join(textwrap.wrap(text, max(6, letters), break_long_words=False))


def _draw_panel(
    axes: Axes, panel: _Panel, methods: Sequence[str], families: Mapping[str, str]
) -> None:
    from matplotlib.collections import PolyCollection

    places = defaultdict(list)
    for cell in panel.cells:
        places[cell["method"], cell["label"]].append(cell)
    squares, colours = [], []
    for (method, label), found in places.items():
        if method not in methods:
            continue
        x, y = panel.columns.index(label), methods.index(method)
        ranked = sorted(found, key=_rank)
        worst = ranked[-1]["verdict"]
        squares.append([(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)])
        colours.append(colour_of(ranked[-1]))
        if ranked[0]["verdict"] != worst:
            squares.append([(x, y), (x + 1, y), (x, y + 1)])
            colours.append(colour_of(ranked[0]))
        if worst in SYMBOLS:
            ink = "white" if worst in FORBIDDEN else "black"
            axes.text(
                x + 0.68,
                y + 0.66,
                SYMBOLS[worst],
                fontsize=4.2,
                color=ink,
                ha="center",
                va="center",
            )
    axes.add_collection(PolyCollection(squares, facecolors=colours, linewidths=0))
    axes.set_xlim(0, len(panel.columns))
    axes.set_ylim(len(methods), 0)
    axes.set_xticks(
        [i + 0.5 for i in range(len(panel.columns))], panel.columns, rotation=90, fontsize=TINY
    )
    axes.set_yticks([i + 0.5 for i in range(len(methods))], methods, fontsize=TINY)
    axes.tick_params(length=0, pad=1.5)
    axes.set_axisbelow(False)
    axes.grid(visible=False)
    for i in range(1, len(panel.columns)):
        axes.axvline(i, color="white", linewidth=0.3)
    for i in range(1, len(methods)):
        new = families[methods[i]] != families[methods[i - 1]]
        axes.axhline(i, color="0.25" if new else "white", linewidth=0.5 if new else 0.3)
    for spine in axes.spines.values():
        spine.set_visible(True)
        spine.set_linewidth(0.5)


def _rank(cell: CellRecord) -> tuple[int, float]:
    """Order cells from best to worst; among the same verdicts, by the error."""
    return VERDICTS.index(cell["verdict"]), cell["error"] or 0.0


def colour_of(cell: CellRecord) -> Any:
    """Return the colour of a cell."""
    if cell["verdict"] != "ok":
        return COLOURS[cell["verdict"]]
    return shade(cell["error"] or 0.0)


def shade(error: float) -> tuple[float, float, float]:
    """Return the shade of an error."""
    low, high = EXPONENTS
    at = (math.log10(max(error, 1e-300)) - low) / (high - low)
    at = min(max(at, 0.0), 1.0)
    red, green, blue = (a + at * (b - a) for a, b in zip(LIGHT, DARK, strict=True))
    return red, green, blue


def _legend(figure: Figure, height: float) -> None:
    from matplotlib.patches import Patch

    low, high = EXPONENTS
    handles = [
        Patch(facecolor=shade(10.0**exponent), label=f"ok, relative error 1e{exponent:.0f}")
        for exponent in (low, 0.5 * (low + high) - 0.5, high)
    ]
    for verdict in ("unresolved", "failed", "refused"):
        label = f"{SYMBOLS[verdict]}  {verdict}"
        handles.append(
            Patch(facecolor=COLOURS[verdict], edgecolor="0.4", linewidth=0.4, label=label)
        )
    words = ", ".join(f"{SYMBOLS[verdict]} {verdict}" for verdict in FORBIDDEN)
    handles.append(Patch(facecolor="#000000", label=f"forbidden: {words}"))
    figure.legend(
        handles=handles,
        loc="lower center",
        ncols=4,
        fontsize=6.0,
        handlelength=1.2,
        columnspacing=1.2,
        bbox_to_anchor=(0.5, 0.0),
        borderaxespad=0.3,
    )
