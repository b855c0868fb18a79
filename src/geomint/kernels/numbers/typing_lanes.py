"""The numba half of a lane value: a type on LLVM's ``<8 x double>`` and its operators.

LLVM splits the vector on machines with narrower registers. No fast-math flag and no contraction:
lane by lane the bits are those of float64 arithmetic (`docs/design.md`, "Arithmetic").
"""

import functools
import itertools
import operator

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import signature
from numba.extending import intrinsic, models, overload, register_model

from . import arithmetic
from .blocks import LaneBlock
from .instruction import instruction, typed
from .lanes import LANES

_F64 = ir.DoubleType()
_VECTOR = ir.VectorType(_F64, LANES)
_MASK_VECTOR = ir.VectorType(ir.IntType(1), LANES)
_I32 = ir.IntType(32)


class LaneValueType(types.Type):
    """Eight float64 numbers."""

    held = LaneBlock

    def __init__(self):
        super().__init__(name="lanes8")


class LaneMaskType(types.Type):
    """Eight truth values: what comparing lane values gives."""

    def __init__(self):
        super().__init__(name="lanemask8")


LANE_VALUE = LaneValueType()
LANE_MASK = LaneMaskType()


@register_model(LaneValueType)
class LaneValueModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _VECTOR)


@register_model(LaneMaskType)
class LaneMaskModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _MASK_VECTOR)


