"""One method on one problem: run it, and hold it to what it states.

The rules are `geomint.stress.report.RULES`.
"""

import dataclasses
import functools
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import (
    DeclarationError,
    DomainError,
    FormError,
    Gathered,
    GeomintError,
    GeomintWarning,
    StepError,
    StepLimitError,
    UnknownReferenceError,
    raised,
)
from ..methods import Method
from ..problems.deviation import pieces_of, relative_error, sizes_of
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from ..run.solution import Solution
from ..run.solve import solve
from ..watch.drift import ROUNDOFF
from .case import StressCase
from .known_end import KnownEnd, condition_of, field_rounding, known_end, separation_time
from .preserved import Quantities

ALLOWED = ("ok", "unresolved", "failed", "refused")
FORBIDDEN = ("wrong", "untyped", "hung")
VERDICTS = ALLOWED + FORBIDDEN

RESOLVED = 0.1  # an error of this size is none of an order
HALVINGS = 3  # within which the order must show
FULL_ORDER = 8  # beyond it, the order need not show at steps of the size that is useful
SPARSE = 64  # steps of adaptive methods between looks
LOOKS = 8  # how often in a run the preserved quantities are looked at
SEPARATIONS = 10.0  # in most motions so many separation times are the characteristic time, or more
MOST_STEPS = 200_000  # of an adaptive method in a run
LONGEST = 10.0  # characteristic times: no reference is computed for longer steps


Found = dict[str, Any]  # what a `Cell` says, from its verdict on


@dataclasses.dataclass(frozen=True)
class Cell:
    """A verdict, and the numbers that it rests on.

    Attributes
    ----------
    system, axis, label, method : str
    value : float
        On the axis.
    verdict : str
        One of `VERDICTS`.
    quantity : str
        What `error` is of: ``"state"``, or the preserved quantity that is worst off.
    error, allowed : float or None
        `error` is relative for the state; of preserved quantities relative to their scale.
    h : float or None
        Step, in characteristic times.
    known, confirmed : float or None
        To what the reference is known, and to what a second method confirms it; None without one.
    seconds : float
        Of the computation, compilations included.
    """

    system: str
    axis: str
    value: float
    label: str
    n: int
    method: str
    verdict: str
    message: str = ""
    quantity: str = "state"
    error: float | None = None
    allowed: float | None = None
    h: float | None = None
    steps: int | None = None
    known: float | None = None
    confirmed: float | None = None
    seconds: float = 0.0


def strictly(call: Callable[[], Any]) -> Any:
    """Return what a call returns; a warning that geomint does not give on purpose is an error."""
    with warnings.catch_warnings(action="error"):
        warnings.simplefilter("ignore", GeomintWarning)
        return call()


