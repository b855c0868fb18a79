"""States at the times that were asked for, beside the steps of a run."""

import numpy as np

from ..arguments import Array
from ..errors import LeftOutWarning, tell
from ..methods.partial import Found, Nodes, PartialSteps
from .saved import Saved


def tell_missed(missed: int, last: float, reached: float) -> None:
    """Warn of wanted times, up to the last, that come after the end of a run."""
    text = (
        f"the run ended at t = {reached:.9g}, before {missed} of the times in t_eval, up to "
        f"{last:.9g}: give a later end, or earlier times"
    )
    tell(LeftOutWarning(text, "t_eval", missed, reached))


class Wanted:
    """Wanted times of a run, and the states there: partial steps from the step before.

    Parameters
    ----------
    times : array
        In the order of the run; none where nothing is wanted.
    sign : float
        Of the direction of the run.
    clock : bool
        Whether they are times of the clock.
    """

    def __init__(self, partial: PartialSteps, times: Array, sign: float, clock: bool) -> None:
        self._partial, self._times, self._sign, self.clock = partial, times, sign, clock
        self._next = 0
        self._found: list[Saved] = []

    def __len__(self) -> int:
        return len(self._times)

    @property
    def missed(self) -> int:
        """How many are still to come."""
        return len(self._times) - self._next

    @property
    def last(self) -> float:
        """The last of them."""
        return float(self._times[-1])

    def take(self, nodes: Nodes) -> None:
        """Find the states at all times up to the last node; raise the `StepError` of one that fails."""
        if not self.missed or not len(nodes.times):
            return
        sign, known = self._sign, nodes.clock if self.clock else nodes.times
        ahead = sign * self._times[self._next :]
        wanted = self._times[self._next :][: np.searchsorted(ahead, sign * known[-1], side="right")]
        if len(wanted):
            found = self.at(nodes, wanted, self.clock)
            self._found.append(Saved(found.times, found.states))
            self._next += len(found.times)
            if found.error is not None:
                raise found.error

    def at(self, nodes: Nodes, wanted: Array, clock: bool) -> Found:
        """Return the states at these times, each from the last node before it."""
        at = nodes.before(wanted, self._sign, clock)
        taken = self._partial.to_clock if clock else self._partial.to_times
        return taken(nodes, at, wanted)

    def found(self, rows: int) -> Saved:
        """Return all states so far, as they were asked for."""
        return Saved.joined(self._found, rows)
