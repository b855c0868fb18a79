r"""How a deviation grows over the members of an ensemble: an exponent with its error, and a class.

One trajectory says little of round-off: a random walk is as often small as large. Over members the root
of the mean square has no such luck, R(t) = (mean over members of δ²)^½, and E. Hairer, R. McLachlan and
A. Razakarivony (BIT 48, 2008) tell by it which methods obey Brouwer's law: R ~ t^½ for an energy where
roundings are unbiased, R ~ t where they are biased, or where the method itself drifts.

R_j of windows in time is fitted by A t^b: log R_j = log A + ½ log mean(t^2b over window j), by least
squares in log A and b. Windows are averaged as the deviations are, so that the first, along which t
grows most, is fitted as well as the last. Windows follow each other, and so do the errors of their R_j:
that of b comes from samples of the members, drawn with replacement (B. Efron).
"""

from typing import NamedTuple

import numpy as np

from ..arguments import Array

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)  # of the quantiles over members
DRAWN = 400  # samples of members
GROUPS = 2048  # of more members, groups are drawn: as many means as tell a variance
EXPONENTS = np.linspace(-1.0, 4.0, 251)
HALFWAY = 0.25  # from an exponent to the next that would be another class
CURVED = 0.25  # by that much exponents of the two halves may differ, beside their error


class FoundGrowth(NamedTuple):
    """What is found of a matrix of deviations.

    Attributes
    ----------
    rms : array, shape (windows,)
    quantiles : array, shape (levels, windows)
    size : float
        What the fit has in the middle of the last window.
    exponent, stderr : float
    low, high : float
        The interval of 95 % of the exponent.
    halves, halves_stderr : array, shape (2,)
        The exponents of the earlier and the later half of the windows, in log t.
    """

    rms: Array
    quantiles: Array
    size: float
    exponent: float
    stderr: float
    low: float
    high: float
    halves: Array
    halves_stderr: Array


def growth_over_members(values: Array, edges: Array, seed: int = 0) -> FoundGrowth:
    """Return how the deviations of members grow.

    Parameters
    ----------
    values : array, shape (members, windows)
        Of each member the root of the mean square of its deviation in each window; finite.
    edges : array, shape (windows + 1,)
        Times from the beginning, > 0 but for the first, that windows begin and end at.
    seed : int
        Of the samples of members.
    """
    squares = np.square(values)
    rms = np.sqrt(squares.mean(axis=0))
    quantiles = np.quantile(values, LEVELS, axis=0)
    drawn = np.sqrt(_drawn(squares, seed))
    some = rms > 0.0
    parts = [some, *_halves(some, edges)]
    exponents, errors = np.full(3, np.nan), np.full(3, np.nan)
    for i, part in enumerate(parts):
        if part.sum() >= 3:
            exponents[i] = _fits(rms[None], edges, part)[0][0]
            errors[i] = _fits(drawn, edges, part)[0].std(ddof=1)
    size = 0.0
    if np.isfinite(exponents[0]):
        amplitude = _fits(rms[None], edges, some)[1][0]
        size = float(np.exp(amplitude + exponents[0] * np.log(edges[-2:].mean())))
    from scipy.special import stdtrit  # plans and lists need no scipy

    wide = float(stdtrit(max(len(values) - 1, 1), 0.975)) * errors[0]
    b, error = float(exponents[0]), float(errors[0])
    halves = exponents[1:], errors[1:]
    return FoundGrowth(rms, quantiles, size, b, error, b - wide, b + wide, *halves)


def class_of_exponent(found: FoundGrowth) -> str:
    """Return the class of `geomint.watch.growth` that the interval of an exponent lies in.

    ``bounded`` about 0, ``sqrt`` about ½, ``linear`` about 1, ``faster`` above 5/4; ``roundoff`` where
    nothing ever deviated. ``undetermined`` where the interval reaches into two, or the halves of the
    run have exponents of their own.
    """
    if not found.rms.any():
        return "roundoff"
    apart, error = abs(np.diff(found.halves)[0]), float(np.hypot(*found.halves_stderr))
    if not np.isfinite(found.low) or apart > CURVED + 2.0 * error:
        return "undetermined"
    if found.low > 1.0 + HALFWAY:
        return "faster"
    for name, exponent in (("bounded", 0.0), ("sqrt", 0.5), ("linear", 1.0)):
        low = -np.inf if name == "bounded" else exponent - HALFWAY
        if low < found.low and found.high < exponent + HALFWAY:
            return name
    return "undetermined"


def _halves(some: Array, edges: Array) -> list[Array]:
    """Return the windows of the earlier and of the later half, in log t."""
    middles = 0.5 * (edges[1:] + edges[:-1])
    logs = np.log(middles[some]) if some.any() else np.zeros(1)
    middle = 0.5 * (logs.min() + logs.max())
    return [some & (np.log(middles) <= middle), some & (np.log(middles) > middle)]


def _drawn(squares: Array, seed: int) -> Array:
    """Return mean squares over samples of the members, shape (samples, windows)."""
    count = min(len(squares), GROUPS)
    parts = np.array_split(squares, count)
    groups, sizes = np.array([part.mean(axis=0) for part in parts]), np.array([*map(len, parts)])
    times = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), DRAWN)
    weights = times * sizes
    # A sample has as many members as there are: its variance is (count − 1)/count of what is sought.
    spread = np.sqrt(count / max(count - 1, 1))
    means = weights @ groups / weights.sum(axis=1, keepdims=True)
    mean = squares.mean(axis=0)
    return np.maximum(mean + spread * (means - mean), 1e-3 * mean)


def _fits(rms: Array, edges: Array, part: Array) -> tuple[Array, Array]:
    """Return b and log A of every row, by the windows of a part."""
    begin, end = edges[:-1][part], edges[1:][part]
    shapes = np.array([_log_mean(b, begin, end) for b in EXPONENTS])
    logs = np.log(np.maximum(rms[:, part], 1e-300))
    shape_means, log_means = shapes.mean(axis=1), logs.mean(axis=1)
    centred, sought = shapes - shape_means[:, None], logs - log_means[:, None]
    rest = (centred**2).sum(axis=1) - 2.0 * sought @ centred.T  # less what no b changes
    best = np.clip(rest.argmin(axis=1), 1, len(EXPONENTS) - 2)
    rows = np.arange(len(rest))
    left, middle, right = (rest[rows, best + i] for i in (-1, 0, 1))
    bend = left - 2.0 * middle + right
    shift = np.where(bend > 0.0, 0.5 * (left - right) / np.where(bend > 0.0, bend, 1.0), 0.0)
    shift = np.clip(shift, -1.0, 1.0)
    exponents = EXPONENTS[best] + shift * (EXPONENTS[1] - EXPONENTS[0])
    slope = (shape_means[best + 1] - shape_means[best - 1]) / 2.0
    return exponents, log_means - (shape_means[best] + slope * shift)


def _log_mean(b: float, begin: Array, end: Array) -> Array:
    """Return half the logarithm of the mean of t^2b over windows."""
    power = 2.0 * b + 1.0
    if abs(power) < 1e-9:
        integral = np.log(end / np.maximum(begin, 1e-300))
    else:
        integral = (end**power - np.maximum(begin, 1e-300) ** power) / power
    return 0.5 * np.log(integral / (end - begin))
