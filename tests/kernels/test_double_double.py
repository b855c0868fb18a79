"""Double-double numbers against mpmath, eight at a time."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from numba.core import types

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import EXTENDED
from geomint.kernels.numbers.blocks import Block, as_lanes

DIGITS = 2.0**-100  # relative; the operations promise about 2⁻¹⁰⁴
ROWS = 20


@gi.helper
def operations(params, t, y, out, work):
    x, z = y[0], y[1]
    out[0] = x + z
    out[1] = x - z
    out[2] = x * z
    out[3] = x / z
    out[4] = gi.sqrt(x * x + z * z)
    out[5] = gi.sin(x)
    out[6] = gi.cos(x)
    out[7] = abs(-x) + 1
    out[8] = 0.1 * x - z / 3.0
    out[9] = gi.maximum(x, z)
    out[10] = gi.select(x < z, x, z)
    out[11] = params[0] * x + 2
    out[12] = gi.tan(x)
    out[13] = gi.atan2(z, x)
    out[14] = gi.exp(x / 8.0)
    out[15] = gi.log(abs(z))
    out[16] = gi.pow(abs(z), x / 32.0)
    out[17] = gi.pow(x, 3)
    out[18] = gi.tanh(z)
    out[19] = gi.pow(x - x, 0.5) + gi.pow(-abs(x), 0.0)


@gi.helper
def run_in_lanes(f, params, y, out):
    """Blocks of lanes are made inside compiled code only."""
    lanes = as_lanes(y, 0, 2)
    f(params, 0.0 * lanes[0], lanes, as_lanes(out, 0, ROWS), as_lanes(out, 0, 0))


@pytest.mark.parametrize("scale", [1e-8, 1.0, 30.0, 300.0])
def test_eight_at_a_time_agree_with_mpmath(scale: float) -> None:
    """What plain Python gives for numbers of 60 digits; the function is the same."""
    rng, number, block = np.random.default_rng(1), EXTENDED.number, EXTENDED.block
    field = types.void(EXTENDED.given, number, block, block, block)
    signature = types.FunctionType(field), EXTENDED.given, EXTENDED.memory, EXTENDED.memory
    run = compile_function(run_in_lanes, types.void(*signature))
    high = scale * rng.standard_normal((2, 8))
    low = high * 2.0**-53 * rng.uniform(-0.9, 0.9, (2, 8))
    held, params = EXTENDED.memory.held, Block(np.array([0.7]))
    y, out = held(np.stack([high, low], axis=1).ravel()), held(np.zeros(16 * ROWS))
    run(compile_function(operations, field), params, y, out)
    found = out.data.reshape(ROWS, 2, 8)
    with mp.workdps(60):
        for i in range(8):
            x, z = (mp.mpf(high[r, i]) + mp.mpf(low[r, i]) for r in range(2))
            exact = Block(np.zeros(ROWS, dtype=object))
            operations(params, mp.mpf(0), Block(np.array([x, z])), exact, exact)
            for row, truth in enumerate(exact.data):
                # Some lose what the rounding of their arguments loses.
                size = max(abs(truth), {5: abs(x), 6: abs(x), 15: 1, 18: 1}.get(row, 0))
                size = max(size, abs(x), abs(z)) if row < 2 else size
                size *= {
                    12: 1 + abs(x) / abs(mp.sin(x)),
                    14: 1 + abs(x),
                    16: 1 + abs(x * mp.log(abs(z))),
                }.get(row, 1)
                error = abs(mp.mpf(found[row, 0, i]) + mp.mpf(found[row, 1, i]) - truth)
                assert error <= DIGITS * size, row
