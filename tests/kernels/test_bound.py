"""Bound functions: entries of one function for Python and every type of number."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from numba.core import types

import geomint as gi
from geomint.kernels.compiling.bound import Bound, bind
from geomint.kernels.compiling.call import Code
from geomint.kernels.compiling.number_types import EXTENDED, LANE, SCALAR
from geomint.kernels.compiling.signatures import (
    ACTION,
    CONSTRAINT,
    FIELD,
    FLOW,
    GENERATOR,
    GRADIENTS,
    VALUE,
    WHOLE,
    Functions,
    advance,
    takes,
)
from geomint.kernels.numbers.blocks import Block, scalar_block

TYPES = (SCALAR, LANE, EXTENDED)


@gi.field
def count_rows(params, t, y, out, work):
    out[0] = 1.0 * len(params)
    out[1] = 1.0 * len(y) + t
    out[2] = 1.0 * len(out) + 10.0 * len(work)


def test_sizes_reach_the_function_in_both_ways() -> None:
    bound = bind(count_rows, FIELD, params=4, y=5, out=3)
    for compiled in (True, False):
        out = scalar_block(3)
        blocks = Block(np.zeros(5)), out, Block(np.zeros(7))
        bound.entry(compiled)(Block(np.zeros(4)), 0.25, *blocks)
        assert out.data.tolist() == [4.0, 5.25, 73.0]


def test_bound_lengths_are_constants_of_the_code() -> None:
    """Seen where a block has another length, which no problem's has."""
    entry = bind(count_rows, FIELD, y=5).entry()
    if not isinstance(entry, Code):
        pytest.skip("nothing is compiled")
    out = scalar_block(3)
    entry(Block(np.zeros(4)), 0.0, Block(np.zeros(6)), out, Block(np.zeros(0)))
    assert out.data.tolist() == [4.0, 5.0, 3.0]


def test_the_same_sizes_are_the_same_function() -> None:
    """So that it is compiled once."""
    assert bind(count_rows, FIELD, y=5) is bind(count_rows, FIELD, y=5)
    assert bind(count_rows, FIELD, y=5) != bind(count_rows, FIELD, y=6)
    assert bind(count_rows, FIELD, y=5).recorded.function.__name__ == "count_rows"


def test_a_size_of_no_argument_is_refused() -> None:
    with pytest.raises(AssertionError):
        bind(count_rows, FIELD, q=5)


@pytest.mark.parametrize(
    "signature", [FIELD, VALUE, GENERATOR, ACTION, GRADIENTS, CONSTRAINT, FLOW]
)
def test_signatures_follow_the_type_of_number(signature) -> None:
    for kind in TYPES:
        made = signature.of(kind)
        names = [name for name, _ in signature.arguments]
        assert len(made.args) == len(names)
        by_name = dict(zip(names, made.args, strict=True))
        for name, found in by_name.items():
            given = {"params": SCALAR.block, "layout": SCALAR.block, "k": types.int64}
            other = kind.number if name in ("t", "h") else kind.block
            assert found == given.get(name, other), (kind, name)
        assert made.return_type == (kind.number if signature is VALUE else types.none)
        assert signature.in_lanes.of(kind) == signature.of(LANE if kind is SCALAR else kind)


def test_a_stepper_has_the_functions_and_memory_of_its_numbers() -> None:
    """Functions for lanes stay so in a stepper of single numbers, as those of a Gauss step."""
    for kind in TYPES:
        made = advance([FIELD, VALUE.in_lanes]).of(kind)
        lanes = LANE if kind is SCALAR else kind
        functions = types.FunctionType(FIELD.of(kind)), types.FunctionType(VALUE.of(lanes))
        assert tuple(made.args[0]) == functions
        params, coefficients, fractions, memory, work = made.args[1:6]
        assert params == fractions == made.args[-1] == SCALAR.block
        assert coefficients == (kind.memory if kind is EXTENDED else SCALAR.block)
        assert memory == work == made.args[-2] == kind.memory


def test_what_a_function_takes_is_known_without_numba() -> None:
    code = (
        "import sys, geomint.methods.stepper, geomint.methods.bound_forms, geomint.watch.observe;"
        "print('numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]


def test_plain_python_gets_the_recorded_functions() -> None:
    field = Bound(count_rows, FIELD)
    assert field.entry(False) is count_rows
    kernel = Bound(
        gi.helper(lambda f, x: f == (count_rows,) and x == 2), takes(f=Functions((FIELD,)), x=WHOLE)
    )
    assert kernel.call(compiled=False, f=(field,))(x=2)
