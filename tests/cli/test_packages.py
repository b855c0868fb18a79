"""What other packages offer: their own names, never those of geomint; what is broken costs itself."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from pydantic import BaseModel, ConfigDict, field_validator

import geomint as gi
from geomint.cli import main
from tests.cli.calls import alone, install, invoke, offer, session

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
'''
TAKEN = {
    "systems": ["veselova"], "methods": ["rk-4", "exact", "auto", "gauss-1-suzuki-4"],
    "commands": ["drift", "inertia"], "watchers": ["measure", "invariants"], "scenes": ["sphere-n3"],
}  # fmt: skip
BAD_SCENES = {
    "method": (b"[integrate]\nmethod = 3\n", "[integrate] method = 3"),
    "letters": (b"title = '\xe9'\n", "cannot be read"),
    "name": (b"[system]\nname = ['veselova', 1]\n", "[system] name"),
    "folder": (None, "cannot be read"),
}


def packages(folder: Path, names: tuple[str, ...]) -> None:
    """Install packages that offer geomint's own names, ``shared`` each, and scenes that are broken."""
    things = {"systems": "SYSTEM", "commands": "command", "watchers": "Zero"}
    for name in names:
        module = f"{name}_code"
        files = folder / module / "files"
        files.mkdir(parents=True)
        (folder / module / "__init__.py").write_text(PACKAGE, "utf-8")
        (files / "__init__.py").touch()
        for scene in ("sphere-n3", "shared"):
            text = f'title = "of {name}"\n[system]\nname = "veselova"\n[time]\nt_end = 1.0\n'
            (files / f"{scene}.toml").write_text(text, "utf-8")
        for scene, (bad, _) in BAD_SCENES.items():
            place = files / f"{scene}-{name}.toml"
            place.mkdir() if bad is None else place.write_bytes(bad)
        entries = {
            group: {
                key: f"{module}:{things.get(group, key.replace('-', '_'))}"
                for key in (*taken, "shared")
            }
            for group, taken in TAKEN.items()
        }
        install(folder, name, entries | {"scenes": {"all": f"{module}.files"}})


# What is found from Python, in silence by now.
FOUND = """
import warnings
import geomint as gi
warnings.simplefilter("error")
found = {"sphere": gi.load_scene("sphere-n3").title, "rk-4": gi.find_method("rk-4").order}
for name in ("gauss-1-suzuki-4", "shared"):
    found[name] = type(gi.find_method(name)).__name__
told["python"] = [0, json.dumps(found | {"names": gi.method_names()}), ""]
"""


def test_names_of_geomint_are_its_own(tmp_path: Path) -> None:
    """And of several packages that of the first in the alphabet; others are told once."""
    names = "zorro", "attila"
    packages(tmp_path, names)
    winner, loser = sorted(names)
    bad = {f"check {scene}-{winner}": words for scene, (_, words) in BAD_SCENES.items()}
    good = ["--help", "scenes", "methods", "check sphere-n3", "shared", "inertia --a 1,2 --d 9",
            "drift --help", "check sphere-n3 --observe measure"]  # fmt: skip
    run = "run hamiltonized-n3 --method rk-4 --step 0.1 --tau-end 1 --out run.nc"
    told = session(tmp_path, *good, run, "dritf", *bad, then=FOUND)
    assert {line: x[0] for line, x in told.items()} == dict.fromkeys(told, 0) | dict.fromkeys(
        ("dritf", *bad), 2
    )
    said = {line: out for line, (_, out, _) in told.items()}
    for words in ("  drift ", "  shared ", "Convert principal moments", "From far away."):
        assert said["--help"].count(words) == 1
    assert said["shared"] == f"{winner}_code\n"
    assert "--methods" in said["drift --help"]
    (shared,) = [row for row in said["scenes"].splitlines() if row.strip().startswith("shared ")]
    assert shared.split()[1:3] == ["of", winner]
    assert [scene in said["scenes"] for scene in ("sphere-n3", "folder-")] == [True, True]
    for line, words in bad.items():
        assert words in told[line][2]
    lines = "".join(errors for _, _, errors in told.values()).splitlines()
    assert {line[:17] for line in lines if "is left out" in line} == {"geomint: warning:"}
    for group, taken in TAKEN.items():
        for name, package in ((name, package) for name in taken for package in names):
            assert said_of(lines, name, package, group, "geomint") == 1, (group, name, lines)
        assert said_of(lines, "shared", loser, group, f"'{winner}' has") == 1, (group, lines)
        assert said_of(lines, "shared", winner, group, "") == 0
    found = json.loads(said["python"])
    assert found["sphere"] != f"of {winner}"
    assert (found["rk-4"], found["shared"]) == (4, "RungeKutta")
    assert found["gauss-1-suzuki-4"] == "Compose"
    assert not {"exact", "auto", "gauss-1-suzuki-4"} & set(found["names"])
    # What is installed is no word of a run, and kept by no solution.
    assert gi.load(tmp_path / "run.nc").warnings == ()


