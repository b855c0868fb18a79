"""A problem's functions at single states, in plain Python: for checks, defaults and scales."""

import math
import threading
from collections.abc import Callable
from functools import partial
from types import FunctionType
from typing import Any

import numpy as np

from ..arguments import Array, as_array, finite, numbers_of
from ..errors import DeclarationError, DomainError, nearest
from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import (
    ACTION,
    CONSTRAINT,
    FIELD,
    FLOW,
    GRADIENTS,
    VALUE,
    Signature,
)
from ..kernels.numbers.blocks import Block, scalar_block
from .bound import bound, called, given_at
from .declaration import check_form, check_value, kept_with
from .formulas import is_formula
from .groups import own_sizes
from .problem import Problem
from .spaces.repair import length, repaired
from .watched_call import unwatched_call

Rate = Callable[[Problem, Array, float], Array]
Value = Callable[[Array, float], float]
SPACING, TINY = 1e-5, 1e-300  # of sizes: over which velocities of constraints change
REPAIRS, PROJECTS = 3, 12  # steps of Newton's method


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
    call, now = partial(unwatched_call, problem.name, f), _time(t)
    return float(VALUE.run(call, params=problem.params, t=now, y=y, work=problem.work))


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
    return _RATES[form](problem, False)(problem, y, now)


def rates_of(problem: Problem, y: Array, compiled: bool = True) -> Rate:
    """Return `derivative`, or compiled code with its bits, kept with the problem.

    Raises
    ------
    DeclarationError
        If the functions of the first form do not fit the problem, which is seen at y.
    """
    if not compiled:
        return derivative
    form = problem.forms[0]
    return _of_code(problem, check_form(problem, form, y), _RATES[form], True, derivative)


def value_of(problem: Problem, f: Recorded, y: Array, compiled: bool = True) -> Value:
    """Return an observable as a function of state and time, as `rates_of` returns the derivative."""
    plain = partial(value, problem, f)
    if not compiled:
        return plain
    return _of_code(problem, check_value(problem, f, y), _value, f, plain)


def _of_code(problem: Problem, key: Any, make: Any, of: Any, plain: Any) -> Any:
    """Return what is made of compiled code, once; the plain function where that cannot be."""

    def made() -> Any:
        try:
            return make(problem, of)
        except (DeclarationError, DomainError):
            return plain

    return kept_with(problem, (key, threading.get_ident()), made)  # what it changes is a thread's


def _value(problem: Problem, f: Recorded) -> Value:
    call, state = _call(problem, True, f, VALUE)

    def number(y: Array, t: float) -> float:
        state[:] = y
        return float(call(t=t))

    return number


def _call(
    problem: Problem, compiled: bool, f: Recorded, signature: Signature, **rows: int
) -> tuple[Any, ...]:
    """Return `called`: compiled, if the function is a formula."""
    known = bound(problem, f, signature, **rows)
    return called(problem, known, compiled and is_formula(problem, known))


def _field_rates(problem: Problem, compiled: bool) -> Rate:
    assert problem.field is not None
    call, state, rates = _call(problem, compiled, problem.field, FIELD)

    def field_rates(_: Problem, y: Array, t: float = 0.0) -> Array:
        state[:] = y
        call(t=t)
        return rates.copy()

    return field_rates


def _action_rates(problem: Problem, compiled: bool) -> Rate:
    """Return the difference quotient of a move by the generator over a tiny time."""
    assert problem.action is not None
    group, tiny = problem.action.group, 1e-7
    generator = problem.action.generator
    call, state, xi = _call(problem, compiled, generator, FIELD, out=group.algebra_rows)
    element, moved = np.zeros(group.algebra_rows), np.zeros(problem.rows)
    act = Bound(group.act, ACTION).call(compiled and own_sizes(group) is not None)
    act.set(layout=Block(group.layout), xi=Block(element), y=Block(state), out=Block(moved))
    act.set(work=scalar_block(group.work))

    def action_rates(_: Problem, y: Array, t: float = 0.0) -> Array:
        state[:] = y
        call(t=t)
        size = tiny / max(float(np.max(np.abs(xi))), 1e-300)
        element[:] = size * xi
        act()
        return moved / size

    return action_rates


