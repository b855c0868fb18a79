"""Every option of every command does something: what is printed, refused or asked for differs."""

from __future__ import annotations

import contextlib
import inspect
import itertools
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint import plan as planned
from geomint.cli import find_command, main
from geomint.compare import runs as compared
from tests.asked.asked_support import seen

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")

SCENE = """
[system]
name = "chaplygin-sphere-hamiltonized"
a = [0.8, 1.1, 1.5]
D = 4.0
[initial]
gamma = [0.48, 0.6, 0.64]
p = [3.0, -4.0, 1.5]
[time]
tau_end = 0.5
[integrate]
method = "rk-4"
step = 0.125
[observe]
quantities = ["energy"]
"""
# The lines that options are added to, and what an option has beside it.
LINES = {
    **dict.fromkeys(("check", "run", "drift", "chaos", "warm", "exact"), "s.toml"),
    "section": "s.toml --event gamma[2] --points 3", "scan": "s.toml --vary D=2:4:3",
    "compare": "s.toml --methods rk-4", "scenes": "", "methods": "",
    "inertia": "--d 4 --a 1,1.5,1.2",
}  # fmt: skip
LONG, DRAWN = "--method rk-4 --step 0.125 --tau-end 1e13", "--draws 2"
BESIDE = {
    **{f"{name} --yes": LONG for name in ("run", "drift")}, "compare --yes": "--tau-end 1e13",
    **{f"{name} --representation": "--t-end 1" for name in ("check", "run", "drift", "scan")},
    "chaos --t-end": "--representation reduced",
    **{f"section {option}": "--motions 2" for option in ("--keep", "--seed")},
    **{f"scan {option}": DRAWN for option in ("--keep", "--temperature", "--seed")},
}  # fmt: skip
VALUES = {
    "--method": "gauss-4", "--methods": "gauss-4", "--step": "0.0625", "--tolerance": "1e-5",
    "--t-end": "1", "--tau-end": "1", "--representation": "reduced", "--observe": "energy,K",
    "--event": "gamma[1]", "--direction": "up", "--level": "0.25", "--axes": "gamma[0],K",
    "--vary": "p[0]=2:4:2", "--keep": "K", "--temperature": "1", "--show": "final:K",
    "--steps": "0.1,0.25", "--reference": "extended", "--moments": "1,2,3", "--a": "1,1.5,1.3",
    "--d": "5", "--m": "1", "--rho": "1", "--at": "1", "--animate": "a.txt",
    "--form": "action", "--out": "taken", "run --out": "s.toml",
}  # fmt: skip
# Looked at where they are: what a stopped run does not come to is in tests/report and tests/cli.
ELSEWHERE = {"stress", "audit", "--paper", "compare --quiet"}


def commands() -> dict[str, click.Command]:
    context = click.Context(main)
    found = {name: main.get_command(context, name) for name in main.list_commands(context)}
    return {name: command for name, command in found.items() if name not in ELSEWHERE}


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, short_chains: None) -> list[Any]:
    """Record what commands ask of the rest, where that would take long, instead of doing it."""
    found: list[Any] = []
    clock = time.perf_counter
    monkeypatch.setattr(time, "perf_counter", lambda: 100.0 * clock())  # shorter trials

    def stop(*args: Any) -> None:
        found.append(seen(args))
        raise gi.GeomintError("planned")

    def solve(plan: planned.Plan, progress: Any = None, callback: Any = None) -> None:
        told = [(c.what, c.value, c.chosen) for c in plan.choices]
        stop(plan.purpose, told, plan.problem, plan.state, progress)

    def run(plan: Any, listener: Any) -> None:
        parts = [x for name, x in vars(plan).items() if name not in ("scene", "problems")]
        stop(plan.scene.sections, *parts, listener.progress)

    monkeypatch.setattr(planned.Plan, "solve", solve)
    for name in ("chaos", "scan", "section"):
        monkeypatch.setitem(vars(find_command(name)), "run", run)
    for name in ("checked_steps", "find_peers", "whole"):
        call = getattr(compared, name)
        noting = lambda *args, call=call: found.append(seen(args)) or call(*args)  # noqa: E731
        monkeypatch.setattr(compared, name, noting)
    stopping = lambda model, *args: stop(seen(model.states), *args[:2])  # noqa: E731
    monkeypatch.setattr(compared, "endpoint_of", stopping)
    return found


def outcome(line: str, asked: list[Any], folder: Path) -> Any:
    """Return what is asked for, printed and written."""
    asked.clear()
    (folder / "taken").mkdir(parents=True)
    for name in ("report", "compare", "chaos", "scan", "section", "exact"):
        (folder / "taken" / f"{name}.html").write_text("mine", encoding="utf-8")
    (folder / "s.toml").write_text(SCENE, encoding="utf-8")
    (folder / "o.toml").write_text(SCENE.replace("1.5]\nD", "1.4]\nD"), encoding="utf-8")
    with contextlib.chdir(folder):
        result = CliRunner().invoke(main, line.split(), env={"COLUMNS": "160"})
        written = sorted(str(path) for path in Path().rglob("*"))
    told = " ".join(word for word in result.stdout.split() if not word.startswith("("))
    said = re.sub("this takes .*:?", "this takes", result.stderr)
    return [list(asked), result.exit_code, told, said, written]


def lines(name: str, command: click.Command) -> Iterator[tuple[str, str, str]]:
    """Yield every option with a line without it, and one with it or with another value of it."""
    for p in command.params:
        option = p.opts[0]
        line = f"{name} {LINES[name]} {BESIDE.get(f'{name} {option}', '')}"
        if isinstance(p, click.Argument):
            yield option, line, line.replace("s.toml", "o.toml")
        elif option == "--debug":
            bad = f"{name} {'' if name == 'inertia' else 's.tmol'}"
            yield option, bad, f"{bad} --debug"
        elif not ELSEWHERE & {option, f"{name} {option}"}:
            value = VALUES.get(f"{name} {option}", VALUES.get(option, "2"))
            value = "" if p.is_flag else value
            yield option, line, f"{line} {option} {value}"


@pytest.mark.parametrize("name", commands())
def test_every_option_does_something(name: str, asked: list[Any], tmp_path: Path) -> None:
    places = (tmp_path / str(number) for number in itertools.count())
    outcomes: dict[str, Any] = {}
    for option, *both in lines(name, commands()[name]):
        for line in both:
            if line not in outcomes:
                outcomes[line] = outcome(line, asked, next(places))
        one, other = (outcomes[line] for line in both)
        assert repr(one) != repr(other), f"{option} changes nothing of {one}"
        assert ["Traceback" in x[3] for x in (one, other)] == [False, option == "--debug"]
        assert "Usage" not in one[3] + other[3]
    for line in list(outcomes)[:1]:  # which is the same again
        assert repr(outcome(line, asked, next(places))) == repr(outcomes[line])


def test_the_docs_name_every_option() -> None:
    """Each with its dashes, somewhere."""
    root = Path(__file__).parents[2]
    pages = "".join(p.read_text("utf-8") for p in [*root.glob("docs/*.md"), root / "README.md"])
    named = {p.opts[0] for c in commands().values() for p in c.params if p.opts[0][:1] == "-"}
    assert {option for option in named if option not in pages} <= {"--debug", "--quiet"}


def test_commands_take_the_options_that_they_show() -> None:
    """No parameter of a command's function goes unread."""
    for name, command in commands().items():
        function = inspect.unwrap(command.callback)
        source = inspect.getsource(function).split(") ->", 1)[1]
        for parameter in inspect.signature(function).parameters:
            assert parameter in source, (name, parameter)
