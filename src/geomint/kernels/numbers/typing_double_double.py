"""The numba half of double-double numbers: of one number or of a lane value of eight."""

from __future__ import annotations

import operator
from typing import Any

from numba import njit
from numba.core import cgutils, types
from numba.core.imputils import lower_cast
from numba.core.typeconv import Conversion
from numba.core.typeconv.rules import default_type_manager
from numba.extending import (
    intrinsic,
    models,
    overload,
    register_model,
)

from . import arithmetic
from .double_double import DoubleDoubleBlock
from .typing_blocks import BlockType
from .typing_lanes import LANE_MASK, LANE_VALUE

__all__ = ["DD_BLOCK", "DD_LANE_BLOCK", "DD_LANE_VALUE", "DD_VALUE"]


class DoubleDoubleType(types.Type):
    """An unevaluated sum hi + lo of two numbers of type `base`."""

    def __init__(self, base: Any) -> None:
        self.base = base
        super().__init__(name=f"double_double({base})")

    def lanes(self) -> DoubleDoubleType:
        """Return the type of eight such numbers."""
        return DoubleDoubleType(LANE_VALUE)


DD_VALUE = DoubleDoubleType(types.float64)
DD_LANE_VALUE = DoubleDoubleType(LANE_VALUE)
DD_BLOCK = BlockType(DD_VALUE, held=DoubleDoubleBlock)
DD_LANE_BLOCK = BlockType(DD_LANE_VALUE)


@register_model(DoubleDoubleType)
class DoubleDoubleModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: DoubleDoubleType) -> None:
        super().__init__(dmm, fe_type, [("hi", fe_type.base), ("lo", fe_type.base)])


def _is_dd(x: Any) -> bool:
    return isinstance(x, DoubleDoubleType)


def _is_number(x: Any) -> bool:
    return isinstance(x, types.Float | types.Integer)


@intrinsic
def _hi(typingctx, x):
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_value(args[0], 0)

    return x.base(x), codegen


@intrinsic
def _lo(typingctx, x):
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_value(args[0], 1)

    return x.base(x), codegen


@intrinsic
def _pack(typingctx, hi, lo):
    result = DoubleDoubleType(hi)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
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
def _two_product(x, y):
    p = x * y
    return p, arithmetic.fma(x, y, -p)


@njit
def _add(x, y):
    s, e = _two_sum(_hi(x), _hi(y))
    t, f = _two_sum(_lo(x), _lo(y))
    e = e + t
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
    p, e = _two_product(_hi(x), _hi(y))
    e = e + (_hi(x) * _lo(y) + _lo(x) * _hi(y))
    return _renormalised(p, e)


@njit
def _scaled(x, factor):
    """X times a number of its base."""
    p, e = _two_product(_hi(x), factor)
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
    p, e = _two_product(s, s)
    rest = _subtract(x, _pack(p, e))
    correction = arithmetic.select(s > 0.0, (0.5 * _hi(rest)) / s, 0.0 * s)
    return _renormalised(s, correction)


_HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)
_TERMS = 14


@njit
def _nearest_integer(x):
    shifter = 6755399441055744.0  # 1.5 · 2⁵²: adding it rounds to an integer
    return (x + shifter) - shifter


@njit
def _taylor(r2, first):
    """Σ (−r²)^k / ((first + 1) … (first + 2k)), Horner's way."""
    total = _pack(1.0 + 0.0 * _hi(r2), 0.0 * _hi(r2))
    one = total
    for back in range(_TERMS):
        k = _TERMS - back
        divisor = float((first + 2 * k - 1) * (first + 2 * k))
        term = _multiply(r2, total)
        quotient = _divide(term, _pack(divisor + 0.0 * _hi(r2), 0.0 * _hi(r2)))
        total = _subtract(one, quotient)
    return total


@njit
def _sine_of(x, shift):
    """Sine of ``x + shift π/2``, for x up to about 1e9 in size."""
    k = _nearest_integer(_hi(x) * 0.6366197723675814)
    r = x
    for part in _HALF_PI:
        p, e = _two_product(-k, part + 0.0 * k)
        r = _add(r, _pack(p, e))
    r2 = _multiply(r, r)
    sine = _multiply(r, _taylor(r2, 1))
    cosine = _taylor(r2, 0)
    quadrant = k + shift
    quadrant = quadrant - 4.0 * _nearest_integer(quadrant * 0.25 - 0.375)
    odd = (quadrant - 1.0) * (quadrant - 3.0) * (quadrant + 1.0) == 0.0
    hi = arithmetic.select(odd, _hi(cosine), _hi(sine))
    lo = arithmetic.select(odd, _lo(cosine), _lo(sine))
    flip = (quadrant - 2.0) * (quadrant - 3.0) * (quadrant + 1.0) == 0.0
    return _pack(arithmetic.select(flip, -hi, hi), arithmetic.select(flip, -lo, lo))


