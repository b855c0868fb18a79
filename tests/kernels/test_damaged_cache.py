"""Code on the disk that is not what was written is compiled anew; nobody else may write there."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from geomint.kernels.compiling.private import private_folder

from .test_cache import FIELD, POINTS, REPORT, Outcome, run

posix = pytest.mark.skipif(os.name != "posix", reason="of POSIX")
COMMAND = ("-c", REPORT + FIELD + POINTS)


def flipped(content: bytes) -> bytes:
    """Change a bit in the middle, which is machine code: it could be unpickled and run."""
    damaged = bytearray(content)
    damaged[len(damaged) // 2] ^= 1
    return bytes(damaged)


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": lambda content: content[: len(content) // 2],
    "empty": lambda content: b"",
    "zeroed": lambda content: bytes(len(content)),
    "flipped": flipped,
    "last byte": lambda content: content[:-1] + bytes([content[-1] ^ 1]),
    "checksum alone": lambda content: content[:32],
    "longer": lambda content: content + b"\0",
    "not a pickle": lambda content: b"x" * 1000,
}


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    folder = tmp_path_factory.mktemp("cache")
    return folder, run(*COMMAND, cache=folder)


@pytest.mark.parametrize(
    "damage",
    [name if name == "flipped" else pytest.param(name, marks=pytest.mark.slow) for name in DAMAGES],
)
def test_damaged_code_is_compiled_anew(damage: str, warm: tuple[Path, Outcome]) -> None:
    """Whatever was done to all files of the cache: the same bits, and a sound cache after it."""
    folder, first = warm
    files = list(folder.rglob("*.nbc"))
    assert len(files) == 3
    for path in files:
        path.write_bytes(DAMAGES[damage](path.read_bytes()))
    second = run(*COMMAND, cache=folder)
    assert second.compiled == first.compiled
    assert second.results == first.results
    assert run(*COMMAND, cache=folder).compiled == []


@posix
def test_the_folder_is_private_whatever_the_umask(tmp_path: Path) -> None:
    script = "import os; os.umask(0)\n" + REPORT + FIELD + POINTS
    run("-c", script, cache=tmp_path)
    folders = [path for path in (tmp_path / "geomint").rglob("*") if path.is_dir()]
    assert folders
    for folder in (tmp_path / "geomint", *folders):
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700, folder


@posix
def test_what_others_may_have_put_there_is_not_run(warm: tuple[Path, Outcome]) -> None:
    """A folder that was open to all loses its content before anything of it is unpickled."""
    cache, first = warm
    folder = next(path.parent for path in cache.rglob("*.nbc"))
    folder.chmod(0o777)
    again = run(*COMMAND, cache=cache)
    assert again.compiled == first.compiled
    assert stat.S_IMODE(folder.stat().st_mode) & 0o022 == 0


@posix
@pytest.mark.parametrize("removable", [True, False])
def test_nothing_stays_of_an_open_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, removable: bool
) -> None:
    """Whatever was put there; if it cannot be removed, no later process trusts it either."""
    folder = tmp_path / "kernels"
    (folder / "a" / "b").mkdir(parents=True)
    (folder / "link").symlink_to(tmp_path)
    (folder / "z.nbc").touch()
    folder.chmod(0o777)
    with monkeypatch.context() as patch:
        if not removable:
            patch.setattr("shutil.rmtree", lambda place: Path(place).unlink())
            for _ in range(2):
                with pytest.raises(OSError, match="a"):
                    private_folder(folder)
            assert stat.S_IMODE(folder.stat().st_mode) == 0o777
    private_folder(folder)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o755
    assert list(folder.iterdir()) == []


@posix
@pytest.mark.skipif(
    getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can give files away"
)
def test_a_folder_of_another_user_is_not_used(warm: tuple[Path, Outcome]) -> None:
    cache, first = warm
    folder = next(path.parent for path in cache.rglob("*.nbc"))
    os.chown(folder, 12345, -1)
    try:
        outcome = run("-W", "ignore", *COMMAND, cache=cache)
        assert outcome.compiled == first.compiled
    finally:
        os.chown(folder, 0, -1)


@posix
def test_a_fifo_in_the_place_of_code(warm: tuple[Path, Outcome]) -> None:
    """Nobody writes to it, so reading it would take for ever."""
    cache, first = warm
    for path in list(cache.rglob("*.nbc")):
        path.unlink()
        os.mkfifo(path)
    assert run(*COMMAND, cache=cache).results == first.results
    assert run(*COMMAND, cache=cache).compiled == []


@posix
def test_without_a_home(tmp_path: Path) -> None:
    """Nor an entry of the user: a note that says what to set, no traceback, no folder called ~."""
    script = (
        """
