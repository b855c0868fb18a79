"""Whole calls as a user makes them, timed in one checkout; `floors.py` runs it in two, in turns.

A line of standard input names a row and a number of repeats; the answer is a line of JSON: for each
random state the median of the seconds that a call took. Calls before the clock: one for each state.
"""

from __future__ import annotations

import gc
import json
import statistics
import sys
import time
import warnings
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import chaplygin as ch
import geomint as gi

STATES = 32
STEP, STEPS, MANY = 0.05, 4, 2000
FAMILIES = ("gauss-8", "verlet-4", "rattle-2", "cf-4", "rkmk-4", "rk-4")  # of the sphere, the ball
Call = Callable[[], Any]


@cache
def sphere() -> gi.Problem:
    """Return the Hamiltonised sphere, n = 3."""
    return ch.ChaplyginSphere(a=(0.8, 1.1, 1.5), D=4.0).hamiltonized()


@cache
def ball() -> gi.Problem:
    """Return the classical ball in R³."""
    return ch.ChaplyginSphere.from_moments((1.0, 2.0, 3.0), 1.0, 1.0).classical()


def short(seed: int, watched: int = 0) -> Call:
    """Return a solve of four steps of gauss-8."""
    problem, end = sphere(), STEP * STEPS
    names = list(problem.diagnostics)[:watched]
    given: dict[str, Any] = {"observe": names} if names else {}
    y0 = problem.random_state(seed)
    return partial(gi.solve, problem, y0, tau_end=end, step=STEP, clock=False, **given)


def default_step(seed: int) -> Call:
    """Return the same span with the default step."""
    y0 = sphere().random_state(seed)
    return partial(gi.solve, sphere(), y0, tau_end=STEP * STEPS, clock=False)


def physical_end(seed: int) -> Call:
    """Return four steps to an end in physical time of a problem in τ."""
    y0 = sphere().random_state(seed)
    end = gi.solve(sphere(), y0, step=STEP, tau_end=STEP * STEPS, clock=True).t[-1]
    return partial(gi.solve, sphere(), y0, step=STEP, t_end=end)


def by_tolerance(seed: int) -> Call:
    """Return a run of the ball to T = 100 with a tolerance."""
    y0 = ball().random_state(seed)
    return partial(gi.solve, ball(), y0, t_end=100.0, method="auto", tolerance=1e-9)


def its_steps(seed: int) -> Call:
    """Return the steps of that run alone."""
    y0 = ball().random_state(seed)
    found = by_tolerance(seed)()
    given = {"method": found.method, "step": abs(found.step)}
    made = gi.Integrator(ball(), y0, **given)

    def again() -> None:
        made.reset()
        made.step(found.steps)

    return again


def four_steps(seed: int) -> Call:
    """Return four steps of an integrator that is there."""
    made = gi.Integrator(sphere(), sphere().random_state(seed), "gauss-8", step=STEP)
    return partial(made.step, STEPS)


def many_steps(seed: int) -> Call:
    """Return many steps of an integrator that is there: each state with one of the families."""
    method = FAMILIES[seed % len(FAMILIES)]
    problem = sphere() if method in FAMILIES[:3] else ball()
    made = gi.Integrator(problem, problem.random_state(seed), method, step=STEP)
    return partial(made.step, MANY)


ROWS: dict[str, Callable[[int], Call]] = {
    "solve": short,
    "observe": partial(short, watched=3),
    "default-step": default_step,
    "physical-end": physical_end,
    "tolerance": by_tolerance,
    "its-steps": its_steps,
    "integrator": four_steps,
    "steps": many_steps,
}


def timed(calls: list[Call], repeats: int) -> list[float]:
    """Return for each call the median of its times."""
    found = []
    gc.collect()
    for call in calls:
        times = []
        for _ in range(repeats):
            begun = time.perf_counter()
            call()
            times.append(time.perf_counter() - begun)
        found.append(statistics.median(times))
    return found


def main() -> None:
    """Answer lines of standard input until it ends."""
    warnings.simplefilter("ignore", gi.GeomintWarning)
    made: dict[str, list[Call]] = {}
    for line in sys.stdin:
        name, repeats = line.split()
        if name not in made:
            made[name] = [ROWS[name](seed) for seed in range(STATES)]
            timed(made[name], 1)
        print(json.dumps(timed(made[name], int(repeats))), flush=True)


if __name__ == "__main__":
    main()
