"""Saved states: those of every so many steps and those at wanted times, brought together."""

from __future__ import annotations

import numpy as np

from ..arguments import Array

__all__ = ["State", "merged", "rounding"]

State = tuple[float, Array]  # in the problem's own time; with the clock's row where there is one


def rounding(time: Array | float) -> Array:
    """Return how far apart two times may be that are meant to be the same."""
    return np.asarray(4 * np.spacing(np.abs(time)))


def merged(steps: list[State], asked: list[State], sign: float, clock: bool) -> list[State]:
    """Return all states in the order of the run, each once.

    A wanted time within rounding of a saved step is that step: it keeps the time that was asked for,
    and the state of the run.

    Parameters
    ----------
    steps, asked : list of State
        Those of steps, and those at wanted times; each in the order of the run.
    sign : float
        Of the direction of the run.
    clock : bool
        Whether the last row of a state is physical time, which is then what times mean.
    """

    def time_of(entry: State) -> float:
        return float(entry[1][-1]) if clock else entry[0]

    asked = list({time_of(entry): entry for entry in asked}.values())
    if not steps or not asked:
        return [*steps, *asked]
    known = np.array([time_of(entry) for entry in steps])
    wanted = np.array([time_of(entry) for entry in asked])
    after = np.clip(np.searchsorted(sign * known, sign * wanted), 0, len(known) - 1)
    before = np.maximum(after - 1, 0)
    nearer = np.abs(known[before] - wanted) < np.abs(known[after] - wanted)
    nearest = np.where(nearer, before, after)
    same = np.abs(known[nearest] - wanted) <= rounding(wanted)
    for i in np.flatnonzero(same):
        asked[i] = _renamed(steps[nearest[i]], float(wanted[i]), clock)
    met = set(nearest[same].tolist())
    others = [entry for i, entry in enumerate(steps) if i not in met]
    return sorted([*others, *asked], key=lambda entry: sign * time_of(entry))


def _renamed(entry: State, time: float, clock: bool) -> State:
    if not clock:
        return time, entry[1]
    return entry[0], np.append(entry[1][:-1], time)
