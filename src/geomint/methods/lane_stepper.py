"""A method's step for eight trajectories at once: one lane each."""

from __future__ import annotations

from dataclasses import dataclass

from ..kernels.compiling.bound import Bound
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block

__all__ = ["LaneStepper"]


@dataclass(frozen=True)
class LaneStepper:
    """What `Stepper.lanes` returns: the loop of `geomint.kernels.solve.advance`, to compile for lanes.

    Attributes
    ----------
    kernel : Recorded
        Its memory and work are blocks of lane values; params, coefficients and fractions are not.
        The first rows of memory are the states, the next the carries; what follows may hold
        anything finite, such as what steps from other states have left there.
    functions : tuple of Bound
        What it takes, for lanes like itself.
    memory_rows, work_rows : int
        Lane values, one a row.
    """

    kernel: Recorded
    functions: tuple[Bound, ...]
    coefficients: Block
    memory_rows: int
    work_rows: int
