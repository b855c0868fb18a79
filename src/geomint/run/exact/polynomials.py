"""Polynomials of degree 8 for a function: through nine points of each piece, many pieces at once."""

from math import comb
from typing import NamedTuple

import numpy as np

from ...arguments import Array, Booleans

DEGREE = 8
DECAY = 2.0**-6  # of the largest coefficient: are the last two larger, the polynomial says nothing
MARGIN = 2.0  # of the last two, for what is left out

PLACES = 0.5 - 0.5 * np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)
_POWERS = np.arange(DEGREE + 1)
_CHOICES = [comb(DEGREE, k) for k in _POWERS]
_POLYNOMIALS = _CHOICES * PLACES[:, None] ** _POWERS * (1.0 - PLACES[:, None]) ** _POWERS[::-1]
CHEBYSHEV = np.linalg.inv(np.cos(np.outer(np.arccos(2.0 * PLACES - 1.0), _POWERS))).T
BERNSTEIN = np.linalg.inv(_POLYNOMIALS).T


class Judged(NamedTuple):
    """The first sign of each, 1 or −1; whether there is one root; whether all that is sure."""

    first: Array
    one: Booleans
    sure: Booleans


def points_of(low: Array, high: Array) -> Array:
    """Return the times at which pieces are looked at, a piece a row, from its beginning to its end."""
    points = low[:, None] + (high - low)[:, None] * PLACES
    points[:, -1] = high
    return points


def judged(values: Array, rounding: Array) -> Judged:
    """Return how the functions change their sign that have these values, one a row.

    The ends are values, known to `rounding`; what lies between is known to what the polynomial leaves
    out. An end that is 0 is no root here: whether the sign has changed is seen by what comes after.
    """
    coefficients = np.abs(_product(values, CHEBYSHEV))
    last = np.maximum(coefficients[:, -1], coefficients[:, -2])
    clear = last <= DECAY * coefficients.max(axis=1, initial=0.0) + rounding
    tail = MARGIN * last + rounding
    bernstein = _product(values, BERNSTEIN)
    bernstein[:, 0], bernstein[:, -1] = values[:, 0], values[:, -1]
    count = len(tail)
    first, sign = np.zeros(count), np.zeros(count)  # the first that is not 0, the last so far
    doubtful = np.zeros(count, dtype=bool)
    changes = np.zeros(count, dtype=np.int64)
    for k in range(DEGREE + 1):
        inside = 0 < k < DEGREE
        b = bernstein[:, k]
        known = np.abs(b) > (tail if inside else rounding)
        here = np.sign(b)
        # What is not known between two of one sign, or before the first, may be two roots.
        clear &= ~(known & doubtful & ((here == sign) | (sign == 0.0)))
        changes += known & (sign != 0.0) & (here != sign)
        first = np.where(known & (sign == 0.0), here, first)
        sign = np.where(known, here, sign)
        doubtful = ~known & (doubtful | inside)
    clear &= (sign != 0.0) & ~doubtful & (changes <= 1)
    return Judged(first, changes == 1, clear)


def polynomial(values: Array, x: Array) -> Array:
    """Return the polynomials through values at `PLACES`, one a row, each at its x: Clenshaw's way."""
    c, s = _product(values, CHEBYSHEV), 2.0 * x - 1.0
    one, two = np.zeros(len(x)), np.zeros(len(x))
    for k in range(DEGREE, 0, -1):
        one, two = c[:, k] + 2.0 * s * one - two, one
    return c[:, 0] + s * one - two


def _product(values: Array, matrix: Array) -> Array:
    """Return values @ matrix: every row to the same bits, however many there are."""
    total = values[:, :1] * matrix[0]
    for k in range(1, len(matrix)):
        total += values[:, k : k + 1] * matrix[k]
    return total
