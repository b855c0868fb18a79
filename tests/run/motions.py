"""Motions that tests of runs share: one field for many of them, so that it is compiled once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import geomint as gi

Rate = Callable[..., Any]


def first(name: str, rate: Rate, *params: float, **more: Any) -> gi.Problem:
    """Return the motion x' = rate(params, t, y)."""
    known = gi.helper(rate)

    @gi.field
    def field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = known(params, t, y)

    return gi.Problem(name, (("x", 1),), params, field=field, **more)


PIECES = (("x", 1), ("v", 1))


def second(name: str, force: Rate, *params: float, pieces: Any = PIECES, **more: Any) -> gi.Problem:
    """Return the motion x'' = force(params, t, y), with y = (x, v)."""
    known = gi.helper(force)

    @gi.field
    def field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = 1.0 * y[1]
        out[1] = known(params, t, y)

    return gi.Problem(name, pieces, params, field=field, **more)


_SWING = second("swing", lambda p, t, y: p[1] - p[0] * y[0] - p[2] * y[1])


def swing(stiffness: float = 1.0, push: float = 0.0, friction: float = 0.0, *more: float) -> Any:
    """Return x'' = push − stiffness x − friction x'; further parameters are those of events."""
    params = [stiffness, push, friction, *more]
    return gi.Problem("swing", PIECES, params, field=_SWING.field)
