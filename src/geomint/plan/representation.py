"""The rule of the planner for the representation: the cheapest that delivers what is asked for.

Sections and scans take the cheapest one that has what they name, `route_with`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import DomainError, FormError
from ..methods.method import FITTING
from ..problems.problem import Problem
from ..run import events
from ..watch.quantities import expanded, find_watcher, quantities_of
from ..watch.watcher import Watcher
from .choice import Asked, Choice, Route
from .cost import Cost, cost_of
from .fitting import obstacles, unfit

Reasons = dict[str, str]  # why not, by representations
_TIME = {"t": "physical time t", "tau": "its own time τ"}


def choose_representation(c: Asked) -> Choice[Route]:
    """Take the representation asked for, or the scene's own, or the first that fits the method.

    A cheaper one takes its place if it delivers all that is observed, and the states that are kept.
    """
    unfitting = obstacles(c.model, c.method, c.end)
    missing = {
        name: [*missing_quantities(c, problem), *missing_events(c, problem)]
        for name, problem in c.model.problems.items()
    }
    against = {
        name: obstacle or (f"has no {', '.join(missing[name])}" if missing[name] else "")
        for name, obstacle in unfitting.items()
    }
    asked = c.content.integrate.representation
    if asked is not None:
        return _asked(c, asked, unfitting, against)
    fitting = [name for name in against if not against[name]]
    if not fitting and c.purpose == "drift":  # with those that lack least
        lacking = {n: len(missing[n]) for n, obstacle in unfitting.items() if not obstacle}
        fitting = [name for name, count in lacking.items() if count == min(lacking.values())]
    if not fitting:
        raise _nothing_fits(c, against)
    own, method = c.own, c.method
    first = own if own in fitting else fitting[0]
    if first == own:
        reason = f"the scene's own; it offers the form {method.needs!r} that {method.name} needs"
    else:
        reason = f"{own}: {against[own]}; the same motion from the same initial state"
    chosen, saving = _cheaper(c, c.route(first), unfitting)
    words = [saving] if own == first != chosen.name else [reason, saving]
    return told_representation(chosen, "; ".join(filter(None, words)))


def told_representation(route: Route, reason: str) -> Choice[Route]:
    """Return the choice of a representation, in words."""
    problem = route.problem
    pieces = ", ".join(f"{piece} ({rows})" for piece, rows in problem.pieces)
    value = f"{route.name}: {pieces}; {problem.rows} numbers in {_TIME[problem.time]}"
    return Choice("representation", route, value, reason)


def _asked(c: Asked, asked: str, unfitting: Reasons, against: Reasons) -> Choice[Route]:
    name = c.representation or asked
    if against[name] and (unfitting[name] or c.purpose != "drift"):
        problem = c.model.problems[name]
        has = f"It has {', '.join(quantities_of(problem))}"
        fitting = f"Methods that fit {name!r}: {_methods_for(problem)}"
        instead = fitting if unfitting[name] else has
        raise FormError(f"{_place(c)} = {asked!r} does not serve: {against[name]}. {instead}")
    return told_representation(c.route(name), f"{_place(c)} = {asked!r}")


def _place(c: Asked) -> str:
    return c.scene.place("integrate", "representation")


def _nothing_fits(c: Asked, against: Reasons) -> FormError:
    words = "; ".join(
        f"{', '.join(name for name in against if against[name] == obstacle)}: {obstacle}"
        for obstacle in dict.fromkeys(against.values())
    )
    fitting = _methods_for(c.model.problems[c.own])
    return FormError(
        f"no representation of {c.content.system.name!r} fits method "
        f"{c.method.name!r} ({words}). Methods that fit {c.own!r}: {fitting}"
    )


def _methods_for(problem: Problem) -> str:
    return ", ".join(FITTING[form] for form in problem.forms)


def wanted_watchers(c: Asked, problem: Problem) -> dict[str, Watcher | None]:
    """Return what watches all that is observed, if a problem is integrated; None for what it lacks.

    Groups are those of the scene's own representation, but constraints those of what is integrated: a
    group says "whatever keeps the state on its manifold". A constraint that is named is meant itself.
    """
    own, constraints = c.scene.problem, list(problem.constraints)
    wanted = []
    for quantity in c.content.observe.quantities:
        if quantity == "constraints":
            wanted += constraints
        elif quantity == "all":
            wanted += [q for q in quantities_of(own) if q not in own.constraints] + constraints
        else:
            wanted += expanded(own, [quantity])
    return {name: find_watcher(problem, name) for name in wanted}


def missing_quantities(c: Asked, problem: Problem) -> list[str]:
    """Return what is observed and a problem does not have."""
    return [name for name, watcher in wanted_watchers(c, problem).items() if watcher is None]


def missing_events(c: Asked, problem: Problem) -> list[str]:
    """Return what events of a run look at that a problem does not have."""
    asked = c.content.events.values() if c.purpose == "run" else ()
    return [event.what for event in asked if not has(problem, event.what)]


def has(problem: Problem, name: str) -> bool:
    """Tell whether a problem has a component or a quantity of that name."""
    try:
        events.quantity(problem, name)
    except DomainError:
        return False
    return True


def _cheaper(c: Asked, first: Route, unfitting: Reasons) -> tuple[Route, str]:
    """Return the cheapest way to what `first` delivers, and why.

    It must be in the same time, be cheaper (`Cost.below`), and have every quantity that is observed
    in `first`; the group "constraints" means its own ones. If one or two quantities stand in the
    way, the reason names them.
    """
    ways = {first.name: first, **_others(c, first, unfitting)}
    costs = {n: cost_of(way.problem, c.method.needs, way.state) for n, way in ways.items()}
    smaller = [name for name in ways if costs[name].below(costs[first.name])]
    lacking = {name: _lacking(c, first, ways[name]) for name in smaller}
    whole = [name for name in smaller if not lacking[name]]
    if whole:
        name = min(whole, key=costs.__getitem__)
        return ways[name], _saving(c, first, ways[name], costs)
    nearly = [name for name in smaller if len(lacking[name]) <= 2]
    if not nearly:
        return first, ""
    name = min(nearly, key=lambda name: (len(lacking[name]), costs[name]))
    names = ", ".join(lacking[name])
    keep = "keeps" if len(lacking[name]) == 1 else "keep"
    compared = _compared(costs, first.name, name)
    return first, f"{names} {keep} it: else {name} would do, {compared}"


def _others(c: Asked, first: Route, unfitting: Reasons) -> dict[str, Route]:
    """Return what may be integrated in place of a representation, by name.

    Every representation in the same time, if no states are kept; reductions, if their states are
    mapped back, there are no events, and saved states are not those after so many of an adaptive
    method's own steps.
    """
    model, found = c.model, {}
    if c.purpose == "drift":
        for name, problem in model.problems.items():
            if problem.time == first.problem.time and not unfitting[name]:
                found[name] = c.route(name)
    elif c.content.events or (c.method.adaptive and c.saving.every is not None):
        return {}
    for r in model.reductions:
        if r.of == first.name and r.name not in found and not unfit(r.problem, c.method, c.end):
            lift = r.lift if c.purpose == "run" else None
            found[r.name] = replace(Route.along(r), lift=lift)
    return found


def _lacking(c: Asked, first: Route, way: Route) -> list[str]:
    wanted = [name for name in c.content.observe.quantities if name != "constraints"]
    observed = dict.fromkeys(expanded(first.problem, wanted))

    def has(name: str) -> bool:
        there = find_watcher(way.problem, name)
        same = way.same is None or name in way.same
        return there is not None and there.invariant and same

    return [name for name in observed if find_watcher(first.problem, name) and not has(name)]


def _saving(c: Asked, first: Route, way: Route, costs: dict[str, Cost]) -> str:
    kept = {piece for piece, _ in way.problem.pieces}
    gone = [piece for piece, _ in first.problem.pieces if piece not in kept]
    words = [way.condition] if way.condition not in ("", first.condition) else []
    if c.purpose == "run":
        words.append(f"saved states are those of {first.name} again")
    else:
        alternatives = " or ".join(filter(None, [", ".join(gone[:-1]), *gone[-1:]]))
        words.append(f"nothing observed needs {alternatives}" if gone else "all observed is there")
    compared = _compared(costs, first.name, way.name)
    return f"{first.name} → {way.name}: {', '.join(words)}: {compared}"


def _compared(costs: dict[str, Cost], first: str, name: str) -> str:
    small, large = costs[name], costs[first]
    return (
        f"{small.rows} numbers instead of {large.rows}, "
        f"{small.operations} operations an evaluation instead of {large.operations}"
    )


def route_with(
    c: Asked, names: Sequence[str], use: str, end: Mapping[str, Any] = MappingProxyType({})
) -> Route:
    """Return the cheapest representation that the method fits, that has what is named.

    Of those in the scene's own time whose numbers are all among its own, as long as there are any.

    Parameters
    ----------
    names : sequence of str
        Components and quantities.
    use : str
        What it is for, in words.
    end : mapping
        As `unfit` takes it.

    Raises
    ------
    FormError
        If there is none.
    """
    own = c.route(c.own)
    wanted = list(c.model.problems) if c.representation is None else [c.representation]
    obstacles = {}
    for name in wanted:
        problem = c.model.problems[name]
        lacking = ", ".join(n for n in names if not has(problem, n))
        found = unfit(problem, c.method, end)
        if c.content.integrate.exact:
            found = "has no exact flow" if problem.make_exact is None else ""
        obstacles[name] = found or (f"has no {lacking}" if lacking else "")
    fitting = [c.route(name) for name in wanted if not obstacles[name]]
    if not fitting:
        words = "; ".join(f"{name}: {why}" for name, why in obstacles.items())
        raise FormError(
            f"no representation of {c.content.system.name!r} serves for {use} by "
            f"{'the exact flow' if c.content.integrate.exact else repr(c.method.name)}: {words}"
        )
    within = [route for route in fitting if _within(route, own)] or fitting[:1]
    return min(within, key=lambda route: cost_of(route.problem, c.method.needs, route.state))


def _within(part: Route, own: Route) -> bool:
    """Tell whether all numbers of a representation are numbers of another, by their names."""
    mine, theirs = _numbers(part), _numbers(own)
    return part.problem.time == own.problem.time and all(
        name in theirs and np.array_equal(numbers, theirs[name]) for name, numbers in mine.items()
    )


def _numbers(route: Route) -> dict[str, Array]:
    return {name: route.state[rows] for name, rows in route.problem.slices.items()}
