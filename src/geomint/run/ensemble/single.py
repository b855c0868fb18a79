"""Members one after the other, each by `geomint.solve`: what all others are held to."""

import math
from collections.abc import Iterable

import numpy as np

from ...arguments import Array
from ...errors import Gathered, GeomintError, StepError
from ...methods import Exact
from ..callback import Ending
from ..solution import Solution
from ..solve import solve
from .given import Asked, Members
from .outcome import Outcome


def run_single(
    asked: Asked,
    given: Members,
    which: Iterable[int],
    stop: Array,
    found: Outcome,
    strict: bool = False,
) -> None:
    """Run some members, and write what has become of each to `found`.

    Where `stop` ends it, nothing is written of the member that is under way.

    Raises
    ------
    GeomintError
        If `strict`, for what is no step that failed, but that a run cannot begin.
    """
    # In the main thread Ctrl-C itself ends a run, and an exact motion has no steps to end after.
    alone = strict or isinstance(asked.method, Exact)
    look = Ending(stop)
    callback = None if alone else look
    for k in which:
        if stop[0] != 0.0:
            return
        solution: Solution | None
        try:
            with Gathered(quiet=True):  # `solve_ensemble` tells of all members
                solution = solve(
                    given.problem(k), given.states[k], callback=callback, **asked.arguments()
                )
        except GeomintError as error:
            if strict and not isinstance(error, StepError):
                raise
            if look.ended:
                return
            found.errors[k], found.status[k] = error, "failed"
            solution = getattr(error, "partial", None)
        if look.ended:
            return
        if solution is not None:
            _write(found, k, solution)


def _write(found: Outcome, k: int, solution: Solution) -> None:
    count = len(solution.tau)
    found.widened(count)
    here = slice(0, count)
    found.tau[k], found.y[k], found.physical[k] = math.nan, math.nan, math.nan
    found.tau[k, here], found.y[k, here] = solution.tau, solution.y
    if solution.physical is not None:
        found.physical[k, here] = solution.physical
    if solution.error_estimate is not None:
        if found.error_estimate is None:
            found.error_estimate = np.full_like(found.y, np.nan)
        found.error_estimate[k, here] = solution.error_estimate
    found.counts[k], found.steps[k], found.status[k] = count, solution.steps, solution.status
    if solution.warnings:
        found.warnings[k] = solution.warnings
    if solution.drift:
        found.drift[k] = solution.drift
    if solution.events:
        found.events[k] = solution.events
