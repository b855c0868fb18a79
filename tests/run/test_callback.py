"""A function that is called between chunks, and what it may do."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run import driver

PROBLEM = henon_heiles.problem()
Y0 = henon_heiles.INITIAL


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 64 steps, all of them."""
    monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
    monkeypatch.setattr(driver, "FIRST_CHUNK", 64)


def run(callback: Any, **options: Any) -> gi.Solution:
    given = {"t_end": 100.0, "step": 0.1, "method": "rk-4", "callback": callback, **options}
    return gi.solve(PROBLEM, Y0, **given)


@pytest.mark.parametrize(
    "options",
    [{}, {"save_every": 7}, {"observe": ["energy"]}, {"method": "dop853-adaptive", "step": None}],
)
def test_told_where_it_is(options: dict[str, Any]) -> None:
    """States of whole steps, in order; the run has the bits of one without."""
    seen: list[Any] = []
    watched, plain = run(seen.append, **options), run(None, **options)
    assert watched == plain
    steps = [reached.steps for reached in seen]
    assert steps == sorted(set(steps))
    assert steps[0] >= 1
    assert steps[-1] == plain.steps or plain.steps == steps[-1] + 1
    first = seen[0]
    assert first.t == first.tau
    if not options:
        again = gi.solve(PROBLEM, Y0, t_end=first.tau, step=0.1, method="rk-4")
        np.testing.assert_array_equal(again.y[-1], first.y)


@pytest.mark.parametrize("answer", [True, np.True_])
@pytest.mark.parametrize(
    "options", [{}, {"save_every": 7}, {"dense": True}, {"t_eval": [3.0, 90.0]}]
)
def test_ends_the_run(options: dict[str, Any], answer: Any) -> None:
    """Where it says so; what is left goes on to the bits of one run."""
    ended = run(lambda reached: answer if reached.steps >= 200 else None, **options)
    assert ended.success
    assert "callback" in ended.message
    assert 200 <= ended.steps < 400
    if "t_eval" not in options:
        assert ended.tau[-1] == pytest.approx(0.1 * ended.steps)
    rest = gi.solve(ended, t_end=100.0)
    assert rest.y[-1].tobytes() == run(None).y[-1].tobytes()


def test_in_tau() -> None:
    """Both times are told, also on the way to an end in physical time."""
    problem = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0).hamiltonized()
    y0 = problem.random_state(3)
    seen: list[Any] = []
    for end in ({"tau_end": 60.0}, {"t_end": 40.0}):
        seen.clear()
        gi.solve(problem, y0, step=0.1, callback=seen.append, **end)
        rates = [reached.t / reached.tau for reached in seen]
        assert len(rates) > 2
        assert all(0.0 < rate < 10.0 and rate != 1.0 for rate in rates)
    gi.solve(problem, y0, tau_end=20.0, step=0.1, clock=False, callback=seen.append)
    assert seen[-1].t is None


def test_stops_where_it_could_not_finish() -> None:
    """An adaptive run, and one with an event: what had been found is kept."""
    for method in ("dop853-adaptive", "gauss-4"):
        options = {"method": method, "step": None if "adaptive" in method else 0.1}
        ended = run(lambda reached: True, events="q[0]", t_end=1000.0, **options)
        assert ended.success
        assert (ended.t_events[0] <= ended.tau[-1]).all()


@pytest.mark.parametrize("answer", [1, "yes", np.ones(3)])
def test_fails(answer: Any) -> None:
    """What it raises, and answers that are none, end the run with what there is."""

    def raising(reached: Any) -> None:
        raise ValueError("no more")

    with pytest.raises(gi.WatcherError, match=r"callback.*no more") as caught:
        run(raising)
    assert caught.value.partial.steps == 64
    with pytest.raises(gi.WatcherError, match="expected True, False or None"):
        run(lambda reached: answer)
    with pytest.raises(gi.DomainError, match="callback"):
        run(answer)


def test_interrupted() -> None:
    """Ctrl-C in it is Ctrl-C in the run."""

    def interrupted(reached: Any) -> None:
        raise KeyboardInterrupt

    ended = run(interrupted)
    assert ended.status == "interrupted"
    assert ended.steps == 64
