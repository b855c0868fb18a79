"""geomint's own cases: all built-in scenes and all test problems."""

from ..problems import testproblems
from . import state_cases, step_cases
from .case import StressCase


def cases(examples: step_cases.Examples = testproblems.examples) -> list[StressCase]:
    """Return all cases of this package, or those of all built-in scenes and of other examples."""
    found = list(step_cases.sources(examples))
    return [*step_cases.steps(found), *state_cases.cases(found)]
