"""Files appear whole or not at all, and nothing but regular files is replaced."""

import errno
import json
import os
import shutil
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

import geomint as gi
from geomint.reports.files import sealed
from geomint.run.files import outputs, workplace

posix = pytest.mark.skipif(os.name != "posix", reason="of POSIX")
root = pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="root gives files away")


def write(path, text="new"):
    with gi.whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def contents(folder):
    return {p.name: p.read_text(encoding="utf-8") for p in Path(folder).iterdir() if p.is_file()}


def leftovers(folder):
    found = [p for p in Path(folder).rglob("*") if p.name.startswith(".geomint")]
    return [p.name for p in found if not p.parent.name.startswith(".geomint")]


def test_a_new_and_an_old_file(tmp_path):
    """Beside others of the user's, which may have any name."""
    path, others = tmp_path / "run.nc", ["run.nc.part", ".geomint-0", "run.nc~"]
    for name in others:
        (tmp_path / name).write_text("mine", encoding="utf-8")
    for text in ("first", "second"):
        write(path, text)
        assert contents(tmp_path) == {"run.nc": text, **dict.fromkeys(others, "mine")}


@posix
def test_permissions_are_those_of_the_old_file_or_of_the_user(tmp_path):
    path, mask = tmp_path / "run.nc", os.umask(0o027)
    try:
        write(path)
        assert stat.S_IMODE(path.stat().st_mode) == 0o640
        path.chmod(0o604)
        with gi.whole_file(path) as unfinished:
            assert stat.S_IMODE(unfinished.stat().st_mode) == 0o604
        assert stat.S_IMODE(path.stat().st_mode) == 0o604
    finally:
        os.umask(mask)


@posix
def test_symlinks_are_followed(tmp_path):
    """Whether or not something is there."""
    target, link = tmp_path / "elsewhere" / "run.nc", tmp_path / "link.nc"
    target.parent.mkdir()
    link.symlink_to(target)
    for text in ("new", "newer"):
        write(link, text)
        assert link.is_symlink()
        assert target.read_text(encoding="utf-8") == text
    assert leftovers(tmp_path) == []


@posix
@pytest.mark.parametrize("kind", ["folder", "fifo", "device", "link to a device", "loop"])
def test_nothing_but_regular_files_is_replaced(tmp_path, kind):
    path = tmp_path / "out"
    if kind == "folder":
        path.mkdir()
    elif kind == "fifo":
        os.mkfifo(path)
    elif kind == "device":
        path = Path(os.devnull)
    else:
        path.symlink_to(os.devnull if kind == "link to a device" else path)
    before = path.lstat()
    for call in (gi.check_file, write):
        with pytest.raises(gi.OutputError):
            call(path)
    assert path.lstat()[:2] == before[:2]  # of the same kind, the same one


@posix
@pytest.mark.skipif(getattr(os, "geteuid", lambda: 0)() == 0, reason="root may write everything")
def test_a_file_that_may_not_be_written(tmp_path):
    path = tmp_path / "run.nc"
    write(path)
    path.chmod(0o444)
    with pytest.raises(gi.OutputError, match="may not be written"):
        write(path)


