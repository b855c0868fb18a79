"""Real steps of a method from states of a run to times between its steps: all at once, compiled."""

from __future__ import annotations

import threading
from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array, Integers
from ..errors import StepError
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.call import Call
from ..kernels.compiling.signatures import VALUE
from ..kernels.numbers.blocks import Block, filled_block, scalar_block
from ..kernels.solve.by_address import by_address
from ..kernels.solve.orbit import INSIDE, bound_inside
from ..kernels.solve.partial import PARTIAL, TO_CLOCK, bound_polynomial, bound_write
from ..kernels.solve.status import NOT_CONVERGED, OK
from ..problems.bound import bound
from ..problems.problem import Problem
from .flow import Flow
from .stepper import NOTHING, Advance, Stepper

LARGE = 1 << 12  # numbers


def rounding(time: Array | float) -> Array:
    """Return how far apart two times may be that are meant to be the same."""
    return 4 * np.spacing(np.abs(time))


class Nodes:
    """States of a run, one a row, with the clock's row where there is one; their times; their steps."""

    def __init__(self, times: Array, states: Array, steps: Integers) -> None:
        self.times, self.states, self.steps = times, np.ascontiguousarray(states), steps

    @property
    def clock(self) -> Array:
        """Physical times, where they are integrated."""
        return self.states[:, -1]

    def with_more(self, later: Nodes) -> Nodes:
        """Return these and what comes after."""
        return Nodes(
            np.concatenate((self.times, later.times)),
            np.concatenate((self.states, later.states)),
            np.concatenate((self.steps, later.steps)),
        )

    def before_last(self, count: int, last: int = 0) -> Nodes:
        """Return so many of those before the last, or as many as there are; `last` 1: with it."""
        end = len(self.times) - 1
        which = slice(max(end - count, 0), end + last)
        return Nodes(self.times[which], self.states[which], self.steps[which])

    def up_to(self, last: int) -> Nodes:
        """Return those up to one, and it."""
        which = slice(last + 1)
        return Nodes(self.times[which], self.states[which], self.steps[which])

    def before(self, wanted: Array, sign: float, clock: bool) -> Integers:
        """Return the last node before each time of the run, or at it."""
        known = self.clock if clock else self.times
        found = np.searchsorted(sign * known, sign * wanted, side="right") - 1
        return np.asarray(np.maximum(found, 0), dtype=np.int64)


class Found(NamedTuple):
    """States at wanted times, one a row; their own times; the error that ended them too early."""

    times: Array
    states: Array
    error: StepError | None


def driven(flow: Flow) -> dict[str, Any]:
    """Return what kernels take that drive a flow beside its run, and how they begin."""
    between = flow.between
    return {
        "advance": by_address(tuple(f.signature for f in flow.functions)),
        "functions": (flow.bound, *flow.functions),
        "params": flow.params,
        "fractions": flow.fractions,
        "rows": flow.rows,
        "write": bound_write(*([between.write] if between else [])),
        "table": between.table if between else scalar_block(0),
        "begun": flow.coefficients,
    }


def own_blocks(flow: Flow) -> dict[str, Block]:
    """Return the blocks that a kernel beside the run changes: no two calls may share them."""
    return {
        "coefficients": filled_block(flow.coefficients.data),
        "memory": scalar_block(flow.memory),
        "work": scalar_block(flow.work),
        "whole": scalar_block(flow.memory),
    }


def beside(stepper: Stepper, kernel: Bound, **given: Any) -> Advance:
    """Return what a kernel did that drives a stepper's flow, turned to its other kernel at need.

    Compiled code lets other threads run: each has a call of its own, and what that changes.
    """
    while True:
        flow = stepper.flow
        key = kernel.recorded, threading.get_ident()
        call = flow.calls.get(key) or flow.calls.setdefault(key, _made(flow, kernel))
        found = Advance(*call(**given))
        if found.status != NOT_CONVERGED or not stepper.turn(flow):
            large = {k: NOTHING for k, x in given.items() if type(x) is Block and len(x) > LARGE}
            call.set(**large)  # which is not to be held until the next one
            return found


def _made(flow: Flow, kernel: Bound) -> Call:
    problem, names, between = flow.problem, kernel.signature.names, flow.between
    known = {**driven(flow), **own_blocks(flow), "ends": ends_of(problem)}
    known["scratch"] = scalar_block(problem.work)
    # The function that writes the whole step's polynomial, if there is one, and room for it.
    known["polynomial"] = bound_polynomial(*([between.polynomial] if between else []))
    known["powers"] = scalar_block(flow.rows * between.powers if between else 0)
    if problem.clock is not None:
        known["rate"] = bound(problem, problem.clock, VALUE)
    return kernel.call(flow.compiled, **{name: known[name] for name in names if name in known})


def ends_of(problem: Problem) -> Block:
    """Return where the pieces of the state end."""
    return Block(np.cumsum([float(rows) for _, rows in problem.pieces]))


def inside_of(flow: Flow) -> dict[str, Any]:
    """Return what tells of steps inside, and room for it, or none."""
    between = flow.between
    return {
        "inside": bound_inside(*([between.inside] if between else [])),
        "places": between.places if between else scalar_block(0),
        "known": scalar_block(INSIDE * flow.rows if between else 0),
    }


class PartialSteps:
    """Partial steps of one stepper, which they do not disturb; adaptive ones at given lengths."""

    def __init__(self, stepper: Stepper) -> None:
        self._stepper = stepper.fixed_step

    def to_times(self, nodes: Nodes, at: Integers, wanted: Array) -> Found:
        """Return the states at the problem's own times, each from its node.

        A length in the last bits of the time would only add noise to implicit steps: it is none.
        """
        gaps = wanted - nodes.times[at]
        gaps[np.abs(gaps) <= rounding(wanted)] = 0.0
        states, error = self._taken(PARTIAL, nodes, at, gaps, lengths=Block(gaps))
        return Found(wanted[: len(states)], states, error)

    def to_clock(self, nodes: Nodes, at: Integers, wanted: Array) -> Found:
        """Return the problem's own times and the states at times of the clock, each from its node."""
        gaps = np.zeros(len(wanted))
        given = {"wanted": Block(wanted.copy()), "roundings": Block(rounding(wanted))}
        states, error = self._taken(TO_CLOCK, nodes, at, gaps, lengths=Block(gaps), **given)
        return Found((nodes.times[at] + gaps)[: len(states)], states, error)

    def _taken(
        self, kernel: Bound, nodes: Nodes, at: Integers, gaps: Array, **given: Block
    ) -> tuple[Array, StepError | None]:
        count, rows = len(at), nodes.states.shape[1]
        out = scalar_block(count * rows)
        asked = beside(
            self._stepper,
            kernel,
            span=self._stepper.h,
            states=Block(nodes.states.reshape(-1)),
            times=Block(nodes.times),
            nodes=Block(at.astype(np.float64)),
            count=count,
            out=out,
            **given,
        )
        states = out.data.reshape(count, rows)
        if asked.status == OK:
            return states, None
        i = at[asked.steps]
        failed = self._stepper.like(nodes.states[i], nodes.times[i], gaps[asked.steps])
        error = failed.error(asked._replace(steps=0), 0, int(nodes.steps[i]))
        return states[: asked.steps], error
