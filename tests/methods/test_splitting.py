"""Splittings: flows of parts, great circles, what they keep for long, and what must fail."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from mpmath import mp

import geomint as gi
from geomint.kernels.groups.great_circle import SMALL
from geomint.kernels.numbers.blocks import Block
from geomint.problems.testproblems import neumann
from tests.problems import abc_flow, lotka_volterra, spherical_pendulum

EPSILON = 2.0**-52


def extended(values: object) -> Block:
    return Block(np.array([mp.mpf(float(v)) for v in np.ravel(values)], dtype=object))


def circled(h: float, y: np.ndarray, number: type = float) -> np.ndarray:
    """The increment of a great circle, in float64 or in mpmath numbers."""
    if number is float:
        out = Block(np.zeros(len(y)))
        gi.great_circle(np.float64(h), Block(y), out)
    else:
        out = extended(np.zeros(len(y)))
        gi.great_circle(mp.mpf(h), extended(y), out)
    return out.data


# --- coefficients and great circles ---------------------------------------------------------------


@pytest.mark.nojit
def test_turn_coefficients() -> None:
    """Within two roundings at any angle, on both sides of the change of formula; hyperbolic below 0."""
    inside = np.array([-SMALL, -1e-3, 0.0, 1e-300, 1e-16, 1e-3, np.nextafter(SMALL, 0)])
    for s in [*inside, SMALL, 0.3, 1.0, 9.8, 1e3, 1e6]:
        a, b = gi.turn_coefficients(np.float64(s))
        with mp.workdps(50):
            theta = mp.sqrt(mp.mpf(float(s)))
            sinc = mp.re(mp.sinc(theta))
            versine = mp.re(mp.sinc(theta / 2) ** 2) / 2
            scale = 1.0 if s < 10 else math.sqrt(s)  # large angles are rounded before their sine
            assert abs(a - sinc) <= 2 * EPSILON * scale * max(1, abs(sinc))
            assert abs(b - versine) <= 2 * EPSILON * scale * versine + EPSILON / max(1.0, s)


@pytest.mark.nojit
@pytest.mark.parametrize("n", [2, 3, 6])
@pytest.mark.parametrize("angle", [1e-160, 1e-9, 0.01, 0.49, 0.51, 3.14159, 40.0])
def test_great_circles_are_exact(n: int, angle: float) -> None:
    """To relative accuracy of each increment's size, for any speed."""
    y = neumann.initial(n)
    for speed in (1e-100, 1.0, 1e100):
        z = y.copy()
        z[n:] *= speed / np.linalg.norm(y[n:])
        found = circled(angle / speed, z)
        with mp.workdps(60):
            q, p = extended(z[:n]).data, extended(z[n:]).data
            q = q / mp.sqrt(sum(q * q))
            p = p - sum(p * q) * q
            size = mp.sqrt(sum(p * p))
            theta = mp.mpf(angle / speed) * size
            dq = (mp.cos(theta) - 1) * q + mp.sin(theta) * p / size
            dp = (mp.cos(theta) - 1) * p - mp.sin(theta) * q * size
        # A state is on the manifold to rounding only: what the flow puts right is part of it.
        tolerance = 4 * EPSILON * max(1.0, angle)
        np.testing.assert_allclose(found[:n], dq.astype(float), rtol=0, atol=tolerance)
        np.testing.assert_allclose(
            found[n:] / speed, (dp / speed).astype(float), rtol=0, atol=tolerance
        )


@pytest.mark.nojit
def test_great_circles_return_to_the_sphere() -> None:
    """Defects of 1e-9 of |q| and of (q, p) are gone after one flow, to their square."""
    y = neumann.initial(4)
    y[:4] *= 1.0 + 1e-9
    y[4:] += 3e-9 * y[:4]
    z = y + circled(0.3, y)
    assert abs(z[:4] @ z[:4] - 1.0) < 1e-15
    assert abs(z[:4] @ z[4:]) < 1e-15


