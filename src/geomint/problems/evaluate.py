"""A problem's functions at single states, in plain Python: for checks, defaults and scales."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import FunctionType
from typing import Any

import numpy as np

from ..arguments import Array, as_array, finite
from ..errors import DomainError, nearest
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, scalar_block
from .declaration import check_form, check_value, known_rates
from .problem import Problem
from .watched_call import unwatched_call

__all__ = [
    "at_state",
    "compiled_derivative",
    "derivative",
    "observable_of",
    "rounding_scale",
    "scale_of",
    "states_around",
    "value",
    "vector",
]


def observable_of(problem: Problem, f: Recorded | FunctionType | str, y: Array) -> Recorded:
    """Return an observable of that name, or the given one, checked against the problem at a state."""
    if isinstance(f, str):
        known = problem.diagnostics
        if f not in known:
            some = f"one of {sorted(known)}.{nearest(f, known)}"
            none = f"a recorded function: problem {problem.name!r} has no quantities by name"
            raise DomainError("f", f, some if known else none)
        f = known[f]
    if not isinstance(f, Recorded | FunctionType):
        raise DomainError("f", f, "a name, or a function recorded with geomint.observable")
    f = f if isinstance(f, Recorded) else Recorded(f)
    check_value(problem, f, y)
    return f


@np.errstate(all="ignore")
def value(problem: Problem, f: Recorded | str, y: Array, t: float = 0.0) -> float:
    """Return an observable at a state: one of the problem's diagnostics by name, or a recorded one.

    Raises
    ------
    DomainError
        For a name that the problem does not have, or a state of other length.
    DeclarationError
        If the function does not fit the problem.
    """
    y = _flat(problem, y)
    f = observable_of(problem, f, y)
    work = Block(np.zeros(problem.work))
    return float(unwatched_call(problem.name, f, Block(problem.params), _time(t), Block(y), work))


@np.errstate(all="ignore")
def derivative(problem: Problem, y: Array, t: float = 0.0, form: str | None = None) -> Array:
    """Return dy/dt by a form that the problem has, one of `Problem.forms`; by default the first.

    Raises
    ------
    DomainError
        For a state of other length, or a form that the problem does not have.
    DeclarationError
        If the functions of that form do not fit the problem.
    """
    y, now = _flat(problem, y), _time(t)
    form = problem.forms[0] if form is None else form
    if form not in problem.forms:
        raise DomainError("form", form, f"one of {list(problem.forms)}")
    check_form(problem, form, y)
    if form == "field":
        assert problem.field is not None
        known = known_rates(problem, y) if now == 0.0 else None
        return vector(problem, problem.field, problem.rows, y, now) if known is None else known
    params, work = Block(problem.params), Block(np.zeros(problem.work))
    out = np.zeros(problem.rows)
    if form == "action":
        assert problem.action is not None
        group, tiny = problem.action.group, 1e-7
        xi = vector(problem, problem.action.generator, group.algebra_rows, y, now)
        size = tiny / max(float(np.max(np.abs(xi))), 1e-300)
        scratch = Block(np.zeros(group.work))
        group.act(Block(group.layout), Block(size * xi), Block(y), Block(out), scratch)
        out /= size
    elif form == "splitting":
        assert problem.splitting is not None
        tiny = np.float64(1e-7)
        increment = np.zeros(problem.rows)
        for k in range(problem.splitting.parts):
            problem.splitting.flow(k, params, now, tiny, Block(y), Block(increment), work)
            out += increment / tiny
    else:
        assert problem.hamiltonian is not None
        n = problem.rows // 2
        dq, dp = np.zeros(n), np.zeros(n)
        problem.hamiltonian.gradients(
            params, now, Block(y[:n]), Block(y[n:]), Block(dq), Block(dp), work
        )
        out[:n], out[n:] = dp, -dq
    return out


def compiled_derivative(problem: Problem) -> Callable[..., Array]:
    """Return a function with the bits of `derivative`: the field compiled for single numbers."""
    assert problem.field is not None
    state, rates = np.zeros(problem.rows), np.zeros(problem.rows)
    call = _field_call(problem.field, problem.field.fingerprint).copy()
    call.set(
        params=Block(problem.params),
        t=0.0,
        y=Block(state),
        out=Block(rates),
        work=scalar_block(problem.work),
    )

    def rate_at(_: Problem, y: Array, t: float = 0.0) -> Array:
        state[:] = y
        call(t=t)
        return rates.copy()

    return rate_at


@functools.lru_cache(maxsize=64)
def _field_call(field: Recorded, fingerprint: str) -> Call:
    """Return the field as Python calls it, without arguments; another one where it has changed."""
    return Bound(field, FIELD).call()


def vector(problem: Problem, f: Recorded, rows: int, y: Array, t: float = 0.0) -> Array:
    """Return what a function of the problem writes: a field, a generator, conditions."""
    out, work = np.zeros(rows), Block(np.zeros(problem.work))
    f(Block(problem.params), np.float64(t), Block(y), Block(out), work)
    return out


def at_state(problem: Problem, y: Any, t: Any) -> tuple[Array, np.float64]:
    """Return a state as a flat array, and a time, or raise `DomainError`."""
    return _flat(problem, y), _time(t)


def _flat(problem: Problem, y: Array) -> Array:
    """Return a state, finite or not, as an array of the problem's length."""
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    if type(y) is not np.ndarray or y.dtype != np.float64:
        y = as_array("y", y, f"a state of {problem.rows} numbers")
    if y.shape != (problem.rows,):
        raise DomainError("y", y, f"a state of {problem.rows} numbers")
    return y


def _time(t: Any) -> np.float64:
    return np.float64(t if isinstance(t, float) else finite("t", t))


def rounding_scale(problem: Problem, f: Recorded, y: Array) -> float:
    """Return max(|v|, Σ |y_i ∂v/∂y_i|): a rounding of every number of y changes v by ε times it."""
    return scale_of([value(problem, f, state) for state in states_around(y)], y)


def states_around(y: Array) -> Array:
    """Return the states at which `scale_of` needs a value, one a row: y, then pairs around it."""
    rows = np.flatnonzero(y)
    states = np.repeat(y[None, :], 1 + 2 * len(rows), axis=0)
    sizes, pairs = 1e-5 * np.abs(y[rows]), 1 + 2 * np.arange(len(rows))
    states[pairs, rows] += sizes
    states[pairs + 1, rows] -= sizes
    return states


@np.errstate(all="ignore")
def scale_of(values: Any, y: Array) -> float:
    """Return the `rounding_scale` of what has those values at the `states_around` y."""
    around = np.asarray(values, dtype=np.float64)
    v, q = float(around[0]), y[np.flatnonzero(y)]
    size = 1e-5 * np.abs(q)
    up, down = around[1::2] - v, around[2::2] - v
    # A norm has a kink where it is 0: there the difference of the two sides misses the slope.
    rises = np.abs(q) * np.maximum(np.abs(up - down), np.abs(up + down))
    terms = rises[size > 0.0] / ((q + size) - (q - size))[size > 0.0]
    total = float(np.cumsum(terms)[-1]) if len(terms) else 0.0  # in order, to the same bits always
    scale = max(abs(v), total)
    return scale if np.isfinite(scale) and scale > 0.0 else 1.0
