"""What is read off members while their states are at hand, so that these need not be kept."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ....arguments import Array, Integers, as_array
from ....errors import DomainError, GeomintError, raised
from ....problems.at_states import values_at
from ....problems.problem import Problem
from ...events import component, quantity
from ..given import Asked, Members
from ..outcome import ENDED_EARLY, Outcome

EVEN = 1e-6  # of a step: by that much steps of one length may differ
ROUNDED = 4.0  # units in the last place of the times: so much beside


@dataclass(frozen=True, eq=False)
class Ran:
    """Some members of an ensemble, and what has become of them: what readings look at.

    Attributes
    ----------
    given, asked
        The members, and what is asked of all.
    found : Outcome
        Arrays with an axis of members; states along the runs if a reading needs them.
    stop : array
        Not 0 after Ctrl-C: then what is left may stay NaN.
    shared : dict
        What a reading leaves for others of the same members.
    """

    given: Members
    asked: Asked
    found: Outcome
    stop: Array
    shared: dict[Any, Any] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.given)

    @property
    def ended(self) -> Integers:
        """The numbers of members that have come to their ends."""
        early = np.isin(self.found.status.astype(str), ENDED_EARLY)
        return np.flatnonzero(~early)

    def problem(self, k: int) -> Problem:
        """Return the problem of a member."""
        return self.given.problem(k)

    def series(self, name: str) -> Array:
        """Return a component or a quantity at all saved states, shape (members, samples).

        NaN where a member has fewer than others, and for members that have not come to their ends.
        """
        found, ended = self.found, self.ended
        values = np.full(found.tau.shape, np.nan)
        row = component(self.problem(0), name, "reading")
        if row is not None:
            values[ended] = found.y[ended, :, row]
            return values
        inside = np.arange(found.samples) < found.counts[:, None]
        alike = len(self.given.problems) == 1
        for which in [ended] if alike and len(ended) else ended[:, None]:
            problem, here = self.problem(which[0]), inside[which]
            function = quantity(problem, name, "reading")
            if len(which) == len(found.y) and here.all():  # all of it, as it lies
                states, times = found.y.reshape(-1, found.y.shape[2]), found.tau.reshape(-1)
                return values_at(problem, function, states, times).reshape(here.shape)
            of = np.full(here.shape, np.nan)
            of[here] = values_at(problem, function, found.y[which][here], found.tau[which][here])
            values[which] = of
        return values

    def even(self, k: int) -> tuple[int, float]:
        """Return how many saved states of a member are at equal steps, and the time between them.

        Physical time where states were asked for at such times. A last step that is shorter does not
        count.

        Raises
        ------
        DomainError
            For steps of other lengths.
        """
        physical = self.asked.wanted.get("t_eval") is not None
        times = (self.found.physical if physical else self.found.tau)[k, : self.found.counts[k]]
        gaps = np.diff(times)
        if not len(gaps):
            return len(times), 0.0
        rounded = ROUNDED * np.spacing(np.abs(times).max())  # more than that of a step, late
        uneven = np.flatnonzero(np.abs(gaps - gaps[0]) > EVEN * abs(gaps[0]) + rounded)
        if len(uneven) and uneven[0] < len(gaps) - 1:
            raise DomainError("readings", times, "states at equal steps, such as by tau_eval")
        count = len(times) - len(uneven)
        if rounded < EVEN * abs(gaps[0]):
            return count, float(gaps[0])
        return count, float((times[count - 1] - times[0]) / (count - 1))


class Reading(ABC):
    """A number, or an array of them, that is read off every member of an ensemble.

    Subclasses say what; `geomint.solve_ensemble` takes them as `readings`. They are sent to the
    workers of an executor, so that they have to be importable there.

    Attributes
    ----------
    along : bool
        Whether states along the run are needed, not only the last.
    merges : bool
        Whether what is read has no axis of members, and is added up: such as a histogram.
    fewest : int
        States at equal steps that it takes: of members with fewer a warning tells.
    """

    along: ClassVar[bool] = False
    merges: ClassVar[bool] = False
    fewest: ClassVar[int] = 1

    @property
    @abstractmethod
    def name(self) -> str:
        """What it is called unless it is given a name."""

    def check(self, problem: Problem, asked: Asked) -> None:
        """Raise `DomainError`, before anything is computed, for what cannot be read off."""

    @abstractmethod
    def read(self, ran: Ran) -> Any:
        """Return an array whose first axis is that of the members; NaN where there is nothing.

        What it says of members that have not come to their ends is not looked at: they have NaN.
        """


def read_off(ran: Ran, readings: dict[str, Reading]) -> None:
    """Write what is read off members to what was found of them, and forget the states between.

    Raises
    ------
    DomainError
        For a reading of a user that fails, or is no array of the right length.
    """
    found, early = ran.found, np.setdiff1d(np.arange(len(ran)), ran.ended)
    for name, reading in readings.items():
        expected = f"numbers, a row for each of {len(ran)} members"
        try:
            values = as_array(f"readings[{name!r}]", reading.read(ran), expected)
        except GeomintError:
            raise
        except Exception as error:  # whatever a user's reading raises
            said = f"{expected} ({raised(error)})"
            raise DomainError(f"readings[{name!r}]", reading, said) from error
        if not reading.merges and (values.ndim == 0 or len(values) != len(ran)):
            raise DomainError(f"readings[{name!r}]", values, expected)
        if not reading.merges and len(early):
            values = values.copy()  # it may be the reading's own
            values[early] = np.nan
        found.readings[name] = values
    if not ran.asked.keep_states:
        found.keep_last()
