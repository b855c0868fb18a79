"""Steps are those of the textbook, and orders are what methods say.

Tableaux are verified exactly elsewhere: a method that takes the steps of its tableau has its order.
It is measured all the same, on problems that leave it no excuse: nonlinear, depending on time and
state, on generators that do not commute. The error of three runs must lie well above rounding and
fall with the declared power of the step, to ±0.2 on both sides between any two neighbours: a method
that is better than it says is as wrong as one that is worse.
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import neumann, pulsating_body, sphere_metric
from geomint.tableaux import COMPOSITIONS
from tests.methods.textbook import step
from tests.problems import (
    abc_flow,
    double_pendulum,
    frame_in_field,
    lotka_volterra,
    so_n_flow,
    spherical_pendulum,
)

T_END = 2.0
COMPOSED = [f"gauss-1-{name}" for name, scheme in COMPOSITIONS.items() if scheme.base_order == 2]
COMPOSED += ["rattle-kahan-li-6", "verlet-yoshida-6", "gauss-2-suzuki-6", "gauss-2-yoshida-6"]
COMPOSED += ["gauss-3-triple-jump-8", "verlet-4-suzuki-6", "rattle-4-suzuki-6"]
NAMES = [n for n in (*gi.method_names(), *COMPOSED) if not gi.find_method(n).adaptive]
EACH = {"rk-4", "cf-4", "rkmk-4", "rkmk-cayley-4", "gauss-2", "rattle-2", "lobatto-3", "verlet-2"}
EACH |= {"verlet-4"}  # one method of each kind

ORDERS = {"rk-4", "rkmk-4", "gauss-2"}

# Steps of the three runs, by order: errors between 1e-14 and 1e-2.
COUNTS = {
    1: (256, 512, 1024),
    2: (128, 256, 512),
    3: (128, 256, 512),
    4: (64, 128, 256),
    5: (64, 91, 128),
    6: (23, 32, 45),
    8: (8, 11, 16),
}
LATE = {"gauss-1-sofroniou-spaletta-8": (11, 13, 16)}  # the asymptotics begin later
PLATEAU = 5e-15


def each(names: list[str], fast: set[str] = EACH) -> pytest.MarkDecorator:
    """Methods; those that are not `fast` at night."""
    late = pytest.mark.nightly
    return pytest.mark.parametrize(
        "name", [pytest.param(n, marks=[late] * (n not in fast)) for n in names]
    )


@cache
def cases(form: str) -> list[tuple[gi.Problem, np.ndarray]]:
    """Return the problems of a form; the first one with few constraints, for compositions."""
    metric, frame = sphere_metric.problem(), frame_in_field.problem()
    return {
        "field": [(lotka_volterra.problem(), lotka_volterra.INITIAL)],
        "action": [
            (pulsating_body.problem(), pulsating_body.INITIAL),
            (so_n_flow.problem(4), so_n_flow.initial(4)),
            (so_n_flow.problem(3, frame=True), so_n_flow.initial(3, frame=True)),
        ],
        "hamiltonian": [
            (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
            (metric, sphere_metric.initial(metric)),
            (double_pendulum.problem(), double_pendulum.INITIAL),
            (frame, frame_in_field.initial(frame)),
        ],
        "splitting": [
            (abc_flow.problem(), abc_flow.INITIAL),
            (neumann.problem(season=0.4), neumann.initial()),
        ],
    }[form]


LONG = [n for n in NAMES if isinstance(gi.find_method(n), gi.Compose)]


def stepped() -> list[Any]:
    """All methods on the first problem of their form, on the others those with other steps."""
    found = []
    few = {"rattle-4", "gauss-1-suzuki-4", "gauss-2-yoshida-6", "verlet-yoshida-6"}
    late = {"lobatto-5", "lobatto-6", "lobatto-7", *LONG} - few
    for name in NAMES:
        for index in range(len(cases(gi.find_method(name).needs)) if name not in LONG else 1):
            fast = name not in late if index == 0 else name in EACH - {"lobatto-3"}
            found.append(pytest.param(name, index, marks=[pytest.mark.nightly] * (not fast)))
    return found


@pytest.mark.parametrize(("name", "index"), stepped())
def test_steps_are_those_of_the_textbook(name: str, index: int) -> None:
    """Two of them, to a few roundings: the first, and one that knows the one before."""
    method, t, h = gi.find_method(name), 0.3, 0.1
    problem, y0 = cases(method.needs)[index]
    motion = gi.Integrator(problem, y0, method, step=h, time=t, compiled=False)
    motion.step(2)
    y = step(method, problem, t + h, step(method, problem, t, y0, h), h)
    np.testing.assert_allclose(motion.state, y, rtol=0, atol=6e-15)
    assert np.max(np.abs(y - y0)) > 0.05


@cache
def reference(form: str, index: int) -> np.ndarray:
    """The end of a run of a method of order 32 at a small step, on the ODE form."""
    problem, y0 = cases(form)[index]
    run = {"method": "gauss-16", "step": T_END / 8, "compiled": False}
    return gi.solve(problem, y0, t_end=T_END, **run).y[-1]


def errors_of(
    method: gi.Method, problem: gi.Problem, y0: Any, counts: tuple[int, ...], exact: np.ndarray
) -> list[float]:
    """The errors of runs of so many steps."""
    ends = [gi.solve(problem, y0, t_end=T_END, step=T_END / n, method=method).y[-1] for n in counts]
    return [float(np.max(np.abs(end - exact))) for end in ends]


def slopes(counts: tuple[int, ...], errors: list[float]) -> list[float]:
    """The measured orders between neighbouring runs."""
    runs = pairwise(zip(counts, errors, strict=True))
    return [float(np.log(e / f) / np.log(n / m)) for (m, e), (n, f) in runs]


def measured() -> list[Any]:
    """Methods of order up to 8 on all problems of their form; one of each kind on one, fast."""
    found = []
    for name in (n for n in NAMES if gi.find_method(n).order <= 8):
        # One problem has terms of order 5 so small that dormand-prince-5 shows 5.4, to 1e-13.
        form = "action" if name == "dormand-prince-5" else gi.find_method(name).needs
        first = 2 if form == "hamiltonian" else 0
        for index in range(len(cases(form)[:2] if form == "action" else cases(form))):
            late = [pytest.mark.nightly] * (name not in ORDERS or index != first)
            found.append(pytest.param(name, form, index, marks=late))
    return found


@pytest.mark.parametrize(("name", "form", "index"), measured())
def test_order(name: str, form: str, index: int) -> None:
    """In float64."""
    method = gi.find_method(name)
    counts = LATE.get(name, COUNTS[method.order])
    errors = errors_of(method, *cases(form)[index], counts, reference(form, index))
    assert PLATEAU < errors[-1] <= errors[0] < 0.1, errors
    found = slopes(counts, errors)
    assert found == pytest.approx([method.order] * 2, abs=0.2), found


@each([n for n in NAMES if gi.find_method(n).order <= 6], {"rattle-2"})
def test_order_from_rest(name: str) -> None:
    """Where all that moves in the first step is a piece that was exactly 0."""
    method = gi.find_method(name)
    if method.needs == "action":
        problem, y0 = pulsating_body.problem(), pulsating_body.INITIAL * [0, 0, 0, 1, 1, 1]
    else:
        problem, y0 = neumann.problem(season=0.4), neumann.initial() * [1, 1, 1, 0, 0, 0]
    exact = gi.solve(problem, y0, t_end=T_END, step=T_END / 100, method="dop853", compiled=False)
    counts = COUNTS[method.order]
    errors = errors_of(method, problem, y0, counts, exact.y[-1])
    assert errors[0] < 0.1
    if errors[-1] > 20 * PLATEAU:
        found = slopes(counts, errors)
        assert min(found) > method.order - 0.4, (name, found, errors)
