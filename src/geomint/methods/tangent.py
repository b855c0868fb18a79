"""Steppers in tangent numbers: which ones, and how many directions at once."""

from ..kernels.compiling.number_types import NumberType, tangent, tangent_lanes
from .flow import Flow

AT_ONCE = 8  # directions: a lane value of slopes, or what an iteration gains little from beyond


def directions_at_once(flow: Flow, directions: int) -> int:
    """Return how many directions a step carries at once, of so many.

    Slopes in a lane value cost the same however many are used; beside stages in lanes each counts.
    """
    if not flow.stages_in_lanes:
        return AT_ONCE
    passes = max(-(-directions // AT_ONCE), 1)
    return max(-(-directions // passes), 1)


def tangent_type(flow: Flow, at_once: int, by_params: bool = False) -> NumberType:
    """Return the numbers in which a flow takes steps with so many directions."""
    made = tangent_lanes if flow.stages_in_lanes else tangent
    return made(at_once, by_params)
