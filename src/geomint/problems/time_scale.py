"""The time scale of a motion at a state, of which default steps are a fraction."""

import math
from collections.abc import Callable

import numpy as np

from ..arguments import Array
from ..errors import DomainError
from ..kernels.compiling.signatures import FIELD, FLOW, GRADIENTS
from .evaluate import Rate, derivative
from .problem import Problem
from .spaces.repair import length

RESTING = 1.0 / 32.0  # a piece whose time is this part of the next one's is nearly at rest
FAR = 6.0  # times as long as rates need to turn around: not the time of the motion
SPACING = 1e-6  # of the differences that give the linearised motion, relative
TINY = 1e-8  # of the state: differences of that part of a smaller piece would be lost in roundings

# Where the rate depends on time: it is a polynomial of that degree over the time, to that part of its
# largest size. For an oscillation of angular frequency ω and that size ωT is then 0.9 to 1.7.
DEGREE, FITTED = 6, 1e-6
ROUGH = 0.05  # as well as a rate without derivatives at time 0, such as √t, is fitted over any time
HALVINGS = 100
ROUNDINGS = 64  # of the time at y0: over less than so many no rate is known to be smooth
COUNT = 16
# Irregular parts of the time, so that no oscillation looks slow at them; not 0, where a switch may be.
PARTS = (np.arange(COUNT) + 0.5 + 0.3 * np.sin(np.arange(COUNT) ** 2.0)) / COUNT
POLYNOMIALS = np.linalg.qr(np.vander(2.0 * PARTS - 1.0, DEGREE + 1))[0]


def characteristic_time(
    problem: Problem,
    y0: Array,
    direction: float = 1.0,
    start: float = 0.0,
    rate_at: Rate = derivative,
) -> float:
    """Return the time scale of the motion from y0 at time `start`, forwards or backwards.

    It is that of the state as it moves there (`state_time`), and where the rate depends on time
    explicitly, not longer than that of this dependence (`smooth_time`).

    Parameters
    ----------
    direction : float
        Of the run, such as its end or its step: the sign counts.
    start : float
        The time at y0.
    rate_at : callable
        What gives dy/dt, as `derivative` does in plain Python.

    Raises
    ------
    DomainError
        If the derivative at y0 is not finite, or so large that no time is left; or if it depends on
        time and is smooth over no time at all.
    """
    rates = rate_at(problem, y0, start)
    time = state_time(problem, y0, rates, start, rate_at)
    if not names_time(problem):
        return time
    signed = math.copysign(time, direction)
    return abs(smooth_time(problem, y0, rates, signed, start, rate_at))


@np.errstate(all="ignore")
def state_time(problem: Problem, y0: Array, rates: Array, start: float, rate_at: Rate) -> float:
    """Return the shortest ‖piece‖ / ‖d piece/dt‖ over the pieces of the state, at y0.

    For a unit vector turning at angular velocity ω this is 1/ω. But the size of a piece at rest, or
    nearly so, as a momentum is at a turning point, is not that of its motion. Where there are such
    pieces the time scale of the linearised motion (`linearised_time`) decides: alone if no piece has
    a time, and else where the two are far apart. Where the rates stay as they are for far longer than
    the shortest time (`steady_time`), all pieces that have it are nearly at rest. 1 if there is none.

    A state far from the origin, or beside an equilibrium, seems slow by its size: where the rates
    themselves turn around in a far shorter time (`turning_time`), that one counts.
    """
    times, from_rest = [], False
    ys, speeds, hypot = y0.tolist(), rates.tolist(), math.hypot
    pieces = [(p, hypot(*ys[p]), hypot(*speeds[p])) for p in problem.slices.values()]
    for _, size, rate in pieces:
        if not math.isfinite(rate):
            expected = "a state with a finite derivative: give a step"
            raise DomainError("state", y0, expected)
        time = size / rate if rate > 0.0 else 0.0
        if 0.0 < time < math.inf:
            times.append(time)
        from_rest |= rate > 0.0 and time == 0.0
    times.sort()
    nearly = len(times) > 1 and times[0] < RESTING * times[1]
    if times and not nearly:
        turning = turning_time(problem, y0, rates, start, rate_at, SPACING * times[0])

        def stays(time: float) -> bool:
            """Tell whether the rates are much the same after a time on the line of the first ones.

            No piece's rate has changed by half of its size or, where that is more, of the piece's own
            size over the time: the rate of a piece that turns is 0.
            """
            if math.isinf(time):
                return True
            change = (rate_at(problem, y0 + time * rates, start) - rates).tolist()
            changes = [(hypot(*change[p]), size, rate) for p, size, rate in pieces]
            return all(now <= 0.5 * max(rate, size / time) for now, size, rate in changes)

        steady = 0.0 if turning < times[0] else steady_time(stays, times[0])
        if steady > times[0] / RESTING:
            return finite_time(min(steady, linearised_time(problem, y0, rates, start, rate_at)))
        if not from_rest:
            return turning if FAR * turning < times[0] else times[0]
    linear = linearised_time(problem, y0, rates, start, rate_at)
    if not times:
        return finite_time(linear)
    time = max(times[0], min(times[1], linear)) if nearly else times[0]
    return linear if from_rest and linear < RESTING * time else time


