"""Code on the disk that is not what was written is compiled anew; nobody else may write there."""

from __future__ import annotations

import os
import shutil
import signal
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest

import geomint as gi
from geomint.kernels.compiling import cache, private
from geomint.kernels.compiling.compile import listen

from .test_cache import FIELD, evaluated, run

pytestmark = pytest.mark.skipif(os.name != "posix", reason="of POSIX")
root = pytest.mark.skipif(
    getattr(os, "geteuid", lambda: 1)() != 0, reason="only root can become another user"
)


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for what is kept, and none instead of it; nothing has been told yet."""
    monkeypatch.setattr(cache, "_notes", {})
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "none").touch()
    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.setenv(name, str(tmp_path / "none"))
    return tmp_path / "cache" / "geomint" / "some"


def refused(words: str = "others may write") -> None:
    with pytest.raises(OSError, match=words):
        private.private_folder("some")


# --- code -----------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_code_is_compiled_anew(damage: str, kept: Path) -> None:
    """Whatever was done to a file of the cache: it is not read, and sound after it."""
    compiled, first = evaluated()
    (path,) = kept.parent.glob("kernels-*/spring-*.nbc")
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    assert cache.cache_folder().read(path.name) is None
    assert evaluated() == (compiled, first)
    assert evaluated() == ([], first)


@pytest.mark.parametrize(
    ("up", "owner"), [(0, -1), (1, -1), (2, -1), pytest.param(0, 12345, marks=root)]
)
def test_what_others_may_have_put_there_is_not_run(
    up: int, owner: int, kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Code is kept in the user's own folder, which is told once; what is in theirs stays as it is."""
    first = evaluated()
    files = {path: path.read_bytes() for path in kept.parent.rglob("*.nbc")}
    place = next(iter(files)).parents[up]
    place.chmod(0o777 if owner < 0 else 0o700)
    os.chown(place, owner, -1)
    before = place.stat()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    with pytest.warns(gi.SpeedWarning, match="is kept in"):
        assert evaluated() == first
    assert evaluated() == ([], first[1])
    assert (place.stat().st_mode, place.stat().st_uid) == (before.st_mode, before.st_uid)
    assert {path: path.read_bytes() for path in kept.parent.rglob("*.nbc")} == files


