"""Events: functions of the state whose changes of sign a run looks for."""

import functools
import re
from collections.abc import Callable
from dataclasses import dataclass
from types import FunctionType
from typing import Any, overload

from ..arguments import by_name, finite, whole
from ..errors import DomainError, nearest
from ..kernels.compiling.recorded import Recorded, observable
from ..kernels.compiling.sameness import Compared
from ..problems.problem import Problem

DIRECTIONS = {"both": 0, "up": 1, "down": -1}
EXPECTED = "names of components and quantities, geomint.Event, or a mapping of names to these"
_COMPONENT = re.compile(r"(.+?)\[(-?\d+)\]")


@dataclass(frozen=True, eq=False)
class Event(Compared):
    """A function of the state, and which of its changes of sign are events.

    An event is where the sign is another one than before; the sign of 0 is that before. So what touches
    0 is none; a function that is 0 over a while between two signs has one, at the end of it; and what
    is 0 where a run begins or ends has none there. A run that goes on tells what comes where the former
    one has ended. A value that is 0 to rounding where a run begins (of the numbers of the state 10⁻¹³,
    and 10⁻⁹ of what it becomes in the first step) is 0: a new run that begins where an event has ended
    another one, with a velocity turned round perhaps, does not tell it again.

    Times are those at which the sign changes, to rounding of the time, at roots of any multiplicity.

    Parameters
    ----------
    what : str or Recorded
        A component of the state, ``"gamma[2]"`` (from 0 on); a quantity of the problem by its name; or
        a function ``f(params, t, y, work) -> number``, which `geomint.event` makes an event.
    direction : str or int
        ``"up"``, ``"down"`` or ``"both"``; 1, −1 or 0: as the number changes in the order of the run.
    terminal : bool or int
        Whether the run ends there; a number: at the event of that number.
    level : float
        The value that is looked for; another one is no new compilation.

    Raises
    ------
    DomainError
    """

    what: Any
    direction: str | int = "both"
    terminal: bool | int = False
    level: float = 0.0

    def __post_init__(self) -> None:
        if isinstance(self.what, FunctionType):
            object.__setattr__(self, "what", observable(self.what))
        if not isinstance(self.what, str | Recorded):
            raise DomainError("what", self.what, "the name of a quantity, or a function")
        known: dict[Any, int] = {**DIRECTIONS, **{n: n for n in DIRECTIONS.values()}}
        try:
            sign = known[self.direction]
        except (KeyError, TypeError):
            expected = f"one of {', '.join(map(repr, DIRECTIONS))}, 1, -1 or 0"
            raise DomainError("direction", self.direction, expected) from None
        name = next(name for name, number in DIRECTIONS.items() if number == sign)
        object.__setattr__(self, "direction", name)
        if not isinstance(self.terminal, bool):
            object.__setattr__(self, "terminal", whole("terminal", self.terminal, 1))
        object.__setattr__(self, "level", finite("level", self.level))

    @property
    def name(self) -> str:
        """What it is called unless it is given a name."""
        own = self.what if isinstance(self.what, str) else self.what.function.__name__
        return own if self.level == 0.0 else f"{own} = {self.level:g}"

    @property
    def sign(self) -> int:
        """1, −1, or 0 for both directions."""
        return DIRECTIONS[str(self.direction)]

    @property
    def last(self) -> int:
        """The number of the event that ends the run, from 1 on; 0 for none."""
        return int(self.terminal)

    def row(self, problem: Problem) -> int:
        """Return the row of the component of the state that it is, or −1."""
        row = component(problem, self.what) if isinstance(self.what, str) else None
        return -1 if row is None else row

    def function(self, problem: Problem) -> Recorded:
        """Return what is looked at, less the level, as an observable of the problem."""
        found = looked_at(self, problem)
        return found if self.level == 0.0 else _less(found, self.level)


@overload
def event(function: Callable[..., Any], /) -> Event: ...
@overload
def event(
    *, direction: str | int = ..., terminal: bool | int = ..., level: float = ...
) -> Callable[[Callable[..., Any]], Event]: ...
def event(function: Any = None, /, **options: Any) -> Any:
    """Make a function ``f(params, t, y, work) -> number`` an event: where it is 0.

    The rules are those of `geomint.field`; t is the problem's own time. Options are those of
    `geomint.Event`.

    Examples
    --------
    >>> import geomint as gi
    >>> @gi.event(direction="up")
    ... def height(params, t, y, work):
    ...     return y[0] - 0.5
    >>> height.direction
    'up'
    """
    if function is None:
        return lambda given: Event(observable(given), **options)
    return Event(observable(function))


def component(problem: Problem, name: str, argument: str = "event") -> int | None:
    """Return the row of a component, ``"gamma[2]"`` or a piece of one number; None if it is none.

    `argument` is what it was given as.

    Raises
    ------
    DomainError
        For a component that a piece of the problem does not have.
    """
    if not isinstance(name, str):
        raise DomainError(argument, name, "the name of a component or a quantity")
    slices = problem.slices
    match = _COMPONENT.fullmatch(name)
    piece, index = (match[1], int(match[2])) if match else (name, 0)
    if name in problem.diagnostics or piece not in slices:
        return None
    rows = slices[piece].stop - slices[piece].start
    if 0 <= index < rows and (match or rows == 1):
        return int(slices[piece].start + index)
    raise DomainError(argument, name, f"{piece}[0] to {piece}[{rows - 1}]")


def quantity(problem: Problem, name: str, argument: str = "event") -> Recorded:
    """Return a component of the state or a quantity of the problem by its name."""
    row = component(problem, name, argument)
    if row is not None:
        return component_at(row)
    if name in problem.diagnostics:
        return problem.diagnostics[name]
    known = [*problem.diagnostics, *(f"{p}[0]" for p in problem.slices)]
    expected = f"a component or a quantity of {problem.name!r}.{nearest(name, known)}"
    raise DomainError(argument, name, expected)


@functools.cache
def component_at(row: int) -> Recorded:
    """Return a number of the state as an observable."""

    def component(params, t, y, work):
        return y[row]

    return observable(component)


@functools.lru_cache(maxsize=256)
def _less(function: Recorded, level: float) -> Recorded:
    def less(params, t, y, work):
        return function(params, t, y, work) - level

    return observable(less)


def looked_at(event: Event, problem: Problem) -> Recorded:
    """Return what an event looks at, whatever its level, as an observable of the problem."""
    return event.what if isinstance(event.what, Recorded) else quantity(problem, event.what)


def choose_events(wanted: Any) -> dict[str, Event]:
    """Return the events that were asked for, by name.

    Parameters
    ----------
    wanted : None, name, Event, list of them, or mapping of names to them

    Raises
    ------
    DomainError
    """
    if wanted is None:
        return {}
    if isinstance(wanted, str | Event | Recorded | FunctionType) or callable(wanted):
        wanted = [wanted]
    return by_name("events", wanted, _event_of, lambda found: found.name, EXPECTED)


def _event_of(what: Any) -> Event:
    if isinstance(what, Event):
        return what
    if isinstance(what, str | Recorded):
        return Event(what)
    if callable(what):
        said = "an event: decorate it with @geomint.event; it is called f(params, t, y, work)"
        raise DomainError("events", what, said)
    raise DomainError("events", what, EXPECTED)