def said_of(lines: list[str], name: str, package: str, group: str, owner: str) -> int:
    """Return how many lines tell that a package's name is left out, and who has it."""
    words = (f"package '{package}'", f"'{name}'", f"geomint.{group}", owner)
    return sum(all(word in line for word in words) for line in lines)


# Modules of a package, what they do when they are imported, and what is said of it.
BROKEN = {
    "of_bad_syntax": ("x =", "SyntaxError"),
    "that_exits": ("exit()", "SystemExit"),
    "that_fails": ("{}[0]", "KeyError"),
    "that_is_skipped": ("class Skipped(BaseException): pass\nraise Skipped", "Skipped"),
    "without_words": ("class Dumb(Exception):\n    __str__ = None\nraise Dumb", "Dumb: ?"),
    "of_two_lines": (r"raise ValueError('one\ntwo')", "ValueError: one two"),
    "absent_module": (None, "ModuleNotFoundError"),
    "json": (None, "is not a"),
}
GROUPS = ("systems", "methods", "commands", "watchers", "stress")


def test_a_package_that_is_broken_loses_its_own_names(tmp_path: Path) -> None:
    """One line and exit code 2 for who names what it registers; the rest is as it was."""
    for name, (text, _) in BROKEN.items():
        scene = f'[system]\nname = "{name}"\n[time]\nt_end = 1.0\n'
        (tmp_path / f"{name}.toml").write_text(scene, "utf-8")
        if text is not None:
            (tmp_path / f"{name}.py").write_text(f'"""Of a package."""\n{text}\n', "utf-8")
    offers = {name: f"{name}:loads" for name in BROKEN}
    entries = {group: {**offers, "nothing": "no value"} for group in GROUPS}
    entries["methods"]["rk-4"] = "that_fails:x"
    entries["scenes"] = {"bad": "that_fails:x"}
    install(tmp_path, "broken", entries)
    asked = {
        line: words
        for i, (name, (_, words)) in enumerate(BROKEN.items())
        for line in (name, f"check ./{name}.toml", f"check sphere-n3 --observe energy,{name}")[
            i % 3 :: 2
        ]
    }
    rest = ("--help", "methods", "scenes", "check sphere-n3", "check sphere-n3 --method rk-4")
    stress = "stress --axis momentum --systems no-such"
    told = session(tmp_path, *rest, *asked, "check sphere-n3 --method that_fails", stress)
    assert [told[line] for line in rest if told[line][0] != 0] == []
    assert "sphere-n3" in told["scenes"][1]
    for name, group in (("bad", "scenes"), ("nothing", "methods")):
        assert f"'{name}' of the group geomint.{group} is left out" in told[group][2]
    for line, words in asked.items():
        said = [text for text in told[line][2].splitlines() if "warning" not in text]
        assert (told[line][0], len(said)) == (2, 1), told[line]
        assert words in said[0] or "expected a geomint.Watcher" in said[0]
    for line in ("check sphere-n3 --method that_fails", stress):
        assert (told[line][0], "defect" in told[line][2]) == (2, False), told[line]


def test_a_package_without_a_name_says_no_word_to_a_shell(tmp_path: Path) -> None:
    """What pip has written of it cannot be read. A shell that completes words hears nothing of it."""
    entries = {"commands": {"drift": "json:loads", "drizzle": "json:loads"}}
    install(tmp_path, "anon", entries, "\xe9")
    told = session(tmp_path, "drift --help")["drift --help"]
    assert "package '?': 'drift'" in told[2]
    given = {"COMP_WORDS": "geomint dri", "COMP_CWORD": "1", "_GEOMINT_COMPLETE": "bash_complete"}
    code = "from geomint.cli import main; main(prog_name='geomint')"
    done = alone(tmp_path, code, call=("-c",), **given)
    assert (done.stdout.split(), done.stderr) == (["plain,drift"], "")


@pytest.mark.parametrize(
    ("does", "code", "told"),
    [
        ("import warnings; warnings.simplefilter('error')", 0, "warning: package 'loud'"),
        ("import sys; sys.stdout.detach()", 2, "standard output cannot be written"),
        ("import sys; sys.stdout.close(); sys.stderr.close()", 2, ""),
    ],
)
def test_what_a_package_does_when_it_is_imported(
    does: str, code: int, told: str, tmp_path: Path
) -> None:
    """It is no traceback of commands that need nothing of it, and no other end of them."""
    (tmp_path / "of_loud.py").write_text(f"{does}\n", encoding="utf-8")
    install(tmp_path, "loud", {"methods": {"x": "of_loud:x"}})
    done = alone(tmp_path, "methods")
    assert (done.returncode, told in done.stderr) == (code, True), done.stderr
    assert all(line.startswith("geomint: ") for line in done.stderr.splitlines()), done.stderr
    assert ("rattle-4" in done.stdout) == (code == 0)


