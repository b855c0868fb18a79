r"""The same motions in another time: dt = σ(y) dτ, after Sundman.

Even steps of τ are uneven ones of t, long where σ is large. The field σ(y) f(y) has the orbits and the
invariants of f. A symmetric method is symmetric for it, too, and where f is reversible and σ is the
same at the reversed state the whole map is: so long runs keep what they keep at a fixed step, which
step control by the past does not allow (Hairer, Lubich, Wanner, *Geometric Numerical Integration*,
VIII.2). Quadratic invariants are kept to rounding by Gauss methods. An invariant density μ of f is
μ/σ in τ. Not kept is the symplectic structure: σ f is Hamiltonian on one level of the energy only,
for σ (H − H(y₀)).

A step density for motions of any kind is how fast a state moves, its pieces made comparable. With
v² = ε + Σ_k w_k \|ẏ_k\|² over the pieces of the state, σ = v^(−5/8) is the clock ``"speed"`` of
`geomint.time_transformed`. It depends on the state alone and is the same for the reversed motion.

The exponent −1 gives steps of equal arc length. But what good steps are along a motion that turns
sharply here and runs straight there is nearer to −2/3: the time r of eccentric anomaly on an ellipse
of Kepler's, where acceleration is r⁻², and N = \|A⁻¹x\|² on an ellipsoid, where it is N^(−3/2), in
which the coordinates are quotients of theta functions. Two square roots of square roots make −5/8.
"""

import dataclasses
import functools
import math
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import DomainError, FormError, nearest
from ..kernels.compiling.recorded import Recorded, helper, named_as, observable
from ..kernels.compiling.signatures import VALUE
from ..kernels.numbers.arithmetic import like, sqrt
from ..kernels.numbers.blocks import part
from ..kernels.numbers.exponential import log
from .evaluate import derivative, value
from .forms import GroupAction, Measure
from .problem import Problem
from .quadrature import quantities
from .spaces.repair import length
from .time_scale import PARTS, characteristic_time, names_time

# Of v² at y0. Where the motion nearly rests steps end at 2^(12.5) times those at y0.
SLOWEST = 2.0**-40


@helper
def pace(weights, sizes, rates):
    """Return v^(−5/8), the weights of the pieces and ε being given."""
    squared = 0.0 * rates[0] + weights[len(sizes)]
    first = 0
    for k in range(len(sizes)):
        piece = rates[first] * rates[first]
        for i in range(first + 1, first + sizes[k]):
            piece += rates[i] * rates[i]
        squared += weights[k] * piece
        first += sizes[k]
    fourth = sqrt(sqrt(squared))
    return 1.0 / (fourth * sqrt(sqrt(fourth)))


def pace_parameters(problem: Problem, y0: Array) -> Array:
    """Return the weights of the pieces, and ε: v = 1 at y0.

    A piece is measured by its size there, or by what its rate makes of it within the characteristic
    time, if that is more: pieces may begin at rest.
    """
    rates = derivative(problem, y0)
    time = characteristic_time(problem, y0)
    sizes, speeds = [], []
    for rows in problem.slices.values():
        speed = length(rates[rows])
        sizes.append(max(length(y0[rows]), time * speed))
        speeds.append(speed)
    shares = [
        (speed / size) if size > 0.0 else 0.0 for speed, size in zip(speeds, sizes, strict=True)
    ]
    whole = float(np.linalg.norm(shares))
    if whole == 0.0:  # an equilibrium
        return np.array([*(0.0 for _ in sizes), 1.0])
    scale = np.sqrt(1.0 - SLOWEST) / whole
    weights = [(scale / size) ** 2 if size > 0.0 else 0.0 for size in sizes]
    return np.array([*weights, SLOWEST])


SPEED = "speed"


def time_transformed(problem: Problem, clock: Any = SPEED, y0: Any = None) -> Problem:
    r"""Return the problem in another time τ, in which even steps are uneven ones of its own.

    Parameters
    ----------
    problem : Problem
        One that has the ODE form or that of a group; they are what the new problem offers. It must
        not depend on time explicitly.
    clock : str or recorded ``f(params, t, y, work) -> number``
        σ(y) = dt/dτ > 0, smooth; best about as large as a good step is there, or somewhat more even:
        one of the problem's quantities by name, or a function. ``"speed"``, the default, needs a
        field, and y0: σ = (ε + Σ_k w_k \|ẏ_k\|²)^(−5/16) over the pieces y_k of the state,
        `geomint.problems.time_transformation`.
    y0 : array_like, optional
        A state of the motion, for ``"speed"``: the weights w_k make pieces comparable there, and σ = 1,
        so that steps are those of the problem's own time there.

    Returns
    -------
    Problem
        In τ, with dt/dτ as its clock: ends, events, and states are wanted at times t as ever. It has
        the same states, invariants, constraints and observables, the measure of density μ/σ, and
        neither a Hamiltonian or splitting form, nor an exact flow.

    Raises
    ------
    DomainError
        For a name that the problem does not have, a clock that is not > 0 at y0, and where
        ``"speed"`` has no y0.
    FormError
        For a problem that has no such form, or depends on time.

    Notes
    -----
    K. F. Sundman, Acta Math. 36 (1913) 105. Of a problem that has a time τ already, `clock` is the rate
    of that time by the new one, and t goes on beside it.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("ellipsoid-n4")
    >>> uneven = gi.time_transformed(scene.problem, "normal_squared")
    >>> uneven.time, uneven.forms
    ('tau', ('field',))
    """
    if not isinstance(problem, Problem):
        raise DomainError("problem", problem, "a geomint.Problem")
    if problem.field is None and problem.action is None:
        what = (
            f"offers {', '.join(problem.forms)}: a time transformation needs a field or an action"
        )
        raise FormError(f"problem {problem.name!r} {what}")
    state = None if y0 is None else problem.canonical(y0)
    rate, more = _rate_of(problem, clock, state)
    _check_autonomous(problem, state)
    own = len(problem.params)
    of_own = functools.partial(_of_own, own if len(more) else None)
    rate = rate if len(more) else of_own(rate)
    field, action, measure = problem.field, problem.action, problem.measure
    if measure is not None:
        manifold = measure.manifold and _written(measure.manifold, own)
        density = _density(of_own(measure.log_density), rate)
        measure = Measure(density, manifold, measure.conditions)
    old = problem.clock
    joint = rate if problem.time == "t" else old and _product(of_own(old), rate)

    name = clock if isinstance(clock, str) else rate.function.__name__
    result = dataclasses.replace(
        problem,
        name=f"{problem.name}-by-{name}",
        params=np.concatenate((problem.params, more)),
        field=field and _scaled_field(field, rate, own),
        action=action and GroupAction(_scaled_field(action.generator, rate, own), action.group),
        hamiltonian=None,
        splitting=None,
        symplectic_form=None,
        make_exact=None,
        work=problem.work + problem.rows,
        time="tau",
        clock=joint,
        measure=measure,
        equations=(
            *problem.equations,
            f"d{'t' if problem.time == 't' else 'τ′'} = σ dτ,  σ: {name}",
        ),
        **quantities(problem, of_own),
    )
    if state is not None:
        there = value(result, rate, state)
        if not 0.0 < there < math.inf:
            raise DomainError(
                "clock", clock, f"a clock > 0 and finite at y0, where it is {there:g}"
            )
    return result


