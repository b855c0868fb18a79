"""What the instrument is made of: reflections, determinants, Gauss methods for eight trajectories."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from exact_maps import PROBLEMS
from hypothesis import given, strategies as st

from geomint.kernels.compiling.bound import Bound
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.compiling.recorded import helper
from geomint.kernels.compiling.signatures import FIELD
from geomint.kernels.measure.reflections import (
    log_det_near_identity,
    reflect,
    reflect_back,
    reflections,
)
from geomint.kernels.numbers.blocks import Block, LaneBlock, part, scalar_block
from geomint.kernels.numbers.lanes import LANES
from geomint.kernels.solve.advance import bound_stepper
from geomint.kernels.solve.gauss_trajectories import gauss_trajectories_stepper
from geomint.methods import Start, find_method

# --- linear algebra -------------------------------------------------------------------------------


@pytest.mark.nojit
@given(st.integers(1, 7), st.integers(0, 5), st.integers(0, 10**6))
def test_reflections_make_orthonormal_bases(n: int, m: int, seed: int) -> None:
    """The first components are those along the rows, and the volume is that of the rows."""
    m = min(m, n)
    rows = np.random.default_rng(seed).standard_normal((m, n))
    vectors = Block(np.zeros(m * n))
    volume = reflections(n, m, Block(rows.copy().ravel()), vectors)
    basis = np.eye(n)
    for column in basis:
        reflect_back(m, vectors, Block(column))
    np.testing.assert_allclose(basis @ basis.T, np.eye(n), atol=1e-14)
    np.testing.assert_allclose(basis[m:] @ rows.T, 0.0, atol=1e-13)
    if m > 0:
        expected = 0.5 * np.linalg.slogdet(rows @ rows.T)[1]
        assert volume == pytest.approx(expected, abs=1e-9)
    x = np.arange(1.0, n + 1.0)
    there = x.copy()
    reflect(m, vectors, Block(there))
    np.testing.assert_allclose(there, basis @ x, atol=1e-13)


@pytest.mark.nojit
def test_dependent_rows_are_not_finite() -> None:
    """Two equal conditions: no number that looks like one."""
    vectors = Block(np.zeros(6))
    with np.errstate(all="ignore"):
        volume = reflections(3, 2, Block(np.array([0.0, 3.0, 4.0, 0.0, 6.0, 8.0])), vectors)
    assert volume < -30.0


@pytest.mark.nojit
@pytest.mark.parametrize("size", [1e-12, 1e-6, 1e-2, 0.1, 1.0, 30.0])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_determinants_near_one(size: float, n: int) -> None:
    """To the rounding of E, not to that of 1."""
    for seed in range(5):
        E = size * np.random.default_rng(seed).standard_normal((n, n))
        with mpmath.workdps(40):
            expected = float(mpmath.log(abs(mpmath.det(mpmath.eye(n) + mpmath.matrix(E.tolist())))))
        found = log_det_near_identity(n, Block(E.copy().ravel()))
        assert abs(found - expected) <= 2e-14 * size


@pytest.mark.nojit
def test_determinants_of_large_matrices() -> None:
    """A quarter turn needs exchanges; a singular matrix is −inf."""
    turn = Block(np.array([-1.0, -1.0, 1.0, -1.0]))
    assert log_det_near_identity(2, turn) == 0.0
    with np.errstate(all="ignore"):
        assert log_det_near_identity(1, Block(np.array([-1.0]))) == -np.inf
        assert np.isnan(log_det_near_identity(2, Block(np.full(4, np.nan))))


def test_a_store_as_the_last_use_of_a_part_is_made() -> None:
    """numba must not take it for dead: the part shares the memory of its block."""

    @helper
    def store(block, row):
        view = part(block, 2, 3)
        view[row] = 7.0

    from numba.core import types

    block = scalar_block(5)
    compile_function(store, types.void(SCALAR.block, types.int64))(block, 1)
    assert block.data.tolist() == [0.0, 0.0, 0.0, 7.0, 0.0]


# --- Gauss methods for trajectories ---------------------------------------------------------------

H = 0.1


def gauss(name: str, problem: str, states: np.ndarray, kind, h: float = H):
    """The entry of the kernel for trajectories, its arguments, and its memory from such states."""
    p, y0 = PROBLEMS[problem]
    stepper = find_method(name).start(Start(p, y0, 0.0, h))
    lanes = stepper.lanes()
    field = Bound(lanes.functions[0].recorded, FIELD)
    loop = bound_stepper(lanes.kernel, (field,)).call(number_type=kind, functions=(field,))
    shape = (LANES,) if kind is LANE else ()
    make = LaneBlock if kind is LANE else Block
    memory = make(np.zeros((lanes.memory_rows, *shape)))
    memory.data[: p.rows] = states
    work = make(np.zeros((lanes.work_rows, *shape)))

    def advance(count: int) -> tuple[int, int, int, float]:
        return loop(
            params=stepper.params,
            coefficients=lanes.coefficients,
            fractions=stepper.fractions,
            memory=memory,
            work=work,
            rows=p.rows,
            t0=0.0,
            h=h,
            first=0,
            count=count,
            every=count + 1,
            out=memory,
        )

    return advance, memory


def eight(problem: str) -> np.ndarray:
    _, y0 = PROBLEMS[problem]
    return np.stack([y0 * (1.0 + 0.02 * k) for k in range(LANES)], axis=1)


@pytest.mark.parametrize(
    ("name", "problem"), [("gauss-3", "lotka-volterra"), ("gauss-1-suzuki-4", "henon-heiles")]
)
def test_trajectories_do_not_depend_on_each_other(name: str, problem: str) -> None:
    """Each lane has the bits of a run of its own."""
    states = eight(problem)
    together, memory = gauss(name, problem, states, LANE)
    assert together(200)[:2] == (0, 200)
    for k in range(LANES):
        alone, single = gauss(name, problem, states[:, k], SCALAR)
        assert alone(200)[:2] == (0, 200)
        np.testing.assert_array_equal(memory.data[:, k], single.data)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("gauss-1", "henon-heiles"),
        ("gauss-3", "lotka-volterra"),
        ("gauss-8", "spherical-pendulum"),
        ("gauss-11", "lotka-volterra"),
        ("gauss-1-suzuki-4", "henon-heiles"),
    ],
)
def test_trajectories_are_those_of_gauss(name: str, problem: str) -> None:
    """The same map, to rounding."""
    p, y0 = PROBLEMS[problem]
    advance, memory = gauss(name, problem, y0[:, None], LANE)
    assert advance(100)[:2] == (0, 100)
    stepper = find_method(name).start(Start(p, y0, 0.0, H))
    assert stepper.advance(0, 100, 101, scalar_block(0)).status == 0
    np.testing.assert_allclose(
        memory.data[: p.rows], np.repeat(stepper.state[:, None], LANES, axis=1), rtol=3e-14
    )


def test_a_step_too_large_is_told() -> None:
    """Neither an endless loop nor a success."""
    advance, _ = gauss("gauss-3", "lotka-volterra", eight("lotka-volterra"), LANE, h=30.0)
    status, steps, *_ = advance(1)
    assert status != 0
    assert steps == 0


@pytest.mark.nojit
def test_trajectories_in_plain_python() -> None:
    """The source runs as it stands."""
    p, y0 = PROBLEMS["lotka-volterra"]
    stepper = find_method("gauss-3").start(Start(p, y0, 0.0, H, compiled=False))
    lanes = stepper.lanes()
    assert lanes.kernel is gauss_trajectories_stepper()
    memory = LaneBlock(np.zeros((lanes.memory_rows, LANES)))
    memory.data[: p.rows] = y0[:, None]
    work = LaneBlock(np.zeros((lanes.work_rows, LANES)))
    status, *_ = lanes.kernel(
        (lanes.functions[0].recorded,), stepper.params, lanes.coefficients, stepper.fractions,
        memory, work, p.rows, 0.0, H, 0, 3, 4, memory,
    )  # fmt: skip
    assert status == 0
    stepper.advance(0, 3, 4, scalar_block(0))
    np.testing.assert_allclose(memory.data[: p.rows, 0], stepper.state, rtol=1e-15)
