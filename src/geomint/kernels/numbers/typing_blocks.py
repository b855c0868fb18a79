"""The numba half of blocks: a pointer and a row count, with rows of float64 or of lane values.

Setting ``NUMBA_BOUNDSCHECK=1`` before compilation checks every row index; otherwise none is checked,
but in the one run of every function in plain Python before its first (`geomint.problems.declaration`).
"""

import functools
import operator
from typing import Any

from llvmlite import ir
from numba.core import cgutils, config, types
from numba.core.imputils import lower_builtin
from numba.core.ir import Assign, Expr
from numba.core.typing.templates import signature
from numba.extending import models, register_model

from ..numba_inside import add_alias, alias_analysis_extensions
from . import blocks
from .instruction import instruction, typed
from .lanes import LANES
from .typing_lanes import LANE_VALUE

_F64 = ir.DoubleType()
_ALIGN = 8


class BlockType(types.Type):
    """A block whose rows are of type `row`; `rows` is their number where it is a constant."""

    def __init__(self, row, rows=None):
        self.row, self.rows = row, rows
        size = "" if rows is None else f", {rows}"
        super().__init__(name=f"block({row}{size})")

    def of_rows(self, rows: int):
        """Return the type of those that have so many rows."""
        return BlockType(self.row, rows)

    @property
    def held(self):
        """The class of what Python holds."""
        return getattr(self.row, "held", blocks.Block)


SCALAR_BLOCK = BlockType(types.float64)
LANE_BLOCK = BlockType(LANE_VALUE)


@register_model(BlockType)
class BlockModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        members = [("data", types.CPointer(types.float64)), ("rows", types.int64)]
        super().__init__(dmm, fe_type, members)


def _opened(context, builder, typ, value):
    """Return where a block's numbers begin, and how many rows it has."""
    block = cgutils.create_struct_proxy(typ)(context, builder, value=value)
    return block.data, block.rows if typ.rows is None else ir.IntType(64)(typ.rows)


def _closed(context, builder, typ, data, rows):
    block = cgutils.create_struct_proxy(typ)(context, builder)
    block.data, block.rows = data, rows
    return block._getvalue()


def parts_of(row) -> tuple[Any, ...]:
    """Return the types that a row is made of: float64 numbers and lane values."""
    return getattr(row, "parts", (row,))


def _width(row):
    """Numbers in a row: of all its parts."""
    return sum(LANES if part == LANE_VALUE else 1 for part in parts_of(row))


def place_in(row, part: int) -> tuple[int, ...]:
    """Return where a part is in the value of a row: nowhere in what is a part itself."""
    if hasattr(row, "place"):
        return row.place(part)
    return (part,) if hasattr(row, "parts") else ()


def _refuse(context, builder, outside, message):
    """Raise IndexError where a condition holds."""
    with builder.if_then(outside, likely=False):
        context.call_conv.return_user_exc(builder, IndexError, (message,))


def _row_pointers(context, builder, typ, value, index):
    """Return the address of each part of a row."""
    data, rows = _opened(context, builder, typ, value)
    if config.BOUNDSCHECK:
        outside = builder.icmp_unsigned(">=", index, rows)
        _refuse(context, builder, outside, "row index outside of the block")
    start = builder.mul(index, index.type(_width(typ.row)))
    pointers, offset = [], 0
    for part in parts_of(typ.row):
        pointer = builder.gep(data, [builder.add(start, index.type(offset))])
        if part == LANE_VALUE:
            pointer = builder.bitcast(pointer, ir.VectorType(_F64, LANES).as_pointer())
        pointers.append(pointer)
        offset += LANES if part == LANE_VALUE else 1
    return pointers


_INDEX = types.Integer | types.IntEnumMember


@typed(operator.getitem)
def _type_get(block, row):
    rows = isinstance(block, BlockType) and isinstance(row, _INDEX)
    return signature(block.row, block, types.int64) if rows else None


@typed(operator.setitem)
def _type_set(block, row, value):
    rows = isinstance(block, BlockType) and isinstance(row, _INDEX)
    return signature(types.none, block, types.int64, block.row) if rows else None


@typed(len)
def _type_length(block):
    return signature(types.int64, block) if isinstance(block, BlockType) else None


@lower_builtin(operator.getitem, BlockType, types.Integer)
def _lower_get(context, builder, sig, args):
    pointers = _row_pointers(context, builder, sig.args[0], *args)
    parts = [builder.load(pointer, align=_ALIGN) for pointer in pointers]
    if len(parts) == 1:
        return parts[0]
    row = sig.args[0].row
    value = cgutils.get_null_value(context.get_value_type(row))
    for k, part in enumerate(parts):
        value = builder.insert_value(value, part, place_in(row, k))
    return value


@lower_builtin(operator.setitem, BlockType, types.Integer, types.Any)
def _lower_set(context, builder, sig, args):
    pointers = _row_pointers(context, builder, sig.args[0], args[0], args[1])
    if len(pointers) == 1:
        builder.store(args[2], pointers[0], align=_ALIGN)
    else:
        for i, pointer in enumerate(pointers):
            part = builder.extract_value(args[2], place_in(sig.args[0].row, i))
            builder.store(part, pointer, align=_ALIGN)
    return context.get_dummy_value()


@lower_builtin(len, BlockType)
def _lower_length(context, builder, sig, args):
    return _opened(context, builder, sig.args[0], args[0])[1]


