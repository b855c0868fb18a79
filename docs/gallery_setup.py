"""How sphinx-gallery runs the pages of `examples`: their style, their warnings, their figures."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from geomint import GeomintWarning
from geomint.plots.style import COLOURS, STYLE

FIRST = ("rolling_ball", "poincare_section", "drift_of_four_methods", "measure_lost_and_kept")


class PageOrder:
    """The order on the gallery's page: what shows most, then the others by name."""

    def __init__(self, source: str) -> None:
        self.source = source

    def __call__(self, name: str) -> tuple[int, str]:
        """Return what pages are sorted by."""
        stem = Path(name).stem
        return (FIRST.index(stem) if stem in FIRST else len(FIRST)), stem


def begin_page(gallery_conf: dict[str, Any], name: str) -> None:
    """Give every page the style of geomint's figures, and make a warning of geomint an error."""
    warnings.simplefilter("error", GeomintWarning)
    plt.rcdefaults()
    mpl.rcParams.update(STYLE)
    mpl.rcParams["axes.prop_cycle"] = mpl.cycler(color=COLOURS)
    plt.close("all")


def new_figures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figures that a block has made, geomint's among them, which pyplot does not know."""
    named = block_vars["example_globals"].values()
    figures = {id(value): value for value in named if isinstance(value, Figure)}
    paths = []
    for figure in figures.values():
        if not getattr(figure, "in_gallery", False):
            figure.in_gallery = True
            paths.append(next(block_vars["image_path_iterator"]))
            figure.savefig(paths[-1], bbox_inches="tight")
    plt.close("all")
    return str(figure_rst(paths, gallery_conf["src_dir"]))
