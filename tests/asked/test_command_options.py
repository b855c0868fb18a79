"""Every option of every command does something: what is printed, written or asked for differs."""

from __future__ import annotations

import contextlib
import inspect
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import click
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.plan import Plan
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
OTHER = SCENE.replace("1.5]\nD", "1.4]\nD")
NOTHING: tuple[str, ...] = ()
SCENE_OPTIONS = {
    "scene": (("s.toml",), ("o.toml",)),
    "--method": (("s.toml", "--method", "gauss-4"), ("s.toml", "--method", "gauss-5")),
    "--step": (("s.toml", "--step", "0.25"), ("s.toml", "--step", "0.0625")),
    "--tolerance": (("s.toml", "--tolerance", "1e-3"), ("s.toml", "--tolerance", "1e-5")),
    "--t-end": (("s.toml", "--t-end", "2"), ("s.toml", "--t-end", "1")),
    "--tau-end": (("s.toml", "--tau-end", "2"), ("s.toml", "--tau-end", "1")),
    "--representation": (
        ("s.toml", "--t-end", "1", "--representation", "own"),
        ("s.toml", "--t-end", "1", "--representation", "reduced"),
    ),
    "--observe": (("s.toml", "--observe", "energy"), ("s.toml", "--observe", "energy,K")),
    "--debug": (("no-such",), ("no-such", "--debug")),
}
QUIET = {"--quiet": (("s.toml",), ("s.toml", "--quiet"))}
OUT = {"--out": (("s.toml", "--out", "one"), ("s.toml", "--out", "two"))}
LONG = ("s.toml", "--method", "rk-4", "--step", "0.125", "--tau-end", "1e13")
YES = {"--yes": (LONG, (*LONG, "--yes"))}
AT = ("s.toml", "--event", "gamma[2]", "--points", "3")
IN_T = ("s.toml", "--representation", "reduced")
SCAN = ("s.toml", "--vary", "D=2:4:3")
DRAWS = ("s.toml", "--draws", "2")
CHAOS = ("scene", "--method", "--step", "--tolerance", "--tau-end", "--debug")
PAPER = {"--paper": (("s.toml",), ("s.toml", "--paper"))}
METHODS = {"--methods": (("s.toml", "--methods", "rk-4"), ("s.toml", "--methods", "gauss-4"))}

# command: {option: (arguments, other arguments)}

