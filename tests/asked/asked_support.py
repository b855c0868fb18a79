"""What the tables of this folder share: one number for everything that a result says.

Every table has an entry for every key, option or argument that there is: the names are read off the
models, commands and signatures themselves, so that a new one without an entry fails. An entry is two
values of that one thing, all else being equal; what they lead to must differ.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import geomint as gi

__all__ = ["arguments_of", "called", "methods_of", "said", "seen"]


def arguments_of(function: Callable[..., Any]) -> set[str]:
    """Return the names of all arguments of a function or a class."""
    return set(inspect.signature(function).parameters)


def methods_of(kind: type) -> set[str]:
    """Return the names of the public methods of a class that take arguments."""
    found = inspect.getmembers(kind, lambda f: inspect.isfunction(f) or inspect.ismethod(f))
    return {
        name
        for name, f in found
        if not name.startswith("_")
        and arguments_of(f) - ({"self"} if inspect.isfunction(f) else set())
    }


def called(function: Callable[..., Any], given: Mapping[str, Any]) -> Any:
    """Return what can be seen of a call's result, or of its typed error.

    Arguments are given by position where a function takes them so.
    """
    try:
        kinds = inspect.signature(function).parameters
        if all(p.kind is p.POSITIONAL_OR_KEYWORD for p in kinds.values()) and set(kinds) == set(
            given
        ):
            return seen(function(*(given[name] for name in kinds)))
        return seen(function(**given))
    except gi.GeomintError as error:
        return ["error", str(error)]


def seen(x: Any) -> Any:
    """Return all that can be seen of a result, in a form that `==` compares."""
    if isinstance(x, gi.Problem):
        return of_problem(x)
    if isinstance(x, gi.Solution):
        return of_solution(x)
    if isinstance(x, gi.Method):
        return (x.name, x.order, x.needs, x.step_fraction, x.adaptive, repr(x.options), x.summary)
    if isinstance(x, np.ndarray):
        return (x.shape, x.tolist())
    if isinstance(x, Mapping):
        return {str(key): seen(item) for key, item in x.items()}
    if isinstance(x, list | tuple):
        return [seen(item) for item in x]
    if dataclasses.is_dataclass(x) and not isinstance(x, type):
        return {f.name: seen(getattr(x, f.name)) for f in dataclasses.fields(x)}
    if isinstance(x, str | int | float | complex | bool | None):
        return x
    return {name: seen(item) for name, item in sorted(vars(x).items())} if said(x) else None


def said(x: Any) -> bool:
    """Tell whether an object has plain attributes worth comparing."""
    return not callable(x) and hasattr(x, "__dict__")


def of_problem(problem: gi.Problem) -> Any:
    """Return what a problem is, and its functions at a random state of its own."""
    try:
        y = problem.random_state(5)
    except gi.DomainError:
        y = np.linspace(0.3, 0.9, problem.rows)
    rates = gi.derivative(problem, y, 0.4) if problem.field or problem.action else None
    found = {name: gi.value(problem, f, y, 0.4) for name, f in problem.diagnostics.items()}
    clock = None if problem.clock is None else gi.value(problem, problem.clock, y, 0.4)
    density = problem.measure and gi.value(problem, problem.measure.log_density, y)
    data = [problem.name, problem.pieces, problem.params, problem.forms, problem.time]
    return seen([*data, y, rates, found, clock, density, dict(problem.parameters)])


def of_solution(solution: gi.Solution) -> Any:
    """Return states, drifts and costs, without times that no two runs share."""
    drifts = {name: drift.as_json() for name, drift in solution.drift.items()}
    numbers = [solution.steps, solution.iterations, solution.evaluations, solution.rejected]
    times = None if solution.physical is None else solution.physical
    said = [solution.step, solution.status, solution.message]
    beside = [solution.kept and solution.kept.times, solution.t_events, solution.y_events]
    beside.append(solution.error_estimate)
    return seen([solution.tau, times, solution.y, drifts, numbers, *said, *beside])
