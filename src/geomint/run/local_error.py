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
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..errors import StepWarning, tell
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.numbers.lanes import LANES
from ..kernels.solve.ranks import MARKS, SATURATED, ranks_layout
from ..kernels.solve.status import OK
from ..kernels.solve.trial import STRETCHES
from ..methods.method import Method
from ..methods.partial import beside, rounding

if TYPE_CHECKING:
    from .integrator import Integrator
    from .second import Second

PROMISED = ((7, 1e-9), (4, 1e-7), (2, 1e-3), (1, 1e-2))  # of methods of that order, and higher ones
DOUBT = 12.0  # times as much is no reason to begin anew: local errors are known to a factor of ten
SHORTER = "give a shorter one, such as geomint.solve takes with a tolerance"
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


def tell_errors(error: LocalError, time: str, do: str = SHORTER) -> None:
    """Warn of steps that err by more than is promised; `time` is the name of the problem's own."""
    known = error.largest < math.inf
    much = f"{error.largest:.2g} of a piece of the state" if known else "more than can be measured"
    text = (
        f"steps of {error.step:.3g} err by {much}, near "
        f"{time} = {error.time:.6g}: more than is promised where no step is given; {do}"
    )
    tell(StepWarning(text, "state", error.largest, error.time))


class Ranked:
    """The steps of a run, ranked while it goes on; errors are measured when they are asked for."""

    def __init__(self, integrator: Integrator) -> None:
        stepper, state = integrator.stepper, integrator.state
        self._integrator, self._start, self._first = integrator, state, integrator.time
        self._begun, self._longest = state, 0.0  # the stretch that it is in; steps of those before
        self._known: dict[int, tuple[float, float, int]] = {}  # of records before it: see `_place`
        self._short: list[tuple[Array, float, float, int]] = []  # stretches without ranks
        self.second: Second | None = None
        self.compiled = stepper.compiled
        self.end, self.final = integrator.time, stepper.state  # with the clock, where there is one
        self.window = 2 if stepper.flow.ranked else min(integrator.method.order + 1, LONGEST)
        self.power = 2.0 if stepper.flow.ranked else 1.0
        template, self._places = _template(self.window, self.power, stepper.rows)
        integrator._ranks = self.block = scalar_block(len(template))
        numbers, ring = self.block.data, self._places["ring"].start
        numbers[:] = template
        numbers[ring : ring + stepper.rows] = stepper.state
        sizes, inverse = list(map(abs, state.tolist())), list[float]()
        whole, first = max(sizes) or 1.0, self._places["inverse"].start
        for piece in integrator.problem.slices.values():  # in half of the time of arrays
            inverse += (piece.stop - piece.start) * [1.0 / (max(sizes[piece]) or whole)]
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
        size, count = len(self._start), int(self.number("records"))
        marks = self.part("marks").reshape(MARKS, -1)[:, :size]
        looks = range(max(count - MARKS, 0), count)
        found = [(self._place(k)[0], marks[k % MARKS].copy()) for k in looks]
        return [(self._first, self._start), *found, (self.end, self.final[:size])]

    def _place(self, record: int) -> tuple[float, float, int]:
        """Return where the steps of a record begin, their length, and how many are run again."""
        return self._known.get(record) or self._steps_to(int(self.part("ats")[record % MARKS]))

    def _steps_to(self, at: int) -> tuple[float, float, int]:
        made, first = self._integrator, at - self.window
        steps = min(self.window + self.window % COARSE, made.done - first)
        return made.stepper.time_after(first), abs(made.h), steps

    def go_on(self) -> None:
        """Know that the integrator begins anew behind a break: no window has steps from before it."""
        made, count = self._integrator, int(self.number("records"))
        self._known = {k: self._place(k) for k in range(max(count - MARKS, 0), count)}
        self._short, self._begun = self._unranked_stretches, made.state
        self._longest = max(self._longest, abs(made.h))
        self.part("missing")[0] = self.window

    @property
    def _unranked_stretches(self) -> list[tuple[Array, float, float, int]]:
        """States where stretches begin that are shorter than a window, times, steps."""
        made = self._integrator
        here = (self._begun, made.stepper.t0, abs(made.h), made.done)
        return [*self._short, here] if made.done < self.window else self._short

    @property
    def concentrated(self) -> bool:
        """Whether few steps make most of the errors: one a half, or a tenth and 300 times the mean."""
        part = self.number("largest") ** self.power / max(self.number("total"), 1e-300)
        done = self._integrator.steps
        return done > MANY and part > min(FEW, max(LEAST, PEAK / done))

    def measured(self, most: int = MARKS) -> LocalError:
        """Return the errors, measured at so many of the last records."""
        count, largest = int(self.number("records")), self.number("largest")
        if count == 0 and self._begun is self._start:
            return self._whole()
        numbers, marks = self.part("numbers"), self.part("marks").reshape(MARKS, -1)
        window, own = self.window + self.window % COARSE, self.number("own")
        looks = range(max(count - min(most, MARKS), 0), count)
        ranked = [(float(numbers[k % MARKS]), self._place(k), marks[k % MARKS]) for k in looks]
        found, done = [one for one in ranked if one[1][2] > 0], self._integrator.done
        if len(found) < len(ranked):  # an event has ended the run before some of them
            if not found:
                return self._whole()
            largest = max(number for number, _, _ in found)
        if own >= SATURATED and self.power > 1.0 and done >= self.window:
            # numbers rank no more: it may get faster
            oldest = (int(self.number("slot")) + 1) % (self.window + 1)
            ring = self.part("ring").reshape(self.window + 1, -1)[oldest]
            found.append((max(2.0 * own, FAR * largest), self._steps_to(done), ring))
        worst, factor, first, time = 0.0, 0.0, 0.0, 0.0
        for number, (begin, h, steps), state in reversed(found):
            if number < FAR * largest:
                break
            y = state[: len(self._start)]
            of_one, error = self._errors(y, begin, h, steps)
            if most > 1:
                of_one = max(of_one, self._on_the_way(y, begin, h, steps))
            error, first = max(error, of_one), max(first, of_one)
            factor = max(factor, error / (number**self.power or math.inf))  # 0: underflown
            if error >= worst:
                worst, time = error, begin
        # Of one step, which may err as much as all in its window, or as every one of them.
        most_of_one = max(factor * largest**self.power / math.sqrt(window), first)
        total = factor * self.number("total") / window
        for error, count, begin in self._unranked:
            total += error
            if error > most_of_one * math.sqrt(count):
                most_of_one, time = error / math.sqrt(count), begin
        return LocalError(most_of_one, time, total, max(self._longest, abs(self._integrator.h)))

    def _on_the_way(self, y: Array, t: float, h: float, steps: int) -> float:
        """Return what the worst of so many steps errs by: at the end of all it may be less again."""
        count, h = steps // COARSE, math.copysign(h, self._integrator.h)
        found = self._stretches(y, t, count * [h], count * [COARSE])
        ends = enumerate([] if found is None else found[0][:-1], 1)
        return max(
            (self._errors(y, t + COARSE * k * h, h, COARSE)[0] for k, y in ends), default=0.0
        )

    @functools.cached_property
    def _unranked(self) -> list[tuple[float, int, float]]:
        """What steps err by that have no ranks, how many they are, and where they begin.

        A last partial one, and those of stretches between breaks that are shorter than a window.
        """
        made, state, begin = self._integrator, self._integrator.state, self._integrator.time
        rest, found = self.end - begin, list[tuple[Array, float, float, int]]()
        if self._begun is not self._start:
            found += self._unranked_stretches
        if rounding(self.end) < math.copysign(rest, made.h * rest):
            found.append((state, begin, abs(rest), 1))
        return [(self._errors(y, t, h, count)[1], count, t) for y, t, h, count in found if count]

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
        begin = self._first
        span = abs(self.end - begin)
        count = max(1, round(span / abs(self._integrator.h)))
        one, error = self._errors(self._start, begin, span / count, count) if span else (0.0, 0.0)
        return LocalError(max(error / math.sqrt(count), one), begin, error, span / count)

    def _errors(self, y: Array, t: float, h: float, steps: int) -> tuple[float, float]:
        """Return what a step from a state errs by, and so many, as far as shorter ones tell.

        What the first ones err by may have become small at the end of all.
        """
        near, power = min(COARSE, steps), self._integrator.method.order + 1
        rest, few = steps - near, max(near * FINE // COARSE, 1)
        many = max(rest * FINE // COARSE, 1)
        lengths, counts = (FIRST, (near - FIRST) / few, rest / many), (1, few, many if rest else 0)
        given = [h, h, *(h * length for length in lengths)], [near, rest, *counts]
        found = self._stretches(y, t, *given, again=2, compared=2)
        if found is None:
            return math.inf, math.inf
        left = [n * length**power for n, length in zip(counts, lengths, strict=True)]
        one, every = (error if error < math.inf else math.inf for error in found[1].tolist())
        one, every = one / (1.0 - sum(left[:2]) / near), every / (1.0 - sum(left) / steps)
        return one / math.sqrt(near), every

    def _stretches(
        self,
        y: Array,
        t: float,
        lengths: Sequence[float],
        counts: Sequence[int],
        again: int = -1,
        compared: int = 0,
    ) -> tuple[Array, Array] | None:
        """Return the states after stretches of so many steps, and how far some are apart, or None.

        See `geomint.kernels.solve.trial.stretches`; None where one fails.
        """
        n = len(y)
        out, errors = np.empty(n * len(counts)), np.empty(compared)
        found = beside(
            self._integrator.stepper.aside,
            STRETCHES,
            t=t,
            lengths=Block(np.copysign(lengths, self._integrator.h)),
            counts=Block(np.array(counts, dtype=np.float64)),
            again=again,
            y0=Block(y),
            out=Block(out),
            sizes=Block(np.empty(n)),
            errors=Block(errors),
        )
        return (out.reshape(-1, n), errors) if found.status == OK else None


@functools.cache
def _template(window: int, power: float, rows: int) -> tuple[Array, dict[str, slice]]:
    """Return what is known before the first step, and where each part of it lies."""
    layout = ranks_layout(window, -(-rows // LANES))
    ends = np.cumsum([0, *layout]).tolist()
    places = {name: slice(*ends[i : i + 2]) for i, name in enumerate(layout._fields)}
    template = np.zeros(ends[-1])
    every = window // 2 + 1 if power == 1.0 else 1  # each step is well inside of one of them
    known = (("window", window), ("rows", rows), ("every", every))
    weights = [(-1) ** k * math.comb(window, k) for k in range(window + 1)]
    for name, value in (*known, ("missing", window), ("weights", 2 * weights)):
        template[places[name]] = value
    return template, places
