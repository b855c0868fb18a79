"""Exponentials, actions and brackets of SO(3) and SO(n), against 40 digits and each other."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp

from geomint.forms import Group
from geomint.groups import so3, so_n
from geomint.kernels import signatures
from geomint.kernels.blocks import Block, LaneBlock
from geomint.kernels.compile import LANE, SCALAR, compile_function
from geomint.kernels.lanes import LANES
from geomint.kernels.so3 import SMALL

pytestmark = pytest.mark.nojit
EPSILON = 2.0**-52
PIECES = ("vector", "adjoint", "frame")


def sizes(group: Group, n: int, pieces: tuple[str, ...]) -> int:
    """Rows of a state made of pieces."""
    return sum({"vector": n, "adjoint": n * (n - 1) // 2, "frame": n * n}[p] for p in pieces)


def skew(flat: np.ndarray, n: int) -> np.ndarray:
    """Skew matrix of a flat upper triangle, of the same kind of number."""
    x = np.zeros((n, n), dtype=np.asarray(flat).dtype)
    x[np.triu_indices(n, 1)] = flat
    return x - x.T


def act(group: Group, xi: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The increment, by plain Python."""
    out = np.zeros(len(y))
    group.act(Block(group.layout), Block(xi), Block(y), Block(out), Block(np.zeros(group.work)))
    return out


def bracket(group: Group, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    out = np.zeros(group.algebra_rows)
    group.bracket(Block(group.layout), Block(x), Block(y), Block(out), Block(np.zeros(group.work)))
    return out


def exact_exponential(x: np.ndarray) -> np.ndarray:
    """Matrix exponential of a float64 matrix in 40 digits."""
    with mp.workdps(80):
        e = mpmath.expm(mp.matrix(x.tolist()))
        return np.array(e.tolist(), dtype=object).reshape(x.shape)


def exact_action(n: int, pieces: tuple[str, ...], xi: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The increments of all pieces in 40 digits."""
    with mp.workdps(80):
        e = exact_exponential(skew(xi, n))
        result, at = [], 0
        for piece in pieces:
            rows = {"vector": n, "adjoint": n * (n - 1) // 2, "frame": n * n}[piece]
            old = np.array([mp.mpf(float(v)) for v in y[at : at + rows]], dtype=object)
            if piece == "vector":
                new = e @ old
            elif piece == "adjoint":
                new = (e @ skew(old, n) @ e.T)[np.triu_indices(n, 1)]
            else:
                new = (old.reshape(n, n) @ e.T).ravel()
            result.append(new - old)
            at += rows
        return np.concatenate(result)


angles = st.one_of(
    st.floats(-30.0, 0.0).map(lambda e: 10.0**e),
    st.floats(1e-3, 0.05),
    st.floats(1e-30, 30.0),  # below, 80 digits of exp(x) − 1 are not enough to compare with
    st.sampled_from(
        [0.0, np.sqrt(SMALL), np.sqrt(SMALL) * (1 + 1e-15), 0.25, 0.5, np.pi, 2 * np.pi]
    ),
)
directions = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed))


@given(angle=angles, rng=directions)
def test_so3_turns_vectors(angle: float, rng: np.random.Generator) -> None:
    """The increment is right to rounding, relative to its own size, at every angle."""
    axis = rng.standard_normal(3)
    xi = axis * (angle / np.linalg.norm(axis))
    y = rng.standard_normal(6)
    found = act(so3(2), xi, y)
    hat = np.array([-xi[2], xi[1], -xi[0]])  # the flat triangle of x̂
    exact = exact_action(3, ("vector", "vector"), hat, y)
    size = min(angle, 2.0) * np.max(np.abs(y)) + 1e-300
    # The angle itself is known to ε only, which turns by ε · angle.
    allowed = 8 * EPSILON * (size + 2.0 * max(angle - 2.0, 0.0))
    assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed


@given(n=st.integers(2, 6), angle=angles, rng=directions)
def test_so_n_acts_on_all_pieces(n: int, angle: float, rng: np.random.Generator) -> None:
    """Vectors, skew matrices and frames, right to rounding."""
    group = so_n(n, *PIECES)
    xi = rng.standard_normal(group.algebra_rows)
    xi *= angle / np.linalg.norm(xi)
    y = rng.standard_normal(sizes(group, n, PIECES))
    found, exact = act(group, xi, y), exact_action(n, PIECES, xi, y)
    allowed = 16 * n * EPSILON * min(angle, 2.0) * (1.0 + angle) * np.max(np.abs(y)) + 1e-300
    assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed


@given(n=st.integers(2, 5), rng=directions)
def test_so_n_bracket(n: int, rng: np.random.Generator) -> None:
    """[X, Y] = XY − YX, skew and of the right sign."""
    group = so_n(n)
    x, y = rng.standard_normal((2, group.algebra_rows))
    X, Y = skew(x, n), skew(y, n)
    expected = (X @ Y - Y @ X)[np.triu_indices(n, 1)]
    np.testing.assert_allclose(bracket(group, x, y), expected, rtol=0, atol=8 * n * EPSILON * 10)
    np.testing.assert_array_equal(bracket(group, x, y), -bracket(group, y, x))


@given(rng=directions)
def test_so3_and_so_n_are_the_same_group(rng: np.random.Generator) -> None:
    """In the identification x ↦ x̂."""
    x, y, v = rng.standard_normal((3, 3))

    def hat(w: np.ndarray) -> np.ndarray:
        return np.array([-w[2], w[1], -w[0]])

    np.testing.assert_allclose(bracket(so3(1), x, y), np.cross(x, y), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        bracket(so_n(3), hat(x), hat(y)), hat(np.cross(x, y)), rtol=0, atol=1e-14
    )
    np.testing.assert_allclose(
        act(so3(1), x, v), act(so_n(3, "vector"), hat(x), v), rtol=0, atol=1e-14
    )


@pytest.mark.parametrize("n", [0, 3, 4])
def test_lanes_are_eight_actions(n: int) -> None:
    """Bit for bit, also where the lanes need different series and different scalings."""
    pieces = PIECES if n else ()
    group = so_n(n, *pieces) if n else so3(2)
    rows = sizes(group, n, pieces) if n else 6
    rng = np.random.default_rng(n)
    xi = rng.standard_normal((group.algebra_rows, LANES))
    xi *= np.array([0.0, 1e-200, 1e-9, 0.02, 0.04, 0.3, 3.0, 25.0])
    y = rng.standard_normal((rows, LANES))
    single = compile_function(group.act, signatures.action(SCALAR))
    several = compile_function(group.act, signatures.action(LANE))
    out = LaneBlock(np.zeros((rows, LANES)))
    work = LaneBlock(np.zeros((group.work, LANES)))
    several(Block(group.layout), LaneBlock(xi), LaneBlock(y), out, work)
    for k in range(LANES):
        one = Block(np.zeros(rows))
        single(
            Block(group.layout),
            Block(xi[:, k].copy()),
            Block(y[:, k].copy()),
            one,
            Block(np.zeros(group.work)),
        )
        np.testing.assert_array_equal(out.data[:, k], one.data)
        np.testing.assert_array_equal(one.data, act(group, xi[:, k].copy(), y[:, k].copy()))


def test_groups_refuse_nonsense() -> None:
    """With the value and what was expected."""
    with pytest.raises(ValueError, match="n = 1: expected a dimension ≥ 2"):
        so_n(1)
    with pytest.raises(ValueError, match="Did you mean 'vector'"):
        so_n(3, "vectro")
    with pytest.raises(ValueError, match="vectors = 0"):
        so3(0)
