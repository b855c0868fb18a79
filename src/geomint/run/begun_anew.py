"""Runs that begin anew, with a shorter step, until errors are what they shall be."""

import math
from collections.abc import Callable

import numpy as np

from ..arguments import Array
from ..errors import StepError
from ..methods.adaptive import Adaptive
from .accuracy.asked import TOO_LONG
from .asked import Asked
from .callback import Ending
from .error_estimate import label
from .growth import (
    end_error,
    end_time,
    final,
    hopeless,
    may_grow,
    met,
    off_at_end,
    second_end,
    sizes_of,
)
from .local_error import Ranked
from .promise import FEW_STEPS, MOST_STEPS, STRICTER, UNEVEN, Setting
from .second import longer
from .solution import Solution

LONGEST = 4  # times as many steps as the first run had, or `MOST_STEPS`
ATTEMPTS, FAILURES = 14, 9  # runs with shorter steps, and those that may fail
MISSED = 3  # runs whose steps erred too much: variable ones are taken then, if they may be
GUESSED = 2  # failures that are said to be those of a guess: Newton's method takes no step before
LOOKS = 17  # states of a second run, by which pieces are as large as they become
QUIET = {
    **dict.fromkeys(("t_end", "tau_end", "t_eval", "tau_eval", "events", "save_every", "callback")),
    **{"observe": (), "dense": False, "estimate_error": False, "progress": False},
}
Solved = Callable[[Asked], Solution]


def begun_anew(solved: Solved, chosen: Setting, asked: Asked) -> tuple[Solution, Setting]:
    """Return what `solved` does with a step, or shorter ones, until errors are what they shall be.

    Each step's, as far as they are promised, and that at the end, as a second run tells. A callback
    sees one run.
    """
    once = not isinstance(asked.callback, Ending | None)
    most = MOST_STEPS if asked.compiled else FEW_STEPS
    found, chosen = _succeeded(solved, chosen, asked, most, once)
    wanted, begin = chosen.wanted, asked.t0 if label(found)[0] == "t" else 0.0
    if not found.success or found.steps == 0:
        return found, chosen
    before, expected, most = None, math.inf, max(most, LONGEST * found.steps)
    if wanted is not None:
        try:
            p = found.method.order
            sizes, other, ratio = None, second_end(found), longer(p) ** p
            if isinstance(found.method, Adaptive):
                sizes, other, ratio = _looser(found, solved, chosen, asked, begin)
        except KeyboardInterrupt:  # of a run that is done
            return found, chosen
        if other is not None:
            off = off_at_end(found, other, sizes, wanted)
            found.end_error = end_error(found, off, wanted, begin, ratio, 0.0)
            expected = off / max(ratio - 1.0, 1.0)
    for k in range(0 if once else ATTEMPTS if chosen.own is None else MISSED):
        unknown = wanted is not None and found.end_error is None and found.ranked is not None
        if not unknown and chosen.kept(found) and (wanted is None or met(found, wanted)):
            break
        if wanted is not None and hopeless(found, wanted, before):
            break
        shorter = chosen.variable(found) if k >= MISSED else None
        shorter = shorter or chosen.shorter(found, most, expected)
        if shorter is None:
            break
        before, former = found, chosen
        try:
            found, chosen = _succeeded(solved, shorter, asked, most, once, False)
        except StepError:  # of the shorter one alone
            break
        if not found.success:
            break
        if wanted is not None:
            other, ratio = final(before), min(before.step / found.step, 1e3) ** found.method.order
            if isinstance(found.ranked, Ranked):
                sizes = None
            elif isinstance(before.ranked, Ranked):
                sizes, other, ratio = _looser(found, solved, chosen, asked, begin)
            else:
                ratio = 1.0 / STRICTER
            off = math.inf
            if other is not None:
                off = off_at_end(found, other, sizes, wanted)
                found.end_error = end_error(found, off, wanted, begin, ratio, expected)
            expected = off / max(ratio - 1.0, 1.0)
            now, then = found.end_error, before.end_error
            if now and then and not chosen.step and now.error > then.error:  # varied in vain
                found, chosen = before, former._replace(free=False)
    return found, chosen


def _succeeded(
    solved: Solved,
    chosen: Setting,
    asked: Asked,
    most: float,
    once: bool,
    confirmed: bool = True,
) -> tuple[Solution, Setting]:
    """Return what `solved` does with a step, or with the first shorter one that does not fail."""
    for failures in range(1 if once else FAILURES):
        by = chosen.asked
        by["confirmed"] &= confirmed
        if once or failures > GUESSED:
            by["turning"] = True
        try:
            return solved(asked._replace(**by)), chosen
        except TOO_LONG as error:
            shorter = error.partial and chosen.shorter(error.partial, most)
            if once or not shorter or failures + 1 == FAILURES:
                raise
            chosen = shorter
    raise AssertionError


def _looser(
    found: Solution, solved: Solved, chosen: Setting, asked: Asked, begin: float
) -> tuple[Array | None, Array | None, float]:
    """Return sizes of pieces, and the end of a run with larger local tolerances, that errs more.

    None where nothing says that the run errs.
    """
    accuracy, name, end = chosen.accuracy, label(found)[0], end_time(found)
    doubted = accuracy is None or accuracy.note != "" or accuracy.reason == UNEVEN
    own, none = asked.t0 if found.problem.time == "t" else 0.0, (None, None, 1.0)
    if chosen.state is None or not (doubted or may_grow(found, chosen.state, own)):
        return none
    given = {f"{name}_end": end, f"{name}_eval": np.linspace(begin, end, LOOKS)[1:]}
    try:
        states = solved(asked._replace(**{**QUIET, **given, **chosen.looser()})).y
    except StepError:
        return none
    return sizes_of(found, *states), states[-1], 1.0 / STRICTER
