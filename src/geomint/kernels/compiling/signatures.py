"""The numba signatures under which problems' functions and steppers are compiled."""

from __future__ import annotations

from typing import Any

from numba.core import types

from .compile import SCALAR, NumberType

__all__ = [
    "action",
    "advance_signature",
    "constraint",
    "field",
    "flow",
    "gradients",
    "sweep",
    "value",
]


def field(number_type: NumberType) -> Any:
    """``f(params, t, y, out, work)``: vector fields and generators."""
    block = number_type.block
    return types.void(SCALAR.block, number_type.number, block, block, block)


def value(number_type: NumberType) -> Any:
    """``f(params, t, y, work) -> number``: invariants, observables, clocks."""
    return number_type.number(
        SCALAR.block, number_type.number, number_type.block, number_type.block
    )


def action(number_type: NumberType) -> Any:
    """``f(layout, x, y, out, work)``: a group acting, or a Lie bracket."""
    block = number_type.block
    return types.void(SCALAR.block, block, block, block, block)


def gradients(number_type: NumberType) -> Any:
    """``f(params, t, q, p, dq, dp, work)``: both gradients of a Hamiltonian."""
    block = number_type.block
    return types.void(SCALAR.block, number_type.number, block, block, block, block, block)


def constraint(number_type: NumberType) -> Any:
    """``f(params, q, g, G, work)``: constraints and their Jacobian, row after row."""
    block = number_type.block
    return types.void(SCALAR.block, block, block, block, block)


def flow(number_type: NumberType) -> Any:
    """``f(k, params, t, h, y, out, work)``: the increment of the flow of part k over h."""
    block, number = number_type.block, number_type.number
    return types.void(types.int64, SCALAR.block, number, number, block, block, block)


def advance_signature(functions: list[Any], number_type: NumberType = SCALAR) -> Any:
    """Return the signature of a stepper that takes functions of the given signatures.

    Its memory holds numbers of that type; one with a memory type of its own has its coefficients in
    that type too.
    """
    result = types.Tuple([types.int64, types.int64, types.int64, types.float64])
    block = number_type.memory
    coefficients = SCALAR.block if number_type.memory is number_type.block else number_type.memory
    numbers = [types.int64, types.float64, types.float64, types.int64, types.int64, types.int64]
    return result(
        *(types.FunctionType(f) for f in functions),
        SCALAR.block,  # params
        coefficients,
        SCALAR.block,  # fractions
        block,  # memory
        block,  # work
        *numbers,  # rows, t0, h, first, count, every
        block,  # out
    )


def sweep(functions: list[Any]) -> Any:
    """Return the signature of the sweep of `geomint.kernels.measure.measure` with such functions."""
    block = SCALAR.block
    return types.void(*(types.FunctionType(f) for f in functions), *[block] * 11)