@pytest.mark.parametrize("home", [True, False])
def test_where_nothing_can_be_kept(
    home: bool, kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All is compiled anew, which is told once, with what to set; there is no folder called ~."""
    import pwd

    def nobody(*_: object) -> None:
        raise KeyError("uid not found")

    first, words = evaluated(), "cannot be kept"
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "none"))
    if not home:
        words = "there is no home folder; let NUMBA_CACHE_DIR name"
        for name in ("HOME", "XDG_CACHE_HOME", "NUMBA_CACHE_DIR"):
            monkeypatch.delenv(name)
        monkeypatch.setattr(pwd, "getpwuid", nobody)
        monkeypatch.setattr(pwd, "getpwnam", nobody)
    with pytest.warns(gi.SpeedWarning, match=words) as told:
        assert evaluated() == first
    assert len(told) == 1
    assert evaluated() == first
    assert list((tmp_path / "here").iterdir()) == []


@pytest.mark.parametrize(("times", "done"), [(1, True), (2, False)])
def test_ctrl_c_waits_for_a_compilation(times: int, done: bool, kept: Path) -> None:
    """What is broken off there may never compile again in the process; a second one does not wait."""
    waited: list[str] = []

    def press(name: str, seconds: float | None) -> None:
        if seconds is None:
            for _ in range(times):
                signal.raise_signal(signal.SIGINT)
            waited.append(name)

    before, end = signal.signal(signal.SIGINT, signal.default_int_handler), listen(press)
    try:
        with pytest.raises(KeyboardInterrupt):
            evaluated()
        assert waited == ["spring"] * done
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        end()
        signal.signal(signal.SIGINT, before)
    assert len(evaluated()[0]) == 2 * (not done)


FORK = """
import json, os, threading, time, warnings
from geomint.kernels.compiling.compile import listen
warnings.simplefilter("ignore", DeprecationWarning)  # of Python, about forks and threads
begun = threading.Event()
listen(lambda name, seconds: begun.set())


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
print(json.dumps(os.waitstatus_to_exitcode(status)))
"""


def test_a_fork_while_a_thread_compiles(tmp_path: Path) -> None:
    """The child does not wait for a lock whose thread it does not have."""
    assert run("-c", FIELD + FORK, cache=tmp_path) == 0


# --- the folder -----------------------------------------------------------------------------------


def test_the_folder_is_private_whatever_the_umask(kept: Path) -> None:
    before = os.umask(0)
    try:
        private.private_folder("some").write("a", b"own")
    finally:
        os.umask(before)
    assert [stat.S_IMODE(x.stat().st_mode) for x in (kept, kept.parent, kept / "a")] == [
        *(0o700, 0o700, 0o600)
    ]


@pytest.mark.parametrize("after", ["cache", "geomint", "some"])
def test_a_folder_that_is_swapped_after_a_look_is_held(
    after: str, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever of the folders on the way: what somebody else puts in its place is not read."""
    folder = private.private_folder("some")
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


def test_the_folder_is_looked_at_whenever_it_is_used(kept: Path) -> None:
    """One that becomes open is neither read nor written to; one that is removed is made again."""
    folder = private.private_folder("some")
    folder.write("a", b"own")
    kept.parent.chmod(0o777)
    for call in (folder.read, lambda name: folder.write(name, b"again")):
        with pytest.raises(PermissionError, match="others may write"):
            call("a")
    assert (kept / "a").read_bytes().endswith(b"own")
    kept.parent.chmod(0o700)
    shutil.rmtree(kept)
    assert folder.read("a") is None
    folder.write("a", b"two")
    assert folder.read("a") == b"two"


def test_what_is_no_file_of_the_user_is_left_alone(kept: Path, tmp_path: Path) -> None:
    """Neither read nor replaced, nor is what it leads to; nobody writes to a FIFO: it would wait."""
    folder = private.private_folder("some")
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


def test_files_that_may_be_of_others_are_not_read(kept: Path) -> None:
    """Those that others may write to, or that were copied there: they are code of other functions."""
    folder = private.private_folder("some")
    for name in "ab":
        folder.write(name, name.encode())
    shutil.copy(kept / "a", kept / "b")
    assert (folder.read("a"), folder.read("b")) == (b"a", None)
    (kept / "a").chmod(0o666)
    assert folder.read("a") is None
    folder.write("a", b"own")
    assert folder.read("a") == b"own"
    assert stat.S_IMODE((kept / "a").stat().st_mode) == 0o600


def test_what_is_written_is_whole(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If it cannot be moved to its place, the old one stays, and nothing beside it."""
    folder = private.private_folder("some")
    folder.write("a", b"one")

    def fail(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(private.os, "replace", fail)
    with pytest.raises(KeyboardInterrupt):
        folder.write("a", b"two")
    assert [path.name for path in kept.iterdir()] == ["a"]
    assert folder.read("a") == b"one"


@pytest.mark.parametrize(
    "whose", [pytest.param("of another user", marks=root), "in a folder of all"]
)
def test_links_to_the_folder_are_looked_at(whose: str, kept: Path, tmp_path: Path) -> None:
    """Who can make or change one of them says where code is read from."""
    own = tmp_path / "own" / "geomint"
    own.mkdir(parents=True)
    link = tmp_path / "team" / "link"
    link.parent.mkdir()
    link.symlink_to("../own")
    (tmp_path / "cache").symlink_to(link)
    private.private_folder("some").write("a", b"own")
    assert [path.name for path in own.iterdir()] == ["some"]
    if whose == "of another user":
        os.lchown(link, 1234, -1)
    else:
        link.parent.chmod(0o777)
    refused("team")


@pytest.mark.parametrize("way", ["cache", "cache/geomint", "cache/geomint/some"])
def test_nothing_is_removed_where_a_link_leads(way: str, kept: Path, tmp_path: Path) -> None:
    """To a folder that others may write to: it stays as it is."""
    theirs = tmp_path / "theirs"
    (theirs / "folder").mkdir(parents=True)
    (theirs / "file").touch()
    theirs.chmod(0o777)
    (tmp_path / way).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / way).symlink_to(theirs)
    refused()
    assert sorted(path.name for path in theirs.iterdir()) == ["file", "folder"]
    assert stat.S_IMODE(theirs.stat().st_mode) == 0o777
    theirs.chmod(0o700)
    private.private_folder("some").write("a", b"own")
    assert (theirs / "file").exists()


def test_links_in_bad_places(kept: Path, tmp_path: Path) -> None:
    """In a circle; and where others may turn it, though it leads to a folder of the user's alone."""
    (tmp_path / "cache").symlink_to(tmp_path / "cache")
    refused("cache")
    (tmp_path / "cache").unlink()
    (tmp_path / "mine").mkdir(mode=0o700)
    (tmp_path / "cache").mkdir()
    kept.parent.symlink_to(tmp_path / "mine")
    private.private_folder("some")
    (tmp_path / "cache").chmod(0o777)
    refused()


def test_sticky_folders_are_passed_but_nothing_is_kept_in_them(kept: Path) -> None:
    kept.parent.mkdir(parents=True)
    kept.parent.chmod(0o1777)
    private.private_folder("some").write("a", b"own")
    kept.chmod(0o1777)
    refused()


def test_the_group_may_write_where_it_is_the_users_own(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As with a umask of 002: of the user's name, with nobody else in it, and no list of others."""
    import grp
    import pwd

    kept.mkdir(parents=True)
    for place in (kept, kept.parent):
        place.chmod(0o775)
    number = kept.stat().st_gid
    user, other = (SimpleNamespace(pw_name=name, pw_gid=number) for name in ("me", "other"))
    listing = hasattr(os, "listxattr")
    monkeypatch.setattr(pwd, "getpwuid", lambda _: user)
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
        monkeypatch.setattr(pwd, "getpwall", lambda users=users: users)
        if listing:
            monkeypatch.setattr(os, "listxattr", lambda _, listed=listed: listed)
        private._alone.cache_clear()
        if allowed:
            private.private_folder("some").write("a", b"own")
        else:
            refused()
    private._alone.cache_clear()


def test_where_folders_cannot_be_held(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There the user's own folder is taken in place of a given one."""
    monkeypatch.setattr(private, "_HELD", False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    folder = private.private_folder("some")
    assert tmp_path / "cache" not in folder.path.parents
    assert "cannot be held" in folder.instead_of
    folder.write("a", b"own")
    assert folder.read("a") == b"own"
    assert not kept.exists()


def test_a_folder_that_is_gone_below_the_process(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A relative name means nothing there: the user's own folder is taken."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "own"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", "relative")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    assert (
        private.private_folder("some").path == tmp_path / "here" / "relative" / "geomint" / "some"
    )
    shutil.rmtree(tmp_path / "here")
    assert private.private_folder("some").path.is_relative_to(tmp_path / "own")
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


@root
def test_folders_that_may_be_passed_but_not_read(
    anywhere: Path, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As /home often is; what other users have put in a sticky folder is not taken."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(anywhere / "own"))
    (anywhere / "own").mkdir()
    os.chown(anywhere / "own", 12345, 12345)
    with another_user(12345):
        private.private_folder("some").write("a", b"own")
    for who in (0, 23456):  # nor is what that one keeps another's, nor root's
        with another_user(who):
            refused("another user")
    shared = anywhere / "own" / "geomint" / "some"
    for owner in (23456, 0):
        os.chown(shared, owner, -1)
        with another_user(12345):
            refused("another user")
    os.chown(shared, 12345, -1)
    os.chown(shared / "a", 23456, -1)
    (shared / "a").chmod(0o644)
    with another_user(12345):
        assert private.private_folder("some").read("a") is None
