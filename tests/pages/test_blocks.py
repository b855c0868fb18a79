"""What pages show is what happens: Python, commands with their outputs, options."""

from __future__ import annotations

import contextlib
import functools
import gc
import json
import shlex
import sys
import tomllib
from pathlib import Path
from typing import Any

import click
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.cli import main
from tests.cli.calls import install
from tests.pages.blocks import PAGES, Block, blocks, commands, examples, invocations, page
from tests.pages.session import NOT_RUN, alike, is_slow, outputs, printed, same

CONSOLES = ["tutorial", "scene-files", "is-it-chaotic"]
FIRST = ("tutorial", "README")  # the others are run at night
# The packages that pages tell how to write are installed as they say: see below.
WRITTEN = {
    "add-a-diagnostic",
    "add-a-method",
    "add-a-space",
    "add-a-system",
    "add-a-command",
    "my-own-system",
}
PYTHON = [
    path.stem
    for path in PAGES
    if path.stem not in {*WRITTEN, "stress"} and any(b.info == "python" for b in blocks(path))
]


def at_night(names: list[str]) -> list[Any]:
    return [pytest.param(n, marks=[pytest.mark.nightly] * (n not in FIRST)) for n in names]


def test_every_console_is_run_somewhere() -> None:
    shown = {p.stem for p in PAGES if any(block.info == "console" for block in blocks(p))}
    assert shown <= {*CONSOLES, *WRITTEN, "audit"}


@pytest.mark.parametrize(
    "slow", [False, pytest.param(True, marks=pytest.mark.nightly)], ids=["fast", "all"]
)
@pytest.mark.parametrize("name", at_night(CONSOLES))
def test_commands_print_what_the_page_shows(name: str, slow: bool, tmp_path: Path) -> None:
    ran = 0
    for command, lines in outputs(name, tmp_path, slow):
        if command.output:
            assert same(command.output, lines), (command.text, "\n".join(lines))
            ran += 1
    shown = [c for c in commands(page(name)) if not c.text.startswith(NOT_RUN)]
    assert ran >= sum(1 for c in shown if c.output and (slow or not is_slow(c.text))) > 0


@pytest.mark.parametrize("name", at_night(PYTHON))
def test_python_prints_what_the_page_shows(name: str, tmp_path: Path) -> None:
    """All blocks of a page in one namespace, in their order."""
    scope: dict[str, object] = {"__name__": "page"}
    with contextlib.chdir(tmp_path):
        for example in examples(page(name)):
            text = printed(example.source, scope, str(page(name)), example.line)
            plt.close("all")
            if example.output is not None:
                shown = example.output.text.splitlines()
                assert same(shown, text.rstrip().splitlines()), (example.line, text)
    if name == "README":
        check_readme(scope)


def test_what_is_alike() -> None:
    """On a processor that pages were not written on: roundings and iterations are others."""
    shown = "H   1.25e-15 (−1.5 ± 2.6)e-18  sqrt\nsteps 917, about 8.99e+04"
    assert alike(shown, "H  0   (0.1 ± 2)e-17 sqrt\nsteps 917, about\n9.5e+04")
    for other in ("H 1e-12 0 sqrt steps 917, about 9e4", "H 0 0 sqrt steps 917, about 8e4"):
        assert not alike(shown, other)
    assert not alike(shown, shown.replace("sqrt", "linear"))
    assert not alike(shown, shown + " more")


def check_readme(scope: dict[str, object]) -> None:
    """Neither run warns, and both keep their energy; the pendulum, from rest, against SciPy."""
    for name, energy in (("sol", 1e-13), ("swing", 1e-11)):
        sol = scope[name]
        assert isinstance(sol, gi.Solution)
        assert not sol.warnings
        assert sol.drift["energy"].max_abs_error < energy
    tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12}
    exact = solve_ivp(lambda t, y: [y[1], -np.sin(y[0])], (0, 1000), [2, 0], **tight)
    np.testing.assert_allclose(sol.y[-1], exact.y[:, -1], atol=2e-8)


