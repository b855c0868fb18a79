"""The commands: what they print, write and return."""

import importlib.metadata
import json
import os
import subprocess
import sys
import warnings
from importlib.metadata import EntryPoint
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from pydantic import BaseModel, ConfigDict, field_validator

import geomint as gi
from chaplygin import scenes
from geomint.cli import main
from geomint.methods import methods
from geomint.problems.systems import find_system, system_names
from geomint.watch.registry import plugged, registered

# What is in pictures: tests/report.
pytestmark = pytest.mark.usefixtures("blank_pictures")


def offer(monkeypatch, group, name, thing):
    """Let this be all that packages offer geomint."""
    others = importlib.metadata.entry_points

    class Point(EntryPoint):
        def load(self):
            return thing

    def entry_points(**given):
        if "geomint" not in given.get("group", ""):
            return others(**given)
        return [Point(name, "other.package:THING", group)] if given["group"] == group else []

    monkeypatch.setattr(importlib.metadata, "entry_points", entry_points)


REPORT = {"report.html", "drift.json", "drift.png", "drift.svg"}


def invoke(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments], env={"COLUMNS": "120"})


def by_fixed_point(folder):
    """Write the scene sphere-n3 without Newton's method, so that long steps fail; return the file."""
    text = (Path(scenes.__file__).parent / "sphere-n3.toml").read_text(encoding="utf-8")
    file = folder / "sphere-n3.toml"
    file.write_text(text.replace("[integrate]", '[integrate]\niteration = "fixed-point"'), "utf-8")
    return file


def test_help_names_all_commands():
    result = invoke("--help")
    assert result.exit_code == 0
    for name in ("scenes", "methods", "check", "run", "drift", "compare"):
        assert f"  {name} " in result.stdout


def test_scenes():
    result = invoke("scenes")
    assert result.exit_code == 0
    for name in gi.scene_names():
        assert name in result.stdout


def test_methods():
    result = invoke("methods")
    assert result.exit_code == 0
    for name in gi.method_names():
        assert name in result.stdout
    heads = [line for line in result.stdout.splitlines() if "(needs " in line]
    assert {line.partition(" (")[0] for line in heads} == {m.family for m in methods().values()}
    assert "Crouch–Grossman (needs action): keeps group orbits and steady motions" in heads
    only = invoke("methods", "--form", "hamiltonian").stdout
    assert "rattle-4" in only
    assert "gauss-8" not in only
    assert invoke("methods", "--form", "acton").exit_code == 2


@pytest.mark.parametrize("name", gi.scene_names())
def test_check_says_what_and_why(name):
    result = invoke("check", name)
    assert result.exit_code == 0
    for word in ("representation", "method", "step", "steps", "watched", "why"):
        assert word in result.stdout


def shortened(name):
    """Return the options that make a built-in scene short."""
    scene = gi.load_scene(name)
    key = "tau_end" if scene.problem.time == "tau" else "t_end"
    return [f"--{key.replace('_', '-')}", "5"]


# One scene of each family of kernels; all others run at night.
SOON = {"ball-3d", "hamiltonized-n3", "sphere-n3", "rolling-ball-n3", "ellipsoid-n4", "clebsch-n4"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] * (name not in SOON))
        for name in gi.scene_names()
    ],
)
def test_built_in_scenes_run_shortened(name, tmp_path):
    out = tmp_path / "run.nc"
    result = invoke("run", name, *shortened(name), "--out", out)
    assert result.exit_code == 0, result.output
    saved = gi.load(out)
    assert saved.provenance["status"] == "success"
    assert saved.tau[-1] == 5.0
    assert set(saved.drift) == set(gi.load_scene(name).content.observe.quantities)


@pytest.mark.parametrize("name", ["ball-3d", "hamiltonized-n3"])
def test_drift_shortened(name, tmp_path):
    out = tmp_path / "a" / "report"
    result = invoke("drift", name, *shortened(name), "--out", out)
    assert result.exit_code == 0, result.output
    assert {path.name for path in out.iterdir()} == REPORT
    assert str(out / "report.html") in result.stdout.replace("\n", "")


