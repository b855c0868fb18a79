"""From raw content to a checked scene, or one `SceneError` that lists everything wrong with it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel, ValidationError

from ..errors import (
    DomainError,
    GeomintError,
    GeomintWarning,
    MethodError,
    SceneError,
    nearest,
    quoted,
    shortened,
)
from ..methods.method import Method
from ..methods.registry import find_method
from ..problems.systems import Model, System, find_system
from ..watch.observe import choose_watchers
from ..watch.quantities import GROUPS, expanded, quantities_of
from ..watch.registry import plugged
from .entries import check_once, method_and_step
from .explain import explained, key_of, shown
from .model import Content, ObserveSection

__all__ = ["Checked", "check_content"]

OWN = ("step", "representation", "exact")  # of [integrate], beside the method and its options


class Checked(NamedTuple):
    """Content that was found right, with what was built from it."""

    content: Content
    parameters: BaseModel
    initial: BaseModel
    model: Model
    method: Method
    notes: tuple[str, ...]


def check_content(raw: Mapping[str, Any], name: str, former: Checked | None = None) -> Checked:
    """Return the checked content, or raise a `SceneError` with one line for every flaw.

    `former` is of a scene with the same system and initial state, whose model is taken.
    """
    content, flaws = _structure(raw)
    system, more = _system(raw)
    flaws += more
    method, more = _method(raw, content)
    flaws += [*more, *_observe_keys(raw)]
    if content is None or system is None or method is None or flaws:
        raise _error(name, flaws)
    parameters = system.parameters.model_validate(_parameters(content))
    initial = system.initial.model_validate(content.initial)
    try:
        model, notes = _build(system, parameters, initial, former)
    except DomainError as error:
        raise _error(name, [f"{_section_of(error.name, content)} {error}"]) from error
    except GeomintError as error:
        raise _error(name, [f"[system] or [initial]: {error}"]) from error
    except (ArithmeticError, MemoryError, np.linalg.LinAlgError) as error:
        expected = "numbers whose products are finite, and of which there are not too many"
        said_by = f"{type(error).__name__}: {shortened(str(error))}"
        flaw = f"[system] or [initial]: expected {expected} ({said_by})"
        raise _error(name, [flaw]) from error
    flaws = [
        *_representation(model, content),
        *_quantities(model, content),
        *_observation(model, content),
        *_ends(model, content),
    ]
    if flaws:
        raise _error(name, flaws)
    return Checked(content, parameters, initial, model, method, notes)


def _error(name: str, flaws: list[str]) -> SceneError:
    if len(flaws) == 1:
        return SceneError(f"scene {quoted(name)}: {flaws[0]}")
    lines = "".join(f"\n  {flaw}" for flaw in flaws)
    return SceneError(f"scene {quoted(name)} has {len(flaws)} problems:{lines}")


def _structure(raw: Mapping[str, Any]) -> tuple[Content | None, list[str]]:
    try:
        return Content.model_validate(dict(raw)), []
    except ValidationError as error:
        return None, list(explained(error, Content, (), raw))


def _section(raw: Mapping[str, Any], name: str) -> dict[str, Any]:
    section = raw.get(name, {})
    return dict(section) if isinstance(section, Mapping) else {}


def _system(raw: Mapping[str, Any]) -> tuple[System | None, list[str]]:
    """Check the name, the parameters and the keys of the initial state."""
    parameters = _section(raw, "system")
    name = parameters.pop("name", None)
    if not isinstance(name, str) or not name:
        return None, []  # the structure has reported it
    try:
        system = find_system(name)
    except SceneError as error:
        return None, [str(error)]
    flaws: list[str] = []
    initial = _section(raw, "initial")
    for key, model, given in (
        ("system", system.parameters, parameters),
        ("initial", system.initial, initial),
    ):
        try:
            model.model_validate(given)
        except ValidationError as error:
            flaws += explained(error, model, (key,), given)
    return system, flaws


def _method(raw: Mapping[str, Any], content: Content | None) -> tuple[Method | None, list[str]]:
    section = _section(raw, "integrate")
    name = section.pop("method", "gauss-8")
    for key in OWN:
        section.pop(key, None)
    if not isinstance(name, str) or not name:
        return None, []
    flaws = list(_other_methods(content)) if content is not None else []
    try:
        method = find_method(name)
    except (MethodError, DomainError) as error:
        return None, [f"[integrate] {error}", *flaws]
    for key in section:
        if key not in method.options:
            known = ["method", *OWN, *method.options]
            flaws.append(
                f"[integrate] {key} = {shown(section[key])}: no such key, nor an option of "
                f"{name!r}.{nearest(key, known)}"
            )
    if flaws:
        return None, flaws
    try:
        return method.with_options(**section), []
    except DomainError as error:
        return None, [f"[integrate] {error}"]


def _other_methods(content: Content) -> Iterator[str]:
    named = [("[drift] ", [content.drift.method or "gauss-8"])]
    named.append(("[compare] methods: ", content.compare.methods or []))
    for where, names in named:
        for name in names:
            try:
                find_method(name)
            except (MethodError, DomainError) as error:
                yield f"{where}{error}"
    found = []
    for entry in content.drift.methods or []:
        try:
            found.append(method_and_step(entry))
        except (MethodError, DomainError) as error:
            yield f"[drift] methods: {error}"
    try:
        check_once(found)
    except DomainError as error:
        yield f"[drift] {error}"


def _parameters(content: Content) -> dict[str, Any]:
    return dict(content.system.__pydantic_extra__ or {})


def _section_of(name: str, content: Content) -> str:
    key = name.split("[")[0]
    if key in _parameters(content):
        return "[system]"
    return "[initial]" if key in content.initial else "[system] or [initial]:"


def _build(
    system: System, parameters: Any, initial: Any, former: Checked | None
) -> tuple[Model, tuple[str, ...]]:
    """Return the model, and what the system had to change to make the initial state admissible."""
    if former is not None:
        return former.model, former.notes
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GeomintWarning)
        model = system.build(parameters, initial)
    notes = []
    for warning in caught:
        if issubclass(warning.category, GeomintWarning):
            notes.append(str(warning.message))
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
    return model, tuple(dict.fromkeys(notes))


def _representation(model: Model, content: Content) -> Iterator[str]:
    name, known = content.integrate.representation, ["own", *model.problems]
    if name is not None and name not in known:
        yield (
            f"[integrate] representation = {quoted(name)}: no such representation of "
            f"{content.system.name!r} from this initial state.{nearest(name, known)}"
        )


def _quantities(model: Model, content: Content) -> Iterator[str]:
    """Any representation may have what is observed: the planner finds the one that does."""
    names = [name for problem in model.problems.values() for name in quantities_of(problem)]
    known = [*dict.fromkeys(names), *GROUPS, *plugged()]
    for section, quantities in (
        ("observe", content.observe.quantities),
        ("drift", content.drift.quantities or []),
    ):
        for i, name in enumerate(quantities):
            where = f"[{section}] quantities[{i}] = {quoted(name)}"
            if name not in known:
                yield f"{where}: no such quantity.{nearest(name, known)}"
            elif name in plugged() and name not in names:
                yield from _plugged(where, model, name)


def _plugged(where: str, model: Model, name: str) -> Iterator[str]:
    """Yield what keeps the watcher of another package from every representation."""
    obstacles = []
    for problem in model.problems.values():
        try:
            choose_watchers(problem, [name])
        except GeomintError as error:
            obstacles.append(str(error))
        else:
            return
    yield f"{where}: {obstacles[0]}"


def _observe_keys(raw: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of ``[observe]`` that are none, and no tables of options."""
    known = list(ObserveSection.model_fields)
    for key, value in _section(raw, "observe").items():
        if key not in known and not isinstance(value, Mapping):
            where = f"{key_of(('observe', key))} = {shown(value)}"
            yield f"{where}: no such key.{nearest(str(key), known)}"


def _observation(model: Model, content: Content) -> Iterator[str]:
    """Yield what is said of quantities that are not observed."""
    observe, others = content.observe, content.drift.quantities
    names = {*observe.quantities, *(others or [])}
    if not names:
        for section in ("observe", "drift"):
            if (getattr(content, section).every or 1) != 1:
                every = getattr(content, section).every
                yield f"[{section}] every = {every!r}: nothing is observed: quantities is empty"
    for name, options in observe.options.items():
        where = f"{key_of(('observe', name))} = {shown(options)}"
        having = [p for p in model.problems.values() if name in expanded(p, names)]
        if not having:
            yield f"{where}: {quoted(name)} is observed neither in [observe] nor in [drift]"
            continue
        try:
            choose_watchers(having[0], {name: options})
        except GeomintError as error:
            yield f"[observe.{name}] {error}"


def _ends(model: Model, content: Content) -> Iterator[str]:
    problem = next(iter(model.problems.values()))
    if problem.time == "tau":
        return
    for name in ("time", "drift", "compare"):
        tau_end = getattr(content, name).tau_end
        if tau_end is not None:
            yield (
                f"[{name}] tau_end = {tau_end!r}: expected t_end: "
                f"{content.system.name!r} is in physical time"
            )