def turning_time(
    problem: Problem, y0: Array, rates: Array, start: float, rate_at: Rate, spacing: float
) -> float:
    """Return √(|ẏ| / |J J ẏ|), by two differences, the first over the time `spacing`.

    Of an oscillation it is 1/ω, whatever pieces and units its numbers have; infinity if all is 0, and
    where something is no number.
    """
    speed = math.sqrt(rates.dot(rates))
    change = (rate_at(problem, y0 + spacing * rates, start) - rates) / spacing
    spacing *= speed / (math.sqrt(change.dot(change)) or math.inf)
    if not 0.0 < spacing < math.inf:
        return math.inf
    change = (rate_at(problem, y0 + spacing * change, start) - rates) / spacing
    second = math.sqrt(change.dot(change))
    return math.sqrt(speed / second) if 0.0 < second < math.inf else math.inf


def finite_time(time: float) -> float:
    """Return a time, or 1 for one that is infinite."""
    return time if math.isfinite(time) else 1.0


def steady_time(stays: Callable[[float], bool], time: float) -> float:
    """Return how long the rates stay, to a tenth; 0 if not over `time`, infinity if for ever."""
    if not stays(time):
        return 0.0
    while stays(2.0 * time):
        time *= 2.0
        if math.isinf(time):
            return time
    for factor in (2.0**0.5, 2.0**0.25, 2.0**0.125):
        if stays(factor * time):
            time *= factor
    return time


@np.errstate(all="ignore")
def linearised_time(
    problem: Problem, y0: Array, rates: Array, start: float, rate_at: Rate
) -> float:
    """Return min(1/ρ(J), √(‖piece‖ / ‖J ẏ‖)) with J = ∂ẏ/∂y, ρ its spectral radius; inf if all are 0.

    The second, for pieces that are not nearly at rest themselves, is the time in which the second
    derivative moves a piece by its own size.
    """
    J = jacobian(problem, y0, start, rate_at)
    if not np.isfinite(J).all():
        return math.inf
    radius = float(np.max(np.abs(np.linalg.eigvals(J))))
    linear = 1.0 / radius if radius > 0.0 else math.inf
    found = [linear]
    for rows in problem.slices.values():
        size, rate, second = length(y0[rows]), length(rates[rows]), length((J @ rates)[rows])
        resting = rate > 0.0 and size < RESTING * rate * linear
        if second > 0.0 and size > 0.0 and not resting:
            found.append(math.sqrt(size / second))
    return min(found)


@np.errstate(all="ignore")
def jacobian(problem: Problem, y0: Array, start: float, rate_at: Rate) -> Array:
    """Return ∂ẏ/∂y by central differences."""
    J = np.zeros((problem.rows, problem.rows))
    for rows in problem.slices.values():
        size = SPACING * (
            max(length(y0[rows]), TINY * length(y0)) if y0[rows].any() else length(y0)
        )
        size = size or SPACING
        for i in range(rows.start, rows.stop):
            above, below = y0.copy(), y0.copy()
            above[i] += size
            below[i] -= size
            difference = rate_at(problem, above, start) - rate_at(problem, below, start)
            J[:, i] = difference / (above[i] - below[i])
    return J


def names_time(problem: Problem) -> bool:
    """Tell whether the code of a form names time at all: most do not, and pay for nothing more."""
    known = [(problem.field, FIELD)]
    if problem.action is not None:
        known.append((problem.action.generator, FIELD))
    if problem.hamiltonian is not None:
        known.append((problem.hamiltonian.gradients, GRADIENTS))
    if problem.splitting is not None:
        known.append((problem.splitting.flow, FLOW))
    return any(f is not None and signature.reads(f, "t") for f, signature in known)


@np.errstate(all="ignore")
def smooth_time(
    problem: Problem, y0: Array, rates: Array, time: float, start: float, rate_at: Rate
) -> float:
    """Return `time`, halved until the explicit dependence of the rate on time is smooth over it.

    Looked at are y0, and a state on the way, where what is multiplied by a piece at rest is seen. What
    is smooth over no time is taken for what it is over the longest that shows no more of it.
    """
    way = y0 + 0.5 * time * rates
    way += 0.5 * time * rate_at(problem, way, start + 0.5 * time)
    there = rate_at(problem, way, start)
    states, last = ((y0, way), there) if np.isfinite(there).all() else ((y0,), rates)
    if not depends_on_time(problem, states[-1], last, time, start, rate_at):
        return time
    least, found = math.inf, time
    # A state so small that its own time is 1e100 must be led back to a time that is one.
    for _ in range(HALVINGS + max(0, math.frexp(time)[1])):
        if abs(time) < ROUNDINGS * math.ulp(start):
            break
        left = max(roughness(problem, y, time, start, rate_at) for y in states)
        if left <= FITTED:
            return time
        if left < 0.5 * least:
            least, found = left, time
        time *= 0.5
    if least > ROUGH:
        raise DomainError("state", y0, "one from which the rate is smooth in time: give a step")
    return found


def depends_on_time(
    problem: Problem, y: Array, first: Array, time: float, start: float, rate_at: Rate
) -> bool:
    """Tell whether the rate at a fixed state has other bits at some times up to the given one."""
    times = (start + part * time for part in PARTS[::7])
    return any(rate_at(problem, y, t).tobytes() != first.tobytes() for t in times)


def roughness(problem: Problem, y: Array, time: float, start: float, rate_at: Rate) -> float:
    """Return how far the rate at a fixed state is from a polynomial in time, up to the given one.

    Relative to the largest rate of each piece: the largest of them.
    """
    rates = np.array([rate_at(problem, y, start + part * time) for part in PARTS])
    if not np.isfinite(rates).all():
        return math.inf
    found = 0.0
    for rows in problem.slices.values():
        largest = float(np.max(np.abs(rates[:, rows])))
        if largest > 0.0:
            scaled = rates[:, rows] / largest
            rest = scaled - POLYNOMIALS @ (POLYNOMIALS.T @ scaled)
            found = max(found, float(np.max(np.abs(rest))))
    return found
