"""Figures in the text of pages are those of the results beside them.

An entry is a sentence, made of the JSON, that must be on the page: a new measurement without a new
sentence fails, and says what the sentence would be. Tables of docs are made at the build
(``docs/tables.py``) and cannot differ.
"""

from __future__ import annotations

import importlib.util
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from tests.pages.blocks import ROOT, page

RESULTS = ROOT / "benchmarks" / "results"


def result(name: str) -> dict[str, Any]:
    return json.loads((RESULTS / f"{name}.json").read_text("utf-8"))


def script(name: str) -> ModuleType:
    """Return a benchmark as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "benchmarks"))
        spec.loader.exec_module(module)
    return module


def against_heyoka() -> Iterator[tuple[str, str]]:
    table = result("against_peers")
    ratios = [row["geometric_mean"] for row in table["rows"] if row["goal"] == 1e-9]
    yield "README", f"at tolerance 1e-9 from {table['states']} random states"
    faster, slower = f"{max(ratios):.2g} times faster", f"{1 / min(ratios):.2g} times slower"
    yield "README", f"up to {faster} (large systems) or {slower} (short runs of small systems)"


def measure() -> Iterator[tuple[str, str]]:
    scenes = result("measure_cost")["scenes"]
    ratios = [m["measure_us"] / m["step_us"] for ms in scenes.values() for m in ms.values()]
    yield "limitations", f"methods {min(ratios):.0f} to {max(ratios):.0f} times (`python"

    def times(scene: str, method: str) -> float:
        return scenes[scene][method]["measure_us"] / scenes[scene][method]["step_us"]

    ball = [times("ball-3d", name) for name in ("rkmk-4", "cf-4")]
    small = [times("hamiltonized-n3", name) for name in ("verlet-4", "rk-4")]
    gauss = [times(scene, "gauss-8") for scene in ("hamiltonized-n3", "ball-3d")]
    yield "tutorial", f"costs {times('ball-3d', 'cf-4'):.0f} times"
    sphere = "times a step of `rk-4` or `verlet-4` of the Hamiltonised sphere at n = 3, and"
    of_gauss, of_groups = "times one of `gauss-8`", "times a step of `cf-4` or `rkmk-4`"
    for words in (
        f"costs {min(small):.0f} to {max(small):.0f} {sphere} {gauss[0]:.0f} {of_gauss}",
        f"it is {times('ball-3d', 'rk-4'):.0f} times a step of `rk-4` of the ball at n = 3.",
        f"{min(ball):.0f} to {max(ball):.0f} {of_groups}, {gauss[1]:.0f} {of_gauss} (`python",
    ):
        yield "drift-classes", words
    yield "limitations", f"takes {times('ball-3d', 'cf-4'):.0f} times a plain one's time"


def audit() -> Iterator[tuple[str, str]]:
    text = (ROOT / "docs" / "audit-table.md").read_text("utf-8")
    found = re.search(r"Distinct findings: ([^.]+)\.", text)
    counts = dict(reversed(part.split(" ", 1)) for part in found[1].split(", "))
    misprints, unprinted = counts["misprint"], counts["needs a restriction"]
    yield "audit", f"It finds {misprints} misprints, {unprinted} restrictions that are not printed"
    yield "audit", f", {counts['holds on the manifold only']} formulas that need |γ| = 1, and"
    stronger = counts["condition stronger than needed"]
    yield "audit", f" and {stronger} condition that is stronger than needed"


def ladder(table: str, method: str) -> list[dict[str, Any]]:
    points = result("method_tables")["tables"][table]["points"]
    return [point for point in points if point["method"] == method and point["error"]]


def seconds_at(table: str, methods: tuple[str, ...], error: float) -> float:
    """Return the time of the fastest of some methods at an error, between the points of its ladder."""
    found = []
    for method in methods:
        points = sorted((p["error"], p["seconds"]) for p in ladder(table, method))
        errors, seconds = np.log(np.array(points)).T
        found.append(math.exp(np.interp(math.log(error), errors, seconds)))
    return min(found)


def compared() -> Iterator[tuple[str, str]]:
    """Two methods at the same error, and a Gauss method at half the step."""
    rattle, verlet = (
        np.array(
            [seconds_at("splittings", (f"{name}-4", f"{name}-6"), 10.0**-k) for k in range(3, 8)]
        )
        for name in ("rattle", "verlet")
    )
    low, high = min(rattle / verlet), max(rattle / verlet)
    slow = seconds_at("rkmk", ("rkmk-4",), 1e-9)
    shares = [slow / seconds_at("rkmk", (f"rkmk-{t}dop853",), 1e-9) for t in ("", "cayley-")]
    told = f"{shares[0]:.0f} and {shares[1]:.0f}"
    coarse, fine = ladder("sphere", "gauss-8")[:2]
    smaller = 100 * round(coarse["error"] / fine["error"] / 100)
    steps = f"from {coarse['step']:.2f} to {fine['step']:.2f}"
    for words in (
        f"{low:.0f} to {high:.0f} times as fast as compositions of RATTLE",
        f"on the ball {told} times as fast as `rkmk-4` at an error of 1e-9",
        f"the iteration converges faster: {fine['seconds'] / coarse['seconds']:.1f} times from",
        f"{steps} in the table above, for an error {smaller} times as small",
    ):
        yield "choose-a-method", words


def power(value: float) -> str:
    return f"{value:.0e}".replace("e-0", "e-")


def exact() -> Iterator[tuple[str, str]]:
    """The exact flow against double-double arithmetic, and methods against it."""
    worst = max(run["deviation"][-1] for run in result("exact_flow")["against double-double"])
    yield "exact-flow", f"which share nothing with it: {power(worst)} at τ = 10⁴"
    phase = result("global_error")["methods"]["gauss-8"]["phase"]
    yield "exact-flow", f"{power(phase[0])} at T = 10 and {power(phase[-1])} at 10⁷ for gauss-8"


SOURCES = (against_heyoka, measure, audit, compared, exact)
FIGURES = [entry for source in SOURCES for entry in source()]


def test_tables_are_of_the_results() -> None:
    record = result("drift_classes")
    cells = next(value for value in record.values() if isinstance(value, list))
    drift_classes = script("drift_classes").table(cells, record["seeds"])
    stress = script("stress_table").page(result("stress"))
    for name, told in (("drift-classes", drift_classes), ("stress", stress)):
        assert page(f"{name}-table").read_text("utf-8") == told


def words_of(name: str) -> str:
    return " ".join(page(name).read_text("utf-8").split())


@pytest.mark.parametrize(("name", "sentence"), FIGURES)
def test_the_page_has_the_figures_of_the_result(name: str, sentence: str) -> None:
    assert sentence in words_of(name)


def test_long_runs_are_as_the_page_says() -> None:
    """Of dop853 and the bounded methods, after ten million steps."""
    scenes = result("long_runs")["scenes"]

    def energy(scene: str, method: str) -> float:
        return scenes[scene]["methods"][method]["drift"]["energy"]["max_abs_error"]

    assert energy("veselova-n3", "dop853") > energy("veselova-n3", "gauss-2")
    hamiltonized, ellipsoid = ("gauss-2", "rattle-4", "verlet-4"), ("rattle-2", "rattle-4")
    for scene, methods in (("hamiltonized-n3", hamiltonized), ("ellipsoid-n4", ellipsoid)):
        assert energy(scene, "dop853") < min(energy(scene, method) for method in methods)
    methods = scenes["hamiltonized-n3"]["methods"]
    assert {methods["gauss-8"]["drift"][n]["class"] for n in ("norm", "tangency")} == {"sqrt"}
    assert 1.5e-18 < abs(methods["gauss-2"]["drift"]["norm"]["slope"]) < 2.5e-18


ROUNDING = 32 * 2.0**-52
# Methods by what they keep to round-off in all six scenes, as the table "Which method for what" says.
KEEPS = {
    "energy": ("gauss-8",),
    "constraints": ("gauss-8", "gauss-2", "rattle-2", "rattle-4", "cf-4", "rkmk-4"),
}


def test_what_is_kept_by_which_method() -> None:
    scenes = result("drift_by_method")["scenes"]
    for scene in scenes.values():
        for label, method in scene["methods"].items():
            for name, found in method["quantities"].items():
                kind, size = scene["kinds"][name], found["max_abs_error"] / found["scale"]
                if label in KEEPS.get(kind, ()):
                    assert size <= ROUNDING, (label, name)
                if kind == "integrals" and label.startswith(("cf", "rkmk")):
                    assert size <= ROUNDING, (label, name)
                if kind == "energy":
                    assert label != "rk-4" or found["class"] == "linear"
                    assert not label.startswith("rattle") or found["class"] == "bounded"


def test_rattle_costs_what_pages_say() -> None:
    """60 to 300 times gauss-8, the pair 1 to 4 times: the least of points with no larger error."""
    ours = ladder("sphere", "gauss-8")
    bounds = {"rattle-4": (60, 300), "rattle-6": (60, 300), "rattle-8": (60, 300)}
    for name, (low, high) in (bounds | {"lobatto-8": (0.7, 4)}).items():
        for point in ladder("sphere", name):
            if 1e-10 < point["error"] < 1e-4:
                best = min(p["seconds"] for p in ours if p["error"] <= point["error"])
                assert 0.8 * low < point["seconds"] / best < 1.2 * high, (name, point)
    for name in ("limitations", "choose-a-method"):
        assert "60 to 300 times" in words_of(name)
        assert "1 to 4 times" in words_of(name)


EXAMPLES = re.findall(
    r"^\| `drift ([^`]+)` \| `([\w-]+)` \| ([\d.e+-]+) \| .*? \| `(\w+)` \|$",
    page("drift-classes").read_text("utf-8"),
    re.MULTILINE,
)


@pytest.mark.nightly
@pytest.mark.parametrize(("words", "quantity", "size", "kind"), EXAMPLES)
def test_examples_of_drift_classes(
    words: str, quantity: str, size: str, kind: str, tmp_path: Path
) -> None:
    """Watched alone: what else a report watches changes nothing but its time."""
    assert len(EXAMPLES) == 7
    line = ["drift", *words.split(), "--observe", quantity, "--out", str(tmp_path)]
    assert CliRunner().invoke(main, line).exit_code == 0
    (entry,) = json.loads((tmp_path / "drift.json").read_text("utf-8"))["methods"].values()
    found = entry["quantities"][quantity]
    assert (f"{found['max_abs_error']:.1e}", found["class"]) == (size, kind)


def test_the_tables_of_plans_are_of_these_scenes_and_rules() -> None:
    """Plans take what the result says that they took, and no built-in scene is missing."""
    record, rules = result("plan_table"), script("plan_table").RULES
    assert [row["name"] for row in record["scenes"]] == gi.scene_names()
    assert [row["label"] for row in record["rules"]] == list(rules)
    for row in record["rules"]:
        plan = gi.make_plan(gi.Scene(**rules[row["label"]]))
        exact = plan.exact is not None and plan.exact.chosen is not None
        assert row["taken"] == ("exact flow" if exact else plan.route.name)
        assert row["taken"] != next(iter(plan.scene.model.problems))
