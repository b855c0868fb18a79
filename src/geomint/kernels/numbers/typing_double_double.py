"""The numba half of double-double numbers: of one number or of a lane value of eight."""

from __future__ import annotations

import functools
import operator
from typing import Any

from numba import njit
from numba.core import cgutils, types
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.extending import intrinsic, models, overload, register_model

from ..numba_inside import default_type_manager
from . import arithmetic, circular, exponential
from .blocks import Block
from .double_double import DoubleDoubleBlock, multiplied
from .instruction import overloaded
from .typing_blocks import BlockType
from .typing_lanes import LANE_MASK, LANE_VALUE, is_plain


class DoubleDoubleType(types.Type):
    """An unevaluated sum hi + lo of two numbers of type `base`."""

    def __init__(self, base):
        self.base = base
        super().__init__(name=f"double_double({base})")

    @property
    def held(self) -> type[Block]:
        """The class of blocks of them that Python holds."""
        return DoubleDoubleBlock if self.base == types.float64 else Block

    @property
    def parts(self) -> tuple[Any, Any]:
        """The types of what a row of a block holds."""
        return self.base, self.base

    def lanes(self) -> DoubleDoubleType:
        """Return the type of eight such numbers."""
        return DoubleDoubleType(LANE_VALUE)

    def singles(self) -> DoubleDoubleType:
        """Return the type of one of eight such numbers."""
        return DoubleDoubleType(types.float64)


DD_VALUE = DoubleDoubleType(types.float64)
DD_LANE_VALUE = DoubleDoubleType(LANE_VALUE)
DD_BLOCK = BlockType(DD_VALUE)
DD_LANE_BLOCK = BlockType(DD_LANE_VALUE)


@register_model(DoubleDoubleType)
class DoubleDoubleModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, [("hi", fe_type.base), ("lo", fe_type.base)])


def _is_dd(x):
    return isinstance(x, DoubleDoubleType)


def _part(index):
    @intrinsic
    def part(typingctx, x):
        def codegen(context, builder, sig, args):
            return builder.extract_value(args[0], index)

        return x.base(x), codegen

    return part


_hi, _lo = _part(0), _part(1)


@intrinsic
def _pack(typingctx, hi, lo):
    result = DoubleDoubleType(hi)

    def codegen(context, builder, sig, args):
        packed = cgutils.create_struct_proxy(result)(context, builder)
        packed.hi, packed.lo = args
        return packed._getvalue()

    return result(hi, hi), codegen


@njit
def _two_sum(x, y):
    s = x + y
    shadow = s - x
    return s, (x - (s - shadow)) + (y - shadow)


@njit
def _renormalised(s, e):
    total = s + e
    return _pack(total, e - (total - s))


@njit
def _add(x, y):
    s, e = _two_sum(_hi(x), _hi(y))
    t, f = _two_sum(_lo(x), _lo(y))
    e += t
    total = s + e
    rest = (e - (total - s)) + f
    return _renormalised(total, rest)


@njit
def _negate(x):
    return _pack(-_hi(x), -_lo(x))


@njit
def _subtract(x, y):
    return _add(x, _negate(y))


@njit
def _multiply(x, y):
    p, e = multiplied(_hi(x), _hi(y))
    e += _hi(x) * _lo(y) + _lo(x) * _hi(y)
    return _renormalised(p, e)


@njit
def _scaled(x, factor):
    """X times a number of its base."""
    p, e = multiplied(_hi(x), factor)
    return _renormalised(p, e + _lo(x) * factor)


@njit
def _divide(x, y):
    q1 = _hi(x) / _hi(y)
    r = _subtract(x, _scaled(y, q1))
    q2 = _hi(r) / _hi(y)
    r = _subtract(r, _scaled(y, q2))
    q3 = _hi(r) / _hi(y)
    first = _renormalised(q1, q2)
    return _add(first, _pack(q3, 0.0 * q3))


@njit
def _square_root(x):
    s = arithmetic.sqrt(_hi(x))
    p, e = multiplied(s, s)
    rest = _subtract(x, _pack(p, e))
    correction = arithmetic.select(s > 0.0, (0.5 * _hi(rest)) / s, 0.0 * s)
    return _renormalised(s, correction)


_HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)
_LOG_TWO = (0.6931471805599453, 2.3190468138462996e-17, 5.707708438416212e-34)


