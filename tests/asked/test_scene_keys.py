"""Every key of every section of a scene file does something, for the commands that read it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

import geomint as gi
from geomint.compare import of_scene
from geomint.plan import plan_scan, plan_section
from geomint.run import solve as integrate
from geomint.scene.model import Content
from tests.asked.asked_support import seen

BASE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 2.0},
    "integrate": {"method": "gauss-8", "step": 0.25},
    "observe": {"quantities": ["energy"]},
}
IN_TAU = {
    **BASE,
    "system": {**BASE["system"], "name": "chaplygin-sphere-hamiltonized"},
    "time": {"tau_end": 2.0},
}


def changed(section: str, key: str, given: Any, base: dict[str, Any] = BASE) -> gi.Scene:
    """Return the base with that value of a key; a string for keys that belong to no section."""
    if not section:
        return gi.Scene(**{**base, key: given})
    return gi.Scene(**{**base, section: {**base.get(section, {}), key: given}})


@dataclasses.dataclass
class Stopped(Exception):  # noqa: N818 - no error
    """What a function was called with, instead of calling it."""

    arguments: dict[str, Any]


@pytest.fixture
def stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make `solve` and `compare` raise what they are called with."""

    def instead(*args: Any, **kwargs: Any) -> None:
        kwargs.pop("report", None)
        kwargs.pop("progress", None)
        raise Stopped({"args": seen(args), **{key: seen(x) for key, x in kwargs.items()}})

    monkeypatch.setattr(integrate, "solve", instead)
    monkeypatch.setattr(of_scene, "compare", instead)


def called(function: Callable[..., Any], *args: Any) -> dict[str, Any]:
    with pytest.raises(Stopped) as caught:
        function(*args)
    return caught.value.arguments


def run(scene: gi.Scene) -> Any:
    return called(gi.make_plan(scene, "run").solve)


def drift(scene: gi.Scene) -> Any:
    return called(gi.make_plan(scene.for_drift(), "drift").solve)


def compare(scene: gi.Scene) -> Any:
    chosen = scene.for_compare()
    section = chosen.content.compare
    names = section.methods or [chosen.content.integrate.method]
    return called(of_scene.compare_scene, chosen, names, section.steps)


def told(scene: gi.Scene) -> Any:
    return (scene.title, scene.content.description)


def of_compare(scene: gi.Scene) -> Any:
    return seen(scene.content.compare.model_dump())  # read by the command: see its own table


def several(scene: gi.Scene) -> Any:
    return scene.content.drift.methods  # read by the command: see its own table


def planned(scene: gi.Scene) -> Any:
    return [choice.value for choice in gi.make_plan(scene).choices]


def section(scene: gi.Scene) -> Any:
    plan = plan_section(scene)
    asked = plan.scene.content.section
    return seen((plan.name, plan.event, plan.states, asked.points, asked.axes))


def scan(scene: gi.Scene) -> Any:
    plan = plan_scan(scene)
    keys = [variation.key for variation in plan.variations]
    return seen((keys, plan.values, plan.draws, plan.states, list(plan.readings)))


