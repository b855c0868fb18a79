"""How a quantity drifts: size, slope, and the class of its growth, see `geomint.watch.growth`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from ..kernels.compiling.sameness import Compared
from ..problems.shown import Shown
from .growth import MIN_TREND_WINDOWS, NOT_FINITE, Growth, growth_of
from .windows import NOTHING, Windows

# Deviations up to this, times the scale of the quantity, count as round-off.
ROUNDOFF = 32.0 * 2.0**-52
# Deviations up to this, times the scale and √steps, may be a random walk of rounding errors.
WALK = 4.0 * 2.0**-52


@dataclass(frozen=True, eq=False, repr=False)
class Drift(Shown, Compared):
    r"""The drift of one quantity over a run.

    Attributes
    ----------
    initial : float
        The first value v₀.
    max_abs_error, final_error : float
        Largest \|v − v₀\|, and the last v − v₀ with its sign.
    max_rel_error : float or None
        `max_abs_error` / \|v₀\|; None where v₀ is 0, or so small that this is too large for a float.
    scale : float
        What a rounding error of v is measured against.
    slope, slope_stderr : float
        Drift of v per unit of the scene's time, by least squares through the window means without
        their jumps and oscillations, and its standard error; see `geomint.watch.growth`. None for
        fewer than 32 windows, and where it is too large for a float.
    drift_class : str
        One of `CLASSES`.
    windows : Windows
        The reduced series.
    trend_bound : float or None
        The largest rise or fall over the run that the data do not exclude at 95 %. None as `slope`.
    jump_size, jump_time : float or None
        Size and time of the largest jump, where there is one; the time is 0 for the first step.
    not_finite_from : float or None
        Time of the first value that was infinite or not a number.
    kind, label, note : str
    own_noise : bool
        What the watcher says of the quantity, see `geomint.Watcher`.
    """

    name: str
    initial: float
    max_abs_error: float
    max_rel_error: float | None
    scale: float
    final_error: float
    slope: float | None
    slope_stderr: float | None
    drift_class: str
    windows: Windows
    trend_bound: float | None = None
    jump_size: float | None = None
    jump_time: float | None = None
    not_finite_from: float | None = None
    kind: str = "others"
    label: str = "deviation"
    note: str = ""
    own_noise: bool = False

    @property
    def within_roundoff(self) -> bool:
        """Whether no deviation is larger than 32 ε × scale, however it grows."""
        return self.max_abs_error <= ROUNDOFF * self.scale

    @property
    def brief(self) -> str:
        """Largest deviation and class, in words."""
        return f"{self.drift_class}, largest {self.max_abs_error:.3g}"

    def _shown(self) -> tuple[str, dict[str, Any]]:
        facts = {
            "class": self.drift_class,
            "initial": self.initial,
            "largest": self.max_abs_error,
            "last": self.final_error,
            "slope": self.slope and f"{self.slope:.6g} ± {self.slope_stderr or 0.0:.2g}",
            "scale": self.scale,
            "samples": self.windows.samples,
            "windows": len(self.windows.times),
            "jump at": self.jump_time,
            "not finite from": self.not_finite_from,
        }
        told = {name: fact for name, fact in facts.items() if fact is not None}
        words = {name: f"{x:.6g}" if isinstance(x, float) else x for name, x in told.items()}
        return f"drift of {self.name!r}", words

    def as_json(self) -> dict[str, Any]:
        """Return the numbers under the names of ``drift.json``."""
        numbers = asdict(self)
        for key in ("name", "windows"):
            del numbers[key]
        numbers["class"] = numbers.pop("drift_class")
        numbers["samples"], numbers["until"] = self.windows.samples, self.windows.last_time
        return numbers

    def stretched(self, rate: float) -> Drift:
        """Return the same drift with all times multiplied by `rate`."""
        old = self.windows
        windows = replace(
            old,
            last_time=rate * old.last_time,
            closed=np.array([rate * old.times, old.means, old.maxima]),
            last_window=NOTHING,
            not_finite_from=_times(rate, old.not_finite_from),
        )
        return replace(
            self,
            windows=windows,
            slope=_times(1.0 / rate, self.slope),
            slope_stderr=_times(1.0 / abs(rate), self.slope_stderr),
            jump_time=_times(rate, self.jump_time),
            not_finite_from=windows.not_finite_from,
        )


def _times(factor: float, number: float | None) -> float | None:
    return None if number is None else factor * number


def walk_level(scale: float, steps: int) -> float:
    """Return how large a random walk of rounding errors may get in so many steps."""
    return float(max(ROUNDOFF, WALK * steps**0.5) * scale)


def not_finite(drifts: Mapping[str, Drift]) -> str:
    """Return which quantities were infinite or not a number, and from when on; empty if none."""
    words = [
        f"{name!r} is not finite from {drift.not_finite_from:.6g} on"
        for name, drift in drifts.items()
        if drift.not_finite_from is not None
    ]
    return "; ".join(words)


def drift_of_run(
    name: str, windows: Windows, scale: float, explained: float, **described: Any
) -> Drift:
    """Return the drift by the rule of `geomint.watch.growth`, undetermined where times are in no order.

    So no run is lost in which a clock has stood still. `described` is what its watcher says of the
    quantity.
    """
    growth = Growth(NOT_FINITE if windows.not_finite_from is not None else "undetermined")
    decides = windows.max_abs == 0.0 or len(windows.times) >= MIN_TREND_WINDOWS
    if windows.not_finite_from is None and decides and windows.in_order:
        rows = windows.times, windows.means, windows.maxima
        level = ROUNDOFF * scale
        growth = growth_of(*rows, windows.last_time, windows.max_abs, level, explained)
        if described.get("own_noise") and windows.max_abs <= level and growth.slope is not None:
            growth = growth._replace(drift_class="roundoff")  # the trend may be the instrument's
    initial = windows.initial
    relative = windows.max_abs / abs(initial) if initial != 0.0 else math.inf
    drift = object.__new__(Drift)
    drift.__dict__.update(  # the fields of a frozen dataclass, in a third of the time
        name=name,
        initial=initial,
        max_abs_error=windows.max_abs,
        max_rel_error=relative if math.isfinite(relative) else None,
        scale=float(scale),
        final_error=windows.last,
        windows=windows,
        not_finite_from=windows.not_finite_from,
        slope=growth.slope,
        slope_stderr=growth.slope_stderr,
        drift_class=growth.drift_class,
        trend_bound=growth.trend_bound,
        jump_size=growth.jump_size,
        jump_time=growth.jump_time,
        **described,
    )
    return drift
