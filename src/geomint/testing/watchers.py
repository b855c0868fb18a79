"""What every watcher has."""

import copy
import pickle
from typing import Any

import numpy as np

from ..arguments import Array, positive
from ..kernels.compiling.sameness import same
from ..kernels.numbers.blocks import scalar_block
from ..methods import find_method
from ..problems.problem import Problem
from ..run.solve import solve
from ..watch.drift import Drift
from ..watch.watcher import Run, Seen, Watcher
from .judge import checks, hold, sure

__all__ = ["check_watcher"]

STEPS, SELDOM = 60, 7


@checks(Watcher)
def check_watcher(
    watcher: Watcher, problem: Problem, y0: Array, step: float, method: str = "rk-4"
) -> None:
    """Raise `AssertionError` for the first property of a watcher that does not hold.

    It is a value: copies, pickles and options given again make an equal one, and runs leave it as it
    was. What it sees does not depend on what is watched beside it, on a run before, nor on chunks of a
    run; it changes no state; sampled more seldom, what sees every state ends with the same value.

    Parameters
    ----------
    watcher : Watcher
    problem : Problem
    y0 : array
        Where 60 steps, forth and back, make sense.
    step : float
        Their length, > 0.
    method : str
        That fits the problem. Runs are in plain Python.
    """
    step, name = positive("step", step), type(watcher).__name__
    end_name = "tau_end" if problem.time == "tau" else "t_end"
    made = [copy.copy(watcher), pickle.loads(pickle.dumps(watcher))]
    made.append(watcher.with_options(**watcher.options))
    sure(all(watcher == other for other in made), f"{name}: a copy is not equal to the watcher")
    before, own = copy.copy(watcher), problem.canonical(y0)

    def run(end: float, observe: Any, every: int = 1) -> Any:
        options = {end_name: end, "observe": observe, "observe_every": every}
        options |= {"compiled": False, "progress": False}
        return solve(problem, own, step=step, method=method, **options)

    for end in (STEPS * step, -STEPS * step, (STEPS + 0.4) * step):
        alone = run(end, {"it": watcher})
        drift = alone.drift["it"]
        sure(same(vars(watcher), vars(before)), f"{name}: a run changes the watcher itself")
        hold(run(end, ()).y[-1], alone.y[-1], f"{name} changes the run that it watches")
        again = run(end, {"other": watcher, "it": watcher}).drift["it"]
        sure(again == drift, f"{name}: a second run sees something else")
        if watcher.sees_all:
            last = run(end, {"it": watcher}, SELDOM).drift["it"].final_error
            words = f"{name}: sampled more seldom it ends at {last}, not {drift.final_error}"
            sure(last == drift.final_error or last != last, words)
    whole, cut = (_in_chunks(watcher, problem, own, step, method, size) for size in (STEPS, SELDOM))
    sure(whole == cut, f"{name}: what is seen depends on the chunks of a run")


def _in_chunks(
    watcher: Watcher, problem: Problem, y0: Array, step: float, method: str, size: int
) -> Drift:
    """Return the drift over a run whose states come in chunks of a size."""
    own = find_method(method)
    stepper = own.on(problem, y0, compiled=False).begin(y0, 0.0, step)
    run = Run(problem, y0, 0.0, stepper, method=own)
    (watch,) = type(watcher).together({"it": watcher}, run)
    watch.prepare()
    out = scalar_block(STEPS * stepper.rows)
    stepper.advance(0, STEPS, 1, out)
    states = out.data.reshape(STEPS, -1)
    times = step * np.arange(1.0, STEPS + 1.0)
    seen = Seen(times, times, states, np.ones(STEPS, dtype=bool), step)
    for first in range(0, STEPS, size):
        watch.add(seen.of(slice(first, first + size)))
    return next(iter(watch.drifts(STEPS)))
