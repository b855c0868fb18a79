"""The content of a scene before it is checked: made plain, merged, changed for another use."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..errors import SceneError, quoted
from .explain import key_of, shown
from .model import DriftSection, IntegrateSection, ObserveSection, Raw

DEEPEST = 20  # lists and tables in one another: the deepest that has a meaning is 4
LARGEST_INTEGER = 10**300  # a float
CHANGED = {  # what `overridden` changes, by sections
    "observe": ("quantities", "every"),
    "integrate": ("method", "step", "tolerance", "representation"),
    "time": ("t_end", "tau_end"),
}


def overridden(raw: Raw, **given: Any) -> dict[str, Any]:
    """Return the content with some of the keys in `CHANGED` changed; None leaves one as it is.

    Options of the former method go with it, and so does its step, unless one is given. A step takes
    the place of a tolerance, and this of a step. Options of quantities go with these.
    """
    method, quantities = given.get("method"), given.get("quantities")
    changes = {
        section: {
            key: given[key]
            for key in keys
            if key not in ("method", "quantities") and given.get(key) is not None
        }
        for section, keys in CHANGED.items()
    }
    tables = {key: value for key, value in raw.items() if isinstance(value, Mapping)}
    if quantities is not None:
        names, fields = list(quantities), ObserveSection.model_fields
        options = [key for key in tables.get("observe", ()) if key not in fields]
        gone = [] if "all" in names else [key for key in options if key not in names]
        gone += [] if names else ["every"]
        changes["observe"] = {**dict.fromkeys(gone), **changes["observe"], "quantities": names}
    former, fields = tables.get("integrate", {}), IntegrateSection.model_fields
    if method not in (None, former.get("method", fields["method"].default)):
        old = dict.fromkeys(key for key in former if key == "step" or key not in fields)
        changes["integrate"] = {**old, "method": method, **changes["integrate"]}
    if (given.get("step") is None) != (given.get("tolerance") is None):
        other = "tolerance" if given.get("tolerance") is None else "step"
        changes["integrate"] = {other: None, **changes["integrate"]}
    return merged(raw, plain({section: keys for section, keys in changes.items() if keys}))


def drift_changes(raw: Raw) -> dict[str, Any]:
    """Return what ``geomint drift`` changes in a scene, as `overridden` takes it.

    Its section ``[drift]``; nothing if that makes no sense: the check of the whole reports it.
    """
    try:
        return DriftSection.model_validate(raw.get("drift", {})).model_dump(exclude={"methods"})
    except ValidationError:
        return {}


def in_drift(key: str) -> str:
    """Return where a scene states what `drift_changes` changes."""
    return f"[drift] {key}"


def places_of(changes: Raw, written: Callable[[str], str]) -> dict[str, str]:
    """Return where what `overridden` changes was written, by the keys that scenes have it under.

    ``"[observe] every"`` ↦ ``"[drift] every"``, with what `written` makes of ``"every"``.
    """
    return {
        f"[{section}] {key}": written(key)
        for section, keys in CHANGED.items()
        for key in keys
        if changes.get(key) is not None
    }


def merged(raw: Raw, sections: Raw) -> dict[str, Any]:
    """Return the content with some keys of some sections changed; None removes a key.

    An end takes the place of the other one: there is only one.
    """
    result = {key: dict(v) if isinstance(v, Mapping) else v for key, v in raw.items()}
    for key, changes in sections.items():
        section = result.get(key, {})
        if not isinstance(changes, Mapping) or not isinstance(section, Mapping):
            result[key] = changes if not isinstance(changes, Mapping) else section
            continue
        if {"t_end", "tau_end"} & {k for k, v in changes.items() if v is not None}:
            section = {k: v for k, v in section.items() if k not in ("t_end", "tau_end")}
        result[key] = {k: v for k, v in {**section, **changes}.items() if v is not None}
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
    if isinstance(value, np.ma.MaskedArray) and np.ma.getmaskarray(value).any():
        raise SceneError(f"{key_of(where)} = {shown(value)}: expected numbers, none of them masked")
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item, *where, i) for i, item in enumerate(value)]
    if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
        expected = "a number below 10³⁰⁰"
        raise SceneError(f"{key_of(where)} = {quoted(value)}: expected {expected}")
    return value
