"""Gauss methods: 50-digit identities, closed forms, exact structure in float64, the predictor."""

from __future__ import annotations

import decimal
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from operator import attrgetter
from typing import Literal

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from geomint.tableaux import (
    MAX_GAUSS_STAGES,
    GaussTableau,
    gauss_legendre,
    row,
    rows,
    runge_kutta_defect,
)

STAGES = range(1, MAX_GAUSS_STAGES + 1)
each_method = pytest.mark.parametrize(
    "method", [gauss_legendre(s) for s in STAGES], ids=attrgetter("name")
)
TINY = Fraction(1, 10**47)


@each_method
def test_quadrature_and_collocation_conditions(method: GaussTableau) -> None:
    """B(2s), C(s) and D(s), which together imply order 2s, to 47 digits."""
    A, b, c, s = method.tableau.A, method.tableau.b, method.tableau.c, method.stages
    powers = [[x ** (k - 1) for x in c] for k in range(1, 2 * s + 2)]
    for k, power in enumerate(powers[:-1], start=1):
        assert abs(sum(x * y for x, y in zip(b, power, strict=True)) - Fraction(1, k)) < TINY
    beyond = sum(x * y for x, y in zip(b, powers[-1], strict=True)) - Fraction(1, 2 * s + 1)
    assert abs(beyond) > 10**6 * TINY or s > 10
    for k, power in enumerate(powers[:s], start=1):
        for a, x in zip(A, c, strict=True):
            assert abs(sum(u * v for u, v in zip(a, power, strict=True)) - x**k / k) < TINY
        weighted = [u * v for u, v in zip(b, power, strict=True)]
        for column, b_j, c_j in zip(zip(*A, strict=True), b, c, strict=True):
            sums = sum(u * v for u, v in zip(weighted, column, strict=True))
            assert abs(sums - b_j * (1 - c_j**k) / k) < TINY


