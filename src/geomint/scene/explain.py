"""Flaws that pydantic finds, in words: key path, value, expectation, and what was meant."""

import reprlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from ..errors import nearest, quoted, shortened
from .model import Content

_MISSING = object()
LONGEST = 200  # characters of a key or a value
_OBJECTS = reprlib.Repr()
_OBJECTS.maxlist = _OBJECTS.maxdict = 8
_OBJECTS.maxstring = _OBJECTS.maxother = 80


def explained(
    error: ValidationError, model: type[BaseModel], prefix: tuple[str, ...], raw: Any
) -> Iterator[str]:
    """Yield a line for each flaw: key, value, expectation, and what was probably meant."""
    words = set()
    for entry in _nearest_branches(error.errors(include_url=False), raw):
        location = _without_branches(entry["loc"], raw)
        key = key_of((*prefix, *location))
        value = _at(raw, location)
        if entry["type"] == "extra_forbidden":
            fields = _fields_at(model, location[:-1])
            line = f"{key} = {shown(value)}: no such key.{nearest(str(location[-1]), fields)}"
        elif entry["type"] == "missing":
            line = f"{key} is missing: expected {_described(model, location)}"
        elif entry["type"] == "value_error":
            line = f"{key}: {entry['ctx']['error']}"
        else:
            line = f"{key} = {shown(value)}: expected {_expected(entry)}"
        if key in words:
            continue  # another branch of the same union
        words.add(key)
        yield line


_SECTIONS = Content.model_fields.keys() - {"title", "description"}
_EXPECTED = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "a string",
    "string_too_short": "a name",
    "list_type": "a list",
    "dict_type": "a section of keys, below its name in single brackets",
    "model_type": "a section of keys, below its name in single brackets",
    "model_attributes_type": "a section of keys, below its name in single brackets",
    "bool_type": "true or false",
    "finite_number": "a finite number",
}


def _expected(entry: Any) -> str:
    kind, context = entry["type"], entry.get("ctx", {})
    if kind == "greater_than":
        return f"a number > {context['gt']:g}"
    if kind == "greater_than_equal":
        return f"a number ≥ {context['ge']:g}"
    if kind == "less_than_equal":
        return f"a number ≤ {context['le']:g}"
    message = shortened(str(entry["msg"]))
    return _EXPECTED.get(kind, message.removeprefix("Input should be "))


def _without_branches(location: tuple[Any, ...], raw: Any) -> tuple[Any, ...]:
    """Drop the names of union branches, which are no keys of the content."""
    kept: list[Any] = []
    for i, part in enumerate(location):
        here = _at(raw, tuple(kept))
        is_key = isinstance(here, Mapping) and (part in here or i == len(location) - 1)
        if is_key or isinstance(part, int) or here is raw:
            kept.append(part)
    return tuple(kept)


def _nearest_branches(entries: Iterable[Any], raw: Any) -> list[Any]:
    """Keep, of the branches of a union that a value failed, the one with the fewest flaws."""
    flaws: dict[tuple[Any, ...], dict[Any, list[Any]]] = {}
    for entry in entries:
        location = entry["loc"]
        kept = _without_branches(location, raw)
        at = next(
            (i for i, (a, b) in enumerate(zip(location, kept, strict=False)) if a != b), len(kept)
        )
        branch = location[at] if at < len(location) else None
        flaws.setdefault(location[:at], {}).setdefault(branch, []).append(entry)
    nearest_ones = [min(branches.values(), key=len) for branches in flaws.values()]
    return [entry for branch in nearest_ones for entry in branch]


def _at(raw: Any, location: tuple[Any, ...]) -> Any:
    for part in location:
        try:
            raw = raw[part]
        except (KeyError, IndexError, TypeError):
            return _MISSING
    return raw


def key_of(location: tuple[Any, ...]) -> str:
    """Return ``[time] t_end`` or ``[save] t_eval[2]``."""
    head, *rest = location
    text = "".join(f"[{p}]" if isinstance(p, int) else f".{_bare(p)}" for p in rest)
    if rest:
        return f"[{_bare(head)}] {text.removeprefix('.')}"
    return f"[{head}]" if head in _SECTIONS else _bare(head)


def _bare(key: Any) -> str:
    """Return a key as TOML has it: quoted where it is no plain word, and short."""
    text = str(key)
    plain = text.isascii() and text.replace("-", "").replace("_", "").isalnum()
    return shortened(text, LONGEST) if plain else shortened(repr(text), LONGEST)


def _fields_at(model: type[BaseModel], location: tuple[Any, ...]) -> dict[str, FieldInfo]:
    """Return the keys that the section at a location may have; none if there is no section."""
    fields = model.model_fields
    for part in location:
        found = fields.get(str(part))
        inner = None if found is None else found.annotation
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return {}
        fields = inner.model_fields
    return fields


def _described(model: type[BaseModel], location: tuple[Any, ...]) -> str:
    found = _fields_at(model, location[:-1]).get(str(location[-1]))
    if found is None:
        return "a value"
    if found.description:
        return found.description
    kind = found.annotation
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return "this section"
    if "list" in str(kind):
        return "a list of numbers"
    return {float: "a number", int: "a whole number", str: "a string"}.get(kind, "a value")  # type: ignore[arg-type]


def shown(value: Any) -> str:
    """Return a value as messages show it: short."""
    try:
        return shortened(_OBJECTS.repr(value), LONGEST)
    except Exception:  # integers too long to print, objects without a text
        return quoted(value)
