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
from numba import types

import geomint as gi
from geomint.kernels.compiling import beside, compile
from geomint.kernels.compiling.sending import sent

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


def known(other: beside.Other, name: str) -> None:
    """Wait until it is known what is being compiled on the other side."""
    while other._making != name:
        time.sleep(0.001)


def folders(cache: pathlib.Path) -> set[str]:
    return {path.name.partition("-")[0] for path in cache.rglob("*.nbc")}


@pytest.mark.parametrize("gone", [False, True])
def test_who_comes_to_what_is_being_compiled_waits(ends, gone: bool) -> None:
    """As long as the other process is at it, or is there."""
    mine, theirs = ends
    theirs.tell(NAME)
    known(mine, NAME)
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
    waiting.join(60.0)
    assert found == [True]
    assert not mine.waited(NAME)


def test_to_tell_a_process_that_has_ended_is_no_error(ends) -> None:
    mine, theirs = ends
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


def test_it_is_begun_once_and_for_a_kernel() -> None:
    tasks = [partial(time.sleep, 600.0)]
    with beside.compiled_beside(lambda: tasks):
        assert beside.other(NAME, False) is None
        helper = beside.other(NAME, True)
        assert helper is not None
        assert beside.other("another.nbc", False) is helper
    assert beside.other(NAME, True) is None
    helper._reader.join(60.0)  # the process has been ended
    assert not helper._reader.is_alive()


def test_what_cannot_be_sent_is_compiled_here() -> None:
    with beside.compiled_beside(lambda: [partial(print, threading.Lock())]):
        assert beside.other(NAME, True) is None
        assert beside.other(NAME, True) is None


def test_without_a_second_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with beside.compiled_beside(list):
        assert beside.other(NAME, True) is None
    monkeypatch.setattr(beside, "cores", lambda: 1)
    with beside.compiled_beside(list):
        assert beside._state["start"] is None


def test_it_ends_with_the_one_that_began_it() -> None:
    """However that ends; what its tasks print or raise is nobody's."""
    content = sent((partial(print, "printed"), partial(int, "raised"), partial(time.sleep, 600.0)))
    program = ["-c", beside._PROGRAM.format(sys.path)]
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, *program], stdin=pipe, stdout=pipe) as process:
        process.stdin.write(len(content).to_bytes(8, "little") + content)
        process.stdin.close()
        assert process.stdout.read() == b""
        assert process.wait(60.0) == 0


RUN = """
import sys
from functools import partial
import geomint as gi
from geomint.kernels.compiling import beside, compile  # noqa: A004
from geomint.problems.testproblems import henon_heiles

beside.cores = lambda: 2
problem, y0 = henon_heiles.problem(), henon_heiles.INITIAL
run = partial(gi.solve, problem, y0, t_end=10.0, step=0.1, method="rk-4", observe=["measure"])
with beside.compiled_beside(lambda: [run]):
    began = beside._state["start"]
    def started():
        helper = began()
        if {broken}:
            helper._sink.close()
        return helper
    beside._state["start"] = started
    print(run().drift["measure"].final_error.hex())
"""


COMPILING = "geomint: compiling (once, then kept in the cache)\n"  # what a script is told, once


@pytest.mark.nightly
@pytest.mark.parametrize("broken", [False, True])
def test_runs_have_the_same_bits(broken: bool, tmp_path: pathlib.Path) -> None:
    """Where another process compiles for them, and where it ends before it has begun."""
    from geomint.problems.testproblems import henon_heiles

    done = subprocess.run(
        [sys.executable, "-c", RUN.format(broken=broken)],
        capture_output=True,
        text=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr in ("", COMPILING)
    alone = gi.solve(
        henon_heiles.problem(), henon_heiles.INITIAL, t_end=10.0, step=0.1, method="rk-4",
        observe=["measure"],
    )  # fmt: skip
    assert done.stdout.strip() == alone.drift["measure"].final_error.hex()
    assert {"runge_kutta_step", "measure"} <= folders(tmp_path)


FLAGS = """
import subprocess, sys
sys.path[:] = {!r}
from geomint.kernels.compiling import beside, compile  # noqa: A004
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
    "options", ["-I -O -W ignore::FutureWarning", "-E -s -OO -B", "-P -b -X pycache_prefix=/none"]
)
def test_it_runs_as_this_process_does(options: str) -> None:
    """With the same options of Python, and nothing from the current folder."""
    command = [sys.executable, *options.split(), "-c", FLAGS.format(sys.path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    own, its = done.stdout.strip().splitlines()
    assert own.replace("safe_path=False", "safe_path=True") == its, done.stderr


def test_who_says_nothing_more_is_not_waited_for(ends, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a process that was stopped: what is compiled twice is none the worse."""
    mine, theirs = ends
    theirs.tell(NAME)
    known(mine, NAME)
    monkeypatch.setattr(beside, "LONGEST", 0.05)
    assert not mine.waited(NAME)


def test_what_fails_is_no_longer_being_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else two processes may wait for each other for ever."""
    told: list[str] = []
    double = type("Double", (), {"tell": lambda self, name: told.append(name)})()
    monkeypatch.setitem(beside._state, "other", double)
    monkeypatch.setattr(double.__class__, "waited", lambda self, name: False, raising=False)

    entry = compile._entry(gi.helper(lambda x: x))
    monkeypatch.setattr(entry, "compile", lambda signature: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        compile._compile(entry, "refused", types.float64(types.float64))
    assert told == [""]


def test_it_ends_by_itself() -> None:
    """When all is done, whatever its input: no thread of it is broken off."""
    command = [sys.executable, "-c", beside._PROGRAM.format(sys.path)]
    content = sent(())
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        process.stdin.write(len(content).to_bytes(8, "little") + content)
        process.stdin.flush()
        assert (process.wait(120.0), process.stderr.read()) == (0, b"")
