"""Sine, cosine, tangent and angles of our own: the same bits for float64, lanes and plain Python.

Sine, cosine and tangent are within 0.8 units in the last place (0.52 are the C library's), `atan2`
within 0.6. A sine costs what the C library's costs, and a sixth of that in lanes.
Arguments of sine, cosine and tangent beyond `FAR` are left to the C library.

With k the nearest whole number to 2x/π and π/2 in three parts, ``x − k π/2`` is found to 32 digits
(W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980); on |r| ≤ π/4 the
polynomials are those of K. C. Ng's fdlibm, with what r lacks of its last digits as a first-order term.
An angle is that of the nearest of 0, ½ and 1 to the smaller over the larger of two numbers, and a rest
|t| < ¼ as a sum of two numbers, with the minimax polynomial of Remez's algorithm, off by 2⁻⁶¹.
"""

import math
from typing import Any

from .arithmetic import SHIFT, exponent, fma, of_our_own, polynomial, select
from .double_double import divided, summed

FAR = 2.0**30
# π/2 as a sum, each part rounded to nearest.
_FIRST, _SECOND, _THIRD = 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33
# (arctan(t)/t − 1)/t² in t², and arctan ½.
_ARCTAN = (-0.33333333333333332933, 0.19999999999998955722, -0.14285714285265867583,
           0.11111111036923223602, -0.0909090293352183736, 0.076920198658146427407,
           -0.066587248329205641671, 0.057533610436666716296, -0.04104886341456972429)  # fmt: skip
_HALF, _HALF_LOW = 0.4636476090008061, 2.2698777452961687e-17


def quarter(x):
    """Return k, sin r and cos r, each a sum of two numbers, of ``x = k π/2 + r`` up to `FAR`."""
    k = fma(x, 0.6366197723675814, SHIFT) - SHIFT
    head = fma(-k, _FIRST, x)  # exact
    tail = k * _SECOND
    r = head - tail
    low = ((head - r) - tail) - fma(k, _SECOND, -tail) - k * _THIRD
    s = r * r
    q = s * s
    odd = fma(s, -1.98412698298579493134e-04, 8.33333333332248946124e-03)
    high = fma(s, -2.50507602534068634195e-08, 2.75573137070700676789e-06)
    odd += q * fma(q, 1.58969099521155010221e-10, high)
    cube = s * r
    rest = s * fma(-cube, odd, 0.5 * low) - low
    rest += cube * 1.66666666666666324348e-01
    high = fma(s, -1.13596475577881948265e-11, 2.08757232129817482790e-09)
    high = fma(s, -2.75573143513906633035e-07, 2.48015872894767294178e-05) + q * high
    even = s * (fma(s, -1.38888888888741095749e-03, 4.16666666666666019037e-02) + q * high)
    half = 0.5 * s
    first = 1.0 - half
    cosine, cosine_low = summed(first, ((1.0 - first) - half) + fma(s, even, -(r * low)))
    sine, sine_low = summed(r, -rest)
    missed = fma(r, r, -s)  # of the square: sine and cosine alone do without
    sine_low -= (fma(s, r, -cube) + r * missed) * 1.66666666666666324348e-01
    return k, sine, sine_low, cosine, cosine_low - 0.5 * missed


def rest_of(k):
    """Return the rest of a whole number by 4: 0, 1, 2 or 3."""
    return k - 4.0 * ((fma(k, 0.25, -0.375) + SHIFT) - SHIFT)


def turned(x, quarters: float):
    """Return ``sin(x + quarters π/2)`` for whole quarters."""
    k, sine, _, cosine, _ = quarter(x)
    n = rest_of(k + quarters)
    found = select((n - 1.0) * (n - 3.0) == 0.0, cosine, sine)
    return select(n > 1.5, -found, found)


def of_sin(x):
    """Return sin(x)."""
    return turned(x, 0.0)


def of_cos(x):
    """Return cos(x)."""
    return turned(x, 1.0)


def of_tan(x):
    """Return tan(x)."""
    k, sine, sine_low, cosine, cosine_low = quarter(x)
    n = rest_of(k)
    odd = (n - 1.0) * (n - 3.0) == 0.0
    over, over_low = select(odd, -cosine, sine), select(odd, -cosine_low, sine_low)
    below, below_low = select(odd, sine, cosine), select(odd, sine_low, cosine_low)
    found, low = divided(over, over_low, below, below_low)
    return select(x == 0.0, x, found + low)


def of_atan2(y, x):
    """Return the angle of (x, y) from the first axis."""
    height, width = abs(y), abs(x)
    steep = height > width
    n, d = select(steep, width, height), select(steep, height, width)
    scale = select(d < 2.0**-400, 2.0**600, select(d > 2.0**1000, 2.0**-100, 1.0))
    endless = d == math.inf
    n = select(endless, select(n == math.inf, 1.0, 0.0 * n), n * scale)
    d = select(endless | (d == 0.0), 1.0, d * scale)
    c = select(n < 0.25 * d, 0.0, select(n < 0.75 * d, 0.5, 1.0))
    t, t_low = divided(n - c * d, 0.0, *summed(d, c * n))  # the difference is exact
    t_low = select(abs(t) < 2.0**-500, 0.0, t_low)
    t_low = fma(t * (t * t), polynomial(t * t, _ARCTAN), t_low)
    left = exponent(x) > 1024.0
    quarters = select(steep, 1.0, select(left, 2.0, 0.0))
    sign = select(left, -1.0, 1.0)
    sign = select(steep, -sign, sign)
    known = select(c == 0.0, 0.0, select(c == 0.5, _HALF, 0.5 * _FIRST))
    known_low = select(c == 0.0, 0.0, select(c == 0.5, _HALF_LOW, 0.5 * _SECOND))
    first, low = summed(quarters * _FIRST, sign * known)
    second, more = summed(first, sign * t)
    found = second + (low + more + (quarters * _SECOND + sign * (known_low + t_low)))
    return select(exponent(y) > 1024.0, -found, found)


def sin(x) -> Any:
    """Sine; NaN of what is not finite."""
    return of_our_own(sin, of_sin, x, library=math.sin, far=FAR)


def cos(x) -> Any:
    """Cosine; NaN of what is not finite."""
    return of_our_own(cos, of_cos, x, library=math.cos, far=FAR)


def tan(x) -> Any:
    """Tangent; NaN of what is not finite. Errors are below 0.8 units in the last place."""
    return of_our_own(tan, of_tan, x, library=math.tan, far=FAR)


def atan2(y, x) -> Any:
    """Angle of the point (x, y) from the first axis, from −π to π, with C99's signs of zeros.

    Errors are below 0.6 units in the last place. Its derivatives x/(x² + y²) and −y/(x² + y²) are right
    for lengths of any size, and NaN at the origin. arctan x is ``atan2(x, 1.0)``, arcsin x
    ``atan2(x, sqrt((1.0 - x) * (1.0 + x)))``.
    """
    return of_our_own(atan2, of_atan2, y, x)
