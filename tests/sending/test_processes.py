"""Runs in processes that are spawned: the same bits, by the code that this process compiled."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

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

    return gi.Problem(
        "turning",
        (("y", 2),),
        params=[2.0],
        field=turning,
        invariants={"energy": gi.observable(scaled)},
    )


def solved(problem: gi.Problem, y0: Any, method: gi.Method) -> gi.Solution:
    return gi.solve(
        problem, y0, t_end=1.0, method=method, step=0.1, observe=list(problem.invariants)
    )


def in_process(problem: gi.Problem, y0: Any, method: gi.Method) -> tuple[gi.Solution, list[str]]:
    """Return a run of the process, and what it had to compile."""
    from geomint.kernels.compiling.compile import listen

    compiled: list[str] = []
    listen(lambda name, seconds: compiled.append(name))
    return solved(problem, y0, method), compiled


def test_the_same_bits_by_the_same_code() -> None:
    ball = gi.load_scene("ball-3d")
    session: dict[str, Any] = {"gi": gi, "__name__": "__main__"}
    exec("@gi.field\ndef mine(params, t, y, out, work):\n    out[0] = -3.0 * y[0]", session)
    cases = [
        (ball.problem, ball.state, gi.CommutatorFree()),
        (made(2.0), np.array([1.0, 0.0]), gi.RungeKutta()),
        (gi.Problem("mine", (("y", 1),), field=session["mine"]), np.ones(1), gi.RungeKutta()),
    ]
    own = [solved(*case) for case in cases]
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        for solution, future in zip(own, [pool.submit(in_process, *c) for c in cases], strict=True):
            found, compiled = future.result()
            assert found == solution
            assert found.y.tobytes() == solution.y.tobytes()
            assert compiled == []
