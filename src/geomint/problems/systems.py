"""Systems that scenes can name, registered by any package through entry points.

A package registers under ``[project.entry-points."geomint.systems"]`` an object of type `System`
for every name, and under ``"geomint.scenes"`` a package folder of scene files (TOML).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel

from ..arguments import Array
from ..errors import DomainError, SceneError, loaded, nearest, offered, quoted
from ..kernels.compiling.sending import Sendable
from .problem import Problem
from .time_transformation import time_transformed

Lift = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Reduction(Sendable):
    """A problem whose solution from one initial state gives that of a representation, in the same time.

    Parameters
    ----------
    of, name : str
        The representation, and what plans call the problem.
    problem : Problem
    state : array
        Where it starts.
    lift : callable
        States of the problem, one a row ↦ those of the representation.
    condition : str
        In words, why this initial state allows it.
    quantities : tuple of str, optional
        Those of the problem's quantities that mean what they mean in the representation. Default: all
        that have the same name.
    """

    of: str
    name: str
    problem: Problem
    state: Array
    lift: Lift
    condition: str
    quantities: tuple[str, ...] | None = None


@dataclass(frozen=True, eq=False)
class Model(Sendable):
    """One mechanical system with its parameters and initial state, in all its representations.

    Parameters
    ----------
    problems : mapping of name to Problem
        The representations; the first is the one that a scene means.
    states : mapping of name to array
        The same initial state for each of them.
    conditions : mapping of name to str
        In words, why this initial state allows a representation that others do not: what a plan
        says when it takes that one.
    reductions : tuple of Reduction
        What may be integrated in place of a representation, where that is cheaper.
    """

    problems: Mapping[str, Problem]
    states: Mapping[str, Array]
    conditions: Mapping[str, str] = field(default_factory=dict)
    reductions: tuple[Reduction, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what has no problem, or not a state for each."""
        given = self.problems
        known = isinstance(given, Mapping) and all(isinstance(p, Problem) for p in given.values())
        if not (known and given):
            raise DomainError("problems", given, "problems by name, at least one")
        if not (isinstance(self.states, Mapping) and given.keys() <= self.states.keys()):
            raise DomainError("states", self.states, f"a state for each of {quoted([*given])}")


def in_time(model: Model, clock: str) -> Model:
    """Return a model with its first representation in another time.

    See `geomint.time_transformed`, whose errors it raises. Of the others those in physical time are
    left, for methods and comparisons that need them; the first itself, if it is one, as NAME-in-t.
    """
    first, problem = next(iter(model.problems.items()))
    found = {first: time_transformed(problem, clock, model.states[first])}
    states = {first: model.states[first]}
    for name, other in model.problems.items():
        if other.time == "t":
            called = f"{name}-in-t" if name == first else name
            found[called], states[called] = other, model.states[name]
    return Model(found, states, model.conditions)


@dataclass(frozen=True, eq=False)
class System(Sendable):
    """What a scene's ``[system] name`` stands for.

    Parameters
    ----------
    name, summary : str
    parameters : pydantic model
        The other keys of ``[system]``.
    initial : pydantic model
        The keys of ``[initial]``.
    build : callable
        ``build(parameters, initial) -> Model``.
    source : str
        The text of the file in Python that it comes from, where that is no installed module.
    own : bool
        Whether it is not registered: one's own, that its name does not tell.
    """

    name: str
    summary: str
    parameters: type[BaseModel]
    initial: type[BaseModel]
    build: Callable[[Any, Any], Model]
    source: str = ""
    own: bool = False

    def __post_init__(self) -> None:
        """Refuse what scenes could not be checked by."""
        for name in ("parameters", "initial"):
            if not isinstance(given := getattr(self, name), type) or not issubclass(
                given, BaseModel
            ):
                raise DomainError(name, given, "a class that inherits from pydantic.BaseModel")
        if not callable(self.build):
            raise DomainError("build", self.build, "a function")


def system_names() -> list[str]:
    """Return the names of all registered systems."""
    return sorted(offered("geomint.systems"))


def find_system(name: str) -> System:
    """Return the registered system of that name, or raise `SceneError`."""
    points = offered("geomint.systems")
    if name not in points:
        raise SceneError(f"[system] name = {quoted(name)}: no such system.{nearest(name, points)}")
    system = loaded(points[name])
    if not isinstance(system, System):
        raise SceneError(f"entry point {points[name].value!r} is not a geomint.System")
    return system
