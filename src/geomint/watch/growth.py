r"""The statistical rule for how a deviation grows.

The window means of the deviation are taken apart: jumps (`geomint.watch.jumps`), oscillations of
2.5 or more periods in the run (`geomint.watch.oscillations`), and a rest in which a line or a
parabola is looked for beside a noise that may be white, a random walk, or both
(`geomint.watch.trend`). The *trend bound* is the largest rise or fall over the run that the data do
not exclude at 95 %: \|rise\| + 1.96 errors. The error is the standard error, with a twentieth of
what the oscillations could feign and 1½ times what the jumps are not known better than added in
squares (`geomint.watch.decomposition`).

The rule, in this order (`RULE` states it for reports):

``not finite``
    A value is infinite or not a number.
``roundoff``
    All deviations are 0.
``undetermined``
    There are fewer than 64 windows.
``linear``, ``faster``
    There is a trend. A line is likelier than the noise alone by a factor e⁵, or a parabola by e⁸
    (twice the gain of the logarithm of the likelihood is above 10, or 16), it rises by more than 3
    errors and a thousandth of the largest deviation, and the means of 16 blocks of the run differ
    between its ends by ¾ of their range; or these means rise or fall throughout, by more than twice
    the standard deviation of the series. Let r be the rise over the second half of the run by that
    over the first: ``faster`` if r is above 2^1.25 − 1 (a growth like t^1.25) at 95 %; ``linear``
    if it is below 2^1.5 − 1 and above 2^0.6 − 1, each at 95 %. If neither, the rule goes on.
``jump``
    Jumps make up 0.1 of the largest deviation, in a window or before the first.
``sqrt``, ``undetermined``
    The trend bound is above 0.1 of the largest deviation. It is ``sqrt`` if there is no trend,
    rounding can explain the largest deviation, a random walk is likelier than white noise by e⁵, a
    line or a parabola beside it likelier by no more than e^2.5 or e^3.5, the likeliest α for
    variances of the cosines as k^(−2α), k ≤ 32, is between ½ and 1.5, and the walk goes on
    throughout: not most of it in one block, in three windows, in one cosine, or in step.
``undetermined``
    The last 1/32 of the run has deviations 1.5 times as large as all before.
``linear``, ``faster``, ``undetermined``
    An oscillation can grow about a mean that does not. Its amplitude (the largest \|deviation\| of
    four windows, or of each, less the \|mean\| of all) has a trend, of that class, and 0.05 of the
    largest deviation is not excluded; or has none, and neither excludes 0.2 of the largest
    deviation. This is left out where it is 0.9 of the largest in the first and the last quarter
    alike, and where sines of constant amplitudes are all there is.
``bounded``
    Otherwise.

If no deviation is larger than 32 ε × scale, ``roundoff`` is said instead of ``bounded``, of an
amplitude not known better, and of ``jump`` where the trend bound is below 0.1 of the largest
deviation and the jumps after the first window add up to less than that, as those to and fro do, or
to less than 1.5 ε × scale: a flip between two neighbouring values. The
scale of a quantity v at the initial state is max(\|v\|, Σ \|y_i ∂v/∂y_i\|): what rounding each number
of the state once may do to it. Rounding can explain a walk of 4 ε × scale × √steps, or 32 ε × scale
if that is more.

Measured on synthetic series: see `benchmarks/drift_classes.py`.
"""

from typing import Final, NamedTuple

import numpy as np

from ..arguments import Array
from .decomposition import WALK, Part, evenly, taken_apart, without_jumps
from .jumps import Jump, first_step
from .trend import cosines

MIN_TREND_WINDOWS, MIN_WINDOWS = 32, 64
EXCLUDED, AMPLITUDE_EXCLUDED, AMPLITUDE_LEAST = 0.1, 0.2, 0.05  # of the largest deviation
LINE, PARABOLA = 10.0, 16.0  # gains of likelihood, see `geomint.watch.trend`
NO_LINE, NO_PARABOLA = 5.0, 7.0
CLEAR = 3.0  # standard errors
ONE_SIDED = 1.645  # of them: 95 % of a normal distribution
BLOCKS, RISEN = 16, 0.75
LEAST = 1e-3  # of the largest deviation: less is no trend, however clear
FASTER, NOT_LINEAR, LEVELLING = 2.0**1.25 - 1.0, 2.0**1.5 - 1.0, 2.0**0.6 - 1.0
GROWN = 24.0**0.5  # an oscillation whose amplitude grows by 1 leaves a sine this part of 1
ONE_BLOCK, ONE_COSINE, THREE_WINDOWS = 0.6, 0.4, 0.5
LATE, LAST = 1.5, 32
FLIP = 1.5 / 32.0  # of the level of round-off: neighbouring values differ by ε × scale at most
AS_LARGE, POOLED = 0.9, 4  # of the amplitude; windows

