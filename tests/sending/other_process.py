"""What the tests of this folder do in other processes, which import this module."""

from __future__ import annotations

from typing import Any

import geomint as gi

FACTOR = 0.5


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A function of a module that the other process imports."""
    out[0] = FACTOR * y[1]
    out[1] = -params[0] * y[0]


def made(factor: float) -> gi.Problem:
    """Return a problem whose observable is a closure."""

    def scaled(params: Any, t: Any, y: Any, work: Any) -> Any:
        return factor * y[0]

    invariants = {"energy": gi.observable(scaled)}
    return gi.Problem("turning", (("y", 2),), [2.0], field=turning, invariants=invariants)


def solved(problem: gi.Problem, y0: Any, method: gi.Method) -> gi.Solution:
    run = {"t_end": 1.0, "step": 0.1, "observe": list(problem.invariants)}
    return gi.solve(problem, y0, method=method, **run)


def in_process(problem: gi.Problem, y0: Any, method: gi.Method) -> tuple[gi.Solution, list[str]]:
    """Return a run of the process, and what it had to compile."""
    from geomint.kernels.compiling.compile import listen

    compiled: list[str] = []
    listen(lambda name, seconds: compiled.append(name))
    return solved(problem, y0, method), compiled
