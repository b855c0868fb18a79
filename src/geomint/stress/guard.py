"""Work in processes of its own: one that hangs, crashes or takes too much memory ends alone.

Compiled code does not hear signals, so only another process can stop it.
"""

import contextlib
import multiprocessing
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any

from ..errors import raised

COMPILE_SECONDS = 600.0  # compilations are not what is judged, but they must end too
LEAVING = 60.0  # seconds that a process with much memory may take to end
_TICK = 0.2


@dataclass(frozen=True)
class Outcome:
    """What became of one item.

    Attributes
    ----------
    ending : str
        ``"done"`` with the function's `value`, ``"raised"`` or ``"died"`` with a `message`,
        ``"hung"``.
    """

    item: Any
    ending: str
    value: Any = None
    message: str = ""
    seconds: float = 0.0


def guarded(
    function: Callable[[Any], Any],
    groups: Sequence[Sequence[Any]],
    *,
    seconds: float,
    workers: int = 2,
    memory: int = 0,
) -> Iterator[Outcome]:
    """Call `function` on every item, in `workers` processes, and yield outcomes as they come.

    Parameters
    ----------
    function : callable
        A function of a module: processes find it by name.
    groups : sequence of sequences
        Items of one group run in one process one after the other, so that it may remember things.
    seconds : float
        An item that takes longer, compilations apart, has hung: its process is killed.
    memory : int
        Bytes that a process may take, where the platform can limit them; 0 for any number.
    """
    waiting = deque(deque(group) for group in groups if group)
    crew: list[_Worker] = []
    try:
        while waiting or any(worker.items for worker in crew):
            for worker in crew:
                if not worker.items and waiting:
                    worker.take(waiting.popleft())
            while waiting and len(crew) < workers:
                crew.append(_Worker(function, memory))
                crew[-1].take(waiting.popleft())
            wait([worker.pipe for worker in crew], _TICK)
            for worker in list(crew):
                yield from worker.outcomes(seconds)
                if worker.ended:
                    crew.remove(worker)
                    if worker.items:
                        waiting.appendleft(worker.items)
    finally:
        for worker in crew:
            worker.end()


class _Worker:
    """A process, the items that it has still to do, and the time that it has taken for the first."""

    def __init__(self, function: Callable[[Any], Any], memory: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other, function, memory), daemon=True)
        self._process.start()
        other.close()
        self.items: deque[Any] = deque()
        self.ended = False
        self._ready = False
        self._begun = time.monotonic()
        self._compiling: float | None = None

    def take(self, items: deque[Any]) -> None:
        self.items = items
        self._send()

    def _send(self) -> None:
        self._begun = time.monotonic()
        with contextlib.suppress(OSError):  # a process that has died is noticed elsewhere
            self.pipe.send(self.items[0])

    def outcomes(self, cap: float) -> Iterator[Outcome]:
        """Yield what has been done since, and end the process if it takes too long."""
        try:
            while self.pipe.poll():
                yield from self._heard(*self.pipe.recv())
        except (EOFError, OSError):
            self._process.join(5.0)
            yield from self._lost("died", f"the process ended with code {self._process.exitcode}")
            return
        now = time.monotonic()
        late = self._compiling is not None and now - self._compiling > COMPILE_SECONDS
        spent = self._ready and self._compiling is None and now - self._begun > cap
        if self.items and (late or spent):
            what = "compiling" if late else "running"
            self._process.kill()
            yield from self._lost("hung", f"still {what} after {now - self._begun:.3g} s: ended")

    def _heard(self, ending: str, value: Any) -> Iterator[Outcome]:
        now = time.monotonic()
        if ending == "ready":
            self._ready, self._begun = True, now
        elif ending == "compiling":
            self._compiling = self._compiling or now
        elif ending == "compiled":
            self._begun += now - (self._compiling or now)
            self._compiling = None
        else:
            item, seconds = self.items.popleft(), now - self._begun
            self._compiling = None
            if self.items:
                self._send()
            if ending == "done":
                yield Outcome(item, "done", value, seconds=seconds)
            else:
                yield Outcome(item, "raised", message=value, seconds=seconds)

    def _lost(self, ending: str, message: str) -> Iterator[Outcome]:
        self.ended = True
        self.pipe.close()
        if self.items:
            seconds = time.monotonic() - self._begun
            yield Outcome(self.items.popleft(), ending, message=message, seconds=seconds)

    def end(self) -> None:
        """Let the process go: at once if it is at rest, by force if not."""
        if not self.ended:
            self.pipe.close()
            if self.items:
                self._process.kill()
            self._process.join(LEAVING)  # so that its processor time is counted


def _serve(pipe: Connection, function: Callable[[Any], Any], memory: int) -> None:
    """Do items until the other end hangs up."""
    import signal

    from ..kernels.compiling.compile import listen

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what Ctrl-C means
    _limit(memory)
    listen(lambda name, taken: pipe.send(("compiling" if taken is None else "compiled", name)))
    pipe.send(("ready", None))
    while True:
        try:
            item = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer = ("done", function(item))
        except Exception as error:
            answer = ("raised", raised(error))
        try:
            pipe.send(answer)
        except OSError:
            return


def _limit(memory: int) -> None:
    try:
        import resource
    except ImportError:
        return
    if memory:
        resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