def test_drift_of_several_methods(tmp_path):
    result = invoke(
        *("drift", "sphere-n3", "--t-end", 5, "--methods", "gauss-8, rk-4:0.05,cf-4,lobatto-3:40"),
        *("--out", tmp_path),
    )
    assert result.exit_code == 0, result.output
    assert {path.name for path in tmp_path.iterdir()} == REPORT
    assert "lobatto-3: failed: the implicit step did not converge" in result.stderr
    for word in ("a second", "energy", "rk-4", "no larger than 32 ε × scale: gauss-8"):
        assert word in result.stdout
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    assert list(record["methods"]) == ["gauss-8", "rk-4", "cf-4", "lobatto-3"]
    assert record["provenance"]["command"].startswith("geomint")


def test_if_every_method_fails_so_does_the_command(tmp_path):
    arguments = ("drift", "ball-3d", "--t-end", 1, "--methods", "rattle-2,rattle-4")
    assert invoke(*arguments, "--quiet", "--out", tmp_path).exit_code == 2


def test_methods_of_the_scene_and_of_the_command_line(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(
        drift={"methods": ["gauss-8", "gauss-4:0.2"], "quantities": ["energy"], "t_end": 2.0}
    )
    path, out = tmp_path / "scene.toml", tmp_path / "report"
    path.write_text(scene.toml(), encoding="utf-8")
    told = invoke("check", path, "--for-drift").stdout
    assert "0.2 in t" in told
    assert told.count("representation") == 2
    assert invoke("check", path).stdout.count("representation") == 1
    assert invoke("drift", path, "--quiet", "--out", out).exit_code == 0
    record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
    assert set(record["kinds"]) == {"energy"}
    assert invoke("drift", path, "--method", "gauss-8", "--quiet", "--out", out).exit_code == 0
    record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
    assert list(record["methods"]) == ["gauss-8"]


def test_check_of_several_methods():
    told = invoke("check", "hamiltonized-n3", "--methods", "gauss-8,cf-4,euler-wrong")
    assert told.exit_code == 2
    told = invoke("check", "ball-3d", "--methods", "cf-4,rattle-4").stdout
    assert "not possible: no representation" in told
    told = invoke("check", "hamiltonized-n3", "--methods", "gauss-8,cf-4").stdout
    assert "about t = 8818" in told
    assert "estimated by the rate at the start" in " ".join(told.split())


def test_a_representation_can_be_forced_and_quantities_changed():
    arguments = ("check", "ball-3d", "--for-drift", "--observe", "energy, K")
    assert "classical: k (3)" in invoke(*arguments).stdout
    assert "classical-attitude: k (3)" in invoke(*arguments, "--representation", "own").stdout
    assert "ball-attitude: k (3)" in invoke(*arguments, "--representation", "ball-attitude").stdout


def test_options_change_the_scene(tmp_path):
    result = invoke(
        *("drift", "sphere-n3", "--method", "rk-4", "--step", 0.01, "--t-end", 2, "--quiet"),
        *("--out", tmp_path),
    )
    assert result.exit_code == 0
    assert result.stdout == ""
    record = json.loads((tmp_path / "drift.json").read_text())
    run = record["methods"]["rk-4"]["run"]
    assert (run["method"], run["step"], run["steps"]) == ("rk-4", 0.01, 200)
    assert record["provenance"]["scene"]["time"] == {"t_end": 2}


def test_projections_are_said(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(initial={"gamma": [1.0, 2.0, 2.0], "p": [2, -1, 0]})
    path = tmp_path / "scene.toml"
    path.write_text(scene.toml(), encoding="utf-8")
    result = invoke("check", path)
    assert result.exit_code == 0
    assert "note: gamma has length 3" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["chek", "ball-3d"], "Did you mean 'check'?"),
        (["check", "ball-3d", "--step", "abc"], "'abc'"),
        (["check", "ball-3d", "--step", "-1"], "step = -1.0"),
        (["check", "ball-3d", "--method", "cf4"], "'cf-4'"),
        (["check", "ball-3d", "--t-end", "1", "--tau-end", "2"], "one of them"),
        (["check", "ball-3d", "--tau-end", "2"], "--tau-end = 2.0"),
        (["check", "ball-3d", "--method", "rattle-4"], "no form 'hamiltonian'"),
        (["check", "nothing.toml"], "does not exist"),
        (["check", "ball-3d", "--representation", "bal"], "Did you mean 'ball'?"),
        (["check", "ball-3d", "--observe", "enrgy"], "Did you mean 'energy'?"),
        (["drift", "ball-3d", "--methods", "cf-4,cf4"], "Did you mean 'cf-4'?"),
        (["drift", "ball-3d", "--methods", "cf-4:fast"], "the step of 'cf-4' = 'fast'"),
        (["drift", "ball-3d", "--methods", ","], "--methods = ',': expected names"),
        (["check", "ball-3d", "--observe", ""], "--observe = '': expected names"),
        (
            ["stress", "--systems", " , ,", "--axis", "no-such"],
            "--systems = ' , ,': expected names",
        ),
        (["drift", "ball-3d", "--methods", "cf-4", "--step", "1"], "write NAME:STEP"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_bad_command_lines(arguments, word):
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr
    assert word in result.stderr


def test_out_must_be_a_folder(tmp_path):
    path = tmp_path / "file"
    path.touch()
    assert invoke("drift", "sphere-n3", "--out", path).exit_code == 2
    inside = invoke("drift", "sphere-n3", "--t-end", 1, "--out", path / "report")
    assert inside.exit_code == 2
    assert "Traceback" not in inside.stderr


def test_debug_shows_the_traceback():
    assert "Traceback" in invoke("--debug", "check", "bal-3d").stderr
    assert "Traceback" in invoke("check", "bal-3d", "--debug").stderr


@pytest.mark.parametrize("command", ["run", "drift"])
def test_a_failed_run_says_why_and_leaves_what_it_did(command, tmp_path):
    out = tmp_path / ("out.nc" if command == "run" else "report")
    result = invoke(command, by_fixed_point(tmp_path), "--step", 40, "--out", out)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr
    for word in ("did not converge", "t = 0", "step 0", "residual", "iterations", "h = 40"):
        assert word in result.stderr
    if command == "run":
        assert gi.load(out).provenance["status"] == "failed"
    else:
        assert {path.name for path in out.iterdir()} == REPORT
        page = (out / "report.html").read_text(encoding="utf-8")
        assert "gauss-8: failed." in page
        assert "did not converge" in page
        record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
        assert record["status"] == record["methods"]["gauss-8"]["run"]["status"] == "failed"


def test_commands_of_other_packages(monkeypatch):
    @click.command("hello")
    def hello():
        click.echo("hello")

    offer(monkeypatch, "geomint.commands", "hello", hello)
    assert "hello" in invoke("--help").stdout
    assert invoke("hello").stdout == "hello\n"


GROUPS = ("systems", "scenes", "methods", "commands", "watchers", "stress")


def install(folder, name, entries, words="Metadata-Version: 2.1\nName: {}\nVersion: 1.0\n"):
    """Write what pip would of a package with these entry points, group by group."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_bytes(words.format(name).encode("latin-1"))
    lines = (
        f"[geomint.{group}]\n" + "".join(f"{key} = {value}\n" for key, value in of.items())
        for group, of in entries.items()
    )
    (info / "entry_points.txt").write_text("".join(lines), "utf-8")


@pytest.fixture
def other_packages():
    """What is kept of packages is forgotten, before and after."""
    for cached in (methods, plugged):
        cached.cache_clear()
    yield
    for cached in (methods, plugged):
        cached.cache_clear()


PACKAGE = '''
import dataclasses
import click
import geomint as gi
from geomint.tableaux import RUNGE_KUTTA
from pydantic import BaseModel

def made(name):
    return gi.RungeKutta(dataclasses.replace(RUNGE_KUTTA["kutta-3"], name=name))

METHODS = {name: made(name) for name in ("rk-4", "exact", "auto", "gauss-1-suzuki-4", "shared")}
globals().update({name.replace("-", "_"): method for name, method in METHODS.items()})
SYSTEM = gi.System("shared", __name__, BaseModel, BaseModel, dict)

@click.command()
def command():
    """From far away."""
    print(__name__)

class Zero(gi.Watcher):
    """No number but 0."""

def cases():
    return []
'''
TAKEN = {
    "systems": ["veselova"],
    "methods": ["rk-4", "exact", "auto", "gauss-1-suzuki-4"],
    "commands": ["drift", "inertia"],
    "watchers": ["measure", "invariants"],
    "scenes": ["sphere-n3"],
}


def of_other_packages(tmp_path, monkeypatch, names, first):
    """Install packages that offer geomint's own names, and ``shared`` each; ahead of all, or last."""
    for name in names:
        home, module = tmp_path / name, f"{name}_code"
        for old in (module, f"{module}.files"):
            monkeypatch.delitem(sys.modules, old, raising=False)
        (home / module / "files").mkdir(parents=True)
        (home / module / "__init__.py").write_text(PACKAGE, "utf-8")
        (home / module / "files" / "__init__.py").touch()
        for scene in ("sphere-n3", "shared"):
            text = f'title = "of {name}"\n[system]\nname = "veselova"\n[time]\nt_end = 1.0\n'
            (home / module / "files" / f"{scene}.toml").write_text(text, "utf-8")
        things = {"systems": "SYSTEM", "commands": "command", "watchers": "Zero"}
        entries = {
            group: {
                key: f"{module}:{things.get(group, key.replace('-', '_'))}"
                for key in (*taken, "shared")
            }
            for group, taken in TAKEN.items()
        }
        install(home, name, entries | {"scenes": {"all": f"{module}.files"}})
        if first:
            monkeypatch.syspath_prepend(str(home))
        else:
            monkeypatch.setattr(sys, "path", [*sys.path, str(home)])


@pytest.mark.filterwarnings("default::geomint.LeftOutWarning")
@pytest.mark.usefixtures("other_packages")
@pytest.mark.parametrize("first", [True, False])
@pytest.mark.parametrize("names", [("abba", "zappa"), ("zorro", "attila")])
def test_names_of_geomint_are_its_own(names, first, tmp_path, monkeypatch):
    """And of several packages that of the first in the alphabet; others are told once."""
    names = [f"{name}{int(first)}" for name in names]
    of_other_packages(tmp_path, monkeypatch, names, first)
    told = {
        c: invoke(*c.split())
        for c in ("--help", "scenes", "methods", "check sphere-n3", "shared", "inertia --a 1,2 --d 9",
                  "drift --help", "check sphere-n3 --observe measure", "dritf", "scenes ")
    }  # fmt: skip
    assert {c: t.exit_code for c, t in told.items()} == dict.fromkeys(told, 0) | {"dritf": 2}
    winner, loser = sorted(names)
    assert told["--help"].stdout.count("  drift ") == told["--help"].stdout.count("  shared ") == 1
    assert "Convert principal moments" in told["--help"].stdout
    assert told["--help"].stdout.count("From far away.") == 1
    assert told["shared"].stdout == f"{winner}_code\n"
    assert "--methods" in told["drift --help"].stdout
    assert f"of {winner}" in told["scenes"].stdout
    assert f"of {loser}" not in told["scenes"].stdout
    said = "".join(t.stderr for t in told.values()).splitlines()
    assert {line[:17] for line in said if "is left out" in line} == {"geomint: warning:"}
    for group, taken in TAKEN.items():
        for name in taken:
            for package in names:
                assert said_of(said, name, package, group, "geomint") == 1, (group, name, said)
        assert said_of(said, "shared", loser, group, winner) == 1, (group, said)
        assert said_of(said, "shared", winner, group, "") == 0
    # what is found from Python, in silence by now
    with warnings.catch_warnings(action="error"):
        assert gi.load_scene("sphere-n3").title != f"of {winner}"
        assert system_names().count("veselova") == system_names().count("shared") == 1
        assert find_system("veselova").build.__module__.startswith("chaplygin")
        assert find_system("shared").summary == f"{winner}_code"
        assert gi.find_method("rk-4").order == 4
        assert isinstance(gi.find_method("gauss-1-suzuki-4"), gi.Compose)
        assert not {"exact", "auto", "gauss-1-suzuki-4"} & set(gi.method_names())
        assert type(gi.find_method("shared")).__name__ == "RungeKutta"
        assert registered("measure").__class__.__module__.startswith("geomint")
        assert "invariants" not in plugged()


def said_of(lines, name, package, group, owner):
    """Return how many lines tell that a package's name is left out, and who has it."""
    return sum(
        f"package '{package}'" in line
        and f"'{name}'" in line
        and f"geomint.{group}" in line
        and ("geomint" if owner == "geomint" else f"'{owner}' has") in line
        for line in lines
    )


@pytest.mark.filterwarnings("default::geomint.LeftOutWarning")
@pytest.mark.usefixtures("other_packages")
def test_what_is_installed_is_no_word_of_a_run(tmp_path, monkeypatch):
    """Told where the scene is built, whose own notes are printed instead, and kept by no solution."""
    of_other_packages(tmp_path, monkeypatch, ["herod"], True)
    told = invoke("run", by_fixed_point(tmp_path), "--t-end", "5", "--out", tmp_path / "run.nc")
    assert "'rk-4'" in told.stderr
    assert gi.load(tmp_path / "run.nc").warnings == ()


@pytest.mark.filterwarnings("default::geomint.LeftOutWarning")
@pytest.mark.usefixtures("other_packages")
@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[integrate]\nmethod = 3\n", "[integrate] method = 3"),
        (b"title = '\xe9'\n", "cannot be read"),
        (b"system = 3\n", "[system] = 3"),
        (b"[system]\nname = ['veselova', 1]\n", "[system] name"),
        (None, "cannot be read"),
    ],
)
def test_a_scene_of_a_package_that_is_broken(content, words, tmp_path, monkeypatch):
    """It costs its own name: a typed error there, and a row among the others."""
    of_other_packages(tmp_path, monkeypatch, ["fawlty"], True)
    place = tmp_path / "fawlty" / "fawlty_code" / "files" / "lost.toml"
    place.mkdir() if content is None else place.write_bytes(content)
    listed, told = invoke("scenes"), invoke("check", "lost")
    assert listed.exit_code == 0, listed.output
    assert "lost" in listed.stdout
    assert "sphere-n3" in listed.stdout
    assert told.exit_code == 2, told.output
    with pytest.raises(gi.SceneError) as raised:
        gi.load_scene("lost")
    assert words in str(raised.value)


