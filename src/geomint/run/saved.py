"""Saved states: those of every so many steps and those at wanted times, brought together."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..methods.partial import rounding


class Saved(NamedTuple):
    """States, one a row, with the clock's row where there is one, and the problem's own times."""

    times: Array
    states: Array

    @classmethod
    def joined(cls, parts: list[Saved], rows: int) -> Saved:
        """Return all of them, one after the other."""
        if not parts:
            return cls(np.zeros(0), np.zeros((0, rows)))
        return cls(np.concatenate([p.times for p in parts]), np.vstack([p.states for p in parts]))

    def of(self, which: Any) -> Saved:
        """Return some of them."""
        return Saved(self.times[which], self.states[which])


def merged(steps: Saved, asked: Saved, sign: float, clock: bool) -> Saved:
    """Return all states in the order of the run, each once.

    A wanted time within rounding of a saved step is that step: it keeps the time that was asked for,
    and the state of the run.

    Parameters
    ----------
    steps, asked : Saved
        Those of steps, and those at wanted times; each in the order of the run.
    sign : float
        Of the direction of the run.
    clock : bool
        Whether wanted times are those of the clock.
    """

    def key(saved: Saved) -> Array:
        return saved.states[:, -1] if clock else saved.times

    wanted = key(asked)
    asked = asked.of(np.append(wanted[1:] != wanted[:-1], np.ones(min(len(wanted), 1), dtype=bool)))
    known, wanted = key(steps), key(asked).copy()
    if not len(known) or not len(wanted):
        return steps if len(known) else asked
    after = np.clip(np.searchsorted(sign * known, sign * wanted), 0, len(known) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.abs(known[before] - wanted) < np.abs(known[after] - wanted)
    nearest = np.where(nearer, before, after)
    same = np.abs(known[nearest] - wanted) <= rounding(wanted)
    met = nearest[same]
    asked.states[same] = steps.states[met]
    if clock:
        asked.times[same], asked.states[same, -1] = steps.times[met], wanted[same]
    others = steps.of(np.setdiff1d(np.arange(len(known)), met))
    everything = Saved.joined([others, asked], steps.states.shape[1])
    return everything.of(np.argsort(sign * key(everything), kind="stable"))
