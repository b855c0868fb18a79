"""Every field of the JSON files is on the page that describes them."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterable
from typing import Any

import pytest
from blocks import ROOT, page

import geomint as gi
from geomint.compare.runs import Point
from geomint.plan import MethodRun, SeveralRuns
from geomint.problems.testproblems import pulsating_body
from geomint.report.drift_json import drift_record
from geomint.run.provenance import environment, run_record
from geomint.scene.provenance import scene_record
from tests.paper.report import as_json
from tests.paper.run import CLAIMS, audit as evaluate_all


def section(name: str, heading: str) -> str:
    """Return the part of a page under a heading of the second level."""
    return page(name).read_text("utf-8").split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]


def missing(keys: Iterable[str], text: str) -> list[str]:
    """Return the keys that are neither code nor strings of the page."""
    return [key for key in keys if f"`{key}`" not in text and f'"{key}"' not in text]


@pytest.fixture(scope="module")
def solution() -> gi.Solution:
    return gi.solve(
        pulsating_body.problem(),
        pulsating_body.INITIAL,
        t_end=0.5,
        method="dop853-adaptive",
        observe="all",
        compiled=False,
        progress=False,
    )


def test_drift_json(solution: gi.Solution) -> None:
    text = section("drift-classes", "`drift.json`")
    run = MethodRun("dop853-adaptive", None, solution, solution.status)
    record = drift_record(SeveralRuns(gi.load_scene("sphere-n3"), [run]), {})
    assert not missing(record, text)
    (entry,) = record["methods"].values()
    assert entry["quantities"]
    numbers = {key for quantity in entry["quantities"].values() for key in quantity}
    keys = {*environment(), *scene_record(gi.load_scene("sphere-n3")), *run_record(solution)}
    assert not missing({*keys, *entry, *numbers}, text)
    told = set(re.findall(r'"(\w+)":', text)) | set(re.findall(r"`(\w+)`", text))
    assert told - {*keys, *record, *entry, *numbers} <= WORDS


# Words of the text that are no keys.
WORDS = {"success", "interrupted", "failed", "problem", "seed"}


def test_results_by_method_are_as_reports_are() -> None:
    text = section("drift-classes", "`drift.json`")
    path = ROOT / "benchmarks" / "results" / "drift_by_method.json"
    scene = next(iter(json.loads(path.read_text("utf-8"))["scenes"].values()))
    entry = next(iter(scene["methods"].values()))
    assert not missing({*scene, *entry, *entry["run"]} - {"end"}, text)


def test_compare_json() -> None:
    text = section("drift-classes", "`compare.json`")
    assert not missing([field.name for field in dataclasses.fields(Point)], text)


def test_audit_json() -> None:
    text = section("audit", "`audit.json`")
    document: dict[str, Any] = as_json(evaluate_all((3,), 1, claims=CLAIMS[:1]))
    assert not missing(document, text)
    assert not missing(document["gap"], text)
    assert not missing(document["claims"][0], text)


def test_options_of_methods() -> None:
    """Each is on one of the pages for users, with what it means."""
    text = "".join(page(name).read_text("utf-8") for name in ("choose-a-method", "scene-files"))
    options = {option for name in gi.method_names() for option in gi.find_method(name).options}
    assert not [o for o in options if not re.search(rf"\b{o}\b", text)]
