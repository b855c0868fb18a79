"""Sweeps in which no step waits for another one, on all cores."""

from __future__ import annotations

import itertools
import threading
from typing import TypeAlias

import numpy as np

from ..arguments import Array
from ..kernels.compiling.call import Call
from ..kernels.compiling.cores import cores
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.tangent.measure_lanes import PARTS
from ..kernels.tangent.normals import GROWN
from ..methods.carried_lanes import CarriedLanes
from .steps_again import BATCH

__all__ = ["StepsApart"]

MOST = 8  # threads: more of them wait for Python
NOTHING = np.empty(0)

Steps: TypeAlias = tuple[Array, ...]  # starts, lengths, states


class StepsApart:
    """The sweep of `geomint.kernels.tangent.measure_lanes` over chunk after chunk of a run.

    What a step adds depends on its two ends and on the units of pieces alone. As long as no unit
    grows, batches of a chunk are swept by threads, each with memory of its own, and added up in their
    order: to the bits of one call after the other. A batch begins one step early, whose end is that
    of the step before for all that follows.

    In other threads than the main one, where members of ensembles run, all cores are at work already.
    """

    def __init__(self, carried: CarriedLanes, sweep: Call) -> None:
        self._carried, self._sweep = carried, sweep
        self._others: list[Call] = []
        self._before: Steps | None = None  # the last step of the chunk before
        self._behind = False  # whether others have taken steps since `sweep` has

    def __call__(self, starts: Array, lengths: Array, states: Array) -> Array:
        """Return the sum of the defects after each of the next steps."""
        steps = starts, lengths, states
        parts, values = np.empty(PARTS * len(starts)), np.empty(len(starts))
        if self._before is not None and len(starts) > BATCH and self._apart(states):
            both = zip(self._before, steps, strict=True)
            self._in_threads(tuple(map(np.concatenate, both)), parts)
            _sweep(self._sweep, _cut(steps, slice(0)), parts, values)
        else:
            self._in_turn(steps, parts, values)
        self._before = tuple(each.copy() for each in _cut(steps, slice(-1, None)))
        return values

    def _in_turn(self, steps: Steps, parts: Array, values: Array) -> None:
        if self._behind and self._before is not None:
            _sweep(self._sweep, self._before, np.empty(PARTS))
        self._behind = False
        for first in range(0, len(values), BATCH):
            here = slice(first, first + BATCH)
            into = parts[PARTS * first : PARTS * here.stop]
            _sweep(self._sweep, _cut(steps, here), into, values[here])

    def _apart(self, states: Array) -> bool:
        """Tell whether threads may take these steps: no unit grows on the way."""
        alone = threading.current_thread() is threading.main_thread() and cores() > 1
        scales = self._carried.kept("scales")
        return alone and bool((np.abs(states[:, : len(scales)]) <= GROWN * scales).all())

    def _in_threads(self, steps: Steps, parts: Array) -> None:
        """Sweep batches of steps, of which the first has been taken before."""
        count = len(parts) // PARTS
        batches = itertools.count(0, BATCH)  # whoever is free takes the next one
        errors: list[BaseException] = []

        def work(call: Call) -> None:
            try:
                for first in batches:
                    if first >= count or errors:
                        return
                    _sweep(call, _cut(steps, slice(first, first + 1)), np.empty(PARTS))
                    here = slice(first + 1, first + 1 + BATCH)
                    at = slice(PARTS * first, PARTS * (first + BATCH))
                    _sweep(call, _cut(steps, here), parts[at])
            except BaseException as error:
                errors.append(error)

        calls = self._calls(min(cores(), MOST, -(-count // BATCH)))
        threads = [threading.Thread(target=work, args=(call,)) for call in calls[1:]]
        for thread in threads:
            thread.start()
        work(calls[0])
        for thread in threads:
            thread.join()
        if errors:
            raise errors[0]
        self._behind = True

    def _calls(self, count: int) -> list[Call]:
        """Return calls with memories of their own, in which units are as they are now."""
        while len(self._others) < count:
            call = self._sweep.copy()
            call.set(memory=scalar_block(len(call.given("memory"))), **self._carried.rooms())
            self._others.append(call)
        layout = self._carried.arguments["memory"].data
        for call in self._others[:count]:
            call.given("memory").data[:] = layout
        return self._others[:count]


def _cut(steps: Steps, here: slice) -> Steps:
    return tuple(each[here] for each in steps)


def _sweep(call: Call, steps: Steps, parts: Array, out: Array = NOTHING) -> None:
    starts, lengths, states = (Block(each.reshape(-1)) for each in steps)
    call(starts=starts, lengths=lengths, states=states, parts=Block(parts), out=Block(out))
