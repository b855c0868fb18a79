"""What there is to stress: cases of all packages, cells for every method."""

import numpy as np
import pytest

import geomint as gi
from geomint.stress import sweep
from tests.stress.stress_support import AXES, CASES, EVERY, OFFERED, built

LARGE = 8  # larger ones take a second to build


def test_every_case_of_a_package_is_there_and_told_apart():
    assert sorted(map(repr, CASES)) == sorted(repr(c) for make in OFFERED.values() for c in make())
    places = [(c.system, c.representations, c.axis.name, c.text, c.n) for c in EVERY]
    assert len(set(places)) == len(places)


# Cases, runs, dimensions, steps, quick runs, a sum of all values and states.
CONTENT = [1265, 1211, 2653, 26022, 18, 11738.574220653]


def test_every_case_is_built_or_refused():
    """Special states are on their manifolds to rounding: methods would be blamed for it.

    And none is lost, nor another one: what is stressed stays the same as long as nobody means it.
    """
    content = np.zeros(6)
    for c in CASES:
        runs = len(c.representations or ())
        content += [1, runs, c.n, c.steps, len(c.quick), np.arcsinh(c.value)]
    for number, case in enumerate(EVERY):
        if case.n > LARGE:
            continue
        try:
            model = built(number)
        except gi.GeomintError:
            assert (case.axis.name, case.value) == ("edge", 0.0)
            continue
        assert (case.axis.name, case.value) != ("edge", 0.0)
        if number < len(CASES):
            for y in model.states.values():
                content[-1] += np.arcsinh(y) @ np.cos(number + np.arange(len(y)))
        names = set(model.problems)
        assert case.representations is None or set(case.representations) <= names
        assert case.reference is None or case.reference in names
        assert set(case.quick) <= names
        if case.axis.name not in ("rest", "zeros", "steady") or case.n > 0:
            continue
        for name, problem in model.problems.items():
            if "g" not in problem.slices:
                off = [gi.value(problem, f, model.states[name]) for f in problem.constraints]
                assert all(abs(x) <= 1e-13 for x in off), (case.system, case.value, off)
    assert content == pytest.approx(CONTENT, rel=1e-10)


def test_every_method_is_stressed():
    selection = sweep.Selection(tuple(gi.method_names()), quick=True)
    items = sweep.items_of(*sweep.selected(selection, CASES), True)
    assert {item.method for item in items} == set(gi.method_names())


def test_selections():
    cases, methods = sweep.selected(sweep.Selection(("rk-4",), (), ("edge",), quick=True), CASES)
    assert [m.name for m in methods] == ["rk-4"]
    assert {case.axis.name for case in cases} == {"edge"}
    assert all(case.quick for case in cases)


def test_quick_takes_the_ends_of_every_family():
    _, methods = sweep.selected(sweep.Selection(quick=True), CASES)
    names = {m.name for m in methods}
    assert {"gauss-1", "gauss-16", "heun-2", "dop853", "dop853-adaptive"} <= names
    assert len(names) < 0.6 * len(gi.method_names())
    families = {(m.family, m.adaptive) for m in map(gi.find_method, gi.method_names())}
    assert {(m.family, m.adaptive) for m in methods} == families


def test_the_quick_run_has_every_axis():
    items = sweep.items_of(*sweep.selected(sweep.Selection(quick=True), CASES), quick=True)
    assert {item.case.axis.name for item in items} == {axis.name for axis in AXES}


def test_steady_cases_are_steady():
    """Group methods follow them by any step: one of h is two of h/2."""
    steady = [number for number, case in enumerate(EVERY) if case.steady]
    assert len(steady) > 20
    seen = set()
    for case, number in ((EVERY[number], number) for number in steady):
        if case.system in seen or case.n > 4:
            continue
        seen.add(case.system)
        for name, problem in built(number).problems.items():
            if problem.action is None or name not in (case.representations or [name]):
                continue
            y0, ends = built(number).states[name], []
            for steps in (1, 2):
                motion = gi.Integrator(problem, y0, "rkmk-4", step=0.25 / steps, compiled=False)
                motion.step(steps)
                ends.append(motion.state)
            np.testing.assert_allclose(*ends, rtol=0.0, atol=1e-12 * np.abs(y0).max())


def test_rest_is_rest():
    places = [(case.system, case.value) for case in EVERY]
    model = built(places.index(("test:spring-pendulum-p", 0.0)))
    (problem,), (y,) = model.problems.values(), model.states.values()
    assert not y[problem.slices["p"]].any()
    assert y[problem.slices["q"]].any()
