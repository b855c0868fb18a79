"""Motions in many dimensions."""

from functools import partial

import geomint as gi

from .standard import QUICK, SYSTEMS, THREE, started

DIMENSION = gi.StressAxis("dimension", "dimensions", "n")

_SMALL = (2, 3, 4, 5)
_LARGE = (7, 10, 16, 32, 64, 100)
_MANY = {"veselova": _LARGE, "ellipsoid": _LARGE, "neumann": (10, 100), "clebsch": (10, 100)}
_SHORT = 0.2  # characteristic times, for large n


def cases() -> list[gi.StressCase]:
    """Return motions in growing dimension.

    From n = 7 on the ball has no attitude, and its reference comes from the reduced system, whose
    field takes O(n) operations.
    """
    found = [
        gi.StressCase(
            name,
            DIMENSION,
            n,
            n,
            partial(started, name, n),
            quick=QUICK if (name, n) == ("sphere", 3) else (),
        )
        for name in SYSTEMS
        for n in (_SMALL if name not in THREE else ())
    ]
    found += [
        gi.StressCase(
            "sphere",
            DIMENSION,
            n,
            n,
            partial(started, "sphere", n),
            representations=("reduced", "hamiltonized", "ball"),
            span=_SHORT,
            reference="reduced",
        )
        for n in _LARGE
    ]
    return found + [
        gi.StressCase(name, DIMENSION, n, n, partial(started, name, n), span=_SHORT)
        for name, sizes in _MANY.items()
        for n in sizes
    ]
