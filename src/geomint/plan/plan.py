"""Making plans, and carrying them out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

from ..errors import DomainError
from ..kernels.compiling.sameness import Compared
from ..problems.problem import Problem
from ..run.solution import Solution
from ..scene.load import load_scene
from ..scene.scene import Scene
from ..watch.observe import MEASURE
from .context import Choice, Context
from .rules import COST_RULES, RULES

__all__ = ["Plan", "make_plan", "run_scene"]

PURPOSES = ("run", "drift")


@dataclass(frozen=True, eq=False)
class Plan(Compared):
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

    @property
    def notes(self) -> tuple[str, ...]:
        """What is asked for and will not be done, in words."""
        missing = self.context.choices.get("not watched")
        return () if missing is None else (f"not watched: {missing.value}: {missing.reason}",)

    def solve(self, progress: bool | None = None) -> Solution:
        """Carry the plan out."""
        from ..run.solve import solve

        content = self.scene.content
        keeps = self.context.purpose == "run"
        watched = self.context.choices["watched"].detail
        return solve(
            self.problem,
            self.context.state,
            t_end=content.time.t_end,
            tau_end=content.time.tau_end,
            method=self.scene.method,
            step=content.integrate.step,
            t_eval=content.save.t_eval if keeps else None,
            save_every=content.save.every if keeps else None,
            observe=watched,
            observe_every=content.observe.every if watched else 1,
            measure_steps=content.observe.measure_steps if MEASURE in watched else None,
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
    if not isinstance(scene, Scene):
        raise DomainError("scene", scene, "a geomint.Scene, such as load_scene gives")
    if not (isinstance(purpose, str) and purpose in PURPOSES):
        raise DomainError("purpose", purpose, f"one of {list(PURPOSES)}")
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