@pytest.mark.parametrize(
    "path", ["missing/run.nc", "file/run.nc", "nul\0l", "x" * 300, "\ud800", "y" * 10_000]
)
def test_places_that_are_none(tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("", encoding="utf-8")
    with pytest.raises(gi.OutputError, match="cannot be written") as caught:
        write(path)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("path", [None, 3, b"run.nc", ["run.nc"]])
def test_what_is_no_path(path):
    for call in (gi.check_file, gi.check_folder, gi.load, write):
        with pytest.raises(gi.DomainError, match="path"):
            call(path)


@posix
@pytest.mark.parametrize("way", ["itself", "symlink", "hard link"])
def test_what_is_read_is_not_written_over(tmp_path, way):
    """By any name, whatever writes."""
    source, other = tmp_path / "source", tmp_path / "other"
    source.write_text("old")
    with pytest.raises(gi.SceneError):
        gi.load_scene(source)
    if way == "symlink":
        other.symlink_to(source)
    elif way == "hard link":
        other.hardlink_to(source)
    place = source if way == "itself" or not other.exists() else other
    for attempt in (gi.check_file, write, lambda path: gi.check_folder(path.parent, [path.name])):
        with pytest.raises(gi.OutputError, match=r"it is the input|a symlink, which is left"):
            attempt(place)
    with pytest.raises(gi.OutputError, match=r"the input|a symlink"):
        write_report(tmp_path, "new", [place.name])
    assert source.read_text() == place.read_text() == "old"
    assert leftovers(tmp_path) == []
    write(tmp_path / "third")  # whose neighbours may be read
    write(tmp_path / "third")


def test_an_error_while_writing_leaves_the_old_file(tmp_path):
    path = tmp_path / "run.nc"
    write(path, "old")

    def write_half(failure):
        with gi.whole_file(path) as unfinished:
            unfinished.write_text("half", encoding="utf-8")
            raise failure

    for failure in (ValueError("of the writer"), KeyboardInterrupt(), OSError(errno.ENOSPC, "")):
        with pytest.raises((ValueError, KeyboardInterrupt, gi.OutputError)):
            write_half(failure)
        assert path.read_text(encoding="utf-8") == "old"
    assert leftovers(tmp_path) == []


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EFBIG, errno.EDQUOT])
def test_a_full_disk_is_typed(tmp_path, monkeypatch, number):
    def fail(*_):
        raise OSError(number, os.strerror(number))

    path = tmp_path / "run.nc"
    write(path, "old")
    monkeypatch.setattr(outputs.os, "fsync", fail)
    with pytest.raises(gi.OutputError) as caught:
        write(path)
    assert caught.value.errno == number
    assert path.read_text(encoding="utf-8") == "old"
    for check, place in ((gi.check_file, path), (gi.check_folder, tmp_path)):
        with pytest.raises(gi.OutputError):
            check(place)
    assert leftovers(tmp_path) == []


NAMES = ("a.json", "b.png", "c.html")


def write_report(folder, text="new", names=NAMES):
    with gi.whole_folder(folder) as unfinished:
        for name in names:
            (unfinished / name).write_text(text, encoding="utf-8")


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    write_report(tmp_path / "report", "old")
    (tmp_path / "report" / "notes.txt").write_text("mine", encoding="utf-8")
    write_report(tmp_path / "report", "new", (*NAMES, "d.svg"))
    expected = {"notes.txt": "mine", "d.svg": "new", **dict.fromkeys(NAMES, "new")}
    assert contents(tmp_path / "report") == expected


@pytest.mark.parametrize("failing", range(3))
def test_or_not_at_all(tmp_path, monkeypatch, failing):
    """Whichever of its files cannot be moved: the old ones are all there, the new ones are not."""
    write_report(tmp_path / "report", "old", NAMES[:2])
    put, calls = outputs._put, []

    def failing_put(unfinished, target):
        calls.append(target)
        if len(calls) == failing + 1:
            raise OSError(errno.EDQUOT, "quota")
        put(unfinished, target)

    monkeypatch.setattr(outputs, "_put", failing_put)
    with pytest.raises(gi.OutputError, match="quota"):
        write_report(tmp_path / "report", "new")
    assert contents(tmp_path / "report") == dict.fromkeys(NAMES[:2], "old")


def test_a_folder_in_the_place_of_a_file(tmp_path):
    write_report(tmp_path, "old", NAMES[:2])
    (tmp_path / NAMES[2]).mkdir()
    with pytest.raises(gi.OutputError, match="a folder"):
        write_report(tmp_path, "new")
    assert (tmp_path / NAMES[0]).read_text(encoding="utf-8") == "old"


