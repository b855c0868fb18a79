"""Sections: as many points as asked for, of every motion, those of one run."""

from __future__ import annotations

import copy
import csv
import math
import pickle
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.problems import lotka_volterra
from tests.run.motions import after_a_while, swing

BALL = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0)
SPHERE = BALL.reduced()
LOTKA = lotka_volterra.problem(), lotka_volterra.INITIAL
Z0 = np.array([0.48, 0.6, 0.64, 3.0, -4.0, 1.5])
UP = gi.Event("gamma[2]", "up")


def section_of(points: int = 40, **options: Any) -> gi.Section:
    return gi.poincare_section(SPHERE, Z0, UP, points, **options)


def test_points_are_those_of_one_run() -> None:
    """However the run is cut into pieces: none is lost at the seams, none is told twice."""
    known = gi.solve(SPHERE, Z0, t_end=400.0, step=0.02, events=UP)
    (t,), (y,) = known.t_events, known.y_events
    for points in (1, 12, len(t)):
        found = section_of(points, step=0.02)
        assert found.complete
        assert len(found) == points
        np.testing.assert_allclose(found.tau, t[:points], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.y, y[:points], rtol=0, atol=1e-12)
        assert set(found.directions) == {1.0}
        np.testing.assert_array_equal(found.t, found.tau)


def test_points_at_seams() -> None:
    """Points at steps, where the first piece, of 4096 steps, ends, are points; however many steps."""
    strobe = gi.Event(lambda params, t, y, work: gi.sin(math.pi * t), "up")
    found = gi.poincare_section(swing(), [1.0, 0.0], strobe, 60, method="rk-4", step=2.0**-10)
    np.testing.assert_allclose(found.tau, np.arange(2.0, 122.0, 2.0), rtol=0, atol=1e-12)


def test_several_motions() -> None:
    """Each has its points, in the order of the states."""
    states = [SPHERE.random_state(seed) for seed in range(3)]
    found = gi.poincare_section(SPHERE, states, "gamma[0]", 9, step=0.4)
    np.testing.assert_array_equal(found.motions, np.repeat([0, 1, 2], 9))
    for i, y0 in enumerate(states):
        alone = gi.poincare_section(SPHERE, y0, "gamma[0]", 9, step=0.4)
        np.testing.assert_array_equal(alone.y, found.y[found.motions == i])
        energies = found.values("energy")[found.motions == i]
        np.testing.assert_allclose(energies, gi.value(SPHERE, "energy", y0), rtol=1e-13)


def test_in_tau() -> None:
    """Of a problem in τ; with physical times if they are asked for."""
    problem = BALL.hamiltonized()
    y0 = problem.state(gamma=Z0[:3], p=Z0[3:])
    bare = gi.poincare_section(problem, y0, "gamma[2]", 12, step=0.1)
    both = gi.poincare_section(problem, y0, "gamma[2]", 12, step=0.1, clock=True)
    assert bare.t is None
    np.testing.assert_allclose(both.tau, bare.tau, rtol=0, atol=1e-12)
    reduced = gi.poincare_section(SPHERE, Z0, "gamma[2]", 12, step=0.2)
    np.testing.assert_allclose(both.t, reduced.t, rtol=0, atol=1e-10)


def test_fewer_points_than_asked_for() -> None:
    """At an end; where a motion crosses no more; after Ctrl-C, whenever that comes."""
    ended = section_of(end=20.0, step=0.5)
    assert (ended.complete, ended.status) == (False, "incomplete")
    assert 0 < len(ended) < 40
    assert ended.tau[-1] <= 20.0
    back = section_of(5, end=-math.inf, step=0.5)
    assert back.complete
    assert (np.diff(back.tau) < 0).all()
    run: dict[str, Any] = {"method": "rk-4", "step": 0.5}
    never = gi.poincare_section(swing(), [1.0, 0.0], gi.Event("x", level=2.0), 10, **run)
    assert (len(never), never.status) == (0, "incomplete")
    assert 10**6 <= never.steps < 2 * 10**6
    level, two = gi.Event("x", level=2.0), [[1.0, 0.0], [3.0, 0.0]]
    first_ended = gi.poincare_section(swing(), two, level, 2, end=20.0, **run)
    assert (first_ended.motions.tolist(), first_ended.status) == ([1, 1], "incomplete")
    with after_a_while(lambda *_: signal.raise_signal(signal.SIGINT)):
        stopped = section_of(10**7, step=1e-4)  # the first piece has no point
    assert stopped.status == "interrupted"
    assert len(stopped) < 10**7


