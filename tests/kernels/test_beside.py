"""A process that compiles beside this one: what they tell each other, and that it is never needed."""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from functools import partial

import pytest

import geomint as gi
from geomint.kernels.compiling import beside, sending

NAME = "gauss-0123.nbc"


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beside, "cores", lambda: 2)


@pytest.fixture
def ends() -> Iterator[tuple[beside.Other, beside.Other]]:
    """Two ends, as two processes have them."""
    (here, there), (back, forth) = os.pipe(), os.pipe()
    one = beside.Other(os.fdopen(here, "rb"), os.fdopen(forth, "wb"))
    two = beside.Other(os.fdopen(back, "rb"), os.fdopen(there, "wb"))
    yield one, two
    for each in (one, two):
        each._sink.close()
    for each in (one, two):
        each._reader.join(60.0)
        each._source.close()


def makes(theirs: beside.Other, mine: beside.Other) -> None:
    """Let the other side compile something, and wait until this one knows it."""
    theirs.tell(NAME)
    while mine._making != NAME:
        time.sleep(0.001)


@pytest.mark.parametrize("gone", [False, True])
def test_who_comes_to_what_is_being_compiled_waits(ends, gone: bool) -> None:
    """As long as the other process is at it, or is there."""
    mine, theirs = ends
    makes(theirs, mine)
    assert not mine.waited("another.nbc")
    found: list[bool] = []
    waiting = threading.Thread(target=lambda: found.append(mine.waited(NAME)))
    waiting.start()
    waiting.join(0.1)
    assert waiting.is_alive()
    if gone:
        theirs._sink.close()
    else:
        theirs.tell("")
    waiting.join(30.0)
    assert found == [True]
    assert not mine.waited(NAME)


def test_who_says_nothing_more_is_not_waited_for(ends, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a process that was stopped; to tell one that has ended is no error."""
    mine, theirs = ends
    makes(theirs, mine)
    monkeypatch.setattr(beside, "LONGEST", 0.05)
    assert not mine.waited(NAME)
    theirs._sink.close()
    mine._reader.join(60.0)
    mine._sink.close()
    mine.tell(NAME)


def test_a_process_that_helps_begins_at_the_other_end(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    parts = [partial(done.append, name) for name in "abc"]
    beside.in_turn(*parts)
    monkeypatch.setitem(beside._state, "helps", True)
    beside.in_turn(*parts)
    assert "".join(done) == "abccba"
    with beside.compiled_beside(list):
        assert beside.other(NAME, True) is None


def test_it_is_begun_once_and_for_a_kernel(tmp_path: pathlib.Path) -> None:
    """It carries out the tasks, one after the other, until the context ends."""
    done = tmp_path / "done"
    tasks = [partial(done.touch), partial(time.sleep, 600.0)]
    with beside.compiled_beside(lambda: tasks):
        assert beside.other(NAME, False) is None
        helper = beside.other(NAME, True)
        assert helper is not None
        assert beside.other("another.nbc", False) is helper
        end = time.monotonic() + 60.0
        while not done.exists() and time.monotonic() < end:
            time.sleep(0.01)
        assert done.exists()
        assert helper._reader.is_alive()
    assert beside.other(NAME, True) is None
    helper._reader.join(60.0)  # the process has been ended
    assert not helper._reader.is_alive()


def test_without_a_second_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where tasks cannot be sent, no process can be begun, or there is one core."""
    with beside.compiled_beside(lambda: [partial(print, threading.Lock())]):
        assert beside.other(NAME, True) is None
        assert beside.other(NAME, True) is None
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with beside.compiled_beside(list):
        assert beside.other(NAME, True) is None
    monkeypatch.setattr(beside, "cores", lambda: 1)
    with beside.compiled_beside(list):
        assert beside._state["start"] is None


@pytest.mark.parametrize("gone", [True, False])
def test_it_ends(gone: bool) -> None:
    """With the one that began it, and by itself; what its tasks print or raise is nobody's."""
    tasks = (partial(print, "printed"), partial(int, "raised"), partial(time.sleep, 600.0 * gone))
    content, pipe = sending.sent(tasks), subprocess.PIPE
    program = [sys.executable, "-c", beside._PROGRAM.format(sys.path)]
    with subprocess.Popen(program, stdin=pipe, stdout=pipe, stderr=pipe) as process:
        process.stdin.write(len(content).to_bytes(8, "little") + content)
        process.stdin.flush()
        if gone:
            process.stdin.close()
        assert process.wait(120.0) == 0
        assert process.stdout.read() == b""
        assert gone or process.stderr.read() == b"printed\n"  # which nobody reads


FLAGS = """
import subprocess, sys
sys.path[:] = {!r}
from geomint.kernels.compiling import beside
told = "import sys; print(sys.flags, sys.pycache_prefix, sys.warnoptions)"
class Process(subprocess.Popen):
    def __init__(self, command, **more):
        seen.append(command[: command.index("-c")])
        raise OSError
seen, plain = [], subprocess.Popen
beside.cores, subprocess.Popen = lambda: 2, Process
with beside.compiled_beside(lambda: (len,)):
    beside.other("x", True)
subprocess.Popen = plain
(command,) = seen
child = subprocess.run([*command, "-c", told], capture_output=True, text=True).stdout
exec(told)
print(child)
"""


@pytest.mark.parametrize(
    "options", ["-I -O -W ignore::FutureWarning", "-E -s -OO -B -P -b -X pycache_prefix=/none"]
)
def test_it_runs_as_this_process_does(options: str) -> None:
    """With the same options of Python, and nothing from the current folder."""
    command = [sys.executable, *options.split(), "-c", FLAGS.format(sys.path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    own, its = done.stdout.strip().splitlines()
    assert own.replace("safe_path=False", "safe_path=True") == its, done.stderr


def test_what_fails_is_no_longer_being_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else two processes may wait for each other for ever."""
    told: list[str] = []
    double = type("Double", (), {"tell": told.append, "waited": lambda name: False})
    monkeypatch.setitem(beside._state, "other", double)

    @gi.field
    def refused(params, t, y, out, work):
        out[0] = missing(y[0])  # noqa: F821

    with pytest.raises(gi.DeclarationError, match="missing"):
        gi.pointwise(refused, [], [[1.0]], rows=1, check=False)
    assert told[-1] == ""
    assert any(name.startswith("refused-") for name in told)
