"""The derivative of every method's map, against differences of the map; what integrators carry."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.run.carried_directions import CarriedDirections
from tests.families import FAMILIES, PROBLEMS, pairs
from tests.run.motions import first, swing

STEP, END = 0.05, 3.4 * 0.05  # the last step is a cut one
FIXED = [pair for pair in FAMILIES if not gi.find_method(pair[0]).adaptive]
SYSTEMS = [("verlet-2", "hamiltonized-n3"), ("cf-4", "ball-3d"), ("gauss-2", "control-physical-n4")]
# Derivatives are compiled for every pair anew: the fast row has one of each kind of equations.
LOTKA, POLE = ("rk-4", "lotka-volterra"), ("gauss-8", "neumann-at-rest")
FAST = [LOTKA, POLE, ("cf-4", "pulsating-body"), ("rattle-2", "sphere-metric")]
HENON, START = PROBLEMS["henon-heiles"]
J = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.eye(2))
# What holds states to their manifold, and parameters to what they were made of.
BOUNDS = dict.fromkeys(("space", "admit", "make_state", "make_random", "make_exact"))


def begun(problem: str) -> tuple[gi.Problem, np.ndarray, dict[str, Any]]:
    """Return a problem without bounds, a state, and the options of a short run."""
    scene = None if problem in PROBLEMS else gi.load_scene(problem)
    p, y0 = PROBLEMS[problem] if scene is None else (scene.problem, scene.state)
    free = dataclasses.replace(p, parameters={}, **BOUNDS)
    return free, p.canonical(y0), {"tau_end" if p.time == "tau" else "t_end": END, "step": STEP}


def limit(at: Callable[[float], np.ndarray]) -> np.ndarray:
    """Return the derivative at 0: central differences, extrapolated (L. F. Richardson)."""
    table = [(at(h) - at(-h)) / (2.0 * h) for h in 0.05 / 2.0 ** np.arange(5)]
    for k in range(1, 5):
        table = [fine + (fine - coarse) / (4.0**k - 1.0) for coarse, fine in pairwise(table)]
    return table[0]


@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")  # states off the manifold
@pairs([p for p in FIXED if p[0] != "lobatto-8"] + SYSTEMS, FAST)  # which stays on the manifold
def test_slopes_are_those_of_the_map(name: str, problem: str) -> None:
    """By states, off the manifold too, and by parameters; lengths do not matter to the last bit."""
    p, y0, run = begun(problem)
    run |= {"method": name}
    plain = {**run, "clock": False} if p.time == "tau" else run
    rng = np.random.default_rng(4)
    u = rng.normal(size=p.rows)
    v = rng.normal(size=len(p.params)) * (p.params != np.round(p.params))  # some are counts

    def by_state(h: float) -> np.ndarray:
        return gi.solve(p, y0 + h * u, **plain).y[-1]

    def by_parameters(h: float) -> np.ndarray:
        return gi.solve(dataclasses.replace(p, params=p.params + h * v), y0, **plain).y[-1]

    given = {"directions": np.array([u, 0.0 * u]).T}
    if len(v):
        given["parameters"] = np.array([0.0 * v, v]).T
    found = gi.tangent_flow(p, y0, **run, **given)
    np.testing.assert_allclose(found.y, by_state(0.0), rtol=1e-15, atol=1e-15)
    expected = np.array([limit(by_state), limit(by_parameters)]).T
    size = np.abs(found.slopes).max()
    np.testing.assert_allclose(found.slopes, expected, rtol=0, atol=2e-12 * size)
    lengths = np.array([2.0**700, 2.0**-700])
    scaled = {name: lengths * moved for name, moved in given.items()}
    longer = gi.tangent_flow(p, y0, **run, **scaled)
    np.testing.assert_array_equal(longer.slopes / lengths, found.slopes)


GROWN = [POLE, ("rattle-2", "sphere-metric"), ("gauss-3", "henon-heiles")]
GROWN += [(name, "double-pendulum") for name in ("rattle-4", "lobatto-3", "lobatto-8")]


@pairs(GROWN, GROWN[:2])
def test_slopes_may_grow(name: str, problem: str) -> None:
    """Where they are much larger than the state the state is solved for as it was before."""
    p, y0, _ = begun(problem)
    stepper = gi.Integrator(p, y0, name, step=0.1).stepper
    y, slopes = [], []
    for grown in (1.0, 2.0**40, 2.0**500):
        still = np.zeros((len(p.params), p.rows))
        carried = CarriedDirections(stepper, np.eye(p.rows), still if len(still) else None)
        for group in carried._groups:
            group.memory[:, 1:] *= grown
        carried.take(0.0, 0.1, 5)
        y.append(carried.state)
        slopes.append(carried.slopes / grown)
    np.testing.assert_allclose(y[1:], [y[0]] * 2, rtol=0.0, atol=1e-14)
    size = np.abs(slopes[0]).max()
    np.testing.assert_allclose(slopes[1:], [slopes[0]] * 2, rtol=0.0, atol=1e-13 * size)


@given(
    st.sampled_from(["gauss-1", "gauss-8", "gauss-1-suzuki-4"]),
    st.floats(0.05, 0.6),
    st.sampled_from([1.0, 0.0, 1e-150]),
)
def test_symplectic_to_rounding(name: str, step: float, size: float) -> None:
    """Of converged equations, whatever the tolerance: values at rest need no iteration, slopes do."""
    run = {"t_end": 20 * step, "step": step}
    y0, method = size * np.asarray(START), gi.find_method(name)
    D = gi.tangent_flow(HENON, y0, **run, method=method).slopes
    assert np.abs(D.T @ J @ D - J).max() < 2e-14 * np.abs(D).max() ** 2
    coarse = method.with_options(iteration_tolerance=1e-6)
    np.testing.assert_array_equal(gi.tangent_flow(HENON, y0, **run, method=coarse).slopes, D)


@gi.observable
def pace(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 2.0 + y[0] * y[0]


SWING, RUNAWAY = swing(), swing(-1.0)


@pytest.mark.parametrize("name", ["rk-4", "gauss-8"])
@pytest.mark.parametrize(("size", "end"), [(0.0, 709.0), (1e100, 471.0)])
def test_what_overflows(name: str, size: float, end: float) -> None:
    """Slopes beside a state at rest, and states: no run succeeds with what is no number."""
    run = {"method": name, "step": 0.5}
    with pytest.raises(gi.NonFiniteError) as failed:
        gi.tangent_flow(RUNAWAY, [size, 0.0], t_end=1000.0, **run)
    assert failed.value.t == pytest.approx(end, rel=0.03)
    motion = gi.Integrator(RUNAWAY, [size, 0.0], **run, tangents=2)
    with pytest.raises(gi.NonFiniteError) as stopped:
        motion.step(2000)
    assert motion.steps == stopped.value.step == failed.value.step
    assert np.isfinite([motion.state, *motion.tangents]).all()
    terms = 5 if name == "rk-4" else 20  # of exp h: what a step of each method has of them
    grown = motion.steps * math.log(sum(0.5**k / math.factorial(k) for k in range(terms)))
    np.testing.assert_allclose(np.log(motion.tangents), grown - math.log(2.0), rtol=1e-12)


# --- what an integrator carries -------------------------------------------------------------------


@pairs(FIXED, [LOTKA, ("gauss-1-suzuki-4", "henon-heiles")])
def test_an_integrator_carries_the_slopes_of_the_flow(name: str, problem: str) -> None:
    """After steps, a cut step and a turn; the state's bits are those without directions."""
    p, y0, _ = begun(problem)
    end, v = 6.4 * STEP, np.eye(p.rows)[:, :2]
    motion = gi.Integrator(p, y0, name, step=STEP, tangents=2)
    plain = gi.Integrator(p, y0, name, step=STEP)
    for one in (motion, plain):
        one.step(2)
        one.propagate_until(end)
    flow = gi.tangent_flow(p, y0, t_end=end, method=name, step=STEP, directions=v)
    np.testing.assert_array_equal(motion.state, plain.state)
    np.testing.assert_allclose(motion.tangents, flow.slopes, rtol=0, atol=1e-14)
    motion.propagate_until(0.0)
    if name.startswith("gauss"):  # symmetric, and nothing is projected
        size = np.abs(flow.slopes).max()
        np.testing.assert_allclose(motion.tangents, v, rtol=0, atol=1e-4 * size)


