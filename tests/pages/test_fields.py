"""Every key of the JSON files, as the text of the public surface has them, is on their page."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable

import geomint as gi
from tests.pages.blocks import ROOT, page

SURFACE = (ROOT / "tests" / "surface.txt").read_text("utf-8")


def section(name: str, heading: str) -> str:
    """Return the part of a page under a heading of the second level."""
    return page(name).read_text("utf-8").split(f"\n## `{heading}`\n", 1)[1].split("\n## ", 1)[0]


def keys(file: str) -> set[str]:
    """Return the keys of a file; what versions and step sizes there are is told in words."""
    paths = re.findall(rf"^{re.escape(file)}(\.\w.*)$", SURFACE, re.MULTILINE)
    if file != "drift.json":  # which tells of the provenance for all of them
        paths = [path for path in paths if not path.startswith(".provenance.")]
    paths = [re.sub(r"(versions|_sizes)\..*", r"\1", path) for path in paths]
    return {key for path in paths for key in re.findall(r"\.(\w+)", path)}


def missing(keys: Iterable[str], text: str) -> list[str]:
    """Return the keys that are neither code nor strings of the page."""
    return [key for key in keys if f"`{key}`" not in text and f'"{key}"' not in text]


def test_keys_of_files() -> None:
    """And of ``drift.json`` the page tells no others."""
    for file in ("drift.json", "compare.json", "audit.json"):
        name = "audit" if file == "audit.json" else "drift-classes"
        assert keys(file)
        assert not missing(keys(file), section(name, file))
    text = section("drift-classes", "drift.json")
    told = set(re.findall(r'"(\w+)":', text)) | set(re.findall(r"`(\w+)`", text))
    assert told - keys("drift.json") <= WORDS


# Words of the text that are no keys.
WORDS = {"success", "interrupted", "failed", "problem", "seed"}


def test_results_by_method_are_as_reports_are() -> None:
    text = section("drift-classes", "drift.json")
    path = ROOT / "benchmarks" / "results" / "drift_by_method.json"
    scene = next(iter(json.loads(path.read_text("utf-8"))["scenes"].values()))
    entry = next(iter(scene["methods"].values()))
    assert not missing({*scene, *entry, *entry["run"]} - {"end"}, text)


def test_options_of_methods() -> None:
    """Each is on one of the pages for users, with what it means."""
    text = "".join(page(name).read_text("utf-8") for name in ("choose-a-method", "scene-files"))
    options = {option for name in gi.method_names() for option in gi.find_method(name).options}
    assert not [o for o in options if not re.search(rf"\b{o}\b", text)]