@pytest.mark.usefixtures("other_packages")
def test_a_package_without_a_name(tmp_path, monkeypatch):
    """What pip has written of it cannot be read; its names are others' if they have them too."""
    install(tmp_path, "anon", {"systems": {"veselova": "json:loads"}}, "Name: \xe9{}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.warns(gi.LeftOutWarning, match=r"package '\?': 'veselova'"):
        assert find_system("veselova").build.__module__.startswith("chaplygin")


def test_a_shell_that_completes_words_hears_nothing(tmp_path):
    """Commands but for those that are broken, and no warning in the line that is being written."""
    install(tmp_path, "noisy", {"commands": {"drift": "json:loads", "drizzle": "json:loads"}})
    given = {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    given |= {"_GEOMINT_COMPLETE": "bash_complete", "COMP_WORDS": "geomint dri", "COMP_CWORD": "1"}
    code = "from geomint.cli import main; main(prog_name='geomint')"
    asked = [sys.executable, "-c", code]
    done = subprocess.run(asked, env=os.environ | given, capture_output=True, check=False)
    assert done.stdout.split() == [b"plain,drift"]
    assert done.stderr == b""


@pytest.mark.filterwarnings("default::geomint.LeftOutWarning")
@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("absent_module:x", "ModuleNotFoundError"),
        ("of_bad_syntax:x", "SyntaxError"),
        ("that_exits:x", "SystemExit"),
        ("that_fails:x", "KeyError"),
        ("that_is_skipped:x", "Skipped"),
        ("without_words:x", "Dumb: ?"),
        ("of_two_lines:x", "ValueError: one two"),
        ("json:loads", "is not a"),
        ("no value", "no value"),
    ],
)
@pytest.mark.usefixtures("other_packages")
def test_a_package_that_is_broken_loses_its_own_names(value, words, tmp_path, monkeypatch):
    """One line and exit code 2 for who names what it registers; the rest is as it was."""
    sources = {
        "of_bad_syntax": "x =", "that_exits": "exit()", "that_fails": "{}[0]",
        "that_is_skipped": "class Skipped(BaseException): pass\nraise Skipped",
        "without_words": "class Dumb(Exception):\n    __str__ = None\nraise Dumb",
        "of_two_lines": r"raise ValueError('one\ntwo')",
    }  # fmt: skip
    for name, text in sources.items():
        (tmp_path / f"{name}.py").write_text(f'"""Of a package."""\n{text}\n', encoding="utf-8")
    entries = {key: {"bad": value} for key in GROUPS} | {"methods": {"bad": value, "rk-4": value}}
    install(tmp_path, "broken", entries)
    monkeypatch.syspath_prepend(str(tmp_path))
    scene = tmp_path / "scene.toml"
    scene.write_text('[system]\nname = "bad"\n[time]\nt_end = 1.0\n', encoding="utf-8")
    told = {
        c: invoke(*c.split())
        for c in ("--help", "methods", "scenes", "check sphere-n3", "bad", f"check {scene}",
                  "check sphere-n3 --observe energy,bad", "check sphere-n3 --method bad",
                  "stress --axis momentum --systems no-such")
    }  # fmt: skip
    assert methods()["rk-4"].order == 4
    assert all(isinstance(t.exception, SystemExit | None) for t in told.values()), told
    for command in ("--help", "methods", "scenes", "check sphere-n3"):
        assert told[command].exit_code == 0
    assert "sphere-n3" in told["scenes"].stdout
    assert "'bad' of the group geomint.scenes is left out" in told["scenes"].stderr or "j" in value
    assert "'bad' of the group geomint.methods is left out" in told["methods"].stderr
    for command in ("bad", f"check {scene}", "check sphere-n3 --observe energy,bad"):
        said = [line for line in told[command].stderr.splitlines() if "warning" not in line]
        assert (told[command].exit_code, len(said)) == (2, 1), told[command].stderr
        assert words in said[0] or "expected a geomint.Watcher" in said[0]
    assert told["check sphere-n3 --method bad"].exit_code == 2


