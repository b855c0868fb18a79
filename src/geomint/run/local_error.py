"""Local errors of a run: where a step errs most, by how much, and what all of them err by.

Kernels rank steps (`geomint.kernels.solve.ranks`); errors are measured where a step is the worst so
far. From the state there the stretch of the window is run again, in the run's steps and in shorter
ones, which by their order err a known part as much (L. F. Richardson): 3 for every 2 of them, behind a
first one that is shorter still. Halves would see what repeats itself from step to step as the run's own
steps do, and those of 2/3 alone a jump behind a common time: both err by it alike. Errors of other
steps follow from their numbers.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..kernels.numbers.blocks import scalar_block
from ..kernels.numbers.lanes import LANES
from ..kernels.solve.ranks import MARKS, SATURATED, ranks_layout
from ..kernels.solve.status import OK
from ..methods.method import Method
from ..methods.partial import rounding
from ..methods.stepper import NOTHING

if TYPE_CHECKING:
    from .integrator import Integrator
    from .second import Second

__all__ = ["COARSE", "DOUBT", "FINE", "SURE", "EndError", "LocalError", "Ranked", "promised"]

PROMISED = ((7, 1e-9), (4, 1e-7), (2, 1e-3), (1, 1e-2))  # of methods of that order, and higher ones
DOUBT = 12.0  # times as much is no reason to begin anew: local errors are known to a factor of ten
SURE = 0.1  # of a limit: what one measurement shows is known to be less

COARSE, FINE = 2, 3  # steps of both runs from one meeting to the next
FIRST = 0.283  # of a step: the first of the shorter ones, so that none are alike about a jump
LONGEST = 9  # order of differences
FEW, MANY, LEAST, PEAK = 0.5, 6, 0.1, 300.0  # parts of all numbers in one step: see `concentrated`
FAR = 0.3  # of the largest number: steps that have less tell nothing of the worst


def promised(method: Method) -> float:
    """Return what each step of a run may err by whose step is not given."""
    return method.step_fraction * next(e for order, e in PROMISED if method.order >= order)


class LocalError(NamedTuple):
    """What steps err by, each from the state where it begins.

    Attributes
    ----------
    largest : float
        Of a step: of a number, relative to the largest of its piece. Infinite where shorter steps fail.
    time : float
        Where, in the problem's own time.
    total : float
        The sum over the run.
    step : float
        The length of a step, that of the run where it is one alone.
    """

    largest: float
    time: float
    total: float
    step: float


class EndError(NamedTuple):
    """What a second run says of the end.

    Attributes
    ----------
    error : float
        Of the state at the end, relative to the largest number of each piece, to a factor of three.
    until : float
        Up to which time it is less than what was wanted, about; as the end is given, or the end itself.
    grown : float
        How many times those of steps have grown on the way; 1 where the end is as wanted.
    """

    error: float
    until: float
    grown: float


class Ranked:
    """The steps of a run, ranked while it goes on; errors are measured when they are asked for."""

    def __init__(self, integrator: Integrator) -> None:
        stepper, state = integrator.stepper, integrator.state
        self._integrator, self._start, self._first = integrator, state, integrator.done
        self.second: Second | None = None
        self.compiled = stepper.compiled
        self.end, self.final = integrator.time, stepper.state  # with the clock, where there is one
        self.window = 2 if stepper.ranked else min(integrator.method.order + 1, LONGEST)
        self.power = 2.0 if stepper.ranked else 1.0
        template, self._places = _template(self.window, self.power, stepper.rows)
        integrator._ranks = self.block = scalar_block(len(template))
        numbers, ring = self.block.data, self._places["ring"].start
        numbers[:] = template
        numbers[ring : ring + stepper.rows] = stepper.state
        sizes, inverse = list(map(abs, state.tolist())), list[float]()
        whole, first = max(sizes) or 1.0, self._places["inverse"].start
        for piece in integrator.problem.slices.values():
            size = max(sizes[piece]) or whole
            inverse += (piece.stop - piece.start) * [1.0 / size]
        numbers[first : first + len(inverse)] = inverse

    def part(self, name: str) -> Array:
        """Return what is known, a view."""
        return self.block.data[self._places[name]]

    def number(self, name: str) -> float:
        """Return what is known, where that is one number."""
        return float(self.block.data[self._places[name].start])

    @property
    def places(self) -> list[tuple[float, Array]]:
        """Times and states where the run began, of records, and where it ended."""
        stepper, size = self._integrator.stepper, len(self._start)
        count = min(int(self.number("records")), MARKS)
        ats, marks = self.part("ats"), self.part("marks").reshape(MARKS, -1)
        found = [(stepper.time_after(self._first), self._start)]
        found += [
            (stepper.time_after(int(ats[k]) - self.window), marks[k, :size].copy())
            for k in range(count)
        ]
        return [*found, (self.end, self.final[:size])]

    @property
    def concentrated(self) -> bool:
        """Whether few steps make most of the errors: one a half, or a tenth and 300 times the mean."""
        part = self.number("largest") ** self.power / max(self.number("total"), 1e-300)
        done = self._integrator.done
        return done > MANY and part > min(FEW, max(LEAST, PEAK / done))

    def measured(self, most: int = MARKS) -> LocalError:
        """Return the errors, measured at so many of the last records."""
        count, largest = int(self.number("records")), self.number("largest")
        if count == 0:
            return self._whole()
        numbers, ats, marks = self.part("numbers"), self.part("ats"), self.part("marks")
        window = self.window + self.window % COARSE
        looks = [k % MARKS for k in range(max(count - min(most, MARKS), 0), count)]
        found = [(float(numbers[k]), int(ats[k]), marks.reshape(MARKS, -1)[k]) for k in looks]
        own = self.number("own")
        if own >= SATURATED and self.power > 1.0:  # numbers rank no more: it may get faster
            oldest = (int(self.number("slot")) + 1) % (self.window + 1)
            ring = self.part("ring").reshape(self.window + 1, -1)[oldest]
            found.append((max(2.0 * own, FAR * largest), self._integrator.done, ring))
        worst, factor, time = 0.0, 0.0, 0.0
        for number, at, state in reversed(found):
            if number < FAR * largest:
                break
            begin = self._integrator.stepper.time_after(at - self.window)
            error = self._error(state[: len(self._start)], begin, abs(self._integrator.h), window)
            factor = max(factor, error / number**self.power)
            if error >= worst:
                worst, time = error, begin
        # Of one step, which may err as much as all in its window, or as every one of them.
        most_of_one = factor * largest**self.power / math.sqrt(window)
        last, begin = self._last
        if last > most_of_one:
            most_of_one, time = last, begin
        total = factor * self.number("total") / window + last
        return LocalError(most_of_one, time, total, abs(self._integrator.h))

    @functools.cached_property
    def _last(self) -> tuple[float, float]:
        """What a last partial step errs by, and where it begins: it is not among those of the ranks."""
        begin, state = self._integrator.time, self._integrator.state
        rest = self.end - begin
        if not rounding(self.end) < math.copysign(rest, self._integrator.h * rest):
            return 0.0, begin
        return self._error(state, begin, abs(rest), 1), begin

    @functools.cached_property
    def error(self) -> LocalError:
        """The errors."""
        return self.measured()

    @functools.cached_property
    def rough(self) -> LocalError:
        """The errors, measured where the worst step is alone."""
        return self.measured(1)

    def __reduce__(self) -> Any:
        return LocalError, tuple(self.error)

    def _whole(self) -> LocalError:
        """Return the errors of a run of fewer steps than a window has."""
        begin = self._integrator.stepper.time_after(self._first)
        span = abs(self.end - begin)
        count = max(1, round(span / abs(self._integrator.h)))
        error = self._error(self._start, begin, span / count, count) if span else 0.0
        return LocalError(error / math.sqrt(count), begin, error, span / count)

    def _error(self, y: Array, t: float, h: float, steps: int) -> float:
        """Return what so many steps from a state err by, as far as shorter ones over the time tell."""
        made, many, ends = self._integrator, max(steps * FINE // COARSE, 1), list[Array]()
        single, shorter = made.stepper.aside, (steps - FIRST) * h / many
        for parts in (((h, steps),), ((FIRST * h, 1), (shorter, many))):
            state, begin = y, t
            for length, count in parts:
                length = math.copysign(length, made.h)
                single.begin(state, begin, length)
                if single.advance(0, count, count + 1, NOTHING).status != OK:
                    return math.inf
                state, begin = single.state[: len(y)].copy(), begin + count * length
            ends.append(state)
        power = made.method.order + 1
        left = (FIRST**power + many * (shorter / h) ** power) / steps
        largest, error = np.maximum(abs(y), abs(ends[1])), abs(ends[0] - ends[1])
        whole = float(largest.max()) or 1.0
        worst = max(
            float(error[p].max() / (largest[p].max() or whole))
            for p in made.problem.slices.values()
        )
        worst /= 1.0 - left
        return worst if worst < math.inf else math.inf


@functools.cache
def _template(window: int, power: float, rows: int) -> tuple[Array, dict[str, slice]]:
    """Return what is known before the first step, and where each part of it lies."""
    layout = ranks_layout(window, -(-rows // LANES))
    ends = np.cumsum([0, *layout]).tolist()
    places = {name: slice(*ends[i : i + 2]) for i, name in enumerate(layout._fields)}
    template = np.zeros(ends[-1])
    given: dict[str, Any] = {"window": window, "rows": rows, "power": power, "missing": window - 1}
    given["weights"] = 2 * [(-1) ** k * math.comb(window, k) for k in range(window + 1)]
    for name, value in given.items():
        template[places[name]] = value
    return template, places
