"""What a user's function is told between the chunks of a run, which it may end."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import DomainError, WatcherError, raised, shortened
from ..kernels.compiling.sameness import Compared


@dataclass(frozen=True, eq=False)
class Reached(Compared):
    """Where a run has got to.

    Attributes
    ----------
    tau : float
        The problem's own time (equal to `t` unless that is τ).
    t : float or None
        Physical time, where it is integrated.
    y : array, shape (rows,)
        The state there, after a whole step.
    steps : int
        How many have been taken, since the state that the run began with.
    """

    tau: float
    t: float | None
    y: Array
    steps: int


Callback = Callable[[Reached], Any]


@dataclass(eq=False)
class Ending:
    """A callback of geomint's own, which ends runs once `stop` is not 0; these may begin anew."""

    stop: Array
    ended: bool = False

    def __call__(self, _: Reached) -> bool:
        """Tell whether the run ends."""
        self.ended = self.ended or bool(self.stop[0] != 0.0)
        return self.ended


def check_callback(given: Any) -> Callback | None:
    """Return a callback, or raise `DomainError` for what cannot be called."""
    if given is None:
        return None
    if callable(given):
        return given
    raise DomainError("callback", given, "a function f(reached), which may return True")


def asked_to_end(callback: Callback, reached: Reached) -> bool:
    """Ask a callback whether the run ends; raise `WatcherError` if it fails, or answers otherwise."""
    try:
        answer = callback(reached)
        if answer is None or isinstance(answer, bool | np.bool_):
            return bool(answer)
        said = shortened(repr(answer), 60)
        raise TypeError(f"it returned {said}: expected True, False or None")
    except Exception as error:  # whatever a user's function raises
        what = raised(error)
        raise WatcherError("callback", reached.tau, what) from error
