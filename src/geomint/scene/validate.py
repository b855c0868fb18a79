"""From raw content to a checked scene, or one `SceneError` that lists everything wrong with it."""

import warnings
from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from ..errors import DomainError, Gathered, GeomintError, GeomintWarning, nearest, quoted, raised
from ..methods.gauss import Gauss
from ..methods.method import Method
from ..methods.registry import AUTO, find_method
from ..problems.systems import Model, System, find_system, in_time
from .entries import check_once, method_and_step
from .explain import key_of, shown
from .flaws import Flaws, mended
from .model import Content, IntegrateSection, ObserveSection, Raw
from .raw import plain
from .with_model import checked_with

_CHOSEN_LATER = Gauss()  # what method "auto" is checked as, until the problem is built
_UNBUILT = (ArithmeticError, MemoryError, np.linalg.LinAlgError)


class _BuiltOf(NamedTuple):
    """What a model is built of; whether all of it is as it was given."""

    system: System
    parameters: BaseModel | None
    initial: BaseModel | None
    right: bool


class Checked(NamedTuple):
    """Content that was found right, as it was given and checked, with what was built from it."""

    raw: dict[str, Any]
    content: Content
    parameters: BaseModel
    initial: BaseModel
    built: Model
    model: Model
    method: Method
    told: tuple[GeomintWarning, ...]
    places: Mapping[str, str]  # as `Flaws` takes them


def check_content(
    given: Raw,
    name: str,
    former: Checked | None = None,
    places: Mapping[str, str] | None = None,
) -> Checked:
    """Return the checked content, or raise a `SceneError` with one line for every flaw.

    What is right is looked at in spite of what is wrong beside it, as far as one does not need the
    other.

    Parameters
    ----------
    given : mapping
    name : str
        Of the scene.
    former : Checked, optional
        Of a scene with the same system and initial state, whose model is taken.
    places : mapping, optional
        As `Flaws` takes them.
    """
    flaws = Flaws(places)
    raw = flaws.asked("", plain, given)
    if raw is None:
        raise flaws.error(name)
    looked = flaws.looked(raw)
    tables = {key: value for key, value in raw.items() if isinstance(value, Mapping)}
    built_of = _system(tables.get("system", {}), tables.get("initial", {}), flaws)
    method = _method(tables.get("integrate", {}), looked.content, flaws)
    flaws += _observe_keys(tables.get("observe", {}))
    built = _built(built_of, tables, former, flaws)
    model = None if built is None else _in_time(built[0], looked.content, former, flaws)
    if model is not None:
        method = checked_with(model, looked, method, flaws)
    if flaws or built_of is None or built is None or model is None or method is None:
        raise flaws.error(name) from flaws.cause
    assert built_of.parameters is not None
    assert built_of.initial is not None
    given_of = built_of.parameters, built_of.initial
    return Checked(raw, looked.content, *given_of, built[0], model, method, built[1], flaws.places)


def _system(given: Raw, initial: Raw, flaws: Flaws) -> _BuiltOf | None:
    """Return the system, its parameters and its initial state, as far as they are right."""
    name = given.get("name")
    if not isinstance(name, str) or not name:
        return None  # the structure has reported it
    system = flaws.asked("", find_system, name)
    if system is None:
        return None
    keys = {key: value for key, value in given.items() if key != "name"}
    before = len(flaws)
    parameters = flaws.validated(system.parameters, keys, "system")
    start = flaws.validated(system.initial, initial, "initial")
    if len(flaws) == before:
        return _BuiltOf(system, parameters, start, True)
    left = mended(system.parameters, keys), mended(system.initial, initial)
    return _BuiltOf(system, *left, False)


