"""Statistics of a long series in windows, in memory that does not grow with its length."""

from __future__ import annotations

import numpy as np

from ..arguments import Array
from ..kernels.compiling.sameness import Compared

__all__ = ["MAX_WINDOWS", "Windows"]

MAX_WINDOWS = 1024


class Windows(Compared):
    """The deviations of a series from its first value, reduced window by window.

    Windows begin one sample long; whenever `MAX_WINDOWS` are full, neighbours merge and the length
    doubles. The result does not depend on how the series is cut into chunks.

    Attributes
    ----------
    initial : float
        The first value; deviations are taken from it.
    length : int
        Samples a window.
    not_finite_from : float or None
        Time of the first value that was infinite or not a number: that of `initial` if it is the first.
    """

    def __init__(self, initial: float, start: float = 0.0) -> None:
        self.initial = initial
        self.length = 1
        self.samples = 0
        self.last = 0.0
        self.last_time = start
        self.max_abs = 0.0
        self.not_finite_from = None if np.isfinite(initial) else start
        self._open_values = np.zeros(0)
        self._open_times = np.zeros(0)
        # rows: mean time, mean deviation, largest |deviation|
        self._closed = np.zeros((3, 0))

    @classmethod
    def restored(
        cls,
        initial: float,
        length: int,
        samples: int,
        last: tuple[float, float],
        largest: float,
        closed: Array,
        not_finite_from: float | None = None,
    ) -> Windows:
        """Return windows as they were: `closed` are the rows times, means, maxima.

        What the last window had before it was full is not kept: nothing can be added.
        """
        windows = cls(initial)
        windows.length, windows.samples, windows.max_abs = length, samples, largest
        windows.last_time, windows.last = last
        windows._closed = closed
        windows.not_finite_from = not_finite_from
        return windows

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
        deviations = np.concatenate((self._open_values, deviations))
        times = np.concatenate((self._open_times, times))
        while len(deviations) >= self.length:
            room = MAX_WINDOWS - self._closed.shape[1]
            whole = min(len(deviations) // self.length, room)
            used = whole * self.length
            block = deviations[:used].reshape(whole, self.length)
            closed = (
                _means(times[:used].reshape(whole, self.length)),
                _means(block),
                np.abs(block).max(axis=1),
            )
            self._closed = np.concatenate((self._closed, closed), axis=1)
            deviations, times = deviations[used:], times[used:]
            if self._closed.shape[1] == MAX_WINDOWS:
                self._merge()
        self._open_values, self._open_times = deviations.copy(), times.copy()

    def _merge(self) -> None:
        time, mean, largest = self._closed.reshape(3, -1, 2)
        self._closed = np.array([_means(time), _means(mean), largest.max(axis=1)])
        self.length *= 2

    @property
    def in_order(self) -> bool:
        """Whether the times of the windows are finite and go on in one direction."""
        if not (np.isfinite(self.times).all() and np.isfinite(self.last_time)):
            return False
        steps = np.diff(self.times)
        one_way = bool(np.all(steps >= 0.0) or np.all(steps <= 0.0))
        return len(steps) == 0 or (one_way and bool(np.any(steps)))

    @property
    def times(self) -> Array:
        """Mean time of each full window."""
        return np.asarray(self._closed[0])

    @property
    def means(self) -> Array:
        """Mean deviation of each full window."""
        return np.asarray(self._closed[1])

    @property
    def maxima(self) -> Array:
        """Largest absolute deviation in each full window."""
        return np.asarray(self._closed[2])


def _means(rows: Array) -> Array:
    """Return the mean of each row, also where the sum is too large for a float."""
    means = np.asarray(rows.mean(axis=1))
    large = ~np.isfinite(means)
    means[large] = (rows[large] / rows.shape[1]).sum(axis=1)
    return means
