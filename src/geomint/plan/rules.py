"""The rules of the planner: small pure functions of what is asked and of the choices before."""

import math
from collections.abc import Mapping

from ..errors import SceneError
from ..kernels.solve.status import NOT_CONVERGED
from ..methods.method import Method
from ..methods.registry import AUTO
from ..problems.evaluate import value
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from ..run.accuracy.auto import auto_method
from ..run.promise import Setting
from ..run.timeline import Timeline, evaluation_times, plan_timeline
from ..watch.functions import Function, grouped
from ..watch.quantities import find_watcher, quantities_of
from ..watch.watcher import Watcher
from .choice import Asked, Choice, Names, Route, Saving
from .representation import missing_quantities, wanted_watchers
from .tolerance import told_accuracy

_PROBE_STEPS = 4
_PROBE_ROWS = 64
_PROBE_CAP = 100  # iterations


def choose_method(c: Asked, problem: Problem) -> Choice[Method]:
    """State the method."""
    method = c.method
    kind = method.structure(problem)
    reason = f"order {method.order}{', ' + kind if kind else ''}: {method.summary}"
    options = ", ".join(f"{k} {v!r}" for k, v in c.content.integrate.options.items())
    told = f"{method.name}{' with ' + options if options else ''}"
    if c.content.integrate.method == AUTO:
        reason = f"auto: {auto_method(problem, c.content.integrate.tolerance)[1]}; {reason}"
    return Choice("method", method, told, reason)


def choose_clock(c: Asked, problem: Problem) -> Choice[bool]:
    """Integrate physical time only if the end or the saved states need it."""
    what = "physical time"
    if problem.time == "t":
        return Choice(what, False, "is the problem's own", "nothing to do")
    reason = ""
    if c.content.time.t_end is not None:
        reason = "the end is given in physical time"
    elif c.saving.t_eval is not None:
        reason = "states are wanted at physical times"
    elif c.purpose == "run":
        reason = "saved states carry their physical times"
    if reason:
        return Choice(what, True, "integrated beside the state", reason)
    return Choice(what, False, "not integrated", "nothing that is asked for needs it")


def timeline_of(c: Asked, route: Route, chosen: Setting | None) -> Timeline:
    """Return steps and end; the default step is that of the representation whose states are kept."""
    if chosen is not None:
        method, step = chosen.method, chosen.step
        return plan_timeline(route.problem, method, route.state, **c.end, step=step)
    step, end = c.content.integrate.step, next(iter(c.end.values()))
    if step is None and route.lift is not None:
        asked = c.route(route.asked)
        step = c.method.default_step(asked.problem, asked.state, end)
    return plan_timeline(route.problem, c.method, route.state, **c.end, step=step)


def choose_states(c: Asked, problem: Problem, timeline: Timeline) -> Choice[Saving]:
    """Store no state that is not asked for."""
    what, save = "states kept", c.saving
    if c.purpose == "drift":
        reason = "a drift report shows no states: memory does not grow with the run"
        return Choice(what, save, "the last", reason)
    if save.t_eval is not None:
        evaluation_times(list(save.t_eval), problem, timeline)
        reason = "[save] t_eval; each met exactly by a partial step beside the run"
        return Choice(what, save, f"at {len(save.t_eval)} physical times", reason)
    if save.every is not None:
        count = timeline.steps
        many = "" if count is None else f": {2 + (count - 1) // save.every} states"
        told = f"the first, every {save.every} steps, the last{many}"
        return Choice(what, save, told, "[save] every")
    return Choice(what, save, "the last", "no [save] section")


def watchers_of(c: Asked, route: Route) -> dict[str, Watcher]:
    """Return what watches the quantities that are asked for and are there, by name."""
    wanted, options = wanted_watchers(c, route.problem), c.content.observe.options
    there = {name: watcher for name, watcher in wanted.items() if watcher is not None}
    if wanted and not there:
        lacking = f"{route.name} has no {', '.join(wanted)}"
        place = c.scene.place("observe", "quantities")
        raise SceneError(f"a drift report has nothing to show: {place}: {lacking}")
    given = {name: there[name].with_options(**options[name]) for name in there if name in options}
    return there | given


