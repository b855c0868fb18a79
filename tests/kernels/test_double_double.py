"""Double-double numbers against mpmath, one number and eight at a time."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from numba.core import types

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import EXTENDED
from geomint.kernels.compiling.signatures import FIELD
from geomint.kernels.numbers.blocks import as_lanes, scalar_block
from geomint.kernels.numbers.double_double import DoubleDoubleBlock, lane_rows

DIGITS = 2.0**-100  # relative; the operations promise about 2⁻¹⁰⁴


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


def exact(x, z, params):
    third, tenth = mp.mpf(3.0), mp.mpf(0.1)
    return [
        x + z,
        x - z,
        x * z,
        x / z,
        mp.sqrt(x * x + z * z),
        mp.sin(x),
        mp.cos(x),
        abs(x) + 1,
        tenth * x - z / third,
        max(x, z),
        min(x, z),
        mp.mpf(params[0]) * x + 2,
        mp.tan(x),
        mp.atan2(z, x),
        mp.exp(x / 8),
        mp.log(abs(z)),
        abs(z) ** (x / 32),
        x**3,
        mp.tanh(z),
        1,
    ]


ROWS = 20


@pytest.fixture(scope="module", autouse=True)
def _precision():
    with mp.workdps(60):
        yield


def pairs(rng, size, scale):
    hi = scale * rng.standard_normal(size)
    return hi, hi * 2.0**-53 * rng.uniform(-0.9, 0.9, size)


@pytest.mark.parametrize("scale", [1e-8, 1.0, 30.0, 300.0])
def test_eight_at_a_time_agree_with_mpmath(scale):
    rng = np.random.default_rng(1)
    entry = compile_function(operations, FIELD.of(EXTENDED))
    hi, lo = pairs(rng, (2, 8), scale)
    y = DoubleDoubleBlock(scalar_block(2 * 16).data)
    y.data[:] = lane_rows(hi.ravel(), lo.ravel())
    out = DoubleDoubleBlock(scalar_block(2 * 8 * ROWS).data)
    params = scalar_block(1)
    params.data[0] = 0.7

    # Blocks of lanes are made inside compiled code only: a small entry does it.
    runner = compile_function(
        run_in_lanes,
        types.void(
            types.FunctionType(FIELD.of(EXTENDED)),
            EXTENDED.given,
            EXTENDED.memory,
            EXTENDED.memory,
        ),
    )
    runner(entry, params, y, out)
    result = out.data.reshape(ROWS, 2, 8)
    for i in range(8):
        x, z = (mp.mpf(hi[r, i]) + mp.mpf(lo[r, i]) for r in range(2))
        for row, truth in enumerate(exact(x, z, params.data)):
            found = mp.mpf(result[row, 0, i]) + mp.mpf(result[row, 1, i])
            # Sines of large arguments lose what the argument's own rounding loses.
            size = max(abs(truth), abs(x) if row in (5, 6) else 0, abs(x) if row < 2 else 0)
            size *= {
                12: 1 + abs(x) / abs(mp.sin(x)),
                14: 1 + abs(x),
                16: 1 + abs(x * mp.log(abs(z))),
            }.get(row, 1)
            size = max(size, 1 if row in (15, 18) else 0)
            assert abs(found - truth) <= DIGITS * max(size, abs(z) if row < 2 else 0), row


@gi.helper
def run_in_lanes(f, params, y, out):
    lanes = as_lanes(y, 0, 2)
    f(params, 0.0 * lanes[0], lanes, as_lanes(out, 0, ROWS), as_lanes(out, 0, 0))
