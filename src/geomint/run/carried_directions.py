"""Directions that steps carry along, eight at once: the same steps in numbers with derivatives."""

import math
from typing import Any

import numpy as np

from ..arguments import Array, as_array
from ..errors import DomainError, NonFiniteError, StepError
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.fixed_point import SMALLEST
from ..kernels.solve.status import NOT_CONVERGED, OK
from ..methods.flow import Flow
from ..methods.stepper import NO_SLOPES, Advance, Stepper
from ..methods.tangent import AT_ONCE, tangent_type

PIECE = 100  # steps after which all are where the first is, and Ctrl-C is seen


class CarriedDirections:
    """The state of a stepper with directions, moved on by steps of its own.

    Steps see each direction in a unit of its own, a power of two that makes it about as long as the
    state, so that what comes of it does not depend on its length.

    Parameters
    ----------
    stepper : Stepper
        With steps of given lengths; the state is where it is now. It is not moved.
    directions : array, shape (n, k)
        Of the first n rows of its state, one a column.
    moved : array, shape (len(params), k), optional
        How the parameters change with them.
    """

    def __init__(self, stepper: Stepper, directions: Array, moved: Array | None = None) -> None:
        self._stepper, self._shape = stepper, directions.shape
        self._units = _units(stepper.memory.data[: stepper.rows], directions)
        if moved is not None:
            self._units = np.maximum(self._units, _units(stepper.flow.params.data, moved))
            moved = np.ldexp(moved, -self._units)
        self._groups = []
        for first in range(0, directions.shape[1], AT_ONCE):
            some = slice(first, first + AT_ONCE)
            self._groups.append(_Group(stepper.flow, None if moved is None else moved[:, some]))
        self.begin(stepper.memory.data[: 2 * stepper.rows], directions)

    def begin(self, memory: Array, directions: Array | None = None) -> None:
        """Begin at a state and its carries, with other directions or those there are now."""
        slopes = np.ldexp(self.slopes if directions is None else directions, -self._units)
        for i, group in enumerate(self._groups):
            own = slopes[:, i * AT_ONCE : (i + 1) * AT_ONCE]
            group.memory[:] = 0.0
            group.memory[: len(memory), 0] = memory
            group.memory[: len(own), 1 : 1 + own.shape[1]] = own

    def follow(self, memory: Array) -> None:
        """Let the state, and its carries, be those given; slopes are what they are.

        Iterations that see other slopes end in other roundings, which chaos would make as large as the
        motion.
        """
        rows = 2 * self._stepper.rows
        for group in self._groups:
            group.memory[:rows, 0] = memory[:rows]

    @property
    def state(self) -> Array:
        """The state where the steps have led, as a copy."""
        return self._groups[0].memory[: self._stepper.rows, 0].copy()

    @property
    def slopes(self) -> Array:
        """What has become of the directions, one a column; a copy."""
        n, count = self._shape
        found = np.hstack([group.memory[:n, 1:] for group in self._groups])[:, :count]
        return np.ldexp(found, self._units)

    def take(self, t: float, h: float, steps: int, first: int = 0, before: int = 0) -> None:
        """Take steps ``first``, … of length h from time t on; `before` others were taken before t.

        Raises
        ------
        ConvergenceError, NonFiniteError, StepSizeError
            After the steps before the one that failed. After Ctrl-C none has been taken.
        """
        begin = self._stepper.last_begin(t, h, first + steps, self._stepper.end)
        if begin != t and steps > 1:
            self.take(t, h, steps - 1, first, before)
            first, steps = first + steps - 1, 1
        t, kept = begin, self.memories
        try:
            for at in range(first, first + steps, PIECE):
                begun = self.memories
                self._some(t, h, at, min(PIECE, first + steps - at), before)
                if not self._finite:
                    self.restore(begun)
                    for one in range(at, first + steps):
                        self._some(t, h, one, 1, before)
                        if not self._finite:
                            numbers = (t + one * h, before + one, math.inf, 0)
                            raise NonFiniteError(*numbers, NO_SLOPES)
        except BaseException as error:
            self.restore(kept)
            if isinstance(error, StepError):
                self.take(t, h, error.step - before - first, first, before)
            raise

    def _some(self, t: float, h: float, first: int, count: int, before: int) -> None:
        """Take a few steps with all groups, after which all are where the first is."""
        begun = self.memories
        for group in self._groups:
            done = group.take(t, h, first, count)
            if done.status == NOT_CONVERGED and self._stepper.turn(group.flow):
                for other in self._groups:
                    other.take_of(self._stepper.flow)
                self.restore(begun)
                self._some(t, h, first, count, before)
                return
            if done.status != OK:
                self.restore(begun)
                raise self._stepper.error_of_slopes(done, self.state, t, h, first, before)
        self.follow(self._groups[0].memory[:, 0])

    @property
    def _finite(self) -> bool:
        """Whether all slopes are numbers: steps look at the state alone."""
        with np.errstate(over="ignore", invalid="ignore"):
            return bool(np.isfinite(self.slopes).all())

    @property
    def memories(self) -> list[Array]:
        """All that the next step depends on, as copies; to be set again by `restore`."""
        return [self._units.copy(), *(group.memory.copy() for group in self._groups)]

    def restore(self, memories: list[Array]) -> None:
        """Be where they were taken."""
        units, *others = memories
        self._units = units.copy()
        for group, memory in zip(self._groups, others, strict=True):
            group.memory[:] = memory

    def cut(self, t: float, h: float, before: int) -> None:
        """Take one step of another length, for which nothing is remembered but the carries."""
        for group in self._groups:
            group.memory[2 * self._stepper.rows :] = 0.0
        self.take(t, h, 1, before=before)


