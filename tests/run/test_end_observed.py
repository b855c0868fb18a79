"""The end of a run is observed, however seldom something is sampled."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import geomint as gi
from geomint.methods.stepper import Stepper
from geomint.problems.testproblems import pulsating_body
from geomint.run import driver
from geomint.watch.observe import Observers

pytestmark = pytest.mark.nojit


@gi.field
def turning(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.field
def ending(params, t, y, out, work):
    out[0] = -y[1] / gi.sqrt(1.0 - t)
    out[1] = y[0] / gi.sqrt(1.0 - t)


@gi.field
def swinging_rate(params, t, y, work):
    return 1.0 + 0.3 * y[0]


@gi.observable
def size(params, t, y, work):
    return y[0] * y[0] + y[1] * y[1]


@gi.observable
def density(params, t, y, work):
    return 0.0 * y[0]


MORE = {"invariants": {"size": size}, "measure": gi.Measure(density)}
IN_T = gi.Problem("circle", (("y", 2),), field=turning, **MORE)
IN_TAU = gi.Problem("circle", (("y", 2),), field=turning, time="tau", clock=swinging_rate, **MORE)
ENDING = gi.Problem("ending", (("y", 2),), field=ending, **MORE)
ADAPTIVE = gi.Adaptive(gi.RungeKutta("bogacki-shampine-3"), rtol=1e-2, atol=1e-2)
START = np.array([0.8, 0.6])
RUNS = {
    "whole steps": (IN_T, {"t_end": 1.0}, "heun-2"),
    "a last partial step": (IN_T, {"t_end": 0.97}, "heun-2"),
    "end in t of a problem in tau": (IN_TAU, {"t_end": 1.0}, "heun-2"),
    "end in tau": (IN_TAU, {"tau_end": 1.0}, "heun-2"),
    "end in tau without a clock": (IN_TAU, {"tau_end": 1.0, "clock": False}, "heun-2"),
    "adaptive": (IN_T, {"t_end": 1.0}, ADAPTIVE),
    "adaptive, end in t": (IN_TAU, {"t_end": 1.0}, ADAPTIVE),
}


def solved(problem, end, method, **options):
    step = 0.1 if isinstance(method, str) else None
    return gi.solve(
        problem, START, **end, method=method, step=step, compiled=False, progress=False, **options
    )


def backwards(end: dict) -> dict:
    return {key: -x if key.endswith("end") else x for key, x in end.items()}


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("every", [1, 2, 3, 7, 1000])
@pytest.mark.parametrize("name", RUNS)
def test_the_end_is_a_sample(name: str, every: int, sign: int) -> None:
    """And the only one besides those of every so many steps; nothing is counted twice."""
    problem, end, method = RUNS[name]
    end = end if sign == 1 else backwards(end)
    whole = solved(problem, end, method, save_every=1)
    for save_every in (None, 1, 5):
        some = solved(
            problem, end, method, observe="size", observe_every=every, save_every=save_every
        )
        drift = some.drift["size"]
        start = gi.value(problem, size, START)
        deviations = np.array([gi.value(problem, size, y) - start for y in whole.y])
        samples = sorted({*range(every, whole.steps + 1, every), len(whole.y) - 1})
        assert drift.final_error == deviations[-1] != 0.0
        assert drift.max_abs_error == np.max(np.abs(deviations[samples]))
        assert drift.windows.samples == len(samples)
        reached = whole.tau if "tau_end" in end else whole.t
        assert drift.windows.last_time == reached[-1]
        np.testing.assert_allclose(drift.windows.times, reached[samples])
        np.testing.assert_array_equal(drift.windows.means, deviations[samples])
        np.testing.assert_array_equal(some.y[-1], whole.y[-1])


@pytest.mark.parametrize("every", [1, 3, 1000])
def test_a_failed_run_is_observed_to_its_last_state(every: int) -> None:
    for end, observed in itertools.product((2.0, 1.55), ("size", "all")):
        with pytest.raises(gi.NonFiniteError) as caught:
            solved(ENDING, {"t_end": end}, "heun-2", observe=observed, observe_every=every)
        partial = caught.value.partial
        drift = partial.drift["size"]
        assert drift.windows.last_time == partial.t[-1] > 0.8
        assert drift.final_error == gi.value(ENDING, size, partial.y[-1]) - gi.value(
            ENDING, size, START
        )


def test_a_run_that_fails_at_once_has_no_sample() -> None:
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(ENDING, START, t_end=4.0, step=2.0, method="heun-2", compiled=False, observe="all")
    for drift in caught.value.partial.drift.values():
        assert (drift.windows.samples, drift.final_error) == (0, 0.0)


@pytest.mark.parametrize("every", [1, 3, 1000])
@pytest.mark.parametrize("where", ["kernel", "observers"])
def test_an_interrupted_run_is_observed_to_its_last_state(
    every: int, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver, "FIRST_CHUNK", 10)
    monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
    calls = {"n": 0}

    def interrupt_after(original):
        def wrapped(*args, **kwargs):
            result = original(*args, **kwargs)
            calls["n"] += 1
            if calls["n"] == 4:
                raise KeyboardInterrupt
            return result

        return wrapped

    target, name = {"kernel": (Stepper, "advance"), "observers": (Observers, "add")}[where]
    with monkeypatch.context() as patch:
        patch.setattr(target, name, interrupt_after(getattr(target, name)))
        sol = solved(IN_T, {"t_end": 1e6}, "heun-2", observe="size", observe_every=every)
    drift = sol.drift["size"]
    assert sol.status == "interrupted"
    assert drift.windows.last_time == sol.t[-1] > 0.0
    assert drift.final_error == gi.value(IN_T, size, sol.y[-1]) - gi.value(IN_T, size, START)
    times = drift.windows.times
    assert (np.diff(times) > 0.0).all()


@pytest.mark.parametrize("end", [1.0, 0.97, -1.0])
@pytest.mark.parametrize("limit", [None, 1, 4, 5, 100])
def test_the_measure_is_sampled_at_its_end(limit: int | None, end: float) -> None:
    """That of the run, or that of the first `steps`; its sum does not depend on samples."""
    options = {"method": "heun-2", "step": 0.1, "compiled": False}
    observe = {"measure": {"steps": limit}}
    all_steps = gi.solve(IN_T, START, t_end=end, observe=observe, **options).drift["measure"]
    for every in (2, 3, 1000):
        some = gi.solve(
            IN_T, START, t_end=end, observe=observe, observe_every=every, **options
        ).drift["measure"]
        assert some.final_error == all_steps.final_error != 0.0
        assert some.windows.last_time == all_steps.windows.last_time
        assert len(set(some.windows.times)) == some.windows.samples


def test_group_methods_too() -> None:
    problem, y0 = pulsating_body.problem(), pulsating_body.INITIAL
    sol = gi.solve(
        problem, y0, t_end=1.0, step=0.1, method="cf-2", observe="all", observe_every=7,
        compiled=False,
    )  # fmt: skip
    for name, drift in sol.drift.items():
        if name != "measure":
            f = problem.diagnostics[name]
            assert drift.final_error == gi.value(problem, f, sol.y[-1], 1.0) - gi.value(
                problem, f, y0
            )
        assert drift.windows.last_time == 1.0
