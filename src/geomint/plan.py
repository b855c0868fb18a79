"""The planner: what a scene asks for, and the cheapest way to deliver it, with reasons.

A plan is made by an ordered list of small pure rules, ``rule(context) -> Choice or None``; each sees
the scene and the choices made before it. A plan never changes the answer: it only leaves out
what the scene does not need.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import FormError, StepError
from .evaluate import value
from .methods.method import Start
from .observe import choose_observables
from .problem import Problem
from .scene import Scene, load_scene
from .solution import Solution
from .timeline import Timeline, characteristic_time, plan_timeline

__all__ = ["Choice", "Context", "Plan", "make_plan", "run_scene"]

PURPOSES = ("run", "drift")
_PROBE_STEPS = 4
_PROBE_ROWS = 64


@dataclass(frozen=True)
class Choice:
    """One decision of a plan: what it is about, its value in words, and why."""

    what: str
    value: str
    reason: str
    detail: Any = None


@dataclass(frozen=True)
class Context:
    """What a rule sees: the scene, the purpose of the run, and the earlier choices."""

    scene: Scene
    purpose: str
    choices: Mapping[str, Choice] = field(default_factory=dict)

    @property
    def representation(self) -> str:
        """The name of the chosen representation."""
        return str(self.choices["representation"].detail)

    @property
    def problem(self) -> Problem:
        """The problem that is integrated."""
        return self.scene.model.problems[self.representation]

    @property
    def state(self) -> npt.NDArray[np.float64]:
        """Its initial state."""
        return self.scene.model.states[self.representation]

    @property
    def clock(self) -> bool:
        """Whether physical time is integrated beside the state."""
        return bool(self.choices["physical time"].detail)

    @cached_property
    def timeline(self) -> Timeline:
        """Steps and end."""
        time, integrate = self.scene.content.time, self.scene.content.integrate
        return plan_timeline(
            self.problem, self.scene.method, self.state, time.t_end, time.tau_end, integrate.step
        )


@dataclass(frozen=True)
class Plan:
    """How a scene is integrated.

    Attributes
    ----------
    choices : tuple of Choice
        In the order of the rules.
    """

    context: Context
    choices: tuple[Choice, ...]

    @property
    def scene(self) -> Scene:
        """The scene that is planned."""
        return self.context.scene

    @property
    def problem(self) -> Problem:
        """The problem that is integrated."""
        return self.context.problem

    def solve(self, progress: bool | None = None) -> Solution:
        """Carry the plan out."""
        from .integrate import solve

        content = self.scene.content
        keeps = self.context.purpose == "run"
        return solve(
            self.problem,
            self.context.state,
            t_end=content.time.t_end,
            tau_end=content.time.tau_end,
            method=self.scene.method,
            step=content.integrate.step,
            t_eval=content.save.t_eval if keeps else None,
            save_every=content.save.every if keeps else None,
            observe=self.context.choices["watched"].detail,
            observe_every=content.observe.every,
            clock=self.context.clock,
            progress=progress,
        )


def make_plan(scene: Scene, purpose: str = "run", costs: bool = False) -> Plan:
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
    context = Context(scene, purpose)
    for rule in (*RULES, *(COST_RULES if costs else ())):
        choice = rule(context)
        if choice is not None:
            context = Context(scene, purpose, {**context.choices, choice.what: choice})
    return Plan(context, tuple(context.choices.values()))


def run_scene(
    scene: str | PathLike[str] | Mapping[str, Any] | Scene, progress: bool | None = None
) -> Solution:
    """Integrate a scene, given by name, file, content or object, as ``geomint run`` does."""
    return make_plan(load_scene(scene)).solve(progress)


def choose_representation(c: Context) -> Choice:
    """Take the scene's own representation unless the method needs a form only another offers."""
    problems, method = c.scene.model.problems, c.scene.method
    own = next(iter(problems))
    obstacles = {name: _obstacle(c.scene, problem) for name, problem in problems.items()}
    fitting = [name for name, obstacle in obstacles.items() if not obstacle]
    if own in fitting:
        reason = f"the scene's own; it offers the form {method.needs!r} that {method.name} needs"
        return Choice("representation", _described(own, problems[own]), reason, own)
    if not fitting:
        told = "; ".join(
            f"{', '.join(name for name in problems if obstacles[name] == obstacle)}: {obstacle}"
            for obstacle in dict.fromkeys(obstacles.values())
        )
        raise FormError(
            f"no representation of {c.scene.content.system.name!r} fits method {method.name!r} "
            f"({told}). Methods that fit {own!r}: {_fitting_methods(problems[own])}"
        )
    other = fitting[0]
    reason = f"{own}: {obstacles[own]}; the same motion from the same initial state"
    return Choice("representation", _described(other, problems[other]), reason, other)


