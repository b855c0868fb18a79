"""Sections: as many points as asked for, of every motion, those of one run."""

from __future__ import annotations

import copy
import csv
import dataclasses
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run import poincare as module
from tests.problems import lotka_volterra

BALL = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0)
SPHERE = BALL.reduced()
Z0 = np.array([0.48, 0.6, 0.64, 3.0, -4.0, 1.5])


def section_of(points: int = 40, **options: Any) -> gi.Section:
    return gi.poincare_section(SPHERE, Z0, gi.Event("gamma[2]", "up"), points, **options)


def test_points_are_those_of_one_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """However the run is cut into pieces: none is lost at the seams, none is told twice."""
    known = gi.solve(SPHERE, Z0, t_end=400.0, step=0.5, events=gi.Event("gamma[2]", "up"))
    (t,), (y,) = known.t_events, known.y_events
    for piece in (1, 7, 64, 4096):
        monkeypatch.setattr(module, "PIECE", piece)
        found = section_of(step=0.5)
        assert found.complete
        assert len(found) == 40
        np.testing.assert_allclose(found.tau, t[:40], rtol=0, atol=1e-12)
        np.testing.assert_allclose(found.y, y[:40], rtol=0, atol=1e-12)
        assert set(found.directions) == {1.0}
        np.testing.assert_array_equal(found.t, found.tau)


