"""What is saved by `save_every`, by `t_eval`, and by both: every combination of a small run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from tests.rows import examples
from tests.run.motions import first, swing

pytestmark = pytest.mark.nojit

SWING = swing()
IN_TAU = gi.Problem(
    *("swing", SWING.pieces, SWING.params, SWING.field),
    time="tau",
    clock=gi.observable(lambda params, t, y, work: 1.0 + 0.3 * y[0]),
)
STEP = 0.25
ADAPTIVE = gi.Adaptive(gi.RungeKutta("bogacki-shampine-3"), rtol=1e-2, atol=1e-2)
KINDS: dict[str, dict[str, Any]] = {
    "fixed": {"problem": SWING, "method": "rk-4", "step": STEP},
    "adaptive": {"problem": SWING, "method": ADAPTIVE},
    "clock, end in t": {"problem": IN_TAU, "method": "rk-4", "step": 0.5 * STEP},
    "clock, end in tau": {"problem": IN_TAU, "method": "rk-4", "step": STEP},
    "adaptive clock, end in t": {"problem": IN_TAU, "method": ADAPTIVE},
}


def run(kind: str, end: float, **asked: Any) -> gi.Solution:
    time = "tau_end" if "tau" in kind else "t_end"
    given = {**KINDS[kind], time: end, **asked, "compiled": False, "progress": False}
    return gi.solve(y0=[0.8, -0.6], **given)


def near(a: float, b: float) -> bool:
    return abs(a - b) <= 4 * math.ulp(b)


def times_to_ask_for(whole: gi.Solution) -> list[float]:
    """0, the end, a step, times between, and next to a step."""
    t = [float(x) for x in whole.t]
    middle = t[len(t) // 2]
    beside = [math.nextafter(middle, x) for x in (0.0, 2 * t[-1]) if middle != t[-1]]
    return [0.0, t[-1], t[1], middle, 0.3 * t[1], 0.5 * (t[-2] + t[-1]), *beside]


@examples(15)
@given(
    *(st.sampled_from(sorted(KINDS)), st.sampled_from([1.0, 2.0, 5.0, 2.6, -1.0, -2.6, -5.0])),
    *(st.sampled_from([None, 1, 2, 3, 9]), st.sets(st.integers(0, 7), max_size=5)),
)
def test_every_combination(kind: str, end: float, every: int | None, which: set[int]) -> None:
    """All states of both kinds, in the order of the run, each once; times as they were asked for."""
    whole = run(kind, end * STEP, save_every=1)
    known, last = times_to_ask_for(whole), len(whole.t) - 1
    wanted = sorted({known[k] for k in which if k < len(known)}, key=abs)
    asked = run(kind, end * STEP, t_eval=wanted or None)
    sol = run(kind, end * STEP, save_every=every, t_eval=wanted or None)
    assert sol.steps == whole.steps
    assert sol.tau.shape == sol.t.shape
    kept = [] if every is None else sorted({*range(0, whole.steps + 1, every), last})
    kept = kept if wanted or kept else [last]
    steps = {float(whole.t[k]): whole.y[k] for k in kept}
    states = {t: y for t, y in steps.items() if not any(near(t, time) for time in wanted)}
    for k, time in enumerate(wanted):  # near a step that is saved it is that one
        step = [steps[t] for t in steps if near(t, time)]
        states[time] = step[0] if step else asked.y[k]
    times = sorted(states, key=abs)
    np.testing.assert_array_equal(sol.t, times)
    np.testing.assert_array_equal(sol.y, [states[time] for time in times])


def test_repeated_times() -> None:
    """Are states as often as they are asked for, where nothing else is saved."""
    np.testing.assert_array_equal(run("fixed", 1.0, t_eval=[0.1, 0.1, 0.5]).t, [0.1, 0.1, 0.5])


def test_a_run_that_fails_keeps_both_kinds_up_to_there() -> None:
    problem = first("ending", lambda p, t, y: 1.0 / gi.sqrt(1.0 - t))
    given: dict[str, Any] = {"step": 0.125, "method": "heun-2", "compiled": False}
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, [0.0, 1.0], t_end=2.0, **given, save_every=3, t_eval=[0.3, 0.75, 1.9])
    np.testing.assert_array_equal(caught.value.partial.t, [0.0, 0.3, 0.375, 0.75, 0.875])
