"""Readings that take runs of their own: Lyapunov exponents, points of a section."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ....arguments import Array, whole
from ....errors import DomainError, StepError
from ....problems.problem import Problem
from ...events import choose_events
from ...exponents import Lyapunov
from ...lyapunov import lyapunov
from ...poincare import poincare_section
from ..given import Asked
from .reading import Ran, Reading

VERDICTS = {"regular": 0.0, "undecided": 0.5, "chaotic": 1.0}  # as numbers, for readings


@dataclass(frozen=True)
class Exponents(Reading):
    """``exponent``: the largest Lyapunov exponents by `geomint.lyapunov`, one or several.

    Of one the reading has shape (N,), of several (N, count); per unit of the problem's own time, in
    which the end has to be given: to that, whatever events end runs before.
    """

    count: int = 1
    kind: ClassVar[str] = "exponent"

    @property
    def name(self) -> str:
        return self.kind if self.count == 1 else f"{self.kind}s"

    def check(self, problem: Problem, asked: Asked) -> None:
        whole("count", self.count, 1, problem.rows)
        if problem.time == "tau" and asked.shared["tau_end"] is None:
            expected = "tau_end: exponents are those of the problem's own time"
            raise DomainError("t_end", asked.shared["t_end"], expected)
        if asked.method.adaptive:
            raise DomainError("method", asked.method.name, "steps of one length for exponents")

    def read(self, ran: Ran) -> Array:
        read = np.full((len(ran), self.count), np.nan)
        for k, found in self._runs(ran).items():
            read[k] = self._of(found)
        return read[:, 0] if self.count == 1 else read

    def _of(self, found: Lyapunov) -> Array:
        return found.exponents

    def _runs(self, ran: Ran) -> dict[int, Lyapunov]:
        """Return the runs of directions beside members, made once for all that is read off them."""
        runs = ran.shared.get((Exponents, self.count))
        if runs is not None:
            return runs
        runs = ran.shared[Exponents, self.count] = {}
        given = {**ran.asked.ends, "method": ran.asked.method, "count": self.count}
        for k in ran.ended:
            if ran.stop[0]:
                break
            try:
                found = lyapunov(ran.problem(k), ran.given.states[k], progress=False, **given)
            except StepError as error:  # of the directions alone: the run itself has ended well
                ran.found.errors.setdefault(int(k), error)
                continue
            ran.found.cut |= found.status == "interrupted"
            if found.status == "success":
                runs[int(k)] = found
        return runs


@dataclass(frozen=True)
class ExponentErrors(Exponents):
    """``exponent-error``: one standard error of each of `Exponents`."""

    kind: ClassVar[str] = "exponent-error"

    def _of(self, found: Lyapunov) -> Array:
        return found.errors


@dataclass(frozen=True)
class ExponentVerdict(Exponents):
    """``chaotic``: 1 where the largest exponent is above 0, 0 where it is compatible with 0.

    ½ where the run is too short to tell: the verdict of `geomint.lyapunov`.
    """

    kind: ClassVar[str] = "chaotic"

    @property
    def name(self) -> str:
        return self.kind

    def read(self, ran: Ran) -> Array:
        read = np.full(len(ran), np.nan)
        for k, found in self._runs(ran).items():
            read[k] = VERDICTS[found.verdict]
        return read


@dataclass(frozen=True, eq=False)
class SectionPoints(Reading):
    """Points of a Poincaré section by `geomint.poincare_section`, of every member.

    Shape (N, points, rows + 1): the problem's own time, then the state; NaN where a member crosses no
    more. Members are followed from time 0 until they have their points, whatever the end of the
    ensemble and events that end its runs.

    Parameters
    ----------
    event : str or Event
        The surface.
    points : int
        Of each member.
    """

    event: Any
    points: int = 100

    @property
    def name(self) -> str:
        return f"section:{', '.join(choose_events(self.event))}"

    def check(self, problem: Problem, asked: Asked) -> None:
        whole("points", self.points, 1)
        if len(choose_events(self.event)) != 1:
            raise DomainError("event", self.event, "one event")
        begin, why = asked.shared["t0"], "points of a section are looked for from there on"
        if begin != 0.0:
            raise DomainError("t0", begin, f"0: {why}")
        for name in ("t_end", "tau_end"):
            end = asked.shared[name]
            if end is not None and not float(end) > 0.0:
                raise DomainError(name, end, f"an end after 0: {why}")

    def read(self, ran: Ran) -> Array:
        rows = ran.given.states.shape[1]
        read = np.full((len(ran), self.points, 1 + rows), np.nan)
        given = {"method": ran.asked.method, "step": ran.asked.shared["step"], "progress": False}
        for k in ran.ended:
            if ran.stop[0]:
                break
            state = ran.given.states[k]
            try:
                found = poincare_section(ran.problem(k), state, self.event, self.points, **given)
            except StepError as error:
                ran.found.errors.setdefault(int(k), error)
                found = error.partial
            ran.found.cut |= found is not None and found.status == "interrupted"
            if found is not None and found.status != "interrupted":
                read[k, : len(found), 0], read[k, : len(found), 1:] = found.tau, found.y
        return read
