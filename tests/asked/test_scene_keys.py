"""Every key of every section of a scene file does something, for the commands that read it."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

import geomint as gi
from geomint.cli import find_command
from tests.asked.asked_support import another, called

BASE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [3.0, -4.0, 1.5]},
    "time": {"t_end": 1.0},
    "integrate": {"method": "rk-4", "step": 0.125},
    "observe": {"quantities": ["energy"]},
    "section": {"event": "gamma[2]", "points": 10, "motions": 2},
    "ensemble": {"draws": 2},
}
IN_TAU = {"system": {**BASE["system"], "name": "chaplygin-sphere-hamiltonized"}}
IN_TAU |= {"time": {"tau_end": 1.0}}
# Another value of a key than the one above, or none; two, as a tuple; and sections beside them.
PAIRS: dict[str, Any] = {
    "title": "two", "description": "two", "events": {"it": {"what": "gamma[2]"}},
    "initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
    "system.name": "chaplygin-ball", "time.clock": "speed", "integrate.method": "kutta-3",
    "integrate.tolerance": (1e-3, 1e-4), "integrate.representation": "ball", "integrate.exact": True,
    "observe.quantities": ["K"], "observe.every": 3, "save.every": 3,
    "save.t_eval": [0.5], "section.event": "gamma[1]", "section.direction": "down",
    "section.level": 0.5, "section.seed": 1, "section.axes": ["gamma[0]", "K"],
    "section.keep": ["energy", "K"], "ensemble.vary": ({"D": "2:4:2"}, {"D": "2:4:3"}),
    "ensemble.keep": ["energy", "K"], "ensemble.temperature": 1.0, "ensemble.seed": 1,
    "ensemble.show": ["exponent"], "drift.method": "kutta-3", "drift.methods": ["rk-4", "gauss-8:0.5"],
    "drift.step": 0.25, "drift.quantities": ["K"], "drift.every": 3, "drift.t_end": 2.0,
    "compare.methods": ["gauss-8"], "compare.steps": [0.25], "compare.repeats": 2,
    "compare.reference": "exact", "compare.peers": True, "section.exact": True,
    "chaos.count": 2, "ensemble.workers": 2, "compare.t_end": 2.0,
    **{f"{section}.tau_end": (2.0, 3.0) for section in ("time", "drift", "compare")},
}  # fmt: skip
BESIDE = {
    **{f"{section}.tau_end": IN_TAU for section in ("time", "drift", "compare")},
    "integrate.tolerance": {"integrate": {"method": "rk-4"}},
    "integrate.exact": {"observe": {"quantities": []}}, "ensemble.vary": {"ensemble": {}},
}  # fmt: skip


@functools.cache
def outcomes(content: str) -> dict[str, Any]:
    """Return what the commands make of a scene, by command."""
    scene = gi.Scene(**eval(content))
    comparing, integrate = find_command("compare").scene(scene, {}).content, scene.content.integrate

    def drift() -> Any:
        chosen = scene.for_drift()  # the methods of a report are read by the command
        return [gi.make_plan(chosen, "drift").solve(False), chosen.content.drift.methods]

    def section() -> Any:
        plan = find_command("section").plan(scene)
        asked = plan.scene.content.section
        return [plan.event, plan.states, asked.points, asked.axes, asked.exact]

    def scan() -> Any:
        plan = find_command("scan").plan(scene)
        keys = [variation.key for variation in plan.variations]
        workers = plan.scene.content.ensemble.workers
        return [plan.values, plan.draws, plan.states, list(plan.readings), keys, workers]

    def chaos() -> Any:
        return find_command("chaos").plan(scene).scene.content.chaos.count

    makers = {
        "chaos": chaos,
        "run": lambda: gi.make_plan(scene).solve(False), "drift": drift, "scan": scan,
        "compare": lambda: [scene.model.states, comparing.time.end, comparing.compare, scene.method,
                            integrate.step, integrate.tolerance, integrate.representation],
        "section": section, "check": lambda: [scene.title, scene.content.description],
    }  # fmt: skip
    return {command: called(make, {}) for command, make in makers.items()}


def changed(key: str, value: Any, sections: dict[str, Any]) -> str:
    """Return the scene's content with that value of a key, or as it is without it."""
    section, _, name = key.rpartition(".")
    content = {**BASE, **sections}
    if value is not None:
        content[section or name] = {**content.get(section, {}), name: value} if section else value
    return repr(content)


def keys() -> list[str]:
    """Return all keys of all sections."""
    found = []
    for name, entry in type(gi.Scene(**BASE).content).model_fields.items():
        kind = entry.annotation
        model = isinstance(kind, type) and issubclass(kind, BaseModel)
        found += [f"{name}.{key}" for key in kind.model_fields] if model else [name]
    return found


ALL = {"run", "drift", "compare"}
# The commands that a section says something to, of which docs/scene-files.md has a table.
READ_BY = {"title": {"check"}, "description": {"check"}, "events": {"run"}, "save": {"run"}}
READ_BY |= {"observe": {"run", "drift"}, "ensemble": {"scan"}, "system": ALL, "initial": ALL}
READ_BY |= {"integrate.exact": {"run", "scan", "chaos"}} | {
    name: {name} for name in ("section", "drift", "compare", "chaos")
}


@pytest.mark.usefixtures("short_chains")
@pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
@pytest.mark.parametrize("key", keys())
def test_every_key_does_something_for_the_commands_that_read_it(key: str) -> None:
    section, _, name = key.rpartition(".")
    value = PAIRS[key] if key in PAIRS else another(BASE[section][name])
    values = value if isinstance(value, tuple) else (None, value)
    first, second = (outcomes(changed(key, value, BESIDE.get(key, {}))) for value in values)
    told = {command for command in first if repr(first[command]) != repr(second[command])}
    wanted = READ_BY.get(key, READ_BY.get(section, ALL))
    assert wanted <= told
    assert wanted == ALL or told == wanted


def test_every_section_of_the_docs_names_its_keys() -> None:
    page = (Path(__file__).parents[2] / "docs" / "scene-files.md").read_text("utf-8")
    for section, _, key in (key.rpartition(".") for key in keys()):
        where = page.split(f"## `[{section}]`", 1)[1].split("\n## ", 1)[0] if section else page
        named = (f"`{key}`", f"`[{key}]`", f"\n{key} = ")
        assert any(name in where for name in named), (section, key)
