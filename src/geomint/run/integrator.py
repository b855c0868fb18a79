"""An integrator to hold in the hand: a problem, a method and a state that steps move on."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..arguments import Array, as_vector, finite, piece_rows, positive, switch, whole
from ..errors import DomainError, MethodError, StepError, StepWarning, tell
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.status import OK
from ..methods import Method, find_method, find_solver
from ..methods.partial import rounding
from ..methods.stepper import NOTHING, Advance, Stepper
from ..problems.evaluate import rates_of
from ..problems.problem import Problem
from .carried_directions import PIECE, CarriedDirections, columns
from .local_error import LocalError, tell_errors
from .restart import Restart
from .timeline import MOST_STEPS, Timeline, check_advance, within
from .watched_steps import PIECE as RANKED, WatchedSteps

BATCH = 1 << 16  # steps between which Ctrl-C is seen
_COUNTED = ("steps", "iterations", "_default")
SHORTEST = 2.0**-9  # of a default step: one that fails is halved, but not below


class Integrator:
    """A state that steps move on, for loops of one's own.

    Everything that a step depends on is kept from call to call: ``step(2)`` and twice ``step()`` end in
    the same bits, which are those of `geomint.solve` with the same step. Writing `state`, `time`,
    `params` or `h` makes a new beginning, which remembers nothing of the steps before. Copies
    (`copy.copy`) and pickles go on by themselves, to the same bits. One integrator is for one thread.

    Parameters
    ----------
    problem : Problem
    state : array_like
        Flat state in the problem's documented order; `Problem.state` makes one.
    method : str or Method, optional
        Such as ``"gauss-8"`` or ``geomint.Gauss(8)``. Default: as that of `geomint.solve`.
    step : float, optional
        Length of a step in the problem's own time, > 0; that of the first of an adaptive method.
        Default: what `geomint.solve` begins with. It stays as it is, but where a step fails: from there
        it is half as long, which a warning says, as one does where steps err by more than is promised.
    time : float
        The problem's own time at the beginning.
    clock : bool
        Whether physical time is integrated beside a problem in τ, from 0.
    compiled : bool
        False runs the same kernels in plain Python, to the same bits.
    tangents : int, or array_like of shape (rows, k), optional
        Directions that are carried along, one a column: `tangents` is then the derivative of the state
        by where it began, along them. A number k stands for the first k unit vectors. Every step is
        taken once more with derivatives (`geomint.tangent_flow`); the bits of the state are the same.

    Raises
    ------
    DomainError, FormError, MethodError, DeclarationError

    Examples
    --------
    >>> import geomint as gi
    >>> from geomint.problems.testproblems import henon_heiles
    >>> motion = gi.Integrator(henon_heiles.problem(), henon_heiles.INITIAL, step=0.1)
    >>> motion.step(10)
    >>> motion.time
    1.0
    >>> motion.propagate_until(2.5)
    >>> motion.time
    2.5
    """

    __slots__ = (  # so that writing to a name that it does not have is an error
        "__weakref__",
        "_carried",
        "_default",
        "_done",
        "_first",
        "_nothing",
        "_ranks",
        "_size",
        "_watched",
        "iterations",
        "stepper",
        "steps",
    )

    def __init__(
        self,
        problem: Problem,
        state: Any,
        method: str | Method | None = None,
        *,
        step: float | None = None,
        time: float = 0.0,
        clock: bool = False,
        compiled: bool = True,
        tangents: Any = None,
    ) -> None:
        if not isinstance(problem, Problem):
            raise DomainError("problem", problem, "a geomint.Problem")
        chosen, start = find_method(find_solver(method, problem)), finite("time", time)
        y = problem.canonical(state)
        clock, compiled = switch("clock", clock), switch("compiled", compiled)
        flow, known = chosen.on(problem, y, start, clock, compiled), step is not None
        if known:
            h = positive("step", step)
        else:
            rate_at = rates_of(problem, y, compiled)
            h = chosen.default_step(problem, y, math.inf, start, rate_at)
        self._begin(flow.begin(y, start, h))
        self.prepare()
        self._default = not (known or chosen.adaptive)
        if self._default:
            self._watched = WatchedSteps(self)
        if tangents is not None:
            self.tangents = tangents
        self._first = y, start, None if tangents is None else self.tangents

    @classmethod
    def of(cls, stepper: Stepper, t0: float = 0.0, restart: Restart | None = None) -> Integrator:
        """Return the integrator of a run that has been checked; it compiles when it is prepared.

        `t0` is where physical time begins, if it is integrated.
        """
        made = cls.__new__(cls)
        made._begin(stepper)
        made._set_clock(float(t0))
        made._first = made.state, stepper.t0, None
        if restart is not None:
            made._restore(restart)
        if made.method.adaptive:  # whose limit of steps is that of a run
            made._done = 0
        return made

    _watched: WatchedSteps | None  # where nobody has given the step

    def _begin(self, stepper: Stepper) -> None:
        self.stepper, self._size, self._done = stepper, abs(stepper.h), 0
        self.steps, self.iterations = 0, 0
        self._carried: CarriedDirections | None = None
        self._nothing: Block | None = None
        self._ranks = NOTHING
        self._watched, self._default = None, False

    def prepare(self) -> None:
        """Compile, or find in the cache, what steps need, and see that it is right."""
        self.stepper.prepare()

    # --- what it is -------------------------------------------------------------------------------

    def __repr__(self) -> str:
        return (
            f"<integrator of {self.problem.name!r} by {self.method.name}: "
            f"{self.problem.time} = {self.time:.9g} after {self.steps} steps>"
        )

    @property
    def problem(self) -> Problem:
        """What is integrated, with the parameters as they are now."""
        return self.stepper.flow.problem

    @property
    def method(self) -> Method:
        """The method."""
        return self.stepper.flow.method

    @property
    def done(self) -> int:
        """Steps since the last beginning."""
        return self._done

    @property
    def time(self) -> float:
        """The problem's own time."""
        return self.stepper.time_after(self._done)

    @time.setter
    def time(self, time: float) -> None:
        self._anew(self.state, finite("time", time), self.h)

    @property
    def t(self) -> float:
        """Physical time."""
        if self.problem.time == "t":
            return self.time
        if not self.stepper.flow.clock:
            raise DomainError("clock", False, "True: physical time is not integrated")
        return float(self.stepper.state[-1])

    @property
    def h(self) -> float:
        """The step with its sign; of an adaptive method the next one that is to be tried."""
        return self.stepper.next_step

    @h.setter
    def h(self, h: float) -> None:
        if finite("h", h) == 0.0:
            raise DomainError("h", h, "a step that is not 0")
        self._watched, self._ranks, self._default = None, NOTHING, False
        self._anew(self.state, self.time, h)

    @property
    def state(self) -> Array:
        """The flat state, as a copy."""
        return self.stepper.state[: self.problem.rows].copy()

    @state.setter
    def state(self, state: Any) -> None:
        self._anew(self.problem.canonical(state), self.time, self.h)

    @property
    def tangents(self) -> Array:
        """What has become of the directions, one a column, as a copy; writing gives others."""
        if self._carried is None:
            raise DomainError("tangents", None, "tangents=… of the integrator: it carries none")
        return self._carried.slopes

    @tangents.setter
    def tangents(self, tangents: Any) -> None:
        rows = self.problem.rows
        if self.method.adaptive:
            raise MethodError(f"method {self.method.name!r} takes no steps of a given length")
        if not self.stepper.compiled:
            raise DomainError("compiled", False, "True: directions are carried by compiled code")
        if isinstance(tangents, int | np.integer) and not isinstance(tangents, bool):
            tangents = np.eye(rows)[:, : whole("tangents", tangents, 1, rows)]
        self._carried = CarriedDirections(self.stepper, columns("tangents", tangents, rows))

    def __getitem__(self, piece: str) -> Array:
        """Return a piece of the state by its name, as a copy."""
        return self.state[piece_rows(self.problem.slices, piece)]

    @property
    def params(self) -> Array:
        """The flat parameters of the problem, as a copy."""
        return np.array(self.problem.params)

    @params.setter
    def params(self, params: Any) -> None:
        given = as_vector("params", params, len(self.problem.params))
        # What plain Python knows of the parameters by itself does not know these.
        problem = replace(self.problem, params=given, parameters={}, make_exact=None, physical=None)
        state, time, known = problem.canonical(self.state), self.time, self.stepper.flow
        flow = self.method.on(problem, state, time, known.clock, known.compiled)
        stepper = flow.begin(self._with_clock(state), time, self.h)
        stepper.prepare()
        self.stepper, self._done, self._size = stepper, 0, abs(stepper.h)
        if self._carried is not None:
            self._carried = CarriedDirections(self.stepper, self._carried.slopes)

    def _anew(self, state: Array, time: float, h: float) -> None:
        """Go on from there, and remember nothing but physical time."""
        self._done = 0
        self.stepper.begin(self._with_clock(state), time, float(h))
        self._carry_on()

    def _with_clock(self, state: Array) -> Array:
        """Return a state with physical time as it is, where that is integrated."""
        return np.append(state, self.t) if self.stepper.flow.clock else state

    def _go_on(self, stretch: Timeline) -> None:
        """Begin anew with the state that there is, for another stretch; carries of sums stay."""
        stepper, carry = self.stepper, self.stepper.carry.copy()
        h = stepper.next_step if self.method.adaptive else stretch.h
        stepper.begin(stepper.state.copy(), stretch.start, h)
        stepper.carry[:] = carry
        stepper.aim(stretch.own_end or 0.0)
        if not self.method.adaptive:  # whose limit of steps is that of a run
            self._done = 0

    def _carry_on(self) -> None:
        """Let the directions begin where the state is now."""
        if self._carried is not None:
            self._carried.begin(self.stepper.memory.data[: 2 * self.stepper.rows])

    def _set_clock(self, t: float) -> None:
        if self.stepper.flow.clock:
            self.stepper.state[-1] = t

    def reset(self, state: Any = None, time: float | None = None) -> None:
        """Go back to where it was made, or to another state, and another time.

        Directions that it was made with are there again.
        """
        y, start, tangents = self._first
        y = y if state is None else self.problem.canonical(state)
        time = start if time is None else finite("time", time)
        self._anew(y, time, self._size)
        self._set_clock(0.0)
        if tangents is not None:
            self.tangents = tangents
        self.steps = self.iterations = 0

    # --- steps ------------------------------------------------------------------------------------

    def step(self, n: int = 1) -> None:
        """Take n steps.

        Raises
        ------
        DomainError
            For a number that is none, and for steps that are less than a rounding of the time.
        ConvergenceError, NonFiniteError, StepSizeError, StepLimitError
            With t, step, residual; the state is that before the step that failed.
        """
        left = whole("n", n, 0)
        if self.method.adaptive:
            self._aim(math.copysign(math.inf, self.h))
        elif left:
            check_advance(self.h, self.stepper.time_after(self._done + left))
        while left > 0:
            left -= self._some(min(left, BATCH))

    def propagate_for(self, span: float) -> None:
        """Go on for a span of the problem's own time; negative: backwards. See `propagate_until`."""
        self.propagate_until(self.time + finite("span", span))

    def propagate_until(self, time: float) -> None:
        """Go on, or back, to a time of the problem's own, which a last shorter step meets exactly.

        Raises
        ------
        DomainError
            For a time that is not finite, or 2⁵³ steps away, or so late that the step is less than
            a rounding of it.
        ConvergenceError, NonFiniteError, StepSizeError, StepLimitError
            With t, step, residual; the state is that before the step that failed.
        """
        end = finite("time", time)
        gap = end - self.time
        if gap == 0.0:
            return
        if not self.method.adaptive:
            check_advance(self.h, max(end, self.time, key=abs))
            if not abs(gap / self.h) < MOST_STEPS:
                expected = f"a time within 2⁵³ steps of {self.h:.3g} from {self.time:.9g}"
                raise DomainError("time", time, expected)
        if math.copysign(1.0, gap) != math.copysign(1.0, self.h):
            self._anew(self.state, self.time, -self.h)
        if self.method.adaptive:
            self._aim(end)
            while not self.stepper.finished:
                self._some(BATCH)
            return
        nearest = round(gap / self.h)
        met = abs(nearest * self.h - gap) <= rounding(end)
        left = nearest if met else int(gap / self.h)
        h = self.h
        self.stepper.aim(end)
        try:
            while left > 0 and self.h == h:
                left -= self._some(min(left, BATCH))
            if self.h == h:
                self._meet(end)
        finally:
            self.stepper.end = None
        if self.h != h:
            self.propagate_until(end)

    def _aim(self, end: float) -> None:
        """Let an adaptive method end there; its limit of steps is that of a call."""
        self.stepper.aim(end)
        self._done = 0

    def _meet(self, end: float) -> None:
        """Take a last shorter step to `end`, from where steps begin anew; none for a rounding."""
        here = self.time
        rest = end - here
        if abs(rest) > rounding(end):
            stepper = self.stepper
            rest = within(here, rest, end)
            try:
                y = stepper.single_step(stepper.state, here, rest, stepper.carry, self.steps)
            except StepError as error:
                self._halve(error)
                return
            if self._watched is not None:
                self._tell(self._watched.cut(end, y))
            if self._carried is not None:
                self._carried.cut(here, rest, self.steps)
            self.steps += 1
            stepper.begin(y, end, stepper.h)
            self._done = 0
            self._carry_on()
        elif rest != 0.0:
            self.stepper.move(end, self.h)
            self._done = 0

    def _some(self, count: int) -> int:
        """Take steps, or raise; return how many."""
        if self._carried is not None:
            count = min(count, PIECE)
        watched = self._watched
        if watched is not None:
            count = min(count, RANKED)
            watched.rank(count)
        asked, good = self.take(count, count + self._done + 1, self._unread)
        if self._carried is not None:
            self._carry(self._carried, good.steps, self.stepper.before)
            self._carried.follow(self.stepper.memory.data)
        if asked.status != OK:
            self._halve(self.failure(asked, good))
        elif watched is not None:
            self._tell(watched.look())
        return good.steps

    def _halve(self, error: StepError) -> None:
        """Go on with half of a default step that has failed; raise where that is of no use."""
        if not (self._default and abs(self.h) > SHORTEST * self._size):
            raise error
        tell(StepWarning(f"{error}; from there steps are half as long", time=self.time))
        self._anew(self.state, self.time, 0.5 * self.h)

    def _tell(self, error: LocalError | None) -> None:
        """Warn, once, of steps that err by more than is promised."""
        if error is not None:
            self._watched, self._ranks = None, NOTHING
            tell_errors(error, self.problem.time)

    @property
    def _unread(self) -> Block:
        """Where kernels may write a state that nobody reads."""
        if self._nothing is None:
            self._nothing = scalar_block(self.stepper.rows)
        return self._nothing

    def _carry(self, carried: CarriedDirections, count: int, mark: Any) -> None:
        """Take the last steps with directions too; where these fail, the state is with them."""
        stepper, first = self.stepper, self._done - count
        try:
            carried.take(stepper.t0, stepper.h, count, first, self.steps - self._done)
        except BaseException as error:
            self.bookmark = mark
            if isinstance(error, StepError) and error.step > self.steps:
                self.take(error.step - self.steps, count + self._done + 1, self._unread)
            raise

    def failure(self, asked: Advance, good: Advance) -> StepError:
        """Return the typed error of a `take` that failed."""
        failed = asked._replace(steps=0, iterations=asked.iterations - good.iterations)
        return self.stepper.error(failed, self._done, self.steps - self._done)

    def take(
        self, count: int, every: int, out: Block, whole: bool = False
    ) -> tuple[Advance, Advance]:
        """Take up to `count` steps, and write the state after every `every`-th since the beginning.

        `whole`: all that is remembered then, of which the state is the first.

        Returns
        -------
        asked, good
            What became of it, and of the steps that succeeded, after which the integrator is.
        """
        stepper, done = self.stepper, self._done
        stepper.before = before = self.bookmark
        try:
            asked = good = stepper.advance(done, count, every, out, whole, self._ranks)
            if asked.status != OK:  # memory may be in the middle of a composition
                self.bookmark = before
                good = stepper.advance(done, asked.steps, every, out, whole)
        except BaseException:  # Ctrl-C, seen when the kernel returns; a row that is not there
            self.bookmark = before
            raise
        self._done += good.steps
        self.steps += good.steps
        self.iterations += good.iterations
        return asked, good

    @property
    def bookmark(self) -> tuple[Array, int, int, int]:
        """Where it is; to be set again as long as nothing but steps has been taken."""
        return self.stepper.memory.data.copy(), self._done, self.steps, self.iterations

    @bookmark.setter
    def bookmark(self, mark: tuple[Array, int, int, int]) -> None:
        self.stepper.memory.data[:], self._done, self.steps, self.iterations = mark

    # --- what it depends on -----------------------------------------------------------------------

    @property
    def restart(self) -> Restart:
        """All that the next step depends on."""
        stepper = self.stepper
        memory = stepper.memory.data.copy()
        return Restart(memory, stepper.t0, stepper.h, self._done, stepper.flow.clock)

    def _restore(self, restart: Restart) -> None:
        memory = self.stepper.memory.data
        if restart.memory.shape != memory.shape:
            expected = f"that of {self.method.name}: {len(memory)} numbers"
            raise DomainError("restart", len(restart.memory), expected)
        memory[:] = restart.memory
        self._done = restart.done

    def __getstate__(self) -> dict[str, Any]:
        kept, carried = ("_size", "_first", *_COUNTED), self._carried
        flow = self.stepper.flow
        tangents = None if carried is None else (carried.slopes, carried.memories)
        own = {
            "restart": self.restart,
            "tangents": tangents,
            "watched": self._watched is not None,
            "on": (flow.method, flow.problem, flow.clock, flow.compiled),
        }
        return {**{name: getattr(self, name) for name in kept}, **own}

    def __setstate__(self, state: dict[str, Any]) -> None:
        restart, (y, _, _) = state["restart"], state["_first"]
        method, problem, *how = state["on"]
        flow = method.on(problem, y, restart.start, *how)
        self._begin(flow.begin(y, restart.start, restart.h))
        self._restore(restart)
        for name in ("_size", "_first", *_COUNTED):
            setattr(self, name, state[name])
        self._watched = WatchedSteps(self) if state["watched"] else None
        if state["tangents"] is not None:
            self.tangents, memories = state["tangents"]
            assert self._carried is not None
            self._carried.restore(memories)
