"""The cheapest representation that has what is named: for sections and scans."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import FormError
from .choice import Asked, Route
from .cost import cost_of
from .fitting import unfit
from .representation import has


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
    asked, own = c.content.integrate.representation, c.route(c.own)
    wanted = list(c.model.problems) if asked is None else [c.own if asked == "own" else asked]
    obstacles: dict[str, str] = {}
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
