"""The rule of the planner for the exact flow: states without stepping, where the scene allows it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import GeomintError
from ..run.result import StepSizes
from ..run.solution import Solution
from ..run.timeline import Timeline, evaluation_times
from .choice import Asked, Choice, Route

if TYPE_CHECKING:
    from .plan import Plan

__all__ = ["choose_exact", "exact_timeline", "follow_exactly"]


def choose_exact(c: Asked) -> Choice[Route | None] | None:
    """Take the exact flow if the scene allows it, and asks for sampled states alone."""
    if not c.content.integrate.exact:
        return None
    reason = ""
    if c.purpose == "drift":
        reason = "a drift report is one of steps"
    elif c.content.observe.quantities:
        reason = "[observe] quantities are watched after steps: [] asks for states alone"
    elif c.saving.every is not None:
        reason = "[save] every counts steps"
    if reason:
        return Choice("exact flow", None, "not taken", reason)
    name = c.content.integrate.representation
    first = c.route(c.own if name in (None, "own") else str(name))
    refused = f"no representation of {c.content.system.name!r} has one that gives {first.asked}"
    for route in (first, *(Route.along(r) for r in c.model.reductions if r.of == first.name)):
        if route.problem.make_exact is None:
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


def follow_exactly(plan: Plan) -> Solution:
    """Return the states that a plan asks for, by the exact flow: no steps, no evaluations."""
    route, content = plan.route, plan.scene.content
    motion: Any = route.problem.exact(route.state)
    in_tau, t_eval = route.problem.time == "tau", plan.save.chosen.t_eval
    if t_eval is None and content.time.tau_end is not None:
        tau = np.array([content.time.tau_end])
        y, physical = motion.at_tau(tau), motion.time(tau)
    else:
        physical = np.array([content.time.t_end] if t_eval is None else t_eval)
        y, tau = motion(physical), motion.tau(physical) if in_tau else physical
    return Solution(
        problem=route.problem,
        method=plan.method.chosen,
        step=0.0,
        step_sizes=StepSizes(0.0, 0.0, 0.0),
        tau=np.asarray(tau),
        y=np.asarray(y),
        drift={},
        steps=0,
        rejected=0,
        iterations=0,
        evaluations=0,
        run_seconds=0.0,
        watching_seconds=0.0,
        compile_seconds=0.0,
        status="success",
        message="",
        drift_time="t" if content.time.tau_end is None else "tau",
        physical=np.asarray(physical),
        route="exact flow",
    )