RULE = {
    "not finite": "The quantity was infinite or not a number, from the time given on: nothing is "
    "known of its drift.",
    "roundoff": "No deviation is larger than 32 ε × scale: no more than rounding the numbers of "
    "the state once may do. A trend of a tenth of the largest is excluded, and jumps do not add up "
    "to that, or to no more than a flip between neighbouring values: nothing drifts.",
    "bounded": "The deviation stays as large as it is: a trend of a tenth of the largest deviation "
    "over the run is excluded at 95 %, and so is a growth of its oscillation by a fifth.",
    "jump": "The deviation changes at once, at the time and by the size given.",
    "sqrt": "The deviation wanders like a random walk and grows like √t, at a size that rounding "
    "errors explain: what unbiased rounding does. Four times as long, twice as large.",
    "linear": "The deviation, or the amplitude of its oscillation, grows in proportion to time: a "
    "systematic error. Twice as long, twice as large; the slope is that of the means.",
    "faster": "The deviation, or the amplitude of its oscillation, grows faster than t^1.25: longer "
    "runs get worse quickly.",
    "undetermined": "The series does not decide: it is short, or a trend of the size of the trend "
    "bound may be hidden in it. A longer run may show which.",
}
CLASSES = tuple(RULE)
NOT_FINITE: Final = "not finite"


class Growth(NamedTuple):
    """How a deviation grows: its class, and the numbers behind it.

    A number is None where there is none, or it is too large for a float.

    Attributes
    ----------
    slope, slope_stderr : float
        Of the means, without jumps and oscillations, per unit of time.
    trend_bound : float
        The largest rise or fall over the run that the data do not exclude at 95 %.
    jump_size, jump_time : float
        Of the largest jump.
    """

    drift_class: str
    slope: float | None = None
    slope_stderr: float | None = None
    trend_bound: float | None = None
    jump_size: float | None = None
    jump_time: float | None = None


def growth_of(
    times: Array,
    means: Array,
    maxima: Array,
    last_time: float,
    largest: float,
    level: float,
    explained: float,
) -> Growth:
    """Return the growth of a finite series of windows.

    Parameters
    ----------
    times, means, maxima : array, shape (N,)
        Of each window: mean time, mean deviation, largest absolute deviation.
    last_time, largest : float
        The length of the run, and the largest absolute deviation of the whole series.
    level, explained : float
        The round-off level, 32 ε × scale; how large a random walk of rounding errors may get.
    """
    if not len(means) or (largest > 0.0 and len(means) < MIN_TREND_WINDOWS):
        return Growth("undetermined")
    if largest == 0.0:
        return Growth("roundoff", 0.0, 0.0, 0.0)
    x, series, sizes = evenly(times, means / largest, maxima / largest)
    part, jumps = without_jumps(x, series, EXCLUDED)
    if not jumps and (start := first_step(part.series, sizes)) is not None:
        jumps = [start]
    flip = FLIP * level / largest
    found_class = _class(part, sizes, jumps, largest <= level, largest <= explained, flip)
    span = float(times[-1] - times[0])
    numbers = (
        _finite(part.trend.rise * largest / span),
        _finite(part.error * largest / abs(span)),
        _finite(part.bound * largest * abs(last_time / span)),
    )
    if len(means) < MIN_WINDOWS or not jumps:
        return Growth("undetermined" if len(means) < MIN_WINDOWS else found_class, *numbers)
    jump = jumps[0]
    time = 0.0 if jump.at < 0 else float(times[jump.at])
    return Growth(found_class, *numbers, _finite(jump.size * largest), time)


def _finite(number: float) -> float | None:
    """Return a number, None for one that is too large for a float."""
    return number if np.isfinite(number) else None