ALL = (run, drift, compare)
SECTION = {**BASE, "section": {"event": "gamma[2]", "motions": 2}}
DRAWS = {**BASE, "ensemble": {"draws": 2}}
TO_TOLERANCE = {**BASE, "integrate": {"method": "gauss-8"}}
# (section, key): value, other value, who notices, and the base.
TABLE: dict[tuple[str, str], tuple[Any, ...]] = {
    ("", "title"): ("one", "other", (told,)),
    ("", "description"): ("one", "other", (told,)),
    ("system", "name"): ("chaplygin-sphere-reduced", "chaplygin-ball", ALL),
    ("", "initial"): (BASE["initial"], {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]}, ALL),
    ("time", "t_end"): (2.0, 3.0, ALL),
    ("time", "tau_end"): (2.0, 3.0, ALL, IN_TAU),
    ("time", "clock"): (None, "speed", ALL),
    ("integrate", "method"): ("gauss-8", "rk-4", ALL),
    ("integrate", "step"): (0.25, 0.125, ALL),
    ("integrate", "tolerance"): (1e-4, 1e-8, (run, drift, compare), TO_TOLERANCE),
    ("integrate", "representation"): ("own", "ball", ALL),
    ("integrate", "exact"): (None, True, (planned,), {**BASE, "observe": {"quantities": []}}),
    ("observe", "quantities"): (["energy"], ["K"], (run, drift)),
    ("observe", "every"): (1, 3, (run, drift)),
    ("observe", "measure"): (
        {"steps": 3},
        {"steps": 4},
        (run, drift),
        {**BASE, "observe": {"quantities": ["measure"]}},
    ),
    ("save", "every"): (1, 3, (run,)),
    ("save", "t_eval"): ([0.5], [0.5, 1.0], (run,)),
    ("", "events"): ({}, {"it": {"what": "gamma[2]"}}, (run,)),
    ("section", "event"): ("gamma[2]", "gamma[1]", (section,), SECTION),
    ("section", "direction"): ("up", "down", (section,), SECTION),
    ("section", "level"): (0.0, 0.5, (section,), SECTION),
    ("section", "points"): (10, 20, (section,), SECTION),
    ("section", "motions"): (2, 3, (section,), SECTION),
    ("section", "keep"): (["energy"], ["energy", "K"], (section,), SECTION),
    ("section", "seed"): (0, 1, (section,), SECTION),
    ("section", "axes"): (None, ["gamma[0]", "K"], (section,), SECTION),
    ("ensemble", "vary"): ({"D": "2:4:2"}, {"D": "2:4:3"}, (scan,)),
    ("ensemble", "draws"): (2, 3, (scan,)),
    ("ensemble", "keep"): (["energy"], ["energy", "K"], (scan,), DRAWS),
    ("ensemble", "temperature"): (None, 1.0, (scan,), DRAWS),
    ("ensemble", "seed"): (0, 1, (scan,), DRAWS),
    ("ensemble", "show"): (["drift:K"], ["exponent"], (scan,), DRAWS),
    ("drift", "t_end"): (2.0, 3.0, (drift,)),
    ("drift", "tau_end"): (2.0, 3.0, (drift,), IN_TAU),
    ("drift", "method"): ("gauss-8", "rk-4", (drift,)),
    ("drift", "methods"): (["gauss-8"], ["rk-4", "gauss-8:0.5"], (several,)),
    ("drift", "step"): (0.25, 0.125, (drift,)),
    ("drift", "quantities"): (["energy"], ["K"], (drift,)),
    ("drift", "every"): (1, 3, (drift,)),
    ("compare", "t_end"): (2.0, 3.0, (compare,)),
    ("compare", "tau_end"): (2.0, 3.0, (compare,), IN_TAU),
    ("compare", "methods"): (["gauss-8"], ["rk-4"], (compare,)),
    ("compare", "steps"): ([0.25], [0.5], (compare,)),
    ("compare", "repeats"): (1, 2, (of_compare,)),
    ("compare", "reference"): ("extended", "exact", (of_compare,)),
}
# The commands that a section says nothing to: docs/scene-files.md has the same table.
READ_BY = {
    "system": {run, drift, compare},
    "": {run, drift, compare, told},
    "time": {run, drift, compare},
    "integrate": {run, drift, compare, planned},
    "observe": {run, drift},
    "save": {run},
    "drift": {drift, several},
    "compare": {compare, of_compare},
    "section": {section},
    "ensemble": {scan},
}


def keys() -> set[tuple[str, str]]:
    """Return all keys of all sections."""
    found = set()
    for name, entry in Content.model_fields.items():
        kind = entry.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            found |= {(name, key) for key in kind.model_fields}
        else:
            found.add(("", name))
    return found


def test_every_key_is_in_the_table() -> None:
    options = {("observe", "measure")}  # tables of the options of a quantity
    assert set(TABLE) == keys() | options


@pytest.mark.usefixtures("stop", "short_chains")
@pytest.mark.parametrize("at", TABLE, ids=lambda at: " ".join(at))
def test_a_key_does_something(at: tuple[str, str]) -> None:
    one, other, observers, *base = TABLE[at]
    for observer in observers:
        assert observer in READ_BY[at[0]]
        results = [observer(changed(*at, given, *base)) for given in (one, other)]
        assert results[0] != results[1], observer.__name__


@pytest.mark.usefixtures("stop", "short_chains")
@pytest.mark.parametrize("at", TABLE, ids=lambda at: " ".join(at))
def test_a_key_says_nothing_to_the_other_commands(at: tuple[str, str]) -> None:
    one, other, _, *base = TABLE[at]
    if at[0] in ("system", "time", "integrate", ""):
        return
    for observer in {run, drift, compare} - READ_BY[at[0]]:
        results = [observer(changed(*at, given, *base)) for given in (one, other)]
        assert results[0] == results[1], observer.__name__


def test_every_section_of_the_docs_names_its_keys() -> None:
    page = (Path(__file__).parents[2] / "docs" / "scene-files.md").read_text("utf-8")
    for section, key in keys():
        where = page.split(f"## `[{section}]`", 1)[1].split("\n## ", 1)[0] if section else page
        named = (f"`{key}`", f"`[{key}]`", f"\n{key} = ")
        assert any(name in where for name in named), (section, key)
