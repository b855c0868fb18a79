"""Where a run should end, and how much of a difference rounding alone explains.

The reference solution is that of `geomint.compare.reference`, in double-double numbers. How far a
problem magnifies roundings is measured: the reference is computed again from states and parameters
that are off by 2⁻²⁶, relative to their piece (2⁻⁴⁰ if that is too much), and the differences at the
end are divided by that. A reference that its own estimate, or the second method that confirms it
(`geomint.compare.confirmation`), does not let judge rounding errors is refused.
"""

from __future__ import annotations

import contextlib
import dataclasses
import itertools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..arguments import Array
from ..compare.reference import integrate_extended, reference_solution
from ..errors import StepError
from ..kernels.numbers.blocks import Block
from ..methods import Gauss
from ..problems.deviation import pieces_of, relative_error, shifted, sizes_of
from ..problems.evaluate import derivative
from ..problems.problem import Problem
from ..watch.drift import ROUNDOFF

Named = dict[str, Array]
SHIFTS = (2.0**-26, 2.0**-40)
LINEAR = 0.1  # differences up to this are taken to be proportional to the shift
SAMPLES = 3
MANY = 60  # numbers in a state up to which all of them are shifted, one by one


@dataclasses.dataclass(frozen=True)
class KnownEnd:
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

    def scaled(self, factors: Mapping[str, float]) -> KnownEnd:
        """Return the same in other units."""
        pieces = {name: factors.get(name, 1.0) * v for name, v in self.pieces.items()}
        return dataclasses.replace(self, pieces=pieces)


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

    def named(y: Array) -> Named:
        return problem.physical_state(y) if physical else pieces_of(problem, y)

    reference = reference_solution(problem, y0, end, judges=ROUNDOFF)
    second = reference.confirmation
    assert second is not None
    h = 0.75 * Gauss(8).default_step(problem, y0, end)

    def from_other(shifted: Problem, y: Array) -> Array:
        return integrate_extended(shifted, y, end, h)[: problem.rows].astype(np.float64)

    condition = condition_of(problem, y0, from_other, named)
    return KnownEnd(named(reference.y), condition, reference.known, second.accuracy)


def condition_of(
    problem: Problem,
    y0: Array,
    end_from: Callable[[Problem, Array], Array],
    named: Callable[[Array], Named],
) -> float:
    """Return what a relative change of state and parameters grows to at the end, at least 1.

    Infinity if even the smallest shift grows to the size of the state, or no run gets to its end.

    Parameters
    ----------
    end_from : callable
        Returns the state at the end, from a problem with other parameters and another state.
    named : callable
        Returns what of a state is compared.
    """
    for shift in SHIFTS:
        ends = []
        for seed in range(SAMPLES):
            with contextlib.suppress(StepError):
                ends.append(named(end_from(*shifted(problem, y0, seed, shift))))
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
    worst, sizes = 0.0, sizes_of(problem, y0)
    for seed in range(SAMPLES):
        near, y = shifted(problem, y0, seed, SHIFTS[0])
        rates: list[Any] = []
        for number in (np.float64, np.longdouble):
            out = np.zeros(problem.rows, number)
            work = Block(np.zeros(problem.work, number))
            params = Block(np.array(near.params, number))
            problem.field(params, number(0.0), Block(y.astype(number)), Block(out), work)
            rates.append(out)
        off = float(np.max(np.abs(rates[0] - rates[1]) / sizes))
        worst = max(worst, off if np.isfinite(off) else 0.0)
    return worst


def separation_time(problem: Problem, y0: Array) -> float:
    """Return the time in which states next to y0 part by a factor e, at most.

    The inverse of the norm of the derivative of the field, each piece in its own unit: the largest
    number of it. Where there are many numbers the norm is sampled in some directions.
    """
    n, sizes = problem.rows, sizes_of(problem, y0)
    directions = np.eye(n)
    if n > MANY:
        directions = np.random.default_rng(0).choice([-1.0, 1.0], (SAMPLES, n))
    center = derivative(problem, y0)
    changes = [derivative(problem, y0 + SHIFTS[0] * sizes * d) - center for d in directions]
    columns = np.array(changes) / (SHIFTS[0] * sizes)
    norm = float(np.linalg.norm(columns, np.inf)) / (n if n > MANY else 1)
    return 1.0 / norm if norm > 0.0 else np.inf
