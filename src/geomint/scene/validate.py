"""From raw content to a checked scene, or one `SceneError` that lists everything wrong with it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
from pydantic import BaseModel, ValidationError

from ..errors import (
    DomainError,
    GeomintError,
    GeomintWarning,
    SceneError,
    nearest,
    quoted,
    shortened,
)
from ..methods.gauss import Gauss
from ..methods.method import Method
from ..methods.registry import find_method
from ..problems.systems import Model, System, find_system, in_time
from ..run.accuracy.auto import AUTO, auto_method
from ..watch.observe import choose_watchers
from ..watch.quantities import GROUPS, expanded, quantities_of
from ..watch.registry import plugged
from .entries import check_once, method_and_step
from .explain import explained, key_of, shown
from .model import Content, IntegrateSection, ObserveSection
from .raw import plain

__all__ = ["Checked", "check_content"]

T = TypeVar("T")
Section = TypeVar("Section", bound=BaseModel)
_CHOSEN_LATER = Gauss()  # what method "auto" is checked as, until the problem is built
_UNBUILT = (GeomintError, ArithmeticError, MemoryError, np.linalg.LinAlgError)


class Checked(NamedTuple):
    """Content that was found right, as it was given and checked, with what was built from it."""

    raw: dict[str, Any]
    content: Content
    parameters: BaseModel
    initial: BaseModel
    built: Model
    model: Model
    method: Method
    notes: tuple[str, ...]


class _Flaws(list[str]):
    """What is wrong with a scene, a line each."""

    def validated(
        self, model: type[Section], given: Mapping[str, Any], *keys: str
    ) -> Section | None:
        """Return what was given under some keys as a model; None if it is none, which is a flaw."""
        try:
            return model.model_validate(given)
        except ValidationError as error:
            self += explained(error, model, keys, given)
            return None

    def asked(self, where: str, function: Callable[..., T], *given: Any) -> T | None:
        """Return what a function returns; None if it raises an error, which is a flaw."""
        try:
            return function(*given)
        except GeomintError as error:
            self.append(f"{where}{error}")
            return None

    def error(self, name: str) -> SceneError:
        """Return the one error that says them all."""
        if len(self) == 1:
            return SceneError(f"scene {quoted(name)}: {self[0]}")
        lines = "".join(f"\n  {flaw}" for flaw in self)
        return SceneError(f"scene {quoted(name)} has {len(self)} problems:{lines}")


def check_content(given: Mapping[str, Any], name: str, former: Checked | None = None) -> Checked:
    """Return the checked content, or raise a `SceneError` with one line for every flaw.

    `former` is of a scene with the same system and initial state, whose model is taken.
    """
    flaws = _Flaws()
    raw = flaws.asked("", plain, given)
    if raw is None:
        raise flaws.error(name)
    content = flaws.validated(Content, raw)
    # The keys of systems and methods are looked at even if the structure is wrong.
    tables = {key: value for key, value in raw.items() if isinstance(value, Mapping)}
    built_of = _system(tables.get("system", {}), tables.get("initial", {}), flaws)
    method = _method(tables.get("integrate", {}), content, flaws)
    flaws += _observe_keys(tables.get("observe", {}))
    if content is None or built_of is None or method is None or flaws:
        raise flaws.error(name)
    try:
        built = _build(*built_of) if former is None else (former.built, former.notes)
    except _UNBUILT as error:
        raise _Flaws([_why_unbuilt(error, content)]).error(name) from error
    model, notes = _in_time(built[0], content, former, flaws), built[1]
    if model is None:
        raise flaws.error(name)
    flaws += _representation(model, content)
    if content.integrate.method == AUTO and not flaws:
        method = _chosen_method(model, content, method, flaws)
    flaws += _quantities(model, content)
    flaws += _observation(model, content)
    flaws += _ends(model, content)
    flaws += _events(model, content)
    if flaws or method is None:
        raise flaws.error(name)
    return Checked(raw, content, *built_of[1:], built[0], model, method, notes)


def _system(
    given: Mapping[str, Any], initial: Mapping[str, Any], flaws: _Flaws
) -> tuple[System, Any, Any] | None:
    """Return the system, its parameters and its initial state."""
    name = given.get("name")
    if not isinstance(name, str) or not name:
        return None  # the structure has reported it
    system = flaws.asked("", find_system, name)
    if system is None:
        return None
    keys = {key: value for key, value in given.items() if key != "name"}
    parameters = flaws.validated(system.parameters, keys, "system")
    return system, parameters, flaws.validated(system.initial, initial, "initial")


def _method(given: Mapping[str, Any], content: Content | None, flaws: _Flaws) -> Method | None:
    """Return the method with its options, and check those that other sections name."""
    known = IntegrateSection.model_fields
    name = given.get("method", known["method"].default)
    if not isinstance(name, str) or not name:
        return None
    method = _CHOSEN_LATER if name == AUTO else flaws.asked("[integrate] ", find_method, name)
    if content is not None:
        _other_methods(content, flaws)
    if method is None:
        return None
    options = {key: value for key, value in given.items() if key not in known}
    if name == AUTO:
        return method  # its options are looked at when it is known
    unknown = [key for key in options if key not in method.options]
    for key in unknown:
        flaws.append(
            f"[integrate] {key} = {shown(options[key])}: no such key, nor an option of "
            f"{name!r}.{nearest(key, [*known, *method.options])}"
        )
    with_options = partial(method.with_options, **options)
    return None if unknown else flaws.asked("[integrate] ", with_options)


def _chosen_method(
    model: Model, content: Content, stand_in: Method, flaws: _Flaws
) -> Method | None:
    """Return the method that the tolerance, and the representation that is meant, choose."""
    name = content.integrate.representation
    problem = model.problems.get(str(name)) or next(iter(model.problems.values()))
    found = flaws.asked("[integrate] ", auto_method, problem, content.integrate.tolerance)
    options = content.integrate.options
    if found is None or not options:
        return None if found is None else found[0]
    return flaws.asked("[integrate] ", partial(found[0].with_options, **options))


def _other_methods(content: Content, flaws: _Flaws) -> None:
    drift, compare = content.drift, content.compare
    if drift.method is not None:
        flaws.asked("[drift] ", find_method, drift.method)
    for name in compare.methods or ():
        flaws.asked("[compare] methods: ", find_method, name)
    found = [
        flaws.asked("[drift] methods: ", method_and_step, entry) for entry in drift.methods or ()
    ]
    flaws.asked("[drift] ", check_once, [entry for entry in found if entry is not None])


def _build(
    system: System, parameters: BaseModel, initial: BaseModel
) -> tuple[Model, tuple[str, ...]]:
    """Return the model, and what the system had to change to make the initial state admissible."""
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


def _why_unbuilt(error: BaseException, content: Content) -> str:
    """Return why a system has no model, after the section of the key that the error names."""
    either, key = "[system] or [initial]:", str(getattr(error, "name", "")).partition("[")[0]
    if isinstance(error, DomainError) and key in (content.system.__pydantic_extra__ or {}):
        return f"[system] {error}"
    if isinstance(error, DomainError) and key in content.initial:
        return f"[initial] {error}"
    if isinstance(error, GeomintError):
        return f"{either} {error}"
    expected = "numbers whose products are finite, and of which there are not too many"
    said_by = f"{type(error).__name__}: {shortened(str(error))}"
    return f"{either} expected {expected} ({said_by})"


def _in_time(built: Model, content: Content, former: Checked | None, flaws: _Flaws) -> Model | None:
    """Return the model in the time that the scene asks for: that of a former scene if it can be."""
    clock = content.time.clock
    if former is not None and former.content.time.clock == clock:
        return former.model
    return built if clock is None else flaws.asked("[time] ", in_time, built, clock)


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
    obstacles = _Flaws()
    problems = model.problems.values()
    if not any(obstacles.asked("", choose_watchers, problem, [name]) for problem in problems):
        yield f"{where}: {obstacles[0]}"


def _observe_keys(given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the keys of ``[observe]`` that are none, and no tables of options."""
    known = list(ObserveSection.model_fields)
    for key, value in given.items():
        if key not in known and not isinstance(value, Mapping):
            where = f"{key_of(('observe', key))} = {shown(value)}"
            yield f"{where}: no such key.{nearest(str(key), known)}"


