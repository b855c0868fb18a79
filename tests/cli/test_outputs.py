"""Commands on disks that are full, in places that cannot be written or are taken."""

import errno
import json
import os
import random
import re
import stat
from pathlib import Path

import click
import pytest

import geomint as gi
from geomint import reports as report
from geomint.cli import main
from geomint.compare import runs
from tests.cli.calls import content, invoke
from tests.paper import run as audit

# A short call of every command that writes something, and what it writes under --out.
COMMANDS = {
    "run": ("run", "sphere-n3", "--t-end", "5"),
    "drift": ("drift", "sphere-n3", "--t-end", "5"),
    "drift of several": ("drift", "sphere-n3", "--t-end", "5", "--methods", "rk-4,gauss-8"),
    "compare": ("compare", "sphere-n3", "--t-end", "5", "--methods", "rk-4", "--repeats", "1",
                "--reference", "exact"),
    "stress": ("stress", "--axis", "momentum", "--systems", "no-such", "--methods", "rk-4"),
    "audit": ("audit", "--n", "2", "--points", "1", "--quiet"),
    "exact": ("exact", "veselova-n3"),
}  # fmt: skip
ALSO = {
    "markdown": (*COMMANDS["audit"], "--markdown"),
    "animate": ("exact", "ball-3d", "--animate"),
}
FOLDERS = ("drift of several", "compare", "audit", "exact")
STEPS = gi.load_scene("sphere-n3")


def begin_nothing(monkeypatch):
    """Whatever costs time must not begin before the output has been tried."""

    def no_run(*_, **__):
        raise AssertionError("the run was begun")

    plan = type(gi.make_plan(STEPS))
    for place, name in ((plan, "solve"), (runs, "solve"), (audit, "audit"), (gi.Problem, "exact")):
        monkeypatch.setattr(place, name, no_run)


@pytest.fixture
def nothing_begins(monkeypatch):
    begin_nothing(monkeypatch)


def full_disk(*_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def full_at_the_end(descriptor):
    """Fail but for folders, and for the trial before the work, of which it is the size."""
    found = os.fstat(descriptor)
    if stat.S_ISREG(found.st_mode) and found.st_size != 4096:
        full_disk()


def refused(result, *words):
    """Tell whether a command has refused an output in words, and called nothing written."""
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.stderr
    said = result.stderr.replace("\n", " ")
    assert [word for word in words if word not in said] == []
    assert not {"written:", "report:"} & set(result.stdout.split())
    return True


@pytest.mark.parametrize("command", {**COMMANDS, **ALSO})
def test_outputs_are_tried_before_the_run(command, tmp_path, monkeypatch, nothing_begins):
    """Below a file, on a full disk, in the current folder by an empty name, in a folder's place."""
    monkeypatch.chdir(tmp_path)
    call = ALSO.get(command) or (*COMMANDS[command], "--out")
    assert refused(invoke(*call, ""), "an empty name; expected")
    assert list(tmp_path.iterdir()) == []
    Path("file").write_text("in the way", encoding="utf-8")
    assert refused(invoke(*call, f"file/x{'.gif' * (command in ALSO)}"), "cannot be written")
    if command in ALSO:
        assert refused(invoke(*call, tmp_path))
        return
    if command != "run":
        assert refused(invoke(*call, "file"), "is a file")
        Path("out", f"{'report' if 'drift' in command else command}.html").mkdir(parents=True)
        assert refused(invoke(*call, "out"), "cannot be written: that is a folder")
    monkeypatch.setattr(os, "fsync", full_disk)
    assert refused(invoke(*call, "new"), "cannot be written")


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("command", FOLDERS)
def test_whatever_a_command_writes_is_looked_at_before(command, tmp_path, monkeypatch):
    out = tmp_path / "out"
    assert invoke(*COMMANDS[command], "--out", out, "--paper").exit_code != 2
    assert not [name for name, data in content(out).items() if b" at 0x" in data]
    begin_nothing(monkeypatch)
    for name in sorted(content(out)):
        mine = tmp_path / name / name
        mine.parent.mkdir()
        mine.write_bytes(b"mine")
        refusal = invoke(*COMMANDS[command], "--out", mine.parent)
        assert refused(refusal, name, "of no earlier report")
        assert mine.read_bytes() == b"mine"


@pytest.mark.usefixtures("blank_pictures")
def test_a_file_of_the_users_is_not_lost(tmp_path, monkeypatch):
    """Beside no report, or changed since; a report that is as it was is replaced, whole or not."""
    call, out = COMMANDS["drift"], tmp_path / "out"
    assert invoke(*call, "--out", out, "--paper").exit_code != 2
    names = sorted(content(out))
    assert invoke(*call, "--out", out).exit_code != 2
    gone = set(names) - set(content(out))  # of what was for a paper nothing stays
    assert {Path(name).suffix for name in gone} >= {".pdf", ".tex", ".bib"}
    (record,) = out.glob("*.json")
    table = json.loads(record.read_bytes())["files"]
    assert {*table, record.name} == set(content(out))
    before = content(out)
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full_at_the_end)
        assert refused(invoke(*call, "--out", out), os.strerror(errno.ENOSPC))
    assert content(out) == before
    begin_nothing(monkeypatch)
    kept, picture = record.read_bytes(), next(out.glob("*.png"))
    for changed in (
        kept.replace(b'"geomint"', b'"geomint "', 1),
        kept.partition(b'"files"')[0].rstrip().rstrip(b",") + b"}",  # tells of none
    ):
        record.write_bytes(changed)
        assert refused(invoke(*call, "--out", out), record.name)
        assert record.read_bytes() == changed
    record.write_bytes(kept)
    picture.write_bytes(b"mine")
    for forget in (lambda: None, record.unlink):
        forget()
        before = content(out)
        assert refused(invoke(*call, "--out", out), picture.name, "of no earlier report")
        assert content(out) == before