@njit
def _nearest_integer(x):
    return (x + arithmetic.SHIFT) - arithmetic.SHIFT


@njit
def _constant(number, x):
    """Return a number as those of the kind of x."""
    return _pack(arithmetic.like(number, _hi(x)), 0.0 * _hi(x))


@njit
def _rest(x, k, parts):
    """Return x − k times a sum of numbers."""
    for part in parts:
        p, e = multiplied(-k, part + 0.0 * k)
        x = _add(x, _pack(p, e))
    return x


@njit
def _taylor(x, first, step, terms):
    """Σ x^k / ((first + 1) … (first + step k)), step 1 or 2, Horner's way."""
    total = _constant(1.0, x)
    one = total
    for back in range(terms):
        last = first + step * (terms - back)
        divisor = _constant(float(last if step == 1 else last * (last - 1)), x)
        total = _add(one, _divide(_multiply(x, total), divisor))
    return total


@njit
def _sine_of(x, shift):
    """Sine of ``x + shift π/2``, for x up to about 1e9 in size."""
    k = _nearest_integer(_hi(x) * 0.6366197723675814)
    r = _rest(x, k, _HALF_PI)
    square = _negate(_multiply(r, r))
    n = circular.rest_of(k + shift)
    sine = _multiply(r, _taylor(square, 1, 2, 14))
    odd = (n - 1.0) * (n - 3.0) == 0.0
    found = arithmetic.select(odd, _taylor(square, 0, 2, 14), sine)
    return arithmetic.select(n > 1.5, _negate(found), found)


@njit
def _absolute(x):
    return arithmetic.select(_hi(x) < 0.0, _negate(x), x)


@njit
def _tangent(x):
    return _divide(_sine_of(x, 0.0), _sine_of(x, 1.0))


@njit
def _exponential(x):
    """By ``x = k log 2 + r``, the Taylor series of E = exp(r/16) − 1, and E ↦ E (2 + E)."""
    most, least = _constant(710.0, x), _constant(-746.0, x)
    x = arithmetic.select(_hi(x) > 710.0, most, arithmetic.select(_hi(x) < -746.0, least, x))
    k = _nearest_integer(_hi(x) * 1.4426950408889634)
    r = _scaled(_rest(x, k, _LOG_TWO), arithmetic.like(0.0625, k))
    total = _multiply(r, _taylor(r, 1, 1, 18))
    for _ in range(4):
        total = _multiply(total, _add(_constant(2.0, x), total))
    half = _nearest_integer(0.5 * k)
    found = _scaled(_add(_constant(1.0, x), total), arithmetic.power_of_two(half))
    return _scaled(found, arithmetic.power_of_two(k - half))


@njit
def _logarithm(x):
    """By a step of Halley's method from the logarithm of a float64."""
    one, first = _constant(1.0, x), _pack(exponential.log(_hi(x)), 0.0 * _hi(x))
    ratio = _multiply(x, _exponential(_negate(first)))
    rest = _divide(_subtract(ratio, one), _add(ratio, one))
    return _add(first, _add(rest, rest))


@njit
def _power(x, y):
    """Signs, zeros and what is no number are those of float64."""
    rough = exponential.pow(_hi(x), _hi(y))
    found = _exponential(_multiply(y, _logarithm(_absolute(x))))
    found = arithmetic.select(rough < 0.0, _negate(found), found)
    known = (_hi(x) == 0.0) | (rough != rough)
    return arithmetic.select(known, _pack(rough, 0.0 * _hi(x)), found)


@njit
def _hyperbolic_tangent(x):
    one, e = _constant(1.0, x), _exponential(_scaled(_absolute(x), arithmetic.like(-2.0, _hi(x))))
    found = _divide(_subtract(one, e), _add(one, e))
    return arithmetic.select(_hi(x) < 0.0, _negate(found), found)


@njit
def _angle(y, x):
    """From the angle of float64, and what is left after turning by it."""
    first = _pack(circular.atan2(_hi(y), _hi(x)), 0.0 * _hi(x))
    s, c = _sine_of(first, 0.0), _sine_of(first, 1.0)
    over = _subtract(_multiply(y, c), _multiply(x, s))
    return _add(first, _divide(over, _add(_multiply(x, c), _multiply(y, s))))


