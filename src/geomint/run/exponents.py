"""What a run tells of how fast neighbouring motions part, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import Array
from ..errors import GeomintWarning
from ..problems.shown import Shown
from .files.outputs import write_table
from .reported import Reported

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLOCKS = 64  # parts of a run that have samples at their ends; half as many tell the errors
ENOUGH = np.log(100.0) + 1.0  # before a hundred characteristic times nothing is called regular


@dataclass(frozen=True, eq=False, repr=False)
class Lyapunov(Shown, Reported):
    """Exponents of a run, and how they have converged.

    Attributes
    ----------
    exponents : array, shape (k,)
        In falling order, whatever the order of their directions; per unit of the problem's own time.
    errors : array, shape (k,)
        One standard error: that of the means over parts of the run, what the second half of it has
        changed, and a rounding a step. A regular motion has exponents like ln t / t, which are no
        larger.
    t : array, shape (samples,)
        Time since the beginning, where there are samples.
    running : array, shape (samples, k)
        The exponents up to there, in the order of those at the end.
    sali : array, shape (samples,), or None
        The smaller alignment index, min ‖v₁ ± v₂‖, of two vectors of length 1 that are carried along:
        it falls to 0 exponentially where motions part exponentially, and like a power of t, or not at
        all, on tori. With one direction there is none.
    y : array, shape (rows,)
        The state at the end.
    unit : float
        A characteristic time where the motion began.
    steps, iterations : int
        Steps taken; iterations of all of them, where the method iterates: those that values and slopes
        needed.
    status : str
        ``"success"``, ``"interrupted"`` or ``"failed"``: then up to there.
    warnings : tuple of GeomintWarning
        All that has been told, as `geomint.Solution.warnings`.
    """

    exponents: Array
    errors: Array
    t: Array
    running: Array
    sali: Array | None
    y: Array
    unit: float
    steps: int
    iterations: int
    status: str = "success"
    warnings: tuple[GeomintWarning, ...] = ()

    @property
    def verdict(self) -> str:
        """``"chaotic"``, ``"regular"`` or ``"undecided"``, by the growth λ₁ t.

        Neighbouring motions of a regular one part like a power of time, so that λ₁ t is like ln(t/T) to
        the power's exponent, T the characteristic time. Up to 3 ln(t/T) + 3 counts as regular; beyond
        10 ln(t/T) + 10, and beyond four standard errors, as chaotic. What is between needs more time.
        """
        if not len(self.t):
            return "undecided"
        grown = self.exponents[0] * self.t[-1]
        power = np.log(max(self.t[-1] / self.unit, 1.0)) + 1.0
        if grown <= 3.0 * power:
            return "regular" if power > ENOUGH else "undecided"
        clear = self.exponents[0] > 4.0 * self.errors[0]
        return "chaotic" if grown > 10.0 * power and clear else "undecided"

    def _shown(self) -> tuple[str, dict[str, Any]]:
        pairs = zip(self.exponents, self.errors, strict=True)
        words = ", ".join(f"{value:.4g} ± {error:.1g}" for value, error in pairs)
        time = f"{self.t[-1]:.6g}" if len(self.t) else "0"
        return "Lyapunov exponents", {"exponents": words, "time": time, "verdict": self.verdict}

    def save(self, path: str | PathLike[str]) -> None:
        """Write time, exponents up to there and the alignment index as CSV.

        Raises
        ------
        OutputError
        """
        names = ["t", *(f"lambda_{k + 1}" for k in range(len(self.exponents)))]
        columns = [self.t, *self.running.T]
        if self.sali is not None:
            names, columns = [*names, "sali"], [*columns, self.sali]
        write_table(path, names, columns)

    def plot(self) -> Figure:
        """Plot the exponents' sizes over time, beside ln t / t, and the alignment index."""
        from ..plots.growth_plot import lyapunov_figure

        return lyapunov_figure(self.t, self.running, self.sali)


def standard_errors(t: Array, grown: Array) -> Array:
    """Return standard errors of the exponents: of means over parts, and of the two halves."""
    if not len(t):
        return np.full(grown.shape[1], np.inf)
    at = np.searchsorted(t, np.linspace(0.0, t[-1], BLOCKS // 2 + 1)[1:])
    at = np.unique(np.concatenate([[0], np.minimum(at, len(t) - 1)]))
    if len(at) < 3:
        return np.full(grown.shape[1], np.inf)
    rates = np.diff(grown[at], axis=0) / np.diff(t[at])[:, None]
    spread = rates.std(axis=0, ddof=1) / np.sqrt(len(rates))
    half = int(np.searchsorted(t, 0.5 * t[-1]))
    change = grown[-1] / t[-1] - grown[half] / t[half]
    return np.hypot(spread, change)
