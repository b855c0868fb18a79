"""Draw the chain of reductions of the rolling ball: docs/images/reduction.png."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt

from geomint.plots.style import COLOURS, figure_style

BOXES = (
    ("ball in space", "$(g,\\, r,\\, \\omega,\\, v)$\ntime $t$", "constraint"),
    (
        "ball in its body",
        "$(k,\\, \\gamma)$\n$so(n)^*\\times S^{n-1}$, $t$",
        "energy, $K$, area, measure",
    ),
    ("reduced sphere", "$(\\gamma,\\, p)$\n$T^*S^{n-1}$, $t$", "energy, $K$, measure"),
    (
        "Hamiltonised sphere",
        "$(\\gamma,\\, \\tilde p)$\n$T^*S^{n-1}$, $\\tau$",
        "symplectic form, tori",
    ),
)
ARROWS = (
    "position, turns\nabout the vertical",
    "zero momentum\nabout the vertical",
    "$d\\tau = \\mathcal{N}\\,dt$\n$\\tilde p = \\mathcal{N} p$",
)


def main() -> None:
    """Write the picture."""
    with figure_style():
        figure, axes = plt.subplots(figsize=(6.5, 1.75))
        axes.set(xlim=(-0.1, 13.4), ylim=(-0.2, 3.4))
        axes.set_axis_off()
        for i, (name, state, kept) in enumerate(BOXES):
            x = 3.65 * i
            box = plt.Rectangle((x, 0.75), 2.4, 1.35, fill=False, edgecolor=COLOURS[0])
            axes.add_patch(box)
            axes.text(x + 1.2, 2.25, name, ha="center", va="bottom", fontsize=8, weight="bold")
            axes.text(x + 1.2, 1.42, state, ha="center", va="center", fontsize=7.5)
            axes.text(x + 1.2, 0.5, kept, ha="center", va="top", fontsize=7, color=COLOURS[2])
        for i, words in enumerate(ARROWS):
            x = 3.65 * i + 2.5
            arrow = {"arrowstyle": "->", "color": COLOURS[1]}
            axes.annotate("", (x + 1.05, 1.42), (x, 1.42), arrowprops=arrow)
            axes.text(
                x + 0.52, 2.75, words, ha="center", va="bottom", fontsize=6.5, color=COLOURS[1]
            )
        out = Path(__file__).parents[1] / "docs" / "images" / "reduction.png"
        figure.savefig(out, bbox_inches="tight", dpi=200)


if __name__ == "__main__":
    main()
