"""One method on one problem: run it, and hold it to what it states.

The rules are `geomint.stress.page.RULES`.
"""

import dataclasses
import functools
import time
import warnings
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import (
    DomainError,
    FormError,
    GeomintWarning,
    StepError,
    StepLimitError,
    UnknownReferenceError,
    raised,
)
from ..methods import Method
from ..problems.deviation import pieces_of, relative_error
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from ..run.many import Outcome, attempt
from ..run.solution import Solution
from ..run.solve import solve
from ..watch.drift import ROUNDOFF
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


def forbidden(cells: Iterable[Cell]) -> list[Cell]:
    """Return the cells with a forbidden verdict."""
    return [cell for cell in cells if cell.verdict in FORBIDDEN]


def strictly(call: Callable[[], Any]) -> Any:
    """Return what a call returns; a warning that geomint does not give on purpose is an error."""
    with warnings.catch_warnings(action="error"):
        warnings.simplefilter("ignore", GeomintWarning)
        return call()


@dataclasses.dataclass
class Trial:
    """A problem, an initial state and the runs to make of it; shared by all methods.

    Parameters
    ----------
    problem : Problem
    y0 : array
    span, fraction, step, steps, steady
        See `geomint.StressCase`.
    reference : callable, optional
        ``reference(end) -> KnownEnd or None``, or a typed error that says why there is none; by default
        that of the problem itself.
    physical : bool
        Whether that is in physical quantities.
    """

    problem: Problem
    y0: Array
    _: dataclasses.KW_ONLY
    span: float = 2.0
    fraction: float | None = None
    step: float | None = None
    steps: int = 1
    steady: bool = False
    reference: Callable[[float], KnownEnd | None] | None = None
    physical: bool = False

    def __post_init__(self) -> None:
        self.quantities = Quantities(self.problem, self.y0)
        self.time = characteristic_time(self.problem, self.y0)
        if self.fraction is not None:
            self.step = self.fraction * self.time
        self._known_ends: dict[float, tuple[KnownEnd | None, str]] = {}
        self._scales: dict[tuple[str, bool], float] = {}

    def plan(self, method: Method) -> tuple[float, int]:
        """Return the end in the problem's own time and the number of steps."""
        if self.step is not None:
            return self.step * self.steps, self.steps
        return self.span * self.time, max(1, int(np.ceil(self.span / method.step_fraction)))

    def known_end(self, end: float, steps: int) -> tuple[KnownEnd | None, str]:
        """Return the reference at `end`, or None and the reason why it is not known."""
        if abs(end) / steps > LONGEST * self.time:
            return None, "no reference for steps this long"
        if end not in self._known_ends:
            reference = self.reference or functools.partial(known_end, self.problem, self.y0)
            try:
                self._known_ends[end] = reference(end), "no reference"
            except (StepError, FormError, UnknownReferenceError) as error:
                self._known_ends[end] = None, f"no reference ({raised(error)})"
        return self._known_ends[end]

    def attempt(self, end: float, method: Method, steps: int, *start: Any) -> Outcome:
        """Integrate, from another problem and state if given; an unintended warning is an error.

        An adaptive method takes the step as its first one, if the case says what it is.
        """
        free = method.adaptive and self.step is None
        ends: dict[str, Any] = {"tau_end" if self.problem.time == "tau" else "t_end": end}
        run = functools.partial(
            solve,
            *(start or (self.problem, self.y0)),
            method=method.with_options(max_steps=MOST_STEPS) if method.adaptive else method,
            step=None if free else abs(end) / steps,
            save_every=SPARSE if method.adaptive else max(1, steps // LOOKS),
            **ends,
        )
        return strictly(functools.partial(attempt, run))

    def run(self, *args: Any) -> Solution:
        """Return the solution of an attempt, or raise its error."""
        return self.attempt(*args).result()

    def end_state(self, end: float, method: Method, steps: int) -> Array:
        """Return the last state of a run."""
        return self.run(end, method, steps).y[-1]

    def own_condition(self, method: Method, end: float, steps: int) -> float:
        """Return what a relative change grows to along the method's own run."""

        def from_other(problem: Problem, y0: Array) -> Array:
            return self.run(end, method, steps, problem, y0).y[-1]

        return condition_of(self.problem, self.y0, from_other, self.named)

    def shortest_time(self, states: Array) -> float:
        """Return the shortest time of the motion at those states, see the module's docstring."""
        times = [SEPARATIONS * self.separation_time]
        for y in states:
            try:
                times.append(characteristic_time(self.problem, y))
            except DomainError:  # numbers so large that their derivative is not finite
                return 0.0
        return min(times)

    @functools.cached_property
    def separation_time(self) -> float:
        """What `geomint.stress.known_end.separation_time` is at the initial state."""
        return separation_time(self.problem, self.y0)

    @functools.cached_property
    def field_rounding(self) -> float:
        """What `geomint.stress.known_end.field_rounding` is at the initial state."""
        return field_rounding(self.problem, self.y0)

    def named(self, y: Array) -> dict[str, Array]:
        """Return what states are compared by."""
        return self.problem.physical_state(y) if self.physical else pieces_of(self.problem, y)

    def scale(self, name: str, pieces: bool) -> float:
        """Return what a rounding error of a quantity is measured against, at the initial state."""
        if (name, pieces) not in self._scales:
            self._scales[name, pieces] = self.quantities.scale(name, 0.0, self.y0, pieces)
        return self._scales[name, pieces]

    def scale_along(self, name: str, solution: Solution, pieces: bool) -> float:
        """Return the larger of the scales at the ends of a run."""
        last = self.quantities.scale(name, solution.tau[-1], solution.y[-1], pieces)
        return max(self.scale(name, pieces), last)


def judge(trial: Trial, method: Method) -> Found:
    """Return what `Cell` says of a method on a trial, from `verdict` on."""
    begun = time.perf_counter()
    found = _judged(trial, method)
    return {**found, "seconds": time.perf_counter() - begun}


def _judged(trial: Trial, method: Method) -> Found:
    try:
        end, steps = trial.plan(method)
        common = {"h": abs(end) / steps / trial.time, "steps": steps}
    except Exception as error:
        return verdict_of("untyped", error)
    try:
        outcome = trial.attempt(end, method, steps)
    except Exception as error:
        return {**common, **verdict_of("untyped", error)}
    if isinstance(outcome.error, StepError):
        return {**common, **_failed(outcome.error)}
    if outcome.error is not None:
        return {**common, **verdict_of("refused", outcome.error)}
    solution = outcome.result()
    if method.adaptive:
        common = {"h": abs(end) / solution.steps / trial.time, "steps": solution.steps}
    if not np.isfinite(solution.y).all() or not np.isfinite(solution.tau).all():
        message = "success, with numbers that are not finite"
        return {**common, "verdict": "wrong", "message": message}
    lost = _lost(trial, method, solution, end)
    if lost is not None:
        return {**common, **lost}
    return {**common, **_accuracy(trial, method, solution, end, steps)}


def verdict_of(verdict: str, error: Exception) -> Found:
    """Return what a verdict by an error says."""
    return {"verdict": verdict, "message": raised(error)}


def _failed(error: StepError) -> Found:
    """Hold a typed error of a step to what it is to carry: where, what is left, a finite partial."""
    found = {**verdict_of("failed", error), "quantity": "residual", "error": error.residual}
    partial = error.partial
    if not (np.isfinite(error.t) and error.step >= 0) or partial is None:
        return {**found, "verdict": "wrong", "message": f"an error without its place: {error!r}"}
    if not np.isfinite(partial.y).all():
        return {**found, "verdict": "wrong", "message": f"a partial that is not finite: {error}"}
    return found


def _lost(trial: Trial, method: Method, solution: Solution, end: float) -> Found | None:
    """Return the verdict on the worst preserved quantity if it is lost, else None."""
    found = []
    turns = max(1.0, abs(end) / trial.time)
    # Orbits are kept with any generator; all else with what rounding makes of the field.
    noise = trial.field_rounding * abs(end) if method.needs != "action" else 0.0
    for name, defect in trial.quantities.preserved(method.keeps).items():
        first = trial.quantities.value(name, 0.0, trial.y0)
        values = [
            trial.quantities.value(name, t, y)
            for t, y in zip(solution.tau, solution.y, strict=True)
        ]
        off = float(np.max(np.abs(np.array(values) - first)))
        scale = trial.scale_along(name, solution, _iterates(method))
        if off <= (ROUNDOFF * turns + defect) * scale:
            continue
        off = max(off - noise * trial.scale_along(name, solution, True), 0.0)
        error = 0.0 if off == 0.0 else off / scale if scale > 0.0 and off < np.inf else np.inf
        found.append((error, defect, name))
    if not found:
        return None
    roundings = ROUNDOFF * max(turns, _rounded(trial, solution, end))
    error, defect, name = max(found, key=lambda one: one[0] / (roundings + one[1]))
    if error <= roundings + defect:
        return None
    return {
        "verdict": "wrong",
        "message": f"{name} is to be preserved",
        "quantity": name,
        "error": error,
        "allowed": roundings + defect,
    }


def _iterates(method: Method) -> bool:
    """Tell whether what a method keeps is found by iterations: Gauss methods and RATTLE."""
    return "quadratic invariants" in method.keeps or method.needs == "hamiltonian"


def _rounded(trial: Trial, solution: Solution, end: float) -> float:
    """Return how often a run rounds changes of the size of the state: once in a step at most."""
    shortest = trial.shortest_time(solution.y)
    fast = abs(end) / shortest if shortest > 0.0 else np.inf
    return min(fast, float(solution.steps))


def _accuracy(trial: Trial, method: Method, solution: Solution, end: float, steps: int) -> Found:
    """Return the verdict on the state at the end."""
    known, why_not = trial.known_end(end, steps)
    notes = [] if known else [f"{why_not}: compared with a finer run"]

    def error_of(y: Array, finer: tuple[Method, int]) -> float:
        right = known.pieces if known else trial.named(trial.end_state(end, *finer))
        return relative_error(trial.named(y), right)

    sure = {"known": known.known, "confirmed": known.confirmed} if known else {}
    found = {**sure}
    exact = trial.steady and "steady motions" in method.keeps
    hopeless = False
    try:
        condition = known.condition if known else trial.own_condition(method, end, steps)
        turns = max(1.0, abs(end) / trial.time)
        floor = condition * (ROUNDOFF * turns + trial.field_rounding * abs(end))
        if method.adaptive:
            floor = max(floor, condition * _tolerance(trial, method) * solution.steps)
        error = error_of(solution.y[-1], _finer(method, steps, 1))
        found = {**sure, "error": error, "allowed": floor}
        good = error <= min(floor, RESOLVED)
        if error <= RESOLVED and not (good or exact or method.adaptive):
            good = _shows_order(trial, method, end, steps, error, floor, error_of, notes)
        if good:
            return {**found, "verdict": "ok", "message": "; ".join(notes)}
        hopeless = floor > RESOLVED
    except StepError as failure:
        notes.append(f"a finer run: {failure}")
        hopeless = isinstance(failure, StepLimitError)
    default = method.step_fraction * trial.shortest_time(solution.y)
    long = not method.adaptive and abs(end) / steps > default * (1.0 + 1e-9)
    verdict = "unresolved" if hopeless or (long and not exact) else "wrong"
    return {**found, "verdict": verdict, "message": "; ".join(notes)}


def _shows_order(
    trial: Trial,
    method: Method,
    end: float,
    steps: int,
    error: float,
    floor: float,
    error_of: Callable[[Array, tuple[Method, int]], float],
    notes: list[str],
) -> bool:
    """Tell whether the error falls as the order wants, soon, when the step is halved."""
    wanted = 2.0 ** (0.5 * min(method.order, FULL_ORDER))
    for times in range(1, HALVINGS + 1):
        y = trial.end_state(end, *_finer(method, steps, times))
        finer = error_of(y, _finer(method, steps, times + 1))
        notes.append(f"{finer:.3g} at 1/{2**times} of the step")
        if finer <= max(floor, error / wanted):
            return True
        error = finer
    return False


def _finer(method: Method, steps: int, times: int) -> tuple[Method, int]:
    """Return the method and number of steps of a run at half the step, or at 1/16 the tolerance."""
    if not method.adaptive:
        return method, steps * 2**times
    options = {name: method.options[name] / 16.0**times for name in ("rtol", "atol")}
    return method.with_options(**options), steps


def _tolerance(trial: Trial, method: Method) -> float:
    """Return what an adaptive method lets a step err, relative to the smallest piece."""
    sizes = [float(np.max(np.abs(piece))) for piece in pieces_of(trial.problem, trial.y0).values()]
    smallest = min((size for size in sizes if size > 0.0), default=1.0)
    return float(method.options["rtol"] + method.options["atol"] / smallest)