def _observation(model: Model, content: Content) -> Iterator[str]:
    """Yield what is said of quantities that are not observed."""
    names = {*content.observe.quantities, *(content.drift.quantities or [])}
    for section, every in (("observe", content.observe.every), ("drift", content.drift.every)):
        if not names and every not in (None, 1):
            yield f"[{section}] every = {every!r}: nothing is observed: quantities is empty"
    for name, options in content.observe.options.items():
        where = f"{key_of(('observe', name))} = {shown(options)}"
        having = [p for p in model.problems.values() if name in expanded(p, names)]
        if not having:
            yield f"{where}: {quoted(name)} is observed neither in [observe] nor in [drift]"
        else:
            refused = _Flaws()
            refused.asked(f"[observe.{name}] ", choose_watchers, having[0], {name: options})
            yield from refused


def _events(model: Model, content: Content) -> Iterator[str]:
    """Yield what ``[events]`` and ``[section]`` name and no representation has."""
    names: list[str] = []
    for problem in model.problems.values():
        names += [f"{piece}[{i}]" for piece, rows in problem.pieces for i in range(rows)]
        names += [piece for piece, rows in problem.pieces if rows == 1]
        names += problem.diagnostics
    known = list(dict.fromkeys(names))
    asked = {f"[events.{name}] what": event.what for name, event in content.events.items()}
    event = content.section.event
    if event is not None and event not in content.events:
        asked["[section] event"], known = event, [*known, *content.events]
    for kind, wanted in (("axes", content.section.axes or []), ("keep", _kept(content))):
        asked |= {f"[section] {kind}[{i}]": name for i, name in enumerate(wanted)}
    for where, name in asked.items():
        if name not in known:
            expected = "no such component or quantity"
            yield f"{where} = {quoted(name)}: {expected}.{nearest(name, known)}"


def _kept(content: Content) -> list[str]:
    """Return what ``[section]`` keeps if it names it: the energy, by default, where there is one."""
    return content.section.keep if "keep" in content.section.model_fields_set else []


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
