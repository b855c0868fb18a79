"""States between steps: real steps of the method, on the manifold, where it was the bits of the run."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.families import FAMILIES, KINDS, PROBLEMS, pairs
from tests.run.motions import TIMED, solve

MOST = 64.0 * 2.0**-52  # of a constraint, over the size of what it is made of
ADAPTIVE, EXACT = "dormand-prince-5-adaptive", pytest.param("exact", marks=pytest.mark.nightly)
LOTKA, START = PROBLEMS["lotka-volterra"]


@pairs(FAMILIES, KINDS)
@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
def test_families(name: str, problem: str, sign: int) -> None:
    """At steps the bits of the run, between them a step from the last of them, in any order."""
    p, y0 = PROBLEMS[problem]
    end, method = sign * 1.3, gi.find_method(name)
    run = {"t_end": end, "method": method, "step": 0.17}
    sol = gi.solve(p, y0, **run, save_every=1, dense=True)
    np.testing.assert_array_equal(sol.sol(sol.t), sol.y)
    assert gi.solve(p, y0, **run, save_every=1).y.tobytes() == sol.y.tobytes()
    rng = np.random.default_rng(3)
    times = end * np.sort(rng.random(20))
    asked = gi.solve(p, y0, **run, t_eval=times).y
    np.testing.assert_array_equal(sol.sol(times), asked)
    shuffled = rng.permutation(20)
    np.testing.assert_array_equal(sol.sol(times[shuffled]), asked[shuffled])
    np.testing.assert_array_equal(sol.sol(times.reshape(4, 5)), asked.reshape(4, 5, -1))
    np.testing.assert_array_equal(sol.sol(times[3]), asked[3])
    base = method.base if isinstance(method, gi.Adaptive) else method
    for t, y in zip(times[::3], asked[::3], strict=True):
        node = np.searchsorted(sign * sol.t, sign * t) - 1
        motion = gi.Integrator(p, sol.y[node], base, step=abs(t - sol.t[node]), time=sol.t[node])
        motion.propagate_until(t)
        assert motion.steps == 1
        np.testing.assert_allclose(y, motion.state, rtol=0, atol=4e-15)
    if {"constraints", "group orbits"} & set(method.keeps):
        for constraint in p.constraints.values():
            at_steps = max(abs(gi.value(p, constraint, y)) for y in sol.y)
            between = max(abs(gi.value(p, constraint, y)) for y in asked)
            assert between <= 4.0 * at_steps + MOST


@pytest.mark.parametrize("method", ["gauss-3", "rk-4"])
def test_two_times(method: str) -> None:
    """Physical times of a problem in τ: where the clock shows them, to rounding."""
    run, times = {"t_end": 1.5, "method": method, "step": 0.21}, np.linspace(0.0, 1.5, 8)
    sol = solve(TIMED, START, **run, dense=True, save_every=1)
    np.testing.assert_array_equal(sol.sol(sol.t), sol.y)
    np.testing.assert_array_equal(sol.sol(tau=sol.tau), sol.y)
    states, asked = sol.sol(times), solve(TIMED, START, **run, t_eval=times)
    np.testing.assert_array_equal(states, asked.y)
    np.testing.assert_allclose(sol.sol(tau=asked.tau), states, rtol=0, atol=3e-15)
    in_tau = solve(TIMED, START, **run, tau_eval=asked.tau[1:-1])
    np.testing.assert_allclose(in_tau.t, times[1:-1], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(in_tau.tau, asked.tau[1:-1])


def test_what_it_is() -> None:
    """It copies, pickles, compares, says what it is; the plain loop gives the same bits."""
    run = {"t_end": 1.0, "method": "gauss-3", "step": 0.13, "dense": True}
    sol, plain = gi.solve(LOTKA, START, **run), gi.solve(LOTKA, START, **run, compiled=False)
    times = np.linspace(0.0, 1.0, 7)
    for other in (copy.copy(sol), copy.deepcopy(sol), pickle.loads(pickle.dumps(sol)), plain):
        np.testing.assert_array_equal(other.sol(times), sol.sol(times))
    assert pickle.loads(pickle.dumps(sol)) == sol
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(sol.sol))(0.4), sol.sol(0.4))
    assert repr(sol.sol) == "<dense output, t = 0 … 1>"
    assert sol.sol([]).shape == (0, 2)


def test_a_run_that_stops_early() -> None:
    """What was computed is there, and no more."""
    run = {"t_end": 50.0, "method": "rk-4", "step": 0.05, "dense": True}
    with pytest.raises(gi.StepError) as caught:
        gi.solve(henon_heiles.problem(), [0.0, 1.2, 1.0, 1.5], **run)
    partial = caught.value.partial
    reached = float(partial.t[-1])
    np.testing.assert_array_equal(partial.sol(reached), partial.y[-1])
    with pytest.raises(gi.DomainError, match="times within the run"):
        partial.sol(reached + 1e-12)


def test_errors_name_the_value() -> None:
    """Outside of the run, not a time, both times, none, too many, no dense output, no clock."""
    run = {"t_end": 1.0, "method": "gauss-3", "step": 0.13}
    sol = gi.solve(LOTKA, START, **run, dense=True)
    for bad in (1.0 + 1e-12, -1e-300, np.nan, np.inf, "x", [0.1, 2.0], 1j, None):
        with pytest.raises(gi.DomainError):
            sol.sol(bad)
    many = np.broadcast_to(0.5, (10**12,))  # refused before room is made for them
    for times, said in (((0.1, 0.1), "exactly one"), ((many, None), "at most")):
        with pytest.raises(gi.DomainError, match=said):
            sol.sol(times[0], tau=times[1])
    with pytest.raises(gi.DomainError, match="dense=True"):
        _ = gi.solve(LOTKA, START, **run).sol
    with pytest.raises(gi.DomainError, match="at most"):
        gi.solve(LOTKA, START, **run, t_eval=many)


def test_threads() -> None:
    """Several threads may ask one dense output at once: compiled code lets all of them run."""
    p, y0 = PROBLEMS["sphere-metric"]
    sol = gi.solve(p, y0, t_end=40.0, method="rattle-2", step=0.1, dense=True).sol
    rng = np.random.default_rng(1)
    times = [40.0 * rng.random(3000) for _ in range(4)]
    known = [sol(t) for t in times]
    for _ in range(3):
        with ThreadPoolExecutor(4) as several:
            np.testing.assert_array_equal(list(several.map(sol, times)), known)


@pytest.mark.parametrize("method", ["gauss-3", "rk-4", ADAPTIVE, EXACT])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rounding_outside(method: str, sign: float) -> None:
    """Times some roundings before the beginning or after the end are these; others are refused."""
    problem, y0 = LOTKA, START
    if method == "exact":
        problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).reduced()
        y0 = problem.random_state(1)
    begin, end = 0.7, 0.7 + 0.6 * sign
    run = {"t0": begin, "t_end": end, "method": method}
    sol = gi.solve(problem, y0, **run, dense=True)
    for roundings in (1, 2, 4):
        off = sign * roundings * np.spacing([begin, end])
        out = [begin - off[0], end + off[1]]
        np.testing.assert_array_equal(sol.sol(out), sol.sol([begin, end]))
        asked = gi.solve(problem, y0, **run, t_eval=out)
        np.testing.assert_array_equal(asked.t, [begin, end])
        np.testing.assert_array_equal(asked.y, sol.sol([begin, end]))
    for bad in (begin - sign * 1e-14, end + sign * 1e-14):
        with pytest.raises(gi.DomainError, match="times within the run"):
            sol.sol(bad)
        with pytest.raises(gi.DomainError, match="times from"):
            gi.solve(problem, y0, **run, t_eval=[bad])


@pytest.mark.parametrize("stages", [1, 2, 3, 4, 6, 8])
def test_times_of_the_clock_keep_the_norm(stages: int) -> None:
    """Where a state is moved along the step's polynomial, that is not seen: fast and slow stretches."""
    scene, method = gi.load_scene("hamiltonized-n3"), gi.Gauss(stages)
    for step in (0.3, 0.4, 0.5):
        run = {"step": 0.1 * (stages + 2) * step, "method": method, "dense": True}
        sol = gi.solve(scene.problem, scene.state, t_end=12.0, **run).sol
        gamma = sol(np.linspace(0.0, 12.0, 1000))[:, :3]
        off = np.abs((gamma**2).sum(axis=1) - 1.0).max()
        assert off < 1.4e-15  # it was 1e-14 where that was seen