def alone(folder, *words, options=(), **environment):
    """Run a command in a process of its own, in a folder; packages that lie there are installed."""
    paths = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, *options, "-m", "geomint", *words],
        env={**os.environ, "PYTHONPATH": paths, **environment},
        **{"cwd": folder, "capture_output": True, "text": True, "check": False},
    )


@pytest.mark.parametrize(
    ("does", "code", "told"),
    [
        ("import warnings; warnings.simplefilter('error')", 0, "warning: package 'loud'"),
        ("import sys; sys.stdout.close()", 2, "standard output cannot be written"),
        ("import sys; sys.stdout.detach()", 2, "standard output cannot be written"),
        ("import sys; sys.stderr.close()", 0, ""),
        ("import sys; sys.stdout.close(); sys.stderr.close()", 2, ""),
    ],
)
def test_what_a_package_does_when_it_is_imported(does, code, told, tmp_path):
    """It is no traceback of commands that need nothing of it, and no other end of them."""
    (tmp_path / "of_loud.py").write_text(f"{does}\n", encoding="utf-8")
    install(tmp_path, "loud", {"methods": {"x": "of_loud:x"}})
    done = alone(tmp_path, "methods")
    assert (done.returncode, told in done.stderr) == (code, True), done.stderr
    assert all(line.startswith("geomint: ") for line in done.stderr.splitlines()), done.stderr
    assert ("rattle-4" in done.stdout) == (code == 0)