TABLE: dict[str, dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "scenes": {},
    "methods": {"--form": (("--form", "field"), ("--form", "action"))},
    "check": {**SCENE_OPTIONS, **METHODS, "--for-drift": (("s.toml",), ("s.toml", "--for-drift"))},
    "run": {**SCENE_OPTIONS, **OUT, **QUIET, **YES},
    "drift": {**SCENE_OPTIONS, **METHODS, **OUT, **PAPER, **QUIET, **YES},
    "section": {
        **{name: SCENE_OPTIONS[name] for name in ("scene", "--debug")},
        "--method": (AT, (*AT, "--method", "gauss-4")),
        "--step": (AT, (*AT, "--step", "0.25")),
        "--tolerance": (AT, (*AT, "--tolerance", "1e-5")),
        "--representation": (AT, (*AT, "--representation", "reduced")),
        "--event": (AT, ("s.toml", "--event", "gamma[1]", "--points", "3")),
        "--direction": (AT, (*AT, "--direction", "up")),
        "--level": (AT, (*AT, "--level", "0.25")),
        "--points": (AT, (*AT, "--points", "4")),
        "--motions": (AT, (*AT, "--motions", "2")),
        "--seed": ((*AT, "--motions", "2"), (*AT, "--motions", "2", "--seed", "1")),
        "--exact": (AT, (*AT, "--exact")),
        "--axes": (AT, (*AT, "--axes", "gamma[0],K")),
        "--out": ((*AT, "--out", "one"), (*AT, "--out", "two")),
        "--paper": (AT, (*AT, "--paper")),
        "--quiet": (AT, (*AT, "--quiet")),
    },
    "chaos": {
        **{n: SCENE_OPTIONS[n] for n in CHAOS},
        "--t-end": ((*IN_T, "--t-end", "1"), (*IN_T, "--t-end", "2")),
        "--representation": (
            (*IN_T, "--t-end", "1"),
            ("s.toml", "--representation", "classical", "--t-end", "1"),
        ),
        "--count": (("s.toml",), ("s.toml", "--count", "2")),
        **OUT,
        **PAPER,
        **QUIET,
    },
    "scan": {
        **{n: SCENE_OPTIONS[n] for n in ("--debug",)},
        "scene": ((*SCAN,), ("o.toml", *SCAN[1:])),
        "--method": ((*SCAN, "--method", "gauss-4"), (*SCAN, "--method", "gauss-5")),
        "--step": ((*SCAN, "--step", "0.25"), (*SCAN, "--step", "0.0625")),
        "--tolerance": ((*SCAN, "--tolerance", "1e-3"), (*SCAN, "--tolerance", "1e-5")),
        "--t-end": ((*SCAN, "--t-end", "2"), (*SCAN, "--t-end", "1")),
        "--tau-end": ((*SCAN, "--tau-end", "2"), (*SCAN, "--tau-end", "1")),
        "--representation": (
            (*SCAN, "--t-end", "1", "--representation", "reduced"),
            (*SCAN, "--t-end", "1", "--representation", "own"),
        ),
        "--vary": (SCAN, ("s.toml", "--vary", "D=2:4:4")),
        "--draws": (DRAWS, ("s.toml", "--draws", "3")),
        "--keep": (DRAWS, (*DRAWS, "--keep", "energy,K")),
        "--temperature": ((*DRAWS, "--temperature", "1"), (*DRAWS, "--temperature", "2")),
        "--seed": (DRAWS, (*DRAWS, "--seed", "1")),
        "--show": (SCAN, (*SCAN, "--show", "final:K")),
        "--workers": ((*SCAN, "--workers", "1"), (*SCAN, "--workers", "2")),
        "--out": ((*SCAN, "--out", "one"), (*SCAN, "--out", "two")),
        "--paper": (SCAN, (*SCAN, "--paper")),
        "--quiet": (SCAN, (*SCAN, "--quiet")),
    },
    "compare": {
        "scene": SCENE_OPTIONS["scene"],
        "--t-end": SCENE_OPTIONS["--t-end"],
        "--tau-end": SCENE_OPTIONS["--tau-end"],
        "--debug": SCENE_OPTIONS["--debug"],
        "--steps": (("s.toml", "--steps", "0.1,0.2"), ("s.toml", "--steps", "0.1,0.25")),
        "--repeats": (("s.toml", "--repeats", "1"), ("s.toml", "--repeats", "2")),
        "--reference": (("s.toml", "--reference", "exact"), ("s.toml", "--reference", "extended")),
        "--peers": (("s.toml",), ("s.toml", "--peers")),
        "--yes": (("s.toml", "--tau-end", "1e13"), ("s.toml", "--tau-end", "1e13", "--yes")),
        **METHODS,
        **OUT,
        **PAPER,
        **QUIET,
    },
    "warm": {
        "scenes": (("s.toml",), ("s.toml", "o.toml")),
        **METHODS,
        **QUIET,
        "--debug": (("no-such",), ("no-such", "--debug")),
    },
    "stress": {
        "--methods": (("--methods", "rk-4"), ("--methods", "rk-4,cf-4")),
        "--systems": (("--systems", "neumann"), ("--systems", "clebsch")),
        "--axis": (("--axis", "step"), ("--axis", "span")),
        "--quick": (NOTHING, ("--quick",)),
        "--seconds": (("--seconds", "1"), ("--seconds", "2")),
        "--workers": (("--workers", "1"), ("--workers", "2")),
        "--out": (("--out", "one"), ("--out", "two")),
        "--quiet": (NOTHING, ("--quiet",)),
        "--debug": (("--seconds", "7"), ("--seconds", "7", "--debug")),
    },
    "inertia": {
        "--moments": (("--d", "1", "--moments", "1,2,3"), ("--d", "1", "--moments", "1,2,2.5")),
        "--a": (("--d", "4", "--a", "1,1.5"), ("--d", "4", "--a", "1,1.25")),
        "--d": (("--d", "4", "--a", "1,1.5"), ("--d", "5", "--a", "1,1.5")),
        "--m": (
            ("--m", "1", "--rho", "2", "--a", "1,1.5"),
            ("--m", "2", "--rho", "2", "--a", "1,1.5"),
        ),
        "--rho": (
            ("--m", "1", "--rho", "2", "--a", "1,1.5"),
            ("--m", "1", "--rho", "3", "--a", "1,1.5"),
        ),
        "--debug": (NOTHING, ("--debug",)),
    },
    "exact": {
        "scene": (("s.toml",), ("o.toml",)),
        "--at": (("s.toml", "--at", "1"), ("s.toml", "--at", "1,2")),
        "--out": (("s.toml",), ("s.toml", "--out", "two")),
        "--paper": (("s.toml", "--out", "two"), ("s.toml", "--out", "two", "--paper")),
        "--animate": (("s.toml",), ("s.toml", "--animate", "a.gif")),
        "--frames": (
            ("s.toml", "--animate", "a.gif", "--frames", "5"),
            ("s.toml", "--animate", "a.gif", "--frames", "6"),
        ),
        "--debug": (("no-such",), ("no-such", "--debug")),
    },
    "audit": {
        "--n": (("--n", "2"), ("--n", "3")),
        "--points": (("--points", "1"), ("--points", "2")),
        "--seed": (("--seed", "1"), ("--seed", "2")),
        "--out": (NOTHING, ("--out", "two")),
        "--paper": (("--out", "two"), ("--out", "two", "--paper")),
        "--markdown": (NOTHING, ("--markdown", "two.md")),
        "--list": (("--list", "findings"), ("--list", "all")),
        "--quiet": (NOTHING, ("--quiet",)),
        "--debug": (("--n", "99"), ("--n", "99", "--debug")),
    },
}


