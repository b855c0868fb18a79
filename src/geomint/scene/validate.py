"""From raw content to a checked scene, or one `SceneError` that lists what is wrong with it."""

import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from ..errors import DomainError, Gathered, GeomintError, GeomintWarning, nearest, quoted, raised
from ..methods.gauss import Gauss
from ..methods.method import Method
from ..methods.registry import AUTO, find_method, find_solver
from ..problems.problem import GROUPS
from ..problems.systems import Model, System, find_system, in_time
from ..run.accuracy.auto import auto_method
from ..watch.observe import choose_watchers
from ..watch.quantities import expanded, quantities_of
from ..watch.registry import plugged
from .entries import method_and_step, methods_and_steps
from .explain import Flaws, key_of, no_such_key
from .model import Content, IntegrateSection, ObserveSection, Raw, content_model
from .raw import plain


class Checked(NamedTuple):
    """Content that was found right, as it was given and checked, with what was built from it."""

    raw: dict[str, Any]
    content: Content
    system: System
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
    system: System | None = None,
) -> Checked:
    """Return the checked content, or raise a `SceneError` with one line for every flaw.

    Flaws of the sections themselves are told together. If there are none, the model is built, and
    what sections say of it and of one another is looked at.

    Parameters
    ----------
    given : mapping
    name : str
        Of the scene.
    former : Checked, optional
        Of a scene with the same system and initial state, whose model is taken.
    places : mapping, optional
        As `Flaws` takes them.
    system : System, optional
        Of one's own. Default: that of the former scene, or the registered one that is named.
    """
    flaws = Flaws(name, places or {})
    raw = flaws.asked("", plain, given)
    flaws.end()
    tables = {key: value for key, value in raw.items() if isinstance(value, Mapping)}
    content = flaws.validated(content_model(raw), raw)
    of = _system(tables, system or (former and former.system), flaws)
    method = _method(tables.get("integrate", {}), flaws)
    flaws += _observe_keys(tables.get("observe", {}))
    flaws.end()
    built, told = (former.built, former.told) if former else _built(of, tables, flaws)
    clock = content.time.clock
    if former and former.content.time.clock == clock:
        model = former.model
    else:
        model = flaws.asked("[time] ", in_time, built, clock) if clock else built
    flaws.end()
    for check in (_methods, _names, _plugged, _observation, _ends):
        flaws += check(model, content)
    flaws.end()
    method = flaws.asked("[integrate] ", _chosen_method, model, content, method)
    flaws.end()
    return Checked(raw, content, of[0], of[1], of[2], built, model, method, told, flaws.places)


def _system(tables: Raw, own: System | None, flaws: Flaws) -> Any:
    """Return the system, its parameters and its initial state; None if it is not known."""
    given = dict(tables.get("system", {}))
    name = given.pop("name", None)
    if own is None or own.name != name:  # `Content` tells what is no name
        own = flaws.asked("", find_system, name) if name and isinstance(name, str) else None
    if own is None:
        return None
    parameters = flaws.validated(own.parameters, given, "system")
    return own, parameters, flaws.validated(own.initial, tables.get("initial", {}), "initial")


def _method(given: Raw, flaws: Flaws) -> Any:
    """Return the method with its options; any one for ``"auto"``, until the problem is built."""
    known = IntegrateSection.model_fields
    name = given.get("method", known["method"].default)
    if name == AUTO or not isinstance(name, str) or not name:
        return Gauss()
    method = flaws.asked("[integrate] ", find_method, name)
    for key in [key for key in given if method and key not in known]:
        if key in method.options:
            method = flaws.asked("[integrate] ", method.with_options, **{key: given[key]}) or method
        else:
            nor, names = f", nor an option of {name!r}", [*known, *method.options]
            flaws.append(no_such_key(("integrate", key), given[key], names, nor))
    return method


def _observe_keys(given: Raw) -> list[str]:
    """Return what is said of keys of ``[observe]`` that are none, and no tables of options."""
    known = ObserveSection.model_fields
    wrong = [key for key in given if key not in known and not isinstance(given[key], Mapping)]
    return [no_such_key(("observe", key), given[key], known) for key in wrong]


def _built(of: Any, tables: Raw, flaws: Flaws) -> tuple[Model, tuple[GeomintWarning, ...]]:
    """Return the model, and what had to be changed to make the initial state admissible."""
    try:
        with Gathered(quiet=True) as told, warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", GeomintWarning)
            model = of[0].build(*of[1:])
            if not isinstance(model, Model):
                raise TypeError(f"it returned {quoted(model)}, which is no Model")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever another package raises
        flaws.append(_why_unbuilt(error, tables))
        flaws.end(error)
    for w in caught:  # of packages that warn by themselves
        if isinstance(w.message, GeomintWarning):
            told.append(w.message)
        else:
            warnings.warn_explicit(w.message, w.category, w.filename, w.lineno)
    return model, tuple(dict.fromkeys(told))


