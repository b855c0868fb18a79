"""What a run leaves, as data: states, drifts, costs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from ..arguments import Array
from ..errors import DomainError
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.problem import Problem, Time
from ..watch.drift import Drift
from .restart import Restart

__all__ = ["Result", "Status", "StepSizes"]

Status = Literal["success", "interrupted", "failed", "not finite"]


class StepSizes(NamedTuple):
    """Lengths of steps in the problem's own time; all the same at fixed step.

    Steps that the end of an adaptive run cuts short count in the mean only.
    """

    min: float
    mean: float
    max: float


@dataclass(repr=False, eq=False)
class Result(Compared):
    """The data of a `geomint.Solution`, where its attributes are described."""

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
    restart: Restart | None = field(default=None, repr=False)
    route: str = ""

    def __repr__(self) -> str:
        end = f"{self.problem.time} = {self.tau[-1]:.9g}" if len(self.tau) else "no state saved"
        mean = "mean " if self.method.adaptive else ""
        return (
            f"<solution of {self.problem.name!r} by {self.route or self.method.name}: {self.status}, "
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