@pytest.mark.parametrize(
    "error", [ValueError("one\ntwo"), SyntaxError("no", ("x.py", 1, 1, "", 1, 1)), MemoryError()]
)
def test_any_error_is_one_line(error: Exception, monkeypatch) -> None:
    """With --debug the traceback comes before it; within another program it is raised."""

    @click.command("fails")
    @click.option("--debug", is_flag=True)
    def fails(debug: bool) -> None:
        raise error

    offer(monkeypatch, "geomint.commands", "fails", fails)
    plain, shown = invoke("fails"), invoke("fails", "--debug")
    assert (plain.exit_code, shown.exit_code, plain.stderr.count("\n")) == (2, 2, 1)
    told = f"geomint: a defect, or settings around geomint: {type(error).__name__}"
    assert plain.stderr.startswith(told)
    assert shown.stderr.startswith("Traceback")
    assert shown.stderr.endswith(plain.stderr)
    with pytest.raises(type(error)):
        main.main(["fails"], "geomint", standalone_mode=False)


# --- systems --------------------------------------------------------------------------------------


def pull(params, t, q, out, work):
    out[0] = -1.0 * q[0]


SPRING = gi.Problem("spring", (("q", 1), ("v", 1)), splitting=gi.natural_in_space(gi.helper(pull)))


class Empty(BaseModel):
    pass


class Position(BaseModel):
    model_config = ConfigDict(extra="forbid")
    q: float = 1.0


def scene_of(folder: Path, keys: Any, build: Any, monkeypatch) -> Path:
    system = gi.System("new", "a new one", keys, Position, build)
    offer(monkeypatch, "geomint.systems", "new", system)
    text = '[system]\nname = "new"\n[initial]\nq = 1.0\n[time]\nt_end = 3.0\n'
    (folder / "s.toml").write_text(f"{text}[observe]\nquantities = []\n", "utf-8")
    return folder / "s.toml"


def test_a_system_without_a_field_takes_the_method_that_fits(tmp_path: Path, monkeypatch) -> None:
    def build(parameters: Any, initial: Position) -> gi.Model:
        return gi.Model({"own": SPRING}, {"own": np.array([initial.q, 0.0])})

    path = scene_of(tmp_path, Empty, build, monkeypatch)
    result = invoke("run", path, "--out", tmp_path / "run.nc")
    assert result.exit_code == 0, result.output
    assert gi.load(tmp_path / "run.nc").method.name == "verlet-8"


class Checking(BaseModel):
    x: float = 1.0

    @field_validator("x", mode="before")
    @classmethod
    def checked(cls, x: object) -> None:
        raise KeyError("from a check")

    model_config = ConfigDict(validate_default=True)


def model(*parts: Any) -> Any:
    return lambda parameters, initial: gi.Model(*parts)


def of_itself(parameters: Any, initial: Any) -> Any:
    return of_itself(parameters, initial)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda parameters, initial: sys.exit(3), "SystemExit: 3"),
        (of_itself, "RecursionError"),
        (lambda: None, "takes 0 positional arguments"),
        (lambda parameters, initial: None, "None, which is no Model"),
        (model({}, {}), "problems = {}: expected"),
        (model({"own": 3}, {"own": 0.0}), "problems = {'own': 3}"),
        (model({"a": SPRING}, {}), "for each of ['a']"),
        (Checking, "[system]: its checks failed, KeyError: 'from a check'"),
    ],
)
def test_a_system_that_is_broken_is_told_in_one_line(
    build: Any, words: str, tmp_path: Path, monkeypatch
) -> None:
    keys = Checking if build is Checking else Empty
    path = scene_of(tmp_path, keys, build, monkeypatch)
    for command in ("check", "run", "scan"):
        told = invoke(command, path)
        assert (told.exit_code, told.stderr.count("\n")) == (2, 1), (command, told.exception)
        assert words in told.stderr


@pytest.mark.parametrize("given", [(int, Empty, dict), (Empty, {}, dict), (Empty, Empty, 3)])
def test_a_system_is_made_of_models_and_a_function(given: tuple[Any, ...]) -> None:
    with pytest.raises(gi.DomainError, match=r"BaseModel|a function"):
        gi.System("none", "no system", *given)