def test_points_at_seams(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points at steps, where pieces may end, are points."""

    @gi.event(direction="up")
    def strobe(params: Any, t: Any, y: Any, work: Any) -> Any:
        return gi.sin(math.pi * t)

    problem = lotka_volterra.problem()
    for piece in (1, 2, 3, 4096):
        monkeypatch.setattr(module, "PIECE", piece)
        found = gi.poincare_section(problem, lotka_volterra.INITIAL, strobe, 9, step=0.25)
        np.testing.assert_allclose(found.tau, np.arange(2.0, 20.0, 2.0), rtol=0, atol=1e-13)


def test_several_motions() -> None:
    """Each has its points, in the order of the states."""
    states = [SPHERE.random_state(seed) for seed in range(3)]
    found = gi.poincare_section(SPHERE, states, "gamma[0]", 9, step=0.4)
    np.testing.assert_array_equal(found.motions, np.repeat([0, 1, 2], 9))
    for i, y0 in enumerate(states):
        alone = gi.poincare_section(SPHERE, y0, "gamma[0]", 9, step=0.4)
        np.testing.assert_array_equal(alone.y, found.y[found.motions == i])
    for energy in (found.values("energy"),):
        for i, y0 in enumerate(states):
            of_motion = energy[found.motions == i]
            np.testing.assert_allclose(of_motion, gi.value(SPHERE, "energy", y0), rtol=1e-13)


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


def test_fewer_points_than_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """At an end; where a motion crosses no more; after Ctrl-C."""
    ended = section_of(end=20.0, step=0.5)
    assert not ended.complete
    assert 0 < len(ended) < 40
    assert ended.tau[-1] <= 20.0
    back = section_of(5, end=-math.inf, step=0.5)
    assert back.complete
    assert (np.diff(back.tau) < 0).all()
    monkeypatch.setattr(module, "PATIENCE", 5000)
    never = gi.poincare_section(SPHERE, Z0, gi.Event("gamma[2]", level=2.0), 10, step=0.5)
    assert (len(never), never.complete) == (0, False)


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


@pytest.mark.parametrize("inside", [True, False])
def test_interrupted(inside: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C within a piece, which `solve` returns from, and between pieces."""
    original, calls = module.solve, []

    def interrupted(*args: Any, **given: Any) -> Any:
        calls.append(1)
        if len(calls) == 3 and not inside:
            raise KeyboardInterrupt
        found = original(*args, **given)
        return dataclasses.replace(found, status="interrupted") if len(calls) == 3 else found

    monkeypatch.setattr(module, "FIRST_PIECE", 64)
    monkeypatch.setattr(module, "PIECE", 64)
    monkeypatch.setattr(module, "solve", interrupted)
    stopped = section_of(step=0.5)
    assert not stopped.complete
    assert 0 < len(stopped) < 40
    assert len(calls) == 3


def test_what_it_is(tmp_path: Path) -> None:
    """It says what it is, compares, copies, pickles, draws and writes itself."""
    found = section_of(30, step=0.5)
    for other in (copy.copy(found), copy.deepcopy(found), pickle.loads(pickle.dumps(found))):
        assert other == found
    assert "30" in repr(found)
    assert found.axes == ("angle of gamma about axis 2 (rad)", "(gamma × p)[2]")
    figure = found.plot()
    (panel,) = figure.axes
    assert (panel.get_xlabel(), panel.get_ylabel()) == found.axes
    figure = found.plot("p[1]", "K")
    np.testing.assert_array_equal(figure.axes[0].lines[0].get_xdata(), found.y[:, 4])
    found.save(tmp_path / "points.csv")
    with (tmp_path / "points.csv").open() as stream:
        numbers = np.array(list(csv.reader(stream))[1:], dtype=float)
    np.testing.assert_array_equal(numbers[:, 3:], found.y)


@pytest.mark.parametrize("method", ["rk-4", "rattle-2", "dop853-adaptive"])
def test_other_methods(method: str) -> None:
    """Pieces of runs at fixed and at chosen steps go on alike."""
    problem = henon_heiles.problem() if method != "rattle-2" else BALL.hamiltonized()
    y0 = henon_heiles.INITIAL if method != "rattle-2" else problem.random_state(1)
    name = next(iter(problem.slices)) + "[1]"
    step = None if "adaptive" in method else 0.05
    found = gi.poincare_section(problem, y0, gi.Event(name, "up"), 12, method=method, step=step)
    assert found.complete
    assert len(found) == 12
    assert (np.diff(found.tau) > 1e-3).all()
    row = problem.slices[name[:-3]].start + 1
    assert np.abs(found.y[:, row]).max() < 1e-12


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"event": ["gamma[0]", "gamma[1]"]}, "one event"),
        ({"event": gi.Event("gamma[0]", terminal=True)}, "how many points"),
        ({"points": 0}, "points"),
        ({"end": math.nan}, "end"),
        ({"end": "x"}, "end"),
        ({"states": [[1.0, 2.0]]}, "state"),
        ({"event": "radius"}, "a component or a quantity"),
        ({"event": "gamma[-1]"}, r"gamma\[0\] to gamma\[2\]"),
        ({"event": "energy"}, "this is conserved"),
        ({"event": gi.Event("norm", level=1.0)}, "this is conserved"),
        ({"step": "x"}, "step"),
        ({"step": math.nan}, "step"),
        ({"step": -1.0}, "step"),
        ({"clock": 1}, "clock"),
        ({"clock": True}, "is physical"),
        ({"progress": "x"}, "progress"),
        ({"problem": None}, "a geomint.Problem"),
    ],
)
def test_wrong_input(given: dict[str, Any], said: str) -> None:
    """Typed, before anything is computed."""
    usual = {"problem": SPHERE, "states": Z0, "event": "gamma[0]", "points": 3}
    with pytest.raises(gi.DomainError, match=said):
        gi.poincare_section(**{**usual, **given})


def test_wrong_names(tmp_path: Path) -> None:
    """Typed, of what it shows and where it is written."""
    found = section_of(3, step=0.5)
    for wrong in (3, None, b"K", ["K"]):
        with pytest.raises(gi.DomainError, match="name ="):
            found.values(wrong)  # type: ignore[arg-type]
    for path in (3, None):
        with pytest.raises(gi.DomainError, match="path"):
            found.save(path)  # type: ignore[arg-type]
    with pytest.raises(gi.OutputError):
        found.save(tmp_path)


def test_numbers_are_right() -> None:
    """Against a run of another family at a fine step."""
    problem = lotka_volterra.problem()
    name = next(iter(problem.slices))
    event = gi.Event(f"{name}[0]", "up", level=1.0)
    found = gi.poincare_section(problem, lotka_volterra.INITIAL, event, 6, step=0.05)
    truth = gi.solve(
        problem, lotka_volterra.INITIAL, t_end=float(found.tau[-1]) + 0.01, method="dop853",
        step=0.005, events=event,
    )  # fmt: skip
    np.testing.assert_allclose(found.tau, truth.t_events[0][:6], rtol=0, atol=1e-10)