@posix
@pytest.mark.parametrize("name", NAMES)
def test_symlinks_in_a_folder_are_left_alone(tmp_path, name):
    """Whether a file would be written there, or only removed; the folder itself may be one."""
    elsewhere, folder = tmp_path / "elsewhere", tmp_path / "report"
    elsewhere.write_text("mine", encoding="utf-8")
    folder.mkdir()
    (folder / name).symlink_to(elsewhere)
    for call in (
        lambda: write_report(folder, "new"),
        lambda: make_report(folder, "new", NAMES[:1]),
        lambda: gi.check_folder(folder, NAMES),
    ):
        with pytest.raises(gi.OutputError, match=f"{name[0]}.*a symlink, which is left alone"):
            call()
    assert contents(folder) == {name: "mine"}
    (folder / name).unlink()
    (tmp_path / "link").symlink_to(folder)
    write_report(tmp_path / "link", "new")
    assert contents(folder) == dict.fromkeys(NAMES, "new")


WRITER = """
import sys
from geomint.run.files.outputs import whole_file, whole_folder
place, text = sys.argv[1:]
for _ in range(15):
    with whole_file(place + "/file") as unfinished:
        unfinished.write_text(text * 200_000)
    with whole_folder(place + "/folder") as unfinished:
        for name in "abcdef":
            (unfinished / name).write_text(text)
"""


@posix
def test_of_several_processes_the_last_complete_one_wins(tmp_path):
    command = [sys.executable, "-c", WRITER, str(tmp_path)]
    writers = [subprocess.Popen([*command, text]) for text in "xy"]
    file = tmp_path / "file"
    while any(w.poll() is None for w in writers):
        if file.exists():
            content = file.read_text(encoding="utf-8")
            assert (len(content), len(set(content))) == (200_000, 1)
    assert [w.returncode for w in writers] == [0, 0]
    found = contents(tmp_path / "folder")
    assert (sorted(found), len(set(found.values()))) == (list("abcdef"), 1)
    assert leftovers(tmp_path) == []


@posix
def test_another_process_that_keeps_the_folder(tmp_path, monkeypatch):
    import fcntl

    descriptor = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    monkeypatch.setattr(outputs, "PATIENCE", 0.05)
    try:
        for call, *given in ((write_report,), (gi.check_folder, NAMES)):
            with pytest.raises(gi.OutputError, match="somebody else is writing"):
                call(tmp_path, *given)
        gi.check_folder(tmp_path)  # of which nothing is to be replaced
    finally:
        os.close(descriptor)
    assert contents(tmp_path) == {}


def make_report(folder, text, names=NAMES):
    """Write files as a report does, with their digests in its JSON."""
    with gi.whole_folder(folder, NAMES) as unfinished:
        for name in names[1:]:
            (unfinished / name).write_text(text, encoding="utf-8")
        # Words of it may be zeros as they are in the place of its digest.
        told = json.dumps({"provenance": {"versions": {"geomint": "0.1"}}, "word": "0" * 80})
        (unfinished / NAMES[0]).write_bytes(sealed(told, NAMES[0], unfinished))


def test_nothing_stays_of_a_report_that_was_there(tmp_path):
    """Of the names that belong to a report; other files stay."""
    (tmp_path / "notes").write_text("mine", encoding="utf-8")
    make_report(tmp_path, "old")
    gi.check_folder(tmp_path, NAMES)
    make_report(tmp_path, "new", NAMES[:2])
    assert contents(tmp_path).keys() == {*NAMES[:2], "notes"}
    assert contents(tmp_path)[NAMES[1]] == "new"


def told_by_json(text):
    return lambda folder: (folder / NAMES[0]).write_text(text, encoding="utf-8")


def beside(folder, json_of="{}"):
    (folder / NAMES[0]).write_text(json_of, encoding="utf-8")
    (folder / NAMES[1]).write_text("mine", encoding="utf-8")


def changed(name, old, new):
    def change(folder):
        make_report(folder, "old")
        text = (folder / name).read_text(encoding="utf-8")
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")

    return change


