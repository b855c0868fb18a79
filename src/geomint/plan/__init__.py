"""The planner: what a scene asks for, and the cheapest way to deliver it, with reasons.

A plan is made by small pure rules, in order: each is a function of what is asked and of the choices
that it depends on, and returns a `Choice`. A plan never changes the answer: it only leaves out
what the scene does not need. `run_methods` plans and runs one scene by one or several methods.
"""

from .chaos import ChaosPlan, plan_chaos
from .choice import Choice, Route, Saving
from .duration import Estimate, estimate, expected_time
from .fitting import representation_for
from .plan import Plan, make_plan, run_scene
from .scan import ScanPlan, plan_scan
from .sections import SectionPlan, plan_section
from .several import (
    MethodRun,
    SeveralRuns,
    common_notes,
    expected_plans,
    run_methods,
    run_plan,
)

__all__ = [
    "ChaosPlan",
    "Choice",
    "Estimate",
    "MethodRun",
    "Plan",
    "Route",
    "Saving",
    "ScanPlan",
    "SectionPlan",
    "SeveralRuns",
    "common_notes",
    "estimate",
    "expected_plans",
    "expected_time",
    "make_plan",
    "plan_chaos",
    "plan_scan",
    "plan_section",
    "representation_for",
    "run_methods",
    "run_plan",
    "run_scene",
]
