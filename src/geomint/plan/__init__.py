"""The planner: what a scene asks for, and the cheapest way to deliver it, with reasons.

A plan is made by an ordered list of small pure rules, ``rule(context) -> Choice or None``; each
sees the scene and the choices made before it. A plan never changes the answer: it only leaves out
what the scene does not need. `run_methods` plans and runs one scene for each of several methods.
"""

from .context import Choice, Context
from .duration import Estimate, comparison_time, estimate, expected_time
from .plan import Plan, make_plan, run_scene
from .several import MethodRun, SeveralRuns, expected_plans, run_methods

__all__ = [
    "Choice",
    "Context",
    "Estimate",
    "MethodRun",
    "Plan",
    "SeveralRuns",
    "comparison_time",
    "estimate",
    "expected_plans",
    "expected_time",
    "make_plan",
    "run_methods",
    "run_scene",
]
