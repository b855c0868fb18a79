r"""The statistical rule that tells how a deviation grows.

The window means m_i, i < N, of the deviation are taken apart into cosines,
c_k = √(2/N) Σ m_i cos(πk(i + ½)/N), k = 1 … K = min(48, N/2). The rule rests on what these are for
the kinds of growth: independent with equal variances for a bounded noise; independent with
variances as 1/k² for a random walk; as 1/k² in size with fixed signs for a trend.

The rule, in this order (`RULE` states it for reports):

``roundoff``
    No deviation is larger than 32 ε × scale, where the scale of a quantity v at the initial state
    is max(\|v\|, Σ \|y_i ∂v/∂y_i\|): what rounding each number of the state once may do to it.
``undetermined``
    There are fewer than 64 windows (or none, which comes before ``roundoff``).
``linear``, ``faster``
    There is a trend: the c_k are likelier by a factor e⁵ (twice the difference of the logarithms of
    the likelihoods is above 10; 16 for the parabola) as a straight line or a parabola plus noise,
    than as noise alone, the noise having the variances a + w/k² with the likeliest a, w ≥ 0; or
    the means of 16 blocks of the run rise or fall throughout, by more than twice the standard
    deviation of all window means. And the end is where the trend has led to: the block means
    differ between the ends by at least ¾ of their range.
    Then r is the rise over the second half of the run by that over the first, of the parabola if
    that is likelier than the line by 8 in the same measure, else 1: ``faster`` above 2^1.5 − 1 (a
    growth like t^1.5), ``linear`` down to 2^0.6 − 1, ``undetermined`` below: it levels off.
``bounded``
    Otherwise the three slowest cosines carry less than 1/20 of the variance of the window means; or
    the likeliest α for variances as k^(−2α), k ≤ 32, is below ½.
``sqrt``
    α is between ½ and 1.5: a random walk (α = 1), that grows like √t.
``undetermined``
    α is above 1.5: too smooth for any of these, such as an oscillation slower than the run.

An oscillation can grow about a mean that does not. So where the means are ``bounded`` or ``sqrt``,
and the amplitudes (in each window the largest \|deviation\| less the \|mean\|) reach a tenth of the
largest deviation, the rule is applied to the amplitudes too, and their growth counts if it is worse.

Measured on synthetic series (`tests/report/test_growth.py`): bounded noise and oscillations with at
least four periods in the run are not taken for growth, random walks are called ``sqrt`` in 99 % of
runs, linear and quadratic drifts are found below oscillations several times their size.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["RULE", "classify", "trend_slope"]

Array = npt.NDArray[np.float64]

MIN_WINDOWS = 64
BLOCKS = 16
COSINES = 48
SLOW_COSINES, SLOW_SHARE = 3, 0.05
LINE, PARABOLA, CURVED = 10.0, 16.0, 8.0
RISEN = 0.75
OSCILLATING = 0.1
FASTER, LEVELLING = 2.0**1.5 - 1.0, 2.0**0.6 - 1.0
# Ratios w/a of a walk's variances to a floor: none, or a grid by factors of 1.8.
_RATIOS = np.concatenate(([0.0], np.logspace(-1.0, 5.0, 25)))

RULE = {
    "roundoff": "No deviation is larger than 32 ε × scale: no more than rounding the numbers of "
    "the state once may do. Nothing drifts.",
    "bounded": "The deviation goes up and down without a trend: its slow parts carry no more than "
    "those of an oscillation or of a noise that stays as large as it is.",
    "sqrt": "The deviation wanders like a random walk and grows like √t: what unbiased rounding "
    "errors do. Four times as long, twice as large.",
    "linear": "The deviation, or the amplitude of its oscillation, grows in proportion to time: a "
    "systematic error. Twice as long, twice as large; the slope is that of the means.",
    "faster": "The deviation, or the amplitude of its oscillation, grows faster than t^1.5: longer "
    "runs get worse quickly.",
    "undetermined": "The series does not decide: fewer than 64 windows, an oscillation slower than "
    "the run, or a drift that levels off. A longer run may tell.",
}


class _Fit(NamedTuple):
    likelihood: float  # logarithm, up to a constant
    coefficients: Array
    variances: Array  # of the noise in each cosine


def classify(times: Array, means: Array, maxima: Array, largest: float, level: float) -> str:
    """Return the class of a series of windows.

    Parameters
    ----------
    times, means, maxima : array, shape (N,)
        Of each window: mean time, mean deviation, largest absolute deviation.
    largest : float
        Largest absolute deviation of the whole series.
    level : float
        The round-off level, 32 ε × scale.
    """
    if len(means) == 0:
        return "undetermined"
    if not (np.isfinite(largest) and np.isfinite(means).all()):
        return "faster"
    if largest <= level:
        return "roundoff"
    if len(means) < MIN_WINDOWS:
        return "undetermined"
    kind = _series_class(times, means)
    amplitudes = maxima - np.abs(means)
    if kind in ("bounded", "sqrt") and amplitudes.max() > OSCILLATING * largest:
        growth = _series_class(times, amplitudes)
        if growth in ("sqrt", "linear", "faster"):
            kind = growth if kind == "bounded" or growth != "sqrt" else kind
    return kind


def _series_class(times: Array, means: Array) -> str:
    """Return the class of a series of means, by the rule from the trend on."""
    scaled, spread = _scaled(means)
    if spread == 0.0:
        return "bounded"
    curve = _trend(times, scaled)
    return _without_trend(scaled) if curve is None else curve


def _scaled(means: Array) -> tuple[Array, float]:
    """Return the means with average 0 and variance 1, and their standard deviation."""
    size = float(np.abs(means).max())
    if size == 0.0:
        return means, 0.0
    centred = means / size - (means / size).mean()  # squares neither overflow nor underflow
    spread = float(centred.std())
    return (means, 0.0) if spread == 0.0 else (centred / spread, size * spread)


def _trend(times: Array, means: Array) -> str | None:
    """Return the class of the trend, or None if there is none."""
    blocks = block_means(means)
    rises = np.diff(blocks)
    risen = abs(blocks[-1] - blocks[0])
    if risen > 2.0 and (np.all(rises > 0.0) or np.all(rises < 0.0)):
        half = len(rises) // 2
        return _curve(rises[:half].sum(), rises[-half:].sum())
    values, shapes, k = _cosines(times, means)
    none = _fit(values, shapes[:, :0], k)
    line, parabola = _fit(values, shapes[:, :1], k), _fit(values, shapes, k)
    by_line = 2.0 * (line.likelihood - none.likelihood)
    by_parabola = 2.0 * (parabola.likelihood - none.likelihood)
    if by_line <= LINE and by_parabola <= PARABOLA:
        return None
    if risen < RISEN * np.ptp(blocks):
        return "undetermined" if np.ptp(blocks) > 0.5 else None
    if by_parabola - by_line <= CURVED:
        return "linear"
    b, c = parabola.coefficients
    return _curve(b / 2.0 + c / 4.0, b / 2.0 + 3.0 * c / 4.0)


def _curve(first: float, second: float) -> str:
    """Return the class of a trend from its rises over the first and the second half."""
    if first * second <= 0.0:
        return "faster" if abs(second) > abs(first) else "undetermined"
    ratio = second / first
    if ratio > FASTER:
        return "faster"
    return "linear" if ratio > LEVELLING else "undetermined"


def _without_trend(means: Array) -> str:
    values, _, k = _cosines(np.arange(len(means), dtype=np.float64), means)
    slow = values[:SLOW_COSINES]
    if slow @ slow < SLOW_SHARE * len(means):  # the means are scaled to variance 1
        return "bounded"
    alpha = _exponent(values[:32], k[:32])
    if alpha < 0.5:
        return "bounded"
    return "sqrt" if alpha < 1.5 else "undetermined"


def block_means(means: Array) -> Array:
    """Return the means of 16 blocks of equal length; what is over at the start is left out."""
    usable = len(means) // BLOCKS * BLOCKS
    return np.asarray(means[len(means) - usable :].reshape(BLOCKS, -1).mean(axis=1))


def _cosines(times: Array, means: Array) -> tuple[Array, Array, Array]:
    """Return the coefficients of the means, those of x and x² (x from 0 to 1), and k.

    k is 2N/π sin(πk/2N), with which the variances of a random walk are exactly as 1/k².
    """
    n = len(means)
    x = (times - times[0]) / (times[-1] - times[0])
    columns = np.stack([means, x, x * x], axis=1)
    numbers = np.arange(1, min(COSINES, n // 2) + 1)
    waves = np.cos(np.pi / n * np.outer(numbers, np.arange(n) + 0.5)) * np.sqrt(2.0 / n)
    values = waves @ (columns - columns.mean(axis=0))
    k = 2.0 * n / np.pi * np.sin(0.5 * np.pi * numbers / n)
    return values[:, 0], values[:, 1:], k


def _fit(values: Array, shapes: Array, k: Array) -> _Fit:
    """Fit multiples of `shapes` plus noise of variances a + w/k², for the greatest likelihood."""
    return max(_fits(values, shapes, k), key=lambda fit: fit.likelihood)


def _fits(values: Array, shapes: Array, k: Array) -> Iterator[_Fit]:
    """Yield the best fit for each ratio w/a."""
    for ratio in _RATIOS:
        relative = 1.0 + ratio / k**2
        weights = 1.0 / np.sqrt(relative)
        coefficients = np.linalg.lstsq(
            shapes * weights[:, None], values * weights, rcond=None
        )[0]  # fmt: skip
        rest = (values - shapes @ coefficients) * weights
        floor = max(float(rest @ rest) / len(values), 1e-300)
        likelihood = -0.5 * float(np.log(relative).sum() + len(values) * np.log(floor))
        yield _Fit(likelihood, coefficients, floor * relative)


def _exponent(values: Array, k: Array) -> float:
    """Return the likeliest α of variances as k^(−2α)."""
    logs = np.log(k) - np.log(k).mean()
    grid = np.linspace(-0.5, 3.0, 141)
    sizes = (values**2 * np.exp(2.0 * np.outer(grid, logs))).mean(axis=1)
    return float(grid[np.argmin(sizes)])


def trend_slope(times: Array, means: Array) -> tuple[float | None, float | None]:
    """Return the least-squares slope of the window means and its standard error.

    The error is that of noise with variances a + w/k² beside a straight line: the largest among
    those w/a that are likelier than e⁻¹ times the likeliest. So it holds for random walks too.
    """
    if len(means) < MIN_WINDOWS // 2 or not np.isfinite(means).all():
        return None, None
    scaled, spread = _scaled(means)
    if spread == 0.0:
        return 0.0, 0.0
    centred = times - times.mean()
    slope = spread * float(centred @ scaled / (centred @ centred))
    values, shapes, k = _cosines(times, scaled)
    ramp = shapes[:, 0] * (times[-1] - times[0])
    fits = list(_fits(values, shapes[:, :1], k))
    likely = max(fit.likelihood for fit in fits) - 1.0
    variance = max((ramp**2) @ fit.variances for fit in fits if fit.likelihood >= likely)
    return slope, spread * float(np.sqrt(variance) / (ramp @ ramp))
