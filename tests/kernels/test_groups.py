"""Groups SO(3) and SO(n): actions, brackets, coordinates, against 40 digits and each other."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st
from mpmath import mp

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.compiling.recorded import Recorded
from geomint.kernels.compiling.signatures import ACTION
from geomint.kernels.groups.so3 import SMALL
from geomint.kernels.numbers.blocks import Block, LaneBlock
from geomint.kernels.numbers.lanes import LANES
from geomint.methods.rkmk import coordinates_of

pytestmark = pytest.mark.nojit
EPSILON = 2.0**-52
PIECES = ("vector", "adjoint", "frame")


def sizes(group: gi.Group, n: int, pieces: tuple[str, ...]) -> int:
    """Rows of a state made of pieces."""
    return sum({"vector": n, "adjoint": n * (n - 1) // 2, "frame": n * n}[p] for p in pieces)


def skew(flat: np.ndarray, n: int) -> np.ndarray:
    """Skew matrix of a flat upper triangle, of the same kind of number."""
    x = np.zeros((n, n), dtype=np.asarray(flat).dtype)
    x[np.triu_indices(n, 1)] = flat
    return x - x.T


def act(group: gi.Group, xi: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The increment, by plain Python."""
    return call(group.act, group, xi, y)


def call(function: Recorded, group: gi.Group, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Any function of a group, by plain Python."""
    out, work = np.zeros(len(y)), Block(np.zeros(group.work + 2 * group.algebra_rows))
    with np.errstate(invalid="ignore", over="ignore"):
        function(Block(group.layout), Block(x), Block(y), Block(out), work)
    return out


def bracket(group: gi.Group, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return call(group.bracket, group, x, y)


def exact_exponential(x: np.ndarray) -> np.ndarray:
    """Matrix exponential of a float64 matrix in 40 digits."""
    with mp.workdps(80):
        e = mpmath.expm(mp.matrix(x.tolist()))
        return np.array(e.tolist(), dtype=object).reshape(x.shape)


def exact_cayley(x: np.ndarray) -> np.ndarray:
    """(1 − x/2)⁻¹ (1 + x/2) of a float64 matrix in 80 digits."""
    with mp.workdps(80):
        half, one = mp.matrix(x.tolist()) / 2, mp.eye(len(x))
        e = mp.inverse(one - half) * (one + half)
        return np.array(e.tolist(), dtype=object).reshape(x.shape)


EXACT = {"act": exact_exponential, "cayley": exact_cayley}


def exact_action(
    n: int, pieces: tuple[str, ...], xi: np.ndarray, y: np.ndarray, chart: str = "act"
) -> np.ndarray:
    """The increments of all pieces in 40 digits."""
    with mp.workdps(80):
        e = EXACT[chart](skew(xi, n))
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
    found = act(gi.so3(2), xi, y)
    hat = np.array([-xi[2], xi[1], -xi[0]])  # the flat triangle of x̂
    exact = exact_action(3, ("vector", "vector"), hat, y)
    size = min(angle, 2.0) * np.max(np.abs(y)) + 1e-300
    # The angle itself is known to ε only, which turns by ε · angle.
    allowed = 8 * EPSILON * (size + 2.0 * max(angle - 2.0, 0.0))
    assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed


@given(n=st.integers(2, 6), angle=angles, rng=directions)
def test_so_n_acts_on_all_pieces(n: int, angle: float, rng: np.random.Generator) -> None:
    """Vectors, skew matrices and frames, right to rounding."""
    group = gi.so_n(n, *PIECES)
    xi = rng.standard_normal(group.algebra_rows)
    xi *= angle / np.linalg.norm(xi)
    y = rng.standard_normal(sizes(group, n, PIECES))
    found, exact = act(group, xi, y), exact_action(n, PIECES, xi, y)
    allowed = 16 * n * EPSILON * min(angle, 2.0) * (1.0 + angle) * np.max(np.abs(y)) + 1e-300
    assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed


@given(n=st.integers(2, 7), size=st.floats(0.0, 6.0), rng=directions)
def test_huge_turns_are_orthogonal(n: int, size: float, rng: np.random.Generator) -> None:
    """EᵀE = 1 to roundings, where doublings alone would have lost up to half of the digits."""
    group, one = gi.so_n(n, "frame"), np.eye(n)
    e = one + act(group, scaled(rng, group.algebra_rows, 10.0**size), one.ravel()).reshape(n, n)
    np.testing.assert_allclose(e.T @ e, one, rtol=0, atol=8 * n * EPSILON * 4.0)


@pytest.mark.parametrize("size", [1e9, 1e100, 1e300])
def test_turns_of_no_meaning_are_refused(size: float) -> None:
    """At a billion turns the angle has lost more than half of its digits."""
    assert np.isnan(act(gi.so_n(3, "vector"), size * np.ones(3), np.ones(3))).all()


@given(n=st.integers(2, 5), rng=directions)
def test_so_n_bracket(n: int, rng: np.random.Generator) -> None:
    """[X, Y] = XY − YX, skew and of the right sign."""
    group = gi.so_n(n)
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

    np.testing.assert_allclose(bracket(gi.so3(1), x, y), np.cross(x, y), rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        bracket(gi.so_n(3), hat(x), hat(y)), hat(np.cross(x, y)), rtol=0, atol=1e-14
    )
    np.testing.assert_allclose(
        act(gi.so3(1), x, v), act(gi.so_n(3, "vector"), hat(x), v), rtol=0, atol=1e-14
    )


# --- coordinates ----------------------------------------------------------------------------------

inside = st.one_of(
    st.floats(-20.0, 0.0).map(lambda e: 10.0**e),
    st.floats(1e-3, 5.99),
    st.sampled_from([0.0, np.sqrt(SMALL), np.sqrt(SMALL) * (1 + 1e-15), 3.0, np.pi, 5.99]),
)


def scaled(rng: np.random.Generator, rows: int, size: float) -> np.ndarray:
    """A random vector of a given length."""
    x = rng.standard_normal(rows)
    return x * (size / np.linalg.norm(x))


@given(n=st.integers(2, 6), size=inside, rng=directions)
def test_cayley_acts_on_all_pieces(n: int, size: float, rng: np.random.Generator) -> None:
    """Right to rounding, relative to the increment, on SO(n) and on SO(3) by its own formula."""
    group = gi.so_n(n, *PIECES)
    xi = scaled(rng, group.algebra_rows, size)
    y = rng.standard_normal(sizes(group, n, PIECES))
    found = call(group.cayley, group, xi, y)
    exact = exact_action(n, PIECES, xi, y, "cayley")
    allowed = 16 * n * EPSILON * min(size, 2.0) * (1.0 + size) * np.max(np.abs(y)) + 1e-300
    assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed
    if n == 3:
        vectors = rng.standard_normal(6)
        found = call(gi.so3(2).cayley, gi.so3(2), from_triangle(xi), vectors)
        exact = exact_action(3, ("vector", "vector"), xi, vectors, "cayley")
        assert float(max(abs(e - f) for e, f in zip(exact, found, strict=True))) <= allowed


@given(n=st.integers(2, 9), size=st.floats(0.0, 7.99), rng=directions)
def test_cayley_is_orthogonal(n: int, size: float, rng: np.random.Generator) -> None:
    """EᵀE = 1 to roundings, as far as the coordinates go."""
    group = gi.so_n(n, "frame")
    one = np.eye(n)
    m = call(group.cayley, group, scaled(rng, group.algebra_rows, size), one.ravel())
    e = one + m.reshape(n, n)
    np.testing.assert_allclose(e.T @ e, one, rtol=0, atol=8 * n * EPSILON * (1.0 + size))


def from_triangle(x: np.ndarray) -> np.ndarray:
    """The vector whose hat is the skew matrix of a flat triangle of n = 3."""
    return np.array([-x[2], x[1], -x[0]])


def differential(chart: str, n: int, u: np.ndarray, w: np.ndarray) -> np.ndarray:
    """``dψ_u(w)`` as a flat triangle: (ψ(u + ε w) − ψ(u)) ψ(u)⁻¹ / ε in 80 digits, ψ = exp or cay."""
    with mp.workdps(80):
        small = mp.mpf(10) ** -40
        exact = [np.array([mp.mpf(float(v)) for v in x], dtype=object) for x in (u, w)]
        there = EXACT[chart](skew(exact[0] + small * exact[1], n))
        here = EXACT[chart](skew(exact[0], n))
        return ((there - here) @ here.T / small)[np.triu_indices(n, 1)].astype(float)


@given(n=st.integers(2, 5), size=inside, rng=directions)
def test_inverse_differential_of_cayley(n: int, size: float, rng: np.random.Generator) -> None:
    """dcay_u(dcay_u⁻¹ v) = v, for left actions: (d/dt) cay(u) = dcay_u(u̇) cay(u)."""
    group = gi.so_n(n)
    u, v = scaled(rng, group.algebra_rows, size), rng.standard_normal(group.algebra_rows)
    w = call(group.dcayinv, group, u, v)
    atol = 64 * EPSILON * (1.0 + size) ** 2 * np.max(np.abs(v))
    np.testing.assert_allclose(differential("cayley", n, u, w), v, rtol=0, atol=atol)
    if n == 3:
        other = call(gi.so3(1).dcayinv, gi.so3(1), from_triangle(u), from_triangle(v))
        np.testing.assert_allclose(other, from_triangle(w), rtol=0, atol=atol)


@given(size=inside, rng=directions)
def test_inverse_differential_of_rotations(size: float, rng: np.random.Generator) -> None:
    """dexp_u(dexp_u⁻¹ v) = v by the closed form, beyond π too; the pole at 2π magnifies rounding."""
    group = gi.so_n(3)
    u, v = scaled(rng, 3, size), rng.standard_normal(3)
    w = call(group.dexpinv, group, u, v)
    atol = 64 * EPSILON / (1.0 - size / (2 * np.pi)) * np.max(np.abs(v))
    np.testing.assert_allclose(differential("act", 3, u, w), v, rtol=0, atol=atol)
    other = call(gi.so3(1).dexpinv, gi.so3(1), from_triangle(u), from_triangle(v))
    np.testing.assert_allclose(other, from_triangle(w), rtol=0, atol=atol)


def series(group: gi.Group, order: int) -> Recorded:
    """The truncated series of dexp⁻¹, whatever closed form there may be."""
    return coordinates_of(replace(group, dexpinv=None), "exp", order)[1]


@pytest.mark.parametrize("n", [3, 4, 5])
def test_the_series_of_the_inverse_differential(n: int) -> None:
    """Kept up to ad^(p−2): what is left out is of size (|ad_u|/2π)^(p−1), to machine precision."""
    group, rng = gi.so_n(n), np.random.default_rng(n)
    u, v = scaled(rng, group.algebra_rows, 0.5), scaled(rng, group.algebra_rows, 1.0)
    for order in (2, 3, 4, 8, 24):
        w = call(series(group, order), group, u, v)
        error = np.max(np.abs(differential("act", n, u, w) - v))
        left = order - 1 + (order > 2 and order % 2 == 0)  # B_3 = B_5 = … = 0
        assert error <= 4.0 * (np.sqrt(2) * 0.5 / (2 * np.pi)) ** left + 16 * EPSILON
    if n == 3:
        closed = call(group.dexpinv, group, u, v)
        np.testing.assert_allclose(w, closed, rtol=0, atol=16 * EPSILON)


def test_translations_are_their_own_coordinates() -> None:
    """In R^m beside SO(n), every map is the identity."""
    for n in (2, 3, 4):
        group = gi.so_n(n, "vector") * gi.translations(2)
        rng = np.random.default_rng(n)
        u, v = rng.standard_normal((2, group.algebra_rows))
        y = rng.standard_normal(n + 2)
        for chart in ("act", "cayley"):
            np.testing.assert_array_equal(call(getattr(group, chart), group, u, y)[n:], u[-2:])
        inverses = [group.dcayinv, series(group, 8), *([group.dexpinv] if n == 3 else [])]
        for inverse in inverses:
            np.testing.assert_array_equal(call(inverse, group, u, v)[-2:], v[-2:])


@pytest.mark.parametrize("size", [6.01, 2 * np.pi, 10.0, 1e200, np.nan])
def test_coordinates_end(size: float) -> None:
    """Where they do, NaN is written: never a number that means nothing."""
    u, v = np.array([0.6, 0.0, 0.8]) * size, np.array([0.3, -0.2, 0.5])
    assert np.isnan(call(gi.so3(1).dexpinv, gi.so3(1), u, v)).all()
    assert np.isnan(call(gi.so_n(3).dexpinv, gi.so_n(3), u, v)).all()
    if not size < 8.0:
        assert np.isnan(call(gi.so_n(3).cayley, gi.so_n(3, "vector"), u, v)).all()


LANED = [
    *((0, function) for function in ("act", "cayley", "dexpinv", "dcayinv")),
    *((3, function) for function in ("act", "dexpinv")),
    *((4, function) for function in ("act", "cayley", "dexpinv", "dcayinv")),
]


@pytest.mark.parametrize(("n", "function"), LANED)
def test_lanes_are_eight_actions(n: int, function: str) -> None:
    """Bit for bit, also where the lanes need different series and different scalings."""
    pieces = PIECES if n else ()
    group = gi.so_n(n, *pieces) if n else gi.so3(2)
    recorded = getattr(group, function)
    if recorded is None:
        recorded = series(group, 8)
    rows = sizes(group, n, pieces) if n else 6
    if function not in ("act", "cayley"):
        rows = group.algebra_rows
    rng = np.random.default_rng(n)
    xi = rng.standard_normal((group.algebra_rows, LANES))
    xi *= np.array([0.0, 1e-200, 1e-9, 0.02, 0.3, 3.0, 25.0, 1e5])
    y = rng.standard_normal((rows, LANES))
    single = compile_function(recorded, ACTION.of(SCALAR))
    several = compile_function(recorded, ACTION.of(LANE))
    out = LaneBlock(np.zeros((rows, LANES)))
    scratch = group.work + 2 * group.algebra_rows
    work = LaneBlock(np.zeros((scratch, LANES)))
    several(Block(group.layout), LaneBlock(xi), LaneBlock(y), out, work)
    for k in range(LANES):
        one = Block(np.zeros(rows))
        single(
            Block(group.layout),
            Block(xi[:, k].copy()),
            Block(y[:, k].copy()),
            one,
            Block(np.zeros(scratch)),
        )
        np.testing.assert_array_equal(out.data[:, k], one.data)
        plain = call(recorded, group, xi[:, k].copy(), y[:, k].copy())
        np.testing.assert_array_equal(one.data, plain)


def test_groups_refuse_nonsense() -> None:
    """With the value and what was expected."""
    with pytest.raises(ValueError, match="n = 1: expected a whole number ≥ 2"):
        gi.so_n(1)
    with pytest.raises(ValueError, match="Did you mean 'vector'"):
        gi.so_n(3, "vectro")
    with pytest.raises(ValueError, match="vectors = 0"):
        gi.so3(0)
