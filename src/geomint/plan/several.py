"""One scene by one or several methods: each in the representation and at the step that suit it.

`warm` compiles what the commands of a scene run, ahead of them: they find it in the cache.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

from ..errors import ByName, FormError, Gathered, GeomintError, StepError
from ..kernels.compiling.sameness import Compared
from ..methods.registry import AUTO
from ..problems.evaluate import value
from ..problems.problem import Time
from ..run.many import Outcome, attempt, run_many
from ..run.reported import Reported
from ..run.solution import Solution
from ..run.solve import solve
from ..scene.entries import methods_and_steps
from ..scene.scene import Scene
from ..watch.drift import Drift
from ..watch.growth import NOT_FINITE
from .first_turns import FirstTurns, first_turns
from .plan import Plan, make_plan


@dataclass(frozen=True)
class MethodRun:
    """One method on a scene.

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
    error : GeomintError or None
        That of a run that failed.
    end : float
        Where the solution ends, in the time of its drifts.
    """

    label: str
    plan: Plan | None
    solution: Solution | None
    status: str
    message: str = ""
    error: GeomintError | None = field(default=None, compare=False, repr=False)
    end: float = 0.0

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
    def representation(self) -> str | None:
        """The name of the representation that is integrated; None if none fits."""
        return None if self.plan is None else self.plan.route.name

    @property
    def missing(self) -> dict[str, str]:
        """Quantities that its representation does not have, and where they are."""
        missing = None if self.plan is None else self.plan.missing
        return {} if missing is None else dict.fromkeys(missing.chosen, missing.reason)


@dataclass(eq=False)
class SeveralRuns(Compared, Reported):
    """All runs of a scene, a method each, in the order asked for.

    A sequence of `MethodRun`; ``runs["gauss-8"]`` is the one with that label, ``runs[0]`` the first.

    Attributes
    ----------
    physical_end : float or None
        Where methods in physical time end, if the scene's end is in τ and there are any.
    motion : FirstTurns or None
        The first turns by the first method that got anywhere, for pictures.
    """

    scene: Scene
    runs: list[MethodRun] = field(default_factory=list)
    physical_end: float | None = None
    motion: FirstTurns | None = None

    @property
    def time(self) -> Time:
        """The time of all drifts, ``"t"`` or ``"tau"``: that in which the scene's end is given."""
        return "t" if self.scene.content.time.tau_end is None else "tau"

    @property
    def time_label(self) -> str:
        """Its name with its unit, for axes."""
        return f"{'τ' if self.time == 'tau' else 't'} ({self.scene.problem.unit(self.time)})"

    def unit(self, name: str) -> str:
        """Return the unit of a quantity."""
        plans = [run.plan for run in self.runs if run.plan is not None and name in run.drift]
        return plans[0].problem.unit(name) if plans else ""

    def __getitem__(self, which: str | int) -> MethodRun:
        if isinstance(which, int):
            return self.runs[which]
        return ByName({run.label: run for run in self.runs}, "runs")[which]

    def __iter__(self) -> Iterator[MethodRun]:
        return iter(self.runs)

    def __len__(self) -> int:
        return len(self.runs)

    @property
    def status(self) -> str:
        """``"interrupted"``, ``"not finite"`` if one is, ``"failed"`` if all have, or ``"success"``."""
        found = {run.status for run in self.runs}
        if found & {"interrupted", "not run"}:
            return "interrupted"
        if NOT_FINITE in found:
            return NOT_FINITE
        return "success" if "success" in found else "failed"


class Variant(NamedTuple):
    """A scene with one method, and its plan, or why it has none.

    Attributes
    ----------
    in_t : bool
        Whether it is in physical time, while the scene ends in τ: it ends at the physical time that is
        reached there, which the plan only estimates by the rate at the start.
    """

    scene: Scene
    plan: Plan | None
    error: GeomintError | None = None
    in_t: bool = False