def installed(folder: Path, entry_points: str) -> None:
    """Make the entry points of a pyproject.toml known, as an installation would."""
    groups = tomllib.loads(entry_points)["project"]["entry-points"]
    install(folder, "page", {group.removeprefix("geomint."): of for group, of in groups.items()})


def forget() -> None:
    """Let registries look for entry points again."""
    for known in gc.get_objects():
        if type(known) is functools._lru_cache_wrapper and "registry" in known.__module__:
            known.cache_clear()


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A folder on the path of imports, whose modules are forgotten afterwards."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(str(tmp_path))
    forget()
    yield tmp_path
    forget()
    for name in set(sys.modules) - before:
        if (getattr(sys.modules[name], "__file__", None) or "").startswith(str(tmp_path)):
            del sys.modules[name]


def by_info(name: str, info: str) -> list[Block]:
    return [block for block in blocks(page(name)) if block.info == info]


@pytest.mark.nightly
def test_a_method_of_ones_own_works_as_its_page_says(package: Path) -> None:
    """The tableau, registered; the order that is printed; the midpoint rule; and the doctest."""
    tableau, order, midpoint, same_bytes = examples(page("add-a-method"))
    (entry_points,) = by_info("add-a-method", "toml")
    (package / "more_methods.py").write_text(tableau.source, "utf-8")
    installed(package, entry_points.text)
    assert gi.find_method("ralston-4").order == 4
    scope: dict[str, object] = {}
    assert printed(order.source, scope, "add-a-method", 0) == order.output.text
    (package / "midpoint.py").write_text(midpoint.source, "utf-8")
    exec("from midpoint import MIDPOINT_2", scope)
    printed(same_bytes.source, scope, "add-a-method", 0)
    (session,) = by_info("add-a-method", "pycon")
    inputs = [x.removeprefix(">>> ") for x in session.text.splitlines() if x.startswith(">>> ")]
    exec(inputs[0], scope)
    assert str(eval(inputs[1], scope)) == session.text.splitlines()[-1]


STEP = 3  # columns of a numbered step: what is indented further is an aside


@pytest.fixture
def tops(package: Path) -> tuple[Path, str, list[str]]:
    """The package of the page on systems: its folder, its first scene, and the files of tests."""
    files = [b.text for b in by_info("add-a-system", "python") if b.indent <= STEP]
    *own, tests, top, sleigh, suslov, others = files
    scene, project, other_scene, other_point = (b.text for b in by_info("add-a-system", "toml"))
    (package / "tops").mkdir()
    names = ("__init__.py", "free_top.py", "free-top.toml", "heavy_top.py", "sleigh.py")
    texts = ("", "\n\n".join(own), scene, top, sleigh, suslov, other_scene)
    for name, text in zip((*names, "suslov.py", "suslov.toml"), texts, strict=True):
        (package / "tops" / name).write_text(text, "utf-8")
    installed(package, project.replace("free-top =", f"{other_point.splitlines()[1]}\nfree-top ="))
    return package, scene, [tests, others]


