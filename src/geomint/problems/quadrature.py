"""Quadratures along a motion: a problem with one more number, whose rate is given."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ..arguments import Array, as_vector, check_name
from ..errors import DomainError, FormError
from ..kernels.compiling.recorded import Recorded, field, observable
from ..kernels.numbers.blocks import part
from .problem import Problem

__all__ = ["with_quadrature"]


def with_quadrature(problem: Problem, name: str, rate: Recorded) -> Problem:
    """Return the problem with one more number s, ṡ = rate(params, t, y, work), in its ODE form.

    So a time that runs at another rate, or an action, is integrated with the state by any method
    for ODEs, to its order.

    Parameters
    ----------
    problem : Problem
        One that has the ODE form.
    name : str
        What the number is called; it is the last piece of the state, and 0 at the beginning unless
        ``state`` gets it.
    rate : recorded ``f(params, t, y, work) -> number``
        As an observable of `problem`; in the problem's own time.

    Raises
    ------
    FormError
        If the problem has no ODE form.
    DomainError
        If it has a piece of that name.
    """
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    check_name("name", name)
    if not isinstance(rate, Recorded):
        raise DomainError("rate", rate, "a function recorded with geomint.observable")
    own = problem.field
    if own is None:
        raise FormError(f"problem {problem.name!r} has no ODE form: with_quadrature needs one")
    if name in dict(problem.pieces):
        raise DomainError("name", name, f"another name than {[n for n, _ in problem.pieces]}")
    rows = problem.rows

    def extended(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        state = part(y, 0, rows)
        own(params, t, state, part(out, 0, rows), work)
        out[rows] = rate(params, t, state, work)

    def restricted(f: Recorded) -> Recorded:
        def observed(params: Any, t: Any, y: Any, work: Any) -> Any:
            return f(params, t, part(y, 0, rows), work)

        return observable(observed)

    def value(params: Any, t: Any, y: Any, work: Any) -> Any:
        return 1.0 * y[rows]

    def make_state(**components: Any) -> Array:
        start = as_vector(name, components.pop(name, 0.0), 1)
        return np.concatenate([problem.state(**components), start])

    def admit(y: Array) -> Array:
        return np.concatenate([problem.canonical(y[:rows]), y[rows:]])

    return dataclasses.replace(
        problem,
        space=None,
        pieces=(*problem.pieces, (name, 1)),
        field=field(extended),
        action=None,
        hamiltonian=None,
        splitting=None,
        clock=None if problem.clock is None else restricted(problem.clock),
        invariants={key: restricted(f) for key, f in problem.invariants.items()},
        constraints={key: restricted(f) for key, f in problem.constraints.items()},
        observables={
            **{key: restricted(f) for key, f in problem.observables.items()},
            name: observable(value),
        },
        measure=None,
        make_state=make_state,
        admit=admit,
        physical=lambda y: problem.physical_state(y[:rows]),
    )
