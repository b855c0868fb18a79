"""What is wrong with a scene beside its system: names that no representation has, and the like."""

from collections.abc import Iterator
from functools import partial

from ..errors import nearest, quoted
from ..methods.method import Method
from ..methods.registry import AUTO, find_solver
from ..problems.problem import GROUPS
from ..problems.systems import Model
from ..run.accuracy.auto import auto_method
from ..watch.observe import choose_watchers
from ..watch.quantities import expanded, quantities_of
from ..watch.registry import plugged
from .explain import key_of, shown
from .flaws import Flaws, Looked
from .model import Content


def checked_with(
    model: Model, looked: Looked, method: Method | None, flaws: Flaws
) -> Method | None:
    """Return the method, and find the flaws that are seen beside the system's representations.

    What one section says of another one is looked at if both are right.
    """
    content, flawed = looked
    flaws += _representation(model, content)
    free = content.integrate.method == AUTO or "method" not in content.integrate.model_fields_set
    if free and not flaws:
        method = _chosen_method(model, content, flaws) or method
    flaws += _quantities(model, content)
    if not flawed & {"observe", "drift"}:
        flaws += _observation(model, content)
    flaws += _ends(model, content)
    if not flawed & {"events", "section"}:
        flaws += _events(model, content)
    return method


def _chosen_method(model: Model, content: Content, flaws: Flaws) -> Method | None:
    """Return the method that the tolerance, and the representation that is meant, choose.

    Where none is named, that which fits, if no representation has a field.
    """
    asked, problems = content.integrate, model.problems
    problem = problems.get(str(asked.representation)) or next(iter(problems.values()))
    found = None
    if asked.method == AUTO:
        found, _ = flaws.asked("[integrate] ", auto_method, problem, asked.tolerance) or (None, "")
    elif not any(other.field for other in problems.values()):
        found = find_solver(None, problem)
    return found and flaws.asked("[integrate] ", partial(found.with_options, **asked.options))


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
    obstacles = Flaws()
    problems = model.problems.values()
    if not any(obstacles.asked("", choose_watchers, problem, [name]) for problem in problems):
        yield f"{where}: {obstacles[0]}"


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
            refused = Flaws()
            refused.asked(f"[observe.{name}] ", choose_watchers, having[0], {name: options})
            yield from refused


def _events(model: Model, content: Content) -> Iterator[str]:
    """Yield what ``[events]`` and ``[section]`` name and no representation has."""
    names = []
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
