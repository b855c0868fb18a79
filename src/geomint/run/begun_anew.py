"""Runs that begin anew, with a shorter step, until errors are what they shall be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import StepError
from ..methods.adaptive import Adaptive
from .accuracy.asked import TOO_LONG
from .error_estimate import label
from .growth import end_error, growth, met, sizes_of
from .promise import FEW_STEPS, MOST_STEPS, Setting
from .solution import Solution

__all__ = ["begun_anew"]

ATTEMPTS, FAILURES = 14, 8  # runs with shorter steps, and those that may fail
MISSED = 3  # runs whose steps erred too much: variable ones are taken then, if they may be
GUESSED = 2  # failures that are said to be those of a guess: Newton's method takes no step before
LOOKS = 17  # states of a second run, by which pieces are as large as they become
CONFIRMED = 4  # second runs, and those with shorter steps after them
QUIET: dict[str, Any] = {
    **{
        "t_end": None,
        "tau_end": None,
        "t_eval": None,
        "tau_eval": None,
        "dense": False,
        "events": None,
        "save_every": None,
    },
    **{"observe": (), "callback": None, "estimate_error": False, "progress": False},
}

Solved = Callable[..., Solution]


def begun_anew(
    solved: Solved, chosen: Setting, named: Mapping[str, Any]
) -> tuple[Solution, Setting]:
    """Return what `solved` does with a step, or shorter ones, until errors are what they shall be.

    A callback sees one run.
    """
    failures, missed, most = 0, 0, MOST_STEPS if named["compiled"] else FEW_STEPS
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
            missed += 1
            shorter = chosen.shorter(solution, most)
            if missed >= MISSED:
                shorter = chosen.variable(solution) if chosen.free else shorter
            if shorter is None:
                break
        chosen = shorter
    return _with_growth(solution, solved, chosen, named, most)


def _with_growth(
    found: Solution,
    solved: Solved,
    chosen: Setting,
    named: Mapping[str, Any],
    most: float,
) -> tuple[Solution, Setting]:
    """Return a run whose error at the end is what is wanted, as a second one confirms, or the last."""
    wanted, problem = chosen.wanted, found.problem
    if wanted is None or not found.success or found.steps == 0:
        return found, chosen
    name, times = label(found)
    begin = named["t0"] if name == "t" else 0.0
    own = named["t0"] if problem.time == "t" else 0.0
    start = own, chosen.state
    accuracy, adaptive = chosen.accuracy, isinstance(found.method, Adaptive)
    doubted = (
        adaptive if accuracy is None else accuracy._replace(steps=found.local_error).note != ""
    )
    power = growth(found, wanted, start, doubted)
    if power == 0.0:
        return found, chosen
    end = float(times[-1])
    ends = {f"{name}_end": end, f"{name}_eval": np.linspace(begin, end, LOOKS)[1:]}
    runs = CONFIRMED if named["callback"] is None else 0
    try:
        other = solved(**{**named, **QUIET, **ends, **chosen.longer(found)})
    except StepError:
        shorter = chosen.shorter(found, most)
        if not runs or shorter is None:
            return found, chosen
        other, found, chosen = found, solved(**named, **shorter.asked), shorter
    sizes = sizes_of(found, other, start)
    found.end_error = end_error(found, other, wanted, sizes, begin, power)
    for _ in range(runs):
        shorter = None if met(found, wanted) else chosen.shorter(found, most)
        if shorter is None:
            break
        other, found, chosen = found, solved(**named, **shorter.asked), shorter
        if not found.success:
            break
        found.end_error = end_error(found, other, wanted, sizes, begin, power)
    return found, chosen
