"""The planner: what a scene asks for, and the cheapest way to deliver it, with reasons.

A plan is made by an ordered list of small pure rules, ``rule(context) -> Choice or None``; each
sees the scene and the choices made before it. A plan never changes the answer: it only leaves out
what the scene does not need. `run_methods` plans and runs one scene by one or several methods.
"""

from .context import Choice, Context
from .duration import Estimate, comparison_time, estimate, expected_time
from .plan import Plan, make_plan, run_scene
from .several import (
    MethodRun,
    SeveralRuns,
    common_notes,
    expected_plans,
    run_methods,
    run_plan,
)

__all__ = [
    "Choice",
    "Context",
    "Estimate",
    "MethodRun",
    "Plan",
    "SeveralRuns",
    "common_notes",
    "comparison_time",
    "estimate",
    "expected_plans",
    "expected_time",
    "make_plan",
    "run_methods",
    "run_plan",
    "run_scene",
]
