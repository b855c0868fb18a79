"""Readings of the states along a run, and of the last of them."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ....arguments import Array, as_array, whole
from ....errors import DomainError
from ....problems.problem import Problem
from ....watch.birkhoff import FEWEST, birkhoff_average
from ....watch.frequencies import frequencies
from ...events import quantity
from ..given import Asked
from .reading import Ran, Reading

STEADY = 1e-9  # of its size: what varies by less has no frequency


@dataclass(frozen=True)
class OfQuantity(Reading):
    """A reading of one component of the state, ``"gamma[2]"``, or one quantity of the problem."""

    of: str
    kind: ClassVar[str] = ""
    along = True

    @property
    def name(self) -> str:
        return f"{self.kind}:{self.of}"

    def check(self, problem: Problem, asked: Asked) -> None:
        quantity(problem, self.of, "readings")


class Final(OfQuantity):
    """``final:NAME``: its value at the end."""

    kind = "final"
    along = False

    def read(self, ran: Ran) -> Array:
        return ran.found.last_of(ran.series(self.of))


class Drift(OfQuantity):
    """``drift:NAME``: its largest deviation from its first value, at the saved states."""

    kind = "drift"

    def read(self, ran: Ran) -> Array:
        values = ran.series(self.of)
        with np.errstate(invalid="ignore"):  # ∞ − ∞, of which there is no number
            return _reduced(np.maximum, np.abs(values - values[:, :1]), ran)


class Lowest(OfQuantity):
    """``lowest:NAME``: its least value at the saved states."""

    kind = "lowest"

    def read(self, ran: Ran) -> Array:
        return _reduced(np.minimum, ran.series(self.of), ran)


class Highest(OfQuantity):
    """``highest:NAME``: its largest value at the saved states."""

    kind = "highest"

    def read(self, ran: Ran) -> Array:
        return _reduced(np.maximum, ran.series(self.of), ran)


def _reduced(function: np.ufunc, values: Array, ran: Ran) -> Array:
    """Return the largest or least of each member's states; NaN where one of these has no number."""
    last = np.maximum(ran.found.counts - 1, 0)
    filled = np.arange(values.shape[1]) <= last[:, None]  # a member has fewer states than others
    return function.reduce(np.where(filled, values, values[:, :1]), axis=1)


class OfEvenSamples(OfQuantity):
    """A reading of samples at equal steps."""

    fewest = FEWEST

    def check(self, problem: Problem, asked: Asked) -> None:
        super().check(problem, asked)
        if asked.method.adaptive and asked.times is None:
            expected = "states at equal steps, which need t_eval or tau_eval"
            raise DomainError("readings", self.name, f"with {asked.method.name}: {expected}")

    def read(self, ran: Ran) -> Array:
        values, read = ran.series(self.of), np.full(len(ran), np.nan)
        for k in ran.ended:
            count, gap = ran.even(k)
            samples = values[k, :count]
            if count >= self.fewest and np.isfinite(samples).all():
                read[k] = self.of_samples(samples, gap)
        return read

    @abstractmethod
    def of_samples(self, samples: Array, gap: float) -> float:
        """Return what is read off samples of one member, `gap` apart."""


class Mean(OfEvenSamples):
    """``mean:NAME``: its average along the motion, by `geomint.birkhoff_average`."""

    kind = "mean"

    def of_samples(self, samples: Array, gap: float) -> float:
        return float(birkhoff_average(samples).value)


class Digits(OfEvenSamples):
    """``digits:NAME``: in how many digits that average has converged: few along chaotic motions."""

    kind = "digits"

    def of_samples(self, samples: Array, gap: float) -> float:
        return birkhoff_average(samples).digits


class Frequency(OfEvenSamples):
    """``frequency:NAME``: of its largest term beside the mean, in radians per unit of own time.

    Of physical time where states are at `t_eval`. By `geomint.frequencies`; NaN for what does not vary.
    """

    kind = "frequency"

    def of_samples(self, samples: Array, gap: float) -> float:
        if not np.ptp(samples) > STEADY * np.abs(samples).max():
            return np.nan
        rest = samples - birkhoff_average(samples).value
        found = frequencies(rest, abs(gap))
        return abs(found[0].frequency) if found else np.nan


@dataclass(frozen=True)
class Windows(OfQuantity):
    """The root of the mean square of a quantity's deviation from its first value, window by window.

    Parameters
    ----------
    of : str
    count : int
        Windows of equal numbers of saved states, the first state not counted.
    """

    count: int = 32
    kind = "windows"

    def check(self, problem: Problem, asked: Asked) -> None:
        super().check(problem, asked)
        whole("count", self.count, 1)

    def read(self, ran: Ran) -> Array:
        values, read = ran.series(self.of), np.full((len(ran), self.count), np.nan)
        for k in ran.ended:
            with np.errstate(invalid="ignore"):
                off = values[k, 1 : ran.found.counts[k]] - values[k, 0]
            parts = np.array_split(off, self.count)
            read[k] = [np.sqrt(np.mean(p * p)) if len(p) else np.nan for p in parts]
        return read


@dataclass(frozen=True, eq=False)
class Histogram(OfQuantity):
    """How many saved states of all members have values of a quantity between given edges.

    Parameters
    ----------
    of : str
    edges : array_like, shape (bins + 1,)
        Rising. A value on an edge belongs to the bin above it, on the last to the last.
    """

    edges: Any = ()
    kind = "histogram"
    merges = True

    def check(self, problem: Problem, asked: Asked) -> None:
        super().check(problem, asked)
        expected = "at least two rising numbers"
        edges = as_array("edges", self.edges, expected)
        if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
            raise DomainError("edges", self.edges, expected)

    def read(self, ran: Ran) -> Array:
        values = ran.series(self.of)
        counts, _ = np.histogram(values[np.isfinite(values)], np.asarray(self.edges, float))
        return counts
