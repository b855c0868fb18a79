"""Conditions c(y) = 0: functions that write several, and geometry from their differences."""

import functools
from collections.abc import Callable

import numpy as np

from ...arguments import Array
from ...kernels.compiling.recorded import Recorded, field, named_as
from ...kernels.numbers.blocks import part
from .repair import length

__all__ = ["both", "brought_back", "differences", "tangent_part", "written"]

ROUNDS = 30  # of Newton's method; it takes 4 or 5
Function = Callable[[Array], Array]


@functools.cache
def both(first: Recorded, m: int, second: Recorded, k: int) -> Recorded:
    """Return the function that writes m conditions and then k others."""

    def conditions(params, t, y, out, work):
        first(params, t, y, part(out, 0, m), work)
        second(params, t, y, part(out, m, k), work)

    return field(conditions)


@functools.cache
def written(*observables: Recorded) -> Recorded:
    """Return the function that writes their values."""
    first, *others = observables
    if others:
        return both(written(first), 1, written(*others), len(others))

    def condition(params, t, y, out, work):
        out[0] = first(params, t, y, work)

    return named_as(condition, first)


def differences(f: Function, y: Array, steps: Array) -> Array:
    """Return ½(f(y + s) − f(y − s)) for each step s."""
    return np.array([0.5 * (f(y + s) - f(y - s)) for s in steps])


def tangent_part(normals: Array, v: Array) -> Array:
    """Return v less its part along the rows of c_y; twice, for round-off."""
    basis, _ = np.linalg.qr((normals / np.linalg.norm(normals, axis=1, keepdims=True)).T)
    for _ in range(2):
        v = v - basis @ (basis.T @ v)
    return v


def brought_back(c: Function, normals: Function, z: Array) -> Array | None:
    """Return the point c = 0 near z, by Newton's method along the rows of c_y; None without one."""
    before = np.inf
    for _ in range(ROUNDS):
        defects = c(z)
        size = float(np.max(np.abs(defects), initial=0.0))
        if not np.isfinite(size):
            return None
        if size == 0.0 or (size >= 0.5 * before and before < 1e-12 * max(1.0, length(z))):
            return z
        before, rows = size, normals(z)
        sizes = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
        z = z - np.linalg.lstsq(rows / sizes[:, None], defects / sizes)[0]
    return None
