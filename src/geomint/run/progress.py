"""Progress on a terminal for runs longer than a second, word of compilations, and Ctrl-C."""

from __future__ import annotations

import functools
import signal
import sys
import threading
from collections.abc import Callable
from html import escape
from types import FrameType, TracebackType
from typing import Any

from ..errors import SpeedWarning, tell
from ..kernels.compiling.clock import running_clock
from .compiling_line import CompilingLine, on_terminal

_DELAY, _BRIEF = 1.0, 2e-3
WHEN_RUNNING: list[Callable[[], object]] = []  # called, once, when the next run has begun
HOUR, DAY = 3600.0, 86400.0
_UNITS = (("years", 365.25 * DAY), ("days", DAY), ("hours", HOUR), ("minutes", 60.0))


def time_in_words(seconds: float) -> str:
    """Return a time to two digits: ``0.2 seconds``, ``14 hours``, ``1.6e+04 years``."""
    unit, size = next(((u, s) for u, s in _UNITS if seconds >= 2.0 * s), ("seconds", 1.0))
    count = seconds / size
    return f"{count:.0f} {unit}" if 9.5 <= count < 1e4 else f"{count:.2g} {unit}"


class Progress:
    """A bar with rate and time left, shown once a run has lasted a second.

    A first Ctrl-C during the run is seen by the next `update`, which raises KeyboardInterrupt where
    everything that was computed is at rest; a second one interrupts at once.

    A run that at its pace would take longer than a day is warned of, after a second, or later if
    it becomes slower. A day: the bar shows it to those who look, and runs of hours are meant;
    beyond, an end or a step is more likely to be a mistake.

    Parameters
    ----------
    show : bool or None
        None: only if standard error is a terminal, or in a notebook; elsewhere one line says, once in
        a process, that functions are compiled, if they are not in the cache.
    total : float or None
        In whatever unit `update` is called with; None if it is not known.
    label : str
    """

    def __init__(self, show: bool | None, total: float | None, label: str) -> None:
        self._show = show
        self.compile_seconds = 0.0
        self.total, self._label = total, label
        self._start = running_clock()
        self._bar: Any = None
        self._task: Any = None
        self._ended: Any = None
        self._asked = self._expected = 0
        self._compiling: CompilingLine | None = None
        self._interrupted = self._at_once = self.brief = False
        self._handler: Any = None
        self._next_look = _DELAY

    @functools.cached_property
    def _notebook(self) -> bool:
        return _in_notebook()

    @functools.cached_property
    def shown(self) -> bool:
        """Whether progress is shown."""
        return self._notebook or on_terminal() if self._show is None else self._show

    def __enter__(self) -> Progress:
        listen, functions_asked = _compiler()
        self._asked = functions_asked()
        self._ended = listen(self._compilation)
        return self

    def expect(self, functions: int) -> None:
        """Tell how many functions are about to be compiled, or found in the cache."""
        self._expected = functions

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended()
        self._clear()
        if self._bar is not None:
            self._bar.stop()
        if self._handler is not None:
            signal.signal(signal.SIGINT, self._handler)
            # numba makes a TypeError of what interrupts it while it reads the types of functions.
            if (self._interrupted and kind is None) or (self._at_once and kind is TypeError):
                raise KeyboardInterrupt

    def _compilation(self, name: str, seconds: float | None) -> None:
        line = self._compiling
        if line is None:
            line = self._compiling = CompilingLine(self._show is not False, self._expected)
        if seconds is not None:
            self.compile_seconds += seconds
            line.ends(seconds)
        elif self._bar is None:
            line.begins(_compiler()[1]() - self._asked)

    def _clear(self) -> None:
        if self._compiling is not None:
            self._compiling.clear()

    def begin(self, soon: bool = False) -> None:
        """Start the clock of the run, after compilation, and take Ctrl-C over.

        Of a run that is updated `soon`, the first update does so if some time has passed: before that
        nobody can have pressed a key because of it.
        """
        self._clear()
        while WHEN_RUNNING:
            WHEN_RUNNING.pop()()
        self._start, self.brief = running_clock(), soon
        if not soon:
            self._take_over()

    def _take_over(self) -> None:
        self.brief = False
        if threading.current_thread() is threading.main_thread():
            handler = signal.getsignal(signal.SIGINT)
            if handler is signal.default_int_handler:  # else somebody has taken it over already
                self._handler = handler
                signal.signal(signal.SIGINT, self._interrupt)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if self._interrupted:
            self._at_once = True
            raise KeyboardInterrupt
        self._interrupted = True

    def update(self, done: float) -> None:
        """Show how far the run is; raise KeyboardInterrupt after Ctrl-C."""
        if self._interrupted:
            self._interrupted = False
            raise KeyboardInterrupt
        elapsed = max(running_clock() - self._start, 1e-9)
        if self.brief and elapsed > _BRIEF:
            self._take_over()
        if elapsed > self._next_look:
            self._look(done, elapsed)
        if (self._bar is None and elapsed < _DELAY) or not self.shown:
            return
        if self._bar is None:
            self._open()
        self._bar.update(self._task, completed=done, rate=f"{done / elapsed:.3g}/s")

    def _look(self, done: float, elapsed: float) -> None:
        """Warn, once, if the run would take longer than a day; look again after as long a time."""
        self._next_look = 2.0 * elapsed
        expected = elapsed * (self.total or 0.0) / done if done > 0.0 else 0.0
        if expected > DAY:
            self._next_look = float("inf")
            text = f"at its pace this run takes about {time_in_words(expected)}: end it earlier?"
            tell(SpeedWarning(text, "run time", expected))

    def _open(self) -> None:
        if self._notebook:
            self._bar, self._task = _NotebookBar(self._label, self.total), None
            return
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            Progress as RichProgress,
            TaskProgressColumn,
            TextColumn,
            TimeRemainingColumn,
        )

        self._bar = RichProgress(
            TextColumn("{task.description}"),
            BarColumn(),
            TaskProgressColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task(self._label, total=self.total, rate="")
        self._bar.start()


@functools.cache
def _compiler() -> tuple[Callable[..., Callable[[], None]], Callable[[], int]]:
    """Return what imports numba."""
    from ..kernels.compiling.compile import functions_asked, listen

    return listen, functions_asked


def _in_notebook() -> bool:
    """Tell whether cells of a notebook show what is displayed."""
    library = sys.modules.get("IPython")
    shell = None if library is None else library.get_ipython()
    return getattr(shell, "kernel", None) is not None


class _NotebookBar:
    """A bar in the output of a cell, of which nothing is left when it stops: not in exports either."""

    def __init__(self, label: str, total: float | None) -> None:
        display = sys.modules["IPython"].display.display
        self._label, self._total = label, total
        self._handle = display({"text/plain": ""}, raw=True, display_id=True)

    def update(self, task: None, completed: float, rate: str) -> None:
        share = "" if self._total is None else f' value="{completed}" max="{self._total}"'
        bar = f"<progress{share}></progress>"
        shown = {"text/plain": "", "text/html": f"{escape(self._label)} {bar} {escape(rate)}"}
        self._handle.update(shown, raw=True)

    def stop(self) -> None:
        self._handle.update({"text/plain": "", "text/html": ""}, raw=True)
