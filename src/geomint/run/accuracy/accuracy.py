"""How a tolerance is met: what is expected of the run, and why."""

import math
from typing import Any, NamedTuple, Self

from ...errors import EndWarning, tell
from ..local_error import LocalError

DOUBT = 3.0  # times the tolerance: what is expected to be more, or steps add up to, is said
MISSED = 10.0  # times the tolerance: so is an error that a finer run has found


class Accuracy(NamedTuple):
    """How a tolerance is met: what is expected of the run, and why.

    Attributes
    ----------
    tolerance : float
        As asked for: of the state at the end, relative to the largest number of each piece.
    expected : float
        The error at the end that trials let expect; infinite where none of them could be run.
    floor : float
        What roundings make of the state at the end of a regular motion, about.
    trials : tuple of (float, float or None)
        Steps, or values of ``rtol`` of an adaptive method, that were tried on a stretch of the motion,
        and the errors at the end that follow from it; None where the stretch could not be run.
    reason : str
        Why the method, where ``method="auto"`` chose it.
    """

    tolerance: float
    expected: float
    floor: float
    trials: tuple[tuple[float, float | None], ...]
    reason: str = ""

    @classmethod
    def read(cls, numbers: list[Any] | None) -> Self | None:
        """Return what JSON has made lists of."""
        if numbers is None:
            return None
        tolerance, expected, floor, trials, *_, reason = numbers  # of older files: of steps too
        return cls(tolerance, expected, floor, tuple((a, b) for a, b in trials), reason)

    @property
    def note(self) -> str:
        """What a user should know before the run; empty if the tolerance is expected to be met."""
        return self.noted(None)

    def noted(self, steps: LocalError | None) -> str:
        """Return the note, by errors of steps where they are known."""
        if self.floor > self.tolerance:
            return f"roundings alone make about {self.floor:.1g} of such a run"
        if steps is not None:
            if steps.total <= DOUBT * self.tolerance:
                return ""
            return (
                f"errors of steps add up to {steps.total:.2g}, that of a step is largest near "
                f"{steps.time:.6g}"
            )
        if self.expected <= DOUBT * self.tolerance:
            return ""
        known = f"an error of {self.expected:.1g}" if math.isfinite(self.expected) else "no end"
        return f"{len(self.trials)} trials let expect {known}"

    def tell(self, steps: LocalError | None, measured: float | None) -> None:
        """Warn where the tolerance is not expected to be met, or was not, as a finer run says.

        `steps` is what steps of the run erred by, and `measured` the error at the end by that run,
        relative as the tolerance is.
        """
        asked, known = f"tolerance = {self.tolerance:g}", self.expected
        because, do = self.noted(steps), "give a shorter step in its place"
        if self.floor > self.tolerance:
            known, do = self.floor, "give a larger one, or an earlier end"
        elif steps is not None:
            known = steps.total
        if measured is not None:
            if measured > MISSED * self.tolerance:
                found = f"by a run with finer steps the error at the end is about {measured:.1g}"
                text = "; ".join(filter(None, (f"{asked} was not met: {found}", because, do)))
                tell(EndWarning(text, "end", measured))
        elif because:
            tell(EndWarning(f"{asked} may not be met: {because}; {do}", "end", known))