class Trial:
    """A case in one of its representations, and the runs to make of it; shared by all methods."""

    def __init__(self, case: StressCase, representation: str) -> None:
        self.case, model = case, strictly(case.build)
        self.problem, self.y0 = model.problems[representation], model.states[representation]
        self.quantities = Quantities(self.problem, self.y0)
        self.time = characteristic_time(self.problem, self.y0)
        self.separation_time = separation_time(self.problem, self.y0)
        self.field_rounding = field_rounding(self.problem, self.y0)
        other = model.problems.get(case.reference or "")
        self.physical = other is not None and other.time == self.problem.time
        self.named = functools.partial(
            Problem.physical_state if self.physical else pieces_of, self.problem
        )  # what states are compared by
        name = case.reference if case.reference and self.physical else representation
        self.source = model.problems[name], model.states[name]
        self.reference_or_why_not = functools.cache(self._reference_or_why_not)

    def plan(self, method: Method) -> tuple[float, int]:
        """Return the end in the problem's own time and the number of steps."""
        case = self.case
        if case.step is not None:
            return case.step * case.steps, case.steps
        return case.span * self.time, max(1, int(np.ceil(case.span / method.step_fraction)))

    def reference(self, end: float) -> KnownEnd | None:
        """Return the reference at `end`, of another representation where the case says so."""
        return known_end(*self.source, end, self.physical)

    def _reference_or_why_not(self, end: float) -> tuple[KnownEnd | None, str]:
        try:
            return self.reference(end), "no reference"
        except (StepError, FormError, DeclarationError, UnknownReferenceError) as error:
            return None, f"no reference ({raised(error)})"

    def run(self, method: Method, end: float, steps: int, *start: Any) -> Solution:
        """Integrate, from another problem and state if given; an unintended warning is an error.

        An adaptive method takes the step as its first one, if the case says what it is.
        """
        adaptive, step = method.adaptive, abs(end) / steps
        options: dict[str, Any] = {
            "tau_end" if self.problem.time == "tau" else "t_end": end,
            "method": method.with_options(max_steps=MOST_STEPS) if adaptive else method,
            "step": None if adaptive and self.case.step is None else step,
            "save_every": SPARSE if adaptive else max(1, steps // LOOKS),
        }
        given = start or (self.problem, self.y0)
        return strictly(functools.partial(solve, *given, progress=False, **options))

    def shortest_time(self, states: Array) -> float:
        """Return the shortest time of the motion at those states, see the module's docstring."""
        try:
            times = [characteristic_time(self.problem, y) for y in states]
        except DomainError:  # numbers so large that their derivative is not finite
            return 0.0
        return min(SEPARATIONS * self.separation_time, *times)


def judge(trial: Callable[[], Trial], method: Method) -> Found:
    """Return what `Cell` says of a method on a trial, from `verdict` on."""
    begun = time.perf_counter()
    try:
        with Gathered(quiet=True):
            found = _judged(trial, method)
    except Exception as error:
        found = verdict_of("untyped", error)
    return {**found, "seconds": time.perf_counter() - begun}


def _judged(make: Callable[[], Trial], method: Method) -> Found:
    common: Found = {}
    try:
        trial = make()
        end, steps = trial.plan(method)
        common = {"h": abs(end) / steps / trial.time, "steps": steps}
        solution = trial.run(method, end, steps)
    except StepError as error:
        return {**common, **_failed(error)}
    except GeomintError as error:
        return {**common, **verdict_of("refused", error)}
    if method.adaptive:
        common = {"h": abs(end) / solution.steps / trial.time, "steps": solution.steps}
    if not np.isfinite(solution.y).all() or not np.isfinite(solution.tau).all():
        message = "success, with numbers that are not finite"
        return {**common, "verdict": "wrong", "message": message}
    lost = _lost(trial, method, solution, end)
    return {**common, **(lost or _accuracy(trial, method, solution, end, steps))}


def verdict_of(verdict: str, error: Exception) -> Found:
    """Return what a verdict by an error says."""
    return {"verdict": verdict, "message": raised(error)}


def _failed(error: StepError) -> Found:
    """Hold a typed error of a step to what it is to carry: where, what is left, a finite partial."""
    found = {**verdict_of("failed", error), "quantity": "residual", "error": error.residual}
    if not (np.isfinite(error.t) and error.step >= 0) or error.partial is None:
        return {**found, "verdict": "wrong", "message": f"an error without its place: {error!r}"}
    if not np.isfinite(error.partial.y).all():
        return {**found, "verdict": "wrong", "message": f"a partial that is not finite: {error}"}
    return found


def _lost(trial: Trial, method: Method, solution: Solution, end: float) -> Found | None:
    """Return the verdict on the worst preserved quantity if it is lost, else None."""
    turns, lost = max(1.0, abs(end) / trial.time), {}
    # Orbits are kept with any generator; all else with what rounding makes of the field.
    noise = trial.field_rounding * abs(end) if method.needs != "action" else 0.0
    for name, defect in trial.quantities.preserved(method.keeps).items():
        places = list(zip(solution.tau, solution.y, strict=True))
        values = np.array([trial.quantities.value(name, t, y) for t, y in places])
        off = float(np.max(np.abs(values - values[0])))
        scale = max(trial.quantities.scale(name, *place) for place in (places[0], places[-1]))
        error = 0.0 if off == 0.0 else off / scale if scale > 0.0 and off < np.inf else np.inf
        if error > ROUNDOFF * turns + defect + noise:
            lost[name] = error, defect + noise
    if not lost:
        return None
    # A run rounds changes of the size of the state once in a step at most.
    shortest = trial.shortest_time(solution.y)
    fast = abs(end) / shortest if shortest > 0.0 else np.inf
    roundings = ROUNDOFF * max(turns, min(fast, float(solution.steps)))
    name, (error, more) = max(lost.items(), key=lambda one: one[1][0] / (roundings + one[1][1]))
    if error <= roundings + more:
        return None
    found = {"quantity": name, "error": error, "allowed": roundings + more}
    return {"verdict": "wrong", "message": f"{name} is to be preserved", **found}


def _accuracy(trial: Trial, method: Method, solution: Solution, end: float, steps: int) -> Found:
    """Return the verdict on the state at the end."""
    known, why_not = None, "no reference for steps this long"
    if abs(end) / steps <= LONGEST * trial.time:
        known, why_not = trial.reference_or_why_not(end)
    notes = [] if known else [f"{why_not}: compared with a finer run"]

    def end_of(times: int, *start: Any) -> dict[str, Array]:
        """Return the end of a run at a step halved, or a tolerance divided by 16, so many times."""
        if not method.adaptive:
            return trial.named(trial.run(method, end, steps * 2**times, *start).y[-1])
        finer = {name: method.options[name] / 16.0**times for name in ("rtol", "atol")}
        return trial.named(trial.run(method.with_options(**finer), end, steps, *start).y[-1])

    def error_of(here: dict[str, Array], times: int) -> float:
        """Return the error of a run that is so many times finer."""
        return relative_error(here, known.pieces if known else end_of(times + 1))

    def shows_order(error: float) -> bool:
        """Tell whether the error falls as the order wants, soon, when the step is halved."""
        for times in range(1, HALVINGS + 1):
            finer = error_of(end_of(times), times)
            notes.append(f"{finer:.3g} at 1/{2**times} of the step")
            if finer <= max(floor, error / 2.0 ** (0.5 * min(method.order, FULL_ORDER))):
                return True
            error = finer
        return False

    found: Found = {"known": known.known, "confirmed": known.confirmed} if known else {}
    exact = trial.case.steady and "steady motions" in method.keeps
    try:
        own_end = functools.partial(end_of, 0)
        condition = known.condition if known else condition_of(trial.problem, trial.y0, own_end)
        turns = max(1.0, abs(end) / trial.time)
        floor = condition * (ROUNDOFF * turns + trial.field_rounding * abs(end))
        if method.adaptive:
            smallest = float(np.min(sizes_of(trial.problem, trial.y0)))
            tolerance = method.options["rtol"] + method.options["atol"] / smallest
            floor = max(floor, condition * tolerance * solution.steps)
        error = error_of(trial.named(solution.y[-1]), 0)
        found |= {"error": error, "allowed": floor}
        good = error <= min(floor, RESOLVED)
        fixed = not (exact or method.adaptive)
        if good or (error <= RESOLVED and fixed and shows_order(error)):
            return {**found, "verdict": "ok", "message": "; ".join(notes)}
        hopeless = floor > RESOLVED
    except StepError as failure:
        notes.append(f"a finer run: {failure}")
        hopeless = isinstance(failure, StepLimitError)
    default = method.step_fraction * trial.shortest_time(solution.y)
    long = not method.adaptive and abs(end) / steps > default * (1.0 + 1e-9)
    verdict = "unresolved" if hopeless or (long and not exact) else "wrong"
    return {**found, "verdict": verdict, "message": "; ".join(notes)}
