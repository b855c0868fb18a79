"""Quantities that are evaluated by one function: the same bits, and when."""

import numpy as np
import pytest

import geomint as gi
from geomint.watch import functions
from geomint.watch.functions import MANY, grouped

WATCHED = ["energy", "K", "area", "norm", "measure"]


def test_when():
    names = ("a", "b", "c")
    assert grouped(names, MANY / 2) == [names]
    assert grouped(names, np.nextafter(MANY / 2, 0.0)) == [("a",), ("b",), ("c",)]
    assert grouped(["a"], 1e300) == [("a",)]
    assert grouped([], 1e300) == []


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize(("end", "every"), [(20.0, 1), (19.99, 3)])
def test_bits_are_the_same(monkeypatch, end, every, compiled):
    """With the measure among them, with an end that is sampled apart, and in plain Python."""
    scene = gi.load_scene("ball-3d")
    problem, state = scene.model.problems["classical"], scene.model.states["classical"]

    def drifts():
        return gi.solve(
            problem,
            state,
            t_end=end if compiled else 0.01 * end,
            method="cf-4",
            step=0.02,
            observe={**{key: {} for key in WATCHED}, "measure": {"steps": 2}},
            observe_every=every,
            compiled=compiled,
        ).drift

    apart = drifts()
    monkeypatch.setattr(functions, "MANY", 1)
    calls = []
    written = functions.written
    monkeypatch.setattr(functions, "written", lambda *f: calls.append(len(f)) or written(*f))
    assert drifts() == apart
    assert calls == [4]


def test_the_plan_says_so():
    scene = gi.load_scene("ball-3d")
    assert "after every step, by one function" in gi.make_plan(scene).watched.reason
    short = scene.changed(time={"t_end": 10.0})
    assert "function" not in gi.make_plan(short).watched.reason
    alone = scene.changed_observation(["energy", "measure"])
    assert "function" not in gi.make_plan(alone).watched.reason
