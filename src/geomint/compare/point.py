"""A point of a comparison."""

from dataclasses import dataclass
from typing import Any

MAX_SECONDS = 30.0  # a point whose single run would take longer is not run, and says so
REPEATS, ENOUGH = 3, 1.0  # runs of a point, fewer where together they have taken so many seconds


def timed_runs(repeats: int | None) -> tuple[int, float]:
    """Return how many runs of a point are timed, and the seconds after which there are no more."""
    return (REPEATS, ENOUGH) if repeats is None else (repeats, MAX_SECONDS)


@dataclass(frozen=True)
class Point:
    """One method at one step, or an adaptive one, or a peer, at one tolerance.

    Attributes
    ----------
    step : float
        Of an adaptive method the mean step; 0 if it did not get there.
    tolerance, rtol : float or None
        Of an implicit method; of an adaptive one.
    error : float or None
        Largest deviation of a physical quantity from the reference at the end, relative to the
        largest entry of that quantity. None where there is no result, or one that is nearer to the
        reference than ten times what that is known to.
    bound : float or None
        What the error is at most: the same, or the deviation and what the reference is known to.
    iterations : int or None
        Of all steps of an implicit method.
    newton : bool
        Whether Newton's method took some of the steps, as `geomint.Solution.newton`.
    seconds : float or None
        Median run time of the repeats, without compilation.
    status : str
        ``"ok"``, or why there is no result or no error.
    peer : str or None
        Package and version of a peer; None for geomint's methods.
    warnings : tuple of dict
        What the run has warned of, as `geomint.Solution.warnings`, each as JSON has it.
    """

    method: str
    order: int
    representation: str
    step: float
    tolerance: float | None
    error: float | None = None
    seconds: float | None = None
    steps: int | None = None
    evaluations: int | None = None
    repeats: int = 0
    status: str = "ok"
    rtol: float | None = None
    bound: float | None = None
    peer: str | None = None
    warnings: tuple[dict[str, Any], ...] = ()
    iterations: int | None = None
    newton: bool = False
