"""The problems that methods are verified with: their forms are one flow, their invariants constant."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles, neumann, pulsating_body, sphere_metric
from geomint.testing import check_problem
from tests.problems import (
    examples,
    so_n_flow,
)


def metric(n: int, **options: float) -> tuple[gi.Problem, np.ndarray]:
    problem = sphere_metric.problem(n, **options)
    return problem, sphere_metric.initial(problem)


CASES = {
    **{problem.name: (problem, y0) for problem, y0 in examples()},
    **{f"so-{n}": (so_n_flow.problem(n, season=0.7), so_n_flow.initial(n)) for n in (2, 6)},
    "so-4-frame": (so_n_flow.problem(4, frame=True), so_n_flow.initial(4, frame=True)),
    **{f"metric-{n}": metric(n, pulse=-0.2, bend=1.3, pull=-0.4) for n in (2, 6)},
    "body": (
        pulsating_body.problem((2.0, 1.0, 0.7), (0.1, 0.5, -0.3), (2.0, 0.5, 1.0), (1.0, 0.3, 0.0)),
        pulsating_body.INITIAL,
    ),
    **{
        f"neumann-{n}": (neumann.problem(np.linspace(2, 0.3, n), -0.6), neumann.initial(n))
        for n in (2, 5)
    },
    "weak": (henon_heiles.problem(0.3), henon_heiles.INITIAL),
}
TIMES = {  # in which much happens, where that is not 1
    "outer-solar-system-6": 500.0,
    "schwarzschild": 40.0,
    "spring-pendulum": 0.02,
    "fast-top": 0.2,
}
each_case = pytest.mark.parametrize("name", CASES)


@each_case
def test_every_problem_is_one(name: str) -> None:
    """The public suite, at the initial state: forms, constraints, invariants, groups."""
    problem, y0 = CASES[name]
    check_problem(problem, [y0])


@pytest.mark.nightly
@each_case
def test_forms_describe_one_flow(name: str) -> None:
    """Methods of all forms come to the same state, by the ODE's own reference.

    In plain Python: that compiled code has the same bits is the business of `test_bits`.
    """
    problem, y0 = CASES[name]
    time = TIMES.get(name, 1.0)
    plain = {"t_end": time, "compiled": False}
    reference = gi.solve(problem, y0, step=0.02 * time, method="dop853", **plain).y[-1]
    assert np.max(np.abs(reference - y0)) > 0.05
    for form, method, steps in (
        ("action", "rkmk-dop853", 20),
        ("hamiltonian", "rattle-6", 32),
        ("splitting", "verlet-8", 20),
    ):
        if form in problem.forms:
            only = dataclasses.replace(problem, field=None)
            found = gi.solve(only, y0, step=time / steps, method=method, **plain).y[-1]
            np.testing.assert_allclose(found, reference, rtol=0, atol=2e-9)