def choose_quantities(
    c: Asked, route: Route, timeline: Timeline, watchers: Mapping[str, Watcher]
) -> Choice[Names]:
    """Evaluate the watched quantities and no others; by one function where they are many.

    The group of constraints means those of the representation that is integrated.
    """
    names, place = tuple(watchers), c.scene.place("observe", "quantities")
    if not names:
        return Choice("watched", names, "nothing", f"{place} is empty")
    every = c.content.observe.every
    often = "after every step" if every == 1 else f"every {every} steps and at the end"
    if c.scene.place("observe", "every") != "[observe] every":
        often += f" ({c.scene.place('observe', 'every')})"
    for name, watcher in watchers.items():
        often += f" ({name}: the first {watcher.steps} steps)" if watcher.steps else ""
    functions = [watcher for watcher in watchers.values() if isinstance(watcher, Function)]
    groups = grouped(functions, timeline.expected / every)
    often += ", by one function" if len(groups) == 1 < len(groups[0]) else ""
    rest = len({*quantities_of(route.problem)} - {*names})
    left = f"; {rest} other{'s' if rest > 1 else ''} left out" if rest else ""
    section = "[observe]" if place == "[observe] quantities" else place
    reason = f"{section}, {often}, reduced to windows on the way{left}"
    return Choice("watched", names, ", ".join(names), reason)


def choose_missing(c: Asked, route: Route) -> Choice[Names] | None:
    """Say what is asked for and cannot be watched in the representation that is integrated."""
    missing = missing_quantities(c, route.problem)
    if not missing:
        return None
    where = [
        name
        for name, problem in c.model.problems.items()
        if all(find_watcher(problem, quantity) for quantity in missing)
    ]
    there = f"; only in {', '.join(where)}" if where else ""
    reason = f"{route.name} has no such quantity{there}"
    return Choice("not watched", tuple(missing), ", ".join(missing), reason)


def choose_events(c: Asked) -> Choice[Names] | None:
    """Look for events where states are asked for."""
    events = c.content.events
    if not events or c.purpose == "drift":
        return None
    ends = [name for name, event in events.items() if event.terminal]
    reason = f"[events]; {' or '.join(ends)} ends the run" if ends else "[events]"
    return Choice("events", tuple(events), ", ".join(events), reason)


def choose_step(
    c: Asked, route: Route, timeline: Timeline, chosen: Setting | None
) -> Choice[float]:
    """State the step and where it came from."""
    given, method, h = c.content.integrate.step, c.method, abs(timeline.h)
    unit = "τ" if route.problem.time == "tau" else "t"
    if chosen is not None:
        told = f"{h:.10g} in {unit}"
        if method.adaptive:
            told = f"adaptive, {_tolerances(chosen.method)}; the first {h:.4g} in {unit}"
        return Choice("step", h, told, told_accuracy(chosen, c.scene))
    if method.adaptive:
        return _adaptive_step(c, h, unit)
    if given is not None:
        reason = c.scene.place("integrate", "step")
        if timeline.steps == 0:
            reason += ", longer than the run: one step to the end is taken instead"
        elif h != given:
            reason += f" = {given!r}, adjusted by rounding to reach the end in whole steps"
    else:
        asked = c.route(route.asked) if route.lift is not None else route
        natural = characteristic_time(asked.problem, asked.state, direction=timeline.h)
        reason = (
            f"default: {method.step_fraction:.4g} (for {method.name}) × the initial state's "
            f"characteristic time {natural:.4g}"
        )
    return Choice("step", h, f"{h:.10g} in {unit}", reason)


def _adaptive_step(c: Asked, h: float, unit: str) -> Choice[float]:
    options, given = c.method.options, c.content.integrate.step
    longest = f", none above {options['max_step']:g}" if options["max_step"] < math.inf else ""
    estimated = "an estimate at the initial state"
    origin = estimated if given is None else c.scene.place("integrate", "step")
    reason = (
        "every step is as long as the estimated error allows: rtol of each piece of the state, and "
        f"atol; the first by {origin}"
    )
    told = f"adaptive, {_tolerances(c.method)}{longest}; the first {h:.4g} in {unit}"
    return Choice("step", h, told, reason)