def _method(given: Raw, content: Content, flaws: Flaws) -> Method | None:
    """Return the method with its options, and check those that other sections name."""
    known = IntegrateSection.model_fields
    name = given.get("method", known["method"].default)
    if not isinstance(name, str) or not name:
        return None
    method = _CHOSEN_LATER if name == AUTO else flaws.asked("[integrate] ", find_method, name)
    _other_methods(content, flaws)
    if method is None:
        return None
    options = {key: value for key, value in given.items() if key not in known}
    if name == AUTO:
        return method  # its options are looked at when it is known
    refused = Flaws()
    for key, value in options.items():
        if key in method.options:
            refused.asked("[integrate] ", partial(method.with_options, **{key: value}))
        else:
            refused.append(
                f"[integrate] {key} = {shown(value)}: no such key, nor an option of "
                f"{name!r}.{nearest(key, [*known, *method.options])}"
            )
    flaws += refused
    with_options = partial(method.with_options, **options)
    return None if refused else flaws.asked("[integrate] ", with_options)


def _other_methods(content: Content, flaws: Flaws) -> None:
    drift, compare = content.drift, content.compare
    if drift.method is not None:
        flaws.asked("[drift] ", find_method, drift.method)
    for name in compare.methods or ():
        flaws.asked("[compare] methods: ", find_method, name)
    found = [
        flaws.asked("[drift] methods: ", method_and_step, entry) for entry in drift.methods or ()
    ]
    flaws.asked("[drift] ", check_once, [entry for entry in found if entry is not None])


def _built(
    of: _BuiltOf | None, tables: Raw, former: Checked | None, flaws: Flaws
) -> tuple[Model, tuple[GeomintWarning, ...]] | None:
    """Return the model, and what had to be changed to make the initial state admissible.

    Of sections with flaws only what is wrong with a value that is there is told: the rest may follow
    from what was told before.
    """
    if of is None or of.parameters is None or of.initial is None:
        return None
    if former is not None:
        return former.built, former.told
    try:
        return _build(of.system, of.parameters, of.initial)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever another package raises
        place = _place_of(error, tables)
        if place is not None or of.right:
            flaws.append(_why_unbuilt(error, place or "[system] or [initial]:"))
            flaws.cause = error
        return None


def _build(
    system: System, parameters: BaseModel, initial: BaseModel
) -> tuple[Model, tuple[GeomintWarning, ...]]:
    with Gathered(quiet=True) as told, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GeomintWarning)
        model = system.build(parameters, initial)
        if not isinstance(model, Model):
            raise TypeError(f"it returned {quoted(model)}, which is no Model")
    for warning in caught:  # of packages that warn by themselves
        if isinstance(warning.message, GeomintWarning):
            told.append(warning.message)
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
    return model, tuple(dict.fromkeys(told))


def _place_of(error: BaseException, tables: Raw) -> str | None:
    """Return the section of the key that an error names; None if it names none that is given."""
    key = str(getattr(error, "name", "")).partition("[")[0]
    sections = ("system", "initial") if isinstance(error, DomainError) else ()
    return next((f"[{name}]" for name in sections if key in tables.get(name, {})), None)


def _why_unbuilt(error: BaseException, place: str) -> str:
    """Return why a system has no model."""
    if isinstance(error, GeomintError):
        return f"{place} {error}"
    if not isinstance(error, _UNBUILT):
        return f"[system] name: the system's own build failed, {raised(error)}"
    expected = "numbers whose products are finite, and of which there are not too many"
    return f"{place} expected {expected} ({raised(error)})"


def _in_time(built: Model, content: Content, former: Checked | None, flaws: Flaws) -> Model | None:
    """Return the model in the time that the scene asks for: that of a former scene if it can be."""
    clock = content.time.clock
    if former is not None and former.content.time.clock == clock:
        return former.model
    return built if clock is None else flaws.asked("[time] ", in_time, built, clock)


def _observe_keys(given: Raw) -> Iterator[str]:
    """Yield the keys of ``[observe]`` that are none, and no tables of options."""
    known = list(ObserveSection.model_fields)
    for key, value in given.items():
        if key not in known and not isinstance(value, Mapping):
            where = f"{key_of(('observe', key))} = {shown(value)}"
            yield f"{where}: no such key.{nearest(str(key), known)}"
