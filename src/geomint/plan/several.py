"""One scene by several methods: each in the representation and at the step that suit it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

from ..errors import FormError, GeomintError, StepError
from ..kernels.compiling.sameness import Compared
from ..problems.evaluate import value
from ..problems.problem import Time
from ..run.solution import Solution
from ..run.solve import solve
from ..scene.entries import methods_and_steps
from ..scene.scene import Scene
from ..watch.drift import Drift
from ..watch.growth import NOT_FINITE
from .plan import Plan, make_plan

__all__ = ["MethodRun", "SeveralRuns", "expected_plans", "run_methods"]

INTERRUPTED = "interrupted before its first step"


@dataclass(frozen=True)
class MethodRun:
    """One method of several on a scene.

    Attributes
    ----------
    label : str
        The method's name, with its step where the name alone would not be unique.
    plan : Plan or None
        None if no representation fits.
    solution : Solution or None
        With drifts in the time of the report; what was computed if the run failed or was
        interrupted, None if nothing was.
    status, message : str
        That of the solution, ``"failed"``, ``"interrupted"`` or ``"not run"``, and why.
    """

    label: str
    plan: Plan | None
    solution: Solution | None
    status: str
    message: str = ""

    @property
    def drift(self) -> dict[str, Drift]:
        """How each quantity drifted, as far as the run went: empty if it took no step."""
        drifts = {} if self.solution is None else self.solution.drift
        return {name: drift for name, drift in drifts.items() if drift.windows.samples}

    @property
    def title(self) -> str:
        """The label, and what became of the run if it did not reach its end."""
        return self.label if self.status == "success" else f"{self.label} ({self.status})"

    @property
    def missing(self) -> dict[str, str]:
        """Quantities that its representation does not have, and where they are."""
        missing = None if self.plan is None else self.plan.missing
        return {} if missing is None else dict.fromkeys(missing.chosen, missing.reason)


@dataclass(eq=False)
class SeveralRuns(Compared):
    """All runs of a scene by several methods, in the order asked for.

    Attributes
    ----------
    time : ``"t"`` or ``"tau"``
        The time of all drifts: that in which the scene's end is given.
    physical_end : float or None
        Where methods in physical time end, if the scene's end is in τ and there are any.
    """

    scene: Scene
    time: Time
    runs: list[MethodRun] = field(default_factory=list)
    physical_end: float | None = None

    def __getitem__(self, label: str) -> MethodRun:
        return next(run for run in self.runs if run.label == label)

    def __iter__(self) -> Iterator[MethodRun]:
        return iter(self.runs)

    @property
    def status(self) -> str:
        """``"interrupted"``, ``"not finite"`` if one is, ``"failed"`` if all have, or ``"success"``."""
        found = {run.status for run in self.runs}
        if found & {"interrupted", "not run"}:
            return "interrupted"
        if NOT_FINITE in found:
            return NOT_FINITE
        return "success" if "success" in found else "failed"


def run_methods(
    scene: Scene,
    methods: Iterable[str],
    progress: bool | None = None,
    report: Callable[[MethodRun], None] = lambda run: None,
) -> SeveralRuns:
    """Integrate a scene for its drifts by several methods, one after the other.

    A method that fails does not end the others; Ctrl-C ends them all, and leaves what was computed.
    All runs end at the same place: if the scene's end is in τ, methods that need a representation
    in physical time run to the physical time that is reached there, and their times are scaled
    by the mean rate, so that all drifts are over the same axis.

    Parameters
    ----------
    scene : Scene
        As `Scene.for_drift` returns it. Its own method keeps its step and its options.
    methods : iterable of str
        Names, or ``"NAME:STEP"`` with the step in the time that the method works in.
    progress : bool, optional
        As in `geomint.solve`.
    report : callable
        Told of every run when it is over.

    Raises
    ------
    MethodError, DomainError
        For names and steps that make no sense, before anything is computed.
    """
    variants = _labelled_scenes(scene, methods)
    result = SeveralRuns(scene, "t" if scene.content.time.tau_end is None else "tau")
    interrupted = False
    for label, variant in variants.items():
        if interrupted:
            run = MethodRun(label, None, None, "not run", "the report was interrupted")
        else:
            run = _run(result, label, variant, progress)
        interrupted = interrupted or run.status == "interrupted"
        result.runs.append(run)
        report(run)
    return result


def expected_plans(
    scene: Scene, methods: Iterable[str], costs: bool = False
) -> dict[str, Plan | str]:
    """Return the plan of each method, or why there is none. Nothing is integrated.

    The physical end of methods in t is estimated by the rate at the start if the scene ends in τ.
    """

    def physical_end() -> float:
        clock, tau_end = scene.problem.clock, scene.content.time.tau_end
        assert clock is not None
        assert tau_end is not None
        return tau_end * value(scene.problem, clock, scene.state)

    plans: dict[str, Plan | str] = {}
    for label, variant in _labelled_scenes(scene, methods).items():
        try:
            plans[label] = _plan_method(variant, physical_end, costs)
        except GeomintError as error:
            plans[label] = str(error)
    return plans


def _labelled_scenes(scene: Scene, methods: Iterable[str]) -> dict[str, Scene]:
    """Return the scene with each method, by labels that are unique."""
    entries = methods_and_steps(methods)
    names = [name for name, _ in entries]
    labels = [
        name if names.count(name) == 1 or step is None else f"{name}:{step:g}"
        for name, step in entries
    ]
    return {
        label: scene.changed_integration(name, step)
        for label, (name, step) in zip(labels, entries, strict=True)
    }


def _plan_method(scene: Scene, physical_end: Callable[[], float], costs: bool = False) -> Plan:
    """Return the plan to the scene's own end, or else to the physical time that is reached there.

    Raises
    ------
    FormError
        If the method fits no representation.
    """
    try:
        return make_plan(scene, "drift", costs)
    except FormError as error:
        tau_end = scene.content.time.tau_end
        if tau_end is None:
            raise
        try:
            make_plan(scene.changed(time={"t_end": tau_end}), "drift")
        except FormError:
            raise error from None
    return make_plan(scene.changed(time={"t_end": physical_end()}), "drift", costs)


def _run(result: SeveralRuns, label: str, scene: Scene, progress: bool | None) -> MethodRun:
    def physical_end() -> float:
        if result.physical_end is None:
            result.physical_end = _physical_end(result.scene, progress)
        return result.physical_end

    plan: Plan | None = None
    try:
        plan = _plan_method(scene, physical_end)
        solution, _ = plan.attempt(progress)
    except GeomintError as error:
        return MethodRun(label, plan, None, "failed", f"{type(error).__name__}: {error}")
    except KeyboardInterrupt:
        return MethodRun(label, plan, None, "interrupted", INTERRUPTED)
    solution = _in_time_of(result, solution)
    return MethodRun(label, plan, solution, solution.status, solution.message)


def _physical_end(scene: Scene, progress: bool | None) -> float:
    """Return the physical time that the scene's own representation reaches at its end in τ."""
    tau_end = scene.content.time.tau_end
    method = "gauss-8" if scene.problem.field is not None else scene.method
    try:
        solution = solve(
            scene.problem,
            scene.state,
            tau_end=tau_end,
            method=method,
            clock=True,
            progress=progress,
        )
    except StepError as error:
        raise FormError(f"the physical time at τ = {tau_end:g} is not known: {error}") from None
    if not solution.success:
        raise KeyboardInterrupt
    return float(solution.t[-1])


def _in_time_of(result: SeveralRuns, solution: Solution) -> Solution:
    """Return a solution with its drifts in the time of the report."""
    end, tau_end = result.physical_end, result.scene.content.time.tau_end
    if solution.drift_time == result.time or end is None or tau_end is None:
        return solution
    drift = {name: d.stretched(tau_end / end) for name, d in solution.drift.items()}
    return replace(solution, drift=drift, drift_time=result.time)