def _tolerances(method: Method) -> str:
    return f"rtol {method.options['rtol']:.3g}, atol {method.options['atol']:.3g}"


def choose_steps(c: Asked, route: Route, timeline: Timeline) -> Choice[int | None]:
    """State how many steps that makes; None where only the run finds out."""
    problem = route.problem
    if c.method.adaptive:
        unit = "t" if timeline.own_end is None else problem.time.replace("tau", "τ")
        end = timeline.physical_end if timeline.own_end is None else timeline.own_end
        reason = f"end at {unit} = {end:g}, met exactly by the last step"
        return Choice("steps", None, "as many as the tolerances need", reason)
    if timeline.steps is not None:
        end = timeline.own_end or 0.0
        last = f" and a last one of {abs(timeline.remainder):.4g}" if timeline.remainder else ""
        reason = f"end at {'τ' if problem.time == 'tau' else 't'} = {end:g}"
        return Choice("steps", timeline.steps, f"{timeline.steps}{last}", reason)
    physical, clock = timeline.physical_end, problem.clock
    assert physical is not None
    assert clock is not None
    rate = value(problem, clock, route.state)
    if not rate > 0.0:
        reason = f"end at t = {physical:g}, but dt/dτ is {rate:.4g} at the start"
        return Choice("steps", None, "not known", reason)
    count = round(abs(physical / (rate * timeline.h))) + 1
    reason = (
        f"end at t = {physical:g}, met by a last partial step; dt/dτ is {rate:.4g} at the start"
    )
    return Choice("steps", count, f"about {count}", reason)


def estimate_evaluations(
    c: Asked, route: Route, timeline: Timeline, clock: bool, steps: int | None
) -> Choice[float | None] | None:
    """Estimate the evaluations of the field; for implicit methods from some plain steps."""
    method, what = c.method, "field evaluations"
    implicit = "max_iterations" in method.options
    if implicit and route.problem.rows > _PROBE_ROWS:
        return None
    from ..kernels.numbers.blocks import scalar_block

    if implicit:  # Newton's method, and many iterations, would take minutes in plain Python
        if method.options.get("iteration") == "newton":
            return Choice(what, None, "not known", "Newton's method is not tried before the run")
        changed = {"max_iterations": min(method.options["max_iterations"], _PROBE_CAP)}
        if "iteration" in method.options:
            changed["iteration"] = "fixed-point"
        method = method.with_options(**changed)
    flow = method.on(route.problem, route.state, clock=clock, compiled=False)
    stepper = flow.begin(route.state, 0.0, timeline.h)
    if method.adaptive:
        few = stepper.evaluations_in(1000, 1000) / 1000
        return Choice(what, None, f"{few:.3g} a step", "rejected steps count as well")
    if steps is None:
        return None
    if not implicit:
        total = steps * flow.evaluations
        return Choice(what, total, f"{total:.4g}", f"{flow.evaluations:g} a step")
    first = rest = stepper.advance(0, 1, 1, scalar_block(stepper.rows))
    tried = min(_PROBE_STEPS, max(_PROBE_CAP // max(first.iterations, 1), 1))
    if not first.status:
        rest = stepper.advance(1, tried, tried, scalar_block(stepper.rows))
    if rest.status == NOT_CONVERGED and method != c.method:
        reason = (
            f"{rest.iterations} iterations found no fixed point: the step is too long, or needs "
            "Newton's method; give a shorter one, or none for the default"
        )
        return Choice(what, None, "not known", reason)
    if rest.status:
        error = stepper.error(rest, 0 if first.status else 1)
        return Choice(what, None, "the run will fail", str(error))
    iterations = rest.iterations / tried
    total = steps * iterations * flow.evaluations
    each = f"{iterations:.3g} iterations of {flow.evaluations:g} a step"
    return Choice(what, total, f"about {total:.3g}", f"{each}, tried on {tried} steps")