def commands() -> dict[str, click.Command]:
    context = click.Context(main)
    return {name: main.get_command(context, name) for name in main.list_commands(context)}


def options(command: click.Command) -> set[str]:
    return {p.opts[0] if isinstance(p, click.Option) else p.name for p in command.params}


def test_every_command_and_option_is_in_the_table() -> None:
    assert {name: options(command) for name, command in commands().items()} == {
        name: set(entries) for name, entries in TABLE.items()
    }


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, short_chains: None, blank_pictures: None) -> list[Any]:
    """Record what commands ask of the rest, where that would take long, instead of doing it."""
    found: list[Any] = []

    def note(name: str, answer: Any = None):
        def instead(*args: Any, **kwargs: Any) -> Any:
            kwargs = {k: x for k, x in kwargs.items() if k != "progress"}
            found.append((name, seen(args), seen(kwargs)))
            return answer() if answer else None

        return instead

    from chaplygin.pictures import command, page as exact_page
    from geomint.compare import of_scene
    from geomint.plan import chaos, scan, sections
    from geomint.report import compare_page, drift_page
    from geomint.stress import page, sweep
    from tests.paper import report as audit_report, run as audit_run

    nothing = audit_run.Audit((), (), 0, 0, 0.0)
    monkeypatch.setattr(audit_run, "audit", note("audit", lambda: nothing))
    monkeypatch.setattr(audit_report, "print_audit", note("table"))
    monkeypatch.setattr(command, "_animate", note("animation"))
    monkeypatch.setattr(command, "_path", lambda model: model.problems)
    monkeypatch.setattr(exact_page, "write_exact_report", note("exact", lambda: Path("exact.html")))
    compared = SimpleNamespace(reference="the reference", without_result={}, points=[])
    monkeypatch.setattr(of_scene, "compare_scene", note("compare", lambda: compared))
    monkeypatch.setattr(compare_page, "reference_text", lambda reference: [reference])
    monkeypatch.setattr(page, "write_stress_report", note("report", lambda: Path("page")))

    def first_of_its_kind(function: Any, kind: Any) -> Any:
        """Note the arguments; answer with what the first call of that kind gave."""

        def instead(*args: Any, **kwargs: Any) -> Any:
            found.append((seen(args), seen({k: x for k, x in kwargs.items() if k != "progress"})))
            key = (function, *kind(*args, **kwargs))
            if key not in ANSWERS:
                ANSWERS[key] = function(*args, **kwargs)
            return ANSWERS[key]

        return instead

    def of_scan(problems: Any, states: Any, *, readings: Any, **_: Any) -> Any:
        return problems[0].name, states.shape, *readings

    def of_motion(problem: Any, *_: Any, **__: Any) -> Any:
        return (problem.name,)

    for module, name, kind in (
        (scan, "solve_ensemble", of_scan),
        (chaos, "lyapunov", of_motion),
        (sections, "poincare_section", of_motion),
    ):
        monkeypatch.setattr(module, name, first_of_its_kind(getattr(module, name), kind))

    def run_selection(selection: Any, watch: Any, *, seconds: float, workers: int) -> Any:
        if seconds == 7.0:
            raise gi.GeomintError("seven")
        found.append((seen(selection), seconds, workers))
        return sweep.Result([], [], [], 0.0, False)

    def written(*args: Any) -> Path:
        folder = next(x for x in args if isinstance(x, Path))
        (folder / "report.html").touch()
        return folder / "report.html"

    monkeypatch.setattr(sweep, "run_selection", run_selection)
    monkeypatch.setattr(drift_page, "write_drift_report", written)
    monkeypatch.setattr(compare_page, "write_compare_report", note("written"))
    return found


