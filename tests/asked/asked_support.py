"""What the tests of this folder share: another value of anything, and all that a result says.

The names of keys, options and arguments are read off models, commands and signatures. One is changed
at a time: what it leads to must differ. A value of its own stands in a table only where one of the
same name or kind does not do.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import geomint as gi

__all__ = ["another", "arguments_of", "called", "check", "seen"]


def arguments_of(function: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """Return all arguments of a function, of a class or of its method."""
    found = dict(inspect.signature(function).parameters)
    return {name: argument for name, argument in found.items() if name != "self"}


def another(x: Any) -> Any:
    """Return another value, near to one."""
    match x:
        case bool():
            return not x
        case int():
            return x + 1
        case float():
            return 1.05 * x
        case np.ndarray():
            return 1.05 * x
        case tuple() | list():
            return type(x)(map(another, x))
    raise TypeError(
        f"no value is known that is like {x!r}, but another one: write it into the table"
    )


Values = Mapping[str, Any]


def pair_of(name: str, argument: inspect.Parameter, values: Values) -> Any:
    """Return two values of an argument, its default first where no other is known."""
    for key in (f"{name} {argument.name}", argument.name):
        if key in values:
            found = values[key]
            return found if isinstance(found, tuple) else (found, another(found))
    assert argument.default is not argument.empty, f"no values of {argument.name} of {name}"
    return argument.default, another(argument.default)


def check(
    name: str,
    call: Callable[..., Any],
    arguments: Mapping[str, inspect.Parameter],
    values: Values,
    beside: Mapping[str, Values],
) -> None:
    """Fail where an argument changes nothing, or where nothing but refusals can be seen.

    Parameters
    ----------
    values : mapping
        By ``"function argument"`` or ``"argument"``: two, as a tuple, or one that has another one near.
    beside : mapping
        By ``"function argument"``: what it needs beside it, or in place of another argument.
    """
    pairs = {a: pair_of(name, p, values) for a, p in arguments.items()}
    base = {a: pairs[a][0] for a, p in arguments.items() if p.default is p.empty}
    assert repr(called(call, base)) == repr(called(call, base)), f"{name}: two calls differ"
    for argument, pair in pairs.items():
        given = base | dict(beside.get(f"{name} {argument}", {}))
        one, other = (called(call, {**given, argument: value}) for value in pair)
        assert repr(one) != repr(other), f"{name}: {argument} changes nothing of {one}"
        assert not refused(one) or not refused(other), f"{name}, {argument}: {one}"


def called(call: Callable[..., Any], given: Mapping[str, Any]) -> Any:
    """Return what can be seen of a call's result, or of its refusal."""
    try:
        return seen(call(**given))
    except gi.GeomintError as error:
        return ["refused", str(error)]


def refused(result: Any) -> bool:
    """Tell whether a call ended with an error of its own."""
    return isinstance(result, list) and result[:1] == ["refused"]


def seen(x: Any) -> Any:
    """Return all that can be seen of a result, in a form that `==` compares."""
    match x:
        case gi.Problem():
            return of_problem(x)
        case gi.Solution():
            return of_solution(x)
        case gi.Method():
            return [
                x.name, x.order, x.needs, x.step_fraction, x.adaptive, repr(x.options), x.summary,
            ]  # fmt: skip
        case np.ndarray():
            return [x.shape, x.tolist()]
        case Mapping():
            return {str(key): seen(item) for key, item in x.items()}
        case list() | tuple():
            return [seen(item) for item in x]
        case str() | int() | float() | complex() | None:
            return x
    if dataclasses.is_dataclass(x) and not isinstance(x, type):
        return {f.name: seen(getattr(x, f.name)) for f in dataclasses.fields(x)}
    plain = not callable(x) and hasattr(x, "__dict__")
    return {name: seen(item) for name, item in sorted(vars(x).items())} if plain else None


def of_problem(problem: gi.Problem) -> Any:
    """Return what a problem is, and its functions at a random state of its own."""
    try:
        y = problem.random_state(5)
    except gi.DomainError:
        y = np.linspace(0.3, 0.9, problem.rows)
    rates = gi.derivative(problem, y, 0.4) if problem.field or problem.action else None
    functions = dict(problem.diagnostics)
    functions |= {"clock": problem.clock} if problem.clock else {}
    functions |= {"density": problem.measure.log_density} if problem.measure else {}
    found = {name: gi.value(problem, f, y, 0.4) for name, f in functions.items()}
    data = [problem.name, problem.pieces, problem.params, problem.forms, problem.time]
    return seen([*data, y, rates, found, dict(problem.parameters)])


def of_solution(solution: gi.Solution) -> Any:
    """Return states, drifts and costs, without times that no two runs share."""
    drifts = {name: drift.as_json() for name, drift in solution.drift.items()}
    numbers = [solution.steps, solution.iterations, solution.evaluations, solution.rejected]
    said = [solution.step, solution.status, solution.message, solution.error_estimate]
    beside = [solution.kept and solution.kept.times, solution.t_events, solution.y_events]
    return seen([solution.tau, solution.physical, solution.y, drifts, *numbers, *said, *beside])
