"""What a file knows of a problem and a method: all but their code, made by name or unpickled."""

from __future__ import annotations

import copy
import json
import warnings
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ..errors import GeomintWarning, MissingCodeError
from ..kernels.compiling.sameness import Compared, same
from ..kernels.compiling.sending import received, sent
from ..methods.method import Method
from ..methods.registry import find_solver
from ..problems.problem import Problem, Time
from ..problems.systems import find_system


@dataclass(frozen=True, eq=False, repr=False)
class Stored(Compared):
    """A value by name, and the places of its functions.

    Attributes
    ----------
    content : bytes
        As `geomint.kernels.compiling.sending.sent` makes them, a pickle; empty if there is no need of
        one, or another process cannot find the functions.
    trusted : bool
        Whether `content` may be unpickled, which runs whatever it names; copies have it only then.
    """

    kind = ""

    name: str
    content: bytes = b""
    trusted: bool = field(default=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy has, for a file or another process too: no code that is not trusted."""
        return {**vars(self), "content": self.content if self.trusted else b""}

    def found(self, unpickle: bool) -> Any:
        """Return the value itself, or raise `MissingCodeError`.

        Nothing is unpickled unless that is asked for here, and the content is `trusted`.
        """
        reason, more = "no name makes it here, nor is its code kept: that needs cloudpickle", ""
        if self.content and unpickle and self.trusted:
            try:
                return received(self.content)
            except Exception as error:  # whatever modules raise when they are imported
                reason = str(error)
        elif self.content:
            reason = "its functions are known by a pickle alone, which runs what it names"
            more = ", or trust=True for a file that you made yourself"
            more = f", or read .{self.kind}, which unpickles it" if self.trusted else more
        advice = (
            f"give it, as geomint.load(path, {self.kind}=…){more}; its numbers can be read without"
        )
        raise MissingCodeError(f"{self.kind} {self.name!r}", f"{reason}: {advice}")


@dataclass(frozen=True, eq=False, repr=False)
class StoredMethod(Stored):
    """A method without its class.

    Attributes
    ----------
    options : mapping or None
        Of a method that is found by its name those with which it is the same; else None.
    """

    kind = "method"

    adaptive: bool = False
    options: Mapping[str, Any] | None = None

    @classmethod
    def of(cls, method: Method | StoredMethod) -> StoredMethod:
        """Return what can be written of a method."""
        if isinstance(method, StoredMethod):
            return copy.copy(method)
        name, known = method.name, method.adaptive
        try:
            options = json.loads(json.dumps(method.options))
            if same(find_solver(name).with_options(**options), method):
                return cls(name, adaptive=known, options=options)
        except Exception:  # whatever the options of a foreign method raise
            pass
        return cls(name, _sent(method), True, adaptive=known)

    def found(self, unpickle: bool) -> Method:
        """Return the method of that name, with its options, or that which is unpickled."""
        if self.options is not None:
            with suppress(Exception):  # of another version, or of a package that is not here
                return find_solver(self.name).with_options(**self.options)
        return super().found(unpickle)


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

    kind = "problem"

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
            return copy.copy(problem)
        names = ("shapes", "time", "parameters", "params", "units")
        known: dict[str, Any] = {name: getattr(problem, name) for name in names}
        return cls(problem.name, _sent(problem), True, **known)

    @property
    def pieces(self) -> tuple[tuple[str, int], ...]:
        """The order of a state."""
        return tuple((name, int(np.prod(shape))) for name, shape in self.shapes.items())

    slices: ClassVar[Any] = Problem.slices  # as of a problem with its code
    unit: ClassVar[Any] = Problem.unit

    def found(self, unpickle: bool) -> Problem:
        """Return the problem of the system, or that which is unpickled."""
        if self.system is not None and self.initial is not None:
            # Another version of the system may refuse; of states that are projected it warned then.
            with (
                suppress(Exception),
                warnings.catch_warnings(action="ignore", category=GeomintWarning),
            ):
                keys = dict(self.system)
                system = find_system(keys.pop("name"))
                model = system.build(system.parameters(**keys), system.initial(**self.initial))
                return next(one for one in model.problems.values() if known(one) == known(self))
        return super().found(unpickle)


def known(value: Any) -> tuple[Any, ...]:
    """Return what is known of a problem or a method with its code or without.

    That are the name, of a method its options if it is found by it, else time, pieces and parameters.
    """
    if isinstance(value, Method | StoredMethod):
        told = StoredMethod.of(value)
        return told.name, told.options
    return value.name, value.time, value.pieces, np.asarray(value.params).tobytes()


def _sent(value: Any) -> bytes:
    """Return the bytes that find a value again, or none."""
    try:
        return sent(value)
    except Exception:  # whatever a foreign object raises there
        return b""
