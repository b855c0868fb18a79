"""Small problems with known structure, to verify methods with; one file each.

Every factory returns a `geomint.Problem` whose forms describe the same flow. `examples` gives one of
each, with an admissible state at time 0, and of those of `geomint.problems.testproblems` too.
"""

from __future__ import annotations

import geomint as gi
from geomint.arguments import Array
from geomint.problems.testproblems import henon_heiles, neumann, pulsating_body, sphere_metric

from . import (
    abc_flow,
    double_pendulum,
    fast_rotor,
    fast_top,
    frame_in_field,
    lotka_volterra,
    morse,
    outer_solar_system,
    schwarzschild,
    so_n_flow,
    spherical_pendulum,
    spring_pendulum,
    toda,
)

__all__ = ["examples"]


def examples() -> list[tuple[gi.Problem, Array]]:
    """Return all problems, at default parameters, each with an initial state."""
    metric, frame = sphere_metric.problem(), frame_in_field.problem()
    hole = schwarzschild.problem()
    return [
        (lotka_volterra.problem(), lotka_volterra.INITIAL),
        (henon_heiles.problem(), henon_heiles.INITIAL),
        (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
        (double_pendulum.problem(), double_pendulum.INITIAL),
        (pulsating_body.problem(), pulsating_body.INITIAL),
        (so_n_flow.problem(4), so_n_flow.initial(4)),
        (so_n_flow.problem(3, frame=True), so_n_flow.initial(3, frame=True)),
        (abc_flow.problem(), abc_flow.INITIAL),
        (neumann.problem(), neumann.initial()),
        (frame, frame_in_field.initial(frame)),
        (metric, sphere_metric.initial(metric)),
        (outer_solar_system.problem(), outer_solar_system.initial()),
        (hole, schwarzschild.initial(hole)),
        (spring_pendulum.problem(), spring_pendulum.INITIAL),
        (fast_rotor.problem(), fast_rotor.INITIAL),
        (fast_top.problem(), fast_top.initial()),
        (toda.problem(), toda.initial()),
        (morse.problem(), morse.INITIAL),
    ]
