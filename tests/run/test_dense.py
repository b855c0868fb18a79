"""States between steps: of the method's order, on the manifold, where it was the bits of the run."""

from __future__ import annotations

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import geomint as gi
from tests.families import PROBLEMS, families
from tests.methods.test_orders import COUNTS, IN_FLOAT64, LATE, PLATEAU, cases, slopes

BETWEEN = np.array([0.7313, 1.6171])  # not at steps
MOST = 64.0 * 2.0**-52  # of a constraint, over the size of what it is made of


@pytest.mark.parametrize("name", IN_FLOAT64)
def test_order_between_steps(name: str) -> None:
    """Dense output has the order of the method, neither less nor more.

    Over three runs together: where in their steps the times lie is another thing in each of them.
    """
    method = gi.find_method(name)
    form = method.needs if name != "dormand-prince-5" else "action"
    problem, y0 = cases(form)[0]
    truth = gi.solve(problem, y0, t_end=2.0, step=2.0 / 64, method="gauss-16", t_eval=BETWEEN).y
    counts = LATE.get(name, COUNTS[method.order])
    errors = []
    for n in counts:
        dense = gi.solve(problem, y0, t_end=2.0, step=2.0 / n, method=method, dense=True).sol
        errors.append(float(np.max(np.abs(dense(BETWEEN) - truth))))
    assert PLATEAU < errors[-1] <= errors[0] < 0.1, errors
    (slope,) = slopes((counts[0], counts[-1]), [errors[0], errors[-1]])
    assert slope == pytest.approx(method.order, abs=0.3), (name, errors)


def test_the_truth_is_one() -> None:
    """What judges the others agrees with runs that end at these times."""
    for form in ("field", "action", "hamiltonian", "splitting"):
        problem, y0 = cases(form)[0]
        given = {"step": 2.0 / 64, "method": "gauss-16"}
        truth = gi.solve(problem, y0, t_end=2.0, t_eval=BETWEEN, **given).y
        for t, y in zip(BETWEEN, truth, strict=True):
            assert np.abs(gi.solve(problem, y0, t_end=float(t), **given).y[-1] - y).max() < 1e-13


@families
@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
def test_families(name: str, problem: str, sign: int) -> None:
    """At steps the bits of the run, between them those of `t_eval`, in any order; constraints kept."""
    p, y0 = PROBLEMS[problem]
    end = sign * 1.3
    run = {"t_end": end, "method": name, "step": 0.17}
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
    if "constraints" in gi.find_method(name).keeps or "group orbits" in gi.find_method(name).keeps:
        for constraint in p.constraints.values():
            at_steps = max(abs(gi.value(p, constraint, y)) for y in sol.y)
            between = max(abs(gi.value(p, constraint, y)) for y in asked)
            assert between <= 4.0 * at_steps + MOST


def test_two_times() -> None:
    """Physical times of a problem in τ: where the clock shows them, to rounding."""
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).hamiltonized()
    for seed, method in ((1, "gauss-8"), (2, "rattle-4"), (3, "dop853")):
        y0 = problem.random_state(seed)
        sol = gi.solve(problem, y0, t_end=7.0, method=method, step=0.21, dense=True, save_every=1)
        np.testing.assert_array_equal(sol.sol(sol.t), sol.y)
        np.testing.assert_array_equal(sol.sol(tau=sol.tau), sol.y)
        times = np.linspace(0.0, 7.0, 41)
        states = sol.sol(times)
        asked = gi.solve(problem, y0, t_end=7.0, method=method, step=0.21, t_eval=times)
        np.testing.assert_array_equal(states, asked.y)
        np.testing.assert_allclose(sol.sol(tau=asked.tau), states, rtol=0, atol=3e-15)
        in_tau = gi.solve(
            problem, y0, t_end=7.0, method=method, step=0.21, tau_eval=asked.tau[1:-1]
        )
        np.testing.assert_allclose(in_tau.t, times[1:-1], rtol=0, atol=1e-14)
        np.testing.assert_array_equal(in_tau.tau, asked.tau[1:-1])


def test_what_it_is() -> None:
    """It copies, pickles, compares, says what it is; the plain loop gives the same bits."""
    problem, y0 = PROBLEMS["lotka-volterra"]
    run = {"t_end": 1.0, "step": 0.13, "dense": True}
    sol, plain = gi.solve(problem, y0, **run), gi.solve(problem, y0, **run, compiled=False)
    times = np.linspace(0.0, 1.0, 7)
    for other in (copy.copy(sol), copy.deepcopy(sol), pickle.loads(pickle.dumps(sol)), plain):
        np.testing.assert_array_equal(other.sol(times), sol.sol(times))
    assert pickle.loads(pickle.dumps(sol)) == sol
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(sol.sol))(0.4), sol.sol(0.4))
    assert repr(sol.sol) == "<dense output, t = 0 … 1>"
    assert sol.sol([]).shape == (0, 2)