@pytest.mark.parametrize(
    "error",
    [
        KeyError("a"),
        ValueError("one\ntwo"),
        SyntaxError("no", ("x.py", 1, 1, "", 1, 1)),
        MemoryError(),
    ],
)
def test_any_error_is_one_line(error, monkeypatch):
    """With --debug the traceback comes before it; within another program it is raised."""

    @click.command("fails")
    @click.option("--debug", is_flag=True)
    def fails(debug):
        raise error

    offer(monkeypatch, "geomint.commands", "fails", fails)
    plain, shown = invoke("fails"), invoke("fails", "--debug")
    assert (plain.exit_code, shown.exit_code) == (2, 2)
    assert plain.stderr.startswith("geomint: a defect, or settings around geomint: ")
    assert plain.stderr.count("\n") == 1
    assert type(error).__name__ in plain.stderr
    assert shown.stderr.startswith("Traceback")
    assert shown.stderr.endswith(plain.stderr)
    with pytest.raises(type(error)):
        main.main(["fails"], "geomint", standalone_mode=False)


@pytest.mark.parametrize(
    ("setting", "words", "told"),
    [
        ("NUMBA_NUM_THREADS=0", "run sphere-n3 --t-end 1", "settings around geomint: ValueError"),
        ("_GEOMINT_COMPLETE=bash_complete", "", "settings around geomint: KeyError: 'COMP_WORDS'"),
        ("MPLBACKEND=nope", "drift sphere-n3 --t-end 1", "geomint: pictures: ValueError"),
        ("MPLBACKEND=nope", "exact sphere-n3 --out of-it", "geomint: pictures: ValueError"),
    ],
)
def test_settings_that_are_broken_are_one_line(setting, words, told, tmp_path):
    """Those of pictures are told before anything is computed."""
    done = alone(tmp_path, *words.split(), **dict([setting.split("=")]))
    assert (done.returncode, told in done.stderr) == (2, True), done.stderr
    assert (done.stdout, done.stderr.count("\n")) == ("", 1)


