"""Making plans, and carrying them out."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

from ..arguments import Array
from ..errors import DomainError, StepError
from ..kernels.compiling.sameness import Compared
from ..methods.method import Method
from ..problems.problem import Problem
from ..problems.shown import Shown
from ..run.promise import Setting
from ..run.solution import Solution
from ..run.timeline import Timeline
from ..scene.load import load_scene
from ..scene.scene import Scene
from ..watch.watcher import Watcher
from . import rules
from .choice import Asked, Choice, Names, Purpose, Route, Saving
from .exact import choose_exact, exact_timeline, follow_exactly
from .representation import choose_representation, told_representation
from .tolerance import chosen_for

PURPOSES = ("run", "drift")


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Shown, Compared):
    """How a scene is integrated: decisions, each with its reason.

    Attributes
    ----------
    exact : Choice of Route, or None
        What exact motion is followed, if the scene allows it; there are no steps then.
    representation : Choice of Route
        What is integrated, and what states are handed out.
    clock : Choice of bool
        Whether physical time is integrated beside the state.
    save : Choice of Saving
    observed : mapping of str to Watcher
        What is watched.
    watched, missing : Choice of tuple of str
        What is observed, and what is asked for and cannot be; None if that is nothing.
    events : Choice of tuple of str
        What is looked for; None if that is nothing.
    timeline : Timeline
    step : Choice of float
        Its length in the problem's own time; of an adaptive method that of the first.
    steps, evaluations : Choice of number or None
        How many there will be, where that is known; evaluations only if costs are asked for.
    setting : Setting or None
        What meets a tolerance, where the scene has one.
    """

    scene: Scene
    purpose: Purpose
    exact: Choice[Route | None] | None
    representation: Choice[Route]
    method: Choice[Method]
    clock: Choice[bool]
    save: Choice[Saving]
    observed: Mapping[str, Watcher]
    watched: Choice[Names]
    missing: Choice[Names] | None
    events: Choice[Names] | None
    timeline: Timeline
    step: Choice[float]
    steps: Choice[int | None]
    evaluations: Choice[float | None] | None = None
    setting: Setting | None = None

    @property
    def choices(self) -> tuple[Choice[Any], ...]:
        """All decisions, for tables."""
        return tuple(choice for choice in vars(self).values() if isinstance(choice, Choice))

    @property
    def route(self) -> Route:
        """What is integrated, and what states are handed out."""
        return self.representation.chosen

    @property
    def problem(self) -> Problem:
        """The problem that is integrated."""
        return self.route.problem

    @property
    def state(self) -> Array:
        """Its initial state."""
        return self.route.state

    @property
    def notes(self) -> tuple[str, ...]:
        """What is asked for and will not be done, in words."""
        missing = self.missing
        return () if missing is None else (f"not watched: {missing.value}: {missing.reason}",)

    def _shown(self) -> tuple[str, dict[str, Any]]:
        facts = {choice.what: f"{choice.value} ({choice.reason})" for choice in self.choices}
        return f"plan of {self.scene.name!r}, {self.purpose}", facts

    def solve(
        self, progress: bool | None = None, callback: Callable[..., Any] | None = None
    ) -> Solution:
        """Carry the plan out; `callback` is that of `geomint.solve`."""
        if self.exact is not None and self.exact.chosen is not None:
            t_eval = self.save.chosen.t_eval
            return self._handed_out(follow_exactly(self.route, self.scene, t_eval, progress))
        from ..run.solve import solve

        time, observe = self.scene.content.time, self.scene.content.observe
        save, route = self.save.chosen, self.route
        given, chosen = self.scene.content.integrate.step, self.setting
        step = self.step.chosen if chosen is None and route.lift is not None else None
        try:
            solution = solve(
                self.problem,
                self.state,
                t_end=time.t_end,
                tau_end=time.tau_end,
                method=self.method.chosen,
                step=step if given is None else given,
                tolerance=chosen,  # type: ignore[arg-type]  # so that it is not searched for again
                t_eval=None if save.t_eval is None else list(save.t_eval),
                save_every=save.every,
                events=self.scene.events if self.purpose == "run" else None,
                observe=self.observed,
                observe_every=observe.every if self.observed else 1,
                clock=self.clock.chosen,
                callback=callback,
                progress=progress,
            )
        except StepError as error:
            error.partial = self._handed_out(error.partial)
            raise
        return self._handed_out(solution)

    def run_to(self, end: float, **given: Any) -> Solution:
        """Return a run of the same method and step to a time of the problem's own."""
        from ..run.solve import solve

        method, in_tau = self.method.chosen, self.problem.time == "tau"
        own = self.scene.content.integrate.step if method.adaptive else abs(self.timeline.h)
        ends: dict[str, Any] = {"tau_end" if in_tau else "t_end": end}
        return solve(self.problem, self.state, method=method, step=own, **ends, **given)

    def _handed_out(self, solution: Solution) -> Solution:
        """Return a solution with the states that are asked for."""
        lift = self.route.lift
        if lift is None:
            return solution
        asked = self.scene.model.problems[self.route.asked]
        way = solution.route or self.route.name
        # What it would go on from is a state of the other problem.
        return replace(
            solution,
            about=asked,
            y=lift(solution.y),
            route=way,
            restart=None,
            kept=None,
            events={},
        )