def _binary(functions, implementation):
    for function in functions:

        @overload(function)
        def choose(x, y):
            if not (_is_dd(x) or _is_dd(y)):
                return None
            if x == y:
                return lambda x, y: implementation(x, y)
            if all(_is_dd(z) or is_plain(z) for z in (x, y)):
                return lambda x, y: implementation(_beside(x, y), _beside(y, x))
            return None


def _beside(value, other):
    raise NotImplementedError  # replaced by the overload below; never called uncompiled


@overload(_beside)
def _overload_beside(value, other):
    """Return a number as a double-double one, or eight where another number is eight."""
    if is_plain(value) and value != LANE_VALUE:
        return lambda value, other: _beside(_pack(float(value), 0.0), other)
    if value == LANE_VALUE:
        return lambda value, other: _pack(value, 0.0 * value)
    if _is_dd(other):
        return lambda value, other: _beside(value, _hi(other))
    if value.base == types.float64 and other == LANE_VALUE:
        return lambda value, other: _pack(
            arithmetic.like(_hi(value), other), arithmetic.like(_lo(value), other)
        )
    return lambda value, other: value


_binary([operator.add, operator.iadd], _add)
_binary([operator.sub, operator.isub], _subtract)
_binary([operator.mul, operator.imul], _multiply)
_binary([operator.truediv, operator.itruediv], _divide)


def _comparison(function):
    def compare(x, y):
        difference = _subtract(x, y)
        return function(_hi(difference), 0.0)

    # Symbols are made of it, and must differ for each comparison (`compile._unique` says why).
    compare.__qualname__ = f"{function.__name__}_of_double_doubles"
    return njit(compare)


for _function in (operator.lt, operator.le, operator.gt, operator.ge):
    _binary([_function], _comparison(_function))


_overloaded = functools.partial(overloaded, word="double_doubles", fits=lambda *x: _is_dd(x[-1]))
_overloaded(operator.neg, lambda x: _negate(x))
_overloaded(abs, lambda x: _absolute(x))
_overloaded(arithmetic.sqrt, lambda x: _square_root(x))
_overloaded(circular.sin, lambda x: _sine_of(x, 0.0))
_overloaded(circular.cos, lambda x: _sine_of(x, 1.0))
_overloaded(circular.tan, lambda x: _tangent(x))
_overloaded(exponential.exp, lambda x: _exponential(x))
_overloaded(exponential.log, lambda x: _logarithm(x))
_overloaded(exponential.tanh, lambda x: _hyperbolic_tangent(x))
_overloaded(arithmetic.like, lambda value, example: _beside(value, example))
_overloaded(arithmetic.top, lambda x: arithmetic.top(_hi(x)))
_overloaded(arithmetic.epsilon, lambda x: 4.93038065763132e-32)
_binary([exponential.pow], _power)
_binary([circular.atan2], _angle)


_overloaded(arithmetic.fma, lambda x, y, z: x * y + z, fits=lambda *x: any(map(_is_dd, x)))


@overload(arithmetic.select)
def _overload_select(condition, x, y):
    if not (_is_dd(x) and _is_dd(y)):
        return None
    if condition != LANE_MASK:
        return lambda condition, x, y: x if condition else y
    return lambda condition, x, y: _pack(
        arithmetic.select(condition, _hi(x), _hi(y)), arithmetic.select(condition, _lo(x), _lo(y))
    )


def _lane(x, index):
    return _pack(arithmetic.lane(_hi(x), index), arithmetic.lane(_lo(x), index))


_overloaded(arithmetic.lane, _lane, fits=lambda x, index: _is_dd(x))


@lower_cast(types.Number, DoubleDoubleType)
@lower_cast(LANE_VALUE, DoubleDoubleType)
@lower_cast(DoubleDoubleType, DoubleDoubleType)
def _cast(context, builder, fromty, toty, value):
    packed = cgutils.create_struct_proxy(toty)(context, builder)
    if _is_dd(fromty):
        parts = [(builder.extract_value(value, k), fromty.base) for k in range(2)]
    else:
        parts = [(value, fromty), (context.get_constant(types.float64, 0.0), types.float64)]
    packed.hi, packed.lo = (context.cast(builder, x, kind, toty.base) for x, kind in parts)
    return packed._getvalue()


default_type_manager.set_compatible(types.float64, DD_VALUE, Conversion.safe)
