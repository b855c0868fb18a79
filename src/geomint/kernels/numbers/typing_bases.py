"""What values and slopes of tangent numbers are added and multiplied by, in compiled code.

Of float64 and lane values by instructions; of any other numbers, as double-double ones or tangent
numbers again, by the functions that these have.
"""

from __future__ import annotations

import functools
import operator
from typing import Any, NamedTuple

from llvmlite import ir
from numba.core import types
from numba.core.errors import TypingError

from . import arithmetic
from .typing_lanes import LANE_VALUE, broadcast, call_vector_function

__all__ = ["arithmetic_of", "eight_of", "is_eight", "is_machine", "one_of", "result_of"]

_COMPARISONS = {
    operator.lt: "<",
    operator.le: "<=",
    operator.gt: ">",
    operator.ge: ">=",
    operator.eq: "==",
}


def is_machine(kind: Any) -> bool:
    """Tell whether numbers are float64 or lane values."""
    return kind in (types.float64, LANE_VALUE)


def is_eight(kind: Any) -> bool:
    """Tell whether numbers are eight at once."""
    return kind == LANE_VALUE or (hasattr(kind, "base") and is_eight(kind.base))


def eight_of(kind: Any) -> Any:
    """Return the type of eight such numbers."""
    return LANE_VALUE if is_machine(kind) else kind.lanes()


def one_of(kind: Any) -> Any:
    """Return the type of one of eight such numbers."""
    return types.float64 if is_machine(kind) else kind.singles()


def result_of(context: Any, function: Any, *kinds: Any) -> Any:
    """Return the type of what a function of numbers returns; None if it takes no such ones."""
    try:
        found = context.resolve_value_type(function).get_call_type(context, kinds, {})
    except TypingError:
        return None
    return None if found is None else found.return_type


class Instructions:
    """Arithmetic of float64 or lane values."""

    def __init__(self, context: Any, builder: Any) -> None:
        self.context, self.builder = context, builder
        self.add, self.subtract, self.multiply = builder.fadd, builder.fsub, builder.fmul
        self.divide, self.negative, self.select = builder.fdiv, builder.fneg, builder.select

    def taken(self, to: Any, kind: Any, value: Any) -> Any:
        """Return an operand of type `kind` for results of type `to`."""
        if kind == to:
            return value
        number = self.context.cast(self.builder, value, kind, types.float64)
        return broadcast(self.builder, number) if to == LANE_VALUE else number

    def given(self, to: Any, x: Any) -> Any:
        """Return the LLVM value of a result of type `to`."""
        return x

    def fused(self, x: Any, y: Any, z: Any) -> Any:
        """Return ``x y + z`` with one rounding."""
        if isinstance(x.type, ir.VectorType):
            return call_vector_function(self.builder, "llvm.fma", (x, y, z))
        return self.builder.fma(x, y, z)

    def compare(self, function: Any, x: Any, y: Any) -> Any:
        """Return whether a comparison holds; with NaN only ``!=`` does."""
        if function is operator.ne:
            return self.builder.fcmp_unordered("!=", x, y)
        return self.builder.fcmp_ordered(_COMPARISONS[function], x, y)

    def reciprocal(self, x: Any) -> Any:
        """Return 1/x."""
        one = 1.0 if x.type == ir.DoubleType() else [1.0] * x.type.count
        return self.divide(ir.Constant(x.type, one), x)

    def is_negative(self, x: Any) -> Any:
        """Return ``x < 0``."""
        return self.compare(operator.lt, x, ir.Constant(x.type, None))

    def absolute(self, x: Any) -> Any:
        """Return |x|."""
        return self.select(self.is_negative(x), self.negative(x), x)


class _Typed(NamedTuple):
    """An LLVM value and its type: a number of the base, or a plain one."""

    kind: Any
    value: Any


class Calls:
    """Arithmetic of numbers of a type of their own, and of plain numbers with them."""

    def __init__(self, context: Any, builder: Any, base: Any) -> None:
        self.context, self.builder, self._base = context, builder, base
        self.add, self.subtract, self.multiply, self.divide, self.negative, self.fused = (
            functools.partial(self._call, function)
            for function in (
                operator.add,
                operator.sub,
                operator.mul,
                operator.truediv,
                operator.neg,
                arithmetic.fma,
            )
        )

    def taken(self, to: Any, kind: Any, value: Any) -> _Typed:
        """Return an operand; a plain number stays one."""
        if kind == LANE_VALUE or isinstance(kind, types.Number):
            return _Typed(kind, value)
        return _Typed(to, self.context.cast(self.builder, value, kind, to))

    def given(self, to: Any, x: _Typed) -> Any:
        """Return the LLVM value of a result of type `to`."""
        return self.context.cast(self.builder, x.value, x.kind, to)

    def select(self, condition: Any, x: _Typed, y: _Typed) -> _Typed:
        """Return x where the condition holds and y elsewhere."""
        typing = self.context.typing_context
        truth = _Typed(result_of(typing, operator.lt, self._base, self._base), condition)
        either = (_Typed(self._base, self.given(self._base, z)) for z in (x, y))
        return self._call(arithmetic.select, truth, *either)

    def compare(self, function: Any, x: _Typed, y: _Typed) -> Any:
        """Return whether a comparison of values holds."""
        return self._call(function, x, y).value

    def reciprocal(self, x: _Typed) -> _Typed:
        """Return 1/x."""
        return self._call(operator.truediv, self._number(1.0), x)

    def is_negative(self, x: _Typed) -> Any:
        """Return ``x < 0``."""
        return self.compare(operator.lt, x, self._number(0.0))

    def _number(self, value: float) -> _Typed:
        return _Typed(types.float64, self.context.get_constant(types.float64, value))

    def _call(self, function: Any, *operands: _Typed) -> _Typed:
        typing = self.context.typing_context
        known = typing.resolve_value_type(function)
        sig = known.get_call_type(typing, tuple(x.kind for x in operands), {})
        given = [self.given(kind, x) for kind, x in zip(sig.args, operands, strict=True)]
        value = self.context.get_function(known, sig)(self.builder, given)
        return _Typed(sig.return_type, value)


def arithmetic_of(context: Any, builder: Any, kind: Any) -> Instructions | Calls:
    """Return the arithmetic of numbers of a type."""
    return Instructions(context, builder) if is_machine(kind) else Calls(context, builder, kind)
