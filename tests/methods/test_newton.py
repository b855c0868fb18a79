"""Steps of Gauss methods whose fixed-point iteration does not contract: stiff forces, long steps."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.tableaux import gauss_legendre
from tests.methods.stage_increments import increments
from tests.problems import fast_rotor, spring_pendulum

Array = Any
LONG = pytest.mark.filterwarnings("ignore:.*steps of .* are so long:geomint.GeomintWarning")
SOLVED = 1e-13  # residuals are rounded to h‖J‖ roundings: some hundred here


def problem(field: Any, rows: int, params: Any = (), **more: Any) -> gi.Problem:
    return gi.Problem(
        name=field.function.__name__, pieces=(("y", rows),), field=field, params=params, **more
    )


def in_one_piece(of: gi.Problem) -> gi.Problem:
    """Return a problem whose state is as large as all of it: no piece passes through nothing."""
    invariants = {"energy": of.invariants["energy"]}
    return problem(of.field, 4, of.params, invariants=invariants)


PENDULUM, ROTOR = map(in_one_piece, (spring_pendulum.problem(), fast_rotor.problem(1000.0)))
# Problem, state, the longest step that the fixed-point iteration takes twenty times (within a tenth).
STIFF = {
    "stiff pendulum": (PENDULUM, np.array([1.0005, 0.0, 0.0, 0.0]), 0.05),
    "fast rotor": (ROTOR, fast_rotor.INITIAL, 0.0069),
}
WITHIN = {"stiff pendulum": 3e-4, "fast rotor": 0.04}  # of the energy, at five times that


def moved(of: gi.Problem, y: Array, step: float, count: int, **options: Any) -> gi.Integrator:
    compiled = options.pop("compiled", True)
    motion = gi.Integrator(of, y, gi.Gauss(8, **options), step=step, compiled=compiled)
    motion.step(count)
    return motion


each = pytest.mark.parametrize(
    "name", ["stiff pendulum", pytest.param("fast rotor", marks=pytest.mark.nightly)]
)


@LONG
@each
def test_longer_steps_than_the_fixed_point_takes(name: str) -> None:
    """It fails at twice its longest; at five times that, the energy stays where it is."""
    of, y, longest = STIFF[name]
    moved(of, y, longest / 1.2, 20, iteration="fixed-point")
    with pytest.raises(gi.ConvergenceError):
        moved(of, y, 2.0 * longest, 20, iteration="fixed-point")
    h = 5.0 * longest
    run = gi.solve(of, y, t_end=1000 * h, step=h, observe=["energy"], progress=False)
    maxima = np.array(run.drift["energy"].windows.maxima)
    half = len(maxima) // 2
    assert maxima[half:].max() <= 1.1 * maxima[:half].max()
    assert maxima.max() < WITHIN[name]


def correction(of: gi.Problem, y: Array, t: float, h: float, L: Array, stages: int) -> float:
    """Return Newton's correction of increments, relative: by dense matrices of all stages."""
    table = gauss_legendre(stages)
    c, b, mu = (np.asarray(x) for x in (table.c, table.b, table.mu))
    Y, n = y + mu @ L, of.rows
    lack = L - h * b[:, None] * np.array(
        [gi.derivative(of, Y[i], t + c[i] * h) for i in range(stages)]
    )
    matrix = np.eye(stages * n)
    for i in range(stages):
        J = gi.jacobian(of, Y[i], t + c[i] * h)
        for j in range(stages):
            matrix[i * n : (i + 1) * n, j * n : (j + 1) * n] -= h * b[i] * mu[i, j] * J
    change = np.linalg.solve(matrix, lack.ravel())
    return float(np.abs(change).max() / max(np.abs(y).max(), np.abs(L).max()))