def test_a_run_that_is_larger_than_a_file_may_be(tmp_path):
    """What was there is still there."""
    resource = pytest.importorskip("resource")
    out = tmp_path / "out.nc"
    assert invoke(*COMMANDS["run"], "--out", out).exit_code == 0
    before = content(tmp_path)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5_000, limits[1]))
    try:
        result = invoke(*COMMANDS["run"], "--out", out)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert refused(result, os.strerror(errno.EFBIG))
    assert content(tmp_path) == before


# Of commands that read a scene what they replace under --out, or the option's own file.
EXACT_FILES = re.findall(r"exact\.\w+", invoke("exact", "--help").stdout)
READING = {
    "run --out": [""], "drift --out": report.DRIFT_FILES, "compare --out": report.COMPARE_FILES,
    "section --event gamma[2] --out": report.SECTION_FILES,
    "scan --vary D=4:5:2 --out": report.SCAN_FILES, "chaos --out": report.CHAOS_FILES,
    "exact --out": EXACT_FILES, "exact --animate": [""],
}  # fmt: skip
WAYS = {
    "path": lambda scene, place: scene.rename(place),
    "link to it": lambda scene, place: place.symlink_to(scene),
    "link that is read": lambda scene, place: (scene.rename(place), scene.symlink_to(place)),
    "hard link": lambda scene, place: place.hardlink_to(scene),
    "another way": lambda scene, place: scene.rename(place),
}


@pytest.mark.skipif(os.name != "posix", reason="links of POSIX")
@pytest.mark.parametrize("command", READING)
def test_no_output_takes_the_place_of_the_scene(command, tmp_path, monkeypatch, nothing_begins):
    """By whatever name, of whatever file of a report, and before anything is computed."""
    monkeypatch.chdir(tmp_path)
    name, *options = command.split()
    text = gi.load_scene("sphere-n3").toml()
    for i, way in enumerate(WAYS):
        file = random.Random(way).choice(READING[command])
        scene, folder = tmp_path / f"scene-{i}.toml", tmp_path / f"{i}"
        folder.mkdir()
        scene.write_text(text, "utf-8")
        single = "out.gif" if "--animate" in options else "out.nc"
        out = Path(f"{i}") if file else Path(f"{i}", single)
        place = tmp_path / out / file
        WAYS[way](scene, place)
        if way == "another way":
            (tmp_path / f"link-{i}").symlink_to(folder)
            out = Path(f"link-{i}", "..", out)
        read = scene if scene.exists() else place
        said = f"cannot be written: it is the input '{read}'; expected another place"
        if file and way == "link to it":  # in the folder of a report
            said = "that is a symlink, which is left alone"
        assert refused(invoke(name, read, *options, out), str(out / file), said)
        assert read.read_text("utf-8") == text
        assert [p.name for p in folder.iterdir()] == [place.name]


def test_a_command_that_goes_on_from_a_saved_run_keeps_it(tmp_path, monkeypatch):
    """Of another package too; in Python the run is in memory, and its file may be written anew."""

    @click.command()
    @click.argument("path")
    @click.argument("out")
    def go_on(path, out):
        gi.load(path).save(out)

    monkeypatch.setitem(main.commands, "go-on", go_on)
    path, link = tmp_path / "run.nc", tmp_path / "link.nc"
    assert invoke(*COMMANDS["run"], "--out", path).exit_code == 0
    link.symlink_to(path)
    before = path.read_bytes()
    for out in (path, link):
        assert refused(invoke("go-on", path, out), "it is the input")
        assert path.read_bytes() == before
    assert invoke("go-on", path, tmp_path / "other.nc").exit_code == 0
    gi.load(path).save(path)
    assert gi.load(path) == gi.load(tmp_path / "other.nc")


