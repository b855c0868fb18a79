"""A change between two runs of one process: every way into compiled code takes the new values."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint import cos, sin

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")

GAIN = 1.5
TABLE = np.array([1.5])


@gi.helper
def gain(x: Any) -> Any:
    """Return a multiple of x: what all functions here depend on, each by calling this."""
    return GAIN * TABLE[0] * x


@gi.field
def pendulum(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """q̈ = −k² sin q."""
    out[0], out[1] = gain(y[1]), -gain(sin(y[0]))


@gi.field
def circle(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A field that nothing changes."""
    out[0], out[1] = 1.0 * y[1], -1.0 * y[0]


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """½p² − k² cos q."""
    return gain(0.5 * y[1] * y[1] - cos(y[0]))


PIECES, START = (("q", 1), ("p", 1)), np.array([0.5, 0.3])
PENDULUM = gi.Problem("pendulum", PIECES, [1.0], field=pendulum, invariants={"energy": energy})


def solved(problem: gi.Problem, method: Any, **options: Any) -> Callable:
    """Return the end of a run, and what was observed."""
    run = {"t_end": 0.5, "step": 0.125, "method": method, "progress": False, **options}

    def entry(compiled: bool) -> Any:
        sol = gi.solve(problem, START, **run, compiled=compiled)
        return [*sol.y[-1], *(d.final_error for d in sol.drift.values())]

    return entry


def mapped(compiled: bool) -> Any:
    """Map a point."""
    return gi.pointwise(pendulum, [1.0], START, 2) if compiled else gi.derivative(PENDULUM, START)


CIRCLING = gi.Problem("circle", PIECES, [1.0], circle, invariants={"energy": energy})
ENTRIES = {
    "explicit": solved(PENDULUM, "rk-4"),
    "lanes": solved(PENDULUM, "gauss-2"),
    "observable": solved(CIRCLING, "rk-4", observe="invariants"),
    "pointwise": mapped,
}


def changed(entry: Callable[[bool], Any], change: Callable[[], None]) -> None:
    """Check an entry before and after a change."""
    before = entry(True)
    change()
    after = entry(True)
    np.testing.assert_array_equal(after, entry(False))
    assert not np.array_equal(before, after)


@pytest.mark.filterwarnings("ignore::geomint.DeclarationWarning")
@pytest.mark.parametrize("name", ENTRIES)
def test_every_entry_takes_the_new_number(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the bits of plain Python, which always does."""
    changed(ENTRIES[name], lambda: monkeypatch.setitem(globals(), "GAIN", 2.25))


def test_contents_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """An array that is changed in place, a helper that is defined anew."""

    def put() -> None:
        TABLE[0] = 2.0

    try:
        changed(ENTRIES["lanes"], put)
    finally:
        TABLE[0] = 1.5
    other = gi.helper(lambda x: 0.75 * x)
    changed(ENTRIES["explicit"], lambda: monkeypatch.setitem(globals(), "gain", other))


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore::geomint.DeclarationWarning")  # its energy does not change
def test_lanes_are_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A field that takes eight numbers, then one, then eight."""
    lanes, one = gain, gi.helper(lambda x: 2.0 * x if x > 0.0 else 2.5 * x)
    ENTRIES["lanes"](True)
    monkeypatch.setitem(globals(), "gain", one)
    with pytest.warns(gi.GeomintWarning, match="takes one number at a time"):
        first = ENTRIES["lanes"](True)
    np.testing.assert_array_equal(first, ENTRIES["lanes"](False))
    monkeypatch.setitem(globals(), "gain", lanes)
    np.testing.assert_array_equal(ENTRIES["lanes"](True), ENTRIES["lanes"](False))


RATE = 1.0


@gi.field
def rising(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = RATE * y[0]


def test_a_remembered_derivative_follows(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check of a declaration leaves a derivative, which the default step takes: of now."""
    problem = gi.Problem("rising", (("y", 1),), field=rising)
    steps = []
    for rate in (1.0, 100.0):
        monkeypatch.setitem(globals(), "RATE", rate)
        run = gi.solve(problem, [1.0], t_end=0.5, method="rk-4", compiled=False)
        assert gi.derivative(problem, np.array([1.0])) == [rate]
        steps.append(run.step)
    assert steps[1] < 0.02 * steps[0]