class _Constrained:
    """A Hamiltonian form at single states: rates without the force of the constraints, and this."""

    def __init__(self, problem: Problem, compiled: bool) -> None:
        form = problem.hamiltonian
        assert form is not None
        self._move, *self._moved = _call(problem, compiled, form.gradients, GRADIENTS)
        self._hold, *self._held = _call(problem, compiled, form.constraint, CONSTRAINT)

    @np.errstate(all="ignore")
    def at(self, y: Array, t: float) -> tuple[Array, Array, Array]:
        """Return (q̇, ṗ) without that force, the constraints, and their Jacobian."""
        (q, p, dq, dp), (at, g, G), n = self._moved, self._held, len(y) // 2
        q[:], p[:], at[:] = y[:n], y[n:], y[:n]
        self._move(t=t)
        self._hold()
        return np.concatenate([dp, -dq]), g.copy(), G.reshape(len(g), n).copy()

    def push(self, y: Array, t: float, change: Array) -> Array:
        """Return ``Gᵀλ`` with ``G H_pp Gᵀ λ = change``: p less it has velocities G H_p less that."""
        n, (_, _, G) = len(y) // 2, self.at(y, t)
        ways = np.hstack([np.zeros_like(G), G]) / (np.abs(G).max(axis=1, keepdims=True) + TINY)
        response = [self.change(y, t, way, 1.0 / (length(y[n:]) or 1.0), 0.0) for way in ways]
        if not np.isfinite([change, *response]).all():
            return np.full(n, np.nan)
        return np.linalg.lstsq(np.transpose(response), change)[0] @ ways[:, n:]

    def change(self, y: Array, t: float, way: Array, fastest: float, pace: float = 1.0) -> Array:
        """Return how fast G H_p changes that way, by a difference: exact if it is quadratic."""
        by, ends = SPACING / (fastest or 1.0), []
        for s in (by, -by):
            rates, _, G = self.at(y + s * way, t + s * pace)
            ends.append(G @ rates[: len(rates) // 2])
        return (ends[0] - ends[1]) / (2.0 * by)


def _hamiltonian_rates(problem: Problem, compiled: bool) -> Rate:
    motion, n = _Constrained(problem, compiled), problem.rows // 2

    def hamiltonian_rates(_: Problem, y: Array, t: float = 0.0) -> Array:
        rates = motion.at(y, t)[0]
        speeds = [length(rates[k]) / (length(y[k]) or np.inf) for k in (slice(n), slice(n, None))]
        rates[n:] -= motion.push(y, t, motion.change(y, t, rates, max(speeds)))
        return rates

    return hamiltonian_rates


def on_constraints(problem: Problem, y: Array, projected: bool = False) -> Array:
    """Return a state on the constraints of a Hamiltonian, repaired if need be as those of spaces are.

    Or `projected`, from wherever it is.

    Constraints are measured beside what all of q would change them by, their velocities likewise.

    Raises
    ------
    DomainError
        For a state that is far from them.
    """
    n, form = len(y) // 2, check_form(problem, "hamiltonian", y)
    times = PROJECTS if projected else REPAIRS
    key = ("constrained", *form, threading.get_ident())
    motion = kept_with(problem, key, lambda: _Constrained(problem, False))

    @np.errstate(all="ignore")
    def defect(off: Array, G: Array, by: Array) -> float:
        share = np.abs(off) / np.maximum(np.abs(off), np.abs(G).sum(axis=1) * length(by))
        return float(np.max(np.where(off == 0.0, 0.0, share)))

    def placed() -> Array:
        z = y.copy()
        for _ in range(times):
            _, g, G = motion.at(z, 0.0)
            z[:n] -= np.linalg.lstsq(G, g)[0]
        return z

    def turned() -> Array:
        z = y.copy()
        for _ in range(times):
            rates, _, G = motion.at(z, 0.0)
            z[n:] -= motion.push(z, 0.0, G @ rates[:n])
        return z

    q, p = problem.pieces[0][0], problem.pieces[-1][0]
    rates, g, G = motion.at(y, 0.0)
    beside = "g(q) beside |G||q|"
    mend: Callable[..., Array] = (lambda *told: told[-1]()) if projected else repaired
    near = mend(q, y, defect(g, G, y[:n]), beside, "a state with g(q) = 0", placed)
    if near is not y:
        y, (rates, _, G) = near, motion.at(near, 0.0)
    said, expected = "G ∂H/∂p beside |G||∂H/∂p|", "a state whose velocities keep g(q) = 0"
    return mend(p, y, defect(G @ rates[:n], G, rates[:n]), said, expected, turned)


def _splitting_rates(problem: Problem, compiled: bool) -> Rate:
    assert problem.splitting is not None
    n, parts, tiny = problem.rows, problem.splitting.parts, np.float64(1e-7)
    call, state, increment = _call(problem, compiled, problem.splitting.flow, FLOW)

    def splitting_rates(_: Problem, y: Array, t: float = 0.0) -> Array:
        state[:], total = y, np.zeros(n)
        for k in range(parts):
            call(k=k, t=t, h=tiny)
            total += increment / tiny
        return total

    return splitting_rates


_RATES = {
    "field": _field_rates,
    "action": _action_rates,
    "hamiltonian": _hamiltonian_rates,
    "splitting": _splitting_rates,
}


def vector(problem: Problem, f: Recorded, rows: int, y: Array, t: float = 0.0) -> Array:
    """Return what a function of the problem writes: a field, a generator, conditions."""
    (out,) = FIELD.run(f, **given_at(problem, y, t=np.float64(t), out=rows))
    return np.asarray(out)


def at_state(problem: Problem, y: Any, t: Any) -> tuple[Array, np.float64]:
    """Return a state as a flat array, and a time, or raise `DomainError`."""
    return _flat(problem, y), _time(t)


def _flat(problem: Problem, y: Array) -> Array:
    """Return a state, finite or not, as an array of the problem's length."""
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    if type(y) is not np.ndarray or y.dtype != np.float64:
        y = as_array("y", y, f"a state of {numbers_of(problem.rows)}")
    if y.shape != (problem.rows,):
        raise DomainError("y", y, f"a state of {numbers_of(problem.rows)}")
    return y


def _time(t: Any) -> np.float64:
    return np.float64(t if isinstance(t, float) else finite("t", t))


def rounding_scale(problem: Problem, f: Recorded, y: Array) -> float:
    """Return max(|v|, Σ |y_i ∂v/∂y_i|): a rounding of every number of y changes v by ε times it."""
    return scales_of([[value(problem, f, state) for state in states_around(y)]], y)[0]


def states_around(y: Array) -> Array:
    """Return the states at which `scales_of` needs a value, one a row: y, then pairs around it."""
    rows = y.nonzero()[0]
    states = np.empty((1 + 2 * len(rows), len(y)))
    states[:] = y
    size = 1e-5 * np.abs(y)
    numbers = states.reshape(-1)
    first = len(y) + rows + 2 * len(y) * np.arange(len(rows))  # of each pair its own number
    numbers[first] = (y + size)[rows]
    numbers[first + len(y)] = (y - size)[rows]
    return states


@np.errstate(all="ignore")
def scales_of(values: Any, y: Array) -> list[float]:
    """Return the `rounding_scale` of what has those values at the `states_around` y, one a row."""
    around = np.asarray(values, dtype=np.float64)
    # Terms know no unit of y: the mantissas serve, whose products do not overflow.
    v, q = around[:, :1], np.frexp(np.abs(y[y.nonzero()[0]]))[0]
    size = 1e-5 * q
    up, down = around[:, 1::2] - v, around[:, 2::2] - v
    # A norm has a kink where it is 0: there the difference of the two sides misses the slope.
    terms = q * np.maximum(np.abs(up - down), np.abs(up + down)) / ((q + size) - (q - size))
    first = np.abs(around[:, 0]).tolist()
    # In order, to the same bits always.
    totals = terms.cumsum(axis=1)[:, -1].tolist() if terms.shape[1] else [0.0] * len(first)
    scales = [max(one, total) for one, total in zip(first, totals, strict=True)]
    return [scale if 0.0 < scale < math.inf else 1.0 for scale in scales]
