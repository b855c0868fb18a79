"""The content of a scene before it is checked: made plain, merged, changed for another use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from ..errors import SceneError, quoted
from .explain import key_of, shown
from .model import DriftSection, IntegrateSection, ObserveSection

__all__ = ["Overrides", "drift_overrides", "merged", "plain"]

DEEPEST = 20  # lists and tables in one another: the deepest that has a meaning is 4
LARGEST_INTEGER = 10**300  # a float


@dataclass(frozen=True)
class Overrides:
    """What a use of a scene changes in it: the keys of several sections; None leaves one as it is.

    Options of the former method go with it, and so does its step, unless one is given. Options of
    quantities go with these.
    """

    method: Any = None
    step: Any = None
    representation: Any = None
    quantities: Any = None
    every: Any = None
    t_end: Any = None
    tau_end: Any = None

    @property
    def nothing(self) -> bool:
        """Whether all is left as it is."""
        return all(value is None for value in vars(self).values())

    def applied(self, raw: Mapping[str, Any]) -> dict[str, Any]:
        """Return the content with these changes."""
        changes = {"observe": self._observe(raw), "integrate": self._integrate(raw)}
        if self.t_end is not None or self.tau_end is not None:
            changes["time"] = {"t_end": self.t_end, "tau_end": self.tau_end}
        return merged(raw, plain({key: section for key, section in changes.items() if section}))

    def _observe(self, raw: Mapping[str, Any]) -> dict[str, Any]:
        changes = {} if self.every is None else {"every": self.every}
        if self.quantities is None:
            return changes
        names = list(self.quantities)
        section = raw.get("observe", {})
        options = [key for key in section if key not in ObserveSection.model_fields]
        gone = [] if "all" in names else [key for key in options if key not in names]
        gone += [] if names else ["every"]
        return {**dict.fromkeys(gone), **changes, "quantities": names}

    def _integrate(self, raw: Mapping[str, Any]) -> dict[str, Any]:
        section = raw.get("integrate", {})
        given = {"step": self.step, "representation": self.representation}
        changes = {key: value for key, value in given.items() if value is not None}
        fields = IntegrateSection.model_fields
        if self.method is None or not isinstance(section, Mapping):
            return changes
        if self.method == section.get("method", fields["method"].default):
            return changes
        gone = {key: None for key in section if key == "step" or key not in fields}
        return {**gone, "method": self.method, **changes}


def drift_overrides(raw: Mapping[str, Any]) -> Overrides:
    """Return what ``geomint drift`` changes in a scene: what its section ``[drift]`` says.

    Nothing if that makes no sense: the check of the whole reports it.
    """
    try:
        other = DriftSection.model_validate(raw.get("drift", {}))
    except ValidationError:
        return Overrides()
    return Overrides(
        method=other.method,
        step=other.step,
        quantities=other.quantities,
        every=other.every,
        t_end=other.t_end,
        tau_end=other.tau_end,
    )


def merged(raw: Mapping[str, Any], sections: Mapping[str, Any]) -> dict[str, Any]:
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
