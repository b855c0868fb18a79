"""What values and slopes of tangent numbers are added and multiplied by: instructions."""

import operator

from llvmlite import ir
from numba.core import types

from .typing_lanes import LANE_VALUE, broadcast, call_llvm, compare


class Instructions:
    """Arithmetic of float64 or lane values."""

    def __init__(self, context, builder) -> None:
        self.context, self.builder = context, builder
        self.add, self.subtract, self.multiply = builder.fadd, builder.fsub, builder.fmul
        self.divide, self.negative, self.select = builder.fdiv, builder.fneg, builder.select

    def taken(self, to, kind, value):
        """Return an operand of type `kind` for results of type `to`."""
        if kind == to:
            return value
        number = self.context.cast(self.builder, value, kind, types.float64)
        return broadcast(self.builder, number) if to == LANE_VALUE else number

    def fused(self, x, y, z):
        """Return ``x y + z`` with one rounding."""
        return call_llvm(self.builder, "llvm.fma", (x, y, z))

    def compare(self, function, x, y):
        """Return whether a comparison holds; with NaN only ``!=`` does."""
        return compare(function, self.builder, x, y)

    def reciprocal(self, x):
        """Return 1/x."""
        one = 1.0 if x.type == ir.DoubleType() else [1.0] * x.type.count
        return self.divide(ir.Constant(x.type, one), x)

    def is_negative(self, x):
        """Return ``x < 0``."""
        return self.compare(operator.lt, x, ir.Constant(x.type, None))

    def absolute(self, x):
        """Return |x|."""
        return self.select(self.is_negative(x), self.negative(x), x)