def _class(
    part: Part, sizes: Array, jumps: list[Jump], rounding: bool, explained: bool, flip: float
) -> str:
    """Return the class of a series whose largest deviation is 1.

    A net change of level by less than `flip` may be between two neighbouring values.
    """
    found_class = _trend_class(part)
    if found_class in ("linear", "faster"):
        return found_class
    excluded = part.bound <= EXCLUDED
    if sum(abs(jump.size) for jump in jumps) >= EXCLUDED:
        net = abs(sum(jump.size for jump in jumps if jump.at >= 0))
        return "roundoff" if rounding and excluded and net < max(EXCLUDED, flip) else "jump"
    if not excluded:
        return "sqrt" if found_class is None and explained and _is_walk(part) else "undetermined"
    if LATE * sizes[: -max(1, len(sizes) // LAST)].max() < 1.0:
        return "undetermined"
    found_class = _amplitude_class(part, sizes)
    return "roundoff" if rounding and found_class in ("bounded", "undetermined") else found_class


def _trend_class(part: Part) -> str | None:
    """Return the class of the trend, ``"undetermined"`` if it has none, or None without a trend."""
    trend, doubt = part.trend, part.doubt
    blocks = block_means(part.rest)
    found_class = None
    error = float(np.sqrt(trend.covariance.sum() + doubt**2))
    line, parabola = abs(trend.rise), abs(float(trend.halves.sum()))
    by_line = trend.by_line > LINE and line > max(CLEAR * part.error, LEAST)
    by_parabola = trend.by_parabola > PARABOLA and parabola > max(CLEAR * error, LEAST)
    if by_line or by_parabola:
        found_class = "undetermined"
        if abs(blocks[-1] - blocks[0]) >= RISEN * np.ptp(blocks):
            found_class = _curve(trend.halves, trend.covariance + 0.25 * doubt**2 * np.eye(2))
    if found_class in ("linear", "faster"):
        return found_class
    return _monotone(part.series, doubt) or _monotone(part.rest, doubt) or found_class


def _monotone(series: Array, doubt: float) -> str | None:
    """Return the class of a series whose block means rise or fall throughout, None for others."""
    rises = np.diff(block_means(series))
    if abs(rises.sum()) <= max(2.0 * float(series.std()), CLEAR * doubt, LEAST):
        return None
    if not (np.all(rises > 0.0) or np.all(rises < 0.0)):
        return None
    half = len(rises) // 2
    rough = 0.5 * half * float(np.mean(np.diff(rises) ** 2))  # of a walk: the variance of a half
    return _curve(np.array([rises[:half].sum(), rises[-half:].sum()]), rough * np.eye(2))


def _curve(halves: Array, covariance: Array) -> str:
    """Return the class of a trend from its rises over the two halves."""
    first, second = halves if halves[1] > 0.0 else -halves

    def above(ratio: float) -> float:
        """By how many standard errors the second rise is above `ratio` times the first."""
        weights = np.array([-ratio, 1.0])
        error = float(np.sqrt(weights @ covariance @ weights))
        return float(second - ratio * first) / max(error, 1e-300)

    if second > abs(first) and above(FASTER) > ONE_SIDED:
        return "faster"
    if above(NOT_LINEAR) < -ONE_SIDED and above(LEVELLING) > ONE_SIDED:
        return "linear"
    return "undetermined"


def _amplitude_class(part: Part, sizes: Array) -> str:
    """Return ``"bounded"``, or the class of the growth of the oscillation about means without one."""
    centre, quarter = abs(float(part.series.mean())), len(sizes) // 4
    ends = min(sizes[:quarter].max(), sizes[-quarter:].max()) - centre
    if ends >= AS_LARGE * (1.0 - centre):
        return "bounded"
    inside = float((sizes - np.abs(part.series)).max())
    if inside <= EXCLUDED and GROWN * part.unsteady <= EXCLUDED:
        return "bounded"  # sines of constant amplitudes are all there is
    bounds = []
    for pooled in (max(1, min(POOLED, len(sizes) // MIN_WINDOWS)), 1):
        usable = len(sizes) // pooled * pooled
        largest = sizes[len(sizes) - usable :].reshape(-1, pooled).max(axis=1)
        amplitudes = np.maximum(largest - centre, 0.0)
        if amplitudes.max() <= EXCLUDED:
            return "bounded"
        found = taken_apart(np.linspace(0.0, 1.0, len(amplitudes)), amplitudes, [])
        bounds.append(found.bound)
        found_class = _trend_class(found)
        if found_class is not None and found.bound > AMPLITUDE_LEAST:
            return found_class
    return "bounded" if min(bounds) <= AMPLITUDE_EXCLUDED else "undetermined"


def _is_walk(part: Part) -> bool:
    """Tell whether a series is a random walk and nothing else."""
    trend = part.trend
    if trend.by_walk < WALK or trend.by_line > NO_LINE or trend.by_parabola > NO_PARABOLA:
        return False
    steps = np.diff(block_means(part.rest)) ** 2
    small = np.sort(np.diff(part.rest) ** 2)
    if steps.max() > ONE_BLOCK * steps.sum() or small[-3:].sum() > THREE_WINDOWS * small.sum():
        return False
    columns, k = cosines(part.rest[:, None])
    values, k = columns[:32, 0], k[:32]
    white = values * k
    total = float(white @ white)
    if (white**2).max() > ONE_COSINE * total:
        return False
    return abs(white.sum()) <= CLEAR * total**0.5 and 0.5 < _exponent(values, k) < 1.5


def block_means(series: Array) -> Array:
    """Return the means of 16 blocks of equal length; what is over at the start is left out."""
    usable = len(series) // BLOCKS * BLOCKS
    return series[len(series) - usable :].reshape(BLOCKS, -1).mean(axis=1)


def _exponent(values: Array, k: Array) -> float:
    """Return the likeliest α of variances as k^(−2α)."""
    logs = np.log(k) - np.log(k).mean()
    grid = np.linspace(-0.5, 3.0, 141)
    sizes = (values**2 * np.exp(2.0 * np.outer(grid, logs))).mean(axis=1)
    return float(grid[np.argmin(sizes)])
