"""What the sweep of `geomint.kernels.measure.measure` works with: nodes of differences, blocks."""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Any

from ..compiling.recorded import inlined
from ..numbers.blocks import REST, Block, packed, scalar_block, section, sections

__all__ = [
    "CONDITIONS_LARGEST",
    "EPSILON",
    "LARGEST",
    "NODES",
    "UNIT",
    "Lanes",
    "Memory",
    "Sizes",
    "Work",
    "lane_layout",
    "measure_given",
    "measure_memory",
    "memory_layout",
    "pieces_of",
    "sizes_of",
    "work_layout",
]

# Three rows of eight: the nodes j, the weights of 840 times the derivative, those of the seventh
# difference. Rounded weights would scale all derivatives by the same 1e-16: a bias, not a noise.
NODES = (
    (1.0, 2.0, 3.0, 4.0, -1.0, -2.0, -3.0, -4.0),
    (672.0, -168.0, 32.0, -3.0, -672.0, 168.0, -32.0, 3.0),
    (-7.0, 7.0, -3.0, 0.5, 7.0, -7.0, 3.0, -0.5),
)
UNIT = 840.0

LARGEST = 2.0**-3  # spacing of the differences of steps
CONDITIONS_LARGEST = 2.0**-3  # and of conditions
EPSILON = 2.0**-52

# Rows of the state, of the stepper's; conditions; rows of memory and of work of the method in lanes,
# of scratch of the problem.
Sizes = namedtuple("Sizes", "n rows m memory_rows work_rows scratch")
Given = namedtuple("Given", "nodes n rows m memory_rows work_rows scratch pieces")
Memory = namedtuple(
    "Memory",
    "sum carry variance bias steps begun origin condition_spacing"
    " state scales condition_scales spacings roundings old new",
)
Lanes = namedtuple("Lanes", "memory work nodes carries values scratch")
Work = namedtuple("Work", "E Z G q D x values gradients scratch")

GIVEN = Given(24, 1, 1, 1, 1, 1, 1, REST)


@inlined
def sizes_of(given: Any) -> Sizes:
    """Return the sizes that are given to the sweep."""
    _, n, rows, m, memory_rows, work_rows, scratch, _ = sections(given, GIVEN)
    return Sizes(
        int(n[0]), int(rows[0]), int(m[0]), int(memory_rows[0]), int(work_rows[0]), int(scratch[0])
    )


@inlined
def pieces_of(given: Any) -> Any:
    """Return the numbers of the pieces that rows of the state belong to."""
    return section(given, GIVEN, "pieces")


@inlined
def memory_layout(s: Sizes) -> Memory:
    """Return the layout of what is kept from step to step, with two frames."""
    return Memory(
        sum=1,
        carry=1,
        variance=1,
        bias=1,
        steps=1,
        begun=1,
        origin=1,
        condition_spacing=1,
        state=s.rows,
        scales=s.n,
        condition_scales=s.m,
        spacings=s.n - s.m,
        roundings=s.n - s.m,
        old=1 + s.m * s.n,
        new=1 + s.m * s.n,
    )


@inlined
def lane_layout(s: Sizes) -> Lanes:
    """Return the layout of scratch in lanes: the method's, nodes with their carries, conditions'."""
    return Lanes(
        memory=s.memory_rows,
        work=s.work_rows,
        nodes=s.n,
        carries=s.n,
        values=s.m,
        scratch=s.scratch,
    )


@inlined
def work_layout(s: Sizes) -> Work:
    """Return the layout of scratch beside the lanes: E, Z, ZᵀZ, vectors; frames', the density's."""
    d = s.n - s.m
    return Work(
        E=d * d,
        Z=s.m * d,
        G=s.m * s.m,
        q=s.n,
        D=s.n,
        x=s.n,
        values=2 * s.m,
        gradients=s.m * s.n,
        scratch=s.scratch,
    )


def measure_given(pieces: Any, sizes: Sizes) -> Block:
    """Return the block of what is given to the sweep: nodes, sizes, the problem's pieces."""
    numbers = [float(i) for i, (_, size) in enumerate(pieces) for _ in range(size)]
    layout = GIVEN._replace(pieces=len(numbers))
    return packed(layout, nodes=NODES, pieces=numbers, **sizes._asdict())


def measure_memory(start: Any, scales: Any, sizes: Sizes) -> Block:
    """Return the memory at the start: `start` is the stepper's state, `scales` are of the problem's."""
    layout = memory_layout(sizes)
    block = scalar_block(sum(layout))
    powers = [2.0 ** math.ceil(math.log2(min(max(size, 1e-290), 1e290))) for size in scales]
    values = {
        "condition_spacing": CONDITIONS_LARGEST,
        "state": start,
        "scales": powers,
        "condition_scales": 1.0,
        "spacings": 0.5 * LARGEST,
    }
    for name, numbers in values.items():
        section(block, layout, name).data[:] = numbers
    return block
