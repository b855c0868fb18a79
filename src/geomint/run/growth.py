"""How errors of steps grow until the end of a run, as a second run shows (`geomint.run.second`).

What both end in tells what the first errs by. Where few steps decide, as at jumps and pulses, or where
what is left of iterations and roundings may have grown to what is wanted, both may err alike: then
their difference is taken for the error. Else the error is a √(r^p − 1)th of it, with steps r times as
long, and not an (r^p − 1)th: steps that meet a tolerance are often too long to err as their order says.
"""

import math

import numpy as np

from ..arguments import Array
from ..errors import EndWarning, tell
from ..methods.adaptive import Adaptive
from ..problems.deviation import sizes_of as largest_of_pieces
from ..problems.evaluate import rates_of, value_of
from ..problems.time_scale import jacobian
from .error_estimate import label
from .local_error import EndError, Ranked
from .promise import FEW, advice, rough_error
from .solution import Solution

ENOUGH = 3.0  # times what is wanted is met: the error is known to that
GROWN = 5.0  # powers of e by which errors must grow to be looked at
BIAS = 0.1  # of what iterations may leave: what a step is off by, on the same side
REGULAR = 30.0  # times the sum of local errors that a regular motion makes of them
AGREE = 0.3, 3.0  # times what was expected: three runs err as their order says
TRUSTED = 30.0  # times less than what two runs differ by one errs, at most, if it is regular
SATURATED, LEAST = 0.03, 1e-4  # relative errors that grow less; part of the time
EXPLODED = 10.0  # times the size of the motion: of steps that are not stable, and of no motion
SHORT = 6  # steps: of so few nothing is known but how far both ends are apart
LITTLE = 0.03  # of what is wanted: clear of so few, too
RESOLVED = 30.0  # numbers of steps: where one has more, both runs may agree by chance
ROUNDING = 2.0**-53  # of each step, at least
CLEAR = 0.1  # of roundings: local errors that are nothing beside them


def may_grow(found: Solution, start: Array, time: float) -> bool:
    """Tell whether errors may grow, by eigenvalues of the linearised motion at both ends of a run."""
    problem, end, rate_at = found.problem, end_time(found), rates_of(found.problem, start)
    known = ((start, time), (final(found)[: problem.rows], end))
    rates = (end - time) * np.array([jacobian(problem, y, t, rate_at) for y, t in known])
    return bool(np.isfinite(rates).all() and np.linalg.eigvals(rates).real.max() > GROWN)


def second_end(found: Solution) -> Array | None:
    """Return the state of the second run at the end of the first, or None where there is none."""
    ranked, problem = found.ranked, found.problem
    if not isinstance(ranked, Ranked) or ranked.second is None:
        return None
    state = ranked.second.state(ranked.end)
    if state is None or problem.time != "tau" or label(found)[0] != "t":
        return None if state is None else state[: problem.rows]
    y, clock = state[: problem.rows], problem.clock  # at the same time of the clock
    assert clock is not None
    late = ranked.final[problem.rows] - state[problem.rows]
    known = ranked.places[0][1]
    pace = value_of(problem, clock, known, ranked.compiled)(y, 0.0)
    return y + late / pace * rates_of(problem, known, ranked.compiled)(problem, y, 0.0)


def final(found: Solution) -> Array:
    """Return the end of a run, saved or not: the state, the clock where there is one, and more."""
    ranked, restart = found.ranked, found.restart
    if isinstance(ranked, Ranked):
        return ranked.final
    assert restart is not None  # variable steps end there
    return restart.memory


def end_time(found: Solution) -> float:
    """Return the time of that state, as the end is given."""
    ranked, rows = found.ranked, found.problem.rows
    if label(found)[0] == "t" and found.problem.time == "tau":
        return float(final(found)[rows])
    clock = found.restart is not None and found.restart.clock
    return ranked.end if isinstance(ranked, Ranked) else float(final(found)[rows + clock])


def sizes_of(found: Solution, *more: Array) -> Array:
    """Return for each number the largest of its piece, at some places of the run and in `more`.

    Or what it becomes in a characteristic time, as that of a piece that turns around.
    """
    problem, ranked, states = found.problem, found.ranked, [*found.y, *more]
    if isinstance(ranked, Ranked):
        (_, begin), *_, (time, end) = known = ranked.places
        rates = rates_of(problem, begin, ranked.compiled)(problem, end, time)
        rates = np.where(np.isfinite(rates), rates, 0.0)
        states += [y for _, y in known] + [rates * found.step / found.method.step_fraction]
    return largest_of_pieces(problem, np.abs(states).max(axis=0))


def apart(one: Array, other: Array, sizes: Array) -> float:
    """Return how far two states are apart, in parts of the sizes; infinity for what is no number."""
    off = float(np.max(np.abs(one[: len(sizes)] - other[: len(sizes)]) / sizes))
    return off if off < math.inf else math.inf


def off_at_end(found: Solution, other: Array, sizes: Array | None, wanted: float) -> float:
    """Return how far the end is from another, relative to sizes, its own, or those of all the run."""
    end = final(found)
    if sizes is None:
        off = apart(end, other, largest_of_pieces(found.problem, end[: found.problem.rows]))
        if off <= ENOUGH * wanted:
            return off
        sizes = sizes_of(found)
    return apart(end, other, sizes)


