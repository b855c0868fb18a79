"""Motions in many dimensions."""

from __future__ import annotations

from functools import partial

import geomint as gi

from .standard import MOTIONS, D, Motion, a_values, direction, momentum

__all__ = ["DIMENSION", "cases"]

DIMENSION = gi.StressAxis("dimension", "dimensions", "n")

_SMALL = (2, 3, 4, 5)
_LARGE = (7, 10, 16, 32, 64, 100)


def _span(n: int) -> float:
    """Characteristic times of a run: a step of SO(n) takes O(n³) operations, and a cell many runs."""
    return 0.2 * min(1.0, 16.0 / n) ** 2


def cases() -> list[gi.StressCase]:
    """Return motions in growing dimension.

    From n = 7 on the ball has no attitude, and its reference comes from the reduced system, whose
    field takes O(n) operations.
    """
    found = [
        gi.StressCase(name, DIMENSION, n, n, partial(_standard, MOTIONS[name], n))
        for name in MOTIONS
        for n in _SMALL
    ]
    found += [
        gi.StressCase(
            "sphere",
            DIMENSION,
            n,
            n,
            partial(_standard, MOTIONS["sphere"], n),
            representations=("reduced", "hamiltonized", "ball"),
            span=_span(n),
            reference="reduced",
        )
        for n in _LARGE
    ]
    return found + [
        gi.StressCase(name, DIMENSION, n, n, partial(_standard, MOTIONS[name], n), span=_span(n))
        for name in ("veselova", "ellipsoid")
        for n in _LARGE
    ]


def _standard(motion: Motion, n: int) -> gi.Model:
    gamma = direction(n)
    return motion(a_values(n), D, gamma, momentum(gamma))
