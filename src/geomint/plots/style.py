"""The look of all figures: sizes for print, colours that colour-blind readers distinguish."""

from __future__ import annotations

import base64
import functools
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import MissingCodeError, raised

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Okabe and Ito's palette without yellow, which is too pale for lines on white.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1.5, 1, 1.5)), (0, (8, 2, 1, 2, 1, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
WIDTH = 6.5  # inches, a printed page without margins
DPI = 200.0  # of files
_GROUND = '<g id="figure_1">'  # where the drawing begins in matplotlib's SVG
_WHITE = '<rect width="100%" height="100%" fill="#ffffff"/>'

STYLE = {
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.5,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "lines.linewidth": 1.1,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "svg.hashsalt": "geomint",
    "savefig.dpi": DPI,
}


@contextmanager
def figure_style() -> Iterator[None]:
    """Make figures within this context look alike, whatever the user's settings: these stay.

    Raises
    ------
    MissingCodeError
        If matplotlib cannot be imported, such as with a backend in MPLBACKEND that it does not know.
    """
    try:
        from matplotlib import style
    except Exception as error:
        raise MissingCodeError("pictures", raised(error)) from error
    with style.context(["default", STYLE]):
        yield


def series_style(i: int) -> dict[str, Any]:
    """Return colour, dashes and marker of the i-th series: no two of 35 share all."""
    return {
        "color": COLOURS[i % len(COLOURS)],
        "linestyle": DASHES[i % len(DASHES)],
        "marker": MARKERS[i % len(MARKERS)],
    }


class Picture:
    """A figure as pages and files show it: laid out once, and drawn once for each kind.

    It must not change any more.
    """

    def __init__(self, figure: Figure) -> None:
        self.figure = figure

    @functools.cached_property
    def svg(self) -> str:
        """SVG with a transparent ground."""
        buffer = io.BytesIO()
        with figure_style():
            self._lay_out()
            metadata = {"Date": None}
            self.figure.savefig(buffer, format="svg", transparent=True, metadata=metadata)
        return buffer.getvalue().decode("utf-8")

    @property
    def uri(self) -> str:
        """The SVG as a data URI."""
        coded = base64.b64encode(self.svg.encode("utf-8")).decode("ascii")
        return f"data:image/svg+xml;base64,{coded}"

    def save(self, folder: Path, name: str) -> None:
        """Write ``name.png`` and ``name.svg``, on white, into the folder."""
        with figure_style():
            self._lay_out()
            self.figure.savefig(folder / f"{name}.png")
        text = self.svg.replace(_GROUND, _WHITE + _GROUND, 1)
        (folder / f"{name}.svg").write_text(text, encoding="utf-8")

    def _lay_out(self) -> None:
        """Place what the figure is made of; `savefig` would draw all of it for that, and twice."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        figure, engine = self.figure, self.figure.get_layout_engine()
        if engine is None:
            return
        before, figure.dpi = figure.dpi, DPI
        FigureCanvasAgg(figure)
        engine.execute(figure)
        figure.set_layout_engine("none")
        figure.dpi = before


def data_uri(figure: Figure) -> str:
    """Return a figure as an SVG data URI with a transparent ground."""
    return Picture(figure).uri
