"""A problem of one's own on the axes of states and steps."""

from types import SimpleNamespace

import numpy as np
import pytest

import geomint as gi
from geomint.stress import sweep


@gi.field
def swinging(params, t, y, out, work):
    """A bob on a rod of length 1 in the plane, q and its velocity, in gravity g."""
    g = params[0]
    pull = (y[2] * y[2] + y[3] * y[3] - g * y[1]) / (y[0] * y[0] + y[1] * y[1])
    out[0] = y[2]
    out[1] = y[3]
    out[2] = -pull * y[0]
    out[3] = -g - pull * y[1]


@gi.observable
def energy(params, t, y, work):
    """½(v, v) + g q₂."""
    return 0.5 * (y[2] * y[2] + y[3] * y[3]) + params[0] * y[1]


PENDULUM = gi.Problem(
    "planar-pendulum",
    params=[1.0],
    field=swinging,
    invariants={"energy": energy},
    space=gi.TangentSphere(2, ("q", "v")),
)
Y0 = np.array([0.6, -0.8, 0.4, 0.3])


@pytest.fixture
def own_cases(monkeypatch, tmp_path):
    """Return a function that gives the cases of a problem, which are not run."""
    found = []

    def noted(selection, listener, cases, **more):
        found.append(cases)
        raise KeyboardInterrupt

    def cases_of(problem, y0):
        with monkeypatch.context() as patched:
            patched.setattr(sweep, "run_selection", noted)
            with pytest.raises(KeyboardInterrupt):
                gi.stress_report(problem, tmp_path, y0=y0, progress=False)
        return found[-1]

    return cases_of


def test_the_cases_of_one_problem(own_cases, tmp_path):
    cases = own_cases(PENDULUM, Y0)
    assert {case.axis.name for case in cases} == {"step", "rest", "zeros", "steady"}
    places = {(case.system, case.axis.name, case.value) for case in cases}
    assert len(places) == len(cases)
    assert ("planar-pendulum-v", "rest", 0.0) in places
    for case in cases:
        (problem,), (y,) = case.build().problems.values(), case.build().states.values()
        assert problem is PENDULUM
        np.testing.assert_allclose([y[:2] @ y[:2], y[:2] @ y[2:]], [1.0, 0.0], atol=1e-12)
    with pytest.raises(gi.DomainError, match="expected a unit vector"):
        gi.stress_report(PENDULUM, tmp_path, y0=2.0 * Y0)


def test_they_are_run_in_processes_of_their_own(own_cases):
    told = []
    listener = SimpleNamespace(begin=told.append, cell_done=told.append)
    selection = sweep.Selection(("rk-4",), axes=("step", "rest"), quick=True)
    result = sweep.run_selection(selection, listener, cases=own_cases(PENDULUM, Y0), workers=1)
    assert told == [len(result.cells), *result.cells]
    verdicts = {(cell.axis, cell.value): cell.verdict for cell in result.cells}
    assert verdicts == {("step", 1e-12): "ok", ("step", 1000.0): "unresolved", ("rest", 0.0): "ok"}
    assert {cell.system for cell in result.cells} == {
        "planar-pendulum/own", "planar-pendulum-v/own"
    }  # fmt: skip
