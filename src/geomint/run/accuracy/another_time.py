"""Another time for ``method="auto"``: even steps of dt = σ dτ, where a long motion is uneven in t.

Steps of one length are as short as the motion is fast anywhere, and Gauss methods in the time "speed"
keep what they keep in t, which steps that an error estimate chooses do not. An orbit of Kepler's of
eccentricity 0.7 takes about as long in both times, one of 0.98 a tenth to a fifth in the other
(`benchmarks/another_time.py`).
"""

import numpy as np

from ...errors import DomainError, FormError
from ...kernels.compiling.signatures import VALUE
from ...problems.evaluate import rates_of, value_of
from ...problems.problem import Problem
from ...problems.time_scale import characteristic_time, names_time
from ...problems.time_transformation import time_transformed
from ...watch.functions import Function
from ...watch.observe import choose_watchers
from ..asked import Asked
from ..events import choose_events, quantity
from ..promise import Setting

LONG = 1e6  # iterations of a run: of shorter ones trials in the other time save nothing
UNEVEN = 25.0  # times the step: characteristic times in the mean
DEARER = 5.0  # times: an iteration that evaluates σ as well, with the trials in both times
STEPS = "steps are even in another time"
OWN = ("longest", "callback", "tau_eval")  # arguments that know the problem's own time


def in_another_time(
    chosen: Setting, problem: Problem, asked: Asked, compiled: bool
) -> tuple[Problem, float] | None:
    """Return the problem in the time "speed", and dt/dτ in the mean, where that may serve; else None.

    Nothing that is asked for may depend on which time the problem has: quantities and events are named.
    """
    state, states = chosen.state, chosen.states
    if not chosen.free or chosen.step is None or state is None or states is None:
        return None
    own = problem.time == "tau" or len(asked.breaks) > 0
    own = own or any(getattr(asked, name) is not None for name in OWN)
    known = problem.diagnostics.values()  # all, as a run that goes on may ask for others
    timed = names_time(problem) or any(VALUE.reads(f, "t") for f in known)
    if own or timed or chosen.iterations < LONG or not _named(problem, asked):
        return None
    if abs(asked.t0) > abs((asked.t_end or 0.0) - asked.t0):  # a clock that began there rounds more
        return None
    rate_at = rates_of(problem, state, compiled)
    try:
        times = [characteristic_time(problem, y, rate_at=rate_at) for y in states]
        if np.mean(times) < UNEVEN * chosen.step:
            return None
        uneven = time_transformed(problem, y0=states[np.argmax(times)])  # sizes of most of the time
    except (DomainError, FormError):
        return None
    assert uneven.clock is not None
    rate = value_of(uneven, uneven.clock, state, compiled)
    return uneven, 1.0 / float(np.mean([1.0 / rate(y, 0.0) for y in states]))


def better(chosen: Setting, other: Setting, problem: Problem) -> Setting:
    """Return what is expected to be as good, and to take less time; `other` is in the other time."""
    then, now = chosen.accuracy, other.accuracy
    good = now and then and now.expected <= max(then.expected, then.tolerance)
    if not (now and good) or DEARER * other.iterations >= chosen.iterations:
        return chosen
    accuracy = now._replace(reason=f"{now.reason}; the motion is uneven: {STEPS}")
    return other._replace(problem=problem, accuracy=accuracy, own=chosen)


def _named(problem: Problem, asked: Asked) -> bool:
    """Tell whether all that is looked at is a quantity or a component of the problem, by name."""
    own = problem.diagnostics.values()
    watched = choose_watchers(problem, asked.observe).values()
    for event in choose_events(asked.events).values():
        if not isinstance(event.what, str):
            return False
        quantity(problem, event.what)  # an error names this problem
    return all(type(w) is Function and w.function in own for w in watched)
