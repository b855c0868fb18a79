"""The numba half of tangent numbers: a value and slopes, of float64 or of lane values.

Operations are machine instructions on all slopes at once: with a value of one number and slopes in
lanes, a tangent number of eight directions costs about three plain numbers. The bits are those of
`geomint.kernels.numbers.tangent`.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, models, overload, register_model

from . import arithmetic, circular
from .instruction import instruction
from .tangent import as_tangents, tangent_block, tangent_lane_block
from .typing_blocks import BlockType, other_rows
from .typing_lanes import (
    LANE_MASK,
    LANE_VALUE,
    LANES,
    broadcast,
    call_vector_function,
    emit_larger,
    fold_lanes,
)

_F64 = ir.DoubleType()

__all__ = ["TangentType", "tangent_lanes", "tangent_numbers"]


class TangentType(types.Type):
    """A value of type `base` and `count` slopes of type `element`.

    `element` is that of the base, or eight directions in a lane value beside a value of one number.
    """

    def __init__(self, base: Any, element: Any, count: int) -> None:
        self.base, self.element, self.count = base, element, count
        super().__init__(name=f"tangent({base}, {count} {element})")

    @property
    def parts(self) -> tuple[Any, ...]:
        """The types of what a row of a block holds, in its order."""
        return (self.base, *[self.element] * self.count)

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

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """Let plain numbers be constants, and one number be eight alike."""
        known = isinstance(other, types.Float | types.Integer) or other == self.base
        known = known or (_is_tangent(other) and not other.packed and other.lanes() == self)
        return Conversion.safe if known else None


def tangent_numbers(directions: int) -> tuple[TangentType, BlockType]:
    """Return the types of numbers with directions in lanes, and of blocks of them."""
    number = TangentType(types.float64, LANE_VALUE, directions // LANES)
    return number, BlockType(number, held=tangent_block(directions))


def tangent_lanes(directions: int) -> tuple[TangentType, BlockType, BlockType]:
    """Return the types of eight numbers with so many directions, of blocks of them, and of memory."""
    one = TangentType(types.float64, types.float64, directions)
    eight = one.lanes()
    held = tangent_block(directions), tangent_lane_block(directions)
    return eight, BlockType(eight, held=held[1]), BlockType(one, held=held[0])


@register_model(TangentType)
class TangentModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: TangentType) -> None:
        slopes = types.UniTuple(fe_type.element, fe_type.count)
        super().__init__(dmm, fe_type, [("value", fe_type.base), ("slopes", slopes)])


def _is_tangent(x: Any) -> bool:
    return isinstance(x, TangentType)


def _is_plain(x: Any) -> bool:
    return x == LANE_VALUE or isinstance(x, types.Float | types.Integer)


def _joined(*given: Any) -> TangentType | None:
    """Return the type of what numbers give, one of them a tangent one; None if they do not fit."""
    tangents = [x for x in given if _is_tangent(x)]
    if not tangents or not all(_is_tangent(x) or _is_plain(x) for x in given):
        return None
    first = tangents[0]
    eight = any(getattr(x, "base", x) == LANE_VALUE for x in given)
    alike = all((x.count, x.packed) == (first.count, first.packed) for x in tangents)
    if not alike or (eight and first.packed):
        return None
    return first.lanes() if eight else first


class _Number:
    """LLVM values of an operand as one of type `to`: value, and slopes unless it is a constant."""

    def __init__(self, context: Any, builder: Any, to: TangentType, kind: Any, given: Any) -> None:
        self._builder, self._to = builder, to
        self.constant = not _is_tangent(kind)
        if self.constant:
            self.value = _as(context, builder, to.base, kind, given)
            self.slopes: list[Any] = []
            return
        self.value = _as(context, builder, to.base, kind.base, builder.extract_value(given, 0))
        slopes = (builder.extract_value(given, (1, k)) for k in range(to.count))
        self.slopes = [_as(context, builder, to.element, kind.element, s) for s in slopes]

    @property
    def factor(self) -> Any:
        """The value, to multiply slopes with."""
        return broadcast(self._builder, self.value) if self._to.packed else self.value


def _as(context: Any, builder: Any, to: Any, kind: Any, value: Any) -> Any:
    if kind == to:
        return value
    number = context.cast(builder, value, kind, types.float64)
    return broadcast(builder, number) if to == LANE_VALUE else number


def _pack(context: Any, builder: Any, kind: TangentType, value: Any, slopes: Sequence[Any]) -> Any:
    packed = cgutils.get_null_value(context.get_value_type(kind))
    packed = builder.insert_value(packed, value, 0)
    for k, slope in enumerate(slopes):
        packed = builder.insert_value(packed, slope, (1, k))
    return packed


def _fused(b: Any, x: Any, y: Any, z: Any) -> Any:
    """Return ``x y + z`` with one rounding, of numbers or lanes."""
    if isinstance(x.type, ir.VectorType):
        return call_vector_function(b, "llvm.fma", (x, y, z))
    return b.fma(x, y, z)


def _sum(b: Any, x: _Number, y: _Number) -> tuple[Any, list[Any]]:
    value = b.fadd(x.value, y.value)
    if x.constant or y.constant:
        return value, x.slopes or y.slopes
    return value, [b.fadd(s, u) for s, u in zip(x.slopes, y.slopes, strict=True)]


def _difference(b: Any, x: _Number, y: _Number) -> tuple[Any, list[Any]]:
    value = b.fsub(x.value, y.value)
    if y.constant:
        return value, x.slopes
    if x.constant:
        return value, [b.fneg(u) for u in y.slopes]
    return value, [b.fsub(s, u) for s, u in zip(x.slopes, y.slopes, strict=True)]


def _product(b: Any, x: _Number, y: _Number) -> tuple[Any, list[Any]]:
    value = b.fmul(x.value, y.value)
    if x.constant or y.constant:
        number, other = (x, y) if x.constant else (y, x)
        factor = number.factor
        return value, [b.fmul(factor, s) for s in other.slopes]
    p, q = x.factor, y.factor
    pairs = zip(x.slopes, y.slopes, strict=True)
    return value, [_fused(b, p, u, b.fmul(q, s)) for s, u in pairs]


def _quotient(b: Any, x: _Number, y: _Number) -> tuple[Any, list[Any]]:
    value = b.fdiv(x.value, y.value)
    if y.constant:
        divisor = y.factor
        return value, [b.fdiv(s, divisor) for s in x.slopes]
    inverse = b.fdiv(ir.Constant(value.type, 1.0 if value.type == _F64 else [1.0] * LANES), y.value)
    by = broadcast(b, inverse) if y._to.packed else inverse
    times = b.fneg(broadcast(b, value) if y._to.packed else value)
    if x.constant:
        return value, [b.fmul(by, b.fmul(times, u)) for u in y.slopes]
    pairs = zip(x.slopes, y.slopes, strict=True)
    return value, [b.fmul(by, _fused(b, times, u, s)) for s, u in pairs]


def _register(functions: list[Any], result: Callable[..., Any], emit: Any) -> None:
    """Let operators take two numbers, one of which at least is a tangent number."""
    for function in functions:

        @infer_global(function)
        class Template(AbstractTemplate):
            def generic(self, args: Any, kws: Any) -> Any:
                joined = _joined(*args) if len(args) == 2 else None
                return None if joined is None else signature(result(joined), *args)

        def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            to = _joined(*sig.args)
            assert to is not None
            pairs = zip(sig.args, args, strict=True)
            x, y = (_Number(context, builder, to, kind, value) for kind, value in pairs)
            return emit(context, builder, to, x, y)

        for left, right in (
            (TangentType, TangentType),
            (TangentType, types.Number),
            (types.Number, TangentType),
            (TangentType, LANE_VALUE),
            (LANE_VALUE, TangentType),
        ):
            lower_builtin(function, left, right)(lower)


for _functions, _emit in (
    ([operator.add, operator.iadd], _sum),
    ([operator.sub, operator.isub], _difference),
    ([operator.mul, operator.imul], _product),
    ([operator.truediv, operator.itruediv], _quotient),
):
    _register(
        _functions,
        lambda joined: joined,
        lambda c, b, to, x, y, emit=_emit: _pack(c, b, to, *emit(b, x, y)),
    )


def _truth(joined: TangentType) -> Any:
    return LANE_MASK if joined.base == LANE_VALUE else types.boolean


for _sign, _function in (
    ("<", operator.lt),
    ("<=", operator.le),
    (">", operator.gt),
    (">=", operator.ge),
    ("==", operator.eq),
):
    _register(
        [_function], _truth, lambda c, b, to, x, y, s=_sign: b.fcmp_ordered(s, x.value, y.value)
    )
_register([operator.ne], _truth, lambda c, b, to, x, y: b.fcmp_unordered("!=", x.value, y.value))


@lower_cast(LANE_VALUE, TangentType)
@lower_cast(types.Number, TangentType)
def _cast_number(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    number = _as(context, builder, toty.base, fromty, value)
    return _pack(context, builder, toty, number, [])


@lower_cast(TangentType, TangentType)
def _cast_one(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    number = _Number(context, builder, toty, fromty, value)
    return _pack(context, builder, toty, number.value, number.slopes)


def _unary(function: Any, emit: Any) -> None:
    """Let a function take a tangent number and give one."""

    @infer_global(function)
    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            return signature(args[0], *args) if len(args) == 1 and _is_tangent(args[0]) else None

    @lower_builtin(function, TangentType)
    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        (kind,) = sig.args
        return emit(context, builder, kind, _Number(context, builder, kind, kind, args[0]))


def _negative(context: Any, b: Any, kind: TangentType, x: _Number) -> Any:
    return _pack(context, b, kind, b.fneg(x.value), [b.fneg(s) for s in x.slopes])


def _size(context: Any, b: Any, kind: TangentType, x: _Number) -> Any:
    negative = b.fcmp_ordered("<", x.value, ir.Constant(x.value.type, None))
    parts = [b.select(negative, b.fneg(part), part) for part in (x.value, *x.slopes)]
    return _pack(context, b, kind, parts[0], parts[1:])


_unary(operator.neg, _negative)
_unary(operator.pos, lambda c, b, kind, x: _pack(c, b, kind, x.value, x.slopes))
_unary(abs, _size)


@infer_global(int)
class _Whole(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        one = len(args) == 1 and _is_tangent(args[0]) and args[0].base == types.float64
        return signature(types.int64, *args) if one else None


@lower_builtin(int, TangentType)
def _whole(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fptosi(builder.extract_value(args[0], 0), ir.IntType(64))


@instruction(arithmetic.fma)
def _fma(typingctx, x, y, z):
    to = _joined(x, y, z)
    if to is None:
        return None

    def codegen(context: Any, b: Any, sig: Any, args: Any) -> Any:
        triple = zip(sig.args, args, strict=True)
        p, q, r = (_Number(context, b, to, kind, value) for kind, value in triple)
        values = p.value, q.value, r.value
        eight = to.base == LANE_VALUE
        value = call_vector_function(b, "llvm.fma", values) if eight else b.fma(*values)
        slopes = r.slopes
        for factor, others in ((q.factor, p.slopes), (p.factor, q.slopes)):
            if slopes and others:
                pairs = zip(others, slopes, strict=True)
                slopes = [_fused(b, factor, s, more) for s, more in pairs]
            elif others:
                slopes = [b.fmul(factor, s) for s in others]
        return _pack(context, b, to, value, slopes)

    return to(x, y, z), codegen


@instruction(arithmetic.select)
def _select(typingctx, condition, x, y):
    to = _joined(x, y)
    if to is None or (condition == LANE_MASK) != (to.base == LANE_VALUE):
        return None

    def codegen(context: Any, b: Any, sig: Any, args: Any) -> Any:
        pairs = zip(sig.args[1:], args[1:], strict=True)
        p, q = (_Number(context, b, to, kind, value) for kind, value in pairs)
        zero = ir.Constant(context.get_value_type(to.element), None)
        s, u = p.slopes or [zero] * to.count, q.slopes or [zero] * to.count
        both = zip((p.value, *s), (q.value, *u), strict=True)
        parts = [b.select(args[0], first, second) for first, second in both]
        return _pack(context, b, to, parts[0], parts[1:])

    return to(condition, x, y), codegen


@instruction(arithmetic.like)
def _like(typingctx, value, example):
    if not _is_tangent(example):
        return None
    to = _joined(value, example)
    if to != example:
        return None

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        number = _Number(context, builder, to, sig.args[0], args[0])
        return _pack(context, builder, to, number.value, number.slopes)

    return to(value, example), codegen


@intrinsic
def _value(typingctx, x):
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_value(args[0], 0)

    return x.base(x), codegen


def _chained(emit: Any) -> Any:
    """Return an intrinsic ``(x, value, number)``: such a value, and what a number makes of slopes."""

    @intrinsic
    def chain(typingctx, x, value, number):
        def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            tangent = _Number(context, builder, x, x, args[0])
            factor = broadcast(builder, args[2]) if x.packed else args[2]
            slopes = [emit(builder, s, factor) for s in tangent.slopes]
            return _pack(context, builder, x, args[1], slopes)

        return x(x, x.base, x.base), codegen

    return chain


_by = _chained(lambda b, slope, factor: b.fmul(factor, slope))
_over = _chained(lambda b, slope, divisor: b.fdiv(slope, divisor))


@overload(arithmetic.sqrt)
def _overload_sqrt(x):
    if not _is_tangent(x):
        return None

    def root_of(x):
        root = arithmetic.sqrt(_value(x))
        return _over(x, root, 2.0 * root)

    return root_of


@overload(circular.sin)
def _overload_sin(x):
    if not _is_tangent(x):
        return None
    return lambda x: _by(x, circular.sin(_value(x)), circular.cos(_value(x)))


@overload(circular.cos)
def _overload_cos(x):
    if not _is_tangent(x):
        return None
    return lambda x: _by(x, circular.cos(_value(x)), -circular.sin(_value(x)))


@overload(arithmetic.log)
def _overload_log(x):
    if not _is_tangent(x):
        return None
    return lambda x: _over(x, arithmetic.log(_value(x)), _value(x))


@instruction(arithmetic.magnitude)
def _magnitude(typingctx, x):
    if not _is_tangent(x):
        return None

    def codegen(context: Any, b: Any, sig: Any, args: Any) -> Any:
        number = _Number(context, b, x, x, args[0])
        found = number.value if not x.packed else number.factor
        found = _absolute(b, found)
        for slope in number.slopes:
            found = emit_larger(b, _absolute(b, slope), found)
        return fold_lanes(b, emit_larger, found) if x.packed else found

    return x.base(x), codegen


def _absolute(b: Any, x: Any) -> Any:
    negative = b.fcmp_ordered("<", x, ir.Constant(x.type, None))
    return b.select(negative, b.fneg(x), x)


@overload(arithmetic.plain)
def _overload_plain(x):
    return (lambda x: _value(x)) if _is_tangent(x) else None


@overload(arithmetic.slope_count)
def _overload_slope_count(x):
    if not _is_tangent(x):
        return None
    count = x.count * (LANES if x.packed else 1)
    return lambda x: count


@overload(arithmetic.top)
def _overload_top(x):
    return (lambda x: arithmetic.top(_value(x))) if _is_tangent(x) else None


@overload(arithmetic.epsilon)
def _overload_epsilon(x):
    return (lambda x: 2.220446049250313e-16) if _is_tangent(x) else None


@instruction(arithmetic.lane)
def _lane(typingctx, x, index):
    if not _is_tangent(x) or x.base != LANE_VALUE:
        return None
    one = x.singles()

    def codegen(context: Any, b: Any, sig: Any, args: Any) -> Any:
        position = context.cast(b, args[1], sig.args[1], types.int32)
        eight = _Number(context, b, x, x, args[0])
        slopes = [b.extract_element(s, position) for s in eight.slopes]
        return _pack(context, b, one, b.extract_element(eight.value, position), slopes)

    return one(x, index), codegen


@instruction(as_tangents, prefer_literal=True)
def _as_tangents(typingctx, block, directions):
    count = getattr(directions, "literal_value", None)
    if count is None or not isinstance(block, BlockType):
        return None
    _, result, _ = tangent_lanes(count)
    return result(block, directions), other_rows(block, result)
