"""Symmetric compositions: every order condition, palindromes to the bit."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from operator import attrgetter

import mpmath as mp
import numpy as np
import pytest

from geomint.tableaux import (
    COMPOSITIONS,
    DEFAULT_COMPOSITION,
    Composition,
    composition_defect,
    default_composition,
)

METHODS = list(COMPOSITIONS.values())
each_method = pytest.mark.parametrize("method", METHODS, ids=attrgetter("name"))

DIGITS = {  # decimals behind the point, where not 50
    **{"yoshida-6": 49, "kahan-li-6": 26, "kahan-li-8": 26},
    **{f"sofroniou-spaletta-{order}": 32 for order in (6, 8, 10)},
}
STAGES = {
    **{"triple-jump": 3, "suzuki": 5, "yoshida-6": 7, "kahan-li-6": 9, "kahan-li-8": 17},
    **{"sofroniou-spaletta-6": 13, "sofroniou-spaletta-8": 21, "sofroniou-spaletta-10": 35},
}


def digits(method: Composition) -> int:
    return DIGITS.get(method.name, 50)


def rounding(method: Composition) -> Fraction:
    """Largest defect that the rounding of the published digits explains."""
    return Fraction(32, 10 ** digits(method))


@each_method
def test_order_is_the_declared_one(method: Composition) -> None:
    """All words up to the order agree with the exact flow, and not all of the next weight."""
    assert composition_defect(method, method.order) < rounding(method)
    assert composition_defect(method, method.order + 1) > Fraction(1, 10**6)
    gamma = method.gamma_exact
    assert sum(gamma) == 1
    for k in range(method.base_order + 1, method.order, 2):
        assert abs(sum((x**k for x in gamma), Fraction(0))) < rounding(method)


@each_method
def test_registry_entry(method: Composition) -> None:
    """Names agree with keys and orders, digits and stages with what the sources give."""
    assert COMPOSITIONS[method.name] is method
    assert method.name.endswith(f"-{method.order}")
    assert method.base_order == 2 or method.base_order == method.order - 2
    assert method.references
    family = method.name.removesuffix(f"-{method.order}")
    assert method.stages == STAGES.get(method.name, STAGES.get(family))
    assert min(len(text.partition(".")[2]) for text in method.fractions) == digits(method)


@each_method
def test_binary_coefficients(method: Composition) -> None:
    """Palindromes bit by bit, nearest to the exact fractions; starts are not sums of rounded."""
    gamma = method.gamma
    assert gamma.shape == method.starts.shape == (method.stages,)
    np.testing.assert_array_equal(gamma, gamma[::-1])
    start = Fraction(0)
    for i, x in enumerate(method.gamma_exact):
        assert gamma[i] == float(x)
        assert method.starts[i] == float(start)
        start += x
    assert start == 1
    assert not gamma.flags.writeable


def test_methods_without_freedom_to_all_digits() -> None:
    """Closed forms; solution A of order 6 by Newton's method on its conditions."""
    with mp.workdps(60):
        for order in (4, 6, 8, 10):
            root = mp.mpf(1) / (order - 1)
            triple, suzuki = 1 / (2 - mp.mpf(2) ** root), 1 / (4 - mp.mpf(4) ** root)
            for name, value in (("triple-jump", triple), ("suzuki", suzuki)):
                given = mp.mpf(COMPOSITIONS[f"{name}-{order}"].fractions[0])
                assert abs(given - value) < mp.mpf(10) ** -49

        def conditions(*half: mp.mpf) -> list[mp.mpf]:
            gamma = [*half, 1 - 2 * mp.fsum(half), *reversed(half)]
            w_1 = w_11 = w_113 = mp.mpf(0)  # coefficients of the words X_1, X_1 X_1, X_1 X_1 X_3
            for g in gamma:
                w_113 += w_11 * g**3 + w_1 * g**4 / 2 + g**5 / 6
                w_11 += w_1 * g + g**2 / 2
                w_1 += g
            return [mp.fsum(g**3 for g in gamma), mp.fsum(g**5 for g in gamma), w_113]

        start = [mp.mpf(text[:12]) for text in COMPOSITIONS["yoshida-6"].fractions]
        found = mp.findroot(conditions, start)
        for value, text in zip(found, COMPOSITIONS["yoshida-6"].fractions, strict=True):
            assert abs(value - mp.mpf(text)) < mp.mpf(10) ** -48


@pytest.mark.parametrize(
    "method",
    [pytest.param(m, marks=[pytest.mark.nightly] * (m.order > 6), id=m.name) for m in METHODS],
)
def test_a_perturbed_digit_is_noticed(method: Composition) -> None:
    """A change of 1e-20 in any fraction breaks the order conditions."""
    for i, text in enumerate(method.fractions):
        at = text.index(".") + 20
        changed = text[:at] + str((int(text[at]) + 1) % 10) + text[at + 1 :]
        fractions = (*method.fractions[:i], changed, *method.fractions[i + 1 :])
        broken = replace(method, fractions=fractions)
        assert sum(broken.gamma_exact) == 1
        assert composition_defect(broken, method.order) > Fraction(1, 10**24)


def test_defaults_of_other_bases() -> None:
    """Made for the base where there is one, else that of order 2; none beyond order 10."""
    assert default_composition(2, 4) is COMPOSITIONS["suzuki-4"]
    assert default_composition(4, 6) is COMPOSITIONS["suzuki-6"]
    assert default_composition(4, 8) is COMPOSITIONS["sofroniou-spaletta-8"]
    assert default_composition(2, 12) is None
    assert set(DEFAULT_COMPOSITION) == {method.order for method in METHODS}
    for order, name in DEFAULT_COMPOSITION.items():
        assert COMPOSITIONS[name].order == order
    lowered = replace(COMPOSITIONS["suzuki-6"], base_order=2)
    assert composition_defect(lowered, 4) > Fraction(1, 100)


@pytest.mark.parametrize(
    "change",
    [{"order": 5}, {"base_order": 3}, {"order": 2}, {"fractions": ()}, {"fractions": ("0.5",)}],
)
def test_construction_is_validated(change: dict[str, object]) -> None:
    """Odd orders, orders that are not raised and vanishing fractions are refused."""
    with pytest.raises(ValueError, match="suzuki-4: "):
        replace(COMPOSITIONS["suzuki-4"], **change)  # type: ignore[arg-type]