def make_plan(scene: Scene, purpose: Purpose = "run", costs: bool = False) -> Plan:
    """Return the plan of a scene.

    Parameters
    ----------
    scene : Scene
    purpose : ``"run"`` or ``"drift"``
        What the result is for: states, or the drift of the watched quantities alone.
    costs : bool
        Also estimate the field evaluations; for implicit methods by some steps in plain Python.

    Raises
    ------
    FormError
        If no representation of the system fits the method.
    DomainError
        For a step or an end that makes no sense.
    """
    if not isinstance(scene, Scene):
        raise DomainError("scene", scene, "a geomint.Scene, such as load_scene gives")
    if not (isinstance(purpose, str) and purpose in PURPOSES):
        raise DomainError("purpose", purpose, f"one of {list(PURPOSES)}")
    asked = Asked(scene, purpose)
    exact = choose_exact(asked)
    if exact is not None and exact.chosen is not None:
        return _without_steps(asked, exact, exact.chosen)
    representation = choose_representation(asked)
    route = representation.chosen
    clock = rules.choose_clock(asked, route.problem)
    observed, t_eval = rules.watchers_of(asked, route), asked.saving.t_eval
    chosen = chosen_for(scene, route.problem, route.state, t_eval, clock.chosen, observed)
    timeline = rules.timeline_of(asked, route, chosen)
    plan = Plan(
        scene,
        purpose,
        exact,
        representation=representation,
        method=rules.choose_method(asked, route.problem),
        clock=clock,
        save=rules.choose_states(asked, route.problem, timeline),
        observed=observed,
        watched=rules.choose_quantities(asked, route, timeline, observed),
        missing=rules.choose_missing(asked, route),
        events=rules.choose_events(asked),
        timeline=timeline,
        step=rules.choose_step(asked, route, timeline, chosen),
        steps=(steps := rules.choose_steps(asked, route, timeline)),
        setting=chosen,
    )
    if not costs:
        return plan
    found = rules.estimate_evaluations(asked, route, timeline, clock.chosen, steps.chosen)
    return replace(plan, evaluations=found)


def _without_steps(c: Asked, exact: Choice[Route | None], route: Route) -> Plan:
    """Return the plan of a motion that is followed exactly."""
    timeline = exact_timeline(c, route)
    none = "the exact flow takes none"
    return Plan(
        c.scene,
        c.purpose,
        exact,
        representation=told_representation(route, "it has an exact flow"),
        method=Choice("method", c.method, "none", f"the exact flow, in place of {c.method.name}"),
        clock=Choice("physical time", False, "of the exact flow", "nothing to integrate"),
        save=rules.choose_states(c, route.problem, timeline),
        observed={},
        watched=rules.choose_quantities(c, route, timeline, {}),
        missing=None,
        events=rules.choose_events(c),
        timeline=timeline,
        step=Choice("step", 0.0, "none", none),
        steps=Choice("steps", 0, "0", none),
        evaluations=Choice("field evaluations", 0.0, "0", none),
    )


def run_scene(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene, progress: bool | None = None
) -> Solution:
    """Integrate a scene, given by name, file, content or object, as ``geomint run`` does."""
    plan = make_plan(load_scene(scene))
    solution = plan.solve(progress)
    solution.origin = {**solution.provenance, "scene": plan.scene.sections}
    return solution
