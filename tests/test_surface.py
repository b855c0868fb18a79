"""The public surface is the one that `surface.txt` lists; what changes there is said in the changelog.

    python tests/test_surface.py        writes the list anew

Names of the packages with signatures, attributes of what they return, methods and their options,
scenes, the keys that they may have, commands with options, exit codes, and what is in the files that
commands write. Parameters that have to be given by name stand on lines of their own.
"""

from __future__ import annotations

import ast
import contextlib
import csv
import difflib
import functools
import importlib
import inspect
import json
import pkgutil
import re
import signal
import tempfile
import textwrap
import tomllib
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner
from scipy.io import netcdf_file

import chaplygin
import geomint as gi
from geomint.cli import main
from geomint.cli.options import EXIT_CODES
from geomint.cli.signals import NAMES as SIGNALS
from geomint.watch.quantities import quantities_of

TEXT = Path(__file__).with_name("surface.txt")
OWN = ("geomint", "chaplygin")
PUBLIC = {name for package in (gi, chaplygin) for name in package.__all__}
PACKAGES = ("geomint", "geomint.compare.runs", "geomint.scipy", "geomint.testing")
PACKAGES += ("geomint.tableaux", "chaplygin")
SYSTEMS = {found.name: found for found in entry_points(group="geomint.systems")}


