"""Jumps in a series: changes of level from one window to the next.

The mean of up to 8 windows after each window is compared with that of as many before it. A jump is
where the difference, less what is usual, is 8 times what nine tenths of all places have at most, is
made within two windows, and moves on neither side by more than a quarter of it. So a random walk has
none, nor has an oscillation, an outlier, or a growth however fast.

In a noise that hides it from its neighbours a jump is the step that fits best, if without it nothing
wanders any more (`best_step`); that is for the caller to see.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import Array

SIDE, FEWEST = 8, 4  # windows
STANDS_OUT = 8.0
SHARP, MOVES = 0.6, 0.25
MOST = 3
OFF = 4.0


class Jump(NamedTuple):
    """A change of level within the window `at`; −1: before the first."""

    at: int
    size: float
    error: float


def find_jumps(series: Array, least: float) -> list[Jump]:
    """Return the jumps larger than `least`, the largest first; none if there are more than three."""
    found: list[Jump] = []
    rest = series
    for _ in range(MOST + 1):
        jump = _largest(rest, least)
        if jump is None:
            return sorted(found, key=lambda j: -abs(j.size))
        found.append(jump)
        rest = rest - steps_of([jump], rest)
    return []


def steps_of(jumps: list[Jump], series: Array) -> Array:
    """Return what jumps add to a series; of a window that holds one, all that is above before."""
    total = np.zeros(len(series))
    for jump in jumps:
        before = series[max(0, jump.at - SIDE) : jump.at].mean()
        total[jump.at + 1 :] += jump.size
        total[jump.at] += series[jump.at] - before
    return total


def first_step(series: Array, maxima: Array) -> Jump | None:
    """Return the jump before the first window: all deviations lie within a quarter of it, off 0."""
    centre = float(np.median(series))
    rest = slice(2, None)  # it may be in these
    spread = max(np.abs(series[rest] - centre).max(), maxima[rest].max() - abs(centre))
    return Jump(-1, centre, float(spread)) if abs(centre) > OFF * spread else None


def best_step(series: Array) -> Jump:
    """Return the step that leaves the least squares; of size 0 if it is not made at once."""
    n = len(series)
    places = np.arange(FEWEST, n - FEWEST)
    sums = np.cumsum(series)
    before = sums[places - 1] / places
    after = (sums[-1] - sums[places]) / (n - places - 1)
    gains = (after - before) ** 2 * places * (n - places)
    i = int(np.argmax(gains))
    at, size = int(places[i]), float(after[i] - before[i])
    sides = series[max(0, at - SIDE) : at].mean(), series[at + 1 : at + 1 + SIDE].mean()
    if abs(sides[1] - sides[0]) < SHARP * abs(size):
        return Jump(at, 0.0, 0.0)
    noise = np.concatenate([series[:at] - before[i], series[at + 1 :] - after[i]]).std()
    return Jump(at, size, float(noise * np.sqrt(1.0 / at + 1.0 / (n - at - 1))))


def _largest(series: Array, least: float) -> Jump | None:
    n = len(series)
    sums = np.concatenate(([0.0], np.cumsum(series)))
    places = np.arange(FEWEST, n - FEWEST)
    low, high = np.maximum(places - SIDE, 0), np.minimum(places + 1 + SIDE, n)
    before = (sums[places] - sums[low]) / (places - low)
    after = (sums[high] - sums[places + 1]) / (high - places - 1)
    changes = after - before
    changes -= np.median(changes)
    i = int(np.argmax(np.abs(changes)))
    size, at = float(changes[i]), int(places[i])
    others = np.abs(changes[np.abs(places - at) > SIDE])
    if abs(size) <= max(least, STANDS_OUT * float(np.quantile(others, 0.9))):
        return None
    sides = series[low[i] : at], series[at + 1 : high[i]]
    halves = [(side[: len(side) // 2], side[len(side) // 2 :]) for side in sides]
    moves = max(abs(late.mean() - early.mean()) for early, late in halves)
    sharp = abs(series[at + 1] - series[at - 1]) >= SHARP * abs(size)
    return (
        Jump(at, size, float(np.median(others))) if sharp and moves <= MOVES * abs(size) else None
    )
