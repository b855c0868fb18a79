"""One motion of a section by the exact flow: followed until it has its points."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from ...arguments import Array
from ...problems.declaration import check_problem, check_watched
from ...problems.problem import Problem
from ..events import Event, looked_at
from ..met import Met
from .crossings import ExactCrossings
from .follow import check_no_steps
from .path import ExactPath

PATIENCE = 10**5  # pieces without a point after which no more are expected


class ExactTrail:
    """One exact motion, followed until it has crossed a surface so many times.

    Parameters
    ----------
    options : mapping
        ``step``, which has to be None, and ``clock`` for a problem in τ.
    end : float
        In the problem's own time, or an infinity.
    """

    steps, span = 0, 0.0

    def __init__(
        self, problem: Problem, name: str, event: Event, count: int, options: Any, end: float
    ) -> None:
        check_no_steps(step=options["step"])
        options["method"].check_fits(problem, False)
        self._problem, self._name, self._end = problem, name, end
        self._count, self._event = count, replace(event, terminal=count)
        self._clock = bool(options.get("clock"))
        self._crossings: ExactCrossings | None = None
        self._ahead: Iterator[float] = iter(())
        self._idle_from = 0.0

    @property
    def points(self) -> int:
        """How many it has so far."""
        return 0 if self._crossings is None else self._crossings.count(self._name)

    @property
    def parts(self) -> list[Met]:
        """The points so far."""
        return [] if self._crossings is None else [self._crossings.met[self._name]]

    def goes_on(self, y0: Array) -> bool:
        """Follow it for some pieces; tell whether there is more to come."""
        if self._crossings is None:
            check_problem(self._problem, y0, self._problem.forms[0], self._clock)
            function = looked_at(self._event, self._problem)
            check_watched(self._problem, y0, {f"events[{self._name!r}]": function})
            self._path = ExactPath(self._problem, y0, 0.0, 0.0)
            self._crossings = ExactCrossings(
                self._path, {self._name: self._event}, 0.0, math.copysign(1.0, self._end),
                clock=self._clock,
            )  # fmt: skip
            self._crossings.prepare()
            self._ahead = self._crossings.follow(self._end)
        before = self.points
        reached = next(self._ahead, None)
        if self._crossings.error is not None:
            raise self._crossings.error
        if reached is None:
            return False
        if self.points > before:
            self._idle_from = reached
        idle = abs(reached - self._idle_from) > PATIENCE * self._path.piece
        return not (idle or self._crossings.stopped or reached == self._end)
