"""Progress on a terminal for runs longer than a second, word of compilations, and Ctrl-C."""

from __future__ import annotations

import signal
import sys
import threading
import time
from types import FrameType, TracebackType
from typing import Any

__all__ = ["Progress"]

_DELAY = 1.0


class Progress:
    """A bar with rate and time left, shown once a run has lasted a second.

    A first Ctrl-C during the run is seen by the next `update`, which raises KeyboardInterrupt where
    everything that was computed is at rest; a second one interrupts at once.

    Parameters
    ----------
    show : bool or None
        None: only if standard error is a terminal.
    total : float or None
        In whatever unit `update` is called with; None if it is not known.
    label : str
    """

    def __init__(self, show: bool | None, total: float | None, label: str) -> None:
        self.shown = sys.stderr.isatty() if show is None else show
        self.compile_seconds = 0.0
        self._total, self._label = total, label
        self._start = time.perf_counter()
        self._bar: Any = None
        self._task: Any = None
        self._ended: Any = None
        self._interrupted = False
        self._handler: Any = None

    def __enter__(self) -> Progress:
        from .kernels.compile import listen

        self._ended = listen(self._compilation)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended()
        if self._bar is not None:
            self._bar.stop()
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
            if self._interrupted and kind is None:
                raise KeyboardInterrupt

    def _compilation(self, name: str, seconds: float | None) -> None:
        if seconds is not None:
            self.compile_seconds += seconds
        elif self.shown and self._bar is None:
            print(f"geomint: compiling {name} (once; kept in the cache)", file=sys.stderr)

    def begin(self) -> None:
        """Start the clock of the run, after compilation, and take Ctrl-C over."""
        self._start = time.perf_counter()
        if threading.current_thread() is threading.main_thread():
            handler = signal.getsignal(signal.SIGINT)
            if handler is signal.default_int_handler:  # else somebody has taken it over already
                self._handler = handler
                signal.signal(signal.SIGINT, self._interrupt)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if self._interrupted:
            raise KeyboardInterrupt
        self._interrupted = True

    def update(self, done: float) -> None:
        """Show how far the run is; raise KeyboardInterrupt after Ctrl-C."""
        if self._interrupted:
            self._interrupted = False
            raise KeyboardInterrupt
        if not self.shown or (self._bar is None and time.perf_counter() - self._start < _DELAY):
            return
        if self._bar is None:
            self._open()
        elapsed = max(time.perf_counter() - self._start, 1e-9)
        self._bar.update(self._task, completed=done, rate=f"{done / elapsed:.3g}/s")

    def _open(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as RichProgress

        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task(self._label, total=self._total, rate="")
        self._bar.start()
