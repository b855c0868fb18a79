"""The rule of the planner for the exact flow: states without stepping, where the scene allows it."""

import math

from ..errors import GeomintError
from ..methods import Exact
from ..run.solution import Solution
from ..run.solve import solve
from ..run.timeline import Timeline, evaluation_times
from ..scene.scene import Scene
from .choice import Asked, Choice, Route
from .representation import missing_events


def choose_exact(c: Asked) -> Choice[Route | None] | None:
    """Take the exact flow if the scene allows it, and asks for sampled states alone."""
    if not c.content.integrate.exact:
        return None
    reason = ""
    if c.purpose == "drift":
        reason = "a drift report is one of steps"
    elif c.content.observe.quantities:
        place = c.scene.place("observe", "quantities")
        reason = f"{place} are watched after steps: [] asks for states alone"
    elif c.saving.every is not None:
        reason = "[save] every counts steps"
    if reason:
        return Choice("exact flow", None, "not taken", reason)
    first = c.route(c.representation or c.own)
    refused = f"no representation of {c.content.system.name!r} has one that gives {first.asked}"
    # States at events are not mapped back.
    others = () if c.content.events else c.model.reductions
    for route in (first, *(Route.along(r) for r in others if r.of == first.name)):
        if route.problem.make_exact is None or missing_events(c, route.problem):
            continue
        try:
            error = _phase_error(c, route)
        except GeomintError as failure:
            refused = str(failure)
        else:
            told = f"of {route.name}, in place of {c.method.name}"
            why = f"[integrate] exact; states alone are asked for, phases are known to {error:.1e}"
            return Choice("exact flow", route, told, why)
    return Choice("exact flow", None, "not taken", refused)


def _phase_error(c: Asked, route: Route) -> float:
    """Return what the phases at the end are known to, in radians, or raise an error if they are not."""
    motion, (name, end) = route.problem.exact(route.state), next(iter(c.end.items()))
    tau = end if name == "tau_end" else float(motion.tau(end))
    error = float(motion.phase_error(tau))
    if name == "t_end" or c.saving.t_eval is not None:
        physical = float(motion.time(tau)) if name == "tau_end" else end
        error += float(motion.time_error(tau))
        timeline = Timeline(0.0, math.copysign(1.0, end), 0, 0.0, None, physical)
        evaluation_times(c.saving.t_eval and list(c.saving.t_eval), route.problem, timeline)
    return error


def exact_timeline(c: Asked, route: Route) -> Timeline:
    """Return the timeline of a motion without steps."""
    end = next(iter(c.end.values()))
    own = "tau_end" in c.end or route.problem.time == "t"
    return Timeline(
        0.0, math.copysign(1.0, end), 0, 0.0, end if own else None, None if own else end
    )


def follow_exactly(
    route: Route, scene: Scene, t_eval: tuple[float, ...] | None, progress: bool | None
) -> Solution:
    """Return the states and events that are asked for, by the exact flow: no steps, no evaluations."""
    time = scene.content.time
    return solve(
        route.problem,
        route.state,
        t_end=time.t_end,
        tau_end=time.tau_end,
        method=Exact(),
        t_eval=None if t_eval is None else list(t_eval),
        events=scene.events,
        progress=progress,
    )
