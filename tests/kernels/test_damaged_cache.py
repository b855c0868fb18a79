"""Code on the disk that is not what was written is compiled anew; nobody else may write there."""

from __future__ import annotations

import os
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from geomint.kernels.compiling import private
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
    [
        name if name == "flipped" else pytest.param(name, marks=pytest.mark.nightly)
        for name in DAMAGES
    ],
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
@pytest.mark.parametrize("up", [0, 1, 2])
def test_what_others_may_have_put_there_is_not_run(
    up: int, warm: tuple[Path, Outcome], tmp_path: Path
) -> None:
    """Code is kept in the user's own folder instead; what is in the open one stays as it is."""
    cache, first = warm
    files = {path: path.read_bytes() for path in cache.rglob("*.nbc")}
    place = next(iter(files)).parents[up]
    mode = stat.S_IMODE(place.stat().st_mode)
    place.chmod(0o777)
    try:
        for compiled in (first.compiled, []):
            own = str(tmp_path / "own")
            again = run("-W", "ignore", *COMMAND, cache=cache, XDG_CACHE_HOME=own)
            assert again.compiled == compiled
        assert stat.S_IMODE(place.stat().st_mode) == 0o777
    finally:
        place.chmod(mode)
    assert {path: path.read_bytes() for path in cache.rglob("*.nbc")} == files


