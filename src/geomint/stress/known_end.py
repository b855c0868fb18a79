"""Where a run should end, and how much of a difference rounding alone explains.

The reference solution is that of `geomint.compare.reference`, in double-double numbers. How far a
problem magnifies roundings is measured: the reference is computed again from states and parameters
that are off by 2⁻²⁶, relative to their piece (2⁻⁴⁰ if that is too much), and the differences at the
end are divided by that. A reference that its own estimate, or the second method that confirms it
(`geomint.compare.confirmation`), does not let judge rounding errors is refused.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..compare.reference import integrate_extended, reference_solution
from ..errors import StepError
from ..kernels.numbers.blocks import Block
from ..methods import Gauss
from ..problems.deviation import pieces_of, relative_error, shifted, sizes_of
from ..problems.evaluate import derivative
from ..problems.problem import Problem
from ..problems.time_scale import jacobian
from ..watch.drift import ROUNDOFF

Named = dict[str, Array]
SHIFTS = (2.0**-26, 2.0**-40)
LINEAR = 0.1  # differences up to this are taken to be proportional to the shift
SAMPLES = 3
MANY = 60  # numbers in a state up to which all of them are shifted, one by one


class KnownEnd(NamedTuple):
    """The end of a run.

    Attributes
    ----------
    pieces : dict of name to array
        The state there, piece by piece, or physical quantities.
    condition : float
        At least 1: what a relative change of state and parameters grows to, relative, at the end.
    known, confirmed : float or None
        To what its own estimate says that it is known; and to what a second method confirms that.
    """

    pieces: Named
    condition: float
    known: float | None = None
    confirmed: float | None = None


def known_end(problem: Problem, y0: Array, end: float, physical: bool = False) -> KnownEnd:
    """Return the reference at the problem's own time `end`.

    Parameters
    ----------
    physical : bool
        In physical quantities instead of pieces of the state.

    Raises
    ------
    ConvergenceError, NonFiniteError, FormError
        If it cannot be computed.
    UnknownReferenceError
        If it is not known, or not confirmed, well enough to judge the rounding errors of a run.
    """
    named = functools.partial(Problem.physical_state if physical else pieces_of, problem)
    reference = reference_solution(problem, y0, end, judges=ROUNDOFF)
    h, second = 0.75 * Gauss(8).default_step(problem, y0, end), reference.confirmation

    def end_from(shifted: Problem, y: Array) -> Named:
        return named(integrate_extended(shifted, y, end, h)[: problem.rows].astype(np.float64))

    condition = condition_of(problem, y0, end_from)
    assert second is not None
    return KnownEnd(named(reference.y), condition, reference.known, second.accuracy)


def condition_of(problem: Problem, y0: Array, end_from: Callable[[Problem, Array], Named]) -> float:
    """Return what a relative change of state and parameters grows to at the end, at least 1.

    Infinity if even the smallest shift grows to the size of the state, or no run gets to its end.

    Parameters
    ----------
    end_from : callable
        Returns what is compared at the end, from a problem with other parameters and another state.
    """
    for shift in SHIFTS:
        ends = []
        for seed in range(SAMPLES):
            with contextlib.suppress(StepError):
                ends.append(end_from(*shifted(problem, y0, seed, shift)))
        # All are shifted: their differences are what one shift makes of another.
        errors = [relative_error(x, y) for x, y in itertools.combinations(ends, 2)]
        worst = max(errors, default=np.inf)
        if worst <= LINEAR:
            return max(1.0, worst / shift)
    return np.inf


@np.errstate(all="ignore")
def field_rounding(problem: Problem, y0: Array) -> float:
    """Return what rounding makes of the field at states next to y0, relative to pieces, per time.

    From a comparison with extended precision, where the platform has it and the state is not large: a
    linear system with parameters of very different size loses digits that no method can give back.
    """
    if problem.field is None or problem.rows > MANY:
        return 0.0
    found = [0.0]
    for seed in range(SAMPLES):
        near, y = shifted(problem, y0, seed, SHIFTS[0])
        double, extended = (_rates(near, y, number) for number in (np.float64, np.longdouble))
        found.append(float(np.max(np.abs(double - extended) / sizes_of(problem, y0))))
    return max(off for off in found if np.isfinite(off))


def _rates(problem: Problem, y: Array, number: Any) -> Any:
    out, work, time = np.zeros(problem.rows, number), np.zeros(problem.work, number), number(0.0)
    params, state = problem.params.astype(number), y.astype(number)
    problem.field(Block(params), time, Block(state), Block(out), Block(work))  # type: ignore[misc]
    return out


def separation_time(problem: Problem, y0: Array) -> float:
    """Return the time in which states next to y0 part by a factor e, at most.

    The inverse of the norm of the derivative of the field, each piece in its own unit: the largest
    number of it. Infinity for many numbers, whose motion is taken to be no faster than its rates.
    """
    if problem.rows > MANY:
        return np.inf
    sizes = sizes_of(problem, y0)
    slopes = jacobian(problem, y0, 0.0, derivative).T * sizes[:, None] / sizes
    norm = float(np.linalg.norm(slopes, np.inf))
    return 1.0 / norm if norm > 0.0 else np.inf
