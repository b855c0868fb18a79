"""Tests use what is public; those of a room's inside import that room alone, by a few names."""

from __future__ import annotations

import ast
import functools
import importlib
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from tests.test_surface import OWN, rooms

HERE = Path(__file__).parent
MODULES, NAMES = 60, 12  # of all rooms together, of each room
SEPARATE = ("paper", "problems")  # which import-linter holds to public names, and test problems
KERNELS = [
    f"geomint.kernels.{room}" for room in ("compiling", "numbers", "groups", "solve", "tangent")
]
ROOMS = {  # what the tests of a folder may see of the inside
    "kernels": KERNELS,
    "sending": ["geomint.kernels.compiling"],
    "declaring": ["geomint.problems"],
    "methods": ["geomint.methods"],
    "run": ["geomint.run"],
    "ensemble": ["geomint.run"],
    "outputs": ["geomint.run"],
    "measure": ["geomint.watch"],
    "watch": ["geomint.watch"],
    "pictures": ["geomint.plots"],
    "scene": ["geomint.scene"],
    "fuzz": ["geomint.scene"],
    "report": ["geomint.plan"],
    "compare": ["geomint.compare"],
    "stress": ["geomint.stress"],
    "cli": ["geomint.cli"],
    "chaplygin": ["chaplygin"],
}


def imported(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield modules of the packages and the names that are taken from them, in strings too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found = [(alias.name, "") for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found = [(node.module or "", alias.name) for alias in node.names]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found = [(node.value.rpartition(".")[0], node.value.rpartition(".")[2])]
        else:
            continue
        for module, name in found:
            if module.split(".")[0] in OWN and module.replace(".", "").isidentifier():
                yield module, name


def defining(module: str, name: str) -> tuple[str, str] | None:
    """Return the module that a name is taken from, and the name; the module alone if it is one."""
    for split in range(module.count(".") + 1):
        parent, *rest = module.rsplit(".", split)
        try:
            found = importlib.import_module(parent)
        except ImportError:
            continue
        if isinstance(getattr(found, (*rest, name)[0], None), ModuleType):
            return f"{parent}.{(*rest, name)[0]}", (*rest, name, "")[1]
        return parent, (*rest, name)[0]
    return None


@functools.cache
def seen() -> dict[str, set[tuple[str, str]]]:
    """Return by room what tests import of its inside; what is not of the folder's own room is in ''."""
    public, found = {*rooms(), *OWN, "geomint.cli"}, defaultdict[str, set[tuple[str, str]]](set)
    for path in HERE.rglob("*.py"):
        folder = path.relative_to(HERE).parts[0]
        for given in imported(ast.parse(path.read_text("utf-8"))) if folder not in SEPARATE else ():
            name = defining(*given)
            if name is not None and name[0] not in public:
                known = (r for r in ROOMS.get(folder, ()) if f"{name[0]}.".startswith(f"{r}."))
                room = next(known, "")
                found[room].add(name if room else (str(path.relative_to(HERE)), ".".join(name)))
    return found


def test_tests_look_inside_of_their_own_room_alone() -> None:
    found = seen()
    assert not found.pop("", None)
    assert not {room: sorted(names) for room, names in found.items() if len(names) > NAMES}
    assert len({module for names in found.values() for module, _ in names}) <= MODULES


def test_names_are_taken_from_where_they_are_defined() -> None:
    """So that no list of names stands for many modules."""
    for module, name in (pair for names in seen().values() for pair in names):
        thing = getattr(importlib.import_module(module), name, None)
        assert getattr(thing, "__module__", module) == module, f"{module}.{name}"


def test_no_module_changes_where_others_are_looked_for() -> None:
    for path in HERE.rglob("*.py"):
        for statement in ast.parse(path.read_text("utf-8")).body:
            inside = () if isinstance(statement, ast.FunctionDef) else ast.walk(statement)
            assert not [n for n in inside if ast.unparse(n) == "sys.path"], path
