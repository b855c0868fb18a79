"""Steppers of runs, made once for a problem and a method: what a run needs of its own is its memory."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..problems.problem import Problem
from .method import Method, Start
from .stepper import Stepper

__all__ = ["keep_started", "often_run", "started"]

MOST = 16  # steppers that a problem keeps
OFTEN = 100  # starts of steppers, two of a run by tolerance: what one takes matters then


def started(method: Method, s: Start) -> Stepper:
    """Return ``method.start(s)``, prepared if the problem keeps such a stepper of a run before.

    Kept is what depends on neither state nor step, which is all that `Stepper.restarted` takes for
    granted too. Functions are looked at again: where they have changed a new stepper is made.
    """
    of = _kept(s)
    of.times += 1
    kept = of.get((method, s.clock))
    if kept is None or method.adaptive or not s.compiled or kept[1] != _fingerprints(kept[0]):
        return method.start(s)
    return kept[0].renewed(np.append(s.y0, 0.0) if s.clock else s.y0, s.t0, s.h)


def keep_started(method: Method, s: Start, stepper: Stepper) -> None:
    """Keep a stepper that has been prepared and has proved to be right."""
    if method.adaptive or not s.compiled:
        return
    kept = _kept(s)
    if len(kept) >= MOST:
        kept.clear()
    kept[method, s.clock] = stepper.renewed(stepper.state, s.t0, s.h), _fingerprints(stepper)


def often_run(problem: Problem) -> bool:
    """Tell whether many runs of a problem have begun in this process."""
    kept: _Kept | None = problem.__dict__.get("_started")
    return kept is not None and kept.times >= OFTEN


class _Kept(dict[Any, tuple[Stepper, tuple[str, ...]]]):
    """The steppers that a problem keeps; copies and pickles of it have none, addresses are no use."""

    times = 0

    def __reduce__(self) -> Any:
        return _Kept, ()

    def __deepcopy__(self, memo: Any) -> _Kept:
        return _Kept()


def _kept(s: Start) -> _Kept:
    kept: _Kept = s.problem.__dict__.setdefault("_started", _Kept())
    return kept


def _fingerprints(stepper: Stepper) -> tuple[str, ...]:
    return stepper.kernel.fingerprint, *(f.recorded.fingerprint for f in stepper.functions)
