"""The numba half of tangent numbers: a value and slopes, of float64 or of lane values.

Operations are machine instructions on all slopes at once: with a value of one number and slopes in
lanes, a tangent number of eight directions costs about three plain numbers. The bits are those of
`geomint.kernels.numbers.tangent`.
"""

from __future__ import annotations

import functools
import itertools
import operator
from typing import Any

from llvmlite import ir
from numba import njit
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing.templates import signature
from numba.extending import intrinsic, models, overload, register_model

from . import arithmetic
from .blocks import Block
from .instruction import instruction, overloaded, typed
from .tangent import PARTIALS, as_tangents, tangent_block, tangent_lane_block
from .typing_bases import Instructions
from .typing_blocks import BlockType, other_rows
from .typing_lanes import (
    COMPARISONS,
    LANE_MASK,
    LANE_VALUE,
    LANES,
    broadcast,
    emit_larger,
    fold_lanes,
    is_plain,
)


class TangentType(types.Type):
    """A value of type `base` and `count` slopes of type `element`.

    The base is float64 or a lane value; `element` is that too, or eight directions in a lane value
    beside a float64 value.
    """

    def __init__(self, base, element, count):
        self.base, self.element, self.count = base, element, count
        super().__init__(name=f"tangent({base}, {count} {element})")

    @property
    def parts(self) -> tuple[Any, ...]:
        """The types of what a row of a block holds, in its order."""
        return (self.base, *(self.element,) * self.count)

    def place(self, part: int) -> tuple[int, ...]:
        """Return where one of the parts is in a number."""
        return (1, part - 1) if part else (0,)

    @property
    def held(self) -> type[Block]:
        """The class of blocks of them that Python holds."""
        if self.base != self.element:
            return tangent_block(LANES * self.count)
        return (tangent_lane_block if self.base == LANE_VALUE else tangent_block)(self.count)

    @property
    def packed(self) -> bool:
        """Whether directions are in lanes."""
        return self.base != self.element

    def lanes(self) -> TangentType:
        """Return the type of eight such numbers."""
        return TangentType(LANE_VALUE, LANE_VALUE, self.count)

    def singles(self) -> TangentType:
        """Return the type of one of eight such numbers."""
        return TangentType(types.float64, types.float64, self.count)

    def can_convert_from(self, typingctx, other):
        """Let plain numbers be constants, and one number be eight alike."""
        known = isinstance(other, types.Float | types.Integer) or other == self.base
        known = known or (_is_tangent(other) and not other.packed and other.lanes() == self)
        return Conversion.safe if known else None


