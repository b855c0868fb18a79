"""Groups SO(3) and SO(n): actions, brackets, coordinates, against 80 digits and each other."""

from __future__ import annotations

import dataclasses
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st
from mpmath import mp

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.numbers.blocks import Block, LaneBlock

pytestmark = pytest.mark.nojit
EPSILON, LANES = 2.0**-52, 8
PIECES = ("vector", "adjoint", "frame")
SMALL = 1.0  # below, sines of angles are series


def size_of(piece: str, n: int) -> int:
    return {"vector": n, "adjoint": n * (n - 1) // 2, "frame": n * n}[piece]


def skew(flat: np.ndarray, n: int) -> np.ndarray:
    """Skew matrix of a flat upper triangle, of the same kind of number."""
    x = np.zeros((n, n), dtype=np.asarray(flat).dtype)
    x[np.triu_indices(n, 1)] = flat
    return x - x.T


def turned(x: np.ndarray) -> np.ndarray:
    """The vector whose hat is the skew matrix of a flat triangle of n = 3, and the other way."""
    return np.array([-x[2], x[1], -x[0]])


def scaled(rng: np.random.Generator, rows: int, size: float) -> np.ndarray:
    """A random vector of a given length."""
    x = rng.standard_normal(rows)
    return x * (size / np.linalg.norm(x))


def call(name: str, group: gi.Group, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Any function of a group, by plain Python."""
    out, work = np.zeros(len(y)), Block(np.zeros(group.work + 2 * group.algebra_rows))
    with np.errstate(invalid="ignore", over="ignore"):
        getattr(group, name)(Block(group.layout), Block(x), Block(y), Block(out), work)
    return out


def exact_turn(chart: str, x: np.ndarray) -> np.ndarray:
    """exp(x), or (1 − x/2)⁻¹ (1 + x/2), of a matrix in the digits that there are."""
    if chart == "act":
        e = mpmath.expm(mp.matrix(x.tolist()))
    else:
        half, one = mp.matrix(x.tolist()) / 2, mp.eye(len(x))
        e = mp.inverse(one - half) * (one + half)
    return np.array(e.tolist(), dtype=object).reshape(x.shape)


def exact_action(
    chart: str, n: int, pieces: tuple[str, ...], xi: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """The increments of all pieces in 80 digits."""
    with mp.workdps(80):
        e = exact_turn(chart, skew(xi, n))
        result, at = [], 0
        for piece in pieces:
            rows = size_of(piece, n)
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
    st.sampled_from([0.0, SMALL, SMALL * (1 + 1e-15), 0.5, np.pi, 2 * np.pi]),
)
inside = st.one_of(
    st.floats(-20.0, 0.0).map(lambda e: 10.0**e),
    st.floats(1e-3, 5.99),
    st.sampled_from([0.0, SMALL, SMALL * (1 + 1e-15), 3.0, np.pi, 5.99]),
)
directions = st.integers(0, 10**6).map(lambda seed: np.random.default_rng(seed))


def check_action(chart: str, n: int, size: float, rng: np.random.Generator) -> None:
    """Increments are right to rounding of their own size; on SO(3) by its own formulas too."""
    group = gi.so_n(n, *PIECES)
    xi = scaled(rng, group.algebra_rows, size)
    cases = [(group, xi, PIECES, 16 * n * min(size, 2.0) * (1.0 + size))]
    if n == 3:
        # The angle itself is known to ε only, which turns by ε · angle.
        own = 8 * (min(size, 2.0) + 2.0 * max(size - 2.0, 0.0))
        cases.append((gi.so3(2), turned(xi), ("vector", "vector"), max(own, 0.0)))
    for group, x, pieces, roundings in cases:
        y = rng.standard_normal(sum(size_of(piece, n) for piece in pieces))
        found, exact = call(chart, group, x, y), exact_action(chart, n, pieces, xi, y)
        allowed = roundings * EPSILON * np.max(np.abs(y)) + 1e-300
        assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed


@given(n=st.integers(2, 6), angle=angles, rng=directions)
def test_turns_act_on_all_pieces(n: int, angle: float, rng: np.random.Generator) -> None:
    check_action("act", n, angle, rng)
    check_action("act", 3, angle, rng)


@given(n=st.integers(2, 6), size=inside, rng=directions)
def test_cayley_acts_on_all_pieces(n: int, size: float, rng: np.random.Generator) -> None:
    check_action("cayley", n, size, rng)
    check_action("cayley", 3, size, rng)


@given(n=st.integers(2, 9), size=st.floats(0.0, 6.0), rng=directions)
def test_huge_turns_are_orthogonal(n: int, size: float, rng: np.random.Generator) -> None:
    """EᵀE = 1 to roundings, where doublings alone would have lost up to half of the digits."""
    group, one = gi.so_n(n, "frame"), np.eye(n)
    for chart, length in (("act", 10.0**size), ("cayley", 1.33 * size)):
        m = call(chart, group, scaled(rng, group.algebra_rows, length), one.ravel())
        e = one + m.reshape(n, n)
        np.testing.assert_allclose(e.T @ e, one, rtol=0, atol=8 * n * EPSILON * (4.0 + size))


@given(n=st.integers(2, 5), rng=directions)
def test_brackets(n: int, rng: np.random.Generator) -> None:
    """[X, Y] = XY − YX, skew and of the right sign; on SO(3) the cross product."""
    group = gi.so_n(n)
    x, y = rng.standard_normal((2, group.algebra_rows))
    X, Y = skew(x, n), skew(y, n)
    found = call("bracket", group, x, y)
    expected = (X @ Y - Y @ X)[np.triu_indices(n, 1)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=8 * n * EPSILON * 10)
    np.testing.assert_array_equal(found, -call("bracket", group, y, x))
    if n == 3:
        own = call("bracket", gi.so3(1), turned(x), turned(y))
        np.testing.assert_allclose(own, np.cross(turned(x), turned(y)), rtol=0, atol=1e-14)


# --- coordinates ----------------------------------------------------------------------------------


def differential(chart: str, n: int, u: np.ndarray, w: np.ndarray) -> np.ndarray:
    """``dψ_u(w)`` as a flat triangle: (ψ(u + ε w) − ψ(u)) ψ(u)⁻¹ / ε in 80 digits, ψ = exp or cay."""
    with mp.workdps(80):
        small = mp.mpf(10) ** -40
        exact = [np.array([mp.mpf(float(v)) for v in x], dtype=object) for x in (u, w)]
        there = exact_turn(chart, skew(exact[0] + small * exact[1], n))
        here = exact_turn(chart, skew(exact[0], n))
        return ((there - here) @ here.T / small)[np.triu_indices(n, 1)].astype(float)


@given(n=st.integers(2, 5), size=inside, rng=directions)
def test_inverse_differentials(n: int, size: float, rng: np.random.Generator) -> None:
    """dψ_u(dψ_u⁻¹ v) = v, for left actions: (d/dt) ψ(u) = dψ_u(u̇) ψ(u); beyond π too.

    Of rotations by the closed form, whose pole at 2π magnifies rounding.
    """
    cases = [("cayley", "dcayinv", n), ("cayley", "dcayinv", 3), ("act", "dexpinv", 3)]
    for chart, inverse, order in cases:
        group = gi.so_n(order)
        u, v = scaled(rng, group.algebra_rows, size), rng.standard_normal(group.algebra_rows)
        w = call(inverse, group, u, v)
        near = (1.0 + size) ** 2 if chart == "cayley" else 1.0 / (1.0 - size / (2 * np.pi))
        atol = 64 * EPSILON * near * np.max(np.abs(v))
        np.testing.assert_allclose(differential(chart, order, u, w), v, rtol=0, atol=atol)
        if order == 3:
            other = call(inverse, gi.so3(1), turned(u), turned(v))
            np.testing.assert_allclose(other, turned(w), rtol=0, atol=atol)


@gi.field
def spin(params, t, y, out, work):
    """A velocity that depends on the state, and on time."""
    for i in range(3):
        out[i] = 1.0 + 0.3 * y[i] - 0.2 * t


@pytest.mark.parametrize("tableau", ["kutta-3", "rk-4", "dormand-prince-5", "dop853"])
def test_the_series_of_the_inverse_differential(tableau: str) -> None:
    """Without the closed form steps differ by what is left out, which is of their own order."""
    closed, ends = gi.so_n(3, "vector"), []
    method = gi.RKMK(tableau)
    for group in (closed, dataclasses.replace(closed, dexpinv=None)):
        problem = gi.Problem("spin", (("y", 3),), action=gi.GroupAction(spin, group))
        for h in (0.4, 0.2):
            run = {"step": h, "method": method, "compiled": False}
            ends.append(gi.solve(problem, [0.6, 0.0, 0.8], t_end=h, **run).y[-1])
    coarse, fine = (np.abs(ends[k] - ends[k + 2]).max() for k in (0, 1))
    assert method.order + 0.5 < np.log2(coarse / fine) < method.order + 2.0
    assert fine > 1e-13


def test_translations_are_their_own_coordinates() -> None:
    """In R^m beside SO(n), every map is the identity."""
    for n in (2, 3, 4):
        group = gi.so_n(n, "vector") * gi.translations(2)
        rng = np.random.default_rng(n)
        u, v = rng.standard_normal((2, group.algebra_rows))
        y = rng.standard_normal(n + 2)
        for chart in ("act", "cayley"):
            np.testing.assert_array_equal(call(chart, group, u, y)[n:], u[-2:])
        for inverse in ("dcayinv", *["dexpinv"] * (n == 3)):
            np.testing.assert_array_equal(call(inverse, group, u, v)[-2:], v[-2:])


@pytest.mark.parametrize("size", [6.01, 2 * np.pi, 10.0, 1e9, 1e200, 1e300, np.nan])
def test_coordinates_end(size: float) -> None:
    """Where they do, NaN is written: never a number that means nothing, as an angle of 1e9."""
    u, v = np.array([0.6, 0.0, 0.8]) * size, np.array([0.3, -0.2, 0.5])
    assert np.isnan(call("dexpinv", gi.so3(1), u, v)).all()
    assert np.isnan(call("dexpinv", gi.so_n(3), u, v)).all()
    if not size < 8.0:
        assert np.isnan(call("cayley", gi.so_n(3, "vector"), u, v)).all()
    if not size < 1e9:
        assert np.isnan(call("act", gi.so_n(3, "vector"), u, v)).all()


LANED = [(0, "act"), (0, "dexpinv"), (4, "act"), (4, "cayley")]
AT_NIGHT = [(0, "cayley"), (0, "dcayinv"), (3, "act"), (3, "dexpinv"), (4, "dcayinv")]


@pytest.mark.parametrize(
    ("n", "name"), [*LANED, *(pytest.param(*x, marks=pytest.mark.nightly) for x in AT_NIGHT)]
)
def test_lanes_are_eight_actions(n: int, name: str) -> None:
    """Bit for bit, also where the lanes need different series and different scalings."""
    from numba.core import types

    group = gi.so_n(n, *PIECES) if n else gi.so3(2)
    function: Any = getattr(group, name)
    rows = sum(size_of(piece, n) for piece in PIECES) if n else 6
    rows = rows if name in ("act", "cayley") else group.algebra_rows
    rng = np.random.default_rng(n)
    xi = rng.standard_normal((group.algebra_rows, LANES))
    xi *= np.array([0.0, 1e-200, 1e-9, 0.02, 0.3, 3.0, 25.0, 1e5])
    y = rng.standard_normal((rows, LANES))
    single, several = (
        compile_function(function, types.void(SCALAR.block, *[kind.block] * 4))
        for kind in (SCALAR, LANE)
    )
    scratch, out = group.work + 2 * group.algebra_rows, LaneBlock(np.zeros((rows, LANES)))
    work = LaneBlock(np.zeros((scratch, LANES)))
    several(Block(group.layout), LaneBlock(xi), LaneBlock(y), out, work)
    for k in range(LANES):
        one, given = Block(np.zeros(rows)), (xi[:, k].copy(), y[:, k].copy())
        single(Block(group.layout), *map(Block, given), one, Block(np.zeros(scratch)))
        np.testing.assert_array_equal(out.data[:, k], one.data)
        np.testing.assert_array_equal(one.data, call(name, group, *given))


def test_groups_refuse_nonsense() -> None:
    """With the value and what was expected."""
    with pytest.raises(ValueError, match="n = 1: expected a whole number ≥ 2"):
        gi.so_n(1)
    with pytest.raises(ValueError, match="Did you mean 'vector'"):
        gi.so_n(3, "vectro")
    with pytest.raises(ValueError, match="vectors = 0"):
        gi.so3(0)