def _obstacle(scene: Scene, problem: Problem) -> str:
    """Return why a representation cannot serve, or an empty string."""
    method, content = scene.method, scene.content
    if method.needs not in problem.forms:
        return f"no form {method.needs!r}"
    if problem.time == "t" and content.time.tau_end is not None:
        return "in physical time, so tau_end says nothing: give t_end"
    if problem.time == "tau" and method.needs == "action" and content.time.t_end is not None:
        return f"{method.name} cannot integrate physical time beside it: give tau_end"
    missing = [
        name
        for name in choose_observables(scene.problem, content.observe.quantities)
        if name not in problem.diagnostics and name not in scene.problem.constraints
    ]
    return f"has no {', '.join(missing)}" if missing else ""


def _described(name: str, problem: Problem) -> str:
    pieces = ", ".join(f"{piece} ({rows})" for piece, rows in problem.pieces)
    return f"{name}: {pieces}; {problem.rows} numbers in {_TIME[problem.time]}"


_TIME = {"t": "physical time t", "tau": "its own time τ"}
_FITTING = {"field": "gauss-8, dop853, rk-4", "action": "cf-4, rkmk-4", "hamiltonian": "rattle-4"}


def _fitting_methods(problem: Problem) -> str:
    return ", ".join(_FITTING[form] for form in problem.forms)


def choose_method(c: Context) -> Choice:
    """State the method."""
    method = c.scene.method
    kind = " and ".join(
        word for word in ("symmetric", "symplectic") if getattr(method, word)
    )  # fmt: skip
    reason = f"order {method.order}{', ' + kind if kind else ''}: {method.summary}"
    options = ", ".join(f"{k} {v!r}" for k, v in c.scene.content.integrate.options.items())
    return Choice("method", f"{method.name}{' with ' + options if options else ''}", reason)


def choose_clock(c: Context) -> Choice:
    """Integrate physical time only if the end or the saved states need it."""
    problem, content = c.problem, c.scene.content
    if problem.time == "t":
        return Choice("physical time", "is the problem's own", "nothing to do", False)
    if content.time.t_end is not None:
        reason = "the end is given in physical time"
        return Choice("physical time", "integrated beside the state", reason, True)
    if c.purpose == "run" and content.save.t_eval is not None:
        reason = "states are wanted at physical times"
        return Choice("physical time", "integrated beside the state", reason, True)
    if c.purpose == "run" and c.scene.method.needs != "action":
        reason = "saved states carry their physical times"
        return Choice("physical time", "integrated beside the state", reason, True)
    return Choice("physical time", "not integrated", "nothing that is asked for needs it", False)


def choose_states(c: Context) -> Choice:
    """Store no state that is not asked for."""
    save = c.scene.content.save
    if c.purpose == "drift":
        reason = "a drift report shows no states: memory does not grow with the run"
        return Choice("states kept", "the last", reason)
    if save.t_eval is not None:
        reason = "[save] t_eval; each met exactly by a partial step beside the run"
        return Choice("states kept", f"at {len(save.t_eval)} physical times", reason)
    if save.every is not None:
        count = c.timeline.steps
        many = "" if count is None else f": {2 + (count - 1) // save.every} states"
        value = f"the first, every {save.every} steps, the last{many}"
        return Choice("states kept", value, "[save] every")
    return Choice("states kept", "the last", "no [save] section")