def test_more_than_eight_and_the_clock() -> None:
    """Eight at once: those of the ninth on are no others; physical time is one more row."""
    timed = dataclasses.replace(SWING, time="tau", clock=pace)
    v = np.random.default_rng(3).normal(size=(2, 11))
    motion = gi.Integrator(timed, [0.3, 0.4], "rk-4", step=0.25, clock=True, tangents=v)
    motion.step(8)
    flow = gi.tangent_flow(SWING, [0.3, 0.4], t_end=2.0, method="rk-4", step=0.25, directions=v)
    np.testing.assert_allclose(motion.tangents, flow.slopes, rtol=0, atol=1e-14)
    whole = gi.tangent_flow(SWING, [0.3, 0.4], t_end=2.0, method="rk-4", step=0.25)
    np.testing.assert_allclose(flow.slopes, whole.slopes @ v, rtol=0, atol=1e-14)


def test_a_copy_goes_on_to_the_same_bits() -> None:
    """Carries, stages and units of derivatives are part of it, of more than eight directions too."""
    v = np.random.default_rng(3).normal(size=(4, 11))
    motion = gi.Integrator(HENON, START, "gauss-8", step=0.1, tangents=v)
    motion.step(1000)
    others = (copy.copy(motion), copy.deepcopy(motion), pickle.loads(pickle.dumps(motion)))
    assert np.abs(motion.tangents).max() > 4.0 * np.abs(v).max()
    for count in (0, 150):
        for one in others:
            one.step(count)
        motion.step(count)
        for one in others:
            np.testing.assert_array_equal(one.tangents, motion.tangents)


