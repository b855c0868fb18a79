"""Quadratures along a motion: a problem with one more number, whose rate is given.

So is physical time integrated beside τ. One number more is one row more, after the state: for the
field its rate is the last component, for a group that acts on the state translations move it.
"""

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..arguments import Array, as_vector, check_name
from ..errors import DomainError, FormError
from ..kernels.compiling.recorded import Recorded, named_as, observable
from ..kernels.numbers.blocks import fixed_rows, part
from .forms import Group, GroupAction
from .groups import translations
from .problem import Problem


@functools.cache
def generator_beside(f: Recorded, rate: Recorded, rows: int, algebra_rows: int) -> Recorded:
    """Return a field or generator with one more row, which moves at the rate of an observable.

    By that of a generator the group of `group_beside` moves the number.
    """

    def beside(params, t, y, out, work):
        state = fixed_rows(part(y, 0, rows), rows)
        f(params, t, state, fixed_rows(part(out, 0, algebra_rows), algebra_rows), work)
        out[algebra_rows] = rate(params, t, state, work)

    return named_as(beside, f)


def group_beside(group: Group, rows: int) -> Group:
    """Return the group that moves states of `rows` rows, and a number after them."""
    return replace(group, rows=rows) * translations(1)


def quantities(problem: Problem, of: Callable[[Recorded], Recorded]) -> dict[str, Any]:
    """Return a problem's invariants, constraints and observables, each made of the own one."""
    return {
        group: {name: of(f) for name, f in getattr(problem, group).items()}
        for group in ("invariants", "constraints", "observables")
    }


def with_quadrature(problem: Problem, name: str, rate: Recorded) -> Problem:
    """Return the problem with one more number s, ṡ = rate(params, t, y, work).

    So a time that runs at another rate, or an action, is integrated with the state by any method
    for ODEs or of groups, to its order.

    Parameters
    ----------
    problem : Problem
        One that has the ODE form or that of a group.
    name : str
        What the number is called; it is the last piece of the state, and 0 at the beginning unless
        ``state`` gets it.
    rate : recorded ``f(params, t, y, work) -> number``
        As an observable of `problem`; in the problem's own time.

    Raises
    ------
    FormError
        If the problem has neither form.
    DomainError
        If it has a piece of that name.
    """
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    check_name("name", name)
    if not isinstance(rate, Recorded):
        raise DomainError("rate", rate, "a function recorded with geomint.observable")
    own, action = problem.field, problem.action
    if own is None and action is None:
        what = "neither an ODE form nor one of a group: with_quadrature needs one"
        raise FormError(f"problem {problem.name!r} has {what}")
    if name in dict(problem.pieces):
        raise DomainError("name", name, f"another name than {[n for n, _ in problem.pieces]}")
    rows = problem.rows

    def restricted(f: Recorded) -> Recorded:
        def observed(params, t, y, work):
            return f(params, t, part(y, 0, rows), work)

        return observable(observed)

    def value(params, t, y, work):
        return 1.0 * y[rows]

    def make_state(**components: Any) -> Array:
        start = as_vector(name, components.pop(name, 0.0), 1)
        return np.concatenate([problem.state(**components), start])

    def admit(y: Array) -> Array:
        return np.concatenate([problem.canonical(y[:rows]), y[rows:]])

    known = quantities(problem, restricted)
    known["observables"][name] = observable(value)
    return replace(
        problem,
        space=None,
        pieces=(*problem.pieces, (name, 1)),
        field=None if own is None else generator_beside(own, rate, rows, rows),
        action=None if action is None else _beside(action, rate, rows),
        hamiltonian=None,
        splitting=None,
        clock=None if problem.clock is None else restricted(problem.clock),
        **known,
        measure=None,
        symplectic_form=None,
        make_state=make_state,
        admit=admit,
        physical=lambda y: problem.physical_state(y[:rows]),
    )


def _beside(action: GroupAction, rate: Recorded, rows: int) -> GroupAction:
    """Return the group form with one more number."""
    generator = generator_beside(action.generator, rate, rows, action.group.algebra_rows)
    return GroupAction(generator, group_beside(action.group, rows))
