"""What a run says of its step: that it was not taken, or is longer than makes sense."""

import math

from ..arguments import Array
from ..errors import DomainError, StepWarning, tell
from ..methods import Method
from ..methods.adaptive import Adaptive
from ..problems.declared import claims_kept
from ..problems.evaluate import scales_of, states_around, value_of
from ..problems.problem import Problem
from ..watch.functions import ENERGY
from .growth import end_time, final
from .local_error import Ranked, promised
from .solution import Solution
from .timeline import Timeline

QUIET = 1e-4  # numbers of all steps that no integral is lost with (`geomint.kernels.solve.ranks`)
LONG = 2.0  # times the default step
LOST = 1e-2  # of the scale of an integral: what is off by more at the end is not the motion
MORE = 3.0  # times what steps that err as is promised may add up to
FEW = 60  # numbers of a state whose integrals plain Python evaluates in a moment


def tell_short_run(problem: Problem, end: float, step: float) -> None:
    """Warn if the run was shorter than the step that was asked for, which it did not take."""
    if end < step * (1.0 - 1e-9):
        text = (
            f"step = {step:.9g} is longer than the run to {problem.time} = {end:.9g}: a step of that "
            "length was taken instead; give a shorter step, or a later end"
        )
        tell(StepWarning(text, "step", step / end if end else None))


def tell_long_steps(problem: Problem, method: Method, state: Array, timeline: Timeline) -> None:
    """Warn of steps, longer than usual ones, that fixed-point iteration would have refused."""
    try:
        usual = method.default_step(problem, state, math.inf, timeline.start)
    except DomainError:  # there is none
        return
    if abs(timeline.h) > LONG * usual:
        text = (
            f"steps of {abs(timeline.h):.3g} are so long that Newton's method had to find some of "
            "them: what is faster is not resolved. If that is wanted, say "
            f"geomint.Gauss(…, iteration='newton'); if not, give a shorter step: step={usual:.3g}"
        )
        tell(StepWarning(text, "step", abs(timeline.h) / usual))


def may_lose(solution: Solution, given: bool) -> bool:
    """Tell whether steps err so much that integrals may be off by `LOST`, and can be looked at.

    Errors of steps that were `given` have not been measured: their ranks tell.
    """
    method, ranked, errors = solution.method, solution.ranked, 0.5 * QUIET  # of no steps
    if solution.end_error is not None and solution.end_error.error < 0.1 * LOST:
        return False
    if isinstance(ranked, Ranked):
        errors = ranked.number("total") if given else ranked.rough.total or errors
    elif isinstance(method, Adaptive):
        errors = solution.steps * method.rtol
    return (
        solution.success
        and len(solution.y) > 0
        and not 0.0 < errors < (QUIET if given else 0.1 * LOST)
    )


def tell_lost_integrals(
    solution: Solution, state: Array, begin: float, given: bool, compiled: bool
) -> None:
    """Warn if an integral is off at the end by more than `LOST`, and than what is promised explains.

    The run began at a `state` and a time of its own; `given`: with a step, that promises nothing.
    """
    method, explained, ranked = solution.method, LOST, solution.ranked
    if not (given or isinstance(method, Adaptive) or solution.accuracy):
        explained = max(LOST, MORE * solution.steps * promised(method))
    time = ranked.end if isinstance(ranked, Ranked) else end_time(solution)
    end = final(solution)[: solution.problem.rows], time
    off = integral_off(solution.problem, (state, begin), end, explained, compiled)
    tell_lost(off, end_time(solution), solution.step, method)


def tell_lost(off: tuple[str, float] | None, end: float, step: float, method: Method) -> None:
    """Warn of an integral, if one is off at the `end`, as the user has given that time."""
    if off is None:
        return
    name, part = off
    said, instead = f"steps of {abs(step):.3g} are so long", "a shorter step"
    if isinstance(method, Adaptive):
        said, instead = f"steps with rtol = {method.rtol:g} err so much", "a smaller rtol"
    text = (
        f"{said} that {name} is off by {part:.2g} of its size at the end: give {instead}, or a "
        "tolerance in its place"
    )
    tell(StepWarning(text, name, part, end))


def integral_off(
    problem: Problem,
    begin: tuple[Array, float],
    end: tuple[Array, float],
    explained: float = LOST,
    compiled: bool = True,
) -> tuple[str, float] | None:
    """Return an integral that is off at the end by more than that part of its scale, and by how much.

    The energy is looked at, where there is one, and else all, but for those that are none; of states
    of more than `FEW` numbers none is. The scale is `rounding_scale` where the run began, or the value
    there where that overflows.
    """
    known, (state, time) = problem.invariants, begin
    if problem.rows > FEW:
        return None
    for name in [ENERGY] if ENERGY in known else known:
        try:
            number = value_of(problem, known[name], state, compiled)
            before = number(state, time)
            change = abs(number(*end) - before)
            if change <= explained * abs(before):
                continue
            around = [number(y, time) for y in states_around(state)]
        except ArithmeticError:  # of a function in plain Python
            continue
        scale = max(scales_of([around], state)[0], abs(before))
        if change > explained * scale:
            false = [claim for claim, _, _ in claims_kept(problem, state, time)]
            return None if name in false else (name, change / scale)
    return None
