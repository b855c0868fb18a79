"""The planner: what a scene asks for, and the cheapest way to deliver it, with reasons.

A plan is made by an ordered list of small pure rules, ``rule(context) -> Choice or None``; each
sees the scene and the choices made before it. A plan never changes the answer: it only leaves out
what the scene does not need.
"""

from .context import Choice, Context
from .plan import Plan, make_plan, run_scene

__all__ = ["Choice", "Context", "Plan", "make_plan", "run_scene"]
