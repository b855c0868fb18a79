"""What a Gauss method remembers of its last step."""

from __future__ import annotations

from typing import Any

import numpy as np

from geomint.methods.gauss import lane_positions


def increments(stepper: Any, stages: int) -> Any:
    """Return the increments of its stages, a stage a row: they are the end of its memory, in lanes."""
    groups, rows = 1 if stages <= 8 else 2, stepper.rows
    numbers = stepper.memory.data[-8 * groups * rows :].reshape(groups, rows, 8)
    return np.concatenate(list(numbers), axis=1).T[lane_positions(stages, 8 * groups)]
