"""What comes out of a run is an outcome, whatever it is; Ctrl-C ends all that are left."""

from functools import partial

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import pulsating_body
from geomint.run.many import attempt, run_many

SOLVE = partial(
    gi.solve, pulsating_body.problem(), pulsating_body.INITIAL, method="rk-4", compiled=False
)


def failing(error):
    def run(progress):
        raise error

    return run


def test_a_run_that_is_repeated():
    told = []

    def run(progress):
        told.append(progress)
        solution = SOLVE(t_end=0.5, step=0.125, progress=progress)
        solution.run_seconds, solution.compile_seconds = float(len(told)), 1.0
        return solution

    outcome = attempt(run, False, repeats=3)
    assert told == [False] * 3
    assert (outcome.status, outcome.repeats, outcome.error) == ("success", 3, None)
    assert (outcome.seconds, outcome.compile_seconds) == (2.0, 3.0)
    assert outcome.result().steps == 4
    told.clear()
    assert attempt(run, None, repeats=9, enough=2.5).repeats == 2  # 1 and 2 seconds
    assert told == [None, None]


def test_errors_are_outcomes():
    method = gi.Gauss(8, iteration="fixed-point")
    implicit = partial(SOLVE, method=method, t_end=80.0, step=40.0)
    outcome = attempt(implicit)
    assert isinstance(outcome.error, gi.ConvergenceError)
    assert outcome.solution is outcome.error.partial
    assert (outcome.status, outcome.message) == ("failed", outcome.solution.message)
    with pytest.raises(gi.ConvergenceError):
        outcome.result()
    outcome = attempt(partial(SOLVE, t_end=np.nan))
    assert (outcome.status, outcome.solution) == ("failed", None)
    assert outcome.message.startswith("DomainError: ")
    with pytest.raises(ZeroDivisionError):  # no typed error: a defect
        attempt(failing(ZeroDivisionError()))


def test_ctrl_c_is_an_outcome():
    outcome = attempt(failing(KeyboardInterrupt()))
    assert (outcome.status, outcome.solution, outcome.error) == ("interrupted", None, None)
    with pytest.raises(KeyboardInterrupt):
        outcome.result()


def test_many_in_turn():
    done, heard = [], []

    def runs():
        for i in range(3):
            done.append((i, list(heard)))  # each when all before have been heard of
            yield i

    assert run_many(runs(), heard.append)
    assert heard == [0, 1, 2]
    assert done == [(0, []), (1, [0]), (2, [0, 1])]


def test_ctrl_c_ends_all_that_are_left():
    heard = []

    def interrupted():
        yield 0
        raise KeyboardInterrupt

    assert not run_many(interrupted(), heard.append)
    assert heard == [0]

    def listener(i):
        heard.append(i)
        if i == 1:
            raise KeyboardInterrupt

    assert not run_many(range(3), listener)
    assert heard == [0, 0, 1]