OF_GEOMINT = '"provenance": {"versions": {"geomint": "0.1"}}'
MINE = {
    "no report": lambda folder: (folder / NAMES[1]).write_text("mine", encoding="utf-8"),
    "changed": changed(NAMES[1], "old", "mine"),
    "noted in its JSON, where it is still one": changed(NAMES[0], "0.1", "0.1, mine"),
    "beside a report without it": lambda folder: beside(folder, f'{{{OF_GEOMINT}, "files": {{}}}}'),
    "without files": told_by_json(f"{{{OF_GEOMINT}}}"),
    "not of geomint": told_by_json('{"a": 1}'),
    "broken": told_by_json('{"provenance'),
    "deep": told_by_json("[" * 10**5),
}


@pytest.mark.parametrize("mine", MINE)
def test_a_file_that_is_of_no_report_is_not_lost(tmp_path, mine):
    """Nor one that the user has changed; whether it would be written anew or only removed."""
    MINE[mine](tmp_path)
    before = contents(tmp_path)
    new, one = (tmp_path, "new"), (tmp_path, "new", NAMES[:1])
    for call, *given in (
        (gi.check_folder, tmp_path, NAMES),
        (make_report, *new),
        (make_report, *one),
    ):
        with pytest.raises(gi.OutputError, match=r"[ab]\..* of no earlier report.*left alone"):
            call(*given)
        assert contents(tmp_path) == before
    assert leftovers(tmp_path) == []


def killed(work):
    """Let a process of its own do some work, which ends in the middle of it."""
    child = os.fork()
    if not child:
        try:
            work()
        finally:
            os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


def half_a_folder(place):
    with gi.whole_folder(place):
        os._exit(9)


@posix
@pytest.mark.parametrize("after", range(3))
def test_a_first_report_that_was_killed_is_replaced(after, tmp_path, monkeypatch):
    """What it has moved by then is told by its JSON, which comes first."""
    put, moved = outputs._put, []

    def kill(unfinished, target):
        if len(moved) == after:
            os._exit(9)
        moved.append(put(unfinished, target))

    with monkeypatch.context() as patch:
        patch.setattr(outputs, "_put", kill)
        killed(lambda: make_report(tmp_path, "old"))
    assert len([path for path in tmp_path.iterdir() if path.name in NAMES]) == after
    make_report(tmp_path, "new")
    assert [contents(tmp_path)[name] for name in NAMES[1:]] == ["new", "new"]


def test_names_are_looked_at_before_the_work(tmp_path):
    (tmp_path / NAMES[1]).mkdir()
    gi.check_folder(tmp_path)
    with pytest.raises(gi.OutputError, match=r"b\.png.*a folder.*expected a file"):
        gi.check_folder(tmp_path, NAMES)


@posix
def test_what_a_killed_process_left_is_removed(tmp_path):
    """Not what others are writing at, nor what only looks like it."""
    place = tmp_path / "report"
    killed(lambda: half_a_folder(place))
    (left,) = leftovers(place)
    old = time.time() - 1000.0
    mine = [place / f"{workplace.LEFT}{name}" for name in ("mine", "0" * 16, "1" * 16, "2" * 16)]
    named, unmarked, linked, file = mine
    for folder in (named, unmarked):
        folder.mkdir()
        (folder / "work").touch()
    (named / named.name).touch()
    (tmp_path / "elsewhere").mkdir()
    linked.symlink_to(tmp_path / "elsewhere")
    (linked / linked.name).touch()
    file.touch()
    for path in mine:
        os.utime(path, (old, old), follow_symlinks=False)
    gi.check_folder(place)
    assert left in leftovers(place)  # too young: perhaps it has no lock yet
    os.utime(place / left, (old, old))
    with gi.whole_folder(place) as unfinished:
        os.utime(unfinished.parent, (old, old))
        gi.check_folder(place)
        assert unfinished.is_dir()
        assert left not in leftovers(place)
    assert set(leftovers(place)) == {path.name for path in mine}
    assert all((folder / "work").exists() for folder in (named, unmarked))
    assert [path.name for path in (tmp_path / "elsewhere").iterdir()] == [linked.name]


