"""Requests to end: SIGTERM and SIGHUP do what Ctrl-C does."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

NAMES = ("SIGTERM", "SIGHUP")  # the second is not on every platform


@contextmanager
def signals_as_ctrl_c() -> Iterator[list[int]]:
    """Take over the signals that ask a process to end; yield the numbers of those that came.

    Whoever has taken over Ctrl-C, such as a run, gets it. A signal that is ignored, as under
    ``nohup``, stays so.
    """
    received = []

    def pass_on(number: int, frame: FrameType | None) -> None:
        received.append(number)
        handler = signal.getsignal(signal.SIGINT)
        if not callable(handler):
            raise KeyboardInterrupt  # Ctrl-C is ignored, as in the background of a script; not this
        handler(signal.SIGINT, frame)

    before = {}
    if threading.current_thread() is threading.main_thread():
        for name in NAMES:
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, pass_on)
    try:
        yield received
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
