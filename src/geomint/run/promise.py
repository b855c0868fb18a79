"""What a run promises whose step is not given, and the step that it is begun anew with.

A step errs, in a characteristic time, by no more than `PROMISED` of a piece where a method is named,
and the end by no more than `AT_END` where none is: default steps are made so that this holds of regular
motions, and local errors are measured. Where they are larger, as the motion is not what it looked like
at its beginning, the run begins anew with a shorter step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..methods import Method
from .local_error import LocalError, Ranked
from .solution import Solution

__all__ = [
    "FEW_STEPS",
    "LONGER",
    "MOST_STEPS",
    "Default",
    "end_of",
    "kept",
    "rough_error",
    "shortened",
]

PROMISED = ((7, 1e-9), (4, 1e-7), (2, 1e-3), (1, 1e-2))  # of methods of that order, and higher ones
AT_END = 1e-9
DOUBT = 20.0  # times as much is no reason to begin anew: local errors are known to a factor of ten
ENOUGH = 3.0  # times what is wanted of the end, where sums of local errors are better known
LONGER = 1.5  # times the step: that of a second run
SURE = 0.1  # of a limit: what one measurement shows is known to be less
AIM = 0.3  # of what is promised
FAILED, SHORTEST, LONGEST = 0.3, 0.1, 0.8  # of a step that failed; of one that is too long
MOST_STEPS, FEW_STEPS = 2.0**24, 2.0**12  # that a run is begun anew with; in plain Python


def shortened(factor: float, power: int) -> float:
    """Return by what a step is multiplied so that an error is, as far as one goes at a time."""
    return float(min(max(factor ** (1.0 / power), SHORTEST), LONGEST)) if factor else SHORTEST


class Default(NamedTuple):
    """A step that is not given: the default one, or what comes after it."""

    method: str | Method | None
    step: float | None = None

    @property
    def asked(self) -> dict[str, Any]:
        """What `solve` is to do."""
        return {"method": self.method, "step": self.step, "turning": False}

    @property
    def wanted(self) -> float | None:
        """What the end may err by; None where a method is named."""
        return AT_END if self.method is None else None

    def longer(self, found: Solution) -> dict[str, Any]:
        """Return what is asked of a second run, which errs more."""
        return {**self.asked, "step": LONGER * abs(found.step)}

    def kept(self, found: Solution) -> bool:
        """Tell whether a run's steps err by no more than is promised."""
        return kept(found, self.wanted, allowed(found))

    def shorter(self, found: Solution, most: float) -> Default | None:
        """Return what is tried after a run that errs too much, or failed: in `most` steps at most."""
        factor, error, p = FAILED, found.local_error, found.method.order
        step = abs(found.step)
        if found.success and error is not None:
            factor, step = LONGEST, error.step
            if error.largest > AIM * allowed(found):
                factor = shortened(AIM * allowed(found) / error.largest, p + 1)
            if self.wanted is not None:
                factor = min(factor, shortened(AIM * self.wanted / end_of(found), p))
        few = found.steps <= factor * most and factor * step > 0.0
        return self._replace(step=factor * step) if few else None


def kept(found: Solution, wanted: float | None, allowed: float | None = None) -> bool:
    """Tell whether a run errs by no more than is wanted of the end, and each step than is allowed."""

    def part(error: LocalError) -> float:
        at_end = 0.0 if wanted is None else error.total / (ENOUGH * wanted)
        return at_end if allowed is None else max(at_end, error.largest / (DOUBT * allowed))

    error = rough_error(found)
    if error is not None and part(error) > SURE:
        error = found.local_error
    return error is None or part(error) <= 1.0


def end_of(found: Solution) -> float:
    """Return what the end errs by: as a second run says, or the sum of what steps do."""
    if found.end_error is not None:
        return found.end_error.error
    return 0.0 if found.local_error is None else found.local_error.total


def rough_error(found: Solution) -> LocalError | None:
    """Return what steps err by, measured at one place where it has not been measured yet."""
    return found.ranked.rough if isinstance(found.ranked, Ranked) else found.ranked


def allowed(found: Solution) -> float:
    """Return what each step of a run may err by."""
    method = found.method
    return method.step_fraction * next(e for order, e in PROMISED if method.order >= order)
