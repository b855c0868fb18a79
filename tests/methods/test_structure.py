"""What methods keep: invariants, constraints, symmetry; symplectic forms are in `test_symplectic`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import neumann, pulsating_body, sphere_metric
from tests.problems import (
    double_pendulum,
    frame_in_field,
    lotka_volterra,
    spherical_pendulum,
)

EPSILON = 2.0**-52
STEPS = 10**5
WALK = EPSILON * STEPS**0.5
METHODS = {name: gi.find_method(name) for name in gi.method_names()}


def late(cases: Iterable[Any], fast: Iterable[Any]) -> list[Any]:
    """Parameters, of which some run in the fast row, the others at night."""
    few = list(fast)
    night = pytest.mark.nightly
    return [
        pytest.param(*(c if isinstance(c, tuple) else (c,)), marks=[night] * (c not in few))
        for c in cases
    ]


def assert_no_drift(drift: gi.Drift, scale: float) -> None:
    """Errors of the size of a random walk of roundings, and no slope beyond the scatter.

    Not every random walk looks like one, even to a rule that errs in few of a hundred.
    """
    assert drift.max_abs_error <= WALK * scale, drift
    assert drift.drift_class in ("roundoff", "bounded", "sqrt", "undetermined"), drift
    assert abs(drift.slope) <= 5 * drift.slope_stderr, drift


# --- invariants -----------------------------------------------------------------------------------

ON_ORBITS = [n for n, m in METHODS.items() if m.needs == "action"]
QUADRATIC = [f"gauss-{s}" for s in (1, 2, 5, 8, 11, 16)]


@pytest.mark.parametrize(
    "name",
    late(
        QUADRATIC + ON_ORBITS,
        [*("gauss-1", "gauss-8", "cf-4"), *("rkmk-4", "rkmk-cayley-4"), ON_ORBITS[-1]],
    ),
)
def test_quadratic_invariants_are_kept(name: str) -> None:
    """Over 10⁵ steps of a non-autonomous flow; the roundings of coefficients and sums do not add up.

    By Gauss methods all of them, by those of groups lengths and angles of the vectors that turn.
    """
    h = {"gauss-1": 0.05, "gauss-2": 0.1}.get(name, 0.2 if "gauss" in name else 0.05)
    run = {"t_end": h * STEPS, "step": h, "method": name, "observe": "invariants"}
    sol = gi.solve(pulsating_body.problem(), pulsating_body.INITIAL, **run)
    assert sol.steps == STEPS or METHODS[name].adaptive
    for drift in sol.drift.values():
        assert_no_drift(drift, 2.0)


METRIC = sphere_metric.problem(5, pulse=0.0)
FRAME = frame_in_field.problem(season=0.0)
CONSTRAINED = {
    "metric-5": (METRIC, sphere_metric.initial(METRIC)),
    "frame": (FRAME, frame_in_field.initial(FRAME)),
    "double": (double_pendulum.problem(), double_pendulum.INITIAL),
    "pendulum": (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    "neumann-5": (neumann.problem((0.5, 0.9, 1.4, 2.0, 2.7)), neumann.initial(5)),
}
KEPT = [
    *((name, h, case) for name, h in (("rattle-2", 0.02), ("rattle-4", 0.05), ("rattle-6", 0.1),
      ("lobatto-3", 0.05)) for case in CONSTRAINED if case != "neumann-5"),
    *((name, h, case) for name, h in (("verlet-2", 0.02), ("verlet-4", 0.1))
      for case in ("pendulum", "neumann-5")),
]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "h", "case"),
    late(KEPT, [("lobatto-3", 0.05, "double"), ("rattle-2", 0.02, "pendulum"), KEPT[-4]]),
)
def test_constraints_and_momenta_are_kept(name: str, h: float, case: str) -> None:
    """Constraints to a few roundings over 10⁵ steps; a quadratic momentum map as a random walk."""
    problem, y0 = CONSTRAINED[case]
    names = [*problem.invariants, *problem.constraints]
    drifts = gi.solve(problem, y0, t_end=h * STEPS, step=h, method=name, observe=names).drift
    # Between two moving points, of scale 5.2, all stages of a pair leave a little more.
    bound = (16 if name.startswith("lobatto") else 8) * EPSILON
    for quantity in problem.constraints:
        assert drifts[quantity].max_abs_error <= bound, drifts[quantity]
    for quantity in problem.invariants:
        if quantity == "angular-momentum":  # kicks and great circles keep it, too
            assert_no_drift(drifts[quantity], 1.0)
        elif case != "metric-5":
            # To the rule a frame's energy is noise: a small trend is not excluded.
            kinds = ("bounded", "undetermined") if case == "frame" else ("bounded",)
            assert drifts[quantity].drift_class in kinds
            assert drifts[quantity].max_abs_error < (1e-3 if "verlet" in name else 2e-4)


# --- symmetry -------------------------------------------------------------------------------------

BACK = [n for n, m in METHODS.items() if m.symmetric or (m.needs == "field" and not m.adaptive)]
BACK += ["gauss-1-kahan-li-6", "gauss-1-triple-jump-4", "rattle-yoshida-6", "verlet-yoshida-6"]
EACH = ["gauss-1", "gauss-8", "gauss-11", "lobatto-3", "rattle-2", "rattle-4", "verlet-2"]
EACH += ["gauss-1-triple-jump-4", "rk-4", "dop853", "heun-2"]


@pytest.mark.parametrize("name", late(BACK, EACH))
def test_symmetric_methods_go_back_and_no_others(name: str) -> None:
    """Ψ₋ₕ ∘ Ψₕ is the identity, to rounding."""
    method, metric = gi.find_method(name), sphere_metric.problem()
    problem, y0 = {
        "field": (lotka_volterra.problem(), lotka_volterra.INITIAL),
        "hamiltonian": (metric, sphere_metric.initial(metric)),
        "splitting": (neumann.problem(season=0.4), neumann.initial()),
    }[method.needs]
    motion = gi.Integrator(problem, y0, method, step=0.2, compiled=False)
    motion.step()
    assert np.max(np.abs(motion.state - y0)) > 0.05
    motion.h = -0.2
    motion.step()
    back = np.max(np.abs(motion.state - y0))
    assert back <= 16 * EPSILON if method.symmetric else back > 5e-13
