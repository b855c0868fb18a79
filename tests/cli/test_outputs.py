"""Commands on disks that are full, places that cannot be written, and terminals that are gone."""

import errno
import importlib
import json
import os
import pkgutil
import random
import subprocess
import sys
import warnings
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import geomint as gi
import geomint.plan
from chaplygin import scenes
from chaplygin.pictures.page import EXACT_FILES
from geomint import report
from geomint.cli import main
from geomint.run.files import outputs

# A short call of every command that writes something, and what it writes under --out.
COMMANDS = {
    "run": ("run", "sphere-n3", "--t-end", "5"),
    "drift": ("drift", "sphere-n3", "--t-end", "5"),
    "drift of several": ("drift", "sphere-n3", "--t-end", "5", "--methods", "rk-4,gauss-8"),
    "compare": ("compare", "sphere-n3", "--t-end", "5", "--methods", "rk-4", "--repeats", "1"),
    "stress": ("stress", "--axis", "momentum", "--systems", "no-such", "--methods", "rk-4"),
    "audit": ("audit", "--n", "2", "--points", "1", "--quiet"),
    "exact": ("exact", "veselova-n3"),
}
ALSO = {
    "markdown": (*COMMANDS["audit"], "--markdown"),
    "animate": ("exact", "ball-3d", "--animate"),
}


