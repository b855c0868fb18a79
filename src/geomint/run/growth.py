"""How errors of steps grow until the end of a run, as a second run shows.

Local errors say nothing of what becomes of them. Where the linearised motion, at a few places of the
run, has eigenvalues that would make them larger than is wanted, the run is done once more in longer
steps; so it is where few steps decide, as at jumps and pulses, which ranks may miss. What both err by
at the end is in proportion to the sums of their local errors, so that their difference tells both.
Nothing cheaper does (measured): one tangent vector turns into the flow, and those of short windows take
growth within a turn for growth of the run.
"""

from __future__ import annotations

import math

import numpy as np

from ..arguments import Array
from ..methods.adaptive import Adaptive
from ..problems.evaluate import rates_of
from ..problems.spaces.repair import warn
from ..problems.time_scale import jacobian
from .error_estimate import label
from .local_error import EndError, Ranked
from .solution import Solution

__all__ = ["end_error", "growth", "met", "sizes_of", "tell_end_error"]

ENOUGH = 3.0  # times what is wanted is met: the error is known to that
Start = tuple[float, Array | None]

SAVED = 8  # states of a run whose steps have no ranks
GROWN = 5.0  # powers of e by which errors must grow to be looked at
TRUSTED = 1.0 / 30.0  # of what two runs differ by: so little one errs, at least
ROUNDING = 2.0**-53  # of each step, at least


def growth(found: Solution, wanted: float, start: Start, doubted: bool) -> float:
    """Return the power of e by which errors may grow; 0 where that makes no more than is wanted.

    Where few steps decide, or the end is `doubted`, at least `GROWN`. `start` is where the run began,
    the problem's own time and the state, which ranks know too.
    """
    problem, places = found.problem, _places(found, start)
    rate_at = rates_of(problem, places[0][1])
    rates = np.array([jacobian(problem, y, time, rate_at) for time, y in places])
    if not np.isfinite(rates).all():
        return 0.0
    gaps = np.diff([time for time, _ in places])
    growths = np.maximum((np.sign(gaps.sum()) * np.linalg.eigvals(rates).real).max(axis=1), 0.0)
    between = np.maximum(growths[1:], growths[:-1])  # and where few places were, as in the mean
    power = float(abs(gaps) @ np.maximum(between, growths.mean()))
    if doubted or (isinstance(found.ranked, Ranked) and found.ranked.concentrated):
        return max(power, GROWN)
    return power if power > GROWN and math.log(_local(found) / wanted) + power > 0.0 else 0.0


def _places(found: Solution, start: Start) -> list[tuple[float, Array]]:
    """Return times and states of the run, in their order; the first is where it began."""
    if isinstance(found.ranked, Ranked):
        known = found.ranked.places
    else:
        some = np.unique(np.linspace(0, len(found.tau) - 1, SAVED).astype(int))
        known = [
            (start[0], np.asarray(start[1])),
            *zip(found.tau[some], found.y[some], strict=True),
        ]
    sign = math.copysign(1.0, known[-1][0] - start[0])
    return sorted(known, key=lambda place: sign * place[0])


def sizes_of(found: Solution, other: Solution, start: Start) -> Array:
    """Return the largest number of its piece for each number, at some places of both runs."""
    states = np.array([*(y for _, y in _places(found, start)), *other.y])
    sizes = np.abs(states).max(axis=0)
    whole = float(sizes.max()) or 1.0
    for rows in found.problem.slices.values():
        sizes[rows] = sizes[rows].max() or whole
    return np.asarray(sizes)


def end_error(
    found: Solution, other: Solution, wanted: float, sizes: Array, begin: float, power: float
) -> EndError:
    """Return what a run errs by at the end, by another one with longer steps; `begin` as the end.

    Where what iterations and roundings leave may grow to what is wanted, both may err alike.
    """
    error = float(np.max(np.abs(found.y[-1] - other.y[-1]) / sizes))
    local = _local(found)
    left = found.method.options.get("iteration_tolerance", 0.0) + ROUNDING * math.sqrt(found.steps)
    few = isinstance(found.ranked, Ranked) and found.ranked.concentrated
    if math.log(left / wanted) + power < 0.0 and not few:
        error *= min(max(local / max(_local(other) - local, local), TRUSTED), 1.0)
    times, until = label(found)[1], 1.0
    if error > wanted:
        until = math.log(max(wanted / local, 1.0)) / math.log(max(error / local, math.e))
    return EndError(error, begin + min(until, 1.0) * (float(times[-1]) - begin))


def met(found: Solution, wanted: float) -> bool:
    """Tell whether the end errs by what is wanted, as far as a second run says anything."""
    error = found.end_error
    return error is None or error.error <= ENOUGH * wanted


def _local(found: Solution) -> float:
    """Return the sum of a run's local errors, and of a rounding for each of its steps."""
    if isinstance(found.method, Adaptive):
        return found.method.rtol
    error = found.local_error
    return (0.0 if error is None else error.total) + ROUNDING * found.steps


def tell_end_error(found: Solution, wanted: float) -> None:
    """Warn where the end errs by more than is wanted, and shorter steps do not help."""
    error = found.end_error
    if error is not None:
        name = label(found)[0]
        warn(
            f"errors grow on the way: that at the end is about {error.error:.1g} by a second run, and "
            f"less than {wanted:.1g} up to {name} = {error.until:.6g}"
        )