def broadcast(builder, scalar):
    """Return a vector whose lanes all hold `scalar`."""
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), scalar, _I32(0))
    zeros = ir.Constant(ir.VectorType(_I32, LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(_VECTOR, ir.Undefined), zeros)


def _as_vector(context, builder, value_type, value):
    if value_type == LANE_VALUE:
        return value
    return broadcast(builder, context.cast(builder, value, value_type, types.float64))


@lower_cast(types.Number, LANE_VALUE)
def _cast_number(context, builder, fromty, toty, value):
    return _as_vector(context, builder, fromty, value)


def is_plain(x) -> bool:
    """Tell whether a type is that of real numbers or their lanes."""
    return x == LANE_VALUE or isinstance(x, types.Float | types.Integer)


def _mixes_lanes(args):
    return LANE_VALUE in args and all(map(is_plain, args))


def _register_binary(functions, emit, result):
    for function in functions:

        @typed(function)
        def signature_of(*args):
            return signature(result, *args) if _mixes_lanes(args) else None

        def lower(context, builder, sig, args):
            x, y = (
                _as_vector(context, builder, value_type, value)
                for value_type, value in zip(sig.args, args, strict=True)
            )
            return emit(builder, x, y)

        for pair in itertools.product((LANE_VALUE, types.Number), repeat=2):
            if LANE_VALUE in pair:
                lower_builtin(function, *pair)(lower)


COMPARISONS = {
    operator.lt: "<",
    operator.le: "<=",
    operator.gt: ">",
    operator.ge: ">=",
    operator.eq: "==",
    operator.ne: "!=",
}


def compare(function, builder, x, y):
    """Emit whether a comparison holds, in each lane; with NaN only ``!=`` does."""
    emit = builder.fcmp_unordered if function is operator.ne else builder.fcmp_ordered
    return emit(COMPARISONS[function], x, y)


_register_binary([operator.add, operator.iadd], ir.IRBuilder.fadd, LANE_VALUE)
_register_binary([operator.sub, operator.isub], ir.IRBuilder.fsub, LANE_VALUE)
_register_binary([operator.mul, operator.imul], ir.IRBuilder.fmul, LANE_VALUE)
_register_binary([operator.truediv, operator.itruediv], ir.IRBuilder.fdiv, LANE_VALUE)
for _function in COMPARISONS:
    _register_binary([_function], functools.partial(compare, _function), LANE_MASK)


def _register_on(value_type, function, arity, emit):
    """Let an operator take `arity` values of a value_type and give one."""

    @typed(function)
    def signature_of(*args):
        return signature(value_type, *args) if args == (value_type,) * arity else None

    @lower_builtin(function, *(value_type,) * arity)
    def lower(context, builder, sig, args):
        return emit(builder, *args)


_register_on(LANE_VALUE, operator.neg, 1, ir.IRBuilder.fneg)
_register_on(LANE_VALUE, operator.pos, 1, lambda b, x: x)
_register_on(LANE_MASK, operator.and_, 2, ir.IRBuilder.and_)
_register_on(LANE_MASK, operator.or_, 2, ir.IRBuilder.or_)


def call_llvm(builder, name: str, values):
    """Call LLVM's intrinsic function `name` of numbers or lane vectors."""
    kind = values[0].type
    own = f"{name}.{'f64' if kind == _F64 else f'v{LANES}f64'}"
    function_type = ir.FunctionType(kind, [kind] * len(values))
    function = cgutils.get_or_insert_function(builder.module, function_type, own)
    return builder.call(function, values)


def _by_llvm(name: str, *given):
    """Return the signature and code of LLVM's intrinsic function of numbers and lanes."""

    def codegen(context, builder, sig, args):
        if sig.return_type == LANE_VALUE:
            pairs = zip(given, args, strict=True)
            args = [_as_vector(context, builder, kind, value) for kind, value in pairs]
        return call_llvm(builder, name, args)

    if _mixes_lanes(given):
        return LANE_VALUE(*given), codegen
    one = types.float64(*[types.float64] * len(given))
    return (one, codegen) if all(map(is_plain, given)) else None


@instruction(arithmetic.sqrt)
def _sqrt(typingctx, x):
    return _by_llvm("llvm.sqrt", x)


@instruction(arithmetic.fma)
def _fma(typingctx, x, y, z):
    return _by_llvm("llvm.fma", x, y, z)


_register_on(LANE_VALUE, abs, 1, lambda b, x: call_llvm(b, "llvm.fabs", [x]))


def _common_type(x, y):
    """Return the type of a choice between two plain numbers."""
    if LANE_VALUE in (x, y):
        return LANE_VALUE
    both_integers = isinstance(x, types.Integer) and isinstance(y, types.Integer)
    return types.int64 if both_integers else types.float64


def _choice(chosen):
    """Return code for (…, x, y) that casts x and y to one type and lets `chosen` choose."""

    def codegen(context, builder, sig, args):
        pair = [
            _as_vector(context, builder, value_type, value)
            if sig.return_type == LANE_VALUE
            else context.cast(builder, value, value_type, sig.return_type)
            for value_type, value in zip(sig.args[-2:], args[-2:], strict=True)
        ]
        return chosen(builder, *args[:-2], *pair)

    return codegen


# As instructions, not as Python branches: those would be inlined into the callers' own branches.
@instruction(arithmetic.select)
def _select(typingctx, condition, x, y):
    if not (is_plain(x) and is_plain(y)):
        return None
    if condition != LANE_MASK and not isinstance(condition, types.Boolean):
        return None
    result = LANE_VALUE if condition == LANE_MASK else _common_type(x, y)
    return result(condition, x, y), _choice(ir.IRBuilder.select)


@instruction(arithmetic.maximum)
def _maximum(typingctx, x, y):
    if not (is_plain(x) and is_plain(y)):
        return None
    return _common_type(x, y)(x, y), _choice(emit_larger)


@instruction(arithmetic.lane)
def _lane(typingctx, x, index):
    def codegen(context, builder, sig, args):
        if x != LANE_VALUE:
            return args[0]
        position = context.cast(builder, args[1], sig.args[1], types.int32)
        return builder.extract_element(args[0], position)

    return (_single(x)(x, index), codegen) if is_plain(x) else None


@intrinsic
def insert_lane(typingctx, x, index, value):
    """Return lanes with another number in one of them."""

    def codegen(context, builder, sig, args):
        position = context.cast(builder, args[1], sig.args[1], types.int32)
        return builder.insert_element(args[0], args[2], position)

    return LANE_VALUE(LANE_VALUE, index, types.float64), codegen


def _single(x):
    return types.float64 if x == LANE_VALUE else x


def _fold(function, emit):
    """Let a function combine lanes; it gives back what has none."""

    @instruction(function)
    def define(typingctx, x):
        def codegen(context, builder, sig, args):
            return fold_lanes(builder, emit, args[0]) if x == LANE_VALUE else args[0]

        known = is_plain(x) or function is arithmetic.total
        return (_single(x)(x), codegen) if known else None


def fold_lanes(builder, emit, vector):
    """Return the lanes combined pairwise: lane i with lane i + half, and again."""
    width = LANES
    while width > 1:
        half = width // 2
        undefined = ir.Constant(vector.type, ir.Undefined)
        mask = ir.VectorType(_I32, half)
        low = builder.shuffle_vector(vector, undefined, mask(list(range(half))))
        high = builder.shuffle_vector(vector, undefined, mask(list(range(half, width))))
        vector, width = emit(builder, low, high), half
    return builder.extract_element(vector, _I32(0))


def emit_larger(builder, x, y):
    """Emit the larger of two numbers, in each lane."""
    # A NaN in either operand must win: llvm.maximum would do, but is slow on x86, where the first
    # selection is one instruction and gives y where the two do not compare.
    if x.type == ir.IntType(64):
        return builder.select(builder.icmp_signed(">", x, y), x, y)
    larger = builder.select(builder.fcmp_ordered(">", x, y), x, y)
    return builder.select(builder.fcmp_ordered("ord", x, x), larger, x)


_fold(arithmetic.total, ir.IRBuilder.fadd)
_fold(arithmetic.top, emit_larger)


@overload(arithmetic.maximum, inline="always")
def _overload_maximum(x, y):
    if is_plain(x) and is_plain(y):
        return None
    return lambda x, y: arithmetic.select(x > y, x, arithmetic.select(x >= x, y, x))


def _of_bits(function, emit):
    """Let a function of float64 and of lanes be instructions on bits."""

    @instruction(function)
    def typed(typingctx, x):
        def codegen(context, builder, sig, args):
            (number,) = args
            lanes = number.type == _VECTOR
            whole = ir.VectorType(ir.IntType(64), LANES) if lanes else ir.IntType(64)

            def constant(kind, value):
                return ir.Constant(kind, [value] * LANES if lanes else value)

            return emit(builder, number, whole, constant)

        return (x(x), codegen) if x in (types.float64, LANE_VALUE) else None


def _power_of_two(builder, k, whole, constant):
    moved = builder.fadd(k, constant(k.type, arithmetic.SHIFT + 1023.0))
    bits = builder.shl(builder.bitcast(moved, whole), constant(whole, 52))
    return builder.bitcast(bits, k.type)


def _exponent(builder, x, whole, constant):
    bits = builder.lshr(builder.bitcast(x, whole), constant(whole, 52))
    bits = builder.or_(bits, constant(whole, 0x433 << 52))  # 2^52 and the exponent
    return builder.fsub(builder.bitcast(bits, x.type), constant(x.type, 2.0**52 + 1023.0))


_of_bits(arithmetic.power_of_two, _power_of_two)
_of_bits(arithmetic.exponent, _exponent)


@instruction(arithmetic.like)
def _like(typingctx, value, example):
    def codegen(context, builder, sig, args):
        if sig.return_type == value:
            return args[0]
        return _as_vector(context, builder, value, args[0])

    if not is_plain(example):
        return None
    return (LANE_VALUE if example == LANE_VALUE else value)(value, example), codegen


def _overload_but(function, having, found):
    """Let a function be another one of all numbers, but of those that have something."""

    @overload(function, inline="always")
    def choose(x):
        return None if hasattr(x, having) else found


_overload_but(arithmetic.plain, "base", lambda x: x)
_overload_but(arithmetic.slope_count, "base", lambda x: 0)
_overload_but(arithmetic.magnitude, "count", lambda x: abs(x))


@overload(arithmetic.epsilon)
def _overload_epsilon(x):
    if x == LANE_VALUE or isinstance(x, types.Float):
        return lambda x: 2.220446049250313e-16
    return None
