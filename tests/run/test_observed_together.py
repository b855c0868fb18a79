"""Quantities that are evaluated by one function where many states are watched: the same bits."""

from __future__ import annotations

from typing import Any

import pytest

import geomint as gi

SCENE = gi.load_scene("ball-3d")
WATCHED: dict[str, Any] = {name: {} for name in ("energy", "K", "area", "norm")}


@pytest.mark.parametrize(
    ("end", "every", "compiled"), [(20.0, 1, True), (19.99, 3, True), (0.1999, 3, False)]
)
def test_bits_are_the_same(end: float, every: int, compiled: bool) -> None:
    """With the measure among them, with an end that is sampled apart, and in plain Python."""
    problem, state = SCENE.model.problems["classical"], SCENE.model.states["classical"]
    ended = gi.Event(lambda params, t, y, work: t, terminal=True, level=end)
    run: dict[str, Any] = {"method": "cf-4", "step": 0.02, "events": ended, "compiled": compiled}
    more = {} if compiled else {"measure": {"steps": 2}}
    run |= {"observe": {**WATCHED, **more}, "observe_every": every}
    together, apart = (gi.solve(problem, state, t_end=x, **run).drift for x in (1e7, 21.0))
    assert together == apart
    assert together["energy"].windows.last_time == pytest.approx(end, rel=1e-15)
