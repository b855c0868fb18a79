"""What a run says of its step: that it was not taken, or is longer than makes sense."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..arguments import Array
from ..errors import DomainError, StepWarning, tell
from ..methods import Method, Start
from ..methods.adaptive import Adaptive
from ..problems.evaluate import scales_of, states_around, value_of
from ..problems.problem import Problem
from ..watch.functions import ENERGY, Function
from ..watch.watcher import Watcher
from .local_error import LocalError, Ranked

if TYPE_CHECKING:
    from .recorder import Recorder
    from .solution import Solution
    from .timeline import Timeline

__all__ = ["advice", "tell_coarse_steps", "tell_errors", "tell_long_steps", "tell_short_run"]

SHORTER = "give a shorter one, such as geomint.solve takes with a tolerance"
QUIET = 1e-4  # numbers of all steps that no integral is lost with (`geomint.kernels.solve.ranks`)
LONG = 2.0  # times the default step
LOST = 1e-2  # of the scale of an integral: what is off by more at the end is not the motion
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


def tell_errors(error: LocalError, time: str, do: str = SHORTER) -> None:
    """Warn of steps that err by more than is promised; `time` is the name of the problem's own."""
    text = (
        f"steps of {error.step:.3g} err by {error.largest:.2g} of a piece of the state, near "
        f"{time} = {error.time:.6g}: more than is promised where no step is given; {do}"
    )
    tell(StepWarning(text, "state", error.largest, error.time))


def advice(solution: Solution, part: float) -> str:
    """Return what to do so that a run errs by such a part of what it errs by; 0: nothing helps."""
    ranked = solution.ranked
    if isinstance(ranked, Ranked) and ranked.concentrated:
        return "if a force switches there, name the time: breaks=[…]"
    if not part > 0.0:
        return "no shorter step does better: give an earlier end"
    if isinstance(solution.method, Adaptive):
        return "give a smaller tolerance"
    step = abs(solution.step) * min(part ** (1.0 / solution.method.order), 0.5)
    return f"give a shorter step: step={step:.2g}"


def tell_coarse_steps(
    solution: Solution, recorder: Recorder, start: Start, watched: Mapping[str, Watcher]
) -> None:
    """Warn of given steps with which an integral is off by more than `LOST` at the end."""
    problem, ranked = start.problem, solution.ranked
    if isinstance(ranked, Ranked) and 0.0 < ranked.number("total") < QUIET:
        return
    if isinstance(solution.method, Adaptive) or not len(solution.y) or problem.rows > FEW:
        return
    off = _integrals_off(solution, recorder, start, watched)
    for name, part in [*off.items()][:1]:
        text = (
            f"steps of {abs(start.h):.3g} are so long that {name} is off by {part:.2g} of its size at "
            "the end: give a shorter step, or a tolerance in its place"
        )
        tell(StepWarning(text, name, part, recorder.own_time))


def _integrals_off(
    solution: Solution, recorder: Recorder, start: Start, watched: Mapping[str, Watcher]
) -> dict[str, float]:
    """Return integrals that are off at the end by more than `LOST` of their scale, and by how much.

    The energy is looked at, where there is one, and else all. The scale is `rounding_scale` where the
    run began, or the value there where that overflows.
    """
    problem, state, known = start.problem, start.y0, start.problem.invariants
    end, time, found = recorder.last_state, recorder.own_time, {}
    for name in [ENERGY] if ENERGY in known else known:
        by, scale = watched.get(name), 0.0
        try:
            if isinstance(by, Function) and by.steps is None and by.function is known[name]:
                drift = solution.drift[name]
                before, change, scale = drift.initial, abs(drift.final_error), drift.scale
            else:
                number = value_of(problem, known[name], state, start.compiled)
                before = number(state, start.t0)
                change = abs(number(end, time) - before)
                if change > LOST * abs(before):
                    around = [number(y, start.t0) for y in states_around(state)]
                    scale = scales_of([around], state)[0]
        except ArithmeticError:  # of a function in plain Python
            continue
        if change > LOST * max(scale, abs(before)):
            found[name] = change / max(scale, abs(before))
    return found