import os, pwd
def nobody(*_): raise KeyError("uid not found")
pwd.getpwuid = pwd.getpwnam = nobody
for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):
    os.environ.pop(name, None)
import warnings
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
"""
        + "".join(f"    {line}\n" for line in (REPORT + FIELD + POINTS).splitlines())
        + """
assert "set NUMBA_CACHE_DIR" in str(caught[0].message), caught
assert len(caught) == 1
"""
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.iterdir()) == []


FORK = """
import os, threading, time, warnings
import geomint as gi
from geomint.kernels.compiling import compile as _compile
warnings.simplefilter("ignore", DeprecationWarning)  # of Python, about forks and threads
begun = threading.Event()
_compile.listen(lambda name, seconds: begun.set())



@gi.field
def turn(params, t, y, out, work):
    out[0] = params[0] * y[1]
    out[1] = -y[0]


def run(f):
    return gi.pointwise(f, [1.5], [[0.5, 0.3]], rows=2)


thread = threading.Thread(target=run, args=(spring,))
thread.start()
begun.wait()
child = os.fork()
if child == 0:
    os._exit(0 if len(run(turn)) else 1)
end = time.monotonic() + 100
while time.monotonic() < end:
    pid, status = os.waitpid(child, os.WNOHANG)
    if pid:
        break
    time.sleep(0.1)
else:
    os.kill(child, 9)
    raise SystemExit("the child hangs")
thread.join()
raise SystemExit(os.waitstatus_to_exitcode(status))
"""


@posix
def test_a_fork_while_a_thread_compiles(tmp_path: Path) -> None:
    """The child does not wait for a lock whose thread it does not have."""
    done = subprocess.run(
        [sys.executable, "-c", FIELD + FORK],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
        timeout=200,
    )
    assert done.returncode == 0, done.stderr


class Compiling:
    """A dispatcher during whose compilation Ctrl-C is pressed so many times."""

    def __init__(self, times: int) -> None:
        self.overloads: dict[Any, Any] = {}
        self.stats = SimpleNamespace(cache_misses={})
        self.times, self.done = times, False

    def disable_compile(self, disabled: bool = True) -> None:
        pass

    def compile(self, signature: Any) -> None:
        for _ in range(self.times):
            signal.raise_signal(signal.SIGINT)
        self.done = True


@pytest.mark.parametrize(("times", "done"), [(1, True), (2, False)])
def test_ctrl_c_waits_for_a_compilation(times: int, done: bool) -> None:
    """What is broken off there may never compile again in the process; a second one does not wait."""
    from geomint.kernels.compiling import compile as compiling

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        dispatcher = Compiling(times)
        with pytest.raises(KeyboardInterrupt):
            compiling._compile(dispatcher, "f", SimpleNamespace(args=()))
        assert dispatcher.done is done
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


POINTWISE = (
    FIELD
    + """
import warnings
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    for _ in range(2):
        gi.pointwise(spring, [1.0], [[0.5, 0.0]], rows=2)
assert ["cannot be kept" in str(w.message) for w in caught] == [True], caught
"""
)


def test_every_compilation_tells_that_it_is_not_kept(tmp_path: Path) -> None:
    """Also outside of runs; once a process."""
    (tmp_path / "file").touch()
    done = subprocess.run(
        [sys.executable, "-c", POINTWISE],
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "file")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
