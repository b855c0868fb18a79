"""Where all runs of a comparison end, and what they should find there.

The reference is an integration in double-double arithmetic (`reference`), or the exact flow where the
system has one (`exact`).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from ..arguments import Array
from ..errors import DomainError, FormError, GeomintError, UnknownReferenceError
from ..methods.gauss import Gauss
from ..problems.deviation import relative_error, shifted
from ..problems.problem import Problem
from ..problems.systems import Model
from .exact_reference import exact_reference
from .reference import reference_solution
from .reference_record import MARGIN, RESOLUTION, SMALL, Reference

Source = Literal["auto", "extended", "exact"]
NEAR, SAMPLES = 2.0**-26, 3
MOST_EXTENDED_STEPS = 100_000  # of gauss-8's default size: some minutes in double-double arithmetic


@dataclass(frozen=True)
class Endpoint:
    """Where all runs end, and what they should find there.

    Attributes
    ----------
    own : Problem
        The representation in whose time `end` is.
    expected : dict of name to array
        Physical quantities.
    known : float
        To what those are known, relative to each.
    """

    own: Problem
    end: dict[str, float]
    physical_end: float
    expected: dict[str, Array]
    known: float = 0.0

    def end_for(self, problem: Problem) -> dict[str, Any]:
        """Return the keyword arguments of `solve` that end a run of `problem` there."""
        if problem is self.own and "tau_end" in self.end:
            return {**self.end, "clock": False}
        return {"t_end": self.physical_end}

    def error(self, problem: Problem, y: Array) -> float:
        """Return the largest relative deviation of a physical quantity."""
        found = problem.physical_state(y)
        return relative_error(found, {n: v for n, v in self.expected.items() if n in found})

    def judged(self, problem: Problem, y: Array) -> dict[str, Any]:
        """Return `error`, `bound` and `status` of a run that ended at y.

        An error is given only where the reference is known to a tenth of it, or to a tenth of what
        float64 can show; else what it is at most.
        """
        off = self.error(problem, y)
        if MARGIN * self.known <= max(off, RESOLUTION):
            return {"error": off, "bound": off, "status": "ok"}
        status = f"not judged: the reference is known to {self.known:.2g} only"
        return {"error": None, "bound": off + self.known, "status": status}


def endpoint_of(
    model: Model, end: dict[str, float], reference: Source, report: Callable[[str], None]
) -> tuple[Endpoint, dict[str, Any]]:
    """Return where the runs of a model end, and the reference there with its numbers for reports.

    See `geomint.compare.runs.compare` for `reference` and `report`.

    Raises
    ------
    FormError, DomainError
        If there is no exact flow and it is asked for.
    UnknownReferenceError
        If the reference cannot judge even errors of 1e-5.
    """
    own = next(iter(model.problems.values()))
    if reference not in get_args(Source):
        raise DomainError("reference", reference, f"one of {list(get_args(Source))}")
    found = None
    if reference == "exact" or (reference == "auto" and _takes_minutes(model, end)):
        report("reference solution by the exact flow")
        try:
            found = _exact(model, end)
        except GeomintError as error:
            if reference == "exact" or isinstance(error, UnknownReferenceError):
                raise
    if found is None:
        report("reference solution in double-double arithmetic")
        found = _extended(model, end)
    name, problem, solution = found
    known = solution.known * _magnified(problem, solution.y)
    quantities = problem.physical_state(solution.y)
    endpoint = Endpoint(own, end, float(solution.physical_end or 0.0), quantities, known)
    numbers = {
        **solution.as_json(),
        "representation": name,
        "physical_end": endpoint.physical_end,
        "known": known,
        "quantities": {key: v.tolist() for key, v in quantities.items()},
    }
    return endpoint, numbers


def _magnified(problem: Problem, y: Array) -> float:
    """Return how many times larger a small error is in physical quantities; at least 1."""
    right = problem.physical_state(y)
    near = [shifted(problem, y, seed, NEAR)[1] for seed in range(SAMPLES)]
    return max(1.0, *(relative_error(problem.physical_state(z), right) / NEAR for z in near))


def _extended_problem(model: Model, end: dict[str, float]) -> tuple[str, Problem]:
    """Return the representation that is integrated in double-double arithmetic."""
    name, problem = next(iter(model.problems.items()))
    if "t_end" in end and problem.time == "tau":
        for other, found in model.problems.items():
            if found.time == "t" and found.field is not None:
                return other, found
        raise FormError(f"{name!r} is a problem in τ: expected tau_end in place of t_end")
    return name, problem


def _takes_minutes(model: Model, end: dict[str, float]) -> bool:
    name, problem = _extended_problem(model, end)
    (own_end,) = end.values()
    steps = abs(own_end) / Gauss(8).default_step(problem, model.states[name], own_end)
    return steps > MOST_EXTENDED_STEPS


def _extended(model: Model, end: dict[str, float]) -> tuple[str, Problem, Reference]:
    name, problem = _extended_problem(model, end)
    (own_end,) = end.values()
    found = reference_solution(problem, model.states[name], own_end, judges=SMALL)
    if problem.time != "tau":
        found = replace(found, physical_end=found.own_end)
    return name, problem, found


def _exact(model: Model, end: dict[str, float]) -> tuple[str, Problem, Reference]:
    """Return the reference by the first representation that has an exact flow."""
    own = next(iter(model.problems.values()))
    offered = [(n, p) for n, p in model.problems.items() if p.make_exact is not None]
    if "tau_end" in end:  # whose τ is meant
        offered = [(n, p) for n, p in offered if p is own]
    if not offered:
        raise FormError(f"the system of {own.name!r} has no exact flow in the time of the end")
    name, problem = offered[0]
    return name, problem, exact_reference(problem, model.states[name], end)
