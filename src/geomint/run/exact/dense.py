"""Dense output of a run without steps: the exact motion at any time of the run."""

from typing import Any

from ...arguments import Array
from ...problems.problem import Problem
from ..dense import Kept, Output
from .path import ExactPath


class ExactOutput(Output):
    """The states of an exact motion at any time of a run: ``sol.sol(t)``, or ``sol.sol(tau=…)``.

    What is kept is the state where the motion was begun, that where the run began, and its end.
    """

    def __init__(self, problem: Problem, kept: Kept) -> None:
        super().__init__(problem, kept.times[1:], kept.states[1:])
        self._made = problem, kept
        origin, y0 = float(kept.times[0]), kept.states[0]
        physical = float(y0[-1]) if self.clock else origin
        self._path = ExactPath(problem, y0[: problem.rows].copy(), origin, physical)

    def __reduce__(self) -> Any:
        return ExactOutput, self._made

    def own_times(self, t: Array) -> Array:
        """Return those of the motion."""
        return self._path.own(t)

    def _found(self, times: Array, by_clock: bool) -> Array:
        return self._path.at_physical(times) if by_clock else self._path.states(times)
