"""What vectors of eight can gain at most here: multiply-adds a second, eight at once over single ones.

Loops of independent fused multiply-adds, in the numbers of the kernels. A processor that works on
vectors in halves gains 4, whatever the code; more is gained only where single numbers wait for each
other.
"""

from __future__ import annotations

import time
from typing import Any

from geomint.kernels.compiling.bound import Bound
from geomint.kernels.compiling.number_types import LANE, SCALAR, NumberType
from geomint.kernels.compiling.recorded import helper
from geomint.kernels.compiling.signatures import MEMORY, WHOLE, OfType, takes
from geomint.kernels.numbers.arithmetic import fma
from geomint.kernels.numbers.blocks import Block, scalar_block
from geomint.kernels.numbers.lanes import LANES

__all__ = ["vector_limit"]

ROUNDS, REPEATS = 200_000, 40


@helper
def eight_chains(y: Any, rounds: int) -> None:
    """Eight multiply-adds a round, none of which waits for another."""
    a, b, c, d, e, f, g, h = y[0], y[1], y[2], y[3], y[4], y[5], y[6], y[7]
    for _ in range(rounds):
        a, b, c, d = fma(a, y[8], y[9]), fma(b, y[8], y[9]), fma(c, y[8], y[9]), fma(d, y[8], y[9])
        e, f, g, h = fma(e, y[8], y[9]), fma(f, y[8], y[9]), fma(g, y[8], y[9]), fma(h, y[8], y[9])
    y[0] = a + b + c + d + e + f + g + h


def _rate(numbers: NumberType, width: int) -> float:
    data = scalar_block(10 * width).data
    data[:] = 0.5
    rows: Block = numbers.memory.held(data if width == 1 else data.reshape(10, width))
    taken = takes(None, y=OfType(MEMORY, numbers), rounds=WHOLE)
    call = Bound(eight_chains, taken).call(True, y=rows, rounds=ROUNDS)
    call()
    seconds = []
    for _ in range(REPEATS):
        begun = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begun)
    return 8 * ROUNDS * width / min(seconds)


def vector_limit() -> dict[str, float]:
    """Return multiply-adds a second of single numbers and of lanes, and their ratio."""
    single, lanes = _rate(SCALAR, 1), _rate(LANE, LANES)
    return {"single": single, "lanes": lanes, "gain": lanes / single}


if __name__ == "__main__":
    print(vector_limit())
