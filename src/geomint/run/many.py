"""Runs one after the other, and what came out of each, whatever that is.

Drift reports, comparisons and stress tests carry out their runs here. A run that fails ends no
other; Ctrl-C ends all that are left.
"""

import math
import statistics
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TypeVar

from ..errors import GeomintError, StepError, raised
from .solution import Solution

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Outcome:
    """What came out of a run.

    Attributes
    ----------
    solution : Solution or None
        What was computed if the run failed or was interrupted, None if nothing was.
    status, message : str
        That of the solution; ``"failed"`` or ``"interrupted"``, and why, where there is none.
    error : GeomintError or None
        That of a run that failed.
    seconds, compile_seconds : float
        Median run time of the repeats, without compilation; compilation in all of them.
    repeats : int
        How often it was carried out.
    """

    solution: Solution | None
    status: str
    message: str = ""
    error: GeomintError | None = None
    seconds: float = 0.0
    compile_seconds: float = 0.0
    repeats: int = 0

    def result(self) -> Solution:
        """Return the solution, or raise the error that ended the run."""
        if self.error is not None:
            raise self.error
        if self.solution is None:
            raise KeyboardInterrupt
        return self.solution


def attempt(
    run: Callable[..., Solution],
    progress: bool | None = False,
    repeats: int = 1,
    enough: float = math.inf,
) -> Outcome:
    """Carry a run out, as far as it goes; typed errors and Ctrl-C become its outcome.

    Parameters
    ----------
    run : callable
        ``run(progress=…)``, such as ``partial(solve, problem, y0, method=…, step=…, t_end=…)`` or the
        `solve` of a plan.
    progress : bool, optional
        As in `geomint.solve`.
    repeats : int
        How often to run, to the same solution: for the run time.
    enough : float
        Seconds after which it is not repeated.
    """
    seconds = []
    compiling = 0.0
    try:
        while True:
            solution = run(progress=progress)
            seconds.append(solution.run_seconds)
            compiling += solution.compile_seconds
            if len(seconds) >= repeats or sum(seconds) > enough or not solution.success:
                break
    except KeyboardInterrupt:
        return Outcome(None, "interrupted", "interrupted before its first step")
    except GeomintError as error:
        partial = error.partial if isinstance(error, StepError) else None
        if partial is None:
            return Outcome(None, "failed", raised(error), error)
        return Outcome(partial, partial.status, partial.message, error, partial.run_seconds)
    median = statistics.median(seconds)
    return Outcome(
        solution, solution.status, solution.message, None, median, compiling, len(seconds)
    )


def run_many(outcomes: Iterable[T], listener: Callable[[T], None]) -> bool:
    """Tell a listener what came out of runs, in turn; return whether all were: False after Ctrl-C.

    Parameters
    ----------
    outcomes : iterable
        Carries a run out when it is asked for the next one. So each may depend on what the listener
        has heard of those before.
    listener : callable
        ``listener(outcome)`` is told of every run when it is over. It may end them all, as Ctrl-C
        does, by raising KeyboardInterrupt.
    """
    try:
        for outcome in outcomes:
            listener(outcome)
    except KeyboardInterrupt:
        return False
    return True
