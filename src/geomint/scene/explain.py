"""Flaws of a scene, gathered; those that pydantic finds in words: key path, value, expectation."""

import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from ..errors import GeomintError, SceneError, nearest, quoted, raised, shortened
from .model import Content, Raw

LONGEST = 200  # characters of a key
_SECTIONS = Content.model_fields.keys() - {"title", "description"}
_TABLE = "a section of keys, below its name in single brackets"
_KINDS = {"float": "a number", "int": "a whole number", "str": "a string"}
_EXPECTED = {  # by types of errors
    "greater_than": "a number > {gt:g}",
    "greater_than_equal": "a number ≥ {ge:g}",
    "less_than_equal": "a number ≤ {le:g}",
    "int_from_float": "a whole number",
    "string_too_short": "a name",
    "too_short": "at least {min_length} of them",
    "too_long": "at most {max_length} of them",
    **{f"{kind}_{of}": said for kind, said in _KINDS.items() for of in ("type", "parsing")},
    **{
        "string_type": "a string",
        "list_type": 'a list, such as ["a", "b"]',
        "bool_type": "true or false",
    },
    **{"dict_type": _TABLE, "model_type": _TABLE},
}


class Flaws(list[str]):
    """What is wrong with a scene, a line each.

    Parameters
    ----------
    name : str
        Of the scene.
    places : mapping
        Where keys of sections were written, if not there: ``"[observe] every"`` ↦ ``"[drift] every"``.
    """

    def __init__(self, name: str, places: Mapping[str, str]) -> None:
        super().__init__()
        self.name, self.places = name, places

    def asked(self, where: str, function: Callable[..., Any], /, *given: Any, **keys: Any) -> Any:
        """Return what a function returns; None if it raises an error, which is a flaw."""
        try:
            return function(*given, **keys)
        except GeomintError as error:
            self.append(f"{where}{error}")

    def validated(self, model: type[BaseModel], given: Raw, *keys: str) -> Any:
        """Return what was given under some keys as a model; None if it is none, which is a flaw."""
        try:
            return model.model_validate(given)
        except ValidationError as error:
            self += _explained(error, model, keys, given)
        except Exception as error:  # of another package's own checks
            self.append(f"[{'.'.join(keys)}]: its checks failed, {raised(error)}")

    def end(self, cause: BaseException | None = None) -> None:
        """Raise the one error that says them all, each once and where it was written, if any."""
        told = (re.sub(r"^\[\w+\] \w+", lambda m: self.places.get(m[0], m[0]), x) for x in self)
        if lines := [*dict.fromkeys(told)]:
            head = f" has {len(lines)} problems:\n  " if len(lines) > 1 else ": "
            raise SceneError(f"scene {quoted(self.name)}{head}" + "\n  ".join(lines)) from cause


def _explained(
    error: ValidationError, model: type[BaseModel], prefix: tuple[str, ...], raw: Any
) -> Iterable[str]:
    """Return a line for each flaw: key, value, expectation, and what was probably meant."""
    lines: dict[str, str] = {}
    for location, entry in _nearest_branches(error, raw):
        place, kind, value = (*prefix, *location), entry["type"], entry["input"]
        key, fields = key_of(place), _fields_at(model, location[:-1])
        if kind == "extra_forbidden":
            line = no_such_key(place, value, fields)
        elif kind == "value_error":
            line = f"{key}: {entry['ctx']['error']}"
        elif kind == "missing":
            line = f"{key} is missing: expected {_described(fields, location[-1])}"
        else:
            known = _EXPECTED.get(kind, "").format(**entry.get("ctx", {}))
            expected = known or shortened(str(entry["msg"])).removeprefix("Input should be ")
            line = f"{key} = {quoted(value)}: expected {expected}"
        lines.setdefault(key, line)  # one of a key: others are of other branches of the same union
    return lines.values()


def no_such_key(at: tuple[Any, ...], value: Any, known: Iterable[str], nor: str = "") -> str:
    """Return what is said of a key that is not among the known ones."""
    return f"{key_of(at)} = {quoted(value)}: no such key{nor}.{nearest(str(at[-1]), known)}"


def _nearest_branches(error: ValidationError, raw: Any) -> list[tuple[tuple[Any, ...], Any]]:
    """Return where flaws are, without the names of branches of unions, and what pydantic says.

    Of the branches that a value failed it is that with the fewest flaws.
    """
    unions: dict[Any, dict[Any, list[Any]]] = {}
    for entry in error.errors(include_url=False):
        keys: tuple[Any, ...] = ()
        here, union = raw, None
        missing = len(entry["loc"]) - 1 if entry["type"] == "missing" else None
        for i, part in enumerate(entry["loc"]):
            inside = isinstance(here, Mapping) and (part in here or i == missing)
            if inside or isinstance(part, int):
                keys = (*keys, part)
                with suppress(KeyError, IndexError, TypeError):  # what is missing, or was converted
                    here = here[part]
            else:
                union = union or (keys, part)
        at, branch = union or (keys, None)
        unions.setdefault(at, {}).setdefault(branch, []).append((keys, entry))
    return [flaw for branches in unions.values() for flaw in min(branches.values(), key=len)]


def _fields_at(model: type[BaseModel], location: tuple[Any, ...]) -> dict[str, FieldInfo]:
    """Return the keys that the section at a location may have; none if there is no section."""
    for part in location:
        inner = getattr(model.model_fields.get(str(part)), "annotation", None)
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return {}
        model = inner
    return model.model_fields


def _described(fields: Mapping[str, FieldInfo], key: Any) -> str:
    """Return what is expected where a field is missing."""
    field = fields.get(str(key), FieldInfo())
    kinds = {"list": "a list of numbers", **_KINDS}
    said = (said for kind, said in kinds.items() if kind in str(field.annotation))
    return field.description or next(said, "a value")


def key_of(location: tuple[Any, ...]) -> str:
    """Return ``[time] t_end`` or ``[save] t_eval[2]``."""
    head, *rest = (part if isinstance(part, int) else _bare(part) for part in location)
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in rest)
    section = f"[{head}]" if rest or head in _SECTIONS else head
    return f"{section} {text.removeprefix('.')}".rstrip()


def _bare(key: Any) -> str:
    """Return a key as TOML has it: quoted where it is no plain word, and short."""
    text = str(key)
    plain = text.isascii() and text.replace("-", "").replace("_", "").isalnum()
    return shortened(text if plain else repr(text), LONGEST)
