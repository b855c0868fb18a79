"""Functions are asked inside of the run alone: by every method, and by all that looks at a run."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.methods import methods


@gi.field
def swinging(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A spherical pendulum, whose force has no value outside of params[0] … params[1]."""
    known = 0.0 * gi.sqrt((t - params[0]) * (params[1] - t))
    p2 = y[3] * y[3] + y[4] * y[4] + y[5] * y[5]
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = known - (p2 - y[2]) * y[i]
    out[5] = out[5] - 1.0


@gi.field
def gradients(params: Any, t: Any, q: Any, p: Any, dq: Any, dp: Any, work: Any) -> None:
    known = 0.0 * gi.sqrt((t - params[0]) * (params[1] - t))
    for i in range(3):
        dq[i] = known + 0.0 * q[i]
        dp[i] = 1.0 * p[i]
    dq[2] = dq[2] + 1.0


@gi.field
def slope(params: Any, t: Any, q: Any, out: Any, work: Any) -> None:
    for i in range(3):
        out[i] = 0.0 * gi.sqrt((t - params[0]) * (params[1] - t)) + 0.0 * q[0]
    out[2] = out[2] + 1.0


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    known = 0.0 * gi.sqrt((t - params[0]) * (params[1] - t))
    return 0.5 * (y[3] * y[3] + y[4] * y[4] + y[5] * y[5]) + y[2] + known


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    known = 0.0 * gi.sqrt((t - params[0]) * (params[1] - t))
    out[0] = 1.0 + known + 0.1 * y[0]
    out[1] = 0.5 + known + 0.0 * y[0]
    out[2] = gi.cos(t) + known + 0.0 * y[0]


SPACE = gi.TangentSphere(3, ("q", "p"))
SWINGING = [0.6, 0.0, -0.8, 0.2, 0.9, 0.15]


def pendulum(begin: float, end: float) -> gi.Problem:
    return gi.Problem(
        "pendulum",
        space=SPACE,
        params=sorted((begin, end)),
        field=swinging,
        hamiltonian=SPACE.hamiltonian(gradients, separable=True),
        splitting=gi.natural_on_sphere(slope),
        invariants={"energy": energy},
        measure=gi.Measure(),
    )


def problem_of(form: str, begin: float, end: float) -> tuple[gi.Problem, list[float]]:
    if form != "action":
        return pendulum(begin, end), SWINGING
    action = gi.GroupAction(turning, gi.so3(1))
    turned = gi.Problem("turned", (("q", 3),), params=sorted((begin, end)), action=action)
    return turned, [0.6, 0.0, -0.8]


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


NAMES = [*methods(), "gauss-1-suzuki-4", "verlet-suzuki-4"]


@pytest.mark.nojit
@pytest.mark.parametrize("which", range(len(NAMES)), ids=NAMES)
def test_every_method(which: int) -> None:
    """Forwards or backwards, with whole steps or a last shorter one."""
    (begin, end, count), name = SPANS[which % len(SPANS)], NAMES[which]
    problem, y0 = problem_of(gi.find_method(name).needs, begin, end)
    step = abs(end - begin) / count * (1.0 if which % 7 else 0.83)
    sol = gi.solve(problem, y0, t0=begin, t_end=end, method=name, compiled=False, step=step)
    assert np.isfinite(sol.y).all()


KINDS = ("rk-4", "rattle-2", "dop853-adaptive")


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize(("begin", "end", "count"), SPANS[1:5:2])
def test_all_that_looks_at_a_run(name: str, begin: float, end: float, count: int) -> None:
    """Default steps, trials of a tolerance, second runs, events, dense output, quantities, members."""
    problem, y0 = problem_of(gi.find_method(name).needs, begin, end)
    run: dict[str, Any] = {"t0": begin, "t_end": end, "method": name}
    step = abs(end - begin) / count
    known = gi.solve(problem, y0, **run, step=step / 32).y[-1]
    times = np.linspace(begin, end, 7)
    looked = gi.solve(
        problem, y0, **run, step=step, t_eval=times, dense=True, observe=["energy"], events="q[0]",
        estimate_error=True,
    )  # fmt: skip
    assert np.isfinite(looked.error_estimate).all()
    np.testing.assert_array_equal(looked.sol(times), looked.y)
    assert looked.success  # and no quantity that is no number
    whole = gi.solve(problem, y0, **run, step=step)
    for chosen in ({}, {"tolerance": 1e-6}):
        assert np.abs(gi.solve(problem, y0, **run, **chosen).y[-1] - known).max() < 1e-3
    members = gi.solve_ensemble(problem, [y0, y0], **run, step=step)
    np.testing.assert_array_equal(members.final[1], whole.y[-1])


def test_an_integrator() -> None:
    """Up to a time, by whole steps and shorter ones."""
    for begin, end, count in SPANS:
        problem, y0 = problem_of("field", begin, end)
        step = abs(end - begin) / count
        for length in (step, 0.83 * step):
            motion = gi.Integrator(problem, y0, "rk-4", step=length, time=begin)
            motion.propagate_until(end)
            assert motion.time == end


@gi.field
def within(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    outside = gi.select((t - params[0]) * (params[1] - t) < 0.0, math.nan, 0.0)
    out[0] = y[1] + outside
    out[1] = outside - gi.sin(y[0])


def test_steps_with_directions() -> None:
    """By whole steps, in one call and in several, and shorter ones."""
    for begin, end, count in SPANS:
        bounds, y0 = sorted((begin, end)), [0.3, 0.4]
        problem = gi.Problem("within", (("y", 2),), bounds, field=within)
        run: dict[str, Any] = {"t0": begin, "t_end": end, "method": "rk-4"}
        for length in (abs(end - begin) / count, 0.83 * abs(end - begin) / count):
            flow = gi.tangent_flow(problem, y0, **run, step=length)
            known = gi.solve(problem, y0, **run, step=length).y[-1]
            np.testing.assert_allclose(flow.y, known, rtol=0, atol=1e-14)
            growth = gi.lyapunov(problem, y0, **run, step=length, count=1)
            np.testing.assert_allclose(growth.y, known, rtol=0, atol=1e-14)
            motion = gi.Integrator(problem, y0, "rk-4", step=length, time=begin, tangents=1)
            motion.propagate_until(end)
            np.testing.assert_allclose(motion.tangents, flow.slopes[:, :1], rtol=0, atol=1e-12)


def test_nothing_of_a_state_knows() -> None:
    """Where nothing depends on time, the run is that of an integrator without an end, to the bit."""
    problem = gi.Problem("free", (("y", 6),), field=still)
    for begin, end, count in SPANS:
        step = (end - begin) / count
        sol = gi.solve(problem, SWINGING, t0=begin, t_end=end, step=abs(step), method="rk-4")
        motion = gi.Integrator(problem, SWINGING, "rk-4", step=abs(sol.step), time=begin)
        motion.h = math.copysign(motion.h, step)
        motion.step(count)
        np.testing.assert_array_equal(sol.y[-1], motion.state)


@gi.field
def still(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(6):
        out[i] = -y[(i + 3) % 6]
