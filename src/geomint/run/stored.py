"""What a file knows of a problem and a method: all but their code, looked for when it is used."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ..errors import GeomintWarning, MissingCodeError
from ..kernels.compiling.sameness import Compared
from ..kernels.compiling.sending import received, sent
from ..methods.method import Method
from ..problems.problem import Problem, Time
from ..problems.spaces.pieces import piece_slices
from ..problems.systems import find_system
from ..problems.units import unit_among


@dataclass(frozen=True, eq=False, repr=False)
class Stored(Compared):
    """A value by name, and the places of its functions.

    Attributes
    ----------
    content : bytes
        As `geomint.kernels.compiling.sending.sent` makes them; empty if the functions have no place.
    missing : str
        Why they have none.
    """

    _kind: ClassVar[str]
    _advice: ClassVar[str] = "its numbers can be read without"

    name: str
    content: bytes = b""
    missing: str = ""

    def found(self) -> Any:
        """Return the value itself, or raise `MissingCodeError`."""
        if not self.content:
            raise self._lost(self.missing)
        try:
            return received(self.content)
        except Exception as error:  # whatever modules raise when they are imported
            raise self._lost(str(error)) from error

    def _lost(self, reason: str) -> MissingCodeError:
        return MissingCodeError(f"{self._kind} {self.name!r}", f"{reason}: {self._advice}")


@dataclass(frozen=True, eq=False, repr=False)
class StoredMethod(Stored):
    """A method without its class."""

    _kind = "method"

    adaptive: bool = False

    @classmethod
    def of(cls, method: Method | StoredMethod) -> StoredMethod:
        """Return what can be written of a method."""
        if isinstance(method, StoredMethod):
            return method
        return cls(method.name, *_sent(method), adaptive=method.adaptive)


@dataclass(frozen=True, eq=False, repr=False)
class StoredProblem(Stored):
    """A problem without its functions.

    Attributes
    ----------
    parameters : mapping
        Of a file those that are numbers.
    units : mapping of str to str
    system, initial : mapping, optional
        Sections of the scene: with them the problem is made anew, in any version that knows the system.
    """

    _kind = "problem"
    _advice = f"give it, as geomint.load(path, problem=…); {Stored._advice}"

    shapes: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    time: Time = "t"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    params: Any = None
    system: Mapping[str, Any] | None = None
    initial: Mapping[str, Any] | None = None
    units: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, problem: Problem | StoredProblem) -> StoredProblem:
        """Return what can be written of a problem."""
        if isinstance(problem, StoredProblem):
            return problem
        content, missing = _sent(problem)
        known = problem.shapes, problem.time, problem.parameters, problem.params
        return cls(problem.name, content, missing, *known, units=problem.units)

    @property
    def pieces(self) -> tuple[tuple[str, int], ...]:
        """The order of a state."""
        return tuple((name, int(np.prod(shape))) for name, shape in self.shapes.items())

    @property
    def slices(self) -> dict[str, slice]:
        """Where each piece lies in the flat state."""
        return piece_slices(self.pieces)

    def unit(self, name: str) -> str:
        """Return the unit of a piece, a component, a quantity or a time by its name."""
        return unit_among(self.units, name)

    def found(self) -> Problem:
        """Return the problem of the system, or that whose functions are where they were."""
        return self._of_system() or super().found()

    def fits(self, problem: Problem) -> bool:
        """Tell whether a problem has this name, these pieces and parameters, bit by bit."""
        same = (problem.name, problem.time, problem.pieces) == (self.name, self.time, self.pieces)
        return same and problem.params.tobytes() == np.asarray(self.params).tobytes()

    def _of_system(self) -> Problem | None:
        if self.system is None or self.initial is None:
            return None
        try:
            system = find_system(self.system["name"])
            keys = {key: value for key, value in self.system.items() if key != "name"}
            with warnings.catch_warnings():  # of states that are projected, as they were then
                warnings.simplefilter("ignore", GeomintWarning)
                model = system.build(system.parameters(**keys), system.initial(**self.initial))
        except Exception:  # another version of the system: its functions may still be there
            return None
        return next((one for one in model.problems.values() if self.fits(one)), None)


class Found:
    """An attribute that may be given as something `Stored`: it is found when it is first read."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, owner: Any, kind: type | None = None) -> Any:
        if owner is None:
            raise AttributeError(self._name)
        value = vars(owner)[self._name]
        if isinstance(value, Stored):
            value = vars(owner)[self._name] = value.found()
        return value

    def __set__(self, owner: Any, value: Any) -> None:
        vars(owner)[self._name] = value


def _sent(value: Any) -> tuple[bytes, str]:
    """Return the bytes that find a value again, or why there are none."""
    try:
        return sent(value), ""
    except Exception as error:  # whatever a foreign object raises there
        return b"", str(error)
