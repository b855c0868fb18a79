"""What `geomint.solve` returns: a result that plots and saves itself."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING

from .result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .storage import SavedSolution

__all__ = ["Solution"]


@dataclass(repr=False, eq=False)
class Solution(Result):
    """The result of `geomint.solve`.

    Attributes
    ----------
    t : array, shape (m,)
        Physical times of the saved states.
    tau : array, shape (m,)
        The same in the problem's own time (equal to `t` unless that is τ).
    y : array, shape (m, rows)
        The saved states, one a row.
    drift : dict of name to Drift
        How each observed quantity drifted.
    step : float
        The step, with its sign; of an adaptive method the mean of those taken.
    step_sizes : StepSizes
        Smallest, mean and largest length of a step.
    steps, rejected : int
        Steps taken; steps that an adaptive method tried and rejected.
    iterations, evaluations : int
        Iterations of implicit steps (explicit: steps, rejected ones included); evaluations of the
        problem.
    run_seconds, watching_seconds, compile_seconds : float
        For the steps; for saving states and evaluating what was observed; for compiling.
    status : str
        ``"success"``, ``"interrupted"``, ``"failed"`` or ``"not finite"`` with `message`; the last
        if the end was reached, but something that was observed was infinite or not a number.
    drift_time : ``"t"`` or ``"tau"``
        The time that drifts are measured in: physical if the end was given in it.
    restart : Restart or None
        What ``geomint.solve(solution, …)`` goes on from: the last whole step.
    route : str
        What was followed in place of the problem, if a plan chose so: the name of a reduction, or
        ``"exact flow"``, which takes no steps.
    """

    def plot_drift(self) -> Figure:
        """Plot the largest deviation of every observed quantity, window by window."""
        from ..plots.drift_plots import drift_figure

        return drift_figure([(self.method.name, self.drift)], self.drift_time, self.status)

    def save(self, path: str | PathLike[str]) -> None:
        """Write states, drifts and provenance to a NetCDF file, whole or not at all.

        Raises
        ------
        OutputError
        """
        from .storage import save_solution

        save_solution(self, path)

    def as_saved(self) -> SavedSolution:
        """Return what `save` would write and `geomint.load` give back: numbers and text alone."""
        from .storage import as_saved

        return as_saved(self)
