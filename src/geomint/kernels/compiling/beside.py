"""A second process that compiles into the same cache, from the other end of what is to be compiled.

numba compiles one function at a time in a process. Where a kernel is missing, a process is started
that does the same as this one and begins with what this one would do last. Both tell each other what
they are compiling; who comes to a function that the other one is at waits for it. Whatever happens to
the other process, this one compiles what it does not find.

What goes between them are names of files of the cache, one a line: of what is being compiled, or an
empty line. A process whose input ends is alone: the other one has ended, however.
"""

import _imp
import contextlib
import os
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from subprocess import _args_from_interpreter_flags  # type: ignore[attr-defined]
from typing import IO, Any

from .cores import cores

LONGEST = 60.0  # seconds for one function; a process that was stopped says nothing
Task = Callable[[], object]
_PROGRAM = f"import sys; sys.path[:] = {{!r}}; from {__name__} import main; main()"
_state: dict[str, Any] = {"other": None, "start": None, "helps": False}


class Other:
    """The other process, as this one sees it."""

    def __init__(self, source: IO[bytes], sink: IO[bytes], gone: Task = lambda: None) -> None:
        self._source, self._sink, self._gone = source, sink, gone
        self._changed = threading.Condition()
        self._making = ""
        self._reader = threading.Thread(target=self._read, daemon=True, name="compiling beside")
        self._reader.start()

    def _read(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            for line in self._source:
                self._set(line.decode().strip())
        self._set("")
        self._gone()

    def _set(self, name: str) -> None:
        with self._changed:
            self._making = name
            self._changed.notify_all()

    def tell(self, name: str) -> None:
        """Tell what is being compiled here: nothing, if it is empty."""
        with contextlib.suppress(OSError, ValueError):  # it has ended
            self._sink.write(f"{name}\n".encode())
            self._sink.flush()

    def waited(self, name: str) -> bool:
        """Wait as long as it compiles that; return whether it did, so that the file may be there."""
        with self._changed:
            if self._making != name:
                return False
            return self._changed.wait_for(lambda: self._making != name, LONGEST)


def other(name: str, kernel: bool) -> Other | None:
    """Return the process beside this one, begun where a kernel is missing; None if there is none."""
    start, found = _state["start"], _state["other"]
    if found is None and start is not None and kernel:
        _state["start"] = None  # once, whatever comes of it
        found = _state["other"] = start()
    return found


def in_turn(*parts: Task) -> None:
    """Carry out parts that do not depend on each other: from the other end in a process that helps."""
    for part in reversed(parts) if _state["helps"] else parts:
        part()


@contextlib.contextmanager
def compiled_beside(tasks: Callable[[], Sequence[Task]]) -> Iterator[None]:
    """Let a second process carry out tasks for what they compile, if a kernel is found missing.

    Not where there is one core, nor in a process that helps, nor where tasks cannot be sent. It ends
    with the context, and with this process.
    """
    processes = []

    def start() -> Other | None:
        from .sending import sent

        try:
            content = sent(tuple(tasks()))
            # As this one has them: -I, -E, -s, -O, -B, -W, -X among others. Nothing is imported
            # from the current folder before the path is that of this one.
            options = [*_args_from_interpreter_flags(), "-P"]
            options += ["--check-hash-based-pycs", _imp.check_hash_based_pycs]
            options += [f"-X{x}" if v is True else f"-X{x}={v}" for x, v in sys._xoptions.items()]
            process = subprocess.Popen(
                [sys.executable, *options, "-c", _PROGRAM.format(sys.path)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        except Exception:  # tasks that cannot be sent, no more processes: all is compiled here
            return None
        processes.append(process)
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(OSError):
            process.stdin.write(len(content).to_bytes(8, "little") + content)
            process.stdin.flush()
        return Other(process.stdout, process.stdin)

    if cores() > 1 and not _state["helps"] and sys.executable:
        _state["start"] = start
    try:
        yield
    finally:
        _state.update(start=None, other=None)
        for process in processes:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                with contextlib.suppress(OSError):
                    pipe.close()  # type: ignore[union-attr]


def main() -> None:
    """Carry out what comes in, for what it compiles; end with the process that sent it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for that one
    source, sink = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what tasks print is nobody's
    content = source.read(int.from_bytes(source.read(8), "little"))
    _state.update(helps=True, other=Other(source, sink, lambda: os._exit(0)))
    warnings.simplefilter("ignore")
    try:
        from .sending import received

        for task in received(content):
            with contextlib.suppress(Exception):
                task()
    finally:
        os._exit(0)  # a thread still reads what Python would close
