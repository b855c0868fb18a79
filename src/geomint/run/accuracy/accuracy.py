"""How a tolerance is met: what `geomint.solve` chose, and what is expected of it."""

from __future__ import annotations

import dataclasses
import math
import warnings
from dataclasses import dataclass
from typing import Any

from ...errors import GeomintWarning
from ...kernels.compiling.sameness import Compared
from ...methods.method import Method

__all__ = ["Accuracy"]

SHORTER = 0.75  # of a step that failed on the way
DOUBT = 3.0  # times the tolerance: what is expected to be more is said


@dataclass(frozen=True, eq=False)
class Accuracy(Compared):
    """How a tolerance is met: what was chosen, and what is expected of it.

    Attributes
    ----------
    tolerance : float
        As asked for: of the state at the end, relative to the largest number of each piece.
    method : Method
        With the tolerance of its iteration, or of its steps.
    step : float or None
        In the problem's own time; None for an adaptive method, whose ``rtol`` was chosen.
    expected : float
        The error at the end that trials let expect; infinite where none of them could be run.
    floor : float
        What roundings will make of the state at the end of a regular motion, about.
    trials : tuple of (float, float or None)
        Steps, or values of ``rtol``, that were tried on a stretch of the motion, and the errors at the
        end that follow from it; None where the stretch could not be run.
    reason : str
        Why the method, where it was chosen too.
    """

    tolerance: float
    method: Method
    step: float | None
    expected: float
    floor: float
    trials: tuple[tuple[float, float | None], ...]
    reason: str = ""

    def shorter(self) -> Accuracy | None:
        """Return what is tried after a step that failed; None for an adaptive method."""
        if self.step is None:
            return None
        expected = self.expected * SHORTER**self.method.order
        return dataclasses.replace(self, step=SHORTER * self.step, expected=expected)

    @property
    def note(self) -> str:
        """What a user should know before the run; empty if the tolerance is expected to be met."""
        if self.floor > self.tolerance:
            return f"roundings alone make about {self.floor:.1g} of such a run"
        if not self.expected <= DOUBT * self.tolerance:
            known = f"an error of {self.expected:.1g}" if math.isfinite(self.expected) else "no end"
            return f"{len(self.trials)} trials let expect {known}"
        return ""

    def tell(self) -> None:
        """Warn where the tolerance is not expected to be met."""
        if self.note:
            said = f"tolerance = {self.tolerance:g} may not be met: {self.note}"
            warnings.warn(said, GeomintWarning, stacklevel=4)

    def record(self) -> dict[str, Any]:
        """Return it for a provenance, in numbers and words."""
        return {
            "tolerance": self.tolerance,
            "expected_error": self.expected,
            "rounding_floor": self.floor,
            "trials": [list(trial) for trial in self.trials],
            "reason": self.reason,
        }
