"""What carries directions along: products of tables, determinants near one, directions per pass."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.kernels.compiling.bound import Bound
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import SCALAR
from geomint.kernels.compiling.signatures import BLOCK, REAL, WHOLE, takes
from geomint.kernels.numbers.blocks import Block, scalar_block
from geomint.kernels.tangent.layout import lanes_for
from geomint.kernels.tangent.near_identity import log_volume
from geomint.kernels.tangent.products import add_product, write_overlaps
from tests.measure.exact_maps import exact_defect


def table(values: np.ndarray) -> Block:
    """A block of a matrix, its columns filled up to whole lane values."""
    block = scalar_block(len(values) * lanes_for(values.shape[1]))
    block.data.reshape(len(values), -1)[:, : values.shape[1]] = values
    return block


THREE = takes(None, n=WHOLE, A=BLOCK, B=BLOCK, out=BLOCK)
VOLUME = takes(REAL, d=WHOLE, S=BLOCK, lower=BLOCK, upper=BLOCK)
plain_or_compiled = pytest.mark.parametrize("compiled", [False, True], ids=["plain", "compiled"])


@plain_or_compiled
@pytest.mark.parametrize(("n", "a", "b"), [(1, 1, 1), (6, 4, 3), (15, 8, 7), (9, 11, 17)])
def test_products_of_tables(n: int, a: int, b: int, compiled: bool) -> None:
    rng = np.random.default_rng(n)
    A, B, C = rng.normal(size=(n, a)), rng.normal(size=(n, b)), rng.normal(size=(n, b))
    overlaps = scalar_block(lanes_for(a) * lanes_for(b))
    Bound(write_overlaps, THREE).call(compiled)(n=n, A=table(A), B=table(B), out=overlaps)
    found = overlaps.data.reshape(lanes_for(a), lanes_for(b))
    np.testing.assert_allclose(found[:a, :b], A.T @ B, atol=1e-13)
    assert not found[a:].any()
    assert not found[:, b:].any()
    total = table(C)
    Bound(add_product, THREE).call(compiled)(n=n, A=table(A), B=overlaps, out=total)
    found = total.data.reshape(n, lanes_for(b))[:, :b]
    np.testing.assert_allclose(found, C + A @ (A.T @ B), atol=1e-12)


def volume(S: np.ndarray, compiled: bool = False) -> tuple[float, np.ndarray]:
    """½ log det(1 + S), and the inverse factor."""
    d = len(S)
    upper = scalar_block(lanes_for(d) ** 2)
    upper.data[:] = 7.0  # what was there does not count
    call = Bound(log_volume, VOLUME).call(compiled)
    lower = scalar_block(lanes_for(d) ** 2)
    found = call(d=d, S=table(S), lower=lower, upper=upper)
    return found, upper.data.reshape(lanes_for(d), -1)


@pytest.mark.nojit
@given(st.integers(1, 9), st.floats(-12.0, 0.0), st.integers(0, 10**6))
def test_determinants_near_one(d: int, exponent: float, seed: int) -> None:
    """To the rounding of S, not to that of 1; the factor makes columns orthonormal."""
    size, rng = 10.0**exponent, np.random.default_rng(seed)
    Q = np.linalg.qr(rng.normal(size=(d + 3, d)))[0]
    D = size / d * rng.normal(size=(d + 3, d))
    S = Q.T @ D + D.T @ Q + D.T @ D
    with mpmath.workdps(40):
        exact = mpmath.eye(d) + mpmath.matrix(S.tolist())
        expected = float(mpmath.log(mpmath.det(exact)) / 2)
    found, upper = volume(S)
    assert abs(found - expected) <= 1e-13 * size
    X = (Q + D) @ upper[:d, :d]
    np.testing.assert_allclose(X.T @ X, np.eye(d), atol=1e-12)
    assert not upper[d:].any()
    assert not upper[:, d:].any()


@pytest.mark.parametrize("size", [1e-9, 0.1, 3.0])
def test_determinants_compiled(size: float) -> None:
    """The same bits."""
    X = np.random.default_rng(3).normal(size=(9, 6))
    S = size * X.T @ X
    (plain, factor), (fast, compiled) = volume(S), volume(S, compiled=True)
    assert fast == plain
    np.testing.assert_array_equal(compiled, factor)


@pytest.mark.nojit
@pytest.mark.parametrize("S", [[[-1.0]], [[np.nan]], [[0.0, 2.0], [2.0, 0.0]]])
def test_no_volume(S: list[list[float]]) -> None:
    """What has no factor has no number that looks like its volume."""
    assert np.isnan(volume(np.array(S))[0])


# --- directions in several passes -----------------------------------------------------------------


@gi.field
def turning(params, t, y, out, work):
    """Nine points on circles, each turned by how far the next one is."""
    for i in range(9):
        speed = 1.0 + 0.3 * y[2 * ((i + 1) % 9)] * y[2 * i]
        out[2 * i] = -speed * y[2 * i + 1]
        out[2 * i + 1] = speed * y[2 * i]


@gi.field
def on_circles(params, t, y, out, work):
    for i in range(9):
        out[i] = y[2 * i] * y[2 * i] + y[2 * i + 1] * y[2 * i + 1] - 1.0


@gi.observable
def volume_alone(params, t, y, work):
    return 0.0 * y[0]


CIRCLES = gi.Problem(
    "circles", (("x", 18),), field=turning, measure=gi.Measure(volume_alone, on_circles, 9)
)
FREE = gi.Problem("free", (("x", 18),), field=turning, measure=gi.Measure(volume_alone))
ANGLES = np.linspace(0.2, 5.0, 9)
ROUND = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1).ravel()


@pytest.mark.parametrize(
    ("problem", "name"),
    [
        (CIRCLES, "rk-4"),
        (FREE, "rk-4"),
        pytest.param(CIRCLES, "gauss-1", marks=pytest.mark.nightly),
    ],
    ids=["circles-rk-4", "free-rk-4", "circles-gauss-1"],
)
def test_many_directions(problem: gi.Problem, name: str) -> None:
    """More than eight, and more than eight conditions; the first step and later ones."""
    h = 0.1
    run = {"method": name, "step": h, "observe": ["measure"]}
    sol = gi.solve(problem, ROUND, t_end=3 * h, **run, save_every=1)
    expected = exact_defect(problem, name, 0.0, ROUND, h)
    assert abs(expected) > 1e-9
    single = gi.solve(problem, ROUND, t_end=h, **run).drift["measure"]
    assert single.final_error == pytest.approx(expected, abs=2e-15)
    if problem is FREE:
        parts = [exact_defect(problem, name, 0.0, y, h) for y in sol.y[:3]]
        assert sol.drift["measure"].final_error == pytest.approx(sum(parts), abs=5e-15)


def test_a_store_as_the_last_use_of_a_part_is_made() -> None:
    """numba must not take it for dead: the part shares the memory of its block."""

    @gi.helper
    def store(block, row):
        view = gi.part(block, 2, 3)
        view[row] = 7.0

    from numba.core import types

    block = scalar_block(5)
    compile_function(store, types.void(SCALAR.block, types.int64))(block, 1)
    assert block.data.tolist() == [0.0, 0.0, 0.0, 7.0, 0.0]
