"""The picture of Brouwer's law: rms errors against numbers of steps, a panel a quantity."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, MARKERS, WIDTH

PANELS = {
    "energy": "energy H",
    "K": "second integral K",
    "norm": "|γ| = 1",
    "tangency": "(γ, p̃) = 0",
    "phase": "phase",
}
SLOPES = {"phase": (1.5, "n³ᐟ²")}
STYLES = {  # colour and marker; the same method with other last digits has its colour
    "dop853": (0, 0),
    "dop853-digits": (0, 6),
    "verlet-8": (1, 1),
    "rattle-2": (2, 2),
    "gauss-8": (3, 3),
    "rkmk-dop853": (4, 4),
    "rkmk-dop853-digits": (4, 5),
    "cf-4": (5, 5),
}
HIGHEST = 1e-10  # of integrals: what is larger is truncation, and is told in words


def picture(record: dict[str, Any], path: Path) -> None:
    """Draw it."""
    with new_figure(WIDTH, 0.8 * WIDTH, layout="constrained") as figure:
        panels = figure.subplots(2, 3, sharex=True).flat
        for panel, (key, title) in zip(panels, PANELS.items(), strict=False):
            for name, found in record["methods"].items():
                draw(panel, found, key, name)
            reference(panel, key, record)
            beyond(panel, key, record)
            panel.set_title(title)
            panel.tick_params(labelbottom=True)
        panels[0].set_ylabel("rms of the relative error")
        panels[3].set_ylabel("rms error")
        for panel in (panels[2], panels[3], panels[4]):
            panel.set_xlabel("steps n")
        legend(panels[5], record)
        figure.savefig(path, dpi=200)


def draw(panel: Any, found: dict[str, Any], key: str, name: str) -> None:
    """Draw a method: all of its error, and where that is more, dashed its random part."""
    n, own = np.array(found["steps"]), found["quantities"][key]
    every, random = (np.array(own[part]["rms"]) for part in ("all", "random"))
    colour, marker = STYLES[name]
    look = {"color": COLOURS[colour], "marker": MARKERS[marker], "ms": 3.2}
    panel.loglog(n, every, **look)
    if every.max() > 2.0**-51 and np.any(every > 2.5 * random):
        panel.loglog(n, random, ls=(0, (2, 1.2)), mfc="white", **look)


def beyond(panel: Any, key: str, record: dict[str, Any]) -> None:
    """Leave out errors of truncation that would leave no room for those of rounding, and name them."""
    if key not in ("energy", "K"):
        return
    words = []
    for name, found in record["methods"].items():
        sizes = found["quantities"][key]["all"]["rms"]
        if min(sizes) > HIGHEST:
            ends = dict.fromkeys(
                f"{size:.0e}".replace("e-0", "e-") for size in (sizes[0], sizes[-1])
            )
            words.append(f"{name}: {' … '.join(ends)}")
    panel.set_ylim(top=HIGHEST)
    text = "\n".join(["above, by truncation:", *words])
    panel.text(0.03, 0.98, text, va="top", transform=panel.transAxes, fontsize=6.5)


def reference(panel: Any, key: str, record: dict[str, Any]) -> None:
    """Draw the slope that the law expects, below all lines, and say what it is."""
    slope, words = SLOPES.get(key, (0.5, "√n"))
    n = np.array(next(iter(record["methods"].values()))["steps"])[[0, -1]]
    low = min(
        own["rms"][0]
        for found in record["methods"].values()
        for own in [found["quantities"][key]["random"]]
        if max(found["quantities"][key]["all"]["rms"]) > 2.0**-51
    )
    line = 0.25 * low * (n / n[0]) ** slope
    panel.loglog(n, line, color="0.6", lw=3.0, alpha=0.6, zorder=0)
    late = n[1] / 6.0
    where = late, 0.25 * low * (late / n[0]) ** slope
    panel.annotate(words, where, (4, -3), textcoords="offset points", va="top", color="0.35")


def legend(panel: Any, record: dict[str, Any]) -> None:
    """Fill the last panel with what lines mean."""
    panel.axis("off")
    for name in record["methods"]:
        colour, marker = STYLES[name]
        panel.plot([], [], color=COLOURS[colour], marker=MARKERS[marker], ms=4, label=name)
    panel.plot(
        [], [], color="0.3", ls=(0, (2, 1.2)), marker="o", mfc="white", ms=4, label="random part"
    )
    panel.plot([], [], color="0.6", lw=3.0, alpha=0.6, label="slope of the law")
    panel.legend(loc="center left", borderaxespad=0.0)
