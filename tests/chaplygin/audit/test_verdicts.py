"""The rule that makes verdicts of residuals."""

from __future__ import annotations

import numpy as np
import pytest

from tests.paper.claim import FAILS, HOLDS, Claim, Section, evaluate, residual
from tests.paper.points import sample

POINTS = [sample(n, 0) for n in (2, 3)]


def verdict_of(check, n=range(2, 8), **options):
    section = Section("test")
    section("label", "statement", "1", n=n, **options)(check)
    return evaluate(section.claims[0], POINTS).verdict


def on_manifold(point):
    return abs(point.gamma @ point.gamma - 1.0) < 1e-12


def equal(point, amended=True):
    return 1.0, 1.0


def different(point, amended=False):
    return 1.0, 2.0


def corrected(point, amended):
    return 1.0, 1.0 if amended else 2.0


def tangent_only(point, amended=False):
    return 1.0, 1.0 if amended or on_manifold(point) else 2.0


@pytest.mark.parametrize(
    ("check", "options", "verdict"),
    [
        (equal, {}, "holds"),
        (equal, {"everywhere": True}, "holds"),
        (tangent_only, {}, "holds"),
        (tangent_only, {"everywhere": True}, "holds on the manifold only"),
        (tangent_only, {"everywhere": True, "off_manifold": "…"}, "holds on the manifold only"),
        (corrected, {"misprint": "…"}, "misprint"),
        (corrected, {"restriction": "…"}, "needs a restriction"),
        (different, {"negative": True}, "holds"),
        (different, {}, "unexplained"),
        (different, {"misprint": "also wrong"}, "unexplained"),
        (equal, {"misprint": "of something right"}, "unexplained"),
        (equal, {"negative": True}, "unexplained"),
        (tangent_only, {"everywhere": True, "misprint": "…"}, "unexplained"),
        (corrected, {"everywhere": True, "off_manifold": "…"}, "unexplained"),
    ],
)
def test_rule(check, options, verdict):
    assert verdict_of(check, **options) == verdict


@pytest.mark.parametrize("size", [2 * HOLDS, 0.5 * FAILS])
def test_between_the_thresholds_nothing_is_decided(size):
    assert verdict_of(lambda point: (1.0, 1.0 + size)) == "unexplained"
    assert verdict_of(lambda point, amended: (1.0, 1.0 + size), misprint="…") == "unexplained"


def test_one_point_that_fails_is_enough():
    assert verdict_of(lambda point: (1.0, 1.0 if point.n == 2 else 2.0)) == "unexplained"


def test_not_a_number_never_holds():
    assert residual((np.nan, 1.0)) == np.inf
    assert residual((1.0, [1.0, np.inf])) == np.inf
    assert verdict_of(lambda point: (np.nan, np.nan)) == "unexplained"


def test_residuals_are_relative():
    assert residual((2.0, 1.0)) == 0.5
    assert residual(([0.0, 1.0], [1e-3, 1.0])) == 1e-3
    assert residual((1e-9, 0.0)) == pytest.approx(1e-6)  # the least size is 1e-3
    assert residual((1e-5, 0.0, 10.0)) == pytest.approx(1e-6)
    assert residual((0.0, 0.0)) == 0.0


def test_a_definition_is_not_evaluated():
    claim = Claim("label", "statement", reason="definition")
    result = evaluate(claim, POINTS)
    assert (result.verdict, result.residual) == ("not checkable numerically", None)
    assert result.reason == "definition"


def test_a_claim_about_other_dimensions_says_so():
    section = Section("test")
    section("label", "statement", "1", n=(7,))(equal)
    result = evaluate(section.claims[0], POINTS)
    assert result.verdict == "not checkable numerically"
    assert result.reason == "speaks of n = 7 only"
