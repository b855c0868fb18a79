"""What a Gauss method remembers of its last step."""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint.kernels.solve.gauss import gauss_memory
from geomint.methods.gauss import lane_positions


def increments(motion: gi.Integrator, stages: int) -> Any:
    """Return the increments of its stages, a stage a row."""
    groups = 1 if stages <= 8 else 2
    rows = motion.stepper.rows
    numbers = gi.section(motion.stepper.memory, gauss_memory(rows, groups), "stages").data
    lanes = np.concatenate(list(numbers.reshape(groups, rows, 8)), axis=1).T
    return lanes[lane_positions(stages, 8 * groups)]
