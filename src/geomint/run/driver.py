"""The chunked loop: kernels for tens of milliseconds at a time, Python in between.

Between chunks the saved states are handed out, progress is shown and Ctrl-C is seen. The bits of
a run do not depend on the size of the chunks.
"""

from collections.abc import Callable

import numpy as np

from ..kernels.compiling.clock import running_clock
from ..kernels.numbers.blocks import scalar_block
from ..kernels.solve.status import OK
from .integrator import Integrator
from .recorder import NEVER, Account, Recorder

CHUNK_SECONDS = 0.03
FIRST_CHUNK = 64  # steps, before it is known what one takes
MAX_BUFFER = 1 << 18  # numbers
_NOTHING = scalar_block(0)


def drive(
    integrator: Integrator, recorder: Recorder, account: Account, between: Callable[[], bool]
) -> bool:
    """Take the steps of a stretch, and hand out states to the recorder, which may end the run.

    Where there is no number of steps, until the recorder says so, or until the stepper has finished;
    then its last state is handed out too. `between` is called after every chunk, to tell whether the
    run ends there. Returns whether it has ended the run before its end.

    Raises
    ------
    StepError
        After the states before the failed step have been handed out.
    """
    steps, stride, left = recorder.stretch.steps, recorder.stride, recorder.left
    whole = recorder.whole
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
        if len(out) < needed and (stride < NEVER or not stepper.length):
            out = scalar_block(needed)
        begun = running_clock()
        asked, good = integrator.take(count, stride, out, whole)
        elapsed = running_clock() - begun
        account.seconds += elapsed
        done = integrator.done
        end, ready = None, done // stride - first // stride
        over = stepper.finished and done % stride > 0  # at an end that steps are made to fit
        if ready or over:
            begun = running_clock()
            indices = np.arange(first - first % stride + stride, done + 1, stride)
            indices = np.append(indices, done) if over else indices
            handed = out.data[: len(indices) * width].reshape(-1, width)
            states = np.ascontiguousarray(handed[:, :rows])
            end = recorder.consume(indices, states, handed if whole else None)
            account.watching_seconds += running_clock() - begun
        if end is not None:
            integrator.bookmark = stepper.before
            integrator.take(end - first, stride, out, whole)
        else:
            recorder.pass_by()
            if asked.status != OK:
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
