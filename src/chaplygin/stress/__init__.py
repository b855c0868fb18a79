"""Where the balls are hard to integrate: cases for ``geomint stress``, one file a kind of them."""

import geomint as gi

__all__ = ["cases"]


def cases() -> list[gi.StressCase]:
    """Return all cases of this package."""
    from . import dimensions, edge_states as states, equilibria, parameters, rotations

    parts = (parameters, states, equilibria, rotations, dimensions)
    return [case for part in parts for case in part.cases()]
