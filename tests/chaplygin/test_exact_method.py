"""The exact flow as a method: the states are those of steps, through the same interface."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.chaplygin.exact_systems import ALL, SYSTEMS, each, own_end, span, systems

BALL = ch.ChaplyginSphere([0.8, 1.1, 1.5], 4.0)
SPHERE, REDUCED = BALL.hamiltonized(), BALL.reduced()
Y0 = SPHERE.random_state(1)


@pytest.mark.nightly
@each
def test_states_are_those_of_steps(name: str) -> None:
    """In both times, forwards and backwards (special states by turns), by a fine run of gauss-8."""
    problem, y0 = ALL[name]
    motion = problem.exact(y0)
    ends = [span(problem, y0), -0.4 * span(problem, y0)]
    for end in ends if name in SYSTEMS else ends[list(ALL).index(name) % 2 :][:1]:
        times = end * np.array([0.0, 0.1237, 0.5, 0.5, 1.0])
        own = "tau_eval" if problem.time == "tau" else "t_eval"
        run = {**own_end(problem, end), own: times}
        exact = gi.solve(problem, y0, **run, method="exact")
        fine = gi.solve(problem, y0, **run, method="gauss-8", step=abs(end) / 200)
        tau = float(motion.tau(end)) if problem.time == "t" else end
        known = 100.0 * float(motion.phase_error(tau)) + 1e-12
        scale = np.abs(y0).max()
        np.testing.assert_allclose(exact.y, fine.y, rtol=0, atol=known * scale)
        np.testing.assert_array_equal(exact.tau, times)
        np.testing.assert_allclose(exact.t, fine.t, rtol=0, atol=known * abs(fine.t[-1]))
        assert (exact.success, exact.steps, exact.evaluations) == (True, 0, 0)
        if problem.time == "tau":
            by_clock = gi.solve(problem, y0, t_end=exact.t[-1], t_eval=exact.t, method="exact")
            np.testing.assert_array_equal(by_clock.t, exact.t)
            atol = 1e-12 * max(1.0, np.abs(exact.tau).max())
            np.testing.assert_allclose(by_clock.tau, exact.tau, rtol=0, atol=atol)
            np.testing.assert_allclose(by_clock.y, exact.y, rtol=0, atol=known * scale)


@systems(6)
def test_dense_output(name: str) -> None:
    """The bits of wanted states, in any order and shape, in both times; at the end that of the run."""
    problem, y0 = ALL[name]
    end = span(problem, y0)
    sol = gi.solve(problem, y0, **own_end(problem, end), method="exact", dense=True)
    times = end * np.sort(np.random.default_rng(3).random(20))
    own = "tau_eval" if problem.time == "tau" else "t_eval"
    asked = gi.solve(problem, y0, **own_end(problem, end), **{own: times}, method="exact")
    in_own = {"tau": times} if problem.time == "tau" else {"t": times}
    np.testing.assert_array_equal(sol.sol(**in_own), asked.y)
    order = np.random.default_rng(4).permutation(20)
    shuffled = {key: value[order].reshape(4, 5) for key, value in in_own.items()}
    np.testing.assert_array_equal(sol.sol(**shuffled), asked.y[order].reshape(4, 5, -1))
    np.testing.assert_array_equal(sol.sol(tau=end), sol.y[-1])
    np.testing.assert_allclose(sol.sol(sol.t[-1]), sol.y[-1], rtol=0, atol=1e-11)
    scale = np.abs(y0).max()
    np.testing.assert_allclose(sol.sol(asked.t), asked.y, rtol=0, atol=1e-11 * scale)
    assert sol.sol([]).shape == (0, problem.rows)


def test_physical_time_begins_where_it_is_said_to() -> None:
    """At t0; of a problem in τ, which begins at τ = 0, too."""
    for problem in (SPHERE, REDUCED):
        y0 = problem.random_state(1)
        plain = gi.solve(problem, y0, t_end=7.0, t_eval=[1.0, 7.0], method="exact", dense=True)
        late = gi.solve(
            problem, y0, t0=3.0, t_end=10.0, t_eval=[4.0, 10.0], method="exact", dense=True
        )
        np.testing.assert_allclose(late.y, plain.y, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(late.t, plain.t + 3.0)
        np.testing.assert_allclose(late.sol(5.5), plain.sol(2.5), rtol=0, atol=1e-14)


@pytest.mark.parametrize("problem", [SPHERE, REDUCED], ids=["in tau", "in t"])
def test_going_on_is_one_run(problem: gi.Problem, tmp_path: Path) -> None:
    """To the bits of it, from a file too: the motion is begun where it was, not where it had got to."""
    y0 = problem.random_state(1)
    looked = {"events": ["gamma[2]", gi.Event("gamma[0]", "up")], "dense": True}
    whole = gi.solve(problem, y0, t_end=90.0, method="exact", **looked)
    first = gi.solve(problem, y0, t_end=31.0, method="exact", **looked)
    first.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc", problem)
    assert loaded == first
    for so_far in (first, loaded):
        second = gi.solve(so_far, t_end=40.0, **looked)
        third = gi.solve(second, t_end=90.0, t_eval=[50.0, 90.0], **looked)
        np.testing.assert_array_equal(third.y[-1], whole.y[-1])
        np.testing.assert_array_equal(third.sol([40.0, 77.0]), whole.sol([40.0, 77.0]))
        with pytest.raises(gi.DomainError, match="times within the run, 40 … 90"):
            third.sol(39.0)
        for name in whole.events:
            parts = [run.events[name] for run in (so_far, second, third)]
            t = np.concatenate([part.t for part in parts])
            np.testing.assert_allclose(t, whole.events[name].t, rtol=0, atol=1e-12)
    for given in ({"step": 0.1}, {"method": "exact"}, {"y0": y0}):
        with pytest.raises(gi.DomainError, match="goes on as it was"):
            gi.solve(first, t_end=50.0, **given)
    with pytest.raises(gi.DomainError, match="a time beyond 31"):
        gi.solve(first, t_end=30.0)


def test_what_it_is(tmp_path: Path) -> None:
    """It says what it is, compares, copies, pickles, is written and read."""
    sol = gi.solve(
        SPHERE, Y0, t_end=20.0, method="exact", dense=True, events="gamma[2]", observe=["energy"]
    )
    sol.save(tmp_path / "run.nc")
    others = (copy.copy(sol), copy.deepcopy(sol), pickle.loads(pickle.dumps(sol)))
    for other in (*others, gi.load(tmp_path / "run.nc", SPHERE)):
        assert other == sol
        np.testing.assert_array_equal(other.sol(7.0), sol.sol(7.0))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(sol.sol))(7.0), sol.sol(7.0))
    assert "by exact flow" in repr(sol)
    assert "steps none" in repr(sol)
    assert repr(sol.sol) == f"<dense output, tau = 0 … {sol.tau[-1]:.9g}>"
    told = gi.load(tmp_path / "run.nc").provenance
    assert (told["method"], told["route"], told["steps"]) == ("exact", "exact flow", 0)
    assert sol.method == gi.Exact() == pickle.loads(pickle.dumps(gi.Exact()))
    assert repr(gi.Exact()) == "Exact()"
    assert gi.solve(SPHERE, Y0, t_end=20.0, method=gi.Exact()).y.tobytes() == sol.y.tobytes()
    plain = gi.solve(
        SPHERE,
        Y0,
        t_end=20.0,
        method="exact",
        events="gamma[2]",
        observe=["energy"],
        compiled=False,
    )
    assert plain.events == sol.events
    assert plain.drift["energy"].max_abs_error == sol.drift["energy"].max_abs_error


def test_quantities_at_the_times_asked_for() -> None:
    """As after steps: from where the run begins, at every time or every third, and at the end."""

    class Seen(gi.Watcher):
        """Remembers what it is shown."""

        def begin(self, run: Any) -> float:
            self.shown, self.step = [run.time], run.step
            shown.append(self.shown)
            return 0.0

        def values(self, times: Any, states: Any, lengths: Any) -> Any:
            self.shown += list(times)
            begun = np.array([self.step(y, t, 0.5) for t, y in zip(times, states, strict=True)])
            after.append((times, begun))
            return times

    shown: list[Any] = []
    after: list[Any] = []
    times = np.linspace(1.0, 10.0, 10)
    watched = {"K": {}, "energy": {}, "seen": Seen()}
    sol = gi.solve(
        REDUCED, Y0, t_end=12.0, t_eval=times, method="exact", observe=watched, observe_every=3
    )
    assert shown == [[0.0, 3.0, 6.0, 9.0, 12.0]]
    for at, states in after:
        known = REDUCED.exact(REDUCED.canonical(Y0))(at + 0.5)
        np.testing.assert_allclose(states, known, rtol=0, atol=1e-12)
    assert sol.drift["K"].max_abs_error < 1e-13
    assert sol.drift["energy"].max_abs_error < 1e-13
    values = [gi.value(REDUCED, "K", y) for y in sol.y]
    assert sol.drift["K"].initial == pytest.approx(values[0], rel=1e-14)
    with pytest.raises(gi.DomainError, match="takes no steps that 'measure' could watch"):
        gi.solve(SPHERE, Y0, t_end=1.0, method="exact", observe="all")


def test_times_after_the_end_are_told() -> None:
    with pytest.warns(gi.GeomintWarning, match="before 1 of the times in t_eval") as told:
        sol = gi.solve(SPHERE, Y0, tau_end=1.0, t_eval=[1.0, 9.0], method="exact")
    np.testing.assert_array_equal(sol.t, [1.0])
    assert told[0].filename == __file__


SEVEN = ch.ChaplyginSphere([0.61, 0.78, 0.93, 1.07, 1.22, 1.41, 1.58], 4.0).hamiltonized()


@pytest.mark.parametrize(
    ("problem", "clock"), [(SPHERE, False), pytest.param(SEVEN, None, marks=pytest.mark.nightly)]
)
def test_without_physical_time(problem: gi.Problem, clock: bool | None) -> None:
    """Where it is not wanted, or its series is refused: τ alone, and typed errors for t."""
    y0 = problem.random_state(1)
    run = {"method": "exact", "dense": True, "clock": clock, "events": "gamma[2]"}
    sol = gi.solve(problem, y0, tau_end=5.0, **run)
    assert sol.events["gamma[2]"].t is None
    for what in (lambda: sol.t, lambda: sol.sol(1.0)):
        with pytest.raises(gi.DomainError, match="clock=True"):
            what()
    assert sol.sol(tau=1.0).shape == (problem.rows,)
    if clock is None:
        with pytest.raises(gi.DomainError, match="Fourier coefficients"):
            gi.solve(problem, y0, t_end=5.0, method="exact")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"step": 0.1}, "step = 0.1: expected None: the exact flow takes no steps"),
        ({"save_every": 2}, "times as t_eval: the exact flow takes no steps"),
        ({"t_end": 1e17}, "the phase is uncertain by more than a radian"),
        ({"t_end": None, "tau_end": 1e17}, "the phase is uncertain by more than a radian"),
        ({"clock": False}, "t_end and t_eval are physical time"),
        ({"t_eval": [0.5, 0.2]}, "in the order of the run"),
        ({"t_eval": [0.5], "tau_eval": [0.1]}, "not both"),
        ({"observe_every": 2}, "something to observe"),
        ({"y0": [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]}, "at rest"),
        ({"y0": [1.0, 0.0]}, "state"),
    ],
)
def test_wrong_input(given: dict[str, Any], said: str) -> None:
    """Typed, before anything is looked for."""
    usual = {"problem": SPHERE, "y0": Y0, "t_end": 1.0, "method": "exact", "events": "gamma[0]"}
    with pytest.raises(gi.DomainError, match=said):
        gi.solve(**{**usual, **given})


def test_where_there_is_none() -> None:
    """What has no exact motion says what would fit; what takes steps says that it does."""
    problem = henon_heiles.problem()
    for method in ("exact", gi.Exact()):
        with pytest.raises(gi.FormError, match=r"needs an exact motion .* gauss-8"):
            gi.solve(problem, henon_heiles.INITIAL, t_end=1.0, method=method)
        with pytest.raises(gi.FormError, match=r"needs an exact motion .* gauss-8"):
            gi.poincare_section(problem, henon_heiles.INITIAL, "q[0]", method=method)
        with pytest.raises(gi.MethodError, match=r"takes no steps.* geomint\.solve"):
            gi.Integrator(SPHERE, Y0, method)
        with pytest.raises(gi.MethodError, match="takes no steps"):
            gi.find_method(method)
    with pytest.raises(gi.SceneError, match=r"exact = true in \[integrate\]"):
        gi.load_scene("sphere-n3").changed(integrate={"method": "exact"})
    with pytest.raises(gi.MethodError, match="Did you mean 'exact'"):
        gi.solve(SPHERE, Y0, t_end=1.0, method="exat")
    for make in (lambda: gi.Compose(gi.Exact(), 4), lambda: gi.Adaptive(gi.Exact())):
        with pytest.raises(gi.MethodError, match="'exact'"):
            make()
    separatrix = np.array([1.0, 0.0, 1e-4, 0.0, 1e-4, 0.2])
    separatrix[3:] -= separatrix[:3] @ separatrix[3:] * separatrix[:3]
    with pytest.warns(gi.GeomintWarning), pytest.raises(gi.DomainError, match="condition"):
        gi.solve(SPHERE, separatrix, t_end=1.0, method="exact")


class Turning:
    """The motion of (x, y) in a circle, as a user may write it: no frequencies, nothing compiled."""

    def __init__(self, y0: np.ndarray, wrong: Any = None, ends: list[float] | None = None) -> None:
        self._y0, self._wrong, self._ends = y0, wrong, ends

    def __call__(self, t: Any) -> Any:
        if self._wrong is not None:
            return self._wrong
        (x, y), t = self._y0, np.asarray(t)
        if self._ends and self._ends[0] < np.max(t) < 1e5:  # not the end, which is looked at first
            self._ends.pop()
            signal.raise_signal(signal.SIGINT)
        return np.stack([x * np.cos(t) - y * np.sin(t), x * np.sin(t) + y * np.cos(t)], axis=-1)


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Turn with angular velocity 1."""
    out[0] = -y[1]
    out[1] = y[0]


