"""What a run leaves behind, so that it can go on."""

from dataclasses import dataclass, field

import numpy as np

from ..arguments import Array
from ..kernels.compiling.sameness import Compared

_NO_TIMES, _NO_STATES = np.zeros(0), np.zeros((0, 0))


@dataclass(frozen=True, eq=False, repr=False)
class Restart(Compared):
    """All that the next step depends on: with it a run goes on as if it had never stopped.

    Attributes
    ----------
    memory : array
        That of the stepper: state, carries of compensated sums, what the method remembers. Of the exact
        flow: the state where the motion was begun; physical time here and there, own time here.
    start, h : float
        After `done` steps the problem's own time is ``start + done h``; an adaptive method has its
        own in `memory`.
    done : int
    clock : bool
        Whether physical time is integrated beside the state.
    seen : float or None
        The problem's own time up to which events have been told.
    told : dict of name to list of (time, direction)
        Those told last, where it ended: to rounding they would be beyond `seen`.
    times, states : array
        The nodes before, as far as events look back.
    wanted : float or None
        What the end was to err by, or 0 where each step was to err by no more than is promised of a
        method; None of a step that was given.
    """

    memory: Array
    start: float
    h: float
    done: int
    clock: bool
    seen: float | None = None
    told: dict[str, list[list[float]]] = field(default_factory=dict)
    times: Array = field(default_factory=lambda: _NO_TIMES)
    states: Array = field(default_factory=lambda: _NO_STATES)
    wanted: float | None = None
