"""Runs that begin anew, with a shorter step, until errors are what they shall be."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import StepError
from ..methods.adaptive import Adaptive
from .accuracy.asked import TOO_LONG
from .error_estimate import label
from .growth import end_error, end_time, final, hopeless, may_grow, met, second_end, sizes_of, worse
from .local_error import Ranked
from .promise import FEW_STEPS, MOST_STEPS, STRICTER, Setting
from .second import LONGER
from .solution import Solution

__all__ = ["begun_anew"]

ATTEMPTS, FAILURES = 14, 9  # runs with shorter steps, and those that may fail
MISSED = 3  # runs whose steps erred too much: variable ones are taken then, if they may be
GUESSED = 2  # failures that are said to be those of a guess: Newton's method takes no step before
MOST_LONGER = 1e3  # times: what is more says no more
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

    Each step's, as far as they are promised, and that at the end, as a second run tells. A callback
    sees one run.
    """
    once, most = named["callback"] is not None, MOST_STEPS if named["compiled"] else FEW_STEPS
    found, chosen = _succeeded(solved, chosen, named, most, once)
    wanted, begin = chosen.wanted, named["t0"] if label(found)[0] == "t" else 0.0
    if not found.success or found.steps == 0:
        return found, chosen
    sizes, before = np.zeros(0), None
    if wanted is not None:
        states, ratio = _second(found, solved, chosen, named, begin)
        if len(states):
            sizes = sizes_of(found, *states[: 0 if isinstance(found.ranked, Ranked) else None])
            found.end_error = end_error(found, states[-1], wanted, sizes, begin, ratio)
    for k in range(0 if once else ATTEMPTS):
        unknown = wanted is not None and found.end_error is None and found.ranked is not None
        if not unknown and chosen.kept(found) and (wanted is None or met(found, wanted)):
            break
        if wanted is not None and hopeless(found, wanted, before):
            break
        shorter = chosen.variable(found) if k >= MISSED and _uneven(found) else None
        shorter = shorter or chosen.shorter(found, most)
        if shorter is None:
            break
        before, former = found, chosen
        found, chosen = _succeeded(solved, shorter, {**named, "confirmed": False}, most, once)
        if not found.success:
            break
        if wanted is not None:
            if isinstance(found.ranked, Ranked) or not len(sizes):
                sizes = sizes_of(found)
            p, longer = found.method.order, before.step / found.step
            ratio = min(longer, MOST_LONGER) ** p if chosen.step else 1.0 / STRICTER
            found.end_error = end_error(found, final(before), wanted, sizes, begin, ratio)
            if not chosen.step and worse(found, before):  # variable steps, which have not helped
                return before, former
    return found, chosen


def _succeeded(
    solved: Solved, chosen: Setting, named: Mapping[str, Any], most: float, once: bool
) -> tuple[Solution, Setting]:
    """Return what `solved` does with a step, or with the first shorter one that does not fail."""
    for failures in range(1 if once else FAILURES):
        by = chosen.asked
        if once or failures > GUESSED:
            by["turning"] = True
        try:
            return solved(**{**by, **named}), chosen
        except TOO_LONG as error:
            shorter = error.partial and chosen.shorter(error.partial, most)
            if once or not shorter or failures + 1 == FAILURES:
                raise
            chosen = shorter
    raise AssertionError("no run")


def _uneven(found: Solution) -> bool:
    """Tell whether few steps make most of the errors."""
    return isinstance(found.ranked, Ranked) and found.ranked.concentrated


def _second(
    found: Solution, solved: Solved, chosen: Setting, named: Mapping[str, Any], begin: float
) -> tuple[Any, float]:
    """Return states of a second run, the last one at the end, and how many times as much it errs."""
    if isinstance(found.method, Adaptive):
        return _looser(found, solved, chosen, named, begin), 1.0 / STRICTER
    end = second_end(found)
    return () if end is None else (end,), LONGER**found.method.order


def _looser(
    found: Solution, solved: Solved, chosen: Setting, named: Mapping[str, Any], begin: float
) -> Any:
    """Return states of a run with larger local tolerances, the last one at the end; or none."""
    accuracy, name, end = chosen.accuracy, label(found)[0], end_time(found)
    doubted = accuracy is None or accuracy.note != ""
    own = named["t0"] if found.problem.time == "t" else 0.0
    if chosen.state is None or not (doubted or may_grow(found, chosen.state, own)):
        return ()
    given = {f"{name}_end": end, f"{name}_eval": np.linspace(begin, end, LOOKS)[1:]}
    try:
        return solved(**{**named, **QUIET, **given, **chosen.looser()}).y
    except StepError:
        return ()