def _rate_of(problem: Problem, clock: Any, state: Array | None) -> tuple[Recorded, Array]:
    """Return dt/dτ, and the parameters that it has after those of the problem."""
    known, none = problem.diagnostics, np.zeros(0)
    if isinstance(clock, Recorded):
        return clock, none
    name = clock if isinstance(clock, str) else ""
    if name in known:
        return known[name], none
    if name != SPEED:
        expected = f"{SPEED!r}, a recorded function, or one of {sorted(known)}"
        hint = nearest(name, [SPEED, *known]) if name else ""
        raise DomainError("clock", clock, f"{expected}.{hint}")
    if problem.field is None:
        raise FormError(f"clock {SPEED!r} needs a field, which problem {problem.name!r} has not")
    if state is None:
        raise DomainError("y0", ..., f"a state of the motion, for the clock {SPEED!r}")
    sizes = tuple(rows for _, rows in problem.pieces)
    return _speed(problem.field, sizes, len(problem.params)), pace_parameters(problem, state)


def _check_autonomous(problem: Problem, state: Array | None) -> None:
    """Raise `FormError` if what names its time depends on it: at another time its bits are others."""
    functions = (*problem.diagnostics.values(), *((problem.clock,) if problem.clock else ()))
    naming = [f for f in functions if VALUE.reads(f, "t")]
    if not naming and not names_time(problem):
        return
    y = problem.random_state(0) if state is None and problem.make_random is not None else state
    if y is None:
        what = f"a state, to see whether {problem.name!r} depends on time"
        raise DomainError("y0", ..., what)
    for t in (1e-3, *PARTS[::3], 1e3):
        moved = derivative(problem, y, t).tobytes() != derivative(problem, y, 0.0).tobytes()
        if moved or any(value(problem, f, y, t) != value(problem, f, y, 0.0) for f in naming):
            what = "depends on time explicitly: it has no other time"
            raise FormError(f"problem {problem.name!r} {what}")


@functools.cache
def _speed(field: Recorded, sizes: tuple[int, ...], own: int) -> Recorded:
    """Return the clock "speed" of a field, whose parameters come first."""
    rows, pieces = sum(sizes), len(sizes)

    def speed(params, t, y, work):
        rates = part(work, 0, rows)
        field(part(params, 0, own), like(0.0, y[0]), y, rates, part(work, rows, len(work) - rows))
        return pace(part(params, own, pieces + 1), sizes, rates)

    return observable(speed)


@functools.cache
def _of_own(own: int | None, f: Recorded) -> Recorded:
    """Return an observable that gets only the parameters it knows, and no time of another clock."""
    if own is None and not VALUE.reads(f, "t"):
        return f

    def observed(params, t, y, work):
        known = params if own is None else part(params, 0, own)
        return f(known, like(0.0, y[0]), y, work)

    return named_as(observed, f)


@functools.cache
def _written(f: Recorded, own: int) -> Recorded:
    """Return a function that writes, with only the parameters it knows."""

    def written(params, t, y, out, work):
        f(part(params, 0, own), like(0.0, y[0]), y, out, work)

    return named_as(written, f)


@functools.cache
def _density(log_density: Recorded, rate: Recorded) -> Recorded:
    """Return log(μ/σ)."""

    def density(params, t, y, work):
        return log_density(params, t, y, work) - log(rate(params, t, y, work))

    return observable(density)


@functools.cache
def _product(first: Recorded, second: Recorded) -> Recorded:
    """Return the product of two clocks."""

    def product(params, t, y, work):
        return first(params, t, y, work) * second(params, t, y, work)

    return observable(product)


@functools.cache
def _scaled_field(f: Recorded, rate: Recorded, own: int) -> Recorded:
    """Return σ f."""

    def scaled(params, t, y, out, work):
        f(part(params, 0, own), like(0.0, y[0]), y, out, work)
        sigma = rate(params, t, y, work)
        for i in range(len(out)):
            out[i] = sigma * out[i]

    return named_as(scaled, f)