def test_warnings_of_a_run_are_lines_whatever_python_makes_of_warnings(tmp_path):
    words = ("run", "sphere-n3", "--step", "3", "--t-end", "100", "--quiet")
    done = [alone(tmp_path, *words, PYTHONWARNINGS=asked) for asked in ("", "error")]
    assert [each.returncode for each in done] == [0, 0], done
    assert "geomint: warning: steps of 3 are so long" in done[0].stderr
    assert done[1].stderr == done[0].stderr


def test_a_report_without_docstrings_tells_the_rule(tmp_path):
    """Python leaves them out under -OO."""
    done = alone(tmp_path, "drift", "sphere-n3", "--t-end", "5", "--quiet", options=["-OO"])
    assert done.returncode == 0, done.stderr
    assert "The window means" in (tmp_path / "report" / "report.html").read_text(encoding="utf-8")


def test_a_system_of_another_package(monkeypatch, tmp_path):
    class Strict(BaseModel):
        model_config = ConfigDict(extra="forbid")

    class Frequency(Strict):
        omega: float

    class Position(Strict):
        q: float

    @gi.field
    def oscillator(params, t, y, out, work):
        out[0] = y[1]
        out[1] = -params[0] * params[0] * y[0]

    @gi.field
    def energy(params, t, y, work):
        return 0.5 * (y[1] * y[1] + params[0] * params[0] * y[0] * y[0])

    def build(parameters, initial):
        problem = gi.Problem(
            name="oscillator",
            pieces=(("q", 1), ("v", 1)),
            params=[parameters.omega],
            field=oscillator,
            invariants={"energy": energy},
        )
        return gi.Model({"own": problem}, {"own": problem.state(q=initial.q, v=0.0)})

    system = gi.System("oscillator", "a harmonic oscillator", Frequency, Position, build)

    offer(monkeypatch, "geomint.systems", "oscillator", system)
    path = tmp_path / "scene.toml"
    path.write_text(
        '[system]\nname = "oscillator"\nomega = 2.0\n[initial]\nq = 1.0\n[time]\nt_end = 10.0\n'
    )
    result = invoke("drift", path, "--out", tmp_path / "report")
    assert result.exit_code == 0, result.output
    assert "energy" in result.stdout


