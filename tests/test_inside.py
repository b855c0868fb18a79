"""Tests use what is public; those of a room's inside import that room alone, by a few names."""

from __future__ import annotations

import ast
import functools
import importlib
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from tests.test_surface import OWN, rooms

HERE = Path(__file__).parent
MODULES, NAMES = 60, 12  # of all rooms together, of each room
SEPARATE = ("paper", "problems", "test_inside.py")  # import-linter holds the first to public names
KERNELS = [
    f"geomint.kernels.{room}"
    for room in ("compiling", "numba_inside", "numbers", "groups", "solve", "tangent")
]
ROOMS = {  # what the tests of a folder may see of the inside
    "kernels": KERNELS,
    "sending": ["geomint.kernels.compiling"],
    "declaring": ["geomint.problems"],
    "methods": ["geomint.methods"],
    "run": ["geomint.run"],
    "ensemble": ["geomint.run"],
    "outputs": ["geomint.run", "geomint.cli"],
    "measure": ["geomint.watch"],
    "watch": ["geomint.watch"],
    "pictures": ["geomint.plots"],
    "scene": ["geomint.scene"],
    "plan": ["geomint.plan"],
    "asked": ["geomint.plan", "geomint.cli"],  # what keys of scenes do is seen in plans
    "fuzz": ["geomint.scene"],
    "report": ["geomint.plan", "geomint.cli"],
    "compare": ["geomint.compare", "geomint.cli"],
    "stress": ["geomint.stress"],
    "cli": ["geomint.cli"],
    "chaplygin": ["chaplygin"],
    "pages": ["geomint.methods", "geomint.watch"],  # the registries, to which pages add
    "test_input.py": ["geomint.errors"],
    "test_surface.py": ["geomint"],  # it lists what is public
    "series.py": ["geomint.watch"],
    "rows.py": ["geomint.kernels.compiling"],
    "conftest.py": ["geomint.run", "geomint.plots"],
}


def imported(tree: ast.AST) -> Iterator[str]:
    """Yield what is taken of the packages, with dots; in strings too, which are set or patched."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            found = [node.value] if isinstance(node, ast.Constant) else []
        for name in found:
            deep = (
                2 if isinstance(node, ast.Constant) else 1
            )  # groups of entry points have names, too
            if re.fullmatch(rf"(geomint|chaplygin)(\.\w+){{{deep},}}", str(name)):
                yield name


@functools.cache
def defining(name: str) -> str | None:
    """Return the module that a name is taken from, itself if it is one; None if there is none."""
    parts, found = name.split("."), None
    for k in range(1, len(parts) + 1):
        if found and not isinstance(getattr(found, parts[k - 1], found), ModuleType):
            break  # a name of that package, whatever modules it has
        try:
            found = importlib.import_module(".".join(parts[:k]))
        except ImportError:
            break
    return found and found.__name__


@functools.cache
def seen() -> dict[tuple[str, str], set[tuple[str, str]]]:
    """Return modules and names that tests see of the inside, by folder and its room or ''."""
    public = {*rooms(), *OWN, "geomint.cli", "geomint.problems.spaces", "geomint.reports"}
    found = defaultdict[tuple[str, str], set[tuple[str, str]]](set)
    for path in HERE.rglob("*.py"):
        place = path.relative_to(HERE)
        if place.parts[0] in SEPARATE:
            continue
        for name in {*imported(ast.parse(path.read_text("utf-8")))}:
            module = defining(name)
            if module is not None and module not in public:
                known = ROOMS.get(place.parts[0], ())
                room = next((r for r in known if f"{module}.".startswith(f"{r}.")), "")
                key = (place.parts[0], room) if room else (str(place), "")
                found[key].add((module, name.removeprefix(module)[1:].partition(".")[0]))
    return found


def test_tests_look_inside_of_their_own_room_alone() -> None:
    others = {place: names for (place, room), names in seen().items() if not room}
    assert not others
    assert not {key: names for key, names in seen().items() if len(names) > NAMES}
    assert len({module for names in seen().values() for module, _ in names}) <= MODULES


def test_names_are_taken_from_where_they_are_defined() -> None:
    """Or from the package of the room, which says what it has: no list stands for many modules."""
    for module, name in (pair for names in seen().values() for pair in names):
        found = importlib.import_module(module)
        thing = getattr(found, name, None)
        defined = thing.__module__ if hasattr(thing, "__qualname__") else module
        own = f"{defined}.".startswith(f"{module}.") if hasattr(found, "__path__") else False
        assert own or defined == module, f"{name} is of {defined}, not of {module}"


def test_no_module_changes_where_others_are_looked_for() -> None:
    for path in HERE.rglob("*.py"):
        text = path.read_text("utf-8")
        for statement in ast.parse(text).body if "sys.path" in text else ():
            inside = () if isinstance(statement, ast.FunctionDef) else ast.walk(statement)
            assert not [n for n in inside if ast.unparse(n) == "sys.path"], path