def test_a_motion_that_fails() -> None:
    """Its error says which one it was, and has the points of all so far."""
    problem = henon_heiles.problem()
    states = [[0.0, -0.1, 0.3, 0.1], [0.0, 2.0, 1.5, 1.0], [0.0, 0.1, 0.3, 0.1]]
    with pytest.raises(gi.StepError) as caught:
        gi.poincare_section(problem, states, gi.Event("q[0]", "up"), 50, step=0.5)
    assert "in motion 1 of 0 to 2" in caught.value.__notes__[0]
    partial = caught.value.partial
    assert (partial.status, partial.complete) == ("failed", False)
    assert np.count_nonzero(partial.motions == 0) == 50
    assert not (partial.motions == 2).any()


def test_what_it_is(tmp_path: Path) -> None:
    """It says what it is, compares, copies, pickles, draws and writes itself; wrong names are told."""
    found = section_of(30, step=0.5)
    for other in (copy.copy(found), copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert other == found
    assert "30" in repr(found)
    assert found.axes == ("angle of gamma about axis 2 (rad)", "(gamma × p)[2]")
    figure = found.plot("p[1]", "K")
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_xdata(), found.y[:, 4])
    found.save(tmp_path / "points.csv")
    with (tmp_path / "points.csv").open() as stream:
        numbers = np.array(list(csv.reader(stream))[1:], dtype=float)
    np.testing.assert_array_equal(numbers[:, 3:], found.y)
    with pytest.raises(gi.DomainError, match="name ="):
        found.values(["K"])


@pytest.mark.parametrize("method", ["rk-4", "rattle-2", "dop853-adaptive"])
def test_other_methods(method: str) -> None:
    """Pieces of runs at fixed and at chosen steps go on alike; against another family."""
    problem = LOTKA[0] if method != "rattle-2" else BALL.hamiltonized()
    y0 = LOTKA[1] if method != "rattle-2" else problem.random_state(1)
    name = f"{next(iter(problem.slices))}[0]"
    event = gi.Event(name, "up", level=0.0 if method == "rattle-2" else 1.0)
    step = {"rk-4": 0.01, "rattle-2": 0.02}.get(method)
    found = gi.poincare_section(problem, y0, event, 6, method=method, step=step)
    assert found.complete
    assert np.abs(found.y[:, 0] - event.level).max() < 1e-12
    end = {"tau_end" if problem.time == "tau" else "t_end": float(found.tau[-1]) + 0.01}
    truth = gi.solve(problem, y0, **end, method="gauss-8", step=0.05, events={"it": event})
    bound = {"rk-4": 1e-7, "rattle-2": 2e-2}.get(method, 1e-6)
    np.testing.assert_allclose(found.tau, truth.events["it"].tau[:6], rtol=0, atol=bound)


def test_wrong_input() -> None:
    """Typed, before anything is computed."""
    usual = {"problem": SPHERE, "states": Z0, "event": "gamma[0]", "points": 3}
    for name, wrong, said in (
        *(("event", ["gamma[0]", "gamma[1]"], "one event"), ("event", "radius", "a component or")),
        *(("event", "gamma[-1]", r"gamma\[0\] to"), ("event", "energy", "is conserved")),
        ("event", gi.Event("norm", level=1.0), "is conserved"),
        ("event", gi.Event("gamma[0]", terminal=True), "how many points"),
        *(("points", 0, "points"), ("end", math.nan, "end"), ("states", [[1.0, 2.0]], "state")),
        *(("states", 5.0, "state"), ("states", object(), "state")),
        *(("step", -1.0, "step"), ("clock", True, "is physical")),
    ):
        with pytest.raises(gi.DomainError, match=said):
            gi.poincare_section(**{**usual, name: wrong})
