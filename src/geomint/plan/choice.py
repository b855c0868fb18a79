"""What the rules of the planner see and say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, Literal, NamedTuple, TypeVar

from ..arguments import Array
from ..kernels.compiling.sameness import Compared
from ..kernels.compiling.sending import Sendable
from ..methods.method import Method
from ..problems.problem import Problem
from ..problems.systems import Lift, Model, Reduction
from ..scene.model import Content
from ..scene.scene import Scene

Purpose = Literal["run", "drift"]
Names = tuple[str, ...]
T = TypeVar("T")


@dataclass(frozen=True)
class Choice(Generic[T]):
    """One decision of a plan.

    Attributes
    ----------
    what : str
        What it is about, for tables.
    chosen : object
        What is done.
    value, reason : str
        The same in words, and why.
    """

    what: str
    chosen: T
    value: str
    reason: str


class Saving(NamedTuple):
    """Which states are kept: every so many steps, or at physical times; neither: the last."""

    every: int | None = None
    t_eval: tuple[float, ...] | None = None


@dataclass(frozen=True, eq=False)
class Route(Sendable):
    """What is integrated, and how the states that are asked for follow from it.

    Attributes
    ----------
    name, asked : str
        The representation that is integrated, and the one whose states are handed out.
    lift : callable, optional
        Its states ↦ those of `asked`, if that is another one and a run keeps states.
    same : tuple of str, optional
        The quantities that mean what they mean in `asked`; None: all.
    condition : str
        In words, why the initial state allows it.
    """

    name: str
    problem: Problem
    state: Array
    asked: str
    lift: Lift | None = None
    same: Names | None = None
    condition: str = ""

    @classmethod
    def along(cls, r: Reduction) -> Route:
        """Return the way by a reduction."""
        return cls(r.name, r.problem, r.state, r.of, r.lift, r.quantities, r.condition)


@dataclass(frozen=True, eq=False)
class Asked(Compared):
    """What a rule sees first: the scene, and what its result is for."""

    scene: Scene
    purpose: Purpose

    @property
    def content(self) -> Content:
        """The checked sections of the scene."""
        return self.scene.content

    @property
    def model(self) -> Model:
        """The system in all its representations."""
        return self.scene.model

    @property
    def method(self) -> Method:
        """The method of the scene."""
        return self.scene.method

    @property
    def end(self) -> dict[str, Any]:
        """``{"t_end": …}`` or ``{"tau_end": …}``."""
        return self.content.time.end

    @property
    def saving(self) -> Saving:
        """Which states are kept: of a drift report the last alone."""
        if self.purpose == "drift":
            return Saving()
        save = self.content.save
        return Saving(save.every, None if save.t_eval is None else tuple(save.t_eval))

    @property
    def own(self) -> str:
        """The name of the scene's own representation."""
        return next(iter(self.model.problems))

    @property
    def representation(self) -> str | None:
        """The name of the representation that is asked for, if one is."""
        named = self.content.integrate.representation
        return self.own if named == "own" else named

    def route(self, name: str) -> Route:
        """Return the way that integrates a representation itself."""
        problem, state = self.model.problems[name], self.model.states[name]
        return Route(name, problem, state, name, condition=self.model.conditions.get(name, ""))
