"""Runge-Kutta tableaux: exact order conditions over the whole registry, and what must fail."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from scipy.integrate import DOP853

import geomint as gi
from geomint.tableaux import (
    RUNGE_KUTTA,
    CommutatorFreeTableau,
    Composition,
    Tableau,
    row,
    rows,
    runge_kutta_defect,
)

METHODS = list(RUNGE_KUTTA.values())
each_method = pytest.mark.parametrize("method", METHODS, ids=attrgetter("name"))
MIDPOINT = Tableau("midpoint", 2, rows("1/2"), row("1"), row("1/2"))
TRAPEZOIDAL = Tableau("trapezoidal", 2, rows("0", "1/2 1/2"), row("1/2 1/2"), row("0 1"))


@each_method
def test_order_is_the_declared_one(method: Tableau) -> None:
    """All rooted trees up to the order are satisfied, and not all of the next size."""
    assert runge_kutta_defect(method, method.order) <= method.tolerance
    assert runge_kutta_defect(method, method.order + 1) > Fraction(1, 10**5)


@pytest.mark.parametrize("method", [m for m in METHODS if m.b_hat], ids=attrgetter("name"))
def test_embedded_order_is_the_declared_one(method: Tableau) -> None:
    """The embedded weights, one set or two, have their own orders."""
    for order, weights in ((method.order_hat, method.b_hat), (method.order_low, method.b_low)):
        if weights is not None:
            assert order is not None
            assert runge_kutta_defect(method, order, weights) <= method.tolerance
            assert runge_kutta_defect(method, order + 1, weights) > Fraction(1, 10**5)


@each_method
def test_registry_entry(method: Tableau) -> None:
    """Names agree with keys and orders, rows sum to nodes, all methods are explicit."""
    assert RUNGE_KUTTA[method.name] is method
    assert method.name == "dop853" or method.name.endswith(f"-{method.order}")
    assert method.explicit
    assert method.references
    assert method.name == "dop853" or method.tolerance == 0
    for a, c in zip(method.A, method.c, strict=True):
        assert abs(sum(a) - c) <= method.tolerance
    for k in range(1, method.order + 1):
        moment = sum(b * c ** (k - 1) for b, c in zip(method.b, method.c, strict=True))
        assert abs(moment - Fraction(1, k)) <= method.tolerance
    assert not method.symmetric
    assert not method.symplectic


@each_method
def test_binary_coefficients(method: Tableau) -> None:
    """Float64 coefficients are nearest."""
    pairs = (
        (method.A, method.A_float),
        ((method.b,), method.b_float[None]),
        ((method.c,), method.c_float[None]),
    )
    for exact, binary in pairs:
        for i, a in enumerate(exact):
            for j, x in enumerate(a):
                assert binary[i, j] == float(x)
        assert binary.dtype == np.float64
        assert binary.flags.c_contiguous
        assert not binary.flags.writeable


@each_method
def test_a_perturbed_coefficient_is_noticed(method: Tableau) -> None:
    """A change of 1e-20 in any weight, compensated in another one, breaks the order conditions."""
    change = Fraction(1, 10**20)
    for i in range(1, method.stages):
        if method.b[i] and method.c[i] != method.c[0]:
            b = (method.b[0] - change, *method.b[1:i], method.b[i] + change, *method.b[i + 1 :])
            assert runge_kutta_defect(replace(method, b=b), 2) >= abs(change * method.c[i]) / 2


@pytest.mark.parametrize("method", [m for m in METHODS if m.order >= 3], ids=attrgetter("name"))
def test_a_perturbed_stage_is_noticed(method: Tableau) -> None:
    """A change of 1e-20 in A that keeps the row sums breaks the order conditions."""
    change = Fraction(1, 10**20)
    i = max(i for i in range(method.stages) if method.b[i])
    a = method.A[i]
    changed = (a[0] - change, *a[1 : i - 1], a[i - 1] + change, *a[i:])
    broken = replace(method, A=(*method.A[:i], changed, *method.A[i + 1 :]))
    assert runge_kutta_defect(broken, method.order) > change / 10**3


def test_structure_is_derived() -> None:
    """Explicit, symmetric and symplectic follow from the coefficients, and which stages are used."""
    assert MIDPOINT.symmetric
    assert MIDPOINT.symplectic
    assert not MIDPOINT.explicit
    assert TRAPEZOIDAL.symmetric
    assert not TRAPEZOIDAL.symplectic
    assert runge_kutta_defect(TRAPEZOIDAL, 2) == 0
    assert TRAPEZOIDAL.first_same_as_last
    last = {name for name, method in RUNGE_KUTTA.items() if method.first_same_as_last}
    assert last >= {"dormand-prince-5", "bogacki-shampine-3"}
    assert not last & {"rk-4", "kutta-3", "heun-2"}
    for name, used in (("dormand-prince-5", 6), ("rk-4", 4), ("dop853", 12)):
        assert RUNGE_KUTTA[name].used_stages == used


def test_error_weights() -> None:
    """Differences of two sets of weights; those of another implementation."""
    found = RUNGE_KUTTA["bogacki-shampine-3"].error_float
    np.testing.assert_array_equal(found, [-5 / 72, 1 / 12, 1 / 9, -1 / 8])
    assert RUNGE_KUTTA["rk-4"].error_float is None
    estimates = {name: table.estimate_order for name, table in RUNGE_KUTTA.items()}
    known = {"bogacki-shampine-3": 3, "dormand-prince-5": 5, "dop853": 8}
    assert {name: order for name, order in estimates.items() if order} == known
    found = RUNGE_KUTTA["dop853"].error_float
    for part, expected in ((found[:12], DOP853.E5), (found[12:], DOP853.E3)):
        np.testing.assert_allclose(part, expected[:12], rtol=0, atol=1e-15)
        assert abs(sum(part)) < 1e-15


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"A": rows("", "1", "")}, "A must be 2 x 2"),
        ({"A": rows("1/2", "1/2")}, "row 1 of A does not sum"),
        ({"b": row("1/2 1/3")}, "b does not sum to 1"),
        ({"b": row("1/2 1/2 0")}, "of length 3"),
        ({"c": row("0")}, "of length 2"),
        ({"b_hat": row("1 0")}, "go together"),
        ({"b_hat": row("1 1"), "order_hat": 1}, "b_hat does not sum to 1"),
        ({"b_hat": row("1 0"), "order_hat": 1, "b_low": row("0 1")}, "b_low and order_low go"),
        ({"b_low": row("1 0"), "order_low": 1}, "b_low comes beside b_hat"),
    ],
)
def test_construction_is_validated(change: dict[str, object], message: str) -> None:
    """Wrong shapes and wrong sums are refused by name."""
    with pytest.raises(ValueError, match=f"heun-2: .*{message}"):
        replace(RUNGE_KUTTA["heun-2"], **change)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"A": None}, gi.ArgumentError),
        ({"b": 1}, gi.ArgumentError),
        ({"b": (0.5, 0.5)}, gi.ArgumentError),
        ({"tolerance": "none"}, gi.ArgumentError),
        ({"order": "two"}, gi.MethodError),
        ({"b": row("1/2 1/3")}, gi.MethodError),
    ],
)
def test_what_is_no_tableau_is_typed(change: dict[str, Any], kind: type[Exception]) -> None:
    """Of whatever kind the values are; of compositions and flows too."""
    with pytest.raises(kind):
        replace(RUNGE_KUTTA["heun-2"], **change)
    for wrong in (None, ("a",), ("0",)):
        with pytest.raises(gi.GeomintError):
            Composition("mine", 4, 2, wrong)  # type: ignore[arg-type]
        with pytest.raises(gi.GeomintError):
            CommutatorFreeTableau("mine", 2, wrong, wrong)  # type: ignore[arg-type]
    for text in (3, "a", "1/0"):
        with pytest.raises(gi.DomainError, match=r"coefficients = .* rationals"):
            row(text)  # type: ignore[arg-type]


def test_text_is_read_exactly() -> None:
    """Decimals and rationals keep every digit."""
    assert row("1/3 -0.1 2e-3") == (Fraction(1, 3), Fraction(-1, 10), Fraction(1, 500))
    assert rows("", "1") == (row("0 0"), row("1 0"))