def rooms() -> Iterator[str]:
    """Yield the public modules; those that are so as a whole stand in the contracts of imports."""
    yield from PACKAGES
    project = tomllib.loads((TEXT.parents[1] / "pyproject.toml").read_text("utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    allowed = [line.split(" -> ")[1] for c in contracts for line in c.get("ignore_imports", ())]
    for name in [*allowed, "geomint.problems.testproblems", "geomint.problems.testproblems.*"]:
        package = name.removesuffix(".*")
        path = importlib.import_module(package).__path__ if package != name else ()
        yield from [f"{package}.{m.name}" for m in pkgutil.iter_modules(path)] if path else [name]


def names() -> Iterator[str]:
    """Yield what can be imported."""
    known: dict[Any, str] = {}
    for room in rooms():
        module = importlib.import_module(room)
        for name in getattr(module, "__all__", filter(str.isupper, vars(module))):
            thing, full = getattr(module, name), f"{room}.{name}"
            if callable(thing) and known.setdefault(thing, full) != full:
                yield f"{full} is {known[thing]}"
            elif isinstance(thing, type):
                yield from of_class(full, thing)
            elif callable(thing):
                yield from of_call(full, thing)
            elif isinstance(thing, Mapping):
                yield from (f"{full}[{key!r}]" for key in thing)
            else:
                yield f"{full} = {thing}" if isinstance(thing, int | str) else full
    for part in parts():
        yield from of_class(type(part).__name__, type(part))


def parts() -> Iterator[Any]:
    """Yield parts of results that have no public names."""
    scene = gi.load_scene("sphere-n3").changed(time={"t_end": 0.5})
    (run,) = gi.run_methods(scene, ["rk-4"], False)
    given = {"tolerance": 1e-3, "dense": True, "events": "gamma[2]", "method": "rk-4"}
    sol = gi.solve(scene.problem, scene.state, t_end=0.5, compiled=False, **given)
    yield from (run, sol.accuracy, sol.sol, sol.step_sizes, *sol.events.values())


def of_call(full: str, function: Callable[..., Any]) -> Iterator[str]:
    """Yield the signature; the name alone of what has none, such as an alias of a type."""
    try:
        given = inspect.signature(function).parameters.values()
    except ValueError:
        yield full
        return
    bare = [p.replace(annotation=p.empty) for p in given if p.name != "self"]
    by_name = [p for p in bare if p.kind in (p.KEYWORD_ONLY, p.VAR_KEYWORD)]
    lines = [str(inspect.Signature([p for p in bare if p not in by_name]))]
    for line in lines + [f"(…, {p})" for p in by_name]:
        yield full + re.sub(r"<function (\S+) at 0x\w+>", r"\1", line)


def of_class(full: str, kind: type) -> Iterator[str]:
    """Yield bases that users can name, and what these do not have: constructor, members."""
    bases = [b for b in kind.__mro__[1:-1] if b.__module__ == "builtins" or b.__name__ in PUBLIC]
    inherited = {line for base in bases for line in members(base)}
    yield from (f"{full}: {base.__name__}" for base in bases)
    yield from of_call(full, kind)
    yield from (f"{full}.{line}" for line in members(kind) if line not in inherited)


def members(kind: type) -> Iterator[str]:
    """Yield the methods and attributes of a class of our own."""
    own = [base for base in reversed(kind.__mro__) if base.__module__.split(".")[0] in OWN]
    found = {
        name: None for base in own for name in [*assigned(base), *inspect.get_annotations(base)]
    }
    found |= {name: member for base in own for name, member in vars(base).items()}
    for name, member in found.items():
        if name[0] != "_":
            called = callable(member) or isinstance(member, classmethod | staticmethod)
            yield from of_call(name, getattr(kind, name)) if called else [name]


@functools.cache
def assigned(kind: type) -> set[str]:
    """Return the attributes that the methods of a class set."""
    with contextlib.suppress(OSError):  # made by a function: it has no source
        tree = ast.walk(ast.parse(textwrap.dedent(inspect.getsource(kind))))
        stored = [n for n in tree if isinstance(n, ast.Attribute) and isinstance(n.ctx, ast.Store)]
        return {n.attr for n in stored if isinstance(n.value, ast.Name) and n.value.id == "self"}
    return set()


def methods() -> Iterator[str]:
    """Yield the methods with the defaults of their options."""
    for name in gi.method_names():
        method = gi.find_method(name)
        given = ", ".join(f"{option}={default!r}" for option, default in method.options.items())
        kind = "adaptive " * method.adaptive + f"of order {method.order}"
        yield f"{name}({given}): {kind}, {method.needs}"


def scenes() -> Iterator[str]:
    """Yield the built-in scenes, and of their systems representations, states and quantities."""
    for name in gi.scene_names():
        scene = gi.load_scene(name)
        system = scene.content.system.name
        yield f"{name}: {system}"
        for form, problem in scene.model.problems.items():
            yield f"{system}: {form} in {problem.time}: {', '.join(problem.slices)}"
            yield from (f"{system}: {form}: {quantity}" for quantity in quantities_of(problem))


def scene_keys() -> Iterator[str]:
    """Yield the keys of scene files, with what they take and defaults."""
    yield from keys_of("", type(gi.load_scene("ball-3d").content).model_json_schema())
    for name, found in SYSTEMS.items():
        system = found.load()
        yield from keys_of(f"[system] of {name}:", system.parameters.model_json_schema())
        yield from keys_of(f"[initial] of {name}:", system.initial.model_json_schema())


def keys_of(
    head: str, schema: dict[str, Any], sections: dict[str, Any] | None = None
) -> Iterator[str]:
    """Yield the keys of a section, and of those in it."""
    sections = schema.get("$defs", {}) if sections is None else sections
    for key, given in schema["properties"].items():
        told = {k: x for k, x in given.items() if k not in ("title", "description")}
        text = json.dumps(told, ensure_ascii=False).replace('"', "")
        text = re.sub(r"\{type: (\w+)\}", r"\1", text)
        inner = re.findall(r"\$ref: #/\$defs/(\w+)", text)
        for name in inner:
            yield from keys_of(f"{head}[{key}]", sections[name], sections)
        if not inner:
            yield f"{head} {key} {text}".strip() + " required" * (key in schema.get("required", ()))


def options() -> Iterator[str]:
    """Yield options and arguments of the commands, and the exit codes."""
    context = click.Context(main)
    commands = {name: main.get_command(context, name) for name in main.list_commands(context)}
    for name, command in {"": main, **commands}.items():
        assert command is not None
        for p in command.params:
            told = p.to_info_dict()
            kind = re.sub(r"<.* object at 0x\w+>", p.type.name, repr(p.type))
            marks = [m for m in ("is_flag", "multiple", "required", "hidden") if told.get(m)]
            start = f"geomint {name}".strip()
            default = f"= {told['default']}" if told["default"] is not None else ""
            yield " ".join([start, *p.opts, *p.secondary_opts, kind, *marks, default]).strip()


def exit_codes() -> Iterator[str]:
    """Yield the exit codes and what they mean."""
    yield from (f"{code}: {meaning}" for meaning, code in EXIT_CODES.items())
    yield from (f"{128 + getattr(signal, name)}: {name}" for name in SIGNALS)


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
[events]
equator = {what = "gamma[2]"}
"""
COMPARED = "s.toml --methods rk-4 --steps 0.05,0.025,0.0125 --repeats 1 --reference exact --paper"
CALLS = {
    "run": "s.toml",
    "drift": "s.toml --paper",
    "section": "s.toml --event equator --points 3 --paper",
    "scan": "s.toml --vary D=2:4:2 --show drift:energy --paper",
    "chaos": "s.toml --count 2 --paper",
    "compare": COMPARED,
    "stress": "--quick --methods rk-4 --axis step --workers 1",
    "exact": "s.toml --at 1 --paper",
    "audit": "--n 2 --points 1 --paper",
}
# Mappings whose keys are names of something.
NAMED = {
    *("counts", "files", "findings", "kept", "kinds", "method_options", "methods", "orders"),
    *("parameters", "quantities", "readings", "statuses", "vary", "verdicts"),
}


LATE = ("compare", "stress", "exact", "audit")  # commands that are looked at at night


def outputs(late: bool = True) -> Iterator[str]:
    """Yield what commands write: files, keys of JSON, columns of CSV, variables of NetCDF."""
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        Path("s.toml").write_text(SCENE, "utf-8")
        for command, words in CALLS.items():
            if command in LATE and not late:
                continue
            done = CliRunner().invoke(main, [command, *words.split(), "--out", f"{command}.nc"])
            assert done.exit_code in (0, 1), done.output
            written = Path(f"{command}.nc")
            for file in sorted(written.iterdir()) if written.is_dir() else [written]:
                yield from (f"{file.name}{line}" for line in content(file))


def content(file: Path) -> Iterator[str]:
    """Yield nothing after the name of a file, and what is in it."""
    yield ""
    if file.suffix == ".json":
        yield from leaves(json.loads(file.read_text("utf-8")))
    elif file.suffix == ".csv":
        with file.open(encoding="utf-8", newline="") as stream:
            yield from (f": {column}" for column in next(csv.reader(stream)))
    elif file.suffix == ".nc":
        with netcdf_file(file, mmap=False) as run:
            for name, text in run._attributes.items():
                told = leaves(json.loads(text)) if text[:1] == b"{" else [""]
                yield from (f": attribute {name}{leaf}" for leaf in told)
            for name, variable in run.variables.items():
                yield f": variable {name}({', '.join(variable.dimensions)})"


def leaves(x: Any) -> Iterator[str]:
    """Yield the paths of all keys, once; the keys of a scene are told above."""
    found: dict[str, None] = {}
    if isinstance(x, dict):
        for key, value in x.items():
            named = key in NAMED and isinstance(value, dict)
            start = f".{key}{{}}" if named else f".{key}"
            for inner in value.values() or [None] if named else [value]:
                found |= {
                    start + leaf: None for leaf in (leaves(inner) if key != "scene" else [""])
                }
    for item in x if isinstance(x, list) else ():
        found |= {f"[]{leaf}": None for leaf in leaves(item)}
    yield from found or [""]


SECTIONS = (names, methods, scenes, scene_keys, options, exit_codes, outputs)


def surface(late: bool = True) -> str:
    """Return the whole text, or all but the files of commands that take long."""
    made = [f"# {TEXT.name}: written by `python tests/test_surface.py`, not by hand.\n"]
    for section in SECTIONS:
        head = section.__name__.replace("_", " ")
        lines = section(late) if section is outputs else section()
        made.append("\n".join(["", f"# {head}", *sorted(set(lines)), ""]))
    return "".join(made)


HOW = """
The public surface has changed. If that is meant, write it anew by `python tests/test_surface.py`, and
say in CHANGELOG.md what has changed, from what to what.
"""

# Records that work goes on in; all others stay what they were when they were made.
CHANGING = {
    *("Account", "AdaptiveFlow", "Algebra", "Comparison", "Ending", "Ensemble", "ExactRun"),
    *("Function", "InvariantMeasure", "Motion", "Outcome", "Result", "Search", "Section", "Seen"),
    *("SeveralRuns", "Solution", "Flow", "StepsAgain", "Stretch", "SymplecticDefect", "Trial"),
    *("Wanted", "Watcher", "Windows"),
}


def test_records_do_not_change() -> None:
    """And are compared and shown as the kind that they are of says, which no fields hide."""
    found = set()
    for package in (gi, chaplygin):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            for kind in vars(importlib.import_module(module.name)).values():
                own = isinstance(kind, type) and kind.__module__ == module.name
                if own and "__dataclass_params__" in vars(kind):
                    found |= set() if kind.__dataclass_params__.frozen else {kind.__name__}
                    plain = [b for b in kind.__mro__[1:-1] if "__dataclass_params__" not in vars(b)]
                    said = {"__eq__", "__repr__"} & {name for base in plain for name in vars(base)}
                    assert not said & vars(kind).keys(), kind
    assert found == CHANGING


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
@pytest.mark.parametrize("late", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_the_surface_is_the_one_that_is_written_down(late: bool) -> None:
    old, new = TEXT.read_text("utf-8"), surface(late)
    if not late:
        before, head, files = old.partition("\n# outputs\n")
        kept = [line for line in files.splitlines(True) if not line.startswith(LATE)]
        old = before + head + "".join(kept)
    changes = difflib.unified_diff(old.splitlines(), new.splitlines(), n=0, lineterm="")
    assert old == new, "\n".join([HOW, *changes])


if __name__ == "__main__":
    TEXT.write_text(surface(), "utf-8")
