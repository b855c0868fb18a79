"""The chunked loop: kernels for tens of milliseconds at a time, Python in between.

Between chunks the saved states are handed out, progress is shown and Ctrl-C is seen. The bits of
a run do not depend on the size of the chunks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arguments import Array
from ..kernels.compiling.clock import running_clock
from ..kernels.numbers.blocks import scalar_block
from ..kernels.solve.status import OK
from .integrator import Integrator

__all__ = ["Account", "drive"]

Consumer = Callable[[npt.NDArray[np.int64], Array, Array | None], int | None]

CHUNK_SECONDS = 0.03
FIRST_CHUNK = 64  # steps, before it is known what one takes
MAX_BUFFER = 1 << 18  # numbers
_NOTHING = scalar_block(0)


@dataclass
class Account:
    """What a run has cost, without what was compiled on the way."""

    seconds: float = 0.0
    watching_seconds: float = 0.0


def drive(
    integrator: Integrator,
    steps: int | None,
    stride: int,
    consume: Consumer,
    account: Account,
    between: Callable[[], bool],
    left: Callable[[], float],
    whole: bool = False,
) -> bool:
    """Take steps until there are `steps` since the beginning, handing out every `stride`-th state.

    None: until `consume` says so, or until the stepper has finished; then its last state is handed
    out too. Returns whether `between` has ended it before.

    Parameters
    ----------
    consume : callable
        ``consume(indices, states, memories) -> end``: the numbers of the saved steps, the states row
        by row, with `whole` all that was remembered then. `end` is the number of the last step of
        the run, None if that is still to come.
    between : callable
        Called after every chunk, to tell whether the run ends there.
    left : callable
        About how many steps are still to come, where `steps` is None.

    Raises
    ------
    StepError
        After the states before the failed step have been handed out.
    """
    stepper = integrator.stepper
    rows = stepper.rows
    width = len(stepper.memory) if whole else rows
    largest = max(1, MAX_BUFFER // width) * stride
    chunk = FIRST_CHUNK if steps is not None else _at_most(FIRST_CHUNK, left())
    out = _NOTHING
    while steps is None or integrator.done < steps:
        first = integrator.done
        count = chunk if steps is None else min(chunk, steps - first)
        needed = (count // stride + 2) * width
        if len(out) < needed:
            out = scalar_block(needed)
        begun = running_clock()
        asked, good = integrator.take(count, stride, out, whole)
        elapsed = running_clock() - begun
        account.seconds += elapsed
        done = integrator.done
        indices = np.arange(first - first % stride + stride, done + 1, stride)
        if stepper.finished and done % stride:  # an end that steps are made to fit
            indices = np.append(indices, done)
        begun = running_clock()
        handed = out.data[: len(indices) * width].reshape(-1, width)
        states = np.ascontiguousarray(handed[:, :rows])
        end = consume(indices, states, handed if whole else None)
        account.watching_seconds += running_clock() - begun
        if end is not None:
            integrator.bookmark = stepper.before
            integrator.take(end - first, stride, out, whole)
        elif asked.status != OK:
            raise integrator.failure(asked, good)
        ended = between()
        if ended or end is not None or stepper.finished:
            return ended and end is None and not (stepper.finished and left() == 0.0)
        wanted = count * min(CHUNK_SECONDS / max(elapsed, 1e-9), 8.0)
        chunk = max(1, int(min(wanted, largest)))
        if steps is None:
            chunk = _at_most(chunk, left())
    return False


def _at_most(chunk: int, left: float) -> int:
    """Return the length of a chunk that does not go far beyond the end."""
    return chunk if not 0.0 <= left < chunk else int(1.05 * left) + 2