@pytest.mark.nightly
def test_systems_of_ones_own_work_as_their_page_says(
    tops: tuple[Path, str, list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    """The files of the page, their tests, plans of the scenes, and the error that it shows."""
    package, scene, tests = tops
    for k, text in enumerate(tests):
        scope: dict[str, object] = {}
        exec(compile(text, f"tests_{k}.py", "exec"), scope)
        given = scope.get("PROBLEMS", [])
        functions = {name: f for name, f in scope.items() if name.startswith("test_")}
        assert len(functions) == 2
        for function in functions.values():
            for arguments in [(p,) for p in given] if hasattr(function, "pytestmark") else [()]:
                function(*arguments)
    for name in ("free-top", "suslov"):
        assert gi.load_scene(name).content.system.name == name
    bad = scene.replace("moments = [1.0, 2.0, 3.0]", "moment = [1.0, 2.0]")
    (package / "bad.toml").write_text(bad, "utf-8")
    (shown,) = (c for c in commands(page("add-a-system")) if "bad.toml" in c.text)
    with contextlib.chdir(package), pytest.raises(SystemExit):
        main(shlex.split(shown.text)[1:])
    told = capsys.readouterr()
    assert same(shown.output, (told.out + told.err).splitlines())


@pytest.mark.nightly
def test_a_space_of_ones_own_works_as_its_page_says(package: Path) -> None:
    """What is printed, the files of the page, and its tests."""
    shown, space, particle, group, *tests = examples(page("add-a-space"))
    assert printed(shown.source, {}, "add-a-space", 0).rstrip() == shown.output.text.rstrip()
    for name, block in (("hyperboloid", space), ("particle", particle), ("integrator", group)):
        (package / f"{name}.py").write_text(block.source, "utf-8")
    scope: dict[str, object] = {}
    for block in tests:
        exec(compile(block.source, "test_hyperboloid.py", "exec"), scope)
    ran = [scope[name]() for name in list(scope) if name.startswith("test_")]
    assert len(ran) == 4


@pytest.mark.nightly
def test_a_diagnostic_of_ones_own_works_as_its_page_says(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its file, what is printed, its test; by its name from a scene and from the command line."""
    file, shown, test = examples(page("add-a-diagnostic"))
    entry_points, options = (b.text for b in by_info("add-a-diagnostic", "toml"))
    (package / "stretching.py").write_text(file.source, "utf-8")
    installed(package, entry_points)
    assert printed(shown.source, {"gi": gi}, "add-a-diagnostic", 0) == shown.output.text
    scope: dict[str, object] = {}
    exec(compile(test.source, "test_stretching.py", "exec"), scope)
    scope["test_stretching"]()
    scene = gi.load_scene("hamiltonized-n3").changed(
        time={"tau_end": 20.0}, observe=tomllib.loads(options)["observe"]
    )
    drift = gi.run_scene(scene, progress=False).drift["stretching"]
    assert drift.windows.samples == 80
    (command,) = commands(page("add-a-diagnostic"))
    with contextlib.chdir(package), contextlib.suppress(SystemExit):
        main(shlex.split(command.text)[1:])
    told = capsys.readouterr()
    assert "stretching" in told.out, told.err
    record = json.loads((package / "stretched" / "drift.json").read_text("utf-8"))
    (run,) = record["methods"].values()
    assert run["quantities"]["stretching"]["samples"] == 400
    text = (package / "stretched" / "report.html").read_text("utf-8")
    assert "stretching: the logarithm of how much a small distance" in text


@pytest.mark.nightly
def test_a_command_of_ones_own_works_as_its_page_says(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its file, by its entry point: from the shell, from Python, and in scenes."""
    file, shown = examples(page("add-a-command"))
    assert len(file.source.splitlines()) <= 80
    entry_points, section = (b.text for b in by_info("add-a-command", "toml"))
    (package / "period.py").write_text(file.source, "utf-8")
    installed(package, entry_points)
    with contextlib.chdir(package):
        assert printed(shown.source, {}, "add-a-command", 0) == shown.output.text
        (command,) = commands(page("add-a-command"))
        with pytest.raises(SystemExit) as ended:
            main(shlex.split(command.text)[1:])
        told = capsys.readouterr().out
        assert (ended.value.code, "q[1] returns 5 times." in told) == (0, True), told
        scene = gi.load_scene("neumann-n3").changed(**tomllib.loads(section))
        assert scene.content.period.event == "q[1]"
        with pytest.raises(gi.SceneError, match=r"\[period\] evnt.*Did you mean 'event'"):
            scene.changed(period={"evnt": "q[0]"})


def test_commands_of_pages_are_accepted() -> None:
    """Every geomint command that a page shows, in whatever block, has a command and its options."""
    context = click.Context(main)
    seen = 0
    for where, line in invocations():
        for part in line.split(" | "):
            words = shlex.split(part.replace("…", "1"))
            words = words[1:] if words[0] == "geomint" else words
            if words[0] == "period":  # of the page that makes it
                continue
            command = main.get_command(context, words[0]) if words else None
            if words[0].startswith("-"):
                continue
            assert command is not None, (where, line)
            with contextlib.suppress(click.MissingParameter):
                command.make_context(words[0], words[1:], resilient_parsing=False)
            seen += 1
    assert seen > 30
