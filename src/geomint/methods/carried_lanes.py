"""Directions of eight steps at once, for steppers that work lane by lane."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arguments import Array
from ..kernels.compiling.number_types import LANE, NumberType, tangent_members
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.numbers.lanes import LANES
from ..kernels.tangent.lane_steps import lane_work_layout
from ..problems.problem import Problem
from .carried import Carried
from .stepper import Stepper
from .supports import find_supports

__all__ = ["CarriedLanes"]

AT_ONCE = (
    2  # directions: more of them leave registers (15 rows: 1.7 microseconds with 8, 0.8 with 2)
)
MOST_ROWS = 32  # of a state: tables of more leave the nearest cache


class CarriedLanes(Carried):
    """As `Carried`, of eight steps: `kept` has no directions, every step begins with its own."""

    @staticmethod
    def fits(problem: Problem, stepper: Stepper) -> bool:
        """Tell whether steps can be taken so."""
        return stepper.lane_by_lane and problem.rows <= MOST_ROWS

    def _types(self, stepper: Stepper, d: int) -> tuple[int, NumberType, NumberType]:
        numbers = tangent_members(AT_ONCE)
        return AT_ONCE, numbers, numbers

    def _supports(self, problem: Problem, conditions: Recorded | None, y0: Array) -> Any:
        return np.concatenate(find_supports(problem, conditions, self.sizes.m, y0))

    @property
    def _groups(self) -> int:
        return 1

    def _work(self) -> Block:
        work = scalar_block(sum(lane_work_layout(self.sizes)) * LANES)
        block: Block = LANE.memory.held(work.data.reshape(-1, LANES))
        return block

    def _room(self, numbers: NumberType, rows: int) -> tuple[Block, Block]:
        held = numbers.memory.held
        plain = scalar_block(rows * held.width * LANES)
        return held(plain.data.reshape(rows, held.width, LANES)), plain
