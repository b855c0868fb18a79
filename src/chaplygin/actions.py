"""Rotations that act on vectors, from generators written as flat triangles."""

from __future__ import annotations

import functools
from typing import Any

import geomint as gi

__all__ = ["action_on_vectors"]


def action_on_vectors(generator: Any, n: int, vectors: int) -> gi.GroupAction:
    """Return the action of SO(n) on a state of so many vectors of R^n, ẏ = ξ·y.

    At n = 3 it is that of SO(3) on R³, whose exponential is a closed formula: several times faster.

    Parameters
    ----------
    generator : recorded
        Writes ξ as a flat triangle.
    n, vectors : int
    """
    if n == 3:
        return gi.GroupAction(as_vector_of_so3(generator), gi.so3(vectors))
    return gi.GroupAction(generator, gi.so_n(n, *(["vector"] * vectors)))


@functools.cache
def as_vector_of_so3(generator: Any) -> Any:
    """Return the generator that writes a 3-vector by the hat map (iso)."""

    def vector_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        generator(params, t, y, out, work)
        first = out[0]
        out[0] = -out[2]
        out[2] = -first

    return gi.field(vector_generator)