def estimated(found: Solution) -> float | None:
    """Return the estimated error of the last saved state, as `end_error`; None without an estimate."""
    error = found.error_estimate
    if error is None or not len(error):
        return None
    return float(np.max(np.abs(error[-1]) / sizes_of(found)))


def end_error(
    found: Solution, error: float, wanted: float, begin: float, ratio: float, other: float
) -> EndError:
    """Return what a run errs by that is `error` apart from another, which errs `ratio` times as much.

    `begin` is where the run began, in the time that its end is given in; `other` is what the other run
    errs by, as its order and one before it tell, or 0.
    """
    end, clear = end_time(found), ENOUGH if found.steps > FEW else LITTLE
    ranked = found.ranked if isinstance(found.ranked, Ranked) else None
    resolved = ranked is None or ranked.number("largest") < RESOLVED
    if error <= clear * wanted and resolved and found.steps > SHORT:
        return EndError(error, end, 1.0)
    local = _local(found)
    more = max(error / (local * ratio), 1.0)  # than local errors add up to
    left = BIAS * found.method.options.get("iteration_tolerance", 0.0) * found.steps
    left += ROUNDING * math.sqrt(found.steps)
    few = ranked is not None and ranked.concentrated
    agree = AGREE[0] * other < error < AGREE[1] * other
    known = agree or (more < REGULAR and not few)
    if known and found.steps > SHORT and left * more < wanted:
        error /= min(math.sqrt(max(ratio - 1.0, 1.0)), TRUSTED)
    if ranked is not None:
        error = max(error, local)
    if error <= wanted:
        return EndError(error, end, 1.0)
    part = 0.0
    if local < wanted:
        part = min(math.log(wanted / local) / max(math.log(error / local), 1.0), 1.0)
    return EndError(error, begin + part * (end - begin), more)


def before_saturation(found: Solution, wanted: float, begin: float) -> EndError | None:
    """Return the error at the end with the time up to which it is less than `wanted`.

    Where it is as large as the motion, nothing of it tells when it became so: both runs are done to
    a quarter of the time, and a quarter of that, until they are near each other.
    """
    error, ranked = found.end_error, found.ranked
    if error is None or not isinstance(ranked, Ranked) or ranked.second is None:
        return error
    start, second, off = ranked.places[0][0], ranked.second, error.error
    sizes, local = sizes_of(found), _local(found)

    def apart_at(part: float) -> float:
        one, other = second.both(start + part * (ranked.end - start))
        return math.inf if one is None or other is None else apart(one, other, sizes)

    part, high = 1.0, 1.0
    while off > SATURATED and part > LEAST:
        high, part = part, 0.25 * part
        off = apart_at(part)
    for _ in range(3 if high > part else 0):
        middle = math.sqrt(part * high)
        now = apart_at(middle)
        part, high, off = (part, middle, off) if now > SATURATED else (middle, high, now)
    rate = math.log(max(off / (part * local), math.e)) / part
    until = begin + min(math.log(max(wanted / local, 1.0)) / rate, 1.0) * (end_time(found) - begin)
    return error._replace(until=until)


def met(found: Solution, wanted: float) -> bool:
    """Tell whether the end errs by what is wanted, as far as a second run says anything."""
    error = found.end_error
    return error is None or error.error <= ENOUGH * wanted


def hopeless(found: Solution, wanted: float, before: Solution | None) -> bool:
    """Tell whether shorter steps would not help: roundings grow to more than what is wanted.

    So they do if nothing else was left in the run `before`, and both ends are too far apart.
    """
    error = found.end_error
    if error is None or error.error > EXPLODED:
        return False
    grown = error.grown * ROUNDING * math.sqrt(found.steps)
    if before is None:  # a run in longer steps tells it only if it has no part of the motion left
        return grown > wanted and error.error > SATURATED
    return grown > wanted or all(map(_rounded, (before, found)))


def _rounded(found: Solution) -> bool:
    """Tell whether local errors are roundings, as far as they add up."""
    error = rough_error(found)
    return error is not None and error.total <= CLEAR * ROUNDING * found.steps


def _local(found: Solution) -> float:
    """Return the sum of a run's local errors, and of a rounding for each of its steps."""
    if isinstance(found.method, Adaptive):
        return found.method.rtol
    error = rough_error(found)
    return (0.0 if error is None else error.total) + ROUNDING * found.steps


def tell_end_error(found: Solution, wanted: float, begin: float) -> None:
    """Warn where the end errs by more than is wanted, and shorter steps do not help."""
    error = found.end_error = before_saturation(found, wanted, begin)
    if error is not None:
        accuracy, asked = found.accuracy, "the end may err by more"
        because = f"errors of steps grow {error.grown:.2g} times on the way"
        if accuracy is not None:
            asked = f"tolerance = {accuracy.tolerance:g} may not be met"
            because = accuracy.noted(found.local_error) or because
        rounded = error.grown * ROUNDING * math.sqrt(found.steps) > wanted
        do = advice(found, 0.0 if rounded else wanted / error.error)
        text = (
            f"{asked}: {because}; by a second run the end errs by about {error.error:.1g}, and the "
            f"motion by less than {wanted:.1g} up to {label(found)[0]} = {error.until:.6g}; {do}"
        )
        tell(EndWarning(text, "end", error.error, error.until))
