"""What a run leaves: states, drifts, costs."""

from __future__ import annotations

from dataclasses import dataclass, field
from os import PathLike
from typing import TYPE_CHECKING, Literal, NamedTuple

from ..arguments import Array
from ..errors import DomainError
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.problem import Problem, Time
from ..watch.drift import Drift

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .storage import SavedSolution

__all__ = ["Solution", "Status", "StepSizes"]

Status = Literal["success", "interrupted", "failed", "not finite"]


class StepSizes(NamedTuple):
    """Lengths of steps in the problem's own time; all the same at fixed step.

    Steps that the end of an adaptive run cuts short count in the mean only.
    """

    min: float
    mean: float
    max: float


@dataclass(repr=False, eq=False)
class Solution(Compared):
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
    """

    problem: Problem
    method: Method
    step: float
    step_sizes: StepSizes
    tau: Array
    y: Array
    drift: dict[str, Drift]
    steps: int
    rejected: int
    iterations: int
    evaluations: int
    run_seconds: float = field(compare=False)
    watching_seconds: float = field(compare=False)
    compile_seconds: float = field(compare=False)
    status: Status
    message: str
    drift_time: Time = "t"
    physical: Array | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        end = f"{self.problem.time} = {self.tau[-1]:.9g}" if len(self.tau) else "no state saved"
        mean = "mean " if self.method.adaptive else ""
        return (
            f"<solution of {self.problem.name!r} by {self.method.name}: {self.status}, "
            f"{self.steps} steps of {mean}{self.step:.6g}, {len(self.tau)} states to {end}, "
            f"{len(self.drift)} drifts>"
        )

    @property
    def t(self) -> Array:
        """Physical times of the saved states."""
        if self.physical is None:
            raise DomainError("clock", False, "clock=True: physical time was not integrated")
        return self.physical

    @property
    def success(self) -> bool:
        """Whether the end was reached, and all that was observed is finite."""
        return self.status == "success"

    def piece(self, name: str) -> Array:
        """Return the saved values of one piece of the state, one a row."""
        slices = self.problem.slices
        if not (isinstance(name, str) and name in slices):
            raise DomainError("piece", name, f"one of {list(slices)}")
        return self.y[:, slices[name]]

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
