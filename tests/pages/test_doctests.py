"""The examples of all docstrings of both packages."""

from __future__ import annotations

import doctest
import importlib
import inspect
import re
from pathlib import Path
from types import ModuleType

import pytest

import chaplygin
import geomint

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src"
API = sorted(p for p in (ROOT / "docs" / "api").glob("*.rst") if ">>> " in p.read_text("utf-8"))
MODULES = [
    ".".join(path.relative_to(SOURCES).with_suffix("").parts).removesuffix(".__init__")
    for path in sorted(SOURCES.rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


@pytest.mark.nightly
@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings(name: str) -> None:
    """Each docstring brings the names that it uses, as a reader would have to."""
    examples = 0
    for test in doctest.DocTestFinder().find(importlib.import_module(name)):
        test.globs = {}
        examples += ran(test)
    assert examples


def ran(test: doctest.DocTest) -> int:
    """Return how many examples there were, or fail."""
    runner = doctest.DocTestRunner(verbose=False, optionflags=doctest.NORMALIZE_WHITESPACE)
    output: list[str] = []
    runner.run(test, out=output.append)
    assert runner.failures == 0, "".join(output)
    return runner.tries


@pytest.mark.nightly
@pytest.mark.parametrize("path", API, ids=lambda path: path.stem)
def test_examples_of_api_pages(path: Path) -> None:
    """All of a page in one session."""
    text = path.read_text("utf-8")
    assert ran(doctest.DocTestParser().get_doctest(text, {}, path.stem, str(path), 0))


# What a function returns has its example there.
RETURNED = {"TangentFlow": "tangent_flow", "Sensitivities": "sensitivities"}


@pytest.mark.parametrize("package", [geomint, chaplygin], ids=lambda p: p.__name__)
def test_every_public_name_has_an_example(package: ModuleType) -> None:
    """In its docstring, or in those of an API page."""
    shown = "\n".join(path.read_text("utf-8") for path in API)
    lines = "\n".join(re.findall(r"^(?:>>>|\.\.\.) (.*)$", shown, re.MULTILINE))
    short = {geomint: "gi", chaplygin: "ch"}[package]
    for name in package.__all__:
        own = inspect.getdoc(getattr(package, RETURNED.get(name, name))) or ""
        assert ">>> " in own or re.search(rf"\b{short}\.{name}\b", lines), name
