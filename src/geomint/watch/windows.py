"""Statistics of long series in windows, in memory that does not grow with their length."""

import math
from dataclasses import dataclass, field

import numpy as np

from ..arguments import Array
from ..kernels.compiling.sameness import Compared

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
        The rows times, deviations of the samples after the last full window.
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

    @property
    def in_order(self) -> bool:
        """Whether the times of the windows are finite and go on in one direction."""
        times = self.times.tolist()
        if not math.isfinite(sum(map(abs, times)) + abs(self.last_time)):
            return False
        ordered = sorted(times)
        one_way = ordered == times or ordered[::-1] == times
        return len(times) <= 1 or (one_way and times[0] != times[-1])

    @property
    def times(self) -> Array:
        """Mean time of each full window."""
        return self.closed[0]

    @property
    def means(self) -> Array:
        """Mean deviation of each full window."""
        return self.closed[1]

    @property
    def maxima(self) -> Array:
        """Largest absolute deviation in each full window."""
        return self.closed[2]


class Series:
    """Series of the same times, one a row, as they come: what their `Windows` are made of.

    Parameters
    ----------
    initial : array, shape (m,)
        Their first values.
    time : float
        Of these.
    """

    def __init__(self, initial: Array, time: float) -> None:
        m = len(initial)
        self._initial, self.last_time = initial[:, None], time
        self._length, self._samples = 1, 0
        self._last = self._max_abs = np.zeros(m)
        self._not_finite_from = [None if x else time for x in np.isfinite(initial)]
        self._times, self._closed = np.zeros(0), np.zeros((2, m, 0))  # means and maxima
        self._late, self._open = np.zeros(0), np.zeros((m, 0))  # times, deviations

    def add(self, times: Array, values: Array) -> None:
        """Append samples, one a column."""
        if not len(times):
            return
        with np.errstate(over="ignore", invalid="ignore"):
            deviations = values - self._initial
            self._samples += len(times)
            self._last, self.last_time = deviations[:, -1], float(times[-1])
            self._max_abs = np.maximum(self._max_abs, np.abs(deviations).max(axis=1))  # keeps a NaN
            for i, largest in enumerate(self._max_abs.tolist()):
                if self._not_finite_from[i] is None and not math.isfinite(largest):
                    self._not_finite_from[i] = float(times[np.argmin(np.isfinite(deviations[i]))])
            if self._late.size:
                times = np.concatenate((self._late, times))
                deviations = np.concatenate((self._open, deviations), axis=1)
            while len(times) >= self._length:
                used = self._close(times, deviations)
                times, deviations = times[used:], deviations[:, used:]
        self._late, self._open = times.copy(), deviations.copy()

    def _close(self, times: Array, deviations: Array) -> int:
        """Close as many windows as there is room for; return how many samples they have."""
        whole = min(len(times) // self._length, MAX_WINDOWS - len(self._times))
        used = whole * self._length
        times, deviations = times[:used], deviations[:, :used]
        closed = np.array((deviations, np.abs(deviations)))
        if self._length > 1:
            times, closed = _merged(times, closed, self._length)
        self._times = np.concatenate((self._times, times))
        self._closed = np.concatenate((self._closed, closed), axis=2)
        if len(self._times) == MAX_WINDOWS:
            self._times, self._closed = _merged(self._times, self._closed, 2)
            self._length *= 2
        return used

    def windows(self) -> list[Windows]:
        """Return the windows of each."""
        numbers = self._initial[:, 0].tolist(), self._last.tolist(), self._max_abs.tolist()
        m = len(self._initial)
        closed, late = np.empty((m, 3, len(self._times))), np.empty((m, 2, len(self._late)))
        closed[:, 0], closed[:, 1:] = self._times, self._closed.swapaxes(0, 1)
        late[:, 0], late[:, 1] = self._late, self._open
        return [
            Windows(
                initial,
                self.last_time,
                last,
                self._length,
                self._samples,
                largest,
                self._not_finite_from[i],
                closed[i],
                late[i],
            )
            for i, (initial, last, largest) in enumerate(zip(*numbers, strict=True))
        ]


def _merged(times: Array, closed: Array, count: int) -> tuple[Array, Array]:
    """Return windows of so many neighbours: their times, means and maxima."""
    means, maxima = closed.reshape(*closed.shape[:-1], -1, count)
    return _means(times.reshape(-1, count)), np.array((_means(means), maxima.max(axis=-1)))


def _means(rows: Array) -> Array:
    """Return the mean of each row, also where the sum is too large for a float."""
    means = np.asarray(rows.mean(axis=-1))
    large = ~np.isfinite(means)
    means[large] = (rows[large] / rows.shape[-1]).sum(axis=-1)
    return means
