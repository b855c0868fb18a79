"""A flow on so(n) × Rⁿ (and SO(n)) along orbits of SO(n), in any dimension, in time."""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np
import numpy.typing as npt

import geomint as gi
from geomint.kernels.groups.so_n import unpack_skew
from geomint.kernels.numbers.blocks import sections
from geomint.problems.spaces.sphere import product

__all__ = ["initial", "problem"]


Flow = namedtuple("Flow", "season a c")


@gi.helper
def flow_rows(n: int) -> Flow:
    """Return the layout of the parameters: ε, a_i, and c_ij."""
    return Flow(season=1, a=n, c=n * (n - 1) // 2)


@gi.helper
def coefficients(params: Any, t: Any, y: Any, n: int, out: Any) -> None:
    """ξ_ij = −(c_ij k_ij (1 + ε cos(t + i)) + (a_j − a_i) γ_i γ_j), i < j, as a flat triangle."""
    amplitude, a, c = sections(params, flow_rows(n))
    gamma, at = gi.part(y, len(c), n), 0
    for i in range(n):
        season = 1.0 + amplitude[0] * gi.cos(t + 1.0 * i)
        for j in range(i + 1, n):
            drag = (a[j] - a[i]) * gamma[i] * gamma[j]
            out[at] = -(c[at] * season * y[at] + drag)
            at += 1


@gi.helper
def dimension(params: Any) -> int:
    """Return the n that has as many parameters."""
    n = 2
    while sum(flow_rows(n)) < len(params):
        n += 1
    return n


@gi.field
def generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ as a flat triangle."""
    coefficients(params, t, y, dimension(params), out)


@gi.field
def motion(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """k̇ = ξk − kξ, γ̇ = ξγ, and, where the state has a frame, ġ = −gξ."""
    n = dimension(params)
    size = n * (n - 1) // 2
    flat = gi.part(work, 0, size)
    x = gi.part(work, size, n * n)
    k = gi.part(work, size + n * n, n * n)
    coefficients(params, t, y, n, flat)
    unpack_skew(n, flat, x)
    unpack_skew(n, gi.part(y, 0, size), k)
    at = 0
    for i in range(n):
        for j in range(i + 1, n):
            total = 0.0 * y[0]
            for m in range(n):
                total += x[i * n + m] * k[m * n + j] - k[i * n + m] * x[m * n + j]
            out[at] = total
            at += 1
    for i in range(n):
        total = 0.0 * y[0]
        for m in range(n):
            total += x[i * n + m] * y[size + m]
        out[size + i] = total
    start = size + n
    if len(y) > start:
        for i in range(n):
            for j in range(n):
                total = 0.0 * y[0]
                for m in range(n):
                    total -= y[start + i * n + m] * x[m * n + j]
                out[start + i * n + j] = total


def initial(n: int = 4, frame: bool = False) -> npt.NDArray[np.float64]:
    """Return a state with |γ| = 1 and, with a frame, g = 1."""
    k = 0.9 + 0.7 * np.cos(2.0 + 1.7 * np.arange(n * (n - 1) // 2))
    gamma = np.sin(1.0 + 1.3 * np.arange(n))
    parts = [k, gamma / np.linalg.norm(gamma)]
    return np.concatenate([*parts, np.eye(n).ravel()] if frame else parts)


def problem(n: int = 4, season: float = 0.4, frame: bool = False) -> gi.Problem:
    """Return a flow of a skew matrix k and a vector γ, both turned by one element of SO(n).

    ::

        k̇ = [ξ, k],   γ̇ = ξγ,   (ġ = −gξ,)
        ξ_ij = −(c_ij k_ij (1 + ε cos(t + i)) + (a_j − a_i) γ_i γ_j)

    for i < j: a rigid body on SO(n) with inertia that changes in time and a coupling to γ. With
    c_ij = 1/(1 + i/2 + j/3 …) generic, the generator depends on time and state and does not commute
    with itself. Conserved: the spectrum of k, (γ, γ), gγ, gkgᵀ. Forms: ODE and group action.

    Parameters
    ----------
    n : int
        At least 2.
    season : float
        ε.
    frame : bool
        Whether g, n×n row after row, is part of the state.
    """
    a = 1.0 + 0.6 * np.arange(n)
    c = np.array([1.0 / (1.0 + 0.5 * i + 0.3 * j) for i in range(n) for j in range(i + 1, n)])
    vectors = gi.Skew(n), gi.Euclidean(n, "gamma", turned=True)
    space = gi.Product(*vectors, gi.Rotations(n)) if frame else gi.Product(*vectors)
    return gi.Problem(
        name=f"so-{n}-flow",
        space=space,
        params=gi.packed(flow_rows(n), season=season, a=a, c=c).data,
        field=motion,
        action=space.action(generator),
        work=len(c) + 2 * n * n,
        invariants={
            "momentum-squared": product(len(c), 0, 0),
            "direction-squared": product(n, len(c), len(c)),
        },
        parameters={"n": n, "season": season, "frame": frame},
    )