def test_a_scene_without_a_field_takes_the_method_that_fits(tmp_path, monkeypatch):
    class Nothing(BaseModel):
        model_config = ConfigDict(extra="forbid")

    def build(parameters, initial):
        return gi.Model({"own": SPRING}, {"own": np.array([1.0, 0.0])})

    system = gi.System("spring", "a spring", Nothing, Nothing, build)

    offer(monkeypatch, "geomint.systems", "spring", system)
    path = tmp_path / "spring.toml"
    path.write_text('[system]\nname = "spring"\n[time]\nt_end = 3.0\n[observe]\nquantities = []\n')
    result = invoke("run", path, "--out", tmp_path / "run.nc")
    assert result.exit_code == 0, result.output
    assert gi.load(tmp_path / "run.nc").method.name == "verlet-8"
    assert "verlet-8" in invoke("check", path).stdout


class Skipped(BaseException):
    """As modules of tests raise it, where they are not to be run."""


class Empty(BaseModel):
    pass


class Dumb(Exception):  # noqa: N818
    __str__ = None


class Checking(BaseModel):
    x: float

    @field_validator("x")
    @classmethod
    def checked(cls, x):
        raise KeyError("from a check")


def failing(error):
    def build(parameters, initial):
        raise error

    return build


def of_itself(parameters, initial):
    return of_itself(parameters, initial)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (failing(TypeError("one\ntwo")), "TypeError: one two"),
        (failing(KeyError("key")), "KeyError: 'key'"),
        (failing(SystemExit(3)), "SystemExit: 3"),
        (failing(Skipped("later")), "Skipped: later"),
        (failing(Dumb()), "Dumb: ?"),
        (of_itself, "RecursionError"),
        (lambda: None, "takes 0 positional arguments"),
        (lambda parameters, initial: None, "None, which is no Model"),
        (lambda parameters, initial: gi.Model({}, {}), "problems = {}: expected"),
        (lambda parameters, initial: gi.Model({"own": 3}, {"own": 0.0}), "problems = {'own': 3}"),
        (lambda parameters, initial: gi.Model(dict.fromkeys("a", SPRING), {}), "for each of ['a']"),
        (Checking, "[system]: its checks failed, KeyError: 'from a check'"),
    ],
)
def test_a_system_that_is_broken_is_told_in_one_line(build, words, tmp_path, monkeypatch):
    keys = Checking if build is Checking else Empty
    system = gi.System("broken", "a broken one", keys, Empty, build)
    offer(monkeypatch, "geomint.systems", "broken", system)
    path = tmp_path / "broken.toml"
    path.write_text('[system]\nname = "broken"\nx = 1.0\n[time]\nt_end = 3.0\n', "utf-8")
    for command in ("check", "run", "scan"):
        told = invoke(command, path)
        assert told.exit_code == 2, (command, told.exception)
        assert words in told.stderr.strip().rpartition("\n")[2]
        assert len(told.stderr.splitlines()) == 1


@pytest.mark.parametrize("given", [(int, Empty, dict), (Empty, {}, dict), (Empty, Empty, 3)])
def test_a_system_is_made_of_models_and_a_function(given):
    with pytest.raises(gi.DomainError, match=r"BaseModel|a function"):
        gi.System("none", "no system", *given)


def pull(params, t, q, out, work):
    out[0] = -1.0 * q[0]


SPRING = gi.Problem("spring", (("q", 1), ("v", 1)), splitting=gi.natural_in_space(gi.helper(pull)))


def test_outputs_have_default_places(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert invoke("drift", "sphere-n3", "--t-end", 5).exit_code == 0
    assert invoke("run", "sphere-n3", "--t-end", 5).exit_code == 0
    assert (tmp_path / "report" / "report.html").exists()
    assert (tmp_path / "sphere-n3.nc").exists()
