"""What a run promises whose step is not given, and the step that it is begun anew with.

A step errs, in a characteristic time, by no more than `PROMISED` of a piece: default steps are made so
that this holds of regular motions, and local errors are measured. Where they are larger, as the motion
is not what it looked like at its beginning, the run begins anew with a shorter step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..methods import Method
from .local_error import LocalError, Ranked
from .solution import Solution

__all__ = ["FEW_STEPS", "MOST_STEPS", "SURE", "Default", "rough_error", "shortened"]

PROMISED = ((7, 1e-9), (4, 1e-7), (2, 1e-3), (1, 1e-2))  # of methods of that order, and higher ones
DOUBT = 20.0  # times as much is no reason to begin anew: local errors are known to a factor of ten
SURE = 0.1  # of a limit: what one measurement shows is known to be less
AIM = 0.3  # of what is promised
FAILED, SHORTEST, LONGEST = 0.3, 0.1, 0.8  # of a step that failed; of one that is too long
MOST_STEPS, FEW_STEPS = 2.0**24, 2.0**12  # that a run is begun anew with; in plain Python


def shortened(factor: float, power: int) -> float:
    """Return by what a step is multiplied so that an error is, as far as one goes at a time."""
    return float(min(max(factor ** (1.0 / power), SHORTEST), LONGEST))


class Default(NamedTuple):
    """A step that is not given: the default one, or what comes after it."""

    method: str | Method | None
    step: float | None = None

    @property
    def asked(self) -> dict[str, Any]:
        """What `solve` is to do."""
        return {"method": self.method, "step": self.step}

    def kept(self, found: Solution) -> bool:
        """Tell whether a run's steps err by no more than is promised."""
        error = rough_error(found)
        if error is not None and error.largest > SURE * DOUBT * allowed(found):
            error = found.local_error
        return error is None or error.largest <= DOUBT * allowed(found)

    def shorter(self, found: Solution, most: float) -> Default | None:
        """Return what is tried after a run that errs too much, or failed: in `most` steps at most."""
        error, factor, step = found.local_error, FAILED, abs(found.step)
        if found.success and error is not None:
            factor = shortened(AIM * allowed(found) / error.largest, found.method.order + 1)
            step = error.step
        few = found.steps <= factor * most and factor * step > 0.0
        return self._replace(step=factor * step) if few else None


def rough_error(found: Solution) -> LocalError | None:
    """Return what steps err by, measured at one place where it has not been measured yet."""
    return found.ranked.rough if isinstance(found.ranked, Ranked) else found.ranked


def allowed(found: Solution) -> float:
    """Return what each step of a run may err by."""
    method = found.method
    return method.step_fraction * next(e for order, e in PROMISED if method.order >= order)
