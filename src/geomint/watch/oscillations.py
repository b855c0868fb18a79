"""Oscillations in a series: found one by one, fitted together, taken away.

Least squares see a trend in a sine: with P periods in the run and amplitude A up to 1.9 A/P. So sines
are fitted beside the trend, and what is left of them is noise.

A sine is where the amplitude spectrum (Hann's window, after a parabola is taken away) has a maximum
whose square is 20 times as high as the median of its neighbours', each times its frequency: so a
random walk, whose amplitudes fall as the frequency grows, has none. Those of the largest A/P come
first; frequencies are refined by Gauss's and Newton's method.
"""

from typing import NamedTuple

import numpy as np

from ..arguments import Array

FEWEST_PERIODS = 2.5  # fewer are no oscillation, but a curve
MOST, TRIED = 8, 3
PADDING = 4
STANDS_OUT = 20.0
ITERATIONS, SOLVED = 6, 1e-6  # the error after a step is of the order of its square
SEEN = 1.9  # times A/P: the rise that least squares see in a sine
NEGLIGIBLE = 2e-3  # of the largest deviation


class Cleaned(NamedTuple):
    """A series without its oscillations.

    Attributes
    ----------
    rest : array
        What is left.
    seen : float
        The rise that least squares might have seen in the oscillations.
    unsteady : float
        The standard deviation of what sines of constant amplitudes leave.
    """

    rest: Array
    seen: float
    unsteady: float


def without_oscillations(x: Array, series: Array) -> Cleaned:
    """Return a series, at equally spaced times `x` from 0 to 1, without its oscillations."""
    u = x - 0.5
    curve = np.stack([np.ones_like(u), u, u * u - 1.0 / 12.0], axis=1)
    rest = series - curve @ _solved(curve, series)
    least = NEGLIGIBLE * float(np.abs(rest).max())
    periods = np.zeros(0)
    while len(periods) < min(MOST, len(u) // 16):
        candidate = _most_seen(rest, periods, least)
        if candidate is None:
            break
        tried = _refined(u, curve, series, np.append(periods, candidate))
        if tried is None:
            break
        columns = np.hstack([curve, _waves(u, tried)])
        left = series - columns @ _solved(columns, series)
        if left @ left >= rest @ rest:
            break
        periods, rest = tried, left
    if not len(periods):
        return Cleaned(series, 0.0, float(rest.std()))
    return _cleaned(u, curve, series, periods, rest)


def _cleaned(u: Array, curve: Array, series: Array, periods: Array, rest: Array) -> Cleaned:
    """Take sines away; where that leaves half as much, sines with amplitudes linear in time."""
    waves, m = _waves(u, periods), curve.shape[1]
    c = _solved(np.hstack([curve, waves]), series)[m:]
    seen = SEEN * float(np.sum(np.hypot(*c.reshape(2, -1)) / periods))
    unsteady = float(rest.std())
    growing = np.hstack([waves, u[:, None] * waves])
    full = np.hstack([curve, growing])
    g = _solved(full, series)
    left = series - full @ g
    if left @ left < 0.5 * (rest @ rest):
        return Cleaned(series - growing @ g[m:], seen, unsteady)
    return Cleaned(series - waves @ c, seen, unsteady)


def _most_seen(rest: Array, known: Array, least: float) -> float | None:
    """Return the periods in the run of the oscillation that would be seen as the largest rise."""
    n = len(rest)
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(n) + 0.5) / n)
    sizes = np.abs(np.fft.rfft(rest * hann, PADDING * n)) * (4.0 / n)  # amplitudes of sines
    periods = np.arange(len(sizes)) / PADDING
    top = np.zeros(len(sizes), dtype=bool)
    top[1:-1] = (sizes[1:-1] >= sizes[:-2]) & (sizes[1:-1] >= sizes[2:])
    top &= periods >= FEWEST_PERIODS
    for other in known:
        top &= np.abs(periods - other) >= 1.0
    tops = np.flatnonzero(top)
    seen = SEEN * sizes[tops] / periods[tops]
    white = (sizes * periods) ** 2
    for i in np.argsort(-seen)[:TRIED]:
        at, here = int(tops[i]), periods[tops[i]]
        if seen[i] <= least:
            return None
        away = np.abs(periods - here)
        near = (away > 2.0) & (away <= max(6.0, 0.5 * here)) & (periods > 0.5)
        if white[at] > STANDS_OUT * np.median(white[near]):
            return float(here)
    return None


def _refined(u: Array, curve: Array, series: Array, periods: Array) -> Array | None:
    """Return the periods that fit best; None if two come too close, or one too slow."""
    p, count = periods.copy(), len(periods)
    a, b = _solved(np.hstack([curve, _waves(u, p)]), series)[-2 * count :].reshape(2, -1)
    for _ in range(ITERATIONS):
        waves = _waves(u, p)
        slopes = 2.0 * np.pi * u[:, None] * (waves[:, :count] * b - waves[:, count:] * a)
        c = _solved(np.hstack([curve, waves, slopes]), series)
        a, b, step = c[-3 * count :].reshape(3, -1)
        p += np.clip(step, -0.3, 0.3)
        if np.abs(step).max() < SOLVED:
            break
    close = count > 1 and np.diff(np.sort(p)).min() < 0.5
    return None if close or p.min() < 0.9 * FEWEST_PERIODS else p


def _waves(u: Array, periods: Array) -> Array:
    phases = 2.0 * np.pi * np.outer(u, periods)
    return np.hstack([np.cos(phases), np.sin(phases)])


def _solved(columns: Array, values: Array) -> Array:
    """Return the least-squares coefficients; the columns are nearly orthogonal as they are made."""
    gram = columns.T @ columns
    gram.flat[:: len(gram) + 1] += 1e-300  # the slope of a sine of amplitude 0 is 0
    return np.asarray(np.linalg.solve(gram, columns.T @ values))
