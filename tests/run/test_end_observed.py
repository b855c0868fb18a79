"""The end of a run is observed, however seldom something is sampled."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.run import driver

pytestmark = pytest.mark.nojit


@gi.field
def turning(params, t, y, out, work):
    out[0], out[1] = -y[1], y[0]


@gi.field
def ending(params, t, y, out, work):
    out[0], out[1] = -y[1] / gi.sqrt(1.0 - t), y[0] / gi.sqrt(1.0 - t)


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
EVERY = pytest.mark.parametrize("every", [1, 100])


def solved(problem: gi.Problem, **options: Any) -> gi.Solution:
    adaptive = options.get("method") is ADAPTIVE
    usual = {"method": "heun-2", "step": None if adaptive else 0.1, "compiled": False}
    return gi.solve(problem, START, **{**usual, **options}, progress=False)


def off(problem: gi.Problem, y: np.ndarray) -> float:
    return gi.value(problem, size, y) - gi.value(problem, size, START)


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("name", RUNS)
def test_the_end_is_a_sample(name: str, sign: int) -> None:
    """And the only one besides those of every so many steps; nothing is counted twice."""
    problem, end, method = RUNS[name]
    end = {key: sign * x if key.endswith("end") else x for key, x in end.items()}
    whole = solved(problem, **end, method=method, save_every=1)
    deviations = np.array([off(problem, y) for y in whole.y])
    reached = whole.tau if "tau_end" in end else whole.t
    for every, save in ((1, 5), (2, None), (3, 1), (7, 5), (1000, None)):
        observe = {"observe": "size", "observe_every": every, "save_every": save}
        some = solved(problem, **end, method=method, **observe)
        drift = some.drift["size"]
        samples = sorted({*range(every, whole.steps + 1, every), len(whole.y) - 1})
        assert drift.final_error == deviations[-1] != 0.0
        assert drift.max_abs_error == np.max(np.abs(deviations[samples]))
        assert drift.windows.samples == len(samples)
        assert drift.windows.last_time == reached[-1]
        np.testing.assert_allclose(drift.windows.times, reached[samples])
        np.testing.assert_array_equal(drift.windows.means, deviations[samples])
        np.testing.assert_array_equal(some.y[-1], whole.y[-1])


@EVERY
@pytest.mark.parametrize("observed", ["size", "all"])
def test_a_failed_run_is_observed_to_its_last_state(every: int, observed: str) -> None:
    for end in (2.0, 1.55):
        with pytest.raises(gi.NonFiniteError) as caught:
            solved(ENDING, t_end=end, observe=observed, observe_every=every)
        partial = caught.value.partial
        drift = partial.drift["size"]
        assert drift.windows.last_time == partial.t[-1] > 0.8
        assert drift.final_error == off(ENDING, partial.y[-1])
    with pytest.raises(gi.NonFiniteError) as caught:  # at once: there is no sample
        solved(ENDING, t_end=4.0, step=2.0, observe=observed, observe_every=every)
    for drift in caught.value.partial.drift.values():
        assert (drift.windows.samples, drift.final_error) == (0, 0.0)


class Pressing(gi.Watcher):
    """Ctrl-C that comes while something is observed for the fourth time."""

    calls = 0

    def begin(self, run: Any) -> float:
        return 0.0

    def values(self, times: Any, states: Any, lengths: Any) -> Any:
        self.calls += 1
        if self.calls == 4:
            raise KeyboardInterrupt
        return np.zeros(len(times))


@EVERY
@pytest.mark.parametrize("where", ["kernel", "observers"])
def test_an_interrupted_run_is_observed_to_its_last_state(
    every: int, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver, "FIRST_CHUNK", 10)
    monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
    take, calls = gi.Integrator.take, []

    def pressed(*given: Any) -> Any:
        calls.append(take(*given))
        if len(calls) == 4:
            raise KeyboardInterrupt
        return calls[-1]

    observe: dict[str, Any] = {"size": size}
    if where == "observers":
        observe["pressing"] = Pressing()
    else:
        monkeypatch.setattr(gi.Integrator, "take", pressed)
    sol = solved(IN_T, t_end=1e6, observe=observe, observe_every=every)
    drift = sol.drift["size"]
    assert sol.status == "interrupted"
    assert drift.windows.last_time == sol.t[-1] > 0.0
    assert drift.final_error == off(IN_T, sol.y[-1])
    assert (np.diff(drift.windows.times) > 0.0).all()


@pytest.mark.parametrize("end", [0.97, -1.0])
@pytest.mark.parametrize("limit", [None, 1, 4, 100])
def test_the_measure_is_sampled_at_its_end(limit: int | None, end: float) -> None:
    """That of the run, or that of the first `steps`; its sum does not depend on samples."""
    observe = {"measure": {"steps": limit}}
    whole, *others = (
        solved(IN_T, t_end=end, observe=observe, observe_every=every).drift["measure"]
        for every in (1, 3, 1000)
    )
    for some in others:
        assert some.final_error == whole.final_error != 0.0
        assert some.windows.last_time == whole.windows.last_time
        assert len(set(some.windows.times)) == some.windows.samples