def test_nothing_drifts_on_a_free_orbit() -> None:
    """10⁶ equal rotations: the same rounding of a coefficient in all of them would be seen."""
    problem = spherical_pendulum.problem(0.0)
    for h in (0.02, 0.3):
        sol = gi.solve(
            problem,
            spherical_pendulum.INITIAL,
            t_end=h * 10**6,
            step=h,
            method="verlet-2",
            observe=["energy", "angular-momentum", "norm", "tangency"],
        )
        for drift in sol.drift.values():
            assert drift.drift_class in ("roundoff", "bounded", "sqrt", "undetermined"), drift
            assert abs(drift.slope) <= 5 * drift.slope_stderr, drift
            assert drift.max_abs_error < 4e-14
        for name in ("norm", "tangency"):
            assert sol.drift[name].max_abs_error <= 8 * EPSILON


@pytest.mark.parametrize(("name", "h"), [("verlet-2", 0.02), ("verlet-4", 0.1)])
def test_verlet_keeps_the_sphere(name: str, h: float) -> None:
    """Constraints to a few roundings over 10⁵ steps; the energy and all F_k are bounded."""
    for problem, y0 in (
        (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
        (neumann.problem((0.5, 0.9, 1.4, 2.0, 2.7)), neumann.initial(5)),
    ):
        names = [*problem.invariants, *problem.constraints]
        sol = gi.solve(problem, y0, t_end=h * 10**5, step=h, method=name, observe=names)
        for quantity in problem.constraints:
            assert sol.drift[quantity].max_abs_error <= 8 * EPSILON, sol.drift[quantity]
        for quantity in problem.invariants:
            drift = sol.drift[quantity]
            if quantity == "angular-momentum":  # kicks and great circles keep it
                assert drift.drift_class in ("roundoff", "sqrt", "bounded", "undetermined")
                assert drift.max_abs_error < EPSILON * 10**2.5
            else:
                assert drift.drift_class == "bounded", drift
                assert drift.max_abs_error < 1e-3


@pytest.mark.nightly
def test_the_sphere_for_ten_million_steps() -> None:
    """No slope of |q|² − 1 or (q, p), nor of the angular momentum."""
    sol = gi.solve(
        spherical_pendulum.problem(),
        spherical_pendulum.INITIAL,
        t_end=2e5,
        step=0.02,
        method="verlet-2",
        observe=["norm", "tangency", "angular-momentum"],
        observe_every=7,
    )
    assert sol.steps == 10**7
    for drift in sol.drift.values():
        assert abs(drift.slope) <= 5 * drift.slope_stderr, drift
        assert drift.max_abs_error < 1e-14


# --- the form -------------------------------------------------------------------------------------


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("problem", "y"),
    [
        (abc_flow.problem(), abc_flow.INITIAL),
        (neumann.problem(season=0.4), neumann.initial()),
        (spherical_pendulum.problem(), spherical_pendulum.INITIAL),
    ],
)
def test_parts_sum_to_the_field(problem: gi.Problem, y: np.ndarray) -> None:
    """Also where the splitting is the only form."""
    only = dataclasses.replace(problem, field=None, hamiltonian=None)
    for t in (0.0, 0.7):
        np.testing.assert_allclose(
            gi.derivative(only, y, t), gi.derivative(problem, y, t), atol=1e-6
        )


@pytest.mark.nojit
def test_part_by_part() -> None:
    """One step is the parts' half flows, the last whole flow, and back, at the middle time."""
    problem, y0, h = abc_flow.problem(), abc_flow.INITIAL, 0.37
    y = y0.copy()
    for k, size in ((0, h / 2), (1, h / 2), (2, h), (1, h / 2), (0, h / 2)):
        out = Block(np.zeros(3))
        problem.splitting.flow(
            k, Block(problem.params), h / 2, size, Block(y), out, Block(np.zeros(0))
        )
        y = y + out.data
    sol = gi.solve(problem, y0, t_end=h, step=h, method="verlet-2", compiled=False)
    np.testing.assert_allclose(sol.y[-1], y, rtol=0, atol=4 * EPSILON)
    assert sol.evaluations == 5