def choose_quantities(c: Context) -> Choice:
    """Evaluate the watched quantities and no others.

    A constraint that only the scene's own representation has is replaced by the constraints of
    the one that is integrated.
    """
    observe, own = c.scene.content.observe, c.scene.problem
    wanted = list(choose_observables(own, observe.quantities))
    names = [name for name in wanted if name in c.problem.diagnostics]
    gone = [name for name in wanted if name not in names]
    if gone:
        names += [name for name in c.problem.constraints if name not in names]
    if not names:
        return Choice("watched", "nothing", "[observe] quantities is empty", [])
    every = "after every step" if observe.every == 1 else f"every {observe.every} steps"
    rest = len(c.problem.diagnostics) - len(names)
    left = f"; {rest} other{'s' if rest > 1 else ''} left out" if rest else ""
    instead = f"; {', '.join(gone)} is no constraint of this representation" if gone else ""
    reason = f"[observe], {every}, reduced to windows on the way{left}{instead}"
    return Choice("watched", ", ".join(names), reason, names)


def choose_step(c: Context) -> Choice:
    """State the step and where it came from."""
    given, method, h = c.scene.content.integrate.step, c.scene.method, abs(c.timeline.h)
    unit = "τ" if c.problem.time == "tau" else "t"
    if given is not None:
        reason = "[integrate] step"
        if h != given:
            reason += f" = {given!r}, adjusted by rounding to reach the end in whole steps"
    else:
        natural = characteristic_time(c.problem, c.state)
        reason = (
            f"default: {method.step_fraction:.4g} (for {method.name}) × the initial state's "
            f"characteristic time {natural:.4g}"
        )
    return Choice("step", f"{h:.10g} in {unit}", reason, h)


def choose_steps(c: Context) -> Choice:
    """State how many steps that makes."""
    timeline = c.timeline
    if timeline.steps is not None:
        end = timeline.own_end or 0.0
        last = f" and a last one of {abs(timeline.remainder):.4g}" if timeline.remainder else ""
        reason = f"end at {'τ' if c.problem.time == 'tau' else 't'} = {end:g}"
        return Choice("steps", f"{timeline.steps}{last}", reason, timeline.steps)
    end, clock = timeline.physical_end, c.problem.clock
    assert end is not None
    assert clock is not None
    rate = value(c.problem, clock, c.state)
    count = round(abs(end / (rate * timeline.h))) + 1
    reason = f"end at t = {end:g}, met by a last partial step; dt/dτ is {rate:.4g} at the start"
    return Choice("steps", f"about {count}", reason, count)


def estimate_evaluations(c: Context) -> Choice | None:
    """Estimate the evaluations of the field; for implicit methods from some plain steps."""
    steps, method = c.choices["steps"].detail, c.scene.method
    implicit = "max_iterations" in method.options
    if implicit and c.problem.rows > _PROBE_ROWS:
        return None
    from .kernels.blocks import scalar_block

    start = Start(c.problem, c.state, 0.0, c.timeline.h, clock=c.clock, compiled=False)
    stepper = method.start(start)
    if not implicit:
        total = steps * stepper.evaluations
        return Choice("field evaluations", f"{total:.4g}", f"{stepper.evaluations:g} a step", total)
    first = stepper.advance(0, 1, 1, scalar_block(stepper.rows))
    rest = stepper.advance(1, _PROBE_STEPS, _PROBE_STEPS, scalar_block(stepper.rows))
    if first.status or rest.status:
        error: StepError = stepper.error(first if first.status else rest, 0 if first.status else 1)
        return Choice("field evaluations", "the run will fail", str(error))
    iterations = rest.iterations / _PROBE_STEPS
    total = steps * iterations * stepper.evaluations
    reason = f"{iterations:.3g} iterations of {stepper.evaluations:g} a step, tried on {_PROBE_STEPS} steps"
    return Choice("field evaluations", f"about {total:.3g}", reason, total)


RULES: tuple[Callable[[Context], Choice | None], ...] = (
    choose_representation,
    choose_method,
    choose_clock,
    choose_states,
    choose_quantities,
    choose_step,
    choose_steps,
)
COST_RULES: tuple[Callable[[Context], Choice | None], ...] = (estimate_evaluations,)