def outcome(command: str, arguments: tuple[str, ...], asked: list[Any], folder: Path) -> Any:
    """Return what is asked for, printed and written."""
    asked.clear()
    folder.mkdir()
    (folder / "s.toml").write_text(SCENE, encoding="utf-8")
    (folder / "o.toml").write_text(OTHER, encoding="utf-8")
    with contextlib.chdir(folder):
        result = CliRunner().invoke(main, [command, *arguments], env={"COLUMNS": "160"})
        written = sorted(str(path) for path in Path().rglob("*"))
        for path in Path().rglob("section.json"):
            record = json.loads(path.read_text("utf-8"))
            asked.append({key: x for key, x in record.items() if key != "provenance"})
    told = " ".join(word for word in result.stdout.split() if not word.startswith("("))
    return [list(asked), result.exit_code, told, result.stderr, written]


SLOW = {"run", "drift", "warm"}
ANSWERS: dict[tuple[Any, ...], Any] = {}  # of what is asked for
OUTCOMES: dict[tuple[Any, ...], Any] = {}  # of calls that several options begin with


@pytest.mark.parametrize(
    ("command", "option"),
    [(c, o) for c, entries in TABLE.items() for o in entries],
    ids=lambda name: name.lstrip("-"),
)
def test_an_option_does_something(
    command: str,
    option: str,
    asked: list[Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    only_planned = command in SLOW and option not in ("--out", "--paper", "--quiet")
    if only_planned:

        def planned(plan: Plan, progress: Any = None, callback: Any = None) -> None:
            told = [(c.what, c.value, seen(c.chosen)) for c in plan.choices]
            asked.append([plan.purpose, told, seen(plan.problem), seen(plan.state)])
            raise gi.GeomintError("planned")

        monkeypatch.setattr(Plan, "solve", planned)
    for i, arguments in enumerate(TABLE[command][option]):
        if (only_planned, command, arguments) not in OUTCOMES:
            found = outcome(command, arguments, asked, tmp_path / str(i))
            OUTCOMES[only_planned, command, arguments] = found
    one, other = (
        OUTCOMES[only_planned, command, arguments] for arguments in TABLE[command][option]
    )
    assert one != other
    if option == "--debug":
        assert "Traceback" in other[3]
        assert "Traceback" not in one[3]
        return
    if option == "--yes":
        assert "give --yes" in one[3]
        assert "note: this takes about" in other[3]
        return
    assert one[1] == other[1], (one, other)
    assert "Usage" not in one[3] + other[3]


def test_the_docs_name_every_option() -> None:
    """Each with its dashes, somewhere."""
    root = Path(__file__).parents[2]
    pages = "".join(p.read_text("utf-8") for p in [*root.glob("docs/*.md"), root / "README.md"])
    named = {option for entries in TABLE.values() for option in entries if option[:1] == "-"}
    assert {option for option in named if option not in pages} <= HELP_IS_ENOUGH


HELP_IS_ENOUGH = {"--debug", "--quiet"}


def test_commands_take_the_options_that_they_show() -> None:
    """No parameter of a command's function goes unread."""
    for name, command in commands().items():
        function = inspect.unwrap(command.callback)
        source = inspect.getsource(function).split(") ->", 1)[1]
        for parameter in inspect.signature(function).parameters:
            assert parameter in source, (name, parameter)
