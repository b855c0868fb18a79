"""Samples of a stretch of a run, for pictures of the motion: so dense that lines may join them, or not.

A line between samples is a picture of the motion only where it is near the motion. So what a run keeps
is asked for more and more states until it is (`DenseOutput`: real steps of the method); and saved
states that are too far apart are points, of which pictures say so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array, Integers, as_array
from ..errors import DomainError
from ..problems.problem import Time
from .variables import time_of

if TYPE_CHECKING:
    from .dense import Output
    from .solution import Solution

NEAR = 1.0 / 1000.0  # of the range of a piece: as far as a joining line may be from the motion
MOST = 8_000  # samples of a picture: some hundred turns
FEW_STEPS = 50_000  # of a run: states after them are looked at for lines
COARSE = 400  # intervals of a stretch to begin with
TRIED = 512  # of them, by which their length is found
FINEST = 1.0 / 16.0  # of a step: a method's step resolves its motion
BETWEEN = 0.381966  # where lines are checked: no part of a period
STILL = 1e-9  # of its size: what moves less is taken for constant


@dataclass(frozen=True)
class Stretch:
    """Samples of a motion.

    Attributes
    ----------
    time : ``"t"`` or ``"tau"``
        The time of `times`.
    times : array, shape (N,)
    own : array, shape (N,)
        The problem's own times.
    states : array, shape (N, rows)
    joined : bool
        Whether lines between them are the motion, to a thousandth of what is seen.
    note : str
        What was left out, for the picture.
    """

    time: Time
    times: Array
    own: Array
    states: Array
    joined: bool
    note: str = ""

    def lifted(self, lift: Callable[[Array], Array]) -> Stretch:
        """Return the same motion in other states, which a map of states gives."""
        return replace(self, states=lift(self.states))


def stretch_of(solution: Solution, span: Any = None) -> Stretch:
    """Return samples of a run between two times, by default of all of it or of its beginning.

    Raises
    ------
    DomainError
        For a span outside of the run, and a run that has fewer than two states there.
    MissingCodeError
        Of a loaded run that kept its steps, if they cannot be taken again without a pickle.
    """
    time = time_of(solution)
    if solution.kept is not None:
        solution.code("about"), solution.code("by")  # else `sol` would unpickle them
        return _of_dense(solution, time, span)
    return _of_saved(solution, time, span)


def with_times(solution: Solution, stretch: Stretch, times: Array) -> tuple[Stretch, Integers]:
    """Return a stretch that has states at further times in its order, and which of its rows they are.

    Of a run that has no dense output the stretch itself, and the states nearest to these times.
    """
    sign = 1.0 if stretch.times[-1] >= stretch.times[0] else -1.0
    if solution.kept is not None:
        every = sign * np.unique(sign * np.concatenate((stretch.times, times)))
        stretch = _samples(solution, stretch.time, every, stretch.note)
    known = sign * stretch.times
    after = np.clip(np.searchsorted(known, sign * times), 1, len(known) - 1)
    nearer = np.abs(known[after - 1] - sign * times) <= np.abs(known[after] - sign * times)
    return stretch, after - nearer


def _dense(solution: Solution, time: Time) -> Callable[[Array], Array]:
    """Return what gives the states at times of that name."""
    output = solution.sol
    return lambda times: output(**{time: times})


def _span(given: Any, first: float, last: float, time: Time) -> tuple[float, float]:
    """Return the beginning and the end of a stretch in the order of the run."""
    if given is None:
        return first, last
    expected = f"two times within the run, {time} = {first:.9g} … {last:.9g}"
    pair = as_array("span", given, expected)
    low, high = sorted((first, last))
    if pair.shape != (2,) or not ((pair >= low) & (pair <= high)).all() or pair[0] == pair[1]:
        raise DomainError("span", given, expected)
    begin, end = sorted(pair.tolist(), reverse=last < first)
    return begin, end


def _of_dense(solution: Solution, time: Time, span: Any) -> Stretch:
    kept = solution.kept
    assert kept is not None
    output = solution.sol
    known = output.states[:, -1] if time == "t" and output.clock else output.times
    first, last = float(known[0]), float(known[-1])
    if first == last:
        raise DomainError("span", span, "a run that has taken a step")
    begin, end = _span(span, first, last, time)
    if span is None and 5 <= len(output.times) <= FEW_STEPS:
        by_steps = _of_steps(output, time, known)
        if by_steps is not None:
            return by_steps
    at = _dense(solution, time)
    length = abs(end - begin)
    spacing = length / COARSE
    smallest = abs(solution.step_sizes.min) or spacing
    if time == "t" and output.clock:
        smallest *= abs((last - first) / (output.times[-1] - output.times[0]))
    while True:
        count = int(np.ceil(length / spacing * (1.0 - 1e-9)))
        shown = min(count, MOST)
        whole = shown == count
        tried = min(shown, TRIED)
        fine = spacing <= FINEST * smallest
        if fine or all(_near(at, begin, end, length, spacing, n) for n in {tried, shown}):
            break
        spacing *= 0.5
    times = _grid(begin, end, length, spacing, shown)
    note = "" if whole else f"the first {shown * spacing / length:.2g} of it"
    return _samples(solution, time, times, note)


def _of_steps(output: Output, time: Time, known: Array) -> Stretch | None:
    """Return the states after steps, at `known` times, if lines may join them: nothing is searched."""
    rows = output.problem.rows
    chosen = _thinned(known, output.states[:, :rows], np.arange(len(known)))
    if chosen is None or len(chosen) > MOST:
        return None
    return Stretch(time, known[chosen], output.times[chosen], output.states[chosen, :rows], True)


def _thinned(times: Array, states: Array, rows: Integers) -> Any:
    """Return as few of the rows as lines may join, or None where all of them are too few."""
    if not _joined(times[rows], states[rows]):
        return None
    while len(rows) > COARSE:
        fewer = np.unique(np.append(rows[::2], rows[-1]))
        if not _joined(times[fewer], states[fewer]):
            break
        rows = fewer
    return rows


def _samples(solution: Solution, time: Time, times: Array, note: str = "") -> Stretch:
    """Return the states at times of a run that has dense output."""
    output = solution.sol
    own = output.own_times(times) if time == "t" and output.clock else times
    return Stretch(time, times, own, _dense(solution, time)(times), True, note)


def _grid(begin: float, end: float, length: float, spacing: float, count: int) -> Array:
    """Return the ends of so many intervals from the beginning on, the last within the run."""
    parts = np.minimum(spacing / length * np.arange(count + 1), 1.0)
    return begin + (end - begin) * parts


def _near(
    at: Callable[[Array], Array],
    begin: float,
    end: float,
    length: float,
    spacing: float,
    count: int,
) -> bool:
    """Tell whether lines between samples are near the motion, at a place between them."""
    times = _grid(begin, end, length, spacing, count)
    states = at(times)
    between = times[:-1] + BETWEEN * np.diff(times)
    lines = states[:-1] + BETWEEN * np.diff(states, axis=0)
    there = at(between)
    off = np.abs(there - lines).max(axis=0, initial=0.0)
    return bool((off <= NEAR * _ranges(np.concatenate((states, there)))).all())


def _ranges(states: Array) -> Array:
    """Return how far each number goes; of one that is constant but for rounding, its size."""
    reach = states.max(axis=0) - states.min(axis=0)
    size = np.abs(states).max(axis=0)
    return np.where(reach > STILL * size, reach, np.maximum(size, 1e-300) / NEAR)


def _of_saved(solution: Solution, time: Time, span: Any) -> Stretch:
    known = solution.tau if time == "tau" else solution.t
    more = "a run with states on the way: dense=True, save_every=… or t_eval=… in solve"
    if len(known) < 2 or known[0] == known[-1]:
        raise DomainError("states", len(known), more)
    low, high = sorted(_span(span, float(known[0]), float(known[-1]), time))
    rows = np.flatnonzero((known >= low) & (known <= high))
    if len(rows) < 2:
        raise DomainError("span", span, more)
    fewer = _thinned(known, solution.y, rows)
    joined = fewer is not None
    rows = fewer if joined else rows
    note, count = "", len(rows)
    if joined and count > MOST:
        rows, note = rows[:MOST], f"the first {MOST / count:.2g} of it"
    elif not joined:
        rows = rows[:: -(-count // MOST)]
        left = "" if len(rows) == count else f" of {count}"
        note = f"{len(rows)}{left} saved states, too far apart for a curve"
    return Stretch(time, known[rows], solution.tau[rows], solution.y[rows], joined, note)


def _joined(times: Array, states: Array) -> bool:
    """Tell whether lines between saved states are near the motion.

    A line over two intervals is four times as far away as one over one.
    """
    if len(times) < 5:
        return False
    before, here, after = times[:-2], times[1:-1], times[2:]
    part = ((here - before) / np.where(after == before, 1.0, after - before))[:, None]
    off = np.abs(states[:-2] + part * (states[2:] - states[:-2]) - states[1:-1])
    return bool((off.max(axis=0) <= 4.0 * NEAR * _ranges(states)).all())
