"""The chunked loop: kernels for tens of milliseconds at a time, Python in between.

Between chunks the saved states are handed out, progress is shown and Ctrl-C is seen. The bits of
a run do not depend on the size of the chunks.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arguments import Array
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.status import OK
from ..methods.stepper import Advance, Stepper

__all__ = ["Account", "drive"]

Consumer = Callable[[npt.NDArray[np.int64], Array], int | None]

CHUNK_SECONDS = 0.03
FIRST_CHUNK = 64
MAX_BUFFER = 1 << 19  # numbers


@dataclass
class Account:
    """What a run has cost."""

    steps: int = 0
    iterations: int = 0
    seconds: float = 0.0
    watching_seconds: float = 0.0


def drive(
    stepper: Stepper,
    steps: int | None,
    stride: int,
    consume: Consumer,
    account: Account,
    progress: Callable[[int], None],
) -> None:
    """Take `steps` steps, handing out every `stride`-th state.

    None: until `consume` says so, or until the stepper has finished; then its last state is handed
    out too.

    Parameters
    ----------
    consume : callable
        ``consume(indices, states) -> end``: the numbers of the saved steps, the states row by row.
        `end` is the number of the last step of the run, None if that is still to come.
    progress : callable
        Called with the number of steps done.

    Raises
    ------
    StepError
        After the states before the failed step have been handed out.
    """
    rows = stepper.rows
    largest = max(1, MAX_BUFFER // rows) * stride
    chunk = FIRST_CHUNK
    out = scalar_block(0)
    while steps is None or account.steps < steps:
        count = chunk if steps is None else min(chunk, steps - account.steps)
        needed = (count // stride + 2) * rows
        if len(out) < needed:
            out = scalar_block(needed)
        first, spent = account.steps, account.iterations
        before = stepper.memory.data.copy()
        begun = time.perf_counter()
        try:
            result = stepper.advance(first, count, stride, out)
            good = result
            if result.status != OK:  # memory may be in the middle of a composition
                good = _repeat(stepper, before, first, result.steps, stride, out)
            elapsed = time.perf_counter() - begun
            account.seconds += elapsed
            account.steps, account.iterations = first + good.steps, spent + good.iterations
        except KeyboardInterrupt:  # seen when the kernel returns: memory is ahead of the account
            stepper.memory.data[:] = before
            account.steps, account.iterations = first, spent
            raise
        indices = np.arange(first // stride + 1, account.steps // stride + 1) * stride
        if stepper.finished and account.steps % stride:  # an end that steps are made to fit
            indices = np.append(indices, account.steps)
        begun = time.perf_counter()
        end = consume(indices, out.data[: len(indices) * rows].reshape(-1, rows))
        account.watching_seconds += time.perf_counter() - begun
        if end is not None:
            good = _repeat(stepper, before, first, end - first, stride, out)
            account.steps, account.iterations = end, spent + good.iterations
        elif result.status != OK:
            failed = result.iterations - good.iterations
            raise stepper.error(result._replace(iterations=failed), first)
        progress(account.steps)
        if end is not None or stepper.finished:
            return
        wanted = count * min(CHUNK_SECONDS / max(elapsed, 1e-9), 8.0)
        chunk = max(1, int(min(wanted, largest)))


def _repeat(
    stepper: Stepper, memory: Array, first: int, count: int, stride: int, out: Block
) -> Advance:
    """Take only the first `count` steps of a chunk that began with `memory`."""
    stepper.memory.data[:] = memory
    return stepper.advance(first, count, stride, out)
