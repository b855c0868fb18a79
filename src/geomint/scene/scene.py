"""`Scene`: the Python object that a scene file becomes, and that can be written as one."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Callable, Container, Iterable, Mapping
from functools import cached_property
from typing import Any

from ..errors import tell
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.problem import Problem
from ..problems.systems import Model, System
from ..run.events import Event
from .model import Content, Raw
from .raw import changes_for, merged, overridden, places_of, plain
from .validate import Checked, check_content


class Scene(Compared):
    """What is integrated, from where, for how long, with which method, and what is watched.

    Parameters
    ----------
    name : str
        For messages and reports.
    **sections
        As in a scene file: `title`, `description`, and mappings `system`, `initial`, `time`,
        `integrate`, `observe`, `save`, `events`, `drift`, `compare`, `section`, `ensemble`.
        Arrays are taken for lists.

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
        self._take(name, check_content(sections, name))
        self.warn()

    @classmethod
    def from_content(
        cls,
        name: str,
        content: Raw,
        text: str | None = None,
        former: Checked | None = None,
        places: Mapping[str, str] | None = None,
        system: System | None = None,
    ) -> Scene:
        """Return a scene from the content of a scene file, and its text if there is one.

        `former` is of a scene with the same system and initial state: its model is taken. `places`
        are where keys were written, if not there; `system` is one of one's own.
        """
        checked = check_content(content, name, former, places, system)
        return cls.__new__(cls)._take(name, checked, text)

    def _take(self, name: str, checked: Checked, text: str | None = None) -> Scene:
        self.name, self._checked, self._text = name, checked, text
        self.content, self.model = checked.content, checked.model
        self.method, self.notes = checked.method, tuple(map(str, checked.told))
        return self

    def __repr__(self) -> str:
        return f"<scene {self.name!r}: {self.content.system.name}, {self.method.name}>"

    def warn(self) -> None:
        """Issue the notes as warnings."""
        for w in self._checked.told:
            tell(type(w)(f"scene {self.name!r}: {w}", w.quantity, w.size, w.time))

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

    @property
    def system(self) -> System:
        """What the model is built by: registered, or one's own."""
        return self._checked.system

    def changed(self, name: str | None = None, **sections: Any) -> Scene:
        """Return a scene with some keys of some sections changed; None removes a key.

        ``scene.changed(time={"t_end": 5.0})`` also removes ``tau_end``: there is only one end.
        """
        former = None if {"system", "initial"} & sections.keys() else self._checked
        own = self.system
        given = plain(sections)
        changed = {
            f"[{section}] {key}"
            for section, keys in given.items()
            if isinstance(keys, dict)
            for key in keys
        }
        raw, places = merged(self._checked.raw, given), self._places_but(changed)
        return self.from_content(name or self.name, raw, None, former, places, own)

    def _overridden(self, written: Callable[[str], str] | None = None, **changes: Any) -> Scene:
        """Return the scene with changes that leave its model, which is not built again.

        `written` says where a user has given one of them, if not where scenes have it.
        """
        raw, former = overridden(self._checked.raw, **changes), self._checked
        if raw == former.raw:
            return self
        told = places_of(changes, written or str)
        places = {**self._places_but(told), **(told if written else {})}
        return self.from_content(self.name, raw, former=former, places=places)

    def _places_but(self, keys: Container[str]) -> dict[str, str]:
        return {key: place for key, place in self._checked.places.items() if key not in keys}

    def _compared(self) -> list[Any]:
        return [self.name, self._text, *self._checked._replace(places={})]

    def place(self, section: str, key: str) -> str:
        """Return where a key of the scene was written: ``"[observe] every"``, or elsewhere."""
        own = f"[{section}] {key}"
        return self._checked.places.get(own, own)

    def for_drift(self) -> Scene:
        """Return the scene as ``geomint drift`` runs it: changed by its ``[drift]`` section."""
        return self._overridden("[drift] {}".format, **changes_for("drift", self._checked.raw))

    @property
    def text(self) -> str | None:
        """The text of the file that it came from, if it did."""
        return self._text

    @property
    def checked(self) -> Checked:
        """What was found right, for scenes that differ from it by their use alone."""
        return self._checked

    def changed_integration(
        self,
        method: str | None = None,
        step: float | None = None,
        representation: str | None = None,
        tolerance: float | None = None,
        written: Callable[[str], str] | None = None,
    ) -> Scene:
        """Return a scene with another method, step, tolerance or representation.

        Options of the former method go; its step goes too, unless one is given. A step takes the place
        of a tolerance, and a tolerance that of a step. `written` says where a user has given one of
        these keys, if that is a place of its own.
        """
        return self._overridden(
            written, method=method, step=step, representation=representation, tolerance=tolerance
        )

    @property
    def events(self) -> dict[str, Event]:
        """The events of ``[events]``, by name."""
        return {name: Event(**dict(event)) for name, event in self.content.events.items()}

    def changed_observation(
        self, quantities: Iterable[str] | None = None, every: int | None = None
    ) -> Scene:
        """Return a scene that watches other quantities, or every so many steps.

        Options of quantities that are watched no longer go with them.
        """
        return self._overridden(quantities=quantities, every=every)

    @property
    def sections(self) -> dict[str, Any]:
        """What was given, as plain lists, strings and numbers: the content of the TOML file."""
        return copy.deepcopy(self._checked.raw)

    def toml(self) -> str:
        """Return the scene as the text of a scene file: the file's own, if it came from one."""
        if self._text is not None:
            return self._text
        import tomli_w

        return tomli_w.dumps(self._checked.raw, multiline_strings=True)

    @cached_property
    def hash(self) -> str:
        """A hash of everything that decides what is computed."""
        deciding = ["system", "initial", "time", "integrate", "observe", "save"]
        return self.hash_of(*deciding, *(["events"] if self.content.events else []))

    def hash_of(self, *sections: str) -> str:
        """Return a hash of some sections that does not depend on order, defaults or 1 for 1.0."""
        known = {"initial": self._checked.initial, "system": self._checked.parameters}
        content = self.content.model_dump()
        plain = {key: known[key].model_dump() if key in known else content[key] for key in sections}
        if "system" in plain:
            plain["system"] = {"name": self.content.system.name, **plain["system"]}
            if self.system.own:  # its name does not tell what it is
                from ..kernels.compiling.digest import digest

                plain["system"]["digest"] = digest((self.problem, self.state))
        text = json.dumps(_normal(plain), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def _normal(value: Any) -> Any:
    """Return `value` with all numbers as floats in hexadecimal, and without keys of None."""
    if isinstance(value, Mapping):
        return {key: _normal(item) for key, item in value.items() if item is not None}
    if isinstance(value, list):
        return [_normal(item) for item in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value).hex()
    return value