class _Group:
    """At most eight directions, and the call that takes steps with them."""

    def __init__(self, flow: Flow, moved: Array | None) -> None:
        kind = tangent_type(flow, AT_ONCE, moved is not None)
        self._held = kind.memory.held
        params = flow.params
        if moved is not None:
            params = self._block(len(flow.params))
            rows = params.data.reshape(len(flow.params), -1)
            rows[:, 0], rows[:, 1 : 1 + moved.shape[1]] = flow.params.data, moved
        memory = self._block(flow.memory)
        self.memory = memory.data.reshape(flow.memory, -1)  # a value and slopes a row
        self._kind, self._params, self._memory = kind, params, memory
        self.take_of(flow)

    def take_of(self, flow: Flow) -> None:
        """Let steps be those of a flow."""
        self.flow = flow
        self._call = flow.bound.call(
            number_type=self._kind,
            functions=flow.functions,
            coefficients=flow.coefficients,
            fractions=flow.fractions,
            work=self._block(flow.work),
            rows=flow.rows,
            params=self._params,
            memory=self._memory,
            out=self._block(0),
        )

    def _block(self, rows: int) -> Block:
        return self._held(scalar_block(rows * self._held.width).data)

    def take(self, t: float, h: float, first: int, count: int) -> Advance:
        """Take some steps after the first ones."""
        return Advance(*self._call(t0=t, h=h, first=first, count=count, every=count + first + 1))


def _units(numbers: Array, directions: Array) -> Array:
    """Return the exponents of the powers of two that make directions about as long as the numbers.

    Of numbers below `SMALLEST`, as long as that: slopes below float64's normal range lose digits.
    """
    length, size = np.abs(directions).max(axis=0), np.abs(numbers).max(initial=0.0)
    exponents = np.frexp(length)[1] - np.frexp(max(size, SMALLEST) if size > 0.0 else 1.0)[1]
    return np.where(length > 0.0, exponents, 0)


def columns(name: str, directions: Any, rows: int) -> Array:
    """Return directions that are given, one a column."""
    expected = f"finite numbers of shape ({rows}, k), {rows} rows with a direction a column"
    found = as_array(name, directions, expected)
    fits = found.ndim == 2 and len(found) == rows and found.shape[1] > 0
    if not (fits and np.isfinite(found).all()):
        raise DomainError(name, directions, expected)
    return found
