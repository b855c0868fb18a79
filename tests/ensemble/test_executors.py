"""Workers of executors: other processes, dask; some of which die."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles

HENON = henon_heiles.problem()
STATES = np.random.default_rng(5).uniform(-0.2, 0.2, (150, 4))
ASKED = {"t_end": 3.0, "step": 0.05, "method": "rk-4"}


def test_processes(tmp_path: Path) -> None:
    """Into a store, and back in memory: failures too."""
    failing, asked = STATES[:70].copy(), {"t_end": 3.0, "step": 0.05, "method": "rk-4"}
    failing[66] = [0.0, 40.0, 0.0, 60.0]
    failing[0] = failing[69] = np.nan
    here = gi.solve_ensemble(HENON, failing, **asked)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        asked["executor"] = pool
        there = gi.solve_ensemble(HENON, failing, **asked, out=tmp_path / "a.zarr")
        told = gi.solve_ensemble(HENON, failing[60:], observe=["energy"], **asked)
    assert np.array_equal(here.y, there.y, equal_nan=True)
    assert sorted(there.errors) == [0, 66, 69]
    assert sorted(told.errors) == [6, 9]
    assert isinstance(told.errors[6], gi.NonFiniteError)
    assert told.drift["energy"]["class"][1] != ""


class Odd(Executor):
    """Runs two blocks; the third it answers in its own way."""

    def __init__(self, answer) -> None:
        self._left, self._answer = 2, answer

    def submit(self, function, /, *given, **named) -> Future:
        self._left -= 1
        return self._answer() if self._left < 0 else answered(function(*given, **named))


def raising(error: BaseException) -> Future:
    raise error


def answered(result: object = None, error: BaseException | None = None) -> Future:
    future: Future = Future()
    future.set_exception(error) if error else future.set_result(result)
    return future


def cancelled() -> Future:
    future: Future = Future()
    future.cancel()
    future.set_running_or_notify_cancel()
    return future


def shut_down() -> Future:
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    return pool.submit(print)


ANSWERS = {
    "shutdown": shut_down,
    "no room": lambda: raising(OSError("no\nroom")),
    "gone": lambda: raising(SystemExit("gone")),
    "is no Future": lambda: None,
    "is not what": lambda: answered("done"),
    "members give": lambda: answered(gi.solve_ensemble(HENON, STATES[:3], **ASKED).found),
    "BrokenProcessPool": lambda: answered(error=BrokenProcessPool("a process\nhas died")),
    "SystemExit": lambda: answered(error=SystemExit(3)),
    "CancelledError": cancelled,
}


@pytest.mark.parametrize(
    ("text", "stored"),
    [*((text, False) for text in ANSWERS), ("no room", True), ("BrokenProcessPool", True)],
)
def test_whatever_an_executor_does_is_told_in_a_line(text: str, stored: bool, tmp_path) -> None:
    """What was computed before is kept, and a store goes on from there."""
    states = np.vstack([STATES[:75]] * 4)
    asked = {**ASKED, **({"out": tmp_path / "many"} if stored else {})}
    with pytest.raises(gi.EnsembleError, match=text.replace(" room", ".*room")) as told:
        gi.solve_ensemble(HENON, states, executor=Odd(ANSWERS[text]), workers=1, **asked)
    assert "\n" not in str(told.value)
    many, size = told.value.partial, 64 if stored else 80
    assert many.status.tolist() == ["success"] * 2 * size + ["not run"] * (len(states) - 2 * size)
    alone = gi.solve_ensemble(HENON, states, **ASKED)
    assert np.array_equal(many.final[: 2 * size], alone.final[: 2 * size])
    if stored:
        assert np.array_equal(gi.solve_ensemble(HENON, states, **asked).final, alone.final)


def test_ctrl_c_ends_what_threads_of_an_executor_have_begun(ctrl_c) -> None:
    asked = {**ASKED, "t_end": 2e7, "progress": False}
    gi.solve_ensemble(HENON, STATES[:8], **ASKED)  # compiled
    timer = threading.Timer(0.3, ctrl_c)
    timer.start()
    with ThreadPoolExecutor(1) as pool:
        many = gi.solve_ensemble(HENON, STATES[:8], executor=pool, workers=1, **asked)
    assert not (many.status == "success").any()


@pytest.mark.nightly
def test_dask_goes_on_when_a_worker_is_killed() -> None:
    """A scheduler and two workers, processes of this machine; one is killed under way."""
    from distributed import Client, LocalCluster

    settings = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**settings) as cluster, Client(cluster) as client:
        victim = next(iter(cluster.workers.values())).pid
        asked = {"t_end": 15_000.0, "step": 0.01, "method": "rk-4"}
        here = gi.solve_ensemble(HENON, STATES, **asked)
        begin = time.monotonic()
        client.run(lambda: __import__("geomint"))
        threading.Timer(1.5, os.kill, (victim, signal.SIGKILL)).start()
        there = gi.solve_ensemble(HENON, STATES, executor=client.get_executor(), **asked)
        assert time.monotonic() - begin > 1.5, "it was over before the worker was killed"
    assert there.success
    assert np.array_equal(here.y, there.y)
