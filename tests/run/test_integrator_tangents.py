"""Directions that an integrator carries: those of `geomint.tangent_flow`, whatever is done to it."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.families import FAMILIES, PROBLEMS

FIXED = [
    pytest.param(name, problem, id=f"{name}-{problem}")
    for name, problem in FAMILIES
    if not gi.find_method(name).adaptive
]
HENON, START = PROBLEMS["henon-heiles"]


@pytest.mark.parametrize(("name", "problem"), FIXED)
def test_as_the_flow(name: str, problem: str) -> None:
    """After steps, a cut step and a turn; the state's bits are those without directions."""
    p, y0 = PROBLEMS[problem]
    y0, end = p.canonical(y0), 6.4 * 0.05
    motion = gi.Integrator(p, y0, name, step=0.05, tangents=2)
    plain = gi.Integrator(p, y0, name, step=0.05)
    for one in (motion, plain):
        one.step(2)
        one.propagate_until(end)
    stop = {"tau_end" if p.time == "tau" else "t_end": end}
    v = np.eye(p.rows)[:, :2]
    flow = gi.tangent_flow(p, y0, **stop, method=name, step=0.05, directions=v)
    np.testing.assert_array_equal(motion.state, plain.state)
    np.testing.assert_allclose(motion.tangents, flow.slopes, rtol=0, atol=1e-14)
    motion.propagate_until(0.0)
    if name.startswith("gauss"):  # symmetric, and nothing is projected
        size = np.abs(flow.slopes).max()
        np.testing.assert_allclose(motion.tangents, v, rtol=0, atol=1e-4 * size)


def test_more_than_eight_and_the_clock() -> None:
    p = gi.load_scene("hamiltonized-n5").problem
    y0 = p.random_state(1)
    motion = gi.Integrator(p, y0, "rk-4", step=0.05, clock=True, tangents=p.rows)
    motion.step(5)
    flow = gi.tangent_flow(p, y0, tau_end=0.25, method="rk-4", step=0.05)
    assert p.rows == 10
    np.testing.assert_allclose(motion.tangents, flow.slopes, rtol=0, atol=1e-14)


def test_copies_and_what_is_written() -> None:
    """A copy goes on by itself; another state, time, step or parameters keep the directions."""
    whole = gi.Integrator(HENON, START, "gauss-4", step=0.1, tangents=4)
    whole.step(6)
    motion = gi.Integrator(HENON, START, "gauss-4", step=0.1, tangents=4)
    motion.step(3)
    for other in (copy.copy(motion), pickle.loads(pickle.dumps(motion))):
        other.step(3)
        np.testing.assert_array_equal(other.tangents, whole.tangents)
    before = motion.tangents
    motion.state = motion.state
    motion.time = 5.0
    motion.h = 0.1
    np.testing.assert_array_equal(motion.tangents, before)
    motion.step(3)
    np.testing.assert_allclose(motion.tangents, whole.tangents, rtol=0, atol=1e-14)
    motion.tangents = np.linalg.qr(motion.tangents)[0][:, :3]
    assert motion.tangents.shape == (4, 3)
    p, y0 = PROBLEMS["neumann"]
    weak = gi.Integrator(p, y0, "verlet-2", step=0.1, tangents=1)
    weak.params = np.append(weak.params[:-1], 2.0 * weak.params[-1])
    weak.step()
    strong = gi.Integrator(weak.problem, y0, "verlet-2", step=0.1, tangents=1)
    strong.step()
    np.testing.assert_array_equal(weak.tangents, strong.tangents)


@pytest.mark.parametrize("name", ["rk-4", "gauss-8", "dop853"])
def test_a_copy_goes_on_to_the_same_bits(name: str) -> None:
    """Carries and stages of derivatives are part of it, of more than eight directions too.

    So are the units of directions, which by then are much longer than they were.
    """
    v = np.random.default_rng(3).normal(size=(4, 11))
    motion = gi.Integrator(HENON, START, name, step=0.1, tangents=v)
    motion.step(1000)
    others = (copy.copy(motion), copy.deepcopy(motion), pickle.loads(pickle.dumps(motion)))
    assert np.abs(motion.tangents).max() > 4.0 * np.abs(v).max()
    for one in others:
        np.testing.assert_array_equal(one.tangents, motion.tangents)
    for one in (motion, *others):
        one.step(150)
        np.testing.assert_array_equal(one.tangents, motion.tangents)


def test_back_to_the_beginning() -> None:
    """The directions are those that it was made with, at another state as well."""
    motion = gi.Integrator(HENON, START, "gauss-4", step=0.1, tangents=4)
    motion.step(5)
    once = motion.tangents
    motion.reset()
    np.testing.assert_array_equal(motion.tangents, np.eye(4))
    motion.step(5)
    np.testing.assert_array_equal(motion.tangents, once)
    motion.tangents = np.ones((4, 1))
    pickle.loads(pickle.dumps(motion)).reset()
    motion.reset(0.5 * np.asarray(START), 3.0)
    np.testing.assert_array_equal(motion.tangents, np.eye(4))


@gi.field
def falling(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = gi.select(y[0] > 0.35, -1.0, gi.sqrt(y[0] - 10.0))


def test_steps_that_fail() -> None:
    """The state and the directions are those before the step that failed."""
    problem = gi.Problem("falling", (("x", 1),), field=falling)
    motion = gi.Integrator(problem, [1.0], "rk-4", step=0.1, tangents=1)
    with pytest.raises(gi.NonFiniteError) as failed:
        motion.step(20)
    assert motion.steps == failed.value.step > 3
    np.testing.assert_allclose(motion.state, 1.0 - 0.1 * motion.steps)
    np.testing.assert_array_equal(motion.tangents, [[1.0]])


def test_wrong_input() -> None:
    given = {"problem": HENON, "state": START, "method": "rk-4", "step": 0.1}
    for tangents in (0, 5, True, 1.5, np.ones(4), np.ones((3, 1)), "x", np.full((4, 1), np.nan)):
        with pytest.raises(gi.DomainError, match="tangents"):
            gi.Integrator(**given, tangents=tangents)
    with pytest.raises(gi.DomainError, match="carries none"):
        gi.Integrator(**given).tangents
    with pytest.raises(gi.MethodError, match="no steps of a given length"):
        gi.Integrator(**{**given, "method": "dop853-adaptive"}, tangents=1)
    with pytest.raises(gi.DomainError, match="compiled"):
        gi.Integrator(**given, tangents=1, compiled=False)


@pytest.mark.parametrize(
    ("name", "problem"), [pair for pair in FAMILIES if gi.find_method(pair[0]).adaptive]
)
def test_steps_of_an_adaptive_run(name: str, problem: str) -> None:
    """The derivative of its steps as they were taken: near that of the motion."""
    p, y0 = PROBLEMS[problem]
    y0 = p.canonical(y0)
    stop = {"tau_end" if p.time == "tau" else "t_end": 1.3}
    found = gi.tangent_flow(p, y0, **stop, method=name)
    fine = gi.tangent_flow(p, y0, **stop, method="gauss-8" if p.field else "rkmk-dop853", step=0.02)
    run = gi.solve(p, y0, **stop, method=name)
    size = np.abs(fine.slopes).max()
    np.testing.assert_allclose(found.y, run.y[-1], rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.slopes, fine.slopes, rtol=0, atol=1e-6 * size)
    assert np.abs(found.slopes - fine.slopes).max() > 1e-15
