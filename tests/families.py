"""A problem for every family of steppers: what all of them are held to."""

from __future__ import annotations

import pytest

from geomint.problems.testproblems import henon_heiles, neumann, pulsating_body, sphere_metric
from tests.problems import (
    abc_flow,
    double_pendulum,
    frame_in_field,
    lotka_volterra,
    so_n_flow,
    spherical_pendulum,
)

METRIC, FRAME = sphere_metric.problem(), frame_in_field.problem()
PROBLEMS = {
    "lotka-volterra": (lotka_volterra.problem(), lotka_volterra.INITIAL),
    "henon-heiles": (henon_heiles.problem(), henon_heiles.INITIAL),
    "pulsating-body": (pulsating_body.problem(), pulsating_body.INITIAL),
    "so-4": (so_n_flow.problem(4), so_n_flow.initial(4)),
    "so-3-frame": (so_n_flow.problem(3, frame=True), so_n_flow.initial(3, frame=True)),
    "sphere-metric": (METRIC, sphere_metric.initial(METRIC)),
    "double-pendulum": (double_pendulum.problem(), double_pendulum.INITIAL),
    "spherical-pendulum": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "frame-in-field": (FRAME, frame_in_field.initial(FRAME)),
    "abc-flow": (abc_flow.problem(), abc_flow.INITIAL),
    "neumann": (neumann.problem((2.0, 0.3, 1.1, 2.7), 0.4), neumann.initial(4)),
    "neumann-at-rest": (neumann.problem(), neumann.initial() * [1, 1, 1, 0, 0, 0]),
}
LATER = {  # pairs whose kernel is another pair's too, of other sizes or with another table
    *(("gauss-1-suzuki-4", "henon-heiles"), ("dop853", "sphere-metric")),
    *(("gauss-8", "sphere-metric"), ("dop853-adaptive", "sphere-metric")),
    *(("rkmk-dormand-prince-5", "so-4"), ("rkmk-cayley-4", "so-3-frame")),
    *(("rattle-4", "double-pendulum"), ("rattle-2", "frame-in-field")),
    ("lobatto-8", "neumann-at-rest"),
}
FAMILIES = [
    ("rk-4", "lotka-volterra"),
    ("dop853", "sphere-metric"),
    ("gauss-3", "lotka-volterra"),
    ("gauss-8", "sphere-metric"),
    ("gauss-11", "lotka-volterra"),
    ("gauss-1-suzuki-4", "henon-heiles"),
    ("cf-4", "pulsating-body"),
    ("cf-3", "so-3-frame"),
    ("rkmk-4", "pulsating-body"),
    ("rkmk-dormand-prince-5", "so-4"),
    ("rkmk-cayley-4", "so-3-frame"),
    ("dormand-prince-5-adaptive", "lotka-volterra"),
    ("dop853-adaptive", "sphere-metric"),
    ("rkmk-dormand-prince-5-adaptive", "pulsating-body"),
    ("rkmk-cayley-dop853-adaptive", "so-4"),
    ("rattle-2", "sphere-metric"),
    ("rattle-4", "double-pendulum"),
    ("rattle-2", "frame-in-field"),
    ("lobatto-3", "double-pendulum"),
    ("verlet-2", "neumann"),
    ("verlet-4", "abc-flow"),
    ("gauss-8", "neumann-at-rest"),
    ("rattle-2", "neumann-at-rest"),
    ("lobatto-8", "neumann-at-rest"),
]


def pairs(
    chosen: list[tuple[str, str]], fast: list[tuple[str, str]] = FAMILIES
) -> pytest.MarkDecorator:
    """Return pairs of a method and a problem as parameters; what is not `fast` runs at night."""
    late = [p for p in chosen if p in LATER or p not in fast]
    marked = [pytest.param(*p, marks=[pytest.mark.nightly] * (p in late)) for p in chosen]
    return pytest.mark.parametrize(("name", "problem"), marked)


# A pair for every kind of stepper: for what does not ask for the tableau, the group or the size.
KINDS = [
    ("rk-4", "lotka-volterra"),
    ("gauss-3", "lotka-volterra"),
    ("cf-4", "pulsating-body"),
    ("dormand-prince-5-adaptive", "lotka-volterra"),
    ("rkmk-dormand-prince-5-adaptive", "pulsating-body"),
    ("rattle-2", "sphere-metric"),
    ("lobatto-3", "double-pendulum"),
    ("verlet-2", "neumann"),
    ("gauss-8", "neumann-at-rest"),
    ("rattle-2", "neumann-at-rest"),
]
kinds = pairs(FAMILIES, KINDS)

# Derivatives are compiled for every pair anew: five of them are in the fast row.
differentiated = pairs(
    [pair for pair in FAMILIES if "adaptive" not in pair[0]],
    [pair for pair in KINDS if pair[0] in ("rk-4", "cf-4", "gauss-8", "rattle-2")],
)
