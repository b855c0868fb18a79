"""A function that is called between chunks, and what it may do."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run import driver

PROBLEM, Y0 = henon_heiles.problem(), henon_heiles.INITIAL
ADAPTIVE = {"method": "dormand-prince-5-adaptive", "step": None, "compiled": False}


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks of 64 steps, and then of one."""
    monkeypatch.setattr(driver, "CHUNK_SECONDS", 0.0)
    monkeypatch.setattr(driver, "FIRST_CHUNK", 64)


def run(callback: Any, **options: Any) -> gi.Solution:
    given = {"t_end": 100.0, "step": 0.1, "method": "rk-4", "callback": callback, **options}
    return gi.solve(PROBLEM, Y0, **given)


@pytest.mark.parametrize("options", [{}, {"save_every": 7}, {"observe": ["energy"]}, ADAPTIVE])
def test_told_where_it_is(options: dict[str, Any]) -> None:
    """States of whole steps, in order; the run has the bits of one without."""
    seen: list[Any] = []
    watched, plain = (run(call, t_end=20.0, **options) for call in (seen.append, None))
    assert watched == plain
    steps = [reached.steps for reached in seen]
    assert steps == sorted(set(steps))
    assert steps[0] >= 1
    assert steps[-1] == plain.steps or plain.steps == steps[-1] + 1
    first = seen[0]
    assert first.t == first.tau
    if not options:
        assert first.steps == 64
        np.testing.assert_array_equal(run(None, t_end=first.tau).y[-1], first.y)


@pytest.mark.parametrize("answer", [True, np.True_])
@pytest.mark.parametrize("options", [{}, {"save_every": 7, "dense": True}, {"t_eval": [3.0, 90.0]}])
def test_ends_the_run(options: dict[str, Any], answer: Any) -> None:
    """Where it says so; what is left goes on to the bits of one run."""
    ended = run(lambda reached: answer if reached.steps >= 200 else None, **options)
    assert ended.success
    assert "callback" in ended.message
    assert ended.steps == 200
    if "t_eval" not in options:
        assert ended.tau[-1] == pytest.approx(0.1 * ended.steps)
    rest = gi.solve(ended, t_end=100.0)
    assert rest.y[-1].tobytes() == run(None).y[-1].tobytes()


@gi.observable
def pace(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 2.0 + y[0] * gi.sin(t)


def test_in_tau() -> None:
    """Both times are told, also on the way to an end in physical time."""
    problem, seen = dataclasses.replace(PROBLEM, time="tau", clock=pace), []
    for end in ({"tau_end": 30.0}, {"t_end": 40.0}, {"tau_end": 20.0, "clock": False}):
        seen.clear()
        gi.solve(problem, Y0, step=0.1, method="rk-4", callback=seen.append, compiled=False, **end)
        assert len(seen) > 2
        for reached in seen:
            assert reached.tau == pytest.approx(0.1 * reached.steps)
            assert reached.t is None if "clock" in end else 1.0 < reached.t / reached.tau < 3.0


@pytest.mark.parametrize("options", [{}, ADAPTIVE])
def test_stops_where_it_could_not_finish(options: dict[str, Any]) -> None:
    """An adaptive run, and one with an event: what had been found is kept."""
    ended = run(lambda reached: True, events="q[0]", t_end=1000.0, **options)
    assert ended.success
    assert (ended.t_events[0] <= ended.tau[-1]).all()


def test_the_end_of_an_adaptive_run_is_its_own() -> None:
    """Whatever the callback says there."""
    whole = run(lambda reached: reached.tau >= 5.0, t_end=5.0, **ADAPTIVE)
    assert (whole.message, whole.t[-1]) == ("", 5.0)


def failing(error: type[BaseException]) -> Any:
    def callback(reached: Any) -> None:
        raise error("no more")

    return callback


@pytest.mark.parametrize("answer", [1, "yes", np.ones(3)])
def test_fails(answer: Any) -> None:
    """What it raises, and answers that are none, end the run with what there is; so does Ctrl-C."""
    with pytest.raises(gi.WatcherError, match=r"callback.*no more") as caught:
        run(failing(ValueError))
    assert caught.value.partial.steps == 64
    with pytest.raises(gi.WatcherError, match="expected True, False or None"):
        run(lambda reached: answer)
    with pytest.raises(gi.DomainError, match="callback"):
        run(answer)
    ended = run(failing(KeyboardInterrupt))
    assert (ended.status, ended.steps) == ("interrupted", 64)
