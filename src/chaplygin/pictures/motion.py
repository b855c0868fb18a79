"""One exact motion: the vertical on the sphere, the separated coordinates, the torus, the trace.

All functions draw into given axes; `motion_figure` makes a whole figure of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

import geomint as gi

from ..manifold import Array
from ..spheroconical import Spheroconical

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..exact.flow import ExactFlow
    from ..exact.reconstruction import ContactPath

# Okabe and Ito's: colour-blind readers distinguish them.
COLOURS = {"blue": "#0072b2", "orange": "#d55e00", "green": "#009e73", "grey": "#999999"}
TURNS = 40.0  # of the fastest angle, in figures of trajectories
SAMPLES = 6000
BOUNDARY = 400  # points of a curve


def motion_figure(exact: ExactFlow, path: ContactPath | None = None) -> Figure:
    """Return a figure of one motion.

    Parameters
    ----------
    exact : ExactFlow
        ``problem.exact(y0)``.
    path : ContactPath, optional
        At n = 3: adds the trace of the contact point.
    """
    from matplotlib.figure import Figure

    panels = motion_panels(exact, path)
    rows, columns = (2, 2) if len(panels) == 4 else (1, len(panels))
    figure = Figure(figsize=(4.2 * columns, 3.7 * rows), layout="constrained")
    for axis, draw in zip(figure.subplots(rows, columns).flat, panels.values(), strict=True):
        draw(axis)
    return figure


def motion_panels(
    exact: ExactFlow, path: ContactPath | None = None
) -> dict[str, Callable[[Any], None]]:
    """Return what draws each panel of a figure of one motion into given axes, by name."""
    panels: dict[str, Callable[[Any], None]] = {
        "separation": partial(draw_separation, exact=exact),
        "torus": partial(draw_torus, exact=exact),
    }
    if len(exact.a) == 3:
        panels = {"vertical": partial(draw_vertical, exact=exact), **panels}
    if path is not None:
        panels["contact"] = partial(draw_contact_point, path=path)
    return panels


def sampled(exact: ExactFlow) -> tuple[Array, Array]:
    """Return times τ of the first turns and the separated coordinates there, a row each."""
    tau = _first_turns(exact.frequencies)[: SAMPLES // 5]
    return tau, exact.lam(_theta(exact, tau))


def draw_vertical(axis: Any, exact: ExactFlow, view: gi.View | None = None) -> None:
    """Draw γ on the sphere, n = 3, and the curves λ = const that bound it.

    Of the ball with area constant zero, where the motion is that of a ball with another.
    """
    from matplotlib.patches import Circle

    if len(exact.a) != 3:
        raise gi.DomainError("n", len(exact.a), "a motion in three dimensions")
    view = gi.View() if view is None else view
    gamma = exact.inward(exact.at_tau(_first_turns(exact.frequencies)))[:, :3]
    axis.add_patch(Circle((0, 0), 1, fill=False, color=COLOURS["grey"], lw=0.8))
    for curve in _boundaries(exact):
        view.draw_curve(axis, curve, color=COLOURS["orange"], lw=1.6)
    view.draw_curve(axis, gamma, color=COLOURS["blue"], lw=0.6)
    for i, name in enumerate(("$\\gamma_1$", "$\\gamma_2$", "$\\gamma_3$")):
        x, y, _ = view(1.12 * np.eye(3)[i])
        axis.text(x, y, name, ha="center", va="center", fontsize=9)
    axis.set_aspect("equal")
    axis.set_axis_off()
    axis.set_title("vertical, bounded by λ = const")


def draw_separation(axis: Any, exact: ExactFlow) -> None:
    """Draw the separated coordinates λ_k, which run to and fro in their ovals, over some turns."""
    tau, lam = sampled(exact)
    palette = list(COLOURS.values())
    for k in range(lam.shape[1]):
        axis.axhspan(*exact.ovals[k], color="#000000", alpha=0.06, lw=0)
        axis.plot(tau, lam[:, k], color=palette[k % 3], lw=1.0, label=f"$\\lambda_{k + 1}$")
    for i, value in enumerate(exact.unit * exact.axes.alpha):
        axis.axhline(
            value, color=COLOURS["grey"], lw=0.6, ls=":", label="$a_i$" if i == 0 else None
        )
    title = "separated coordinates in their ovals"
    axis.set(xlabel="τ (dimensionless)", ylabel="λ (dimensionless)", title=title)
    axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def draw_torus(axis: Any, exact: ExactFlow) -> None:
    """Draw the first two angles unwrapped: θ, and φ, which is a straight line; or one against τ."""
    tau = _first_turns(exact.frequencies)[: SAMPLES // 8]
    phi = exact.start + np.outer(tau, exact.frequencies)
    size = len(exact.torus.middle)
    wide = phi.shape[1] > 1

    def draw(angles: Array, **style: Any) -> None:
        x, y = (angles[:, 0] / np.pi, angles[:, 1]) if wide else (tau, angles[:, 0])
        axis.plot(x, y / np.pi, lw=1.0, **style)

    draw(phi, label="linear angles φ", ls="--", color=COLOURS["orange"])
    if size:
        theta = phi.copy()
        theta[:, :size] = np.unwrap(_theta(exact, tau), axis=0)
        theta[:, :size] += 2 * np.pi * np.rint((phi - theta)[:1, :size] / (2 * np.pi))
        draw(theta, label="angles θ of the ovals", color=COLOURS["blue"])
    labels = ("first angle / π", "second angle / π") if wide else ("τ (dimensionless)", "angle / π")
    axis.set(xlabel=labels[0], ylabel=labels[1], title="torus, unwrapped")
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)


def draw_contact_point(axis: Any, path: ContactPath) -> None:
    """Draw the contact point in the plane without its mean drift, over some turns."""
    times = _first_turns(path.exact.mean_frequencies)
    trace = path.contact(times) - np.outer(times, path.drift)
    axis.plot(*trace.T, color=COLOURS["blue"], lw=0.6)
    axis.set_aspect("equal", adjustable="datalim")
    xlabel, ylabel = (f"$r_{i}$ less drift (dimensionless)" for i in (1, 2))
    title = f"contact point, less a drift of {np.linalg.norm(path.drift):.3g}"
    axis.set(xlabel=xlabel, ylabel=ylabel, title=title)
    axis.grid(alpha=0.3)


def _first_turns(frequencies: Array) -> Array:
    """Return times over some turns of the fastest angle."""
    return np.linspace(0.0, 2 * np.pi * TURNS / np.max(np.abs(frequencies)), SAMPLES)


def _theta(exact: ExactFlow, tau: Array) -> Array:
    size = len(exact.torus.middle)
    if size == 0:
        return np.zeros((len(tau), 0))
    return np.array([exact.theta(y) for y in exact.at_tau(tau)])


def _boundaries(exact: ExactFlow) -> list[Array]:
    """Return the curves λ_k = const at ends of ovals that are no coordinate planes, n = 3."""
    if len(exact.axes.alpha) != 3:
        return []
    chart = Spheroconical(exact.axes.alpha)
    low, middle, high = exact.axes.alpha
    curves = []
    for oval in exact.separation.ovals:
        ends = [(oval.lower, oval.low_axis), (oval.upper, oval.high_axis)]
        for value in (float(end) for end, plane in ends if plane is None):
            # Dense at the ends, where γ goes like a root.
            s = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, BOUNDARY))
            inside = low < value < middle
            other = middle + s * (high - middle) if inside else low + s * (middle - low)
            pair = [np.full(BOUNDARY, value), other]
            lam = np.stack(pair if inside else pair[::-1])
            points = np.array([chart.gamma(x[:, None] - chart.a, np.ones(3)) for x in lam.T])
            signs = itertools.product((1.0, -1.0), repeat=3)
            curves += [points * np.array(s) for s in signs]
    return curves