@posix
@pytest.mark.parametrize("at", ["_remove", "rmtree"])
def test_a_folder_that_takes_the_place_of_a_workplace_stays(tmp_path, monkeypatch, at):
    """Somebody who may write beside it gives its name to a folder of the user's, at any moment."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "work").touch()
    owner = workplace if at == "_remove" else shutil
    remove = getattr(owner, at)

    def swapped(*given, **options):
        (place,) = (path for path in tmp_path.iterdir() if path.name.startswith(workplace.LEFT))
        place.rename(tmp_path / "away")
        (tmp_path / "mine").rename(place)
        remove(*given, **options)

    with monkeypatch.context() as patch:
        patch.setattr(owner, at, swapped)
        write(tmp_path / "file")
    assert [path.parent.name[:9] for path in tmp_path.rglob("work")] == [".geomint-"]


@posix
@root
def test_what_another_user_left_stays(tmp_path):
    killed(lambda: half_a_folder(tmp_path))
    (left,) = leftovers(tmp_path)[:1]
    os.chown(tmp_path / left, 12345, -1)
    os.utime(tmp_path / left, (0.0, 0.0))
    gi.check_folder(tmp_path)
    assert (tmp_path / left).is_dir()
    os.chown(tmp_path / left, 0, -1)
    gi.check_folder(tmp_path)
    assert not (tmp_path / left).exists()


@posix
@pytest.mark.parametrize("at", ["_move_all", "_complete", "rmtree", "mkdir"])
def test_ctrl_c_at_any_moment(tmp_path, monkeypatch, at):
    """The old or the new, nothing beside it, and it is not lost."""
    write_report(tmp_path, "old")
    owner = {"rmtree": shutil, "mkdir": Path}.get(at, outputs)
    function, times = getattr(owner, at), []

    def pressed(*args, **options):
        if len(times) < 2 and (at != "mkdir" or ".geomint" in str(args[0])):
            times.append(at)
            signal.raise_signal(signal.SIGINT)
        return function(*args, **options)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with monkeypatch.context() as patch:
            patch.setattr(owner, at, pressed)
            with pytest.raises(KeyboardInterrupt):
                write_report(tmp_path, "new")
    finally:
        assert signal.signal(signal.SIGINT, before) is signal.default_int_handler
    assert times
    assert leftovers(tmp_path) == []
    assert contents(tmp_path) == dict.fromkeys(NAMES, "old" if at == "mkdir" else "new")


def test_what_ctrl_c_breaks_is_an_interrupt(tmp_path):
    """A file that it leaves closed is no error of the disk."""

    def write_closed():
        with gi.whole_file(tmp_path / "file"):
            try:
                raise KeyboardInterrupt
            finally:
                raise OSError(errno.EBADF, os.strerror(errno.EBADF))

    with pytest.raises(KeyboardInterrupt):
        write_closed()


@posix
def test_a_file_system_without_locks(tmp_path, monkeypatch):
    import fcntl

    def fail(*_):
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    killed(lambda: half_a_folder(tmp_path))
    (left,) = leftovers(tmp_path)
    os.utime(tmp_path / left, (0.0, 0.0))
    monkeypatch.setattr(fcntl, "flock", fail)
    write_report(tmp_path, "new")
    assert leftovers(tmp_path) == [left]  # somebody may be writing there
    shutil.rmtree(tmp_path / left)
    assert contents(tmp_path) == dict.fromkeys(NAMES, "new")


@posix
@root
def test_the_owner_stays(tmp_path):
    path = tmp_path / NAMES[0]
    for writing in (write, lambda p: write_report(p.parent)):
        write(path)
        os.chown(path, 12345, 54321)
        path.chmod(0o640)
        writing(path)
        found = path.stat()
        assert (found.st_uid, found.st_gid) == (12345, 54321)
        assert stat.S_IMODE(found.st_mode) == 0o640


def test_folders_that_cannot_be_are_told(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    file, dangling = tmp_path / "file", tmp_path / "dangling"
    for path, said in (
        *((place, "file' is no folder; expected a folder") for place in (file, file / "further")),
        (dangling, "a symlink that leads nowhere; expected a folder"),
        ("", "an empty name"),
    ):
        for call in (gi.check_folder, write_report):
            with pytest.raises(gi.OutputError, match=said):
                call(path)