@dataclass(frozen=True, eq=False)
class Variants(Compared):
    """A scene with one or several methods, each planned, by labels that are unique."""

    scene: Scene
    each: Mapping[str, Variant]

    @property
    def plans(self) -> list[Plan]:
        """Those that there are."""
        return [variant.plan for variant in self.each.values() if variant.plan is not None]

    @property
    def notes(self) -> list[str]:
        """What is asked for and done by none of the plans, in words."""
        return common_notes(self.plans)


def plan_methods(scene: Scene, methods: Iterable[str], costs: bool = False) -> Variants:
    """Return the plans of a scene by one or several methods. Nothing is integrated.

    Parameters
    ----------
    scene : Scene
        As `Scene.for_drift` returns it. Its own method keeps its step and its options.
    methods : iterable of str
        Names, or ``"NAME:STEP"`` with the step in the time that the method works in.
    costs : bool
        As in `make_plan`.

    Raises
    ------
    GeomintError
        That of the first method, if none has a plan; for names and steps that make no sense.
    """
    found = {}
    for label, variant in _labelled_scenes(scene, methods).items():
        try:
            found[label] = _planned(variant, costs)
        except GeomintError as error:
            found[label] = Variant(variant, None, error)
    errors = [variant.error for variant in found.values() if variant.error is not None]
    if len(errors) == len(found):
        raise errors[0]
    return Variants(scene, found)


def run_methods(
    scene: Scene | Variants,
    methods: Iterable[str] = (),
    progress: bool | None = None,
    report: Callable[[MethodRun], None] = lambda run: None,
) -> SeveralRuns:
    """Integrate a scene for its drifts by one or several methods, one after the other.

    A method that fails does not end the others; Ctrl-C ends them all, and leaves what was computed.
    All runs end at the same place: if the scene's end is in τ, methods that need a representation
    in physical time run to the physical time that is reached there, and their times are scaled
    by the mean rate, so that all drifts are over the same axis.

    Parameters
    ----------
    scene : Scene, or what `plan_methods` gives
    methods : iterable of str
        As `plan_methods` takes them.
    progress : bool, optional
        As in `geomint.solve`.
    report : callable
        Told of every run when it is over.

    Raises
    ------
    MethodError, DomainError
        For names and steps that make no sense, before anything is computed.
    FormError
        Or another error, that of the first, if every method fails before its first step. After
        Ctrl-C before any, KeyboardInterrupt.
    """
    variants = plan_methods(scene, methods) if isinstance(scene, Scene) else scene
    result, plans = SeveralRuns(variants.scene), {}

    def planned(label: str, progress: bool | None) -> Solution:
        variant = variants.each[label]
        if variant.error is not None:
            raise variant.error
        plan = variant.plan
        if variant.in_t:
            if result.physical_end is None:
                result.physical_end = _physical_end(variants.scene, progress)
            plan = make_plan(variant.scene.changed(time={"t_end": result.physical_end}), "drift")
        assert plan is not None
        plans[label] = plan
        return plan.solve(progress)

    def take(run: MethodRun) -> None:
        result.runs.append(run)
        report(run)
        if run.status == "interrupted":
            raise KeyboardInterrupt

    outcomes = ((label, attempt(partial(planned, label), progress)) for label in variants.each)
    run_many((_method_run(result, label, plans.get(label), o) for label, o in outcomes), take)
    for label in list(variants.each)[len(result) :]:
        take(MethodRun(label, None, None, "not run", "the report was interrupted"))
    if all(run.solution is None for run in result):
        raise (result.status == "failed" and result[0].error) or KeyboardInterrupt
    plan = next(run.plan for run in result if run.solution is not None)
    if plan is not None and result.status != "interrupted":
        result.motion = first_turns(plan)
    return result


def run_plan(plan: Plan, progress: bool | None = None) -> SeveralRuns:
    """Carry one plan out, as far as it goes.

    Raises
    ------
    GeomintError
        If nothing was computed.
    """
    outcome = attempt(plan.solve, progress)
    if outcome.solution is None:
        outcome.result()
    result = SeveralRuns(plan.scene)
    result.runs.append(_method_run(result, plan.scene.method.name, plan, outcome))
    return result


