"""Figures that notebooks show by themselves."""

import io

from matplotlib.figure import Figure

from .style import figure_style

DPI = 100  # of a screen


class ShownFigure(Figure):
    """A figure that needs no pyplot, and no backend, to be seen where it is the value of a cell."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        with figure_style():
            self.savefig(buffer, format="png", dpi=DPI)
        return buffer.getvalue()
