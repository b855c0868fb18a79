"""Runs that begin anew, with a shorter step, until errors are what they shall be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import StepError
from ..methods.adaptive import Adaptive
from .accuracy.asked import TOO_LONG
from .error_estimate import label
from .growth import end_error, hopeless, may_grow, met, second_end, sizes_of
from .local_error import Ranked
from .promise import FEW_STEPS, MOST_STEPS, STRICTER, Setting
from .second import LONGER
from .solution import Solution

__all__ = ["begun_anew"]

ATTEMPTS, FAILURES = 14, 8  # runs with shorter steps, and those that may fail
MISSED = 3  # runs whose steps erred too much: variable ones are taken then, if they may be
GUESSED = 2  # failures that are said to be those of a guess: Newton's method takes no step before
LOOKS = 17  # states of a second run, by which pieces are as large as they become
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
            shorter = chosen.variable(solution) if missed >= MISSED else None
            shorter = shorter or chosen.shorter(solution, most)
            if shorter is None:
                break
        chosen = shorter
    return _confirmed(solution, solved, chosen, named, most)


def _confirmed(
    found: Solution, solved: Solved, chosen: Setting, named: Mapping[str, Any], most: float
) -> tuple[Solution, Setting]:
    """Return a run whose error at the end is what is wanted, as a second one confirms, or the last."""
    wanted = chosen.wanted
    if wanted is None or not found.success or found.steps == 0:
        return found, chosen
    begin = named["t0"] if label(found)[0] == "t" else 0.0
    if isinstance(found.method, Adaptive):
        states = _looser(found, solved, chosen, named, begin)
        ratio = 1.0 / STRICTER
    else:
        end = second_end(found)
        states, ratio = () if end is None else (end,), LONGER**found.method.order
    once = named["callback"] is not None
    if len(states) == 0 and isinstance(found.ranked, Ranked) and not once:
        shorter = chosen.shorter(found, most)
        if shorter is not None:  # longer steps fail
            states, step = (found.y[-1],), found.step
            found, chosen = solved(**named, **shorter.asked), shorter
            ratio = (step / found.step) ** found.method.order
    if len(states) == 0 or not found.success:
        return found, chosen
    sizes, before = sizes_of(found, *states), None
    found.end_error = end_error(found, states[-1], wanted, sizes, begin, ratio)
    for k in range(0 if once else ATTEMPTS):
        if met(found, wanted) and chosen.kept(found):
            break
        if hopeless(found, wanted, before):
            break
        uneven = isinstance(found.ranked, Ranked) and found.ranked.concentrated
        shorter = chosen.variable(found) if k >= MISSED and uneven else None
        shorter = shorter or chosen.shorter(found, most)
        if shorter is None:
            break
        again = solved(**named, **{**shorter.asked, "confirmed": False})
        if not again.success:
            return again, shorter
        ratio = (found.step / again.step) ** again.method.order if shorter.step else 1.0 / STRICTER
        again.end_error = end_error(again, found.y[-1], wanted, sizes, begin, ratio)
        before, found, chosen = found, again, shorter
    return found, chosen


def _looser(
    found: Solution, solved: Solved, chosen: Setting, named: Mapping[str, Any], begin: float
) -> Any:
    """Return states of a run with larger local tolerances, the last one at the end; or none."""
    accuracy, (name, times) = chosen.accuracy, label(found)
    doubted = accuracy is None or accuracy.note != ""
    own = named["t0"] if found.problem.time == "t" else 0.0
    if chosen.state is None or not (doubted or may_grow(found, chosen.state, own)):
        return ()
    end = float(times[-1])
    given = {f"{name}_end": end, f"{name}_eval": np.linspace(begin, end, LOOKS)[1:]}
    try:
        return solved(**{**named, **QUIET, **given, **chosen.looser()}).y
    except StepError:
        return ()
