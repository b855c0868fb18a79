"""Drifts of series that nobody integrated."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import geomint as gi
from geomint.watch.drift import drift_of_run, walk_level
from geomint.watch.windows import Windows

__all__ = ["drift_of_series", "windows_of"]

MOST = 1024
Array = npt.NDArray[np.float64]


def windows_of(times: Array, values: Array, initial: float = 0.0, length: int = 1) -> Windows:
    """Return the windows of a series from `initial` at time 0, cut at once.

    Fewer than 1024 of them, each of the least power of two of samples for which that is so, and at
    least of `length`.
    """
    count = len(times)
    while count // length >= MOST:
        length *= 2
    full = count - count % length
    with np.errstate(over="ignore", invalid="ignore"):
        deviations = np.asarray(values, dtype=np.float64) - initial
        rows = deviations[:full].reshape(-1, length)
        means = [(x / length).sum(axis=1) for x in (times[:full].reshape(-1, length), rows)]
    late = np.flatnonzero(~np.isfinite(deviations))
    first = 0.0 if not np.isfinite(initial) else float(times[late[0]]) if len(late) else None
    return Windows(
        initial,
        float(times[-1]) if count else 0.0,
        float(deviations[-1]) if count else 0.0,
        length,
        count,
        float(np.abs(deviations).max(initial=0.0)),
        first,
        np.array([*means, np.abs(rows).max(axis=1)]),
        np.array([times[full:], deviations[full:]]),
    )


def drift_of_series(
    name: str,
    times: Array,
    values: Array,
    scale: float,
    initial: float = 0.0,
    explained: float | None = None,
    length: int = 1,
) -> gi.Drift:
    """Return the drift of a series from `initial` at time 0, by the rule of `geomint.watch.growth`.

    Parameters
    ----------
    scale : float
        What a rounding error of the quantity is measured against.
    explained : float, optional
        How large a random walk of rounding errors may get. Default: that of a step a sample.
    length : int
        The least one of windows.
    """
    windows = windows_of(times, values, initial, length)
    if explained is None:
        explained = walk_level(scale, windows.samples)
    return drift_of_run(name, windows, scale, explained)
