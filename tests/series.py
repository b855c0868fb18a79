"""Drifts of series that nobody integrated."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import geomint as gi
from geomint.watch.drift import drift_of_run, walk_level
from geomint.watch.windows import Series

__all__ = ["drift_of_series"]

Array = npt.NDArray[np.float64]


def drift_of_series(
    name: str,
    times: Array,
    values: Array,
    scale: float,
    initial: float = 0.0,
    explained: float | None = None,
) -> gi.Drift:
    """Return the drift of a series from `initial` at time 0, by the rule of `geomint.watch.growth`.

    Parameters
    ----------
    scale : float
        What a rounding error of the quantity is measured against.
    explained : float, optional
        How large a random walk of rounding errors may get. Default: that of a step a sample.

    Raises
    ------
    DomainError
        For times that are not finite, that are all the same, or that go forth and back.
    """
    series = Series(np.array([initial]), 0.0)
    series.add(times, np.asarray(values, dtype=np.float64)[None, :])
    (windows,) = series.windows()
    if not windows.in_order:
        raise gi.DomainError("times", windows.times, "finite times that go on in one direction")
    if explained is None:
        explained = walk_level(scale, windows.samples)
    return drift_of_run(name, windows, scale, explained)