def _why_unbuilt(error: BaseException, tables: Raw) -> str:
    """Return why a system has no model, with the section of the key that the error names."""
    said = f"expected numbers whose products are finite, and not too many of them ({raised(error)})"
    if isinstance(error, GeomintError):
        said = str(error)
    elif not isinstance(error, ArithmeticError | MemoryError | np.linalg.LinAlgError):
        return f"[system] name: the system's own build failed, {raised(error)}"
    key = error.name.partition("[")[0] if isinstance(error, DomainError) else ""
    having = [f"[{section}]" for section in ("system", "initial") if key in tables.get(section, {})]
    return f"{[*having, '[system] or [initial]:'][0]} {said}"


def _chosen_method(model: Model, content: Content, named: Method) -> Method:
    """Return the method that is named, or the one that the tolerance and the representation choose.

    Where none is named, it is that which fits, if no representation has a field.
    """
    asked, problems = content.integrate, model.problems
    problem = problems.get(str(asked.representation)) or next(iter(problems.values()))
    if asked.method == AUTO:
        found, _ = auto_method(problem, asked.tolerance)
    elif "method" in asked.model_fields_set or any(other.field for other in problems.values()):
        return named
    else:
        found = find_solver(None, problem)
    return found.with_options(**asked.options)


def _refused(where: str, function: Callable[..., Any], *given: Any) -> Iterator[str]:
    """Yield the error that a function raises, if it does."""
    try:
        function(*given)
    except GeomintError as error:
        yield f"{where}{error}"


def _methods(model: Model, content: Content) -> Iterator[str]:
    """Yield what is wrong with the methods of other sections."""
    drift, several = content.drift, content.drift.methods or []
    if drift.method is not None:
        yield from _refused("[drift] ", find_method, drift.method)
    for name in content.compare.methods or ():
        yield from _refused("[compare] methods: ", find_method, name)
    lines = [x for e in several for x in _refused("[drift] methods: ", method_and_step, e)]
    yield from lines or (_refused("[drift] ", methods_and_steps, several) if several else ())


def _names(model: Model, content: Content) -> Iterator[str]:
    """Yield names that are not known."""
    for where, name, known, what in _named(model, content):
        if name is not None and name not in known:
            yield f"{where} = {quoted(name)}: no such {what}.{nearest(name, dict.fromkeys(known))}"


def _named(model: Model, content: Content) -> Iterator[tuple[str, str | None, list[str], str]]:
    """Yield names with the places where they were written, what may be there, and what that is.

    Any representation may have what is observed, and what events look at.
    """
    problems, section = model.problems.values(), content.section
    what = f"representation of {content.system.name!r} from this initial state"
    asked = content.integrate.representation
    yield "[integrate] representation", asked, ["own", *model.problems], what
    known = [*GROUPS, *plugged(), *(name for p in problems for name in quantities_of(p))]
    for where, name in _watched(content):
        yield where, name, known, "quantity"
    pieces = [piece for p in problems for piece in p.pieces]
    known = [f"{piece}[{i}]" for piece, rows in pieces for i in range(rows)]
    known += [piece for piece, rows in pieces if rows == 1]
    known += [name for p in problems for name in p.diagnostics]
    for event, given in content.events.items():
        yield f"[events.{event}] what", given.what, known, "component or quantity"
    yield "[section] event", section.event, [*known, *content.events], "component or quantity"
    # Without a word on it the energy is kept where there is one.
    keep = section.keep if "keep" in section.model_fields_set else []
    for key, names in (("axes", section.axes or []), ("keep", keep)):
        for i, name in enumerate(names):
            yield f"[section] {key}[{i}]", name, known, "component or quantity"


def _watched(content: Content) -> Iterator[tuple[str, str]]:
    """Yield the quantities of ``[observe]`` and ``[drift]`` with their places."""
    for section in ("observe", "drift"):
        for i, name in enumerate(getattr(content, section).quantities or []):
            yield f"[{section}] quantities[{i}]", name


def _plugged(model: Model, content: Content) -> Iterator[str]:
    """Yield what keeps watchers of other packages from every representation."""
    problems = model.problems.values()
    for where, name in _watched(content):
        if name in plugged() and not any(name in quantities_of(p) for p in problems):
            lines = [line for p in problems for line in _refused("", choose_watchers, p, [name])]
            if len(lines) == len(problems):
                yield f"{where} = {quoted(name)}: {lines[0]}"


def _observation(model: Model, content: Content) -> Iterator[str]:
    """Yield what is said of quantities that are not observed."""
    names = {*content.observe.quantities, *(content.drift.quantities or [])}
    for section, every in (("observe", content.observe.every), ("drift", content.drift.every)):
        if not names and every not in (None, 1):
            yield f"[{section}] every = {every!r}: nothing is observed: quantities is empty"
    for name, options in content.observe.options.items():
        having = [p for p in model.problems.values() if name in expanded(p, names)]
        if having:
            yield from _refused(f"[observe.{name}] ", choose_watchers, having[0], {name: options})
        else:
            where = f"{key_of(('observe', name))} = {quoted(options)}"
            yield f"{where}: {quoted(name)} is observed neither in [observe] nor in [drift]"


def _ends(model: Model, content: Content) -> Iterator[str]:
    if next(iter(model.problems.values())).time == "t":
        for name in ("time", "drift", "compare"):
            if (end := getattr(content, name).tau_end) is not None:
                why = f"expected t_end: {content.system.name!r} is in physical time"
                yield f"[{name}] tau_end = {end!r}: {why}"
