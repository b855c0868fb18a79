"""A step from tolerances: chosen once, where the motion is fastest, because it is to stay as it is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.integrate

from ..arguments import as_array, positive
from ..errors import DomainError, StepWarning, tell

if TYPE_CHECKING:
    from .solver import FixedStep

PILOT_STEPS = 100
MOST_TRIALS = 40  # of a step: each multiplies it by 1/5 to 5
LEAST_RTOL = 2.0**-50
LARGEST = 1e300  # error that is told from a failure
LOOK = 16  # steps until errors are looked at, then four times as many, and so on; and at the end
DOUBT = 12.0  # times the tolerances is told: as `geomint.solve` takes errors for known


def tolerances(rtol: Any, atol: Any, n: int) -> tuple[float, Any]:
    """Return tolerances as SciPy takes them, or raise `DomainError`."""
    relative, absolute = positive("rtol", rtol), as_array("atol", atol)
    if absolute.shape not in ((), (n,)) or not np.all(absolute >= 0.0):
        raise DomainError("atol", atol, f"a number ≥ 0, or {n} of them")
    return max(relative, LEAST_RTOL), np.maximum(absolute, 1e-300)


class Watched:
    """Where steps chosen from tolerances move fastest, and whether they err by more there."""

    def __init__(self, allowed: tuple[float, Any]) -> None:
        self._allowed, self._next = allowed, LOOK
        self._worst, self._place, self._before = 0.0, (0.0, np.zeros(0)), np.zeros(0)

    def look(self, solver: FixedStep, t: float, end: float) -> None:
        """Note every other step, by how far it differs from the last noted; warn once."""
        over = end == solver.t_bound
        if solver.done % 2 and not over:
            return
        y, _, h = solver.before
        moved = solver.y - y
        if len(self._before):
            change = float((abs(moved - self._before) / self._scale(y)).max())
            if change > self._worst:
                self._worst, self._place = change, (t, y)
        self._before = moved
        if not self._worst or not (over or solver.done >= self._next):
            return
        self._next = 4 * solver.done
        begin, state = self._place
        error = _error(solver, begin, state, solver.h, self._allowed)
        if error > DOUBT:
            text = (
                f"steps of {abs(h):.3g} err by {error:.2g} times rtol and atol, near t = {begin:.6g}: "
                "more than is promised where no step is given; give a shorter one: step=…"
            )
            tell(StepWarning(text, "state", error, begin))
            solver._watched = None

    def _scale(self, y: Any) -> Any:
        rtol, atol = self._allowed
        return atol + rtol * abs(y)


def chosen_step(solver: FixedStep, longest: float, rtol: float, atol: Any) -> float:
    """Return a step with the error that is wanted, at the beginning and where the motion is fastest.

    0 where no step has it.
    """
    h = longest
    for t, y, scale in _places(solver):
        h = _fitting(solver, t, y, (rtol, atol), min(h, scale), h)
    return h


def _places(solver: FixedStep) -> list[tuple[float, Any, float]]:
    """Return where a pilot run is fastest, and the beginning, with steps to try there."""
    span = abs(solver.t_bound - solver.t)
    given = {"rtol": 1e-3, "atol": 1e-6, "first_step": span * 1e-6 or span}  # not SciPy's own NaN
    f = lambda t, y: solver.plain(solver._inside(t), y)  # noqa: E731
    pilot = scipy.integrate.DOP853(f, solver.t, solver.y, solver.t_bound, **given)
    places: list[tuple[float, Any, float]] = []
    for _ in range(PILOT_STEPS):
        t, y = pilot.t, pilot.y
        pilot.step()
        if pilot.status == "failed":  # as this run will: the steps up to there say nothing
            del places[1:]
            break
        places.append((t, y, abs(pilot.t - t)))
        if pilot.status == "finished":
            break
    solver.nfev += pilot.nfev
    if not places:
        return [(solver.t, solver.y, span)]
    inner = places[:-1] or places  # the last may be cut
    while len(inner) > 1 and inner[1][2] > 2.0 * inner[0][2]:  # the first steps are short
        del inner[0]
    fastest = min(range(len(inner)), key=lambda i: inner[i][2])
    return [*inner[max(fastest - 2, 0) : fastest + 2], (*places[0][:2], inner[0][2])]


def _fitting(
    solver: FixedStep, t: float, y: Any, allowed: tuple[float, Any], h: float, longest: float
) -> float:
    """Return a step from there whose difference from two halves is what is allowed.

    Where it would leave the run it is taken back from there. Where none is, because the function is
    not finite, `longest`: the run will say so; else 0.
    """
    ahead, error = abs(solver.t_bound - t), math.inf
    most = min(longest, max(ahead, abs(t - solver.begin)))
    h, fits, too_long = min(h, most), 0.0, math.inf
    for _ in range(MOST_TRIALS):
        error = _error(solver, t, y, math.copysign(h, ahead - h) * solver.direction, allowed)
        if error > 1.0:
            too_long = h
        elif error >= 0.1 or h >= 0.9 * too_long:
            return h
        elif h == most:  # longer ones do not begin there
            return longest
        else:
            fits = h
        factor = 0.9 * max(error, 1e-30) ** (-1.0 / (solver.order + 1))
        h = min(h * min(max(factor, 0.2), 5.0), most)
        if not fits < h < too_long:
            h = math.sqrt(fits * too_long)
    return longest if error == math.inf and not fits else fits


def _error(solver: FixedStep, t: float, y: Any, h: float, allowed: tuple[float, Any]) -> float:
    """Return the estimated error of a step over what is allowed, infinite where it fails."""
    moved: list[Any] = []
    for begin, step in ((t, h), (t, h / 2), (t + h / 2, h / 2)):
        state = y + moved[1] if moved[1:] else y
        increments, failed = solver.stepped(begin, state, step, solver.guess(begin, state, step))
        if failed:
            return math.inf
        moved.append(increments.sum(axis=0))
    rtol, atol = allowed
    scale = atol + rtol * np.maximum(np.abs(y), np.abs(y + moved[0]))
    difference = moved[0] - moved[1] - moved[2]
    error = float(np.sqrt(np.mean(np.abs(difference / scale) ** 2)))
    return error if error < LARGEST else LARGEST  # also where sizes overflow
