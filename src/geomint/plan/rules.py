"""The rules of the planner, in their order."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..errors import SceneError, StepError
from ..methods.method import Start
from ..problems.evaluate import value
from ..problems.time_scale import characteristic_time
from ..run.timeline import evaluation_times
from ..watch.observe import MEASURE, quantities_of
from .context import Choice, Context
from .representation import choose_representation, missing_quantities, wanted_quantities

__all__ = ["COST_RULES", "RULES"]

_PROBE_STEPS = 4
_PROBE_ROWS = 64


def choose_method(c: Context) -> Choice:
    """State the method."""
    method = c.scene.method
    kind = method.structure(c.problem)
    reason = f"order {method.order}{', ' + kind if kind else ''}: {method.summary}"
    options = ", ".join(f"{k} {v!r}" for k, v in c.scene.content.integrate.options.items())
    return Choice("method", f"{method.name}{' with ' + options if options else ''}", reason)


def choose_clock(c: Context) -> Choice:
    """Integrate physical time only if the end or the saved states need it."""
    problem, content = c.problem, c.scene.content
    if problem.time == "t":
        return Choice("physical time", "is the problem's own", "nothing to do", False)
    reason = ""
    if content.time.t_end is not None:
        reason = "the end is given in physical time"
    elif c.purpose == "run" and content.save.t_eval is not None:
        reason = "states are wanted at physical times"
    elif c.purpose == "run" and c.scene.method.needs != "action":
        reason = "saved states carry their physical times"
    if reason:
        return Choice("physical time", "integrated beside the state", reason, True)
    return Choice("physical time", "not integrated", "nothing that is asked for needs it", False)


def choose_states(c: Context) -> Choice:
    """Store no state that is not asked for."""
    save = c.scene.content.save
    if c.purpose == "drift":
        reason = "a drift report shows no states: memory does not grow with the run"
        return Choice("states kept", "the last", reason)
    if save.t_eval is not None:
        evaluation_times(save.t_eval, c.problem, c.timeline)
        reason = "[save] t_eval; each met exactly by a partial step beside the run"
        return Choice("states kept", f"at {len(save.t_eval)} physical times", reason)
    if save.every is not None:
        count = c.timeline.steps
        many = "" if count is None else f": {2 + (count - 1) // save.every} states"
        value = f"the first, every {save.every} steps, the last{many}"
        return Choice("states kept", value, "[save] every")
    return Choice("states kept", "the last", "no [save] section")


def choose_quantities(c: Context) -> Choice:
    """Evaluate the watched quantities and no others.

    The group of constraints means those of the representation that is integrated.
    """
    has, wanted = quantities_of(c.problem), wanted_quantities(c, c.representation)
    names = [name for name in wanted if name in has]
    if wanted and not names:
        lacking = f"{c.representation} has no {', '.join(wanted)}"
        raise SceneError(f"a drift report has nothing to show: [observe] quantities: {lacking}")
    if not names:
        return Choice("watched", "nothing", "[observe] quantities is empty", [])
    every = c.scene.content.observe.every
    often = "after every step" if every == 1 else f"every {every} steps and at the end"
    limit = c.scene.content.observe.measure_steps
    if MEASURE in names and limit is not None:
        often += f" ({MEASURE}: the first {limit} steps)"
    rest = len(has) - len(names)
    left = f"; {rest} other{'s' if rest > 1 else ''} left out" if rest else ""
    reason = f"[observe], {often}, reduced to windows on the way{left}"
    return Choice("watched", ", ".join(names), reason, names)


def choose_missing(c: Context) -> Choice | None:
    """Say what is asked for and cannot be watched in the representation that is integrated."""
    missing = missing_quantities(c, c.representation)
    if not missing:
        return None
    where = [
        name
        for name, problem in c.scene.model.problems.items()
        if set(missing) <= set(quantities_of(problem))
    ]
    there = f"; only in {', '.join(where)}" if where else ""
    reason = f"{c.representation} has no such quantity{there}"
    return Choice("not watched", ", ".join(missing), reason, missing)


def choose_step(c: Context) -> Choice:
    """State the step and where it came from."""
    given, method, h = c.scene.content.integrate.step, c.scene.method, abs(c.timeline.h)
    unit = "τ" if c.problem.time == "tau" else "t"
    if method.adaptive:
        return _adaptive_step(c, f"{h:.4g} in {unit}")
    if given is not None:
        reason = "[integrate] step"
        if c.timeline.steps == 0:
            reason += ", longer than the run: one step to the end is taken instead"
        elif h != given:
            reason += f" = {given!r}, adjusted by rounding to reach the end in whole steps"
    else:
        natural = characteristic_time(c.problem, c.state, direction=c.timeline.h)
        reason = (
            f"default: {method.step_fraction:.4g} (for {method.name}) × the initial state's "
            f"characteristic time {natural:.4g}"
        )
    return Choice("step", f"{h:.10g} in {unit}", reason, h)


def _adaptive_step(c: Context, first: str) -> Choice:
    options, given = c.scene.method.options, c.scene.content.integrate.step
    longest = f", none above {options['max_step']:g}" if options["max_step"] < math.inf else ""
    origin = "[integrate] step" if given is not None else "an estimate at the initial state"
    reason = (
        "every step is as long as the estimated error allows: rtol of each piece of the state, and "
        f"atol; the first by {origin}"
    )
    tolerances = f"rtol {options['rtol']:g}, atol {options['atol']:g}"
    return Choice("step", f"adaptive, {tolerances}{longest}; the first {first}", reason)


def choose_steps(c: Context) -> Choice:
    """State how many steps that makes."""
    timeline = c.timeline
    if c.scene.method.adaptive:
        unit = "t" if timeline.own_end is None else c.problem.time.replace("tau", "τ")
        end = timeline.physical_end if timeline.own_end is None else timeline.own_end
        reason = f"end at {unit} = {end:g}, met exactly by the last step"
        return Choice("steps", "as many as the tolerances need", reason)
    if timeline.steps is not None:
        end = timeline.own_end or 0.0
        last = f" and a last one of {abs(timeline.remainder):.4g}" if timeline.remainder else ""
        reason = f"end at {'τ' if c.problem.time == 'tau' else 't'} = {end:g}"
        return Choice("steps", f"{timeline.steps}{last}", reason, timeline.steps)
    physical, clock = timeline.physical_end, c.problem.clock
    assert physical is not None
    assert clock is not None
    rate = value(c.problem, clock, c.state)
    if not rate > 0.0:
        reason = f"end at t = {physical:g}, but dt/dτ is {rate:.4g} at the start"
        return Choice("steps", "not known", reason)
    count = round(abs(physical / (rate * timeline.h))) + 1
    reason = (
        f"end at t = {physical:g}, met by a last partial step; dt/dτ is {rate:.4g} at the start"
    )
    return Choice("steps", f"about {count}", reason, count)


def estimate_evaluations(c: Context) -> Choice | None:
    """Estimate the evaluations of the field; for implicit methods from some plain steps."""
    steps, method = c.choices["steps"].detail, c.scene.method
    implicit = "max_iterations" in method.options
    if implicit and c.problem.rows > _PROBE_ROWS:
        return None
    from ..kernels.numbers.blocks import scalar_block

    start = Start(c.problem, c.state, 0.0, c.timeline.h, clock=c.clock, compiled=False)
    stepper = method.start(start)
    if method.adaptive:
        few = stepper.evaluations_in(1000, 1000) / 1000
        return Choice("field evaluations", f"{few:.3g} a step", "rejected steps count as well")
    if steps is None:
        return None
    if not implicit:
        total = steps * stepper.evaluations
        return Choice("field evaluations", f"{total:.4g}", f"{stepper.evaluations:g} a step", total)
    first = stepper.advance(0, 1, 1, scalar_block(stepper.rows))
    rest = stepper.advance(1, _PROBE_STEPS, _PROBE_STEPS, scalar_block(stepper.rows))
    if first.status or rest.status:
        error: StepError = stepper.error(first if first.status else rest, 0 if first.status else 1)
        return Choice("field evaluations", "the run will fail", str(error))
    iterations = rest.iterations / _PROBE_STEPS
    total = steps * iterations * stepper.evaluations
    each = f"{iterations:.3g} iterations of {stepper.evaluations:g} a step"
    return Choice(
        "field evaluations", f"about {total:.3g}", f"{each}, tried on {_PROBE_STEPS} steps", total
    )


RULES: tuple[Callable[[Context], Choice | None], ...] = (
    choose_representation,
    choose_method,
    choose_clock,
    choose_states,
    choose_quantities,
    choose_missing,
    choose_step,
    choose_steps,
)
COST_RULES: tuple[Callable[[Context], Choice | None], ...] = (estimate_evaluations,)
