"""Functions are asked inside of the run alone: by every method, and by all that looks at a run."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.run.motions import SWINGING, TURNING, pushed, second


def inside(p: Any, t: Any) -> Any:
    """0, but no number outside of p[0] … p[1]."""
    return 0.0 * gi.sqrt((t - p[0]) * (p[1] - t))


def problem_of(form: str, begin: float, end: float) -> tuple[gi.Problem, list[float]]:
    bounds = sorted((begin, end))
    if form == "action":
        return pushed("body", inside, *bounds), TURNING
    return pushed("sphere", inside, *bounds, kept=True, measure=gi.Measure()), SWINGING


def spans() -> list[tuple[float, float, int]]:
    """Beginnings, ends and numbers of steps whose last sum rounds to more than the end."""
    rng, found = np.random.default_rng(1), list[tuple[float, float, int]]()
    for sign, count in itertools.product((1.0, -1.0), (2, 3)):
        while True:
            begin = float(rng.uniform(-0.2, 0.2))
            end = begin + sign * float(rng.uniform(0.3, 0.5))
            h = (end - begin) / count
            if sign * ((begin + (count - 1) * h) + h) > sign * end:
                found.append((begin, end, count))
                break
    return [*found, (0.0, 0.3, 3), (100.1, 100.7, 3)]


SPANS = spans()
NAMES = [*gi.method_names(), "gauss-1-suzuki-4", "verlet-suzuki-4"]
EACH = {
    "rk-4",
    "dop853",
    "heun-2",
    "gauss-1",
    "gauss-8",
    "gauss-11",
    "gauss-1-suzuki-4",
    "verlet-4",
}
EACH |= {"lobatto-3", "lobatto-8", "rattle-2", "rattle-4", "verlet-2", "cf-4", "cg-3", "rkmk-4"}
EACH |= {"rkmk-cayley-4", "dormand-prince-5-adaptive", "rkmk-dormand-prince-5-adaptive"}


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("which", "name"),
    [pytest.param(*x, marks=[pytest.mark.nightly] * (x[1] not in EACH)) for x in enumerate(NAMES)],
)
def test_every_method(which: int, name: str) -> None:
    """Forwards or backwards, with whole steps or a last shorter one."""
    begin, end, count = SPANS[which % len(SPANS)]
    problem, y0 = problem_of(gi.find_method(name).needs, begin, end)
    step = abs(end - begin) / count * (1.0 if which % 7 else 0.83)
    sol = gi.solve(problem, y0, t0=begin, t_end=end, method=name, compiled=False, step=step)
    assert np.isfinite(sol.y).all()


@pytest.mark.parametrize("name", ["rk-4", "rattle-2", "dop853-adaptive"])
def test_all_that_looks_at_a_run(name: str) -> None:
    """Default steps, trials of a tolerance, second runs, events, dense output, quantities, members."""
    for begin, end, count in SPANS[1:5:2]:
        problem, y0 = problem_of("field", begin, end)
        run: dict[str, Any] = {"t0": begin, "t_end": end, "method": name}
        step = abs(end - begin) / count
        known = gi.solve(problem, y0, **run, step=step / 32).y[-1]
        asked: dict[str, Any] = {"t_eval": np.linspace(begin, end, 7), "dense": True}
        asked |= {"observe": ["energy"], "events": "q[0]", "estimate_error": True}
        looked = gi.solve(problem, y0, **run, step=step, **asked)
        assert np.isfinite(looked.error_estimate).all()
        np.testing.assert_array_equal(looked.sol(asked["t_eval"]), looked.y)
        assert looked.success  # and no quantity that is no number
        whole = gi.solve(problem, y0, **run, step=step)
        for chosen in ({}, {"tolerance": 1e-6}):
            assert np.abs(gi.solve(problem, y0, **run, **chosen).y[-1] - known).max() < 1e-3
        if name == "rk-4":
            members = gi.solve_ensemble(problem, [y0, y0], **run, step=step)
            np.testing.assert_array_equal(members.final[1], whole.y[-1])


def within(p: Any, t: Any, y: Any) -> Any:
    return gi.select((t - p[0]) * (p[1] - t) < 0.0, math.nan, -gi.sin(y[0]))


WITHIN = second("within", within, -1.0, 1.0)


def test_steps_of_integrators_and_with_directions() -> None:
    """By whole steps, in one call and in several, and shorter ones."""
    for (begin, end, count), part in itertools.product(SPANS, (1.0, 0.83)):
        bounds, y0 = sorted((begin, end)), [0.3, 0.4]
        problem = gi.Problem("within", WITHIN.pieces, bounds, field=WITHIN.field)
        step = part * abs(end - begin) / count
        run: dict[str, Any] = {"t0": begin, "t_end": end, "method": "rk-4", "step": step}
        flow, known = gi.tangent_flow(problem, y0, **run), gi.solve(problem, y0, **run).y[-1]
        np.testing.assert_allclose(flow.y, known, rtol=0, atol=1e-14)
        growth = gi.lyapunov(problem, y0, **run, count=1)
        np.testing.assert_allclose(growth.y, known, rtol=0, atol=1e-14)
        for tangents in (None, 1):
            motion = gi.Integrator(problem, y0, "rk-4", step=step, time=begin, tangents=tangents)
            motion.propagate_until(end)
            assert motion.time == end
            np.testing.assert_allclose(motion.state, known, rtol=0, atol=1e-14)
        np.testing.assert_allclose(motion.tangents, flow.slopes[:, :1], rtol=0, atol=1e-12)