def tangent_numbers(directions: int) -> tuple[TangentType, BlockType]:
    """Return the types of numbers with directions in lanes, and of blocks of them."""
    number = TangentType(types.float64, LANE_VALUE, directions // LANES)
    return number, BlockType(number)


def tangent_lanes(directions: int) -> tuple[TangentType, BlockType, BlockType]:
    """Return the types of eight numbers with so many directions, of blocks of them, and of memory."""
    one = TangentType(types.float64, types.float64, directions)
    eight = one.lanes()
    return eight, BlockType(eight), BlockType(one)


@register_model(TangentType)
class TangentModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        slopes = types.UniTuple(fe_type.element, fe_type.count)
        super().__init__(dmm, fe_type, [("value", fe_type.base), ("slopes", slopes)])


def _is_tangent(x):
    return isinstance(x, TangentType)


def _is_eight(x):
    return getattr(x, "base", x) == LANE_VALUE


def _joined(*given):
    """Return the type of what numbers give, one of them a tangent one; None if they do not fit."""
    tangents = [x for x in given if _is_tangent(x)]
    if not tangents or not all(_is_tangent(x) or is_plain(x) for x in given):
        return None
    first = next((x for x in tangents if _is_eight(x)), tangents[0])
    eight = any(_is_eight(x) for x in given)
    if eight and first.packed:  # there are no eight of them
        return None
    joined = first if _is_eight(first) or not eight else first.lanes()
    fit = all(x == joined or (eight and not _is_eight(x) and x.lanes() == joined) for x in tangents)
    return joined if fit else None


class _Number:
    """An operand as one of type `to`: value, and slopes unless it is a constant."""

    def __init__(self, a, to, kind, given):
        self._a, self._to = a, to
        self.constant = not _is_tangent(kind)
        if self.constant:
            self.value = a.taken(to.base, kind, given)
            self.slopes = []
            return
        part = a.builder.extract_value
        self.value = a.taken(to.base, kind.base, part(given, 0))
        slopes = (part(given, (1, k)) for k in range(to.count))
        self.slopes = [a.taken(to.element, kind.element, slope) for slope in slopes]

    @property
    def factor(self):
        """The value, to multiply slopes with."""
        return self.beside(self.value)

    def beside(self, value):
        """Return a number of the base as one of the elements."""
        return broadcast(self._a.builder, value) if self._to.packed else value


def _operands(context, builder, to, kinds, values):
    """Return the arithmetic of a type, and operands of an operation that gives it."""
    a = Instructions(context, builder)
    return a, *(_Number(a, to, kind, value) for kind, value in zip(kinds, values, strict=True))


def _pack(a, kind, value, slopes):
    packed = cgutils.get_null_value(a.context.get_value_type(kind))
    packed = a.builder.insert_value(packed, value, 0)
    for k, slope in enumerate(slopes):
        packed = a.builder.insert_value(packed, slope, (1, k))
    return packed


def _sum(a, x, y):
    value = a.add(x.value, y.value)
    if x.constant or y.constant:
        return value, x.slopes or y.slopes
    return value, [a.add(s, u) for s, u in zip(x.slopes, y.slopes, strict=True)]


def _difference(a, x, y):
    value = a.subtract(x.value, y.value)
    if y.constant:
        return value, x.slopes
    if x.constant:
        return value, [a.negative(u) for u in y.slopes]
    return value, [a.subtract(s, u) for s, u in zip(x.slopes, y.slopes, strict=True)]


def _product(a, x, y):
    value = a.multiply(x.value, y.value)
    if x.constant or y.constant:
        number, other = (x, y) if x.constant else (y, x)
        factor = number.factor
        return value, [a.multiply(factor, s) for s in other.slopes]
    p, q = x.factor, y.factor
    pairs = zip(x.slopes, y.slopes, strict=True)
    return value, [a.fused(p, u, a.multiply(q, s)) for s, u in pairs]


def _quotient(a, x, y):
    value = a.divide(x.value, y.value)
    if y.constant:
        divisor = y.factor
        return value, [a.divide(s, divisor) for s in x.slopes]
    by = y.beside(a.reciprocal(y.value))
    times = a.negative(y.beside(value))
    if x.constant:
        return value, [a.multiply(by, a.multiply(times, u)) for u in y.slopes]
    pairs = zip(x.slopes, y.slopes, strict=True)
    return value, [a.multiply(by, a.fused(times, u, s)) for s, u in pairs]


def _register(function, result, emit):
    """Let an operator take two numbers, one of which at least is a tangent number."""

    @typed(function)
    def signature_of(*args):
        joined = _joined(*args)
        return None if joined is None else signature(result(joined), *args)

    def lower(context, builder, sig, args):
        to = _joined(*sig.args)
        assert to is not None
        return emit(to, *_operands(context, builder, to, sig.args, args))

    for pair in itertools.product((TangentType, types.Number, LANE_VALUE), repeat=2):
        if TangentType in pair:
            lower_builtin(function, *pair)(lower)


def _binary(emit):
    return lambda to, a, x, y: _pack(a, to, *emit(a, x, y))


for _functions, _emit in (
    ((operator.add, operator.iadd), _sum),
    ((operator.sub, operator.isub), _difference),
    ((operator.mul, operator.imul), _product),
    ((operator.truediv, operator.itruediv), _quotient),
):
    for _function in _functions:
        _register(_function, lambda joined: joined, _binary(_emit))


def _truth(joined):
    """Return the type of a comparison of values."""
    return LANE_MASK if joined.base == LANE_VALUE else types.boolean


def _comparison(function):
    return lambda to, a, x, y: a.compare(function, x.value, y.value)


for _function in COMPARISONS:
    _register(_function, _truth, _comparison(_function))


@lower_cast(LANE_VALUE, TangentType)
@lower_cast(types.Number, TangentType)
@lower_cast(TangentType, TangentType)
def _cast(context, builder, fromty, toty, value):
    a, number = _operands(context, builder, toty, (fromty,), (value,))
    return _pack(a, toty, number.value, number.slopes)


def _unary(function, emit):
    """Let a function take a tangent number and give one."""

    @typed(function)
    def signature_of(x):
        return signature(x, x) if _is_tangent(x) else None

    @lower_builtin(function, TangentType)
    def lower(context, builder, sig, args):
        (kind,) = sig.args
        a, x = _operands(context, builder, kind, (kind,), args)
        return _pack(a, kind, *emit(a, x))


def _size(a, x):
    negative = a.is_negative(x.value)
    value, *slopes = [a.select(negative, a.negative(p), p) for p in (x.value, *x.slopes)]
    return value, slopes


_unary(operator.neg, lambda a, x: (a.negative(x.value), [a.negative(s) for s in x.slopes]))
_unary(operator.pos, lambda a, x: (x.value, x.slopes))
_unary(abs, _size)


@typed(int)
def _type_whole(x, *base):
    one = not base and _is_tangent(x) and x.base == types.float64
    return signature(types.int64, x) if one else None


@lower_builtin(int, TangentType)
def _whole(context, builder, sig, args):
    return builder.fptosi(builder.extract_value(args[0], 0), ir.IntType(64))


@instruction(arithmetic.fma)
def _fma(typingctx, x, y, z):
    to = _joined(x, y, z)
    if to is None:
        return None

    def codegen(context, b, sig, args):
        a, p, q, r = _operands(context, b, to, sig.args, args)
        value = a.fused(p.value, q.value, r.value)
        slopes = r.slopes
        for factor, others in ((q.factor, p.slopes), (p.factor, q.slopes)):
            if slopes and others:
                pairs = zip(others, slopes, strict=True)
                slopes = [a.fused(factor, s, more) for s, more in pairs]
            elif others:
                slopes = [a.multiply(factor, s) for s in others]
        return _pack(a, to, value, slopes)

    return to(x, y, z), codegen


@instruction(arithmetic.select)
def _select(typingctx, condition, x, y):
    to = _joined(x, y)
    if to is None or (condition == LANE_MASK) != _is_eight(to):
        return None

    def codegen(context, b, sig, args):
        a, p, q = _operands(context, b, to, sig.args[1:], args[1:])
        zero = ir.Constant(context.get_value_type(to.element), None)
        s, u = p.slopes or [zero] * to.count, q.slopes or [zero] * to.count
        both = zip((p.value, *s), (q.value, *u), strict=True)
        parts = [a.select(args[0], first, second) for first, second in both]
        return _pack(a, to, parts[0], parts[1:])

    return to(condition, x, y), codegen


@instruction(arithmetic.like)
def _like(typingctx, value, example):
    to = _joined(value, example)
    if to != example:
        return None

    def codegen(context, builder, sig, args):
        a, number = _operands(context, builder, to, sig.args[:1], args[:1])
        return _pack(a, to, number.value, number.slopes)

    return to(value, example), codegen


@intrinsic
def _value(typingctx, x):
    def codegen(context, builder, sig, args):
        return builder.extract_value(args[0], 0)

    return x.base(x), codegen


@intrinsic
def _valued(typingctx, x, value):
    """Return a number with another value and the slopes that it has."""

    def codegen(context, builder, sig, args):
        return builder.insert_value(*args, 0)

    return x(x, x.base), codegen


_of_tangents = functools.partial(
    overloaded, word="tangents", fits=lambda *x: _joined(*x) is not None
)


def _elementary(function, source):
    partials = njit(error_model="numpy")(source)

    def of_one(x):
        value = arithmetic.plain(x)
        f = function(value)
        return _valued(partials(f, value)[0] * x, f)

    def of_two(x, y):
        value, other = 1.0 * arithmetic.plain(x), 1.0 * arithmetic.plain(y)
        value, other = arithmetic.like(value, other), arithmetic.like(other, value)
        f = function(value, other)
        first, second = partials(f, value, other)
        return _valued(first * x + second * y, f)

    return of_one if function.__code__.co_argcount == 1 else of_two


for _function, _partials in PARTIALS.items():
    _of_tangents(_function, _elementary(_function, _partials))
_of_tangents(arithmetic.plain, lambda x: _value(x))
_of_tangents(arithmetic.top, lambda x: arithmetic.top(_value(x)))
_of_tangents(arithmetic.epsilon, lambda x: arithmetic.epsilon(_value(x)))


@instruction(arithmetic.magnitude)
def _magnitude(typingctx, x):
    if not _is_tangent(x):
        return None

    def codegen(context, b, sig, args):
        a, number = _operands(context, b, x, (x,), args)
        found = a.absolute(number.factor)
        for slope in number.slopes:
            found = emit_larger(b, a.absolute(slope), found)
        return fold_lanes(b, emit_larger, found) if x.packed else found

    return x.base(x), codegen


@overload(arithmetic.slope_count)
def _overload_slope_count(x):
    if not _is_tangent(x):
        return None
    count = x.count * (LANES if x.packed else 1)
    return lambda x: count


@instruction(arithmetic.lane)
def _lane(typingctx, x, index):
    if not _is_tangent(x) or not _is_eight(x):
        return None
    one = x.singles()

    def codegen(context, b, sig, args):
        position = context.cast(b, args[1], sig.args[1], types.int32)
        found = cgutils.get_null_value(context.get_value_type(one))
        for place in (x.place(k) for k in range(len(x.parts))):
            part = b.extract_element(b.extract_value(args[0], place), position)
            found = b.insert_value(found, part, place)
        return found

    return one(x, index), codegen


@instruction(as_tangents, prefer_literal=True)
def _as_tangents(typingctx, block, directions):
    count = getattr(directions, "literal_value", None)
    if count is None or not isinstance(block, BlockType):
        return None
    _, result, _ = tangent_lanes(count)
    return result(block, directions), other_rows(block, result)
