"""The numba half of blocks: a pointer and a row count, with rows of float64 or of lane values.

Setting ``NUMBA_BOUNDSCHECK=1`` before compilation checks every row index; otherwise none is checked.
"""

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, config, types
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import (
    NativeValue,
    intrinsic,
    models,
    overload,
    register_model,
    typeof_impl,
    unbox,
)

from . import blocks
from .lanes import LANES
from .typing_lanes import LANE_VALUE

__all__ = ["LANE_BLOCK", "SCALAR_BLOCK"]

_F64 = ir.DoubleType()
_ALIGN = 8


class BlockType(types.Type):
    """A block whose rows are of type `row`; `rows` is their number where it is a constant."""

    def __init__(self, row: Any, rows: int | None = None) -> None:
        self.row, self.rows = row, rows
        size = "" if rows is None else f", {rows}"
        super().__init__(name=f"block({row}{size})")


SCALAR_BLOCK = BlockType(types.float64)
LANE_BLOCK = BlockType(LANE_VALUE)


@register_model(BlockType)
class BlockModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: BlockType) -> None:
        members = [("data", types.CPointer(types.float64)), ("rows", types.int64)]
        super().__init__(dmm, fe_type, members)


@typeof_impl.register(blocks.Block)
def _typeof_block(value: blocks.Block, c: Any) -> BlockType:
    return LANE_BLOCK if isinstance(value, blocks.LaneBlock) else SCALAR_BLOCK


@unbox(BlockType)
def _unbox_block(typ: BlockType, obj: Any, c: Any) -> NativeValue:
    ndim = 2 if typ.row == LANE_VALUE else 1
    array_type = types.Array(types.float64, ndim, "C")
    attribute = c.pyapi.object_getattr_string(obj, "data")
    native = c.unbox(array_type, attribute)
    array = c.context.make_array(array_type)(c.context, c.builder, native.value)
    block = cgutils.create_struct_proxy(typ)(c.context, c.builder)
    block.data = array.data
    block.rows = c.builder.extract_value(array.shape, 0)
    # The Python object keeps the memory alive for the length of the call.
    c.pyapi.decref(attribute)
    return NativeValue(block._getvalue(), is_error=native.is_error, cleanup=native.cleanup)


def _number_of_rows(builder: Any, typ: BlockType, block: Any) -> Any:
    return block.rows if typ.rows is None else ir.Constant(ir.IntType(64), typ.rows)


def _row_pointer(context: Any, builder: Any, typ: BlockType, value: Any, index: Any) -> Any:
    block = cgutils.create_struct_proxy(typ)(context, builder, value=value)
    if config.BOUNDSCHECK:
        rows = _number_of_rows(builder, typ, block)
        outside = builder.icmp_unsigned(">=", index, rows)
        with builder.if_then(outside, likely=False):
            context.call_conv.return_user_exc(
                builder, IndexError, ("row index outside of the block",)
            )
    if typ.row == LANE_VALUE:
        index = builder.mul(index, ir.Constant(index.type, LANES))
        pointer = builder.gep(block.data, [index])
        return builder.bitcast(pointer, ir.VectorType(_F64, LANES).as_pointer())
    return builder.gep(block.data, [index])


@infer_global(operator.getitem)
class _GetRow(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], BlockType) and isinstance(args[1], types.Integer):
            return signature(args[0].row, args[0], types.int64)
        return None


@infer_global(operator.setitem)
class _SetRow(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], BlockType) and isinstance(args[1], types.Integer):
            return signature(types.none, args[0], types.int64, args[0].row)
        return None


@infer_global(len)
class _Length(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], BlockType):
            return signature(types.int64, args[0])
        return None


@lower_builtin(operator.getitem, BlockType, types.Integer)
def _lower_get(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    pointer = _row_pointer(context, builder, sig.args[0], *args)
    return builder.load(pointer, align=_ALIGN)


@lower_builtin(operator.setitem, BlockType, types.Integer, types.Any)
def _lower_set(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    pointer = _row_pointer(context, builder, sig.args[0], args[0], args[1])
    builder.store(args[2], pointer, align=_ALIGN)
    return context.get_dummy_value()


@lower_builtin(len, BlockType)
def _lower_length(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    block = cgutils.create_struct_proxy(sig.args[0])(context, builder, value=args[0])
    return _number_of_rows(builder, sig.args[0], block)


def _view(result: BlockType) -> Any:
    """Return code that makes a block of type `result` from (block, start, rows)."""

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        source = cgutils.create_struct_proxy(sig.args[0])(context, builder, value=args[0])
        start, rows = args[1], args[2]
        width = LANES if sig.args[0].row == LANE_VALUE else 1
        taken = LANES if (result.row == LANE_VALUE and width == 1) else 1
        if config.BOUNDSCHECK:
            end = builder.add(start, builder.mul(rows, ir.Constant(rows.type, taken)))
            outside = builder.icmp_signed(
                ">", end, _number_of_rows(builder, sig.args[0], source)
            )
            with builder.if_then(outside, likely=False):
                context.call_conv.return_user_exc(
                    builder, IndexError, ("part outside of the block",)
                )
        view = cgutils.create_struct_proxy(result)(context, builder)
        offset = builder.mul(start, ir.Constant(start.type, width))
        view.data = builder.gep(source.data, [offset])
        view.rows = rows
        return view._getvalue()

    return codegen


@intrinsic
def _part(typingctx, block, start, rows):
    result = BlockType(block.row)
    return result(block, types.int64, types.int64), _view(result)


@intrinsic
def _as_lanes(typingctx, block, start, rows):
    return LANE_BLOCK(block, types.int64, types.int64), _view(LANE_BLOCK)


@intrinsic
def _as_scalars(typingctx, block):
    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        source = cgutils.create_struct_proxy(sig.args[0])(context, builder, value=args[0])
        rows = _number_of_rows(builder, sig.args[0], source)
        view = cgutils.create_struct_proxy(SCALAR_BLOCK)(context, builder)
        view.data = source.data
        view.rows = builder.mul(rows, ir.Constant(rows.type, LANES))
        return view._getvalue()

    return SCALAR_BLOCK(block), codegen


@intrinsic
def _fixed_rows(typingctx, block, rows):
    """Return the block with its row count known to the compiler, which then unrolls loops."""
    if not isinstance(rows, types.IntegerLiteral):
        return None
    result = BlockType(block.row, rows.literal_value)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return args[0]

    return result(block, rows), codegen


@overload(blocks.as_scalars, inline="always")
def _overload_as_scalars(block):
    return lambda block: _as_scalars(block)


@overload(blocks.fixed_rows, inline="always")
def _overload_fixed_rows(block, rows):
    return lambda block, rows: _fixed_rows(block, rows)


@overload(blocks.part, inline="always")
def _overload_part(block, start, rows):
    return lambda block, start, rows: _part(block, start, rows)


@overload(blocks.as_lanes, inline="always")
def _overload_as_lanes(block, start, rows):
    return lambda block, start, rows: _as_lanes(block, start, rows)