@each_method
def test_nodes_and_structure(method: GaussTableau) -> None:
    """Zeros of Legendre polynomials, rounded to 50 digits; symmetric and symplectic exactly."""
    with mp.workdps(70):
        for text in map(str, method.nodes[: method.stages // 2]):
            start = 2 * mp.mpf(text) - 1
            zero = mp.findroot(lambda x: mp.legendre(method.stages, x), start)
            assert mp.nstr((1 + zero) / 2, 50, strip_zeros=False) == text
    assert list(method.nodes) == sorted(set(method.nodes))
    assert all(0 < c < 1 for c in method.nodes)
    assert method.tableau.symmetric
    assert method.tableau.symplectic
    assert not method.tableau.explicit
    assert method.order == method.tableau.order == 2 * method.stages
    assert method.name == f"gauss-{method.order}"


@pytest.mark.parametrize("stages", [1, 2, 3])
def test_order_on_all_trees(stages: int) -> None:
    """Rooted trees up to the order are satisfied, and not all of the next size."""
    method = gauss_legendre(stages).tableau
    assert runge_kutta_defect(method, method.order) < TINY
    assert runge_kutta_defect(method, method.order + 1) > Fraction(1, 10**5)


def test_closed_forms() -> None:
    """Coefficients for s = 1, 2, 3 in terms of square roots."""
    one = gauss_legendre(1).tableau
    assert (one.A, one.b, one.c) == (rows("1/2"), row("1"), row("1/2"))
    with decimal.localcontext(prec=60):
        r, q = Decimal(3).sqrt(), Decimal(15).sqrt()
        four = [[1 / Decimal(4), 1 / Decimal(4) - r / 6], [1 / Decimal(4) + r / 6, 1 / Decimal(4)]]
        b_1, b_2 = 5 / Decimal(36), 2 / Decimal(9)
        six = [
            [b_1, b_2 - q / 15, b_1 - q / 30],
            [b_1 + q / 24, b_2, b_1 - q / 24],
            [b_1 + q / 30, b_2 + q / 15, b_1],
        ]
    for stages, closed in ((2, four), (3, six)):
        for a, expected in zip(gauss_legendre(stages).tableau.A, closed, strict=True):
            for x, y in zip(a, expected, strict=True):
                assert abs(x - Fraction(y)) < TINY


@each_method
def test_mu_is_symplectic_in_floating_point(method: GaussTableau) -> None:
    """``mu + mu^T = 1`` without any round-off, for the high, the low and the rounded sums."""
    hi, lo = method.split("mu")
    np.testing.assert_array_equal(method.mu, hi)
    np.testing.assert_array_equal(hi + hi.T, np.ones_like(hi))
    np.testing.assert_array_equal(lo + lo.T, np.zeros_like(lo))
    np.testing.assert_array_equal(np.diag(hi), 0.5)
    np.testing.assert_array_equal(hi[::-1, ::-1], hi.T)
    np.testing.assert_array_equal(lo[::-1, ::-1], lo.T)
    assert abs(hi).max() <= 2.0
    for i in range(method.stages):
        for j in range(method.stages):
            assert Fraction(hi[i, j]) + Fraction(hi[j, i]) == 1
            exact = method.tableau.A[i][j] / method.tableau.b[j]
            assert abs(Fraction(hi[i, j]) - exact) <= Fraction(1, 2**53)
            assert abs(Fraction(hi[i, j]) + Fraction(lo[i, j]) - exact) < Fraction(1, 2**105)


@each_method
def test_weights_and_nodes_are_symmetric_in_floating_point(method: GaussTableau) -> None:
    """Weights are palindromic, nodes add up to 1 in pairs, and both have 32 digits in two parts."""
    names: tuple[Literal["b", "c"], ...] = ("b", "c")
    for name in names:
        hi, lo = method.split(name)
        np.testing.assert_array_equal(getattr(method, name), hi)
        for x, y, exact in zip(hi, lo, getattr(method.tableau, name), strict=True):
            assert abs(Fraction(x) - exact) <= Fraction(1, 2**54)
            assert abs(Fraction(x) + Fraction(y) - exact) < Fraction(1, 2**105)
    for part in method.split("b"):
        np.testing.assert_array_equal(part, part[::-1])
    hi, lo = method.split("c")
    np.testing.assert_array_equal(lo, -lo[::-1])
    assert all(Fraction(x) + Fraction(y) == 1 for x, y in zip(hi, hi[::-1], strict=True))


each_size = pytest.mark.parametrize(
    "stages",
    [pytest.param(s, marks=[pytest.mark.nightly] * (s not in (1, 2, 5, 16))) for s in STAGES],
)


@each_size
@pytest.mark.parametrize("ratio", [1.0, 0.7, 2.5])
def test_predictor_reproduces_polynomials(stages: int, ratio: float) -> None:
    """Exact for derivatives of degree s - 1, and for no higher degree."""
    method = gauss_legendre(stages)
    s, tableau = method.stages, method.tableau
    P, rho = method.predictor(ratio), Fraction(ratio)
    for degree in range(s + 1):
        previous = [b * c**degree for b, c in zip(tableau.b, tableau.c, strict=True)]
        following = [
            rho * b * (1 + rho * c) ** degree for b, c in zip(tableau.b, tableau.c, strict=True)
        ]
        for P_i, expected in zip(P, following, strict=True):
            terms = [Fraction(p) * x for p, x in zip(P_i, previous, strict=True)]
            bound = Fraction(1, 2**53) * sum(map(abs, terms)) + TINY * 10**12
            assert (abs(sum(terms) - expected) <= bound) == (degree < s)


@given(ratio=st.floats(0.01, 8.0), stages=st.integers(1, MAX_GAUSS_STAGES))
def test_predictor_continues_a_constant(ratio: float, stages: int) -> None:
    """A constant field is predicted exactly for any ratio of steps: ``P b = ratio b``."""
    method = gauss_legendre(stages)
    P = method.predictor(ratio)
    error = np.abs(P @ method.b - ratio * method.b)
    assert np.all(error <= 2.0**-48 * (np.abs(P) @ method.b))
    # A step back repeats the increments with opposite sign, in reverse order, to the bit.
    np.testing.assert_array_equal(method.predictor(-1.0), -np.eye(stages)[::-1])
    for array in (method.b, method.c, method.mu, P, *method.split("mu")):
        assert array.dtype == np.float64
        assert array.flags.c_contiguous
        assert not array.flags.writeable


def test_what_is_refused() -> None:
    """Steps have finite lengths, and only some numbers of stages have stored nodes."""
    for ratio in (float("nan"), float("inf")):
        with pytest.raises(ValueError, match="finite"):
            gauss_legendre(2).predictor(ratio)
    for stages in (0, -1, MAX_GAUSS_STAGES + 1):
        with pytest.raises(ValueError, match=f"stages = {stages}.* 1 to {MAX_GAUSS_STAGES} stages"):
            gauss_legendre(stages)
    assert gauss_legendre(7).mu is gauss_legendre(7).mu


def test_the_decimal_context_of_the_caller_does_not_matter() -> None:
    """Five digits in the caller's context change nothing, and remain five."""

    def arrays(method: GaussTableau) -> list[object]:
        return [*method.split("mu"), *method.split("c"), *method.split("b"), method.predictor(0.3)]

    expected = gauss_legendre(5)
    gauss_legendre.cache_clear()
    with decimal.localcontext(prec=5, rounding=decimal.ROUND_UP):
        method = gauss_legendre(5)
        found = arrays(method)
        assert decimal.getcontext().prec == 5
    assert method == expected
    for x, y in zip(found, arrays(expected), strict=True):
        np.testing.assert_array_equal(x, y)


def test_a_perturbed_coefficient_is_noticed() -> None:
    """A change of 1e-40 in one pair of E leaves the method symplectic, but its rows do not sum."""
    method = gauss_legendre(3)
    with decimal.localcontext(prec=60):
        E = [list(e) for e in method.skew]
        E[0][2] += Decimal("1e-40")
        E[2][0] -= Decimal("1e-40")
    perturbed = replace(method, skew=tuple(map(tuple, E)))
    np.testing.assert_array_equal(perturbed.mu + perturbed.mu.T, 1.0)
    with pytest.raises(ValueError, match="row 1 of A does not sum"):
        _ = perturbed.tableau
