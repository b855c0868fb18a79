"""A clock for runs: time that a thread has waited for code is none."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

_waits = threading.local()


def running_clock() -> float:
    """Return the seconds of a clock that stands still while this thread waits for code."""
    return time.perf_counter() - getattr(_waits, "seconds", 0.0)


@contextmanager
def standing_still() -> Iterator[None]:
    """Let the clock of this thread stand still."""
    begun = running_clock()
    try:
        yield
    finally:
        _waits.seconds = time.perf_counter() - begun