def invoke(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def by_fixed_point(folder):
    """Write the scene sphere-n3 without Newton's method, so that long steps fail; return the file."""
    text = (Path(scenes.__file__).parent / "sphere-n3.toml").read_text(encoding="utf-8")
    file = folder / "sphere-n3.toml"
    file.write_text(text.replace("[integrate]", '[integrate]\niteration = "fixed-point"'), "utf-8")
    return file


def no_run(*_, **__):
    raise AssertionError("the run was begun")


@pytest.fixture
def nothing_begins(monkeypatch):
    """Whatever costs time must not begin before the output has been tried."""
    for module in pkgutil.iter_modules(geomint.plan.__path__, "geomint.plan."):
        importlib.import_module(module.name)  # or it imports, once and for all, what is set here
    for name in (
        "geomint.plan.plan.Plan.solve",
        "geomint.compare.runs.solve",
        "geomint.stress.sweep.sweep",
        "tests.paper.run.audit",
        "geomint.problems.problem.Problem.exact",
        "geomint.run.solve.solve",  # the last: the modules above have imported it
    ):
        monkeypatch.setattr(name, no_run)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("place", ["below a file", "full"])
def test_outputs_are_tried_before_the_run(command, place, tmp_path, monkeypatch, nothing_begins):
    out = tmp_path / "out"
    if place == "below a file":
        out.write_text("in the way", encoding="utf-8")
        out = out / "further"
    else:
        monkeypatch.setattr(outputs.os, "fsync", full_disk)
    result = invoke(*COMMANDS[command], "--out", out)
    assert result.exit_code == 2, result.output
    assert "cannot be written" in result.stderr
    assert "Traceback" not in result.stderr
    assert "written:" not in result.stdout
    assert "report:" not in result.stdout


def full_disk(*_):
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("option", ALSO)
def test_other_outputs_are_tried_too(option, tmp_path, nothing_begins):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    for place in (tmp_path / "file" / "x.gif", tmp_path):
        result = invoke(*ALSO[option], place)
        assert result.exit_code == 2, result.output


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize(
    "command",
    [
        pytest.param(name, marks=[pytest.mark.nightly] * (name in ("compare", "exact")))
        for name in COMMANDS
        if name != "stress"
    ],
)
def test_a_disk_that_is_full_at_the_end(command, tmp_path, monkeypatch):
    """What was there is still there, exit code 2, nothing is called written."""
    out = tmp_path / ("out.nc" if command == "run" else "out")
    first = invoke(*COMMANDS[command], "--out", out)
    assert first.exit_code != 2, first.output
    before = content(out)
    monkeypatch.setattr(outputs, "_probe", lambda folder: None)
    monkeypatch.setattr(outputs.os, "fsync", full_disk)
    result = invoke(*COMMANDS[command], "--out", out)
    assert result.exit_code == 2, result.output
    assert os.strerror(errno.ENOSPC) in result.stderr
    assert "Traceback" not in result.stderr
    assert "written" not in result.stdout
    assert "report" not in result.stdout
    assert content(out) == before


def content(path):
    files = [path] if path.is_file() else sorted(path.iterdir())
    return {file.name: file.read_bytes() for file in files}


def test_a_file_that_may_not_be_larger(tmp_path):
    """The limit that the system itself sets, in a process of its own."""
    resource = pytest.importorskip("resource")
    scene = ("sphere-n3", "--t-end", "500", "--quiet")
    out = tmp_path / "drift"
    done = subprocess.run(
        [sys.executable, "-m", "geomint", "drift", *scene, "--out", str(out)],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)),
        # Python keeps byte code that was cut off by the limit, and fails by it ever after.
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert os.strerror(errno.EFBIG) in done.stderr
    assert "Traceback" not in done.stderr
    assert list(out.iterdir()) == []


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("command", ["run", "drift"])
def test_a_failure_is_told_before_what_is_written(command, tmp_path):
    out = tmp_path / ("out.nc" if command == "run" else "report")
    result = invoke(command, by_fixed_point(tmp_path), "--step", 40, "--out", out)
    assert result.exit_code == 2
    said = result.output  # both streams, in order
    assert said.index("geomint: gauss-8: failed: the implicit step did not") < said.index(
        "(failed): "
    )


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="of Linux")
@pytest.mark.parametrize("command", ["scenes", "methods", "--help"])
def test_a_terminal_that_is_gone(command):
    run = [sys.executable, "-m", "geomint", command]
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(run, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 2, done.stderr
    assert "standard output cannot be written" in done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(run, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (1, "")


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_what_an_encoding_lacks_is_escaped(encoding):
    """Names, titles and tables have letters that no encoding but those of Unicode has."""
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    for words in (("methods",), ("check", "hamiltonized-n3"), ("inertia", "--help")):
        run = [sys.executable, "-m", "geomint", *words]
        done = subprocess.run(run, capture_output=True, env=environment, check=False)
        assert (done.returncode, b"Traceback" in done.stderr) == (0, False), words
        assert words[0] != "check" or b"\\u" in done.stdout


@pytest.mark.skipif(sys.platform == "win32", reason="a shell of POSIX")
@pytest.mark.parametrize(
    ("command", "closed", "code", "told"),
    [
        ("scenes", ">&-", 2, "geomint: standard output cannot be written"),
        ("check sphere-n3", ">&- 2>&-", 2, ""),
        ("scenes", "2>&- <&-", 0, ""),
        ("check sphere-n", "2>/dev/full", 2, ""),
        ("scenes", "| true", 1, ""),
    ],
)
def test_streams_that_are_closed(command, closed, code, told):
    geomint = f"set -o pipefail; {sys.executable} -m geomint {command} {closed}"
    done = subprocess.run(["bash", "-c", geomint], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    assert done.stderr.startswith(told)
    assert done.stderr.count("\n") == bool(told)


def test_a_run_that_failed_is_seen_in_every_file(tmp_path):
    file = by_fixed_point(tmp_path)
    assert invoke("drift", file, "--step", 40, "--out", tmp_path).exit_code == 2
    assert '"status": "failed"' in (tmp_path / "drift.json").read_text(encoding="utf-8")
    assert "gauss-8: failed." in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "run failed" in (tmp_path / "drift.svg").read_text(encoding="utf-8")


def test_nothing_is_imported_for_it():
    """Taking over signals and testing outputs costs no import of numba or matplotlib."""
    script = (
        "import sys, geomint.run.files.outputs, geomint.cli.signals\n"
        "print({'numba', 'matplotlib'} & {*sys.modules})"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"
    assert gi.whole_file is outputs.whole_file


@pytest.mark.parametrize("call", [*COMMANDS.values(), *ALSO.values()])
def test_an_empty_name_is_no_place(call, tmp_path, monkeypatch, nothing_begins):
    """Nor the current folder; also in commands of other packages."""
    monkeypatch.chdir(tmp_path)
    result = invoke(*call, *([] if call in ALSO.values() else ["--out"]), "")
    assert result.exit_code == 2, result.output
    assert "an empty name; expected" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("drift", "report.html"),
        ("drift of several", "drift.svg"),
        ("compare", "compare-drift.png"),
        ("stress", "stress.json"),
        ("audit", "audit.json"),
        ("exact", "exact.svg"),
    ],
)
def test_a_folder_in_the_place_of_a_file_is_told_before_the_run(
    command, name, tmp_path, nothing_begins
):
    (tmp_path / name).mkdir()
    result = invoke(*COMMANDS[command], "--out", tmp_path)
    assert result.exit_code == 2, result.output
    assert f"{name}' cannot be written: that is a folder" in result.stderr


# Of commands that read a scene what they replace under --out, or the option's own file.
READING = {
    "run --out": [""],
    "drift --out": report.DRIFT_FILES,
    "compare --out": report.COMPARE_FILES,
    "section --event gamma[2] --out": report.SECTION_FILES,
    "scan --vary D=4:5:2 --out": report.SCAN_FILES,
    "chaos --out": report.CHAOS_FILES,
    "exact --out": EXACT_FILES,
    "exact --animate": [""],
}
WAYS = {
    "path": lambda scene, place: scene.rename(place),
    "link to it": lambda scene, place: place.symlink_to(scene),
    "link that is read": lambda scene, place: (scene.rename(place), scene.symlink_to(place)),
    "hard link": lambda scene, place: place.hardlink_to(scene),
    "another way": lambda scene, place: scene.rename(place),
}


@pytest.mark.skipif(os.name != "posix", reason="links of POSIX")
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("command", READING)
def test_no_output_takes_the_place_of_the_scene(
    command, way, tmp_path, monkeypatch, nothing_begins
):
    """By whatever name, of whatever file of a report, and before anything is computed."""
    monkeypatch.chdir(tmp_path)
    name, *options = command.split()
    text, files = gi.load_scene("sphere-n3").toml(), READING[command]
    for i, file in enumerate(random.Random(way).sample(files, min(len(files), 3))):
        scene, folder = tmp_path / f"scene-{i}.toml", tmp_path / f"{i}"
        folder.mkdir()
        scene.write_text(text, "utf-8")
        out = (
            Path(f"{i}")
            if file
            else Path(f"{i}", "out.gif" if "--animate" in options else "out.nc")
        )
        place = tmp_path / out / file
        WAYS[way](scene, place)
        if way == "another way":
            (tmp_path / f"link-{i}").symlink_to(folder)
            out = Path(f"link-{i}", "..", out)
        read = scene if scene.exists() else place
        result = invoke(name, read, *options, out)
        assert result.exit_code == 2, result.output
        said = result.stderr.splitlines()[-1]
        assert str(out / file) in said
        if file and way == "link to it":  # in the folder of a report
            assert "that is a symlink, which is left alone" in said
        else:
            assert f"cannot be written: it is the input '{read}'; expected another place" in said
        assert read.read_text("utf-8") == text
        assert [p.name for p in folder.iterdir()] == [place.name]


def test_commands_in_one_process_are_as_alone(tmp_path, monkeypatch):
    """A file that an earlier command has read may be replaced by a later one."""
    monkeypatch.chdir(tmp_path)
    Path("study").write_text(gi.load_scene("sphere-n3").toml(), "utf-8")
    assert invoke("check", "./study").exit_code == 0
    assert invoke("run", "./study", "--t-end", 5, "--out", "study").exit_code == 2
    assert invoke("run", "sphere-n3", "--t-end", 5, "--out", "study").exit_code == 0
    assert gi.load("study").success


def test_a_command_that_goes_on_from_a_saved_run_keeps_it(tmp_path, monkeypatch):
    """Of another package too; in Python the run is in memory, and its file may be written anew."""

    @click.command()
    @click.argument("path")
    @click.argument("out")
    def go_on(path, out):
        gi.load(path).save(out)

    monkeypatch.setitem(main.commands, "go-on", go_on)
    path, link = tmp_path / "run.nc", tmp_path / "link.nc"
    assert invoke("run", "sphere-n3", "--t-end", 5, "--out", path).exit_code == 0
    link.symlink_to(path)
    content = path.read_bytes()
    for out in (path, link):
        result = invoke("go-on", path, out)
        assert (result.exit_code, path.read_bytes()) == (2, content), result.output
        assert "it is the input" in result.stderr
    assert invoke("go-on", path, tmp_path / "other.nc").exit_code == 0
    gi.load(path).save(path)
    assert gi.load(path) == gi.load(tmp_path / "other.nc")


@pytest.mark.usefixtures("nothing_begins")
@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("drift", {}),
        ("scan", {"vary": {"D": [4.0, 5.0]}}),
        ("section", {"event": "gamma[2]"}),
        ("chaos", {}),
    ],
)
def test_reports_from_python_keep_their_scene(kind, keys, tmp_path, monkeypatch):
    """Given as a path, or as the scene that was made of it, or changed since; in another folder."""
    files = getattr(report, f"{kind.upper()}_FILES")
    path = tmp_path / files[len(files) // 2]
    text = gi.load_scene("sphere-n3").toml()
    path.write_text(text, "utf-8")
    write = getattr(gi, f"{kind}_report")
    monkeypatch.chdir(tmp_path)
    scene = gi.load_scene(Path(path.name))
    monkeypatch.chdir(tmp_path.parent)
    for given in (scene, path, scene.changed(time={"t_end": 7.0})):
        with pytest.raises(gi.OutputError, match="it is the input") as refused:
            write(given, tmp_path, progress=False, **keys)
        assert refused.value.path == str(path)
    assert path.read_text("utf-8") == text


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("command", [name for name in COMMANDS if name not in ("run", "stress")])
def test_names_that_are_looked_at_are_those_that_are_written(command, tmp_path, monkeypatch):
    looked_at = []
    check = outputs.check_folder

    def listening(path, names=()):
        looked_at.extend(names)
        check(path, names)

    monkeypatch.setattr(outputs, "check_folder", listening)
    monkeypatch.setattr(gi, "check_folder", listening)
    invoke(*COMMANDS[command], "--out", tmp_path, "--paper")
    assert sorted(content(tmp_path)) == sorted(looked_at)
    invoke(*COMMANDS[command], "--out", tmp_path)  # of what was for a paper nothing stays
    assert set(content(tmp_path)) < set(looked_at)
    assert not [name for name in content(tmp_path) if name.endswith((".pdf", ".tex", ".bib"))]


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("command", [name for name in COMMANDS if name not in ("run", "stress")])
def test_a_file_of_the_users_is_not_lost(command, tmp_path, monkeypatch):
    """Beside no report; and, if it was changed, of one; a report that is as it was is replaced."""
    call, out = COMMANDS[command], tmp_path / "out"
    assert invoke(*call, "--out", out).exit_code != 2
    assert invoke(*call, "--out", out).exit_code != 2
    table = json.loads(next(out.glob("*.json")).read_text(encoding="utf-8"))["files"]
    assert {*table, next(out.glob("*.json")).name} == {path.name for path in out.iterdir()}
    monkeypatch.setattr("geomint.run.solve.solve", no_run)
    picture = next(out.glob("*.png"))
    (record,) = out.glob("*.json")
    kept = record.read_bytes()
    for changed in (
        kept.replace(b'"geomint"', b'"geomint "', 1),
        kept.partition(b'"files"')[0].rstrip().rstrip(b",") + b"}",  # tells of none
    ):
        record.write_bytes(changed)
        result = invoke(*call, "--out", out)
        assert result.exit_code == 2, result.output
        assert record.name in result.stderr.replace("\n", " ")
        assert record.read_bytes() == changed
    record.write_bytes(kept)
    picture.write_bytes(b"mine")
    for left in ("*.none", "*.json"):
        for path in out.glob(left):
            path.rename(tmp_path / "away")
        before = content(out)
        result = invoke(*call, "--out", out)
        assert result.exit_code == 2, result.output
        said = result.stderr.replace("\n", " ")
        assert picture.name in said
        assert "of no earlier report" in said
        assert content(out) == before


def test_a_file_that_has_the_name_of_a_run_is_not_lost(tmp_path, monkeypatch):
    """Unless it is a run, or was named."""
    monkeypatch.chdir(tmp_path)
    out = Path("sphere-n3.nc")
    for _ in range(2):
        assert invoke(*COMMANDS["run"]).exit_code == 0
    run = out.read_bytes()
    for mine in (b"mine", b"of geomint-run-3", run[:-1], run + b"mine"):
        out.write_bytes(mine)
        result = invoke(*COMMANDS["run"])
        assert result.exit_code == 2, result.output
        assert "another file is there, which is left alone" in result.stderr
        assert out.read_bytes() == mine
    assert invoke(*COMMANDS["run"], "--out", out).exit_code == 0
    assert gi.load(out).success


@pytest.mark.parametrize("mine", ["file", "folder"])
@pytest.mark.parametrize("named", [False, True])
def test_what_comes_to_the_place_of_a_run_meanwhile(mine, named, tmp_path, monkeypatch):
    """Neither that nor the run is lost; a file that was named is to be replaced."""
    monkeypatch.chdir(tmp_path)
    out, run_plan = Path("sphere-n3.nc"), geomint.plan.run_plan
    Path("sphere-n3-2.nc").write_bytes(b"mine too")

    def disturbed(*given):
        found = run_plan(*given)
        out.mkdir() if mine == "folder" else out.write_bytes(b"mine")
        return found

    monkeypatch.setattr(geomint.plan, "run_plan", disturbed)
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
        result = invoke("exact", "ball-3d", "--out", out, "--animate", film)
        assert result.exit_code == 2, result.output
        assert "it is a file of the report" in result.stderr.replace("\n", " ")
        assert content(out) == {}


STEERING = "a\x1b[31m\r\u202e<script>"


def test_nothing_steers_a_terminal(tmp_path, monkeypatch):
    """Names of files, keys, titles and parameters come from strangers."""
    monkeypatch.chdir(tmp_path)
    text = gi.load_scene("sphere-n3").toml()
    escaped = STEERING.replace("\x1b", "\\u001b").replace("\r", "\\r").replace("\u202e", "\\u202e")
    titled = "\n".join(line for line in text.splitlines() if not line.startswith("title"))
    scene = Path(f"{STEERING}.toml")
    scene.write_text(f'title = "{escaped}"\n{titled}', encoding="utf-8")
    odd = Path("odd.toml")
    odd.write_text(text.replace("[integrate]", f'[integrate]\n"{escaped}" = 1'), encoding="utf-8")
    for arguments in (
        ("check", odd),
        ("run", scene, "--t-end", 5),
        ("drift", scene, "--t-end", 5),
        ("compare", scene, "--t-end", 5, "--methods", f"rk-4,{STEERING}"),
    ):
        result = CliRunner().invoke(main, [str(a) for a in arguments], color=True)
        assert result.exit_code == (0 if arguments[0] in ("run", "drift") else 2), result.output
        assert not set("\r\u202e") & set(result.output), arguments
        assert "\x1b[31m" not in result.output
    page = Path("report/report.html").read_text(encoding="utf-8")
    assert not set("\x1b\r\u202e") & set(page)
    assert r"a\x1b[31m\r\u202e&lt;script&gt;" in page


@pytest.mark.parametrize("names", ["x,zzz", "rk-4,zzz"])
@pytest.mark.parametrize("command", ["compare", "drift"])
def test_lists_of_names_are_short(command, names, tmp_path):
    result = invoke(command, "sphere-n3", "--methods", names, "--t-end", 5, "--out", tmp_path)
    assert result.exit_code == 2
    assert "`geomint methods` lists them" in result.stderr
    assert all(len(line) < 400 for line in result.stderr.splitlines())


def test_a_warning_that_was_told_is_heard_by_later_runs(tmp_path, monkeypatch):
    """A note of the command replaces the warning of that run only."""
    from geomint.plan import Estimate

    monkeypatch.setattr("geomint.plan.expected_time", lambda plans: Estimate(1e4, True))
    before = list(warnings.filters)
    assert invoke(*COMMANDS["run"], "--out", tmp_path / "run.nc").exit_code == 0
    assert warnings.filters == before


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("step", [40, -1])
def test_the_traceback_of_an_error_is_told_once(step, tmp_path, monkeypatch):
    """Of an error before the run as of one that ends it."""
    scene = str(by_fixed_point(tmp_path))
    call = ["drift", scene, "--debug", "--quiet", "--step", str(step), "--out", str(tmp_path)]
    monkeypatch.setattr("sys.argv", ["geomint", *call])
    result = invoke(*call)
    assert result.exit_code == 2
    assert result.stderr.count("Traceback") == 1
    assert result.stderr.count("\ngeomint: ") == 1
