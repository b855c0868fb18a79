"""The content of a scene before it is checked: made plain, merged, changed for another use."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..errors import SceneError, quoted
from .explain import key_of
from .model import CompareSection, DriftSection, IntegrateSection, ObserveSection, Raw, Section

DEEPEST = 20  # lists and tables in one another: the deepest that has a meaning is 4
LARGEST_INTEGER = 10**300  # a float
ENDS = ("t_end", "tau_end")
CHANGED = {  # what `overridden` changes, and in which section
    **dict.fromkeys(("quantities", "every"), "observe"),
    **dict.fromkeys(("method", "step", "tolerance", "representation"), "integrate"),
    **dict.fromkeys(ENDS, "time"),
}


def overridden(raw: Raw, **given: Any) -> dict[str, Any]:
    """Return the content with some of the keys in `CHANGED` changed; None leaves one as it is.

    Options of the former method go with it, and so does its step, unless one is given. A step takes
    the place of a tolerance, and this of a step. Options of quantities go with these.
    """
    given = {key: value for key, value in given.items() if value is not None}
    changes = {s: {k: v for k, v in given.items() if CHANGED[k] == s} for s in CHANGED.values()}
    tables = {key: value for key, value in raw.items() if isinstance(value, Mapping)}
    if "quantities" in given:
        names = changes["observe"]["quantities"] = list(given["quantities"])
        kept = {*ObserveSection.model_fields, *names} - (set() if names else {"every"})
        gone = [key for key in tables.get("observe", ()) if "all" not in names and key not in kept]
        changes["observe"] = {**dict.fromkeys(gone), **changes["observe"]}
    former, fields = tables.get("integrate", {}), IntegrateSection.model_fields
    named = former.get("method", fields["method"].default)
    if given.get("method", named) != named:
        gone = [key for key in former if key == "step" or key not in fields]
        changes["integrate"] = {**dict.fromkeys(gone), **changes["integrate"]}
    for key, other in (("step", "tolerance"), ("tolerance", "step")):
        if key in given:
            changes["integrate"].setdefault(other, None)
    return merged(raw, plain({section: keys for section, keys in changes.items() if keys}))


def changes_for(use: str, raw: Raw) -> dict[str, Any]:
    """Return what a use of a scene changes in it, as `overridden` takes it: by a section of its own.

    Nothing if that makes no sense: the check of the whole reports it.
    """
    known: dict[str, type[Section]] = {"drift": DriftSection, "compare": CompareSection}
    try:
        section = known.get(use, Section).model_validate(raw.get(use, {}))
    except ValidationError:
        return {}
    return section.model_dump(include={*CHANGED})


def without_changed(raw: Raw, use: str, given: Raw) -> Raw:
    """Return the content without what its section of a use says of keys that are given otherwise."""
    gone = {key for key, value in given.items() if value is not None}
    if gone & {*ENDS}:
        gone |= {*ENDS}
    if gone & {"method", "step", "tolerance"}:
        gone |= {"step", "tolerance"}
    own = raw.get(use)
    if not isinstance(own, Mapping) or not gone & own.keys():
        return raw
    return {**raw, use: {key: value for key, value in own.items() if key not in gone}}


def places_of(changes: Raw, written: Callable[[str], str]) -> dict[str, str]:
    """Return where what `overridden` changes was written, by the keys that scenes have it under.

    ``"[observe] every"`` ↦ ``"[drift] every"``, with what `written` makes of ``"every"``.
    """
    given = [key for key in CHANGED if changes.get(key) is not None]
    return {f"[{CHANGED[key]}] {key}": written(key) for key in given}


def merged(raw: Raw, sections: Raw) -> dict[str, Any]:
    """Return the content with some keys of some sections changed; None removes a key.

    An end takes the place of the other one: there is only one.
    """
    result = {key: dict(v) if isinstance(v, Mapping) else v for key, v in raw.items()}
    for key, changes in sections.items():
        section = result.get(key, {})
        if not isinstance(changes, Mapping):
            result[key] = changes
        elif isinstance(section, Mapping):
            ended = any(changes.get(end) is not None for end in ENDS)
            changed = {**section, **(dict.fromkeys(ENDS) if ended else {}), **changes}
            result[key] = {k: v for k, v in changed.items() if v is not None}
    return result


def plain(value: Any, *where: Any) -> Any:
    """Return `value` with tuples and arrays as lists and numpy's numbers as Python's.

    `where` are the keys that led to it. What no scene can hold is a `SceneError`.
    """
    if len(where) > DEEPEST:
        expected = f"lists and tables that are nested at most {DEEPEST} deep"
        raise SceneError(f"{key_of(where[:2])}: expected {expected}")
    if isinstance(value, Mapping):
        keys = {key if isinstance(key, str) else quoted(key): key for key in value}
        return {name: plain(value[key], *where, name) for name, key in keys.items()}
    if isinstance(value, list | tuple):
        return [plain(item, *where, i) for i, item in enumerate(value)]
    masked = isinstance(value, np.ma.MaskedArray) and np.ma.getmaskarray(value).any()
    if masked or (isinstance(value, int) and abs(value) > LARGEST_INTEGER):
        expected = "numbers, none of them masked" if masked else "a number below 10³⁰⁰"
        raise SceneError(f"{key_of(where)} = {quoted(value)}: expected {expected}")
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
