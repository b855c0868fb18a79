"""How far a run is from the motion: what a second run with finer steps says of it.

With half the step a method of order p errs 2⁻ᵖ times as much, so that the difference of both runs is
1 − 2⁻ᵖ of the first one's error (L. F. Richardson), its rounding included, which is another one in the
second run. Where a step is so long that the order is not seen yet, the second run is better still and
the difference is the error itself. A state within the first step has been reached by one shorter step,
and is compared with one that more, still shorter ones lead to.
"""

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arguments import Array
from ..errors import DomainError, Gathered, LeftOutWarning, StepError, tell
from ..methods.adaptive import LEAST_RTOL, Adaptive
from ..methods.method import Method
from .restart import Restart
from .solution import Solution

FINER = 16.0  # times smaller tolerances


def check_estimate(asked: bool, before: Restart | None) -> None:
    """Raise `DomainError` where only a part of the run is known."""
    if asked and before is not None:
        expected = "False: what goes on has errors from before, and is estimated as one run"
        raise DomainError("estimate_error", asked, expected)


def error_estimate(
    solution: Solution, again: Callable[..., Solution], begin: float
) -> Array | None:
    """Return the estimated error of every saved state, or None and a warning where there is none.

    Parameters
    ----------
    solution : Solution
        A run from its beginning.
    again : callable
        Solves the same problem from the same state with what it is given.
    begin : float
        The time where the run began, as it is labelled: see `label`.
    """
    if solution.status not in ("success", "not finite"):
        return None
    name, times = label(solution)
    if not len(times) or times[-1] == begin:
        return np.zeros_like(solution.y)
    options, factor = finer(solution.method, solution.step)
    finer_states, reason = solution.y.copy(), ""
    try:
        with Gathered(quiet=True):  # said of the run itself
            for rows, step in _parts(solution, begin if solution.problem.time == "t" else 0.0):
                some, own = times[rows], {} if step is None else {"step": step}
                ends = {f"{name}_end": some[-1], f"{name}_eval": some}
                other = again(**ends, **{**options, **own})
                if other.status == "interrupted":
                    reason = "was interrupted"
                    break
                finer_states[rows] = other.y
    except StepError as error:
        reason = f"failed: {error}"
    if reason:
        tell(
            LeftOutWarning(
                f"no error estimate: the run with finer steps {reason}", "error_estimate"
            )
        )
        return None
    return factor * (solution.y - finer_states)


def _parts(solution: Solution, start: float) -> Iterator[tuple[NDArray[np.bool_], float | None]]:
    """Yield which states are compared with one finer run, and its step if that is an own one.

    States within the first step have runs of their own, each for those within a factor of 2 in time.
    """
    spans = np.abs(solution.tau - start)
    first = float(solution.step_sizes.max) * (1.0 - 1e-9)
    early = (spans > 0.0) & (spans < first)
    powers = np.where(early, np.frexp(spans)[1], 0)
    for power in np.unique(powers[early]):
        rows = early & (powers == power)
        yield rows, 0.5 * float(spans[rows].min())
    if not early.all():
        yield ~early, None


def label(solution: Solution) -> tuple[str, Array]:
    """Return the times at which states are compared: those that the end was given in."""
    if solution.problem.time == "tau" and solution.drift_time == "tau":
        return "tau", solution.tau
    return "t", solution.t


def finer(method: Method, step: float) -> tuple[dict[str, Any], float]:
    """Return options of a finer run, and what its difference is multiplied with."""
    if isinstance(method, Adaptive):
        rtol = max(method.rtol / FINER, LEAST_RTOL)
        chosen = dataclasses.replace(method, rtol=rtol, atol=method.atol / FINER)
        return {"method": chosen}, 1.0 / (1.0 - 1.0 / FINER)
    return {"method": method, "step": 0.5 * abs(step)}, 1.0 / (1.0 - 0.5**method.order)