CIRCLE = gi.Problem("circle", (("x", 1), ("y", 1)), field=turning, make_exact=Turning)


def test_a_motion_of_ones_own() -> None:
    """In physical time a problem needs states at times alone; what are no states is refused."""
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=20.0, method="exact", events="x", dense=True)
    np.testing.assert_allclose(sol.t_events[0], np.pi * (0.5 + np.arange(6)), rtol=0, atol=1e-14)
    np.testing.assert_allclose(sol.sol(3.0), [np.cos(3.0), np.sin(3.0)], rtol=0, atol=1e-15)
    for wrong in (np.array([1.0, np.nan]), np.zeros(3), "x"):
        bad = dataclasses.replace(CIRCLE, make_exact=lambda y, w=wrong: Turning(y, w))
        with pytest.raises(gi.DeclarationError, match="make_exact"):
            gi.solve(bad, [1.0, 0.0], t_end=2.0, method="exact")


def test_ctrl_c() -> None:
    """What is known is there, and the run can go on; a section has the points so far."""
    ends = [30.0]
    stopped = dataclasses.replace(CIRCLE, make_exact=lambda y: Turning(y, ends=ends))
    sol = gi.solve(stopped, [1.0, 0.0], t_end=1e6, method="exact", events="x")
    assert sol.status == "interrupted"
    assert 30.0 < sol.t[-1] < 1e5
    on = gi.solve(sol, t_end=float(sol.t[-1]) + 30.0, events="x")
    found = np.append(sol.t_events[0], on.t_events[0])
    known = np.pi * (0.5 + np.arange(len(found)))
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-12 * known[-1])
    assert known[-1] < on.t[-1] < known[-1] + np.pi
    ends.append(30.0)
    section = gi.poincare_section(stopped, [1.0, 0.0], "x", 10**5, method="exact")
    assert not section.complete
    assert len(section) > 5
