"""Statistics of a long series in windows, in memory that does not grow with its length."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..arguments import Array
from ..kernels.compiling.sameness import Compared

__all__ = ["MAX_WINDOWS", "NOTHING", "Windows"]

MAX_WINDOWS = 1024
NOTHING = np.zeros((2, 0))  # after the last full window


@dataclass(eq=False)
class Windows(Compared):
    """The deviations of a series from its first value, reduced window by window.

    Windows begin one sample long; whenever `MAX_WINDOWS` are full, neighbours merge and the length
    doubles. The result does not depend on how the series is cut into chunks.

    Attributes
    ----------
    initial : float
        The first value; deviations are taken from it.
    last_time, last : float
        Time and deviation of the last sample; the time of `initial` before there is any.
    length, samples : int
        Samples a window, and of the whole series.
    max_abs : float
        The largest absolute deviation.
    not_finite_from : float or None
        Time of the first value that was infinite or not a number: that of `initial` if it is the first.
    closed : array, shape (3, N)
        The rows times, means, maxima of the full windows.
    last_window : array, shape (2, M)
        The rows times, deviations of the samples after the last full window. Without them nothing can
        be added.
    """

    initial: float
    last_time: float = 0.0
    last: float = 0.0
    length: int = 1
    samples: int = 0
    max_abs: float = 0.0
    not_finite_from: float | None = None
    closed: Array = field(default_factory=lambda: np.zeros((3, 0)))
    last_window: Array = field(default_factory=lambda: NOTHING)

    def __post_init__(self) -> None:
        if self.not_finite_from is None and not np.isfinite(self.initial):
            self.not_finite_from = self.last_time

    def add(self, times: Array, values: Array) -> None:
        """Append samples."""
        if not len(values):
            return
        with np.errstate(over="ignore", invalid="ignore"):
            self._add(times, values - self.initial)

    def _add(self, times: Array, deviations: Array) -> None:
        self.samples += len(deviations)
        self.last, self.last_time = float(deviations[-1]), float(times[-1])
        self.max_abs = float(np.maximum(self.max_abs, np.abs(deviations).max()))  # keeps a NaN
        if self.not_finite_from is None and not np.isfinite(self.max_abs):
            self.not_finite_from = float(times[np.argmin(np.isfinite(deviations))])
        if self.last_window.size:
            times, deviations = np.concatenate((self.last_window, (times, deviations)), axis=1)
        while len(deviations) >= self.length:
            room = MAX_WINDOWS - self.closed.shape[1]
            whole = min(len(deviations) // self.length, room)
            used = whole * self.length
            closed = times[:used], deviations[:used], np.abs(deviations[:used])
            if self.length > 1:
                time, mean, largest = (x.reshape(whole, self.length) for x in closed)
                closed = _means(time), _means(mean), largest.max(axis=1)
            self.closed = np.concatenate((self.closed, closed), axis=1)
            deviations, times = deviations[used:], times[used:]
            if self.closed.shape[1] == MAX_WINDOWS:
                self._merge()
        self.last_window = np.array((times, deviations)) if len(times) else NOTHING

    def _merge(self) -> None:
        time, mean, largest = self.closed.reshape(3, -1, 2)
        self.closed = np.array([_means(time), _means(mean), largest.max(axis=1)])
        self.length *= 2

    @property
    def in_order(self) -> bool:
        """Whether the times of the windows are finite and go on in one direction."""
        times = self.times
        if not (np.isfinite(times).all() and np.isfinite(self.last_time)):
            return False
        later, earlier = times[1:], times[:-1]
        one_way = bool((later >= earlier).all() or (later <= earlier).all())
        return len(times) <= 1 or (one_way and bool(times[0] != times[-1]))

    @property
    def times(self) -> Array:
        """Mean time of each full window."""
        return np.asarray(self.closed[0])

    @property
    def means(self) -> Array:
        """Mean deviation of each full window."""
        return np.asarray(self.closed[1])

    @property
    def maxima(self) -> Array:
        """Largest absolute deviation in each full window."""
        return np.asarray(self.closed[2])


def _means(rows: Array) -> Array:
    """Return the mean of each row, also where the sum is too large for a float."""
    means = np.asarray(rows.mean(axis=1))
    large = ~np.isfinite(means)
    means[large] = (rows[large] / rows.shape[1]).sum(axis=1)
    return means
