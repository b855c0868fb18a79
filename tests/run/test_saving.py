"""What is saved by `save_every`, by `t_eval`, and by both: every combination of a small run."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest

import geomint as gi

pytestmark = pytest.mark.nojit


@gi.field
def turning(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.field
def swinging_rate(params, t, y, work):
    return 1.0 + 0.3 * y[0]


IN_T = gi.Problem("circle", (("y", 2),), field=turning)
IN_TAU = gi.Problem("circle", (("y", 2),), field=turning, time="tau", clock=swinging_rate)
STEP = 0.25
ADAPTIVE = gi.Adaptive(gi.RungeKutta("bogacki-shampine-3"), rtol=1e-2, atol=1e-2)
# name: problem, method, the time that the end is in
KINDS = {
    "fixed": (IN_T, "rk-4", "t_end"),
    "adaptive": (IN_T, ADAPTIVE, "t_end"),
    "clock, end in t": (IN_TAU, "rk-4", "t_end"),
    "clock, end in tau": (IN_TAU, "rk-4", "tau_end"),
    "adaptive clock, end in t": (IN_TAU, ADAPTIVE, "t_end"),
}
ENDS = (STEP, 2 * STEP, 5 * STEP, 2.6 * STEP)
EVERY = (1, 2, 3, 9)
FEW = "end in t"  # where every partial step is an iteration


def run(
    kind: str, end: float, save_every: int | None = None, t_eval: Sequence[float] | None = None
) -> gi.Solution:
    return solved(kind, end, save_every, None if t_eval is None else tuple(t_eval))


@functools.cache
def solved(
    kind: str, end: float, save_every: int | None, t_eval: tuple[float, ...] | None
) -> gi.Solution:
    problem, method, time = KINDS[kind]
    step = {"rk-4": 0.5 * STEP if problem is IN_TAU and time == "t_end" else STEP}.get(method)
    return gi.solve(
        problem, [0.8, 0.6], **{time: end}, method=method, step=step, compiled=False, progress=False,
        save_every=save_every, t_eval=t_eval,
    )  # fmt: skip


def near(a: float, b: float) -> bool:
    return abs(a - b) <= 4 * math.ulp(b)


def times_to_ask_for(whole: gi.Solution) -> list[list[float]]:
    """Nothing but 0, the end, a step, a time between, next to a step, and all of these."""
    t = [float(x) for x in whole.t]
    last, first, middle = t[-1], t[1], t[len(t) // 2]
    between = 0.5 * (t[-2] + last)
    beside = [math.nextafter(middle, 0.0), math.nextafter(middle, 2 * last)]
    found = [[0.0], [last], [first], [between], [t[0], between], [between, last]]
    if middle != last:
        found.append(beside)
        found.append(sorted([0.0, *beside, middle, middle, between, last], key=abs))
    return found


def cases(kind: str, sign: int):
    for end in ENDS[2:] if FEW in kind else ENDS:
        whole = run(kind, sign * end, save_every=1)
        for wanted in times_to_ask_for(whole):
            yield sign * end, whole, wanted


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("kind", KINDS)
def test_steps_alone(kind: str, sign: int) -> None:
    """The first, every k-th, the last; each once."""
    for end in ENDS:
        whole = run(kind, sign * end, save_every=1)
        for every in EVERY:
            some = run(kind, sign * end, save_every=every)
            last = len(whole.t) - 1
            kept = sorted({*range(0, some.steps + 1, every), last})
            np.testing.assert_array_equal(some.t, whole.t[kept])
            np.testing.assert_array_equal(some.y, whole.y[kept])
        np.testing.assert_array_equal(run(kind, sign * end).y, whole.y[-1:])


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("kind", KINDS)
def test_times_alone(kind: str, sign: int) -> None:
    """As they were asked for, repeats included, and nothing else."""
    for end, _, wanted in cases(kind, sign):
        np.testing.assert_array_equal(run(kind, end, t_eval=wanted).t, wanted)


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("kind", KINDS)
def test_both(kind: str, sign: int) -> None:
    """All states of both kinds, in the order of the run, each once, the last one always."""
    for end, _, wanted in cases(kind, sign):
        asked = run(kind, end, t_eval=wanted)
        for every in (2, 9) if FEW in kind else EVERY:
            steps, both = (
                run(kind, end, save_every=every),
                run(kind, end, save_every=every, t_eval=wanted),
            )
            where = (end, every, wanted)
            t = [float(x) for x in both.t]
            assert all(sign * a < sign * b for a, b in itertools.pairwise(t)), where
            assert both.t[-1] == steps.t[-1] or both.t[-1] in wanted, where
            np.testing.assert_array_equal(both.y[-1], steps.y[-1])
            assert set(wanted) <= set(t), where
            for time, state in zip(steps.t, steps.y, strict=True):
                same = [i for i, other in enumerate(t) if near(other, float(time))]
                assert same, where
                for i in same:
                    np.testing.assert_array_equal(both.y[i], state)
            alone = [
                time for time in dict.fromkeys(wanted)
                if not any(near(float(other), time) for other in steps.t)
            ]  # fmt: skip
            for time in alone:
                i, j = t.index(time), wanted.index(time)
                np.testing.assert_array_equal(both.y[i], asked.y[j])
            extra = [time for time in t if time not in wanted]
            assert all(any(near(float(s), time) for s in steps.t) for time in extra), where
            assert len(t) == len(set(wanted)) + len(extra), where
            assert both.tau.shape == both.t.shape


def test_the_states_do_not_depend_on_what_is_saved() -> None:
    for kind in KINDS:
        whole, both = run(kind, 1.0, save_every=1), run(kind, 1.0, save_every=2, t_eval=[0.1, 0.5])
        np.testing.assert_array_equal(both.y[-1], whole.y[-1])
        assert both.steps == whole.steps


def test_a_run_that_fails_keeps_both_kinds_up_to_there() -> None:
    @gi.field
    def ending(params, t, y, out, work):
        out[0] = 1.0 / gi.sqrt(1.0 - t)

    problem = gi.Problem("ending", (("y", 1),), field=ending)
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(
            problem, [0.0], t_end=2.0, step=0.125, method="heun-2", compiled=False, progress=False,
            save_every=3, t_eval=[0.3, 0.75, 1.9],
        )  # fmt: skip
    np.testing.assert_array_equal(caught.value.partial.t, [0.0, 0.3, 0.375, 0.75, 0.875])


@pytest.mark.parametrize("wanted", [[], [[0.1, 0.2]], [0.2, 0.1], [-0.1], [1.1], ["a"]], ids=str)
def test_times_that_are_none_are_refused(wanted: list) -> None:
    with pytest.raises(gi.DomainError, match="t_eval"):
        gi.solve(IN_T, [0.8, 0.6], t_end=1.0, step=0.1, method="rk-4", t_eval=wanted, save_every=1)
