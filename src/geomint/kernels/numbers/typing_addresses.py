"""The numba half of functions behind their addresses: a pointer to the addresses of their code."""

import hashlib
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import models, register_model

from . import addresses
from .instruction import instruction


class AddressesType(types.Type):
    """Addresses of functions, one after the other; of which types is told where they are called."""

    def __init__(self) -> None:
        super().__init__(name="addresses")


register_model(AddressesType)(models.OpaqueModel)

ADDRESSES = AddressesType()
_WORD = ir.IntType(8).as_pointer()
_signatures: dict[str, Any] = {}  # by kind


def kind_of(signature) -> str:
    """Return the name of a signature, the same in every process; here it is found by that."""
    name = hashlib.sha256(str(signature).encode()).hexdigest()
    _signatures[name] = signature
    return name


def _known(pointer, kind):
    """Return the signature of that name, or None for what is no name of one."""
    return _signatures.get(getattr(kind, "literal_value", "")) if pointer == ADDRESSES else None


def _function(context, builder, kind, pointer, place):
    """Return the function at a place, as numba has functions that are arguments."""
    if isinstance(place, int):
        place = ir.Constant(ir.IntType(64), place)
    words = builder.bitcast(pointer, _WORD.as_pointer())
    function = cgutils.create_struct_proxy(kind)(context, builder)
    function.c_addr = function.py_addr = ir.Constant(_WORD, None)
    at = builder.gep(words, [place])
    function.jit_addr = builder.load(at)
    return function._getvalue()


@instruction(addresses.function_at, prefer_literal=True)
def _function_at(typingctx, pointer, place, kind):
    """Return one of several functions of a kind as a value of its type."""
    known = _known(pointer, kind)
    if known is None:
        return None
    function = types.FunctionType(known)

    def codegen(context, builder, sig, args):
        return _function(context, builder, function, args[0], args[1])

    return function(pointer, types.int64, kind), codegen


@instruction(addresses.functions_at, prefer_literal=True)
def _functions_at(typingctx, pointer, kind):
    """Return the functions that the stepper takes, as a tuple."""
    known = _known(pointer, kind)
    if known is None:
        return None
    taken = known.args[0]

    def codegen(context, builder, sig, args):
        own = [
            _function(context, builder, function, args[0], 1 + i)
            for i, function in enumerate(taken.types)
        ]
        return context.make_tuple(builder, taken, own)

    return taken(pointer, kind), codegen
