"""How a quantity drifts: size, slope, and the kind of its growth, see `geomint.growth`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from .growth import classify, trend_slope
from .windows import Windows

__all__ = ["CLASSES", "ROUNDOFF", "Drift", "measure_drift"]

CLASSES = ("roundoff", "bounded", "sqrt", "linear", "faster", "undetermined")

# Deviations up to this, times the scale of the quantity, count as round-off.
ROUNDOFF = 32.0 * 2.0**-52


@dataclass(frozen=True)
class Drift:
    r"""The drift of one quantity over a run.

    Attributes
    ----------
    initial : float
        The first value v₀.
    max_abs_error, final_error : float
        Largest \|v − v₀\|, and the last v − v₀ with its sign.
    max_rel_error : float or None
        `max_abs_error` / \|v₀\|; None where v₀ is 0.
    scale : float
        What a rounding error of v is measured against.
    slope, slope_stderr : float
        Drift of v per unit of the scene's time, by least squares through the window means, and its
        standard error; see `geomint.growth.trend_slope`. None for fewer than 32 windows.
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
        numbers["samples"], numbers["until"] = self.windows.samples, self.windows.last_time
        return numbers


def measure_drift(name: str, windows: Windows, scale: float) -> Drift:
    """Return the drift of a series, by the rule of this module."""
    slope, stderr = trend_slope(windows.times, windows.means)
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
        kind=classify(
            windows.times, windows.means, windows.maxima, windows.max_abs, ROUNDOFF * scale
        ),
        windows=windows,
    )