def test_a_run_that_stops_early() -> None:
    """What was computed is there, and no more."""
    from geomint.problems.testproblems import henon_heiles

    problem = henon_heiles.problem()
    with pytest.raises(gi.StepError) as caught:
        gi.solve(problem, [0.0, 1.2, 1.0, 1.5], t_end=50.0, method="rk-4", step=0.05, dense=True)
    partial = caught.value.partial
    reached = float(partial.t[-1])
    np.testing.assert_array_equal(partial.sol(reached), partial.y[-1])
    with pytest.raises(gi.DomainError, match="times within the run"):
        partial.sol(reached + 1e-12)


def test_errors_name_the_value() -> None:
    """Outside of the run, not a time, both times, none, no dense output, no clock."""
    problem, y0 = PROBLEMS["lotka-volterra"]
    sol = gi.solve(problem, y0, t_end=1.0, dense=True)
    for bad in (1.0 + 1e-12, -1e-300, np.nan, np.inf, "x", [0.1, 2.0], 1j, None):
        with pytest.raises(gi.DomainError):
            sol.sol(bad)
    with pytest.raises(gi.DomainError, match="exactly one"):
        sol.sol(0.1, tau=0.1)
    with pytest.raises(gi.DomainError, match="dense=True"):
        gi.solve(problem, y0, t_end=1.0).sol
    with pytest.raises(gi.DomainError, match="dense"):
        gi.solve(problem, y0, t_end=1.0, dense="yes")
    with pytest.raises(gi.DomainError, match=r"tau_eval = .*t_eval"):
        gi.solve(problem, y0, t_end=1.0, tau_eval=[0.5])


@pytest.mark.parametrize(
    ("name", "problem"), [("gauss-8", "lotka-volterra"), ("rattle-2", "sphere-metric")]
)
def test_threads(name: str, problem: str) -> None:
    """Several threads may ask one dense output at once: compiled code lets all of them run."""
    p, y0 = PROBLEMS[problem]
    sol = gi.solve(p, y0, t_end=40.0, method=name, step=0.1, dense=True).sol
    rng = np.random.default_rng(1)
    times = [40.0 * rng.random(8000) for _ in range(4)]
    known = [sol(t) for t in times]
    for _ in range(3):
        with ThreadPoolExecutor(4) as several:
            found = list(several.map(sol, times))
        for one, other in zip(found, known, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("method", ["gauss-8", "rk-4", "dop853-adaptive", "exact"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_rounding_outside(method: str, sign: float) -> None:
    """Times some roundings before the beginning or after the end are these; others are refused."""
    import chaplygin as ch

    problem = ch.ChaplyginSphere([0.5, 0.7, 0.9], 0.8).reduced()
    y0, begin, end = problem.random_state(1), 0.7, 0.7 + 0.6 * sign
    run = {"t0": begin, "t_end": end, "method": method}
    sol = gi.solve(problem, y0, **run, dense=True)
    for roundings in (1, 2, 4):
        out = [
            begin - sign * roundings * np.spacing(begin),
            end + sign * roundings * np.spacing(end),
        ]
        np.testing.assert_array_equal(sol.sol(out), sol.sol([begin, end]))
        asked = gi.solve(problem, y0, **run, t_eval=out)
        np.testing.assert_array_equal(asked.t, [begin, end])
        np.testing.assert_array_equal(asked.y, sol.sol([begin, end]))
    for bad in (begin - sign * 1e-14, end + sign * 1e-14):
        with pytest.raises(gi.DomainError, match="times within the run"):
            sol.sol(bad)
        with pytest.raises(gi.DomainError, match="times from"):
            gi.solve(problem, y0, **run, t_eval=[bad])


def test_more_times_than_fit() -> None:
    """Refused before room is made for them, also where they need none themselves."""
    problem, y0 = PROBLEMS["lotka-volterra"]
    sol = gi.solve(problem, y0, t_end=1.0, dense=True)
    many = np.broadcast_to(0.5, (10**12,))
    with pytest.raises(gi.DomainError, match="at most"):
        sol.sol(many)
    with pytest.raises(gi.DomainError, match="at most"):
        gi.solve(problem, y0, t_end=1.0, t_eval=many)


@pytest.mark.parametrize("stages", [1, 2, 3, 4, 6, 8])
@pytest.mark.parametrize("step", [0.3, 0.4, 0.5])
def test_times_of_the_clock_keep_the_norm(step: float, stages: int) -> None:
    """Where a state is moved along the step's polynomial, that is not seen: fast and slow stretches."""
    scene = gi.load_scene("hamiltonized-n3")
    method = gi.Gauss(stages)
    step *= 0.1 * (stages + 2)
    run = gi.solve(scene.problem, scene.state, t_end=12.0, step=step, method=method, dense=True)
    gamma = run.sol(np.linspace(0.0, 12.0, 1000))[:, :3]
    assert np.abs((gamma**2).sum(axis=1) - 1.0).max() < 1.4e-15  # it was 1e-14 where that was seen