def test_explicit_for_two_parts() -> None:
    """Störmer–Verlet of the pendulum is kick, great circle, kick."""
    problem, y0, h = spherical_pendulum.problem(), spherical_pendulum.INITIAL, 0.1
    e3 = np.array([0.0, 0.0, 1.0])
    q, p = y0[:3], y0[3:]
    p = p - h / 2 * (e3 - q * q[2])
    speed = np.linalg.norm(p)
    q, p = (
        q * np.cos(h * speed) + p / speed * np.sin(h * speed),
        p * np.cos(h * speed) - q * speed * np.sin(h * speed),
    )
    p = p - h / 2 * (e3 - q * q[2])
    found = gi.solve(problem, y0, t_end=h, step=h, method="verlet-2").y[-1]
    np.testing.assert_allclose(found, np.concatenate([q, p]), rtol=0, atol=1e-15)


@gi.observable
def seconds(params, t, y, work):
    return 1.0 + 0.3 * y[0] * y[0] + 0.1 * gi.cos(t)


def test_a_clock_has_the_order_of_the_method() -> None:
    """Physical time beside τ, two-sided, for the base and a composition."""
    base = neumann.problem(season=0.4)
    problem = dataclasses.replace(base, time="tau", clock=seconds)
    y0 = neumann.initial()
    exact = gi.solve(problem, y0, tau_end=2.0, step=0.01, method="gauss-8", save_every=200).t[-1]
    for name, order, counts in (("verlet-2", 2, (40, 80)), ("verlet-4", 4, (10, 20))):
        errors = []
        for n in counts:
            sol = gi.solve(problem, y0, tau_end=2.0, step=2.0 / n, method=name, save_every=n)
            errors.append(abs(sol.t[-1] - exact))
        assert exact > 2.0
        if errors[0] == 0.0:
            pytest.fail("no clock")
        assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2), (name, errors)


# --- failures -------------------------------------------------------------------------------------


@gi.helper
def collapsing(k, params, t, h, y, out, work):
    out[0] = h * gi.sqrt(y[0]) * (0.0 if k == 0 else -1.0)
    out[1] = h * 1.0 if k == 0 else 0.0 * h


@pytest.mark.nojit
@pytest.mark.parametrize("method", ["verlet-2", "verlet-4"])
def test_a_flow_that_ends(method: str) -> None:
    """A NaN in one part is a typed error at the right step, never a result."""
    problem = gi.Problem("ending", (("y", 2),), splitting=gi.Splitting(collapsing, 2))
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, [1.0, 0.0], t_end=9.0, step=0.1, method=method, save_every=1)
    assert 1.0 < caught.value.t < 4.0
    assert np.isfinite(caught.value.partial.y).all()


@pytest.mark.nojit
def test_the_wrong_form() -> None:
    """The message names methods that fit."""
    problem = dataclasses.replace(abc_flow.problem(), field=None)
    with pytest.raises(gi.FormError, match=r"verlet-8, verlet-4, verlet-2 \(form 'splitting'\)"):
        gi.solve(problem, abc_flow.INITIAL, t_end=1.0, method="rk-4")
    with pytest.raises(gi.FormError, match="needs the form 'splitting'"):
        gi.solve(lotka_volterra.problem(), lotka_volterra.INITIAL, t_end=1.0, method="verlet-2")


@pytest.mark.nojit
def test_uhlenbeck_integrals() -> None:
    """Σ F_k = (q, q) and ½ Σ a_k F_k = H on T*S^(n−1)."""
    problem, y = neumann.problem((0.5, 1.3, 2.6, 0.9)), neumann.initial(4)
    found = [gi.value(problem, problem.invariants[f"F{k}"], y) for k in (1, 2, 3, 4)]
    assert sum(found) == pytest.approx(1.0, abs=1e-14)
    energy = gi.value(problem, problem.invariants["energy"], y)
    assert 0.5 * problem.params[1:] @ found == pytest.approx(energy, abs=1e-14)
