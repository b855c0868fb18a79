"""Families of motions: the bifurcation diagram at n = 3, and maps of rotation numbers."""

from typing import Any

import numpy as np

import geomint as gi

from ..exact.frequency_map import critical_energies, discriminant, frequency_map
from ..manifold import Array
from .motion import COLOURS

GRID = 400


def draw_bifurcations(axis: Any, a: Any, D: float, states: Any = None) -> None:
    """Draw the plane of K and H/K of the sphere, n = 3: where there are tori, where they degenerate.

    Both are quadratic in p̃, and critical values of H are multiples of K. Shaded is the logarithm of
    the discriminant: dark where two branch points are near.

    Parameters
    ----------
    axis
        Of matplotlib.
    a, D
        Of the sphere.
    states : array_like, shape (N, 6), optional
        States (γ, p̃) of ``sphere.hamiltonized()``, to be marked.
    """
    lines = critical_energies(a, D, 1.0)
    low, high = float(np.min(lines)), float(np.max(lines))
    values = np.zeros((0, 2)) if states is None else _values(a, D, np.asarray(states))
    ends = [0.1, 10.0] if not len(values) else [0.5 * values[:, 0].min(), 2.0 * values[:, 0].max()]
    ratio = low + np.linspace(0.0, 1.0, GRID)[1:-1] * (high - low)
    shade = np.log10(discriminant(a, D, 1.0, ratio))
    mesh = axis.pcolormesh(
        ends, ratio, np.stack([shade, shade], axis=1), cmap="cividis", shading="gouraud",
        vmin=np.max(shade) - 4.0, rasterized=True,
    )  # fmt: skip
    axis.figure.colorbar(mesh, ax=axis, label="log₁₀ (discriminant / K⁶)", extend="min")
    colours, styles = (COLOURS["orange"], "white", COLOURS["blue"]), ("-", "--", "-")
    for i, (value, colour, style) in enumerate(zip(lines, colours, styles, strict=True), 1):
        axis.axhline(value, color=colour, ls=style, lw=1.8, label=f"steady turns about axis {i}")
    if len(values):
        axis.plot(
            values[:, 0], values[:, 1] / values[:, 0], "o", ms=3, color="black", label="states"
        )
    axis.set(xscale="log", xlabel="K (dimensionless)", ylabel="H/K (dimensionless)",
             title="tori, and where they degenerate")  # fmt: skip
    axis.legend(fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1.08), ncols=2,
                facecolor="#dddddd", framealpha=1.0)  # fmt: skip


def _values(a: Any, D: float, states: Array) -> Array:
    from ..ball.sphere import ChaplyginSphere

    problem = ChaplyginSphere(a, D).hamiltonized()
    return np.array([[gi.value(problem, "K", y), gi.value(problem, "energy", y)] for y in states])


def draw_rotation_numbers(
    axis: Any, problem: gi.Problem, states: Any, label: Any, at: Any, **style: Any
) -> Array:
    """Draw ω_k/ω_1 of a family of motions against a parameter of the family.

    Parameters
    ----------
    axis
        Of matplotlib.
    problem : Problem
        With an exact flow.
    states : iterable of array_like
    label : str
        Of the parameter.
    at : array_like, shape (N,)
        The parameter of each state.

    Returns
    -------
    array, shape (N, n−2)
        The rotation numbers; NaN where a motion has no torus.
    """
    found = frequency_map(problem, states).rotation_numbers
    palette = list(COLOURS.values())
    for k in range(found.shape[1]):
        name = f"$\\omega_{k + 2}/\\omega_1$"
        axis.plot(at, found[:, k], color=palette[k % 3], label=name, **{"lw": 1.2, **style})
    axis.set(xlabel=label, ylabel="rotation number (dimensionless)")
    axis.legend(fontsize=8)
    axis.grid(alpha=0.3)
    return found
