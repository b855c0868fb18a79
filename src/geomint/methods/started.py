"""Steppers of runs, made once for a problem and a method: what a run needs of its own is its memory."""

from typing import Any

import numpy as np

from ..problems.declaration import Kept, check_problem, functions_of
from .method import Method, Start
from .stepper import Stepper

MOST = 16  # steppers that a problem keeps


def started(method: Method, s: Start) -> Stepper:
    """Return ``method.start(s)``, prepared if the problem keeps such a stepper of a run before.

    Kept is what depends on neither state nor step, which is all that `Stepper.restarted` takes for
    granted too. Functions are looked at again: where they have changed a new stepper is made.
    """
    kept = _kept(s).get((method, s.clock))
    if kept is None or method.adaptive or not s.compiled or kept[1] != _now(method, s, kept[0]):
        stepper = method.start(s)
    else:
        stepper = kept[0].renewed(np.append(s.y0, 0.0) if s.clock else s.y0, s.t0, s.h)
    stepper.end = None if method.adaptive else s.end
    return stepper


def keep_started(method: Method, s: Start, stepper: Stepper) -> None:
    """Keep a stepper that has been prepared and has proved to be right."""
    if method.adaptive or not s.compiled:
        return
    kept = _kept(s)
    if len(kept) >= MOST:
        kept.clear()
    kept[method, s.clock] = stepper.renewed(stepper.state, s.t0, s.h), _now(method, s, stepper)


def _kept(s: Start) -> dict[Any, tuple[Stepper, list[str]]]:
    return s.problem.__dict__.setdefault("_started", Kept())


def _now(method: Method, s: Start, stepper: Stepper) -> list[str]:
    """Return fingerprints of the problem's functions, and of others that are the method's own."""
    problem = s.problem
    functions = s.functions or check_problem(problem, s.y0, method.needs, s.clock)
    known = *functions_of(problem, method.needs), problem.clock
    others = [f.recorded for f in stepper.functions if f.recorded not in known]
    return [*functions, *[f.fingerprint for f in (stepper.kernel, *others)]]
