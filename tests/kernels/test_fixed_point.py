"""The stop rule of implicit iterations, case by case."""

from __future__ import annotations

import numpy as np
import pytest

from geomint.kernels.numbers.lanes import Lanes
from geomint.kernels.solve.fixed_point import (
    BEGINNING,
    kept_up,
    larger,
    rounding_left,
    solved,
    solved_by_newton,
)

pytestmark = pytest.mark.nojit
EPSILON = 2.0**-52
CASES = {
    # change, the last, the one before, tolerance, is it the last allowed: is it solved?
    "nothing changed": (0.0, BEGINNING, BEGINNING, 0.0, False, True),
    "the first change, however small": (EPSILON, BEGINNING, BEGINNING, 1e-3, False, False),
    "still falling": (EPSILON, 3 * EPSILON, 1e-14, 0.0, False, False),
    "falls no further": (3 * EPSILON, 3 * EPSILON, 1e-14, 0.0, False, True),
    "rounding goes up and down": (9 * EPSILON, 3 * EPSILON, 1e-14, 0.0, False, True),
    "no rounding": (40 * EPSILON, 40 * EPSILON, 1e-13, 0.0, False, False),
    "falling at the cap": (EPSILON, 3 * EPSILON, 1e-14, 0.0, True, True),
    "far at the cap": (1e-13, 1e-12, 1e-11, 0.0, True, False),
    "below a tolerance": (1e-8, 1e-6, 1e-4, 1e-9, False, True),
    "above a tolerance": (1e-8, 1e-6, 1e-4, 1e-11, False, False),
    "one contraction only": (1e-12, 1.0, BEGINNING, 1e-9, False, False),
    "a contraction that was no better before": (1e-12, 1.0, 1.0, 1e-13, False, False),
    "too coarse for contractions to tell": (1e-5, 1e-1, 1e3, 1e-3, False, False),
}


@pytest.mark.parametrize("case", CASES)
def test_when_an_iteration_has_ended(case: str) -> None:
    change, last, before, tolerance, final, expected = CASES[case]
    rounding = rounding_left(change, 1.0)
    assert bool(solved(change, last, before, tolerance, rounding, final)) is expected
    lanes = [Lanes(np.full(8, x)) for x in (change, last, before)]
    found = solved(*lanes, tolerance, rounding_left(lanes[0], lanes[0]), final)
    assert found.tolist() == [expected] * 8


def test_what_rounding_keeps_up() -> None:
    """As large as halfway to the cap; not what still contracts, nor what is no rounding."""
    for change, halfway, expected in (
        (3e-14, 5e-14, True),
        (5e-14, 3e-14, True),
        (1e-14, 1e-12, False),
        (1e-10, 1e-10, False),
        (1e-14, BEGINNING, False),
    ):
        assert kept_up(change, halfway) is expected


def test_when_newton_has_ended() -> None:
    """Below the tolerance or rounding; or where what no longer falls can be rounding."""
    for change, last, tolerance, expected in (
        (EPSILON, 1e-9, 0.0, True),
        (1e-9, 1e-4, 1e-8, True),
        (1e-9, 1e-4, 0.0, False),
        (1e-13, 1e-14, 0.0, True),
        (2.0**-39, 2.0**-40, 0.0, False),
    ):
        assert bool(solved_by_newton(np.float64(change), last, tolerance)) is expected


def test_the_size_of_a_piece() -> None:
    """The largest of its numbers and of their increments."""
    assert larger([1.0, -2.0], [0.5, 7.0], 2) == 7.0
    assert larger([1.0, -9.0], [0.5, 7.0], 2) == 9.0
    assert larger([1.0, -2.0], [-5.0, 7.0], 1) == 5.0
