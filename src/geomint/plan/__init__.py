"""The planner: what a scene asks for, and the cheapest way to deliver it, with reasons.

A plan is made by small pure rules, in order: each is a function of what is asked and of the choices
that it depends on, and returns a `Choice`. A plan never changes the answer: it only leaves out
what the scene does not need. `run_methods` plans and runs one scene by one or several methods.
"""

import lazy_loader

# A command imports what it plans, and no other.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