@pytest.mark.parametrize(
    "stages", [1, 3, 8, *(pytest.param(s, marks=pytest.mark.nightly) for s in (2, 13))]
)
@each
def test_what_is_accepted_is_solved(name: str, stages: int) -> None:
    """Dense matrices of all stages, made elsewhere, have nothing left to correct."""
    of, y, longest = STIFF[name]
    h = 2.0 * longest
    motion = gi.Integrator(of, y, gi.Gauss(stages, iteration="newton"), step=h)
    for k in range(6):
        before = motion.state
        motion.step()
        found = increments(motion.stepper, stages)
        assert correction(of, before, k * h, h, found, stages) < SOLVED
        np.testing.assert_allclose(motion.state, before + found.sum(axis=0), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize(
    "stages",
    [pytest.param(s, marks=[pytest.mark.nightly] * (s not in (2, 11))) for s in range(1, 17)],
)
def test_what_is_found_is_what_the_fixed_point_finds(stages: int) -> None:
    of, y, longest = STIFF["stiff pendulum"]
    ends = [
        gi.Integrator(of, y, gi.Gauss(stages, iteration=i), step=0.2 * longest, compiled=False)
        for i in ("fixed-point", "newton")
    ]
    for motion in ends:
        motion.step(3)
    np.testing.assert_allclose(*(motion.state for motion in ends), rtol=0.0, atol=4e-14)


# --- bits ---------------------------------------------------------------------------------------------


@gi.field
def stiffer(params, t, y, out, work):
    """An oscillator whose force grows with time: steps are easy, and then they are not."""
    out[0], out[1] = y[1], -(1.0 + params[0] * t * t) * y[0] - y[0] * y[0] * y[0]


STIFFER = problem(stiffer, 2, [100.0])
START = np.array([1.0, 0.5])
STEPS, LENGTH = 60, 0.25


def end_of(motion: gi.Integrator) -> bytes:
    return bytes(motion.restart.memory.tobytes()) + bytes([motion.steps])


def test_the_same_bits_in_chunks_and_after_restarts() -> None:
    """Wherever it is broken off: before, at, or after the first step that is not easy."""
    whole = moved(STIFFER, START, LENGTH, STEPS)
    with pytest.raises(gi.ConvergenceError):
        moved(STIFFER, START, LENGTH, STEPS, iteration="fixed-point")
    for size in (1, 7, 59):
        pieces = moved(STIFFER, START, LENGTH, 0)
        while pieces.steps < STEPS:
            pieces.step(min(size, STEPS - pieces.steps))
        assert end_of(pieces) == end_of(whole)
        assert pieces.iterations == whole.iterations
    for at in (3, 20, 50):
        first = moved(STIFFER, START, LENGTH, at)
        for other in (pickle.loads(pickle.dumps(first)), copy.copy(first)):
            other.step(STEPS - at)
            assert end_of(other) == end_of(whole)


def test_the_same_bits_in_plain_python() -> None:
    for of, y, h in ((STIFFER, START, 1.0), (PENDULUM, STIFF["stiff pendulum"][1], 0.1)):
        ends = [end_of(moved(of, y, h, 2, compiled=compiled)) for compiled in (True, False)]
        assert ends[0] == ends[1]


def test_long_steps_are_told() -> None:
    """Once a run, unless they are asked for."""
    of, (_, y, longest) = spring_pendulum.problem(), STIFF["stiff pendulum"]
    h = 3.0 * longest
    with pytest.warns(gi.GeomintWarning, match="shorter step") as told:
        assert gi.solve(of, y, t_end=50 * h, step=h).newton
    assert len(told) == 1
    assert gi.solve(of, y, t_end=50 * h, step=h, method=gi.Gauss(8, iteration="newton")).newton
    assert not gi.solve(of, y, t_end=5.0, step=longest / 4.0).newton


@LONG
def test_what_takes_over_is_shared_by_runs_of_a_problem() -> None:
    """It is made by the first that needs it; the next ones have its bits, at their own states."""
    _, y, longest = STIFF["stiff pendulum"]
    parts, fresh = (1.0, 0.9, 1.1), [in_one_piece(spring_pendulum.problem()) for _ in range(3)]
    h = 5.0 * longest
    alone = [moved(p, part * y, h, 20).state for p, part in zip(fresh, parts, strict=True)]
    again = [moved(fresh[0], part * y, h, 20).state for part in parts]
    assert np.array_equal(again, alone)


def test_easy_steps_do_not_turn() -> None:
    of, y, longest = STIFF["stiff pendulum"]
    motion = moved(of, y, 0.2 * longest, 200)
    plain = moved(of, y, 0.2 * longest, 200, iteration="fixed-point")
    assert motion.stepper.flow.make_other is not None
    assert end_of(motion) == end_of(plain)
    assert motion.stepper.turn(motion.stepper.flow)
    motion.reset()
    motion.step(200)
    assert end_of(motion) == end_of(plain)


# --- where Jacobians are special --------------------------------------------------------------------


@gi.field
def linear(params, t, y, out, work):
    out[0], out[1] = params[0] + params[1] * y[1], params[2] + params[3] * t + 0.0 * y[0]


@pytest.mark.parametrize(
    ("params", "h", "steps", "end"),
    [
        ((0.0, 0.0, 0.0, 0.0), 0.5, 3, [1.0, -2.0]),
        ((3.0, 0.0, 0.0, 2.0), 0.5, 2, [4.0, -1.0]),
        ((0.0, 1e3, -1.0, 0.0), 1.0, 1, [1.0 - 2500.0, -3.0]),  # J is singular, not zero
    ],
)
def test_a_jacobian_that_is_zero_or_singular(params: Any, h: float, steps: int, end: Any) -> None:
    given = {"iteration": "newton", "compiled": False}
    found = moved(problem(linear, 2, params), np.array([1.0, -2.0]), h, steps, **given)
    np.testing.assert_allclose(found.state, end, rtol=1e-14)


@gi.field
def cubic(params, t, y, out, work):
    """2/h (y − b (y − a)³): 1 − h J/2 is 0 at y = a, where the midpoint rule begins."""
    away = y[0] - params[1]
    out[0] = params[0] * (y[0] - params[2] * away * away * away)


def test_a_step_whose_matrix_is_singular() -> None:
    """Where it has a solution elsewhere that is found; where it has none that is told."""
    a, h, plain = 0.125, 0.5, {"step": 0.5, "compiled": False}
    of = problem(cubic, 1, [2.0 / h, a, 1.0])
    motion = gi.Integrator(of, [a], gi.Gauss(1, iteration="newton"), **plain)
    motion.step()
    np.testing.assert_allclose(motion.state, [2.0 * (a + a ** (1.0 / 3.0)) - a], rtol=1e-14)
    growing = problem(cubic, 1, [2.0 / h, a, 0.0])
    motion = gi.Integrator(growing, [a], gi.Gauss(1), time=1.0, **plain)
    with pytest.raises(gi.ConvergenceError) as caught:
        motion.step(3)
    error = caught.value
    assert (error.t, error.step) == (1.0, 0)
    assert error.iterations > 30
    assert error.residual > 1e-3
    assert motion.state.tolist() == [a]
    assert motion.steps == 0


def test_from_rest_and_through_nothing() -> None:
    """A piece that is 0 before the step, and one of 1e-150, are solved for to relative accuracy."""
    of = spring_pendulum.problem()
    for p in (0.0, 1e-150):
        y = np.array([0.0, -1.001, p, p])
        motion = gi.Integrator(of, y, "gauss-8", step=0.1)
        motion.step()
        assert correction(of, y, 0.0, 0.1, increments(motion.stepper, 8), 8) < SOLVED


@gi.field
def powers(params, t, y, out, work):
    """Takes no numbers with derivatives."""
    out[0], out[1] = y[1], -params[0] * y[0] ** 3


@pytest.mark.filterwarnings("ignore:field 'powers' takes one number:geomint.GeomintWarning")
@pytest.mark.parametrize("compiled", [True, False])
def test_a_field_without_derivatives_keeps_its_fixed_point(compiled: bool) -> None:
    of, y = problem(powers, 2, [1e4]), np.array([1.0, 0.0])
    assert np.isfinite(moved(of, y, 0.001, 2, compiled=compiled).state).all()
    with pytest.raises(gi.ConvergenceError):
        moved(of, y, 1.0, 2, compiled=compiled)
    with pytest.raises(gi.DeclarationError, match="derivatives"):
        moved(of, y, 0.001, 2, compiled=compiled, iteration="newton")


# --- beside a run -------------------------------------------------------------------------------------


@LONG
def test_states_between_long_steps() -> None:
    """They are real steps from the node before."""
    of, y, longest = STIFF["stiff pendulum"]
    h = 1.5 * longest
    wanted = np.linspace(0.3 * h, 20.7 * h, 35)
    run = gi.solve(of, y, t_end=30 * h, step=h, t_eval=wanted, progress=False)
    nodes = gi.solve(of, y, t_end=30 * h, step=h, save_every=1, progress=False)
    for t, state in zip(wanted, run.y, strict=True):
        k = int(t / h)
        part = gi.Integrator(of, nodes.y[k], gi.Gauss(8), step=h)
        part.propagate_for(t - k * h)
        np.testing.assert_allclose(state, part.state, atol=1e-9)