def test_what_is_written() -> None:
    """Another state, time, step or parameters keep the directions; a reset gives the first ones."""
    whole = gi.Integrator(HENON, START, "gauss-8", step=0.1, tangents=4)
    whole.step(6)
    motion = gi.Integrator(HENON, START, "gauss-8", step=0.1, tangents=4)
    motion.step(3)
    before = motion.tangents
    motion.state, motion.time, motion.h = motion.state, 5.0, 0.1
    np.testing.assert_array_equal(motion.tangents, before)
    motion.step(3)
    np.testing.assert_allclose(motion.tangents, whole.tangents, rtol=0, atol=1e-14)
    motion.tangents = np.linalg.qr(motion.tangents)[0][:, :3]
    assert motion.tangents.shape == (4, 3)
    for one in (motion, pickle.loads(pickle.dumps(motion))):
        one.reset(0.5 * np.asarray(START), 3.0)
        np.testing.assert_array_equal(one.tangents, np.eye(4))
    whole.reset()
    whole.step(3)
    np.testing.assert_array_equal(whole.tangents, before)
    runaway = gi.Integrator(SWING, [0.3, 0.4], "rk-4", step=0.25, tangents=2)
    runaway.params = RUNAWAY.params
    runaway.step(8)
    flow = gi.tangent_flow(RUNAWAY, [0.3, 0.4], t_end=2.0, method="rk-4", step=0.25)
    np.testing.assert_array_equal(runaway.tangents, flow.slopes)


@pairs(
    [pair for pair in FAMILIES if gi.find_method(pair[0]).adaptive],
    [("dormand-prince-5-adaptive", "lotka-volterra")],
)
def test_steps_of_an_adaptive_run(name: str, problem: str) -> None:
    """The derivative of its steps as they were taken: near that of the motion."""
    p, y0, _ = begun(problem)
    found = gi.tangent_flow(p, y0, t_end=1.3, method=name)
    fine = gi.tangent_flow(p, y0, t_end=1.3, method="rk-4", step=1.3 / 400)
    size = np.abs(fine.slopes).max()
    run = gi.solve(p, y0, t_end=1.3, method=name)
    np.testing.assert_allclose(found.y, run.y[-1], rtol=0, atol=1e-13)
    np.testing.assert_allclose(found.slopes, fine.slopes, rtol=0, atol=1e-6 * size)
    assert np.abs(found.slopes - fine.slopes).max() > 1e-15


FREE = first("free", lambda p, t, y: 0.0 * y[0])
NAN = np.full((4, 1), np.nan)
TAU = gi.load_scene("hamiltonized-n3")
LONG = {"step": 50.0, "t_end": 100.0, "method": gi.Gauss(8, iteration="fixed-point")}


def test_wrong_input() -> None:
    directions = [({"directions": x}, gi.DomainError, "4 rows") for x in (np.eye(3), NAN)]
    for wrong, kind, said in (
        *directions,
        ({"method": "exact"}, gi.MethodError, "no steps of a given length"),
        ({"problem": TAU.problem, "y0": TAU.state}, gi.DomainError, "moves with the state"),
        (LONG, gi.StepError, "too large"),
        ({"parameters": np.eye(2)}, gi.DomainError, "1 rows"),
        ({"parameters": np.ones((1, 2)), "directions": np.eye(4)}, gi.DomainError, "as many as"),
        ({"problem": FREE, "y0": [1.0] * 2, "parameters": [[1]]}, gi.DomainError, "no parameters"),
    ):
        with pytest.raises(kind, match=said):
            gi.tangent_flow(**{"problem": HENON, "y0": START, "t_end": 1.0, "step": 0.1, **wrong})


def test_wrong_input_of_integrators() -> None:
    given = {"problem": HENON, "state": START, "method": "gauss-8", "step": 0.1}
    for tangents in (0, 5, True, np.ones((3, 1)), NAN):
        with pytest.raises(gi.DomainError, match="tangents"):
            gi.Integrator(**given, tangents=tangents)
    with pytest.raises(gi.DomainError, match="carries none"):
        _ = gi.Integrator(**given).tangents
    with pytest.raises(gi.MethodError, match="no steps of a given length"):
        gi.Integrator(**{**given, "method": "dop853-adaptive"}, tangents=1, compiled=False)
    with pytest.raises(gi.DomainError, match="compiled"):
        gi.Integrator(**given, tangents=1, compiled=False)
