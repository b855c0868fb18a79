"""Small problems with known structure, to verify methods with; one file each.

Every factory returns a `geomint.Problem` whose forms describe the same flow. `examples` gives one of
each, with an admissible state at time 0.
"""

from ...arguments import Array
from ..problem import Problem
from . import henon_heiles, neumann, pulsating_body, sphere_metric

__all__ = ["examples"]


def examples() -> list[tuple[Problem, Array]]:
    """Return all problems, at default parameters, each with an initial state."""
    metric = sphere_metric.problem()
    return [
        (henon_heiles.problem(), henon_heiles.INITIAL),
        (pulsating_body.problem(), pulsating_body.INITIAL),
        (neumann.problem(), neumann.initial()),
        (metric, sphere_metric.initial(metric)),
    ]
