"""Mutated scenes: the content of built-in ones with some keys, values or characters changed."""

from __future__ import annotations

import copy
import json
import math
import tomllib
from functools import cache
from importlib.metadata import entry_points
from random import Random
from typing import Any

import geomint as gi
from tests.fuzz import hostile

__all__ = ["mutated_content", "mutated_text", "toml_text"]

Content_ = dict[str, Any]


@cache
def originals() -> dict[str, Content_]:
    """Return the contents of all built-in scenes."""
    return {name: tomllib.loads(gi.load_scene(name).toml()) for name in gi.scene_names()}


def short(content: Content_) -> Content_:
    """Return a scene of few steps: five of what it gives, as few as may be."""
    result = copy.deepcopy(content)
    step = result.get("integrate", {}).get("step", 0.1)
    for section in ("time", "drift", "compare"):
        for end in ("t_end", "tau_end"):
            if end in result.get(section, {}):
                result[section][end] = 5.0 * step
    if "t_eval" in result.get("save", {}):
        result["save"]["t_eval"] = [step]
    if "every" in result.get("observe", {}):
        result["observe"]["every"] = 2
    return result


@cache
def systems() -> dict[str, gi.System]:
    """Return all systems by name."""
    return {point.name: point.load() for point in sorted(entry_points(group="geomint.systems"))}


@cache
def known_keys() -> dict[str, tuple[str, ...]]:
    """Return all keys that a section may have, in any system."""
    model = type(gi.load_scene("sphere-n3").content)
    keys = {
        name: tuple(getattr(field.annotation, "model_fields", {}))
        for name, field in model.model_fields.items()
    }
    every = systems().values()
    keys["system"] = ("name", *dict.fromkeys(k for s in every for k in s.parameters.model_fields))
    keys["initial"] = tuple(dict.fromkeys(k for s in every for k in s.initial.model_fields))
    options = ("iteration_tolerance", "max_iterations", "iteration", "fused")
    options += ("rtol", "atol", "max_step", "max_steps")
    keys["integrate"] = ("method", "step", "representation", *options)
    keys["events"] = ("crossing", "speed", "first")
    return keys


def mutated_content(rng: Random, run: bool) -> Content_:
    """Return the content of a built-in scene after one to three mutations; `run`: of few steps."""
    found = originals()[rng.choice(sorted(originals()))]
    content = short(found) if run else copy.deepcopy(found)
    for _ in range(rng.choice((1, 1, 2, 3))):
        _mutate(rng, content)
    return content


def _mutate(rng: Random, content: Content_) -> None:
    sections = [name for name in content if isinstance(content[name], dict) and content[name]]
    if not sections or rng.random() < 0.05:
        content[rng.choice((*known_keys(), *hostile.STRINGS))] = hostile.plain(rng)
        return
    if rng.random() < 0.5:
        _scale(rng, content)
        return
    name = rng.choice(sections)
    section = content[name]
    key = rng.choice(sorted(section))
    what = rng.randrange(16)
    if what == 0:
        del section[key]
    elif what == 1:
        section[rng.choice(hostile.STRINGS)] = section.pop(key)
    elif what == 2:
        section[rng.choice(known_keys().get(name) or (key,))] = hostile.plain(rng)
    elif what == 3:
        other = rng.choice(known_keys().get(name) or (key,))
        section[other] = _likely(rng, other)
    elif what == 4:
        new = rng.choice([k for k in known_keys() if k not in ("title", "description")])
        other = rng.choice(known_keys()[new])
        if isinstance(content.setdefault(new, {}), dict):
            content[new][other] = _likely(rng, other)
    elif what == 5:
        section[key] = hostile.plain(rng)
    elif what == 6:
        section[key] = _likely(rng, key)
    else:
        section[key] = hostile.near(rng, section[key])


def _scale(rng: Random, content: Content_) -> None:
    """Multiply one of the numbers, or all of a list."""
    places: list[tuple[Any, Any]] = []
    for section in content.values():
        for key, value in section.items() if isinstance(section, dict) else ():
            places.append((section, key))
            if isinstance(value, list):
                places += [(value, i) for i in range(len(value))]
    holder, key = rng.choice(places)
    factor = rng.choice(
        (0.5, 1.1, 2.0, -1.0, 10.0 ** rng.randint(-6, 6), 10.0 ** rng.randint(-300, 300))
    )
    holder[key] = _times(holder[key], factor)


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_times(item, factor) for item in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    if isinstance(value, float):
        return value * factor
    return round(max(-1e30, min(max(-(10**30), min(value, 10**30)) * factor, 1e30)))


