"""What a run leaves behind, so that it can go on."""

from __future__ import annotations

from dataclasses import dataclass

from ..arguments import Array
from ..kernels.compiling.sameness import Compared

__all__ = ["Restart"]


@dataclass(frozen=True, eq=False, repr=False)
class Restart(Compared):
    """All that the next step depends on: with it a run goes on as if it had never stopped.

    Attributes
    ----------
    memory : array
        That of the stepper: state, carries of compensated sums, what the method remembers.
    start, h : float
        After `done` steps the problem's own time is ``start + done h``; an adaptive method has its
        own in `memory`.
    done : int
    clock : bool
        Whether physical time is integrated beside the state.
    """

    memory: Array
    start: float
    h: float
    done: int
    clock: bool
