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

from .kernels.blocks import scalar_block
from .kernels.status import OK
from .methods.stepper import Stepper

__all__ = ["Account", "drive"]

Array = npt.NDArray[np.float64]
Consumer = Callable[[npt.NDArray[np.int64], Array], bool]

CHUNK_SECONDS = 0.03
FIRST_CHUNK = 64
MAX_BUFFER = 1 << 19  # numbers


@dataclass
class Account:
    """What a run has cost."""

    steps: int = 0
    iterations: int = 0
    seconds: float = 0.0


def drive(
    stepper: Stepper,
    steps: int | None,
    stride: int,
    consume: Consumer,
    account: Account,
    progress: Callable[[int], None],
) -> None:
    """Take `steps` steps (None: until `consume` says so), handing out every `stride`-th state.

    Parameters
    ----------
    consume : callable
        ``consume(indices, states) -> stop``: the numbers of the saved steps, the states row by row.
    progress : callable
        Called with the number of steps done.

    Raises
    ------
    StepError
        After the states before the failed step have been handed out.
    """
    rows = stepper.rows
    stepper.prepare()
    largest = max(1, MAX_BUFFER // rows) * stride
    chunk = FIRST_CHUNK * stride if stride <= FIRST_CHUNK else stride
    out = scalar_block(0)
    while steps is None or account.steps < steps:
        count = chunk if steps is None else min(chunk, steps - account.steps)
        needed = (count // stride + 1) * rows
        if len(out) < needed:
            out = scalar_block(needed)
        first = account.steps
        begun = time.perf_counter()
        result = stepper.advance(first, count, stride, out)
        elapsed = time.perf_counter() - begun
        account.seconds += elapsed
        account.steps += result.steps
        account.iterations += result.iterations
        indices = np.arange(first // stride + 1, (first + result.steps) // stride + 1) * stride
        stop = consume(indices, out.data[: len(indices) * rows].reshape(-1, rows))
        if result.status != OK:
            raise stepper.error(result, first)
        progress(account.steps)
        if stop:
            return
        wanted = count * min(CHUNK_SECONDS / max(elapsed, 1e-9), 8.0)
        chunk = int(min(max(wanted // stride, 1) * stride, largest))
