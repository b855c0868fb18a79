"""How a quantity drifts: size, slope, and the kind of its growth.

The rule for the kind, in this order (stated in every report):

``roundoff``
    No deviation is larger than 32 ε × scale, where the scale of a quantity v at the initial state
    is max(\\|v\\|, Σ \\|y_i ∂v/∂y_i\\|): what rounding each number of the state once may do to it.
``undetermined``
    There are fewer than 64 windows.
``linear``, ``faster``
    The run is cut into 16 blocks. The 15 differences of successive block means have mean d and
    standard deviation s; if \\|d\\| > 4 s/√15, there is a drift. With m(t) the block mean it has the
    exponent α = log₂ (\\|m(T)\\| / \\|m(T/2)\\|): ``faster`` if α > 1.5, ``linear`` if 0.6 < α ≤ 1.5.
``bounded``, ``sqrt``
    Otherwise the variance of the window means' differences over 32 windows, divided by 32 times
    that over one window, is 1 for a random walk and 1/32 for a bounded noise: ``bounded`` below
    0.18 (the geometric mean), ``sqrt`` up to 3.
``undetermined``
    Everything else, for example an oscillation slower than the run.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .windows import Windows

__all__ = ["CLASSES", "Drift", "measure_drift"]

Array = npt.NDArray[np.float64]
CLASSES = ("roundoff", "bounded", "sqrt", "linear", "faster", "undetermined")

_EPSILON = 2.0**-52
_ROUNDOFF = 32.0
_MIN_WINDOWS = 64
_BLOCKS = 16
_SIGNIFICANT = 4.0
_LAG = 32
_BOUNDED_BELOW = 0.18
_WALK_BELOW = 3.0


@dataclass(frozen=True)
class Drift:
    """The drift of one quantity over a run.

    Attributes
    ----------
    initial : float
        The first value v₀.
    max_abs_error, final_error : float
        Largest \\|v − v₀\\|, and the last v − v₀ with its sign.
    max_rel_error : float or None
        `max_abs_error` / \\|v₀\\|; None where v₀ is 0.
    scale : float
        What a rounding error of v is measured against.
    slope, slope_stderr : float
        Drift of v per unit of the scene's time, by least squares through the window means, and its
        standard error from the scatter of 15 block differences.
    kind : str
        One of `CLASSES`.
    windows : Windows
        The reduced series.
    """

    name: str
    initial: float
    max_abs_error: float
    max_rel_error: float | None
    scale: float
    final_error: float
    slope: float | None
    slope_stderr: float | None
    kind: str
    windows: Windows

    def as_json(self) -> dict[str, Any]:
        """Return the numbers under the names of ``drift.json``."""
        numbers = asdict(self)
        for key in ("name", "windows"):
            del numbers[key]
        numbers["class"] = numbers.pop("kind")
        numbers["samples"] = self.windows.samples
        return numbers


def measure_drift(name: str, windows: Windows, scale: float) -> Drift:
    """Return the drift of a series, by the rule of this module."""
    slope, stderr = _slope(windows)
    initial = windows.initial
    return Drift(
        name=name,
        initial=initial,
        max_abs_error=windows.max_abs,
        max_rel_error=windows.max_abs / abs(initial) if initial != 0.0 else None,
        scale=scale,
        final_error=windows.last,
        slope=slope,
        slope_stderr=stderr,
        kind=_kind(windows, scale),
        windows=windows,
    )


def _block_means(values: Array) -> Array:
    usable = len(values) // _BLOCKS * _BLOCKS
    return values[len(values) - usable :].reshape(_BLOCKS, -1).mean(axis=1)


def _slope(windows: Windows) -> tuple[float | None, float | None]:
    times, means = windows.times, windows.means
    if len(times) < 2 * _BLOCKS or not np.isfinite(means).all():
        return None, None
    centred = times - times.mean()
    slope = float(centred @ (means - means.mean()) / (centred @ centred))
    steps = np.diff(_block_means(means)) / np.diff(_block_means(times))
    return slope, float(steps.std(ddof=1) / np.sqrt(len(steps)))


def _kind(windows: Windows, scale: float) -> str:
    if not np.isfinite(windows.max_abs):
        return "faster"
    if windows.max_abs <= _ROUNDOFF * _EPSILON * scale:
        return "roundoff"
    means = windows.means
    if len(means) < _MIN_WINDOWS:
        return "undetermined"
    blocks = _block_means(means)
    steps = np.diff(blocks)
    spread = steps.std(ddof=1) / np.sqrt(len(steps))
    if abs(steps.mean()) > _SIGNIFICANT * spread:
        return _growing(blocks)
    near = np.mean(np.diff(means) ** 2)
    if near == 0.0:
        return "bounded"
    ratio = np.mean((means[_LAG:] - means[:-_LAG]) ** 2) / (_LAG * near)
    if ratio < _BOUNDED_BELOW:
        return "bounded"
    return "sqrt" if ratio <= _WALK_BELOW else "undetermined"


def _growing(blocks: Array) -> str:
    half = abs(blocks[_BLOCKS // 2 - 1])
    if half == 0.0:
        return "faster"
    exponent = np.log2(abs(blocks[-1]) / half)
    if exponent > 1.5:
        return "faster"
    return "linear" if exponent > 0.6 else "undetermined"
