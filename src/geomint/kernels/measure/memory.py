"""What the sweep of `geomint.kernels.measure.measure` works with: nodes of differences, blocks.

`layout` holds the nodes; then rows of the state, of the stepper's, conditions, rows of the lane memory
and of the lane work of the method, rows of scratch of the problem; then the pieces. `memory` holds the
numbers named here, then state, scales, scales of the conditions, spacings, roundings, two frames.
"""

from __future__ import annotations

import math
from typing import Any

from ..numbers.blocks import scalar_block

__all__ = [
    "BEGUN",
    "BIAS",
    "CARRY",
    "CONDITIONS_LARGEST",
    "CONDITION_SPACING",
    "EPSILON",
    "HEADER",
    "LARGEST",
    "LAYOUT",
    "NODES",
    "ORIGIN",
    "OWN",
    "STEPS",
    "SUM",
    "UNIT",
    "VARIANCE",
    "lane_rows",
    "measure_layout",
    "measure_memory",
    "work_size",
]

# Three rows of eight: the nodes j, the weights of 840 times the derivative, those of the seventh
# difference. Rounded weights would scale all derivatives by the same 1e-16: a bias, not a noise.
NODES = (
    (1.0, 2.0, 3.0, 4.0, -1.0, -2.0, -3.0, -4.0),
    (672.0, -168.0, 32.0, -3.0, -672.0, 168.0, -32.0, 3.0),
    (-7.0, 7.0, -3.0, 0.5, 7.0, -7.0, 3.0, -0.5),
)
UNIT = 840.0

LAYOUT = 24
HEADER = LAYOUT + 6
SUM, CARRY, VARIANCE, BIAS, STEPS, BEGUN, ORIGIN, CONDITION_SPACING = range(8)
OWN = 8

LARGEST = 2.0**-3  # spacing of the differences of steps
CONDITIONS_LARGEST = 2.0**-3  # and of conditions
EPSILON = 2.0**-52


def measure_layout(
    pieces: Any, rows: int, m: int, memory_rows: int, work_rows: int, scratch: int
) -> Any:
    """Return the block of sizes: the problem's pieces, the stepper's rows, m conditions, the lanes'."""
    n = sum(size for _, size in pieces)
    numbers = [w for row in NODES for w in row] + [n, rows, m, memory_rows, work_rows, scratch]
    numbers += [float(i) for i, (_, size) in enumerate(pieces) for _ in range(size)]
    block = scalar_block(len(numbers))
    block.data[:] = numbers
    return block


def measure_memory(start: Any, sizes: Any, m: int) -> Any:
    """Return the memory at the start: `start` is the stepper's state, `sizes` the problem's rows'."""
    n, rows = len(sizes), len(start)
    at = OWN + rows + n + m
    d = n - m
    block = scalar_block(at + 2 * d + 2 * (m * n + 1))
    block.data[CONDITION_SPACING] = CONDITIONS_LARGEST
    block.data[OWN : OWN + rows] = start
    for i in range(n):
        block.data[OWN + rows + i] = 2.0 ** math.ceil(math.log2(min(max(sizes[i], 1e-290), 1e290)))
    block.data[at - m : at] = 1.0
    block.data[at : at + d] = 0.5 * LARGEST
    return block


def lane_rows(n: int, m: int, memory_rows: int, work_rows: int, scratch: int) -> int:
    """Lane rows of scratch: the method's, the nodes with their carries, the conditions'."""
    return memory_rows + work_rows + 2 * n + m + scratch


def work_size(n: int, m: int, scratch: int) -> int:
    """Numbers of scratch beside the lanes: E, Z, ZᵀZ, gradients, three vectors, the density's."""
    d = n - m
    return d * d + m * d + m * m + m * n + 2 * m + 3 * n + scratch