def _binary(functions: list[Any], implementation: Any) -> None:
    for function in functions:

        @overload(function)
        def choose(x, y):
            if not (_is_dd(x) or _is_dd(y)):
                return None
            if _is_dd(x) and _is_dd(y) and x == y:
                return lambda x, y: implementation(x, y)
            if _is_dd(x) and _is_dd(y):  # one number against eight
                return lambda x, y: implementation(_widened(x, y), _widened(y, x))
            if _is_dd(x) and (_is_number(y) or y == LANE_VALUE):
                return lambda x, y: implementation(_widened(x, y), _promoted(y, x))
            if _is_dd(y) and (_is_number(x) or x == LANE_VALUE):
                return lambda x, y: implementation(_promoted(x, y), _widened(y, x))
            return None


def _promoted(value: Any, example: Any) -> Any:
    raise NotImplementedError  # replaced by the overload below; never called uncompiled


def _widened(value: Any, other: Any) -> Any:
    raise NotImplementedError  # replaced by the overload below; never called uncompiled


@overload(_promoted)
def _overload_promoted(value, example):
    if value == LANE_VALUE or example.base == types.float64:
        if value == LANE_VALUE:
            return lambda value, example: _pack(value, 0.0 * value)
        return lambda value, example: _pack(float(value), 0.0)
    return lambda value, example: _pack(
        arithmetic.like(float(value), _hi(example)), 0.0 * _hi(example)
    )


@overload(_widened)
def _overload_widened(value, other):
    lanes = other == LANE_VALUE or (_is_dd(other) and other.base == LANE_VALUE)
    if value.base == types.float64 and lanes:
        if _is_dd(other):
            return lambda value, other: _pack(
                arithmetic.like(_hi(value), _hi(other)), arithmetic.like(_lo(value), _hi(other))
            )
        return lambda value, other: _pack(
            arithmetic.like(_hi(value), other), arithmetic.like(_lo(value), other)
        )
    return lambda value, other: value


_binary([operator.add, operator.iadd], _add)
_binary([operator.sub, operator.isub], _subtract)
_binary([operator.mul, operator.imul], _multiply)
_binary([operator.truediv, operator.itruediv], _divide)


def _comparison(function: Any) -> Any:
    def compare(x, y):
        difference = _subtract(x, y)
        return function(_hi(difference), 0.0)

    # Symbols are made of it, and must differ for each comparison (`compile._unique` says why).
    compare.__qualname__ = f"{function.__name__}_of_double_doubles"
    return njit(compare)


for _function in (operator.lt, operator.le, operator.gt, operator.ge):
    _binary([_function], _comparison(_function))


@overload(operator.neg)
def _overload_negate(x):
    return (lambda x: _negate(x)) if _is_dd(x) else None


@overload(abs)
def _overload_abs(x):
    if not _is_dd(x):
        return None

    def positive(x):
        negative = _hi(x) < 0.0
        return _pack(
            arithmetic.select(negative, -_hi(x), _hi(x)),
            arithmetic.select(negative, -_lo(x), _lo(x)),
        )

    return positive


@overload(arithmetic.sqrt)
def _overload_sqrt(x):
    return (lambda x: _square_root(x)) if _is_dd(x) else None


@overload(arithmetic.sin)
def _overload_sin(x):
    return (lambda x: _sine_of(x, 0.0)) if _is_dd(x) else None


@overload(arithmetic.cos)
def _overload_cos(x):
    return (lambda x: _sine_of(x, 1.0)) if _is_dd(x) else None


@overload(arithmetic.fma)
def _overload_fma(x, y, z):
    return (lambda x, y, z: x * y + z) if _is_dd(x) or _is_dd(y) or _is_dd(z) else None


@overload(arithmetic.select)
def _overload_select(condition, x, y):
    if not (_is_dd(x) and _is_dd(y)):
        return None
    if condition != LANE_MASK:
        return lambda condition, x, y: x if condition else y
    return lambda condition, x, y: _pack(
        arithmetic.select(condition, _hi(x), _hi(y)), arithmetic.select(condition, _lo(x), _lo(y))
    )


@overload(arithmetic.like)
def _overload_like(value, example):
    if not _is_dd(example):
        return None
    if _is_dd(value):
        return lambda value, example: _widened(value, example)
    return lambda value, example: _promoted(value, example)


@overload(arithmetic.lane)
def _overload_lane(x, index):
    if not _is_dd(x):
        return None
    return lambda x, index: _pack(arithmetic.lane(_hi(x), index), arithmetic.lane(_lo(x), index))


@overload(arithmetic.top)
def _overload_top(x):
    return (lambda x: arithmetic.top(_hi(x))) if _is_dd(x) else None


@overload(arithmetic.epsilon)
def _overload_epsilon(x):
    return (lambda x: 4.93038065763132e-32) if _is_dd(x) else None


@lower_cast(types.float64, DoubleDoubleType)
def _cast_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    packed = cgutils.create_struct_proxy(toty)(context, builder)
    packed.hi, packed.lo = value, context.get_constant(types.float64, 0.0)
    return packed._getvalue()


default_type_manager.set_compatible(types.float64, DD_VALUE, Conversion.safe)