@pytest.mark.usefixtures("nothing_begins")
@pytest.mark.parametrize("kind", ["drift", "scan", "section", "chaos"])
def test_reports_from_python_keep_their_scene(kind, tmp_path, monkeypatch):
    """Given as a path, or as the scene that was made of it, or changed since; in another folder."""
    more = {"scan": {"vary": {"D": [4.0, 5.0]}}, "section": {"event": "gamma[2]"}}.get(kind, {})
    files = getattr(report, f"{kind.upper()}_FILES")
    path = tmp_path / files[len(files) // 2]
    text = gi.load_scene("sphere-n3").toml()
    path.write_text(text, "utf-8")
    monkeypatch.chdir(tmp_path)
    scene = gi.load_scene(Path(path.name))
    monkeypatch.chdir(tmp_path.parent)
    for given in (scene, path, scene.changed(time={"t_end": 7.0})):
        with pytest.raises(gi.OutputError, match="it is the input") as found:
            getattr(gi, f"{kind}_report")(given, tmp_path, progress=False, **more)
        assert found.value.path == str(path)
    assert path.read_text("utf-8") == text


def test_a_file_that_has_the_name_of_a_run_is_not_lost(tmp_path, monkeypatch):
    """Unless it is a run, or was named; what an earlier command has read may be replaced."""
    monkeypatch.chdir(tmp_path)
    out = Path("sphere-n3.nc")
    out.write_text(STEPS.toml(), "utf-8")
    assert invoke("check", out).exit_code == 0
    assert refused(invoke("run", out, "--t-end", 5, "--out", out), "it is the input")
    assert invoke(*COMMANDS["run"], "--out", out).exit_code == 0
    assert invoke(*COMMANDS["run"]).exit_code == 0
    run = out.read_bytes()
    for mine in (b"mine", b"of geomint-run-3", run[:-1], run + b"mine"):
        out.write_bytes(mine)
        assert refused(invoke(*COMMANDS["run"]), "another file is there, which is left alone")
        assert out.read_bytes() == mine
    assert invoke(*COMMANDS["run"], "--out", out).exit_code == 0
    assert gi.load(out).success


@pytest.mark.parametrize(
    ("mine", "named"), [("file", False), ("folder", False), ("file", True), ("folder", True)]
)
def test_what_comes_to_the_place_of_a_run_meanwhile(mine, named, tmp_path, monkeypatch):
    """Neither that nor the run is lost; a file that was named is to be replaced."""
    monkeypatch.chdir(tmp_path)
    out, kind = Path("sphere-n3.nc"), type(gi.make_plan(STEPS))
    solve = kind.solve
    Path("sphere-n3-2.nc").write_bytes(b"mine too")

    def disturbed(*given, **more):
        found = solve(*given, **more)
        out.mkdir() if mine == "folder" else out.write_bytes(b"mine")
        return found

    monkeypatch.setattr(kind, "solve", disturbed)
    result = invoke(*COMMANDS["run"], *(["--out", out] if named else []))
    assert result.exit_code == 0, result.output
    if named and mine == "file":
        assert gi.load(out).success
    else:
        assert out.is_dir() if mine == "folder" else out.read_bytes() == b"mine"
        assert gi.load("sphere-n3-3.nc").success
        assert "left alone" in result.stderr
        assert "the run is in sphere-n3-3.nc" in result.stderr
        assert "sphere-n3-3.nc" in result.stdout
    assert Path("sphere-n3-2.nc").read_bytes() == b"mine too"


def test_a_film_is_no_file_of_the_report(tmp_path, nothing_begins):
    out = tmp_path / "out"
    (tmp_path / "link").symlink_to(out)
    for film in (out / "exact.html", tmp_path / "link" / ".." / "link" / "exact.html"):
        line = ("exact", "ball-3d", "--out", out, "--animate", film)
        assert refused(invoke(*line), "it is a file of the report")
        assert content(out) == {}


STEERING = "a\x1b[31m\r\u202e\x9b\x07<script>"


@pytest.mark.usefixtures("blank_pictures")
def test_nothing_steers_a_terminal(tmp_path, monkeypatch):
    """Names of files, keys, titles and parameters come from strangers."""
    monkeypatch.chdir(tmp_path)
    titled = STEPS.changed(title=STEERING, description=STEERING).toml()
    scene, odd = Path(f"{STEERING}.toml"), Path("odd.toml")
    scene.write_text(titled, encoding="utf-8")
    key = json.dumps(STEERING)
    odd.write_text(titled.replace("[integrate]", f"[integrate]\n{key} = 1"), encoding="utf-8")
    for arguments in (
        ("check", scene),
        ("check", odd),
        ("run", scene, "--t-end", 5),
        ("drift", scene, "--t-end", 5),
        ("compare", scene, "--t-end", 5, "--methods", f"rk-4,{STEERING}"),
    ):
        result = invoke(*arguments, color=True)
        wrong = odd in arguments or arguments[0] == "compare"
        assert result.exit_code == 2 * wrong, result.output
        assert not set("\r\u202e\x9b\x07") & set(result.output.replace("\x1b[31m", "\r")), arguments
        assert wrong or r"a\x1b[31m\r\u202e" in result.stdout
    page = Path("report/report.html").read_text(encoding="utf-8")
    assert not set("\x1b\r\u202e\x9b") & set(page)
    assert r"a\x1b[31m\r\u202e\x9b\x07&lt;script&gt;" in page
