"""`Scene`: the Python object that a scene file becomes, and that can be written as one."""

from __future__ import annotations

import copy
import hashlib
import json
import warnings
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import GeomintWarning, SceneError, quoted
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.problem import Problem
from ..problems.systems import Model
from ..watch.observe import MEASURE
from .explain import key_of, shown
from .model import Content
from .validate import check_content

__all__ = ["Scene"]

DEEPEST = 20  # lists and tables in one another: the deepest that has a meaning is 4
LARGEST_INTEGER = 10**300  # a float


class Scene(Compared):
    """What is integrated, from where, for how long, with which method, and what is watched.

    Parameters
    ----------
    name : str
        For messages and reports.
    **sections
        As in a scene file: `title`, `description`, and mappings `system`, `initial`, `time`,
        `integrate`, `observe`, `save`, `drift`, `compare`. Arrays are taken for lists.

    Attributes
    ----------
    content : pydantic model
        The checked sections, such as ``scene.content.time.t_end``.
    model : Model
        The system in all its representations, with its initial state.
    method : Method
        With the options of ``[integrate]``.
    notes : tuple of str
        What was changed to make the initial state admissible, such as a projection.

    Raises
    ------
    SceneError
        One message for everything that is wrong.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.Scene(
    ...     system={"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    ...     initial={"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
    ...     time={"t_end": 100.0},
    ... )
    >>> scene.method.name
    'gauss-8'
    """

    content: Content
    model: Model
    method: Method
    notes: tuple[str, ...]

    def __init__(self, name: str = "scene", **sections: Any) -> None:
        self._check(name, sections)
        self.warn()

    @classmethod
    def from_content(cls, name: str, content: Mapping[str, Any], text: str | None = None) -> Scene:
        """Return a scene from the content of a scene file, and its text if there is one."""
        scene = cls.__new__(cls)
        scene._check(name, content)
        scene._text = text
        return scene

    def _check(self, name: str, content: Mapping[str, Any]) -> None:
        self.name = name
        self._text: str | None = None
        try:
            self._raw: dict[str, Any] = _plain(content)
        except SceneError as error:
            raise SceneError(f"scene {quoted(name)}: {error}") from None
        self._checked = check_content(self._raw, name)
        self.content, self.model = self._checked.content, self._checked.model
        self.method, self.notes = self._checked.method, self._checked.notes

    def __repr__(self) -> str:
        return f"<scene {self.name!r}: {self.content.system.name}, {self.method.name}>"

    def warn(self) -> None:
        """Issue the notes as warnings."""
        for note in self.notes:
            warnings.warn(f"scene {self.name!r}: {note}", GeomintWarning, stacklevel=3)

    @property
    def title(self) -> str:
        """The title, or else the name."""
        return self.content.title or self.name

    @property
    def problem(self) -> Problem:
        """The representation that the scene means: the first of the model."""
        return next(iter(self.model.problems.values()))

    @property
    def state(self) -> Any:
        """The initial state of `problem`."""
        return self.model.states[next(iter(self.model.problems))]

    def changed(self, name: str | None = None, **sections: Any) -> Scene:
        """Return a scene with some keys of some sections changed; None removes a key.

        ``scene.changed(time={"t_end": 5.0})`` also removes ``tau_end``: there is only one end.
        """
        raw = {key: dict(v) if isinstance(v, Mapping) else v for key, v in self._raw.items()}
        for key, value in _plain(sections).items():
            if not isinstance(value, Mapping):
                raw[key] = value
                continue
            section = raw.setdefault(key, {})
            if {"t_end", "tau_end"} & {k for k, v in value.items() if v is not None}:
                section = {k: v for k, v in section.items() if k not in ("t_end", "tau_end")}
            section = {**section, **value}
            raw[key] = {k: v for k, v in section.items() if v is not None}
        return Scene.from_content(name or self.name, raw)

    def for_drift(self) -> Scene:
        """Return the scene as ``geomint drift`` runs it: changed by its ``[drift]`` section."""
        other = self.content.drift
        scene = self._with_end(other.t_end, other.tau_end)
        return scene.changed_observation(other.quantities, other.every).changed_integration(
            other.method, other.step
        )

    def for_compare(self) -> Scene:
        """Return the scene with the end that its ``[compare]`` section may state."""
        return self._with_end(self.content.compare.t_end, self.content.compare.tau_end)

    def _with_end(self, t_end: float | None, tau_end: float | None) -> Scene:
        if t_end is None and tau_end is None:
            return self
        return self.changed(time={"t_end": t_end, "tau_end": tau_end})

    def changed_integration(
        self,
        method: str | None = None,
        step: float | None = None,
        representation: str | None = None,
    ) -> Scene:
        """Return a scene with another method, step or representation.

        Options of the former method go; its step goes too, unless one is given.
        """
        scene = self
        if method is not None and method != self.content.integrate.method:
            gone = dict.fromkeys((*self.content.integrate.options, "step"))
            scene = scene.changed(integrate={**gone, "method": method})
        changes = {"step": step, "representation": representation}
        given = {key: value for key, value in changes.items() if value is not None}
        return scene.changed(integrate=given) if given else scene

    def changed_observation(
        self, quantities: Iterable[str] | None = None, every: int | None = None
    ) -> Scene:
        """Return a scene that watches other quantities, or every so many steps.

        What was said of quantities that are watched no longer goes: `measure_steps` with the measure.
        """
        changes: dict[str, Any] = {} if every is None else {"every": every}
        if quantities is not None:
            names = list(quantities)
            gone = [] if {MEASURE, "all"} & set(names) else ["measure_steps"]
            gone += [] if names else ["every"]
            changes = {**dict.fromkeys(gone), **changes, "quantities": names}
        return self.changed(observe=changes) if changes else self

    @property
    def sections(self) -> dict[str, Any]:
        """What was given, as plain lists, strings and numbers: the content of the TOML file."""
        return copy.deepcopy(self._raw)

    def toml(self) -> str:
        """Return the scene as the text of a scene file: the file's own, if it came from one."""
        if self._text is not None:
            return self._text
        import tomli_w

        return tomli_w.dumps(self._raw, multiline_strings=True)

    @cached_property
    def hash(self) -> str:
        """A hash of everything that decides what is computed."""
        return self.hash_of("system", "initial", "time", "integrate", "observe", "save")

    def hash_of(self, *sections: str) -> str:
        """Return a hash of some sections that does not depend on order, defaults or 1 for 1.0."""
        models = {key: getattr(self.content, key) for key in sections}
        if "initial" in models:
            models["initial"] = self._checked.initial
        plain = {key: model.model_dump() for key, model in models.items()}
        if "system" in plain:
            parameters = self._checked.parameters.model_dump()
            plain["system"] = {"name": self.content.system.name, **parameters}
        text = json.dumps(_normal(plain), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: Any, *where: Any) -> Any:
    """Return `value` with tuples and arrays as lists and numpy's numbers as Python's.

    `where` are the keys that led to it. What no scene can hold is a `SceneError`.
    """
    if len(where) > DEEPEST:
        expected = f"lists and tables that are nested at most {DEEPEST} deep"
        raise SceneError(f"{key_of(where[:2])}: expected {expected}")
    if isinstance(value, Mapping):
        keys = {key if isinstance(key, str) else quoted(key): key for key in value}
        return {name: _plain(value[key], *where, name) for name, key in keys.items()}
    if isinstance(value, np.ma.MaskedArray) and np.ma.getmaskarray(value).any():
        raise SceneError(f"{key_of(where)} = {shown(value)}: expected numbers, none of them masked")
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(item, *where, i) for i, item in enumerate(value)]
    if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
        expected = "a number below 10³⁰⁰"
        raise SceneError(f"{key_of(where)} = {quoted(value)}: expected {expected}")
    return value


def _normal(value: Any) -> Any:
    """Return `value` with all numbers as floats in hexadecimal, and without keys of None."""
    if isinstance(value, Mapping):
        return {key: _normal(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [_normal(item) for item in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value).hex()
    return value
