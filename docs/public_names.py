"""Public names on the API pages: `geomint.solve`, wherever it is defined.

Pages list modules. What is public of a module is documented under the name that users import, before
the rest of the module; references by either name lead there.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import re
from pathlib import Path
from types import ModuleType
from typing import Any

PACKAGES = ("geomint", "chaplygin")
_MODULE = re.compile(r"^\.\. automodule:: (\S+)\n((?:   .*\n)*)", re.MULTILINE)


@functools.cache
def public_names() -> dict[str, str]:
    """Return public names by where things are defined: of geomint.run.solve.solve, geomint.solve."""
    found = {}
    for name in PACKAGES:
        package = importlib.import_module(name)
        for public in package.__all__:
            value = getattr(package, public)
            module = getattr(value, "__module__", None)
            if module is not None and not isinstance(value, ModuleType):
                found[f"{module}.{public}"] = f"{name}.{public}"
    return found


def with_public_names(text: str) -> str:
    """Return an API page on which modules document what is public under its public name."""
    return _MODULE.sub(_public_first, f"{text}\n")


def _public_first(found: re.Match[str]) -> str:
    module, options = found[1], found[2]
    shown = {}
    for name, value in _members(module).items():
        where = getattr(value, "__module__", None)  # it may be another module
        if public := public_names().get(f"{where}.{name}"):
            shown[name] = public
    if ":no-members:" in options or not shown:
        return found[0]
    here = [public for name, public in shown.items() if f"{module}.{name}" in public_names()]
    directives = [f"\n.. {_directive(p)}:: {p}\n" for p in here if p not in _listed_by_name()]
    kept = re.search(r":exclude-members: (.*)\n", options)
    excluded = ", ".join([*shown, *([kept[1]] if kept else [])])
    return f".. automodule:: {module}\n   :exclude-members: {excluded}\n" + "".join(directives)


def _members(module: str) -> dict[str, Any]:
    found = importlib.import_module(module)
    names = {*vars(found), *getattr(found, "__all__", ())}  # some are loaded when they are used
    return {name: getattr(found, name) for name in names}


@functools.cache
def _listed_by_name() -> set[str]:
    """Return what pages document by its public name themselves."""
    pages = (Path(__file__).parent / "api").glob("*.rst")
    texts = "\n".join(page.read_text("utf-8") for page in pages)
    return set(re.findall(r"^\.\. auto\w+:: ((?:geomint|chaplygin)\.\w+)$", texts, re.MULTILINE))


def _directive(public: str) -> str:
    package, name = public.split(".")
    value = getattr(importlib.import_module(package), name)
    if not inspect.isclass(value):
        return "autofunction"
    return "autoexception" if issubclass(value, BaseException) else "autoclass"


def documented_as(target: str, module: str | None) -> str | None:
    """Return the public name for a reference, or None: it may be relative to a module."""
    for full in (target, f"{module}.{target}"):
        parts = full.split(".")
        for end in range(len(parts), 1, -1):
            public = public_names().get(".".join(parts[:end]))
            if public is not None:
                return ".".join([public, *parts[end:]])
    return None