def common_notes(plans: Iterable[Plan]) -> list[str]:
    """Return what is asked for and done by none of the plans, in words."""
    notes = [plan.notes for plan in plans]
    return [note for note in dict.fromkeys(sum(notes, ())) if all(note in own for own in notes)]


def drift_methods(scene: Scene) -> list[str]:
    """Return the methods of a drift report: those of ``[drift]``, or the scene's own alone."""
    own = scene.content.integrate.method
    return scene.content.drift.methods or [scene.method.name if own == AUTO else own]


def _labelled_scenes(scene: Scene, methods: Iterable[str]) -> dict[str, Scene]:
    """Return the scene with each method, by labels that are unique."""
    given = list(methods)
    entries = methods_and_steps(given)
    names = [name for name, _ in entries]
    labels = [
        name if names.count(name) == 1 or step is None else f"{name}:{step:g}"
        for name, step in entries
    ]
    place = "[drift] methods" if given == scene.content.drift.methods else "methods"
    return {
        label: scene.changed_integration(name, step, written=lambda key: place)
        for label, (name, step) in zip(labels, entries, strict=True)
    }


def _planned(scene: Scene, costs: bool) -> Variant:
    """Return the plan to the scene's own end, or to about the physical time that is reached there.

    Raises
    ------
    FormError
        If the method fits no representation.
    """
    try:
        return Variant(scene, make_plan(scene, "drift", costs))
    except FormError as error:
        tau_end, clock = scene.content.time.tau_end, scene.problem.clock
        if tau_end is None or clock is None:
            raise
        t_end = tau_end * value(scene.problem, clock, scene.state)
        variant = scene.changed(time={"t_end": t_end})
        try:
            return Variant(variant, make_plan(variant, "drift", costs), in_t=True)
        except FormError:
            raise error from None


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


def _method_run(result: SeveralRuns, label: str, plan: Plan | None, outcome: Outcome) -> MethodRun:
    """Return the run with its drifts in the time of the report."""
    solution, reached = outcome.solution, 0.0
    tau_end, physical_end = result.scene.content.time.tau_end, result.physical_end
    if solution is not None:
        own = solution.drift_time == solution.problem.time
        reached = float(max(solution.tau if own else solution.t, key=abs, default=0.0))
        if solution.drift_time != result.time and physical_end and tau_end:
            rate = tau_end / physical_end
            drift = {name: d.stretched(rate) for name, d in solution.drift.items()}
            solution, reached = (
                replace(solution, drift=drift, drift_time=result.time),
                rate * reached,
            )
    return MethodRun(label, plan, solution, outcome.status, outcome.message, outcome.error, reached)


def warm(scene: Scene, methods: Iterable[str], progress: bool | None = None) -> None:
    """Compile what ``geomint run`` and ``geomint drift`` of a scene run, and nothing else.

    Each plan is carried out as far as its first steps. A method without a plan is left out.

    Raises
    ------
    GeomintError
        As `plan_methods`, and `make_plan`.
    """
    drifting = scene.for_drift()
    for plan in (*plan_methods(drifting, methods).plans, make_plan(scene)):
        warm_plan(plan, progress)


def warm_plan(plan: Plan, progress: bool | None = False) -> None:
    """Compile what carrying out a plan runs, and the pictures of a drift report."""
    with Gathered(quiet=True):  # the run itself will say so
        try:
            _ = plan.solve(progress, callback=lambda told: True).local_error
        except StepError:  # compiled by then
            return
        if plan.purpose == "drift":
            first_turns(plan)


def warming(plans: Sequence[Plan]) -> list[Callable[[], object]]:
    """Return the plans as tasks of a process that compiles beside this one: the last one first."""
    return [partial(warm_plan, plan) for plan in reversed(plans)]