def test_where_code_is_kept_instead_is_told(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.touch()
    catching = f"""
import warnings
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    exec({REPORT + FIELD + POINTS!r})
assert ["is kept in" in str(w.message) for w in caught] == [True], caught
"""
    own = {"XDG_CACHE_HOME": str(tmp_path / "own")}
    first, second = (run("-c", catching, cache=blocked, **own) for _ in range(2))
    assert first.compiled
    assert second.compiled == []


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for what is kept, and none instead of it."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "none"))
    (tmp_path / "none").touch()
    monkeypatch.setenv("HOME", str(tmp_path / "none"))
    return tmp_path / "cache" / "geomint" / "some"


@posix
@pytest.mark.parametrize("after", ["cache", "geomint", "some"])
def test_a_folder_that_is_swapped_after_a_look_is_held(
    after: str, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever of the folders on the way: what somebody else puts in its place is not read."""
    folder = private_folder("some")
    folder.write("a", b"own")
    place = next(p for p in (kept, *kept.parents) if p.name == after)
    look = private._check

    def swapped(found: os.stat_result, path: Path, last: bool) -> None:
        look(found, path, last)
        if path == place and not place.with_name("away").exists():
            place.rename(place.with_name("away"))
            kept.mkdir(parents=True)
            (kept / "a").write_bytes(b"of somebody")

    monkeypatch.setattr(private, "_check", swapped)
    assert folder.read("a") == b"own"
    assert (kept / "a").read_bytes() == b"of somebody"


@posix
def test_a_folder_that_becomes_open_is_not_read(kept: Path) -> None:
    """It is looked at whenever a file is read or written, not once."""
    folder = private_folder("some")
    folder.write("a", b"own")
    kept.parent.chmod(0o777)
    for call in (folder.read, lambda name: folder.write(name, b"again")):
        with pytest.raises(PermissionError, match="others may write"):
            call("a")
    assert (kept / "a").read_bytes().endswith(b"own")


@posix
def test_a_folder_that_is_removed_is_made_again(kept: Path) -> None:
    folder = private_folder("some")
    folder.write("a", b"one")
    shutil.rmtree(kept)
    assert folder.read("a") is None
    folder.write("a", b"two")
    assert folder.read("a") == b"two"


@posix
def test_what_is_no_file_of_the_user_is_left_alone(kept: Path, tmp_path: Path) -> None:
    """Neither read nor replaced, nor is what it leads to."""
    folder = private_folder("some")
    (tmp_path / "elsewhere").write_bytes(b"of somebody")
    (kept / "link").symlink_to(tmp_path / "elsewhere")
    (kept / "folder").mkdir()
    os.mkfifo(kept / "fifo")
    for name in ("link", "folder", "fifo"):
        before = (kept / name).lstat()
        assert folder.read(name) is None
        with pytest.raises(FileExistsError, match="no file of geomint's"):
            folder.write(name, b"own")
        assert (kept / name).lstat() == before
    assert (tmp_path / "elsewhere").read_bytes() == b"of somebody"
    assert sorted(path.name for path in kept.iterdir()) == ["fifo", "folder", "link"]


@posix
def test_a_file_that_others_may_write_to_is_not_read(kept: Path) -> None:
    folder = private_folder("some")
    folder.write("a", b"of somebody")
    (kept / "a").chmod(0o666)
    assert folder.read("a") is None
    folder.write("a", b"own")
    assert folder.read("a") == b"own"
    assert stat.S_IMODE((kept / "a").stat().st_mode) == 0o600


@posix
def test_what_is_written_is_whole(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If it cannot be moved to its place, the old one stays, and nothing beside it."""
    folder = private_folder("some")
    folder.write("a", b"one")

    def fail(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(private.os, "replace", fail)
    with pytest.raises(KeyboardInterrupt):
        folder.write("a", b"two")
    assert [path.name for path in kept.iterdir()] == ["a"]
    assert folder.read("a") == b"one"


@posix
def test_a_file_under_another_name_is_not_read(kept: Path) -> None:
    """Whoever has copied it there: whole as it is, it is the code of another function."""
    folder = private_folder("some")
    for name in "ab":
        folder.write(name, name.encode())
    shutil.copy(kept / "a", kept / "b")
    assert (folder.read("a"), folder.read("b")) == (b"a", None)
    (kept / "a").write_bytes(flipped((kept / "a").read_bytes()))
    assert folder.read("a") is None


@posix
@pytest.mark.parametrize("whose", ["of another user", "in a folder of all"])
def test_links_to_the_folder_are_looked_at(whose: str, kept: Path, tmp_path: Path) -> None:
    """Who can make or change one of them says where code is read from."""
    own = tmp_path / "own" / "geomint"
    own.mkdir(parents=True)
    link = tmp_path / "team" / "link"
    link.parent.mkdir()
    link.symlink_to("../own")
    (tmp_path / "cache").symlink_to(link)
    private_folder("some").write("a", b"own")
    assert [path.name for path in own.iterdir()] == ["some"]
    if whose == "of another user":
        if os.geteuid():
            pytest.skip("only root makes links of others")
        os.lchown(link, 1234, -1)
    else:
        link.parent.chmod(0o777)
    with pytest.raises(OSError, match=r"team"):
        private_folder("some")


@posix
@pytest.mark.parametrize("way", ["cache", "cache/geomint", "cache/geomint/some"])
def test_nothing_is_removed_where_a_link_leads(way: str, kept: Path, tmp_path: Path) -> None:
    """To a folder that others may write to: it stays as it is."""
    theirs = tmp_path / "theirs"
    (theirs / "folder").mkdir(parents=True)
    (theirs / "file").touch()
    theirs.chmod(0o777)
    (tmp_path / way).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / way).symlink_to(theirs)
    with pytest.raises(OSError, match="others may write"):
        private_folder("some")
    assert sorted(path.name for path in theirs.iterdir()) == ["file", "folder"]
    assert stat.S_IMODE(theirs.stat().st_mode) == 0o777
    theirs.chmod(0o700)
    private_folder("some").write("a", b"own")
    assert (theirs / "file").exists()


@posix
def test_a_link_that_others_may_turn(kept: Path, tmp_path: Path) -> None:
    """It lies where they may write, though it leads to a folder of the user's alone."""
    (tmp_path / "mine").mkdir(mode=0o700)
    (tmp_path / "cache").mkdir()
    kept.parent.symlink_to(tmp_path / "mine")
    (tmp_path / "cache").chmod(0o777)
    with pytest.raises(OSError, match="others may write"):
        private_folder("some")


@posix
def test_links_that_lead_in_a_circle(kept: Path, tmp_path: Path) -> None:
    (tmp_path / "cache").symlink_to(tmp_path / "cache")
    with pytest.raises(OSError, match="cache"):
        private_folder("some")


@posix
def test_sticky_folders_are_passed_but_nothing_is_kept_in_them(kept: Path) -> None:
    kept.parent.mkdir(parents=True)
    kept.parent.chmod(0o1777)
    private_folder("some").write("a", b"own")
    kept.chmod(0o1777)
    with pytest.raises(OSError, match="others may write"):
        private_folder("some")


@posix
def test_the_group_may_write_where_it_is_the_users_own(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As with a umask of 002: of the user's name, with nobody else in it, and no list of others."""
    import grp
    import pwd

    kept.mkdir(parents=True)
    for place in (kept, kept.parent):
        place.chmod(0o775)
    number, user = kept.stat().st_gid, SimpleNamespace(pw_name="me", pw_gid=kept.stat().st_gid)
    other = SimpleNamespace(pw_name="other", pw_gid=number)
    listing = hasattr(os, "listxattr")
    for name, more, users, listed, allowed in [
        ("me", [], [user], [], True),
        ("me", ["me"], [user], ["user.some"], True),
        ("staff", [], [user], [], False),
        ("me", ["other"], [user], [], False),
        ("me", [], [user, other], [], False),
        ("me", [], [user], ["system.posix_acl_access"], not listing),
    ]:
        group = SimpleNamespace(gr_name=name, gr_mem=more)
        monkeypatch.setattr(grp, "getgrgid", lambda _, group=group: group)
        monkeypatch.setattr(pwd, "getpwuid", lambda _: user)
        monkeypatch.setattr(pwd, "getpwall", lambda users=users: users)
        if listing:
            monkeypatch.setattr(os, "listxattr", lambda _, listed=listed: listed)
        private._alone.cache_clear()
        if allowed:
            private_folder("some").write("a", b"own")
        else:
            with pytest.raises(OSError, match="others may write"):
                private_folder("some")
    private._alone.cache_clear()


def test_where_folders_cannot_be_held(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There the user's own folder is taken in place of a given one."""
    monkeypatch.setattr(private, "_HELD", False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    folder = private_folder("some")
    assert tmp_path / "cache" not in folder.path.parents
    assert "cannot be held" in folder.instead_of
    folder.write("a", b"own")
    assert folder.read("a") == b"own"
    assert not kept.exists()


@posix
def test_a_folder_that_is_gone_below_the_process(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A relative name means nothing there: the user's own folder is taken."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", "relative")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert private_folder("some").path == tmp_path / "here" / "relative" / "geomint" / "some"
    shutil.rmtree(tmp_path / "here")
    assert private_folder("some").path.is_relative_to(tmp_path / "own")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def anywhere() -> Iterator[Path]:
    """A folder that every user may pass through."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o711)
        yield Path(name)


@contextmanager
def another_user(number: int) -> Iterator[None]:
    os.seteuid(number)
    try:
        yield
    finally:
        os.seteuid(0)


root = pytest.mark.skipif(
    getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can become another user"
)


@posix
@root
def test_folders_that_may_be_passed_but_not_read(
    anywhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As /home often is; what other users have put in a sticky folder is not taken."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(anywhere / "own"))
    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, "/dev/null/none")
    (anywhere / "own").mkdir()
    os.chown(anywhere / "own", 12345, 12345)
    with another_user(12345):
        private_folder("some").write("a", b"own")
    for who in (0, 23456):  # nor is what that one keeps another's, nor root's
        with another_user(who), pytest.raises(OSError, match="another user"):
            private_folder("some")
    shared = anywhere / "own" / "geomint" / "some"
    for owner in (23456, 0):
        os.chown(shared, owner, -1)
        with another_user(12345), pytest.raises(OSError, match="another user"):
            private_folder("some")
    os.chown(shared, 12345, -1)
    os.chown(shared / "a", 23456, -1)
    (shared / "a").chmod(0o644)
    with another_user(12345):
        assert private_folder("some").read("a") is None


@posix
@pytest.mark.skipif(
    getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can give files away"
)
def test_a_folder_of_another_user_is_not_used(warm: tuple[Path, Outcome]) -> None:
    cache, first = warm
    folder = next(path.parent for path in cache.rglob("*.nbc"))
    os.chown(folder, 12345, -1)
    try:
        own = str(cache / "own")
        outcome = run("-W", "ignore", *COMMAND, cache=cache, XDG_CACHE_HOME=own)
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
    assert run("-W", "ignore", *COMMAND, cache=cache).results == first.results
    assert all(stat.S_ISFIFO(path.lstat().st_mode) for path in cache.rglob("*.nbc"))


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
assert "there is no home folder; let NUMBA_CACHE_DIR name" in str(caught[0].message), caught
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
        env={
            **os.environ,
            **dict.fromkeys(("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"), str(tmp_path / "file")),
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