def _likely(rng: Random, key: str) -> Any:
    """Return a value that a key might have in some scene, and that may not fit this one."""
    names = {
        "name": lambda: list(systems()),
        "method": gi.method_names,
        "methods": lambda: [rng.choice(gi.method_names()), "gauss-4:0.1"],
        "representation": lambda: ["own", "ball", "classical", "reduced", "lr", "contact"],
        "crossing": _likely_events,
        "first": _likely_events,
        "what": lambda: ["gamma[0]", "p[1]", "omega[2]", "k[9]", "energy", "K"],
        "event": lambda: ["crossing", "gamma[0]", "energy", "first"],
        "direction": lambda: ["up", "down", "both", "left"],
        "axes": lambda: [["gamma[0]", "p[0]"], ["gamma[1]", "omega[0]"], ["energy"], ["K", "K"]],
        "keep": lambda: [["energy"], ["energy", "K"], ["nothing"]],
        "quantities": lambda: [["all"], ["measure"], ["energy"], ["constraints"], ["energy"] * 2],
    }
    if key in names:
        found = names[key]()
        return found if key == "methods" else rng.choice(found)
    counts = (
        "every", "repeats", "points", "motions", "seed", "max_iterations", "max_steps", "n", "r",
    )  # fmt: skip
    if key in counts:
        return rng.choice((1, 2, 3, 1000, 2**31, 2**53, 2**63, 10**30))
    if key == "iteration":
        return rng.choice(("auto", "fixed-point", "newton", "Newton", ""))
    if key in ("attitude", "multipliers", "fused", "terminal"):
        return rng.random() < 0.5
    if key in ("t_eval", "steps", "a", "gamma", "p", "k", "omega", "g", "moments", "J"):
        n = rng.choice((1, 2, 3, 4, 6, 9))
        row = [rng.choice((0.0, 0.1, 0.5, 1.0, 1e-9, 1e9, 1e308)) for _ in range(n)]
        return row if rng.random() < 0.8 else [row] * n
    return rng.choice((0.1, 0.01, 1.0, 2.0, -1.0, 1e-12, 1e-300, 1e300, 3))


def _likely_events() -> list[Content_]:
    """Return the tables that one of ``[events]`` might be."""
    return [
        {"what": "gamma[0]"},
        {"what": "gamma[1]", "direction": "up", "level": 0.2, "terminal": True},
        {"what": "energy", "level": 1e-300, "terminal": 2},
        {"what": "p[0]", "direction": "down", "level": -1e300},
        {"level": 0.5},
    ]


def toml_text(content: Content_) -> str:
    """Return content as TOML, every section that is a table as one."""
    lines, tables = [], []
    for key, value in content.items():
        if isinstance(value, dict):
            tables += [f"[{_key(key)}]", *(f"{_key(k)} = {_value(v)}" for k, v in value.items())]
        else:
            lines.append(f"{_key(key)} = {_value(value)}")
    return "\n".join([*lines, *tables, ""])


def _key(key: str) -> str:
    return json.dumps(key, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, hostile.Raw):
        return str(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _key(value)
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else ("inf" if value > 0 else "-inf")
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    return repr(value)


def mutated_text(rng: Random, run: bool = False) -> bytes:
    """Return a scene file: mutated content, and now and then mutated text."""
    text = toml_text(mutated_content(rng, run))
    for _ in range(rng.choice((0, 0, 0, 0, 0, 0, 0, 1, 2))):
        text = _spoiled(rng, text)
    data = text.encode("utf-8", "surrogatepass")
    if rng.random() < 0.02:
        at = rng.randint(0, len(data))
        data = data[:at] + bytes([rng.randrange(256)]) + data[at:]
    return data


def _spoiled(rng: Random, text: str) -> str:
    lines = text.split("\n")
    at, line = rng.randint(0, len(text)), rng.randrange(len(lines))
    found = (
        text[:at] + rng.choice(hostile.STRINGS[:27]) + text[at:],
        text[:at],
        "\n".join([*lines[:line], lines[line], *lines[line:]]),
        "\n".join(lines[:line] + lines[line + 1 :]),
        "\n".join(rng.sample(lines, len(lines))),
        text.replace("\n", "\r\n"),
        text + "a" + ".a" * rng.choice((10, 2000)) + " = 1\n",
    )
    return rng.choice(found)
