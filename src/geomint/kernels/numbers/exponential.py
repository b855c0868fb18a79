"""Exponential function, logarithm, power and hyperbolic tangent of our own: the same bits everywhere.

For all float64, subnormal ones too; plain, in lanes and in plain Python. Errors are below 0.56 units
in the last place (`exp`), 0.51 (`log`), 0.7 (`pow`) and 0.65 (`tanh`); of subnormal results below 0.8.

x = k log 2 + r with |r| ≤ ½ log 2, log 2 in two parts (W. J. Cody, W. Waite, Software Manual for the
Elementary Functions, 1980), and log m = 2 artanh((m − 1)/(m + 1)) with m in [√½, √2], to some 65 bits,
so that powers are exp(y log x) (the way of K. C. Ng's fdlibm, with fused multiply-adds in place of cut
numbers, T. J. Dekker, Numer. Math. 18 (1971) 224). Polynomials are minimax by Remez's algorithm: they
are off by 2⁻⁶⁴ and 2⁻⁷⁰.
"""

from math import inf
from typing import Any

from .arithmetic import NAN, SHIFT, exponent, fma, of_our_own, polynomial, power_of_two, select
from .double_double import divided, multiplied, summed

_LOG2, _LOG2_LOW = 0.6931471805599453, 2.3190468138462996e-17
_THIRD, _THIRD_LOW = 0.3333333333333333, 1.850371707708594e-17
# (exp r − 1 − r − r²/2)/r³ in r, (artanh(s)/s − 1 − s²/3)/s⁴ in s².
_EXP = (0.16666666666666683633, 0.041666666666666699902, 0.0083333333333168594211,
        0.0013888888888865049748, 1.9841269896817768701e-4, 2.4801587365328330806e-5,
        2.755723443918075894e-6, 2.7557238496752893005e-7, 2.5112178892950075305e-8,
        2.0925729958285772379e-9)  # fmt: skip
_ARTANH = (0.19999999999999999907, 0.14285714285714687304, 0.11111111110825664616,
           0.090909091681612047277, 0.076922974361121167807, 0.066674045976494598489,
           0.058530625369295298724, 0.058621294882312605473)  # fmt: skip


def halved(x, low):
    """Return k, r and q of ``exp(x + low) = 2^k (1 + r + q)``, |r| ≤ ½ log 2."""
    k = fma(x, 1.4426950408889634, SHIFT) - SHIFT
    head = fma(-k, _LOG2, x)  # exact
    tail = fma(-k, _LOG2_LOW, low)
    r, low = summed(head, tail)
    square, more = multiplied(r, r)
    rest = fma(square * r, polynomial(r, _EXP), fma(low, r, low))
    return k, r, fma(0.5, square, rest + 0.5 * more)


def exponential(x, low):
    """Return ``exp(x + low)`` for a small `low`."""
    x = select(x > 710.0, 710.0, select(x < -746.0, -746.0, x))
    k, r, q = halved(x, low)
    one, rest = summed(1.0, r)
    half = fma(k, 0.5, SHIFT) - SHIFT
    return (one + (rest + q)) * power_of_two(half) * power_of_two(k - half)


def of_exp(x):
    """Return exp(x)."""
    return exponential(x, 0.0)


def logarithm(x):
    """Return log |x| as a sum of two numbers."""
    x = abs(x)
    small = x < 1.0
    scaled = x * select(small, 2.0**54, 2.0**-54)  # no longer subnormal
    k = exponent(scaled)
    m = scaled * power_of_two(-k)
    high = m > 1.4142135623730951
    f = select(high, 0.5 * m, m) - 1.0
    k = k + select(high, 1.0, 0.0) + select(small, -54.0, 54.0)
    s, s_low = divided(f, 0.0, *summed(2.0, f))
    z, z_low = multiplied(s, s)
    z_low += 2.0 * s * s_low
    terms = polynomial(z, _ARTANH)
    more, more_low = multiplied(z, terms)
    w, w_low = summed(_THIRD, more)
    w_low += more_low + z_low * terms + _THIRD_LOW
    cube, cube_low = multiplied(2.0 * s, z)
    cube_low += 2.0 * (s * z_low + s_low * z)
    rest, rest_low = multiplied(cube, w)
    rest_low += cube * w_low + cube_low * w
    first, low = multiplied(k, _LOG2)
    second, more = summed(first, 2.0 * s)
    total, last = summed(second, rest)
    low = last + (low + k * _LOG2_LOW + more + (2.0 * s_low + rest_low))
    found, low = summed(total, low)
    found = select(x == 0.0, -inf, select(x == inf, inf, found))
    return found, select((x == 0.0) | (x == inf), 0.0, low)


def of_log(x):
    """Return log(x)."""
    found, _ = logarithm(x)
    return select(x < 0.0, NAN, found)


def whole(x):
    """Return a number x ≥ 0 rounded to a whole one."""
    return select(x < 2.0**52, (x + 2.0**52) - 2.0**52, x)


def of_pow(x, y):
    """Return x^y."""
    size, low = logarithm(x)
    found, more = multiplied(y, size)
    low = select(abs(found) < 800.0, more + y * low, 0.0)
    found = exponential(found, low)
    steps, half = abs(y), 0.5 * abs(y)
    odd = (whole(steps) == steps) & (whole(half) != half)
    found = select(odd & (exponent(x) > 1024.0), -found, found)
    found = select((x < 0.0) & (x > -inf) & (whole(steps) != steps), NAN, found)
    sure = (x == 1.0) | (y == 0.0) | ((x == -1.0) & (steps == inf))
    return select(sure, 1.0, found)


def of_tanh(x):
    """Return tanh(x)."""
    size = abs(x)
    k, r, q = halved(select(size > 40.0, -80.0, -2.0 * size), 0.0)
    by = power_of_two(k)
    less, missed = summed(-1.0, by)
    high, low = summed(less, by * r)
    e, low = summed(high, low + (by * q + missed))  # exp(−2|x|) − 1
    below, rest = summed(2.0, e)
    found, more = divided(e, low, below, rest + low)
    found = abs(found + more)
    return select(exponent(x) > 1024.0, -found, found)


def exp(x) -> Any:
    """Exponential function; infinite above 709.78. Errors are below 0.56 units in the last place."""
    return of_our_own(exp, of_exp, x)


def log(x) -> Any:
    """Natural logarithm; −inf at 0, NaN below. Errors are below 0.51 units in the last place."""
    return of_our_own(log, of_log, x)


def pow(x, y) -> Any:
    """Return x^y; NaN for x < 0 and y that is not whole, and 1 for y = 0, as in C99.

    Errors are below 0.7 units in the last place. The derivative by x is y x^(y − 1), at 0 as well; that
    by y is NaN where x < 0, for only whole y have powers there, and −inf at 0⁰.
    """
    return of_our_own(pow, of_pow, x, y)


def tanh(x) -> Any:
    """Hyperbolic tangent. Errors are below 0.65 units in the last place."""
    return of_our_own(tanh, of_tanh, x)
