"""Runs that begin anew, with a shorter step, until errors are what they shall be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..errors import StepError
from .accuracy.asked import TOO_LONG
from .accuracy.choose import Chosen
from .error_estimate import label
from .growth import end_error, growth, met
from .promise import FEW_STEPS, MOST_STEPS, Default
from .solution import Solution

__all__ = ["begun_anew"]

ATTEMPTS, FAILURES = 14, 8  # runs with shorter steps, and those that may fail
GUESSED = 2  # failures that are said to be those of a guess: Newton's method takes no step before
CONFIRMED = 4  # second runs, and those with shorter steps after them
QUIET: dict[str, Any] = {
    **{"t_eval": None, "tau_eval": None, "dense": False, "events": None, "save_every": None},
    **{"observe": (), "callback": None, "estimate_error": False, "progress": False},
}

Solved = Callable[..., Solution]


def begun_anew(
    solved: Solved, chosen: Chosen | Default, named: Mapping[str, Any]
) -> tuple[Solution, Chosen | Default]:
    """Return what `solved` does with a step, or shorter ones, until errors are what they shall be.

    A callback sees one run.
    """
    failures, most = 0, MOST_STEPS if named["compiled"] else FEW_STEPS
    for left in reversed(range(ATTEMPTS)):
        one = named["callback"] is not None or not left
        by = chosen.asked
        if one or failures > GUESSED:
            by["turning"] = True
        try:
            solution = solved(**named, **by)
        except TOO_LONG as error:
            failures += 1
            shorter = error.partial and chosen.shorter(error.partial, most)
            if one or shorter is None or failures > FAILURES:
                raise
        else:
            if one or not solution.success or chosen.kept(solution):
                break
            shorter = chosen.shorter(solution, most)
            if shorter is None:
                break
        chosen = shorter
    return _with_growth(solution, solved, chosen, named, most)


def _with_growth(
    found: Solution,
    solved: Solved,
    chosen: Chosen | Default,
    named: Mapping[str, Any],
    most: float,
) -> tuple[Solution, Chosen | Default]:
    """Return a run whose error at the end is what is wanted, as a second one confirms, or the last."""
    wanted, problem = chosen.wanted, found.problem
    if wanted is None or not found.success or found.steps == 0:
        return found, chosen
    name, times = label(found)
    begin = named["t0"] if name == "t" else 0.0
    own = named["t0"] if problem.time == "t" else 0.0
    start = (own, chosen.state if isinstance(chosen, Chosen) else None)
    power = growth(found, wanted, start)
    if power == 0.0:
        return found, chosen
    ends = {"t_end": None, "tau_end": None, f"{name}_end": float(times[-1])}
    runs = CONFIRMED if named["callback"] is None else 0
    try:
        other = solved(**{**named, **QUIET, **ends, **chosen.longer(found), "turning": True})
    except StepError:
        shorter = chosen.shorter(found, most)
        if not runs or shorter is None:
            return found, chosen
        other, found, chosen = found, solved(**named, **shorter.asked), shorter
    found.end_error = end_error(found, other, wanted, start, begin, power)
    for _ in range(runs):
        shorter = None if met(found, wanted) else chosen.shorter(found, most)
        if shorter is None:
            break
        other, found, chosen = found, solved(**named, **shorter.asked), shorter
        if not found.success:
            break
        found.end_error = end_error(found, other, wanted, start, begin, power)
    return found, chosen