def _view(result):
    """Return code that makes a block of type `result` from (block, start, rows)."""

    def codegen(context, builder, sig, args):
        data, whole = _opened(context, builder, sig.args[0], args[0])
        start, rows = args[1], args[2]
        width = _width(sig.args[0].row)
        taken = _width(result.row) // width
        if config.BOUNDSCHECK:
            end = builder.add(start, builder.mul(rows, rows.type(taken)))
            past = builder.icmp_signed(">", end, whole)
            negative = builder.icmp_signed("<", builder.or_(start, rows), rows.type(0))
            outside = builder.or_(past, negative)
            _refuse(context, builder, outside, "part outside of the block")
        data = builder.gep(data, [builder.mul(start, start.type(width))])
        return _closed(context, builder, result, data, rows)

    return codegen


@instruction(blocks.part)
def _part(typingctx, block, start, rows):
    result = BlockType(block.row)
    return result(block, types.int64, types.int64), _view(result)


def _section(context, builder, sig, args, at):
    """Return part `at` of a layout: the sum of the rows before it is as constant as they are."""
    block, layout = sig.args[:2]
    sizes = [builder.extract_value(args[1], i) for i in range(at + 1)]
    start = functools.reduce(builder.add, sizes[:-1], ir.Constant(ir.IntType(64), 0))
    rows = sizes[-1]
    if at + 1 == len(layout.fields):
        _, whole = _opened(context, builder, block, args[0])
        rest = builder.icmp_signed("<", rows, rows.type(0))
        rows = builder.select(rest, builder.sub(whole, start), rows)
    result = BlockType(block.row)
    part_type = result(block, types.int64, types.int64)
    return _view(result)(context, builder, part_type, (args[0], start, rows))


@instruction(blocks.section, prefer_literal=True)
def _named(typingctx, block, layout, name):
    if not isinstance(name, types.StringLiteral) or not isinstance(layout, types.BaseNamedTuple):
        return None
    at = layout.fields.index(name.literal_value)
    return BlockType(block.row)(block, layout, name), functools.partial(_section, at=at)


@instruction(blocks.sections)
def _all_named(typingctx, block, layout):
    if not isinstance(layout, types.BaseNamedTuple):
        return None
    count = len(layout.fields)
    result = types.NamedUniTuple(BlockType(block.row), count, layout.instance_class)

    def codegen(context, builder, sig, args):
        parts = [_section(context, builder, sig, args, at) for at in range(count)]
        return context.make_tuple(builder, sig.return_type, parts)

    return result(block, layout), codegen


@instruction(blocks.as_lanes)
def _as_lanes(typingctx, block, start, rows):
    result = BlockType(block.row.lanes() if hasattr(block.row, "lanes") else LANE_VALUE)
    return result(block, types.int64, types.int64), _view(result)


def other_rows(block, result: BlockType):
    """Return code that makes a block of other rows in the same memory."""

    def codegen(context, builder, sig, args):
        data, rows = _opened(context, builder, sig.args[0], args[0])
        numbers = builder.mul(rows, rows.type(_width(block.row)))
        rows = builder.sdiv(numbers, rows.type(_width(result.row)))
        return _closed(context, builder, result, data, rows)

    return codegen


@instruction(blocks.as_singles)
def _as_singles(typingctx, block):
    single = block.row.singles() if hasattr(block.row, "singles") else types.float64
    result = BlockType(single)
    return result(block), other_rows(block, result)


@instruction(blocks.as_numbers)
def _as_numbers(typingctx, block):
    if not isinstance(block, BlockType):
        return None
    return SCALAR_BLOCK(block), other_rows(block, SCALAR_BLOCK)


@instruction(blocks.set_lane)
def _set_lane(typingctx, block, row, index, value):
    if not isinstance(block, BlockType):
        return None
    single = block.row.singles() if hasattr(block.row, "singles") else types.float64

    def codegen(context, builder, sig, args):
        position = context.cast(builder, args[2], sig.args[2], types.int32)
        for i, pointer in enumerate(_row_pointers(context, builder, sig.args[0], args[0], args[1])):
            part = args[3]
            if hasattr(block.row, "singles"):
                part = builder.extract_value(part, place_in(block.row, i))
            lanes = builder.load(pointer, align=_ALIGN)
            lanes = builder.insert_element(lanes, part, position)
            builder.store(lanes, pointer, align=_ALIGN)
        return context.get_dummy_value()

    return types.none(block, types.int64, types.int64, single), codegen


@instruction(blocks.fixed_rows, prefer_literal=True)
def _fixed_rows(typingctx, block, rows):
    """Return the block with its row count known to the compiler, which then unrolls loops."""
    if not isinstance(rows, types.Literal):
        return None

    def codegen(context, builder, sig, args):
        return args[0]

    return block.of_rows(rows.literal_value)(block, rows), codegen


def _views(statement, arguments, typemap, function, aliases, of_arguments):
    """Let blocks, and tuples that may hold some, be views of all that they are made of."""
    target, made = statement.target.name, statement.value
    kind = (typemap or {}).get(target)
    if isinstance(made, Expr) and (kind is None or isinstance(kind, BlockType | types.BaseTuple)):
        for part in made.list_vars():
            add_alias(target, part.name, aliases, of_arguments)


# Without this numba takes a store as the last use of a view for dead, and removes it.
alias_analysis_extensions[Assign] = _views
