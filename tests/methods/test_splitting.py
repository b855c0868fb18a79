"""Splittings: flows of parts, great circles, what they keep for long, and what must fail."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from mpmath import mp

import geomint as gi
from geomint.problems.testproblems import neumann
from tests.methods.textbook import rows
from tests.problems import abc_flow, lotka_volterra, spherical_pendulum

EPSILON = 2.0**-52


def circled(h: float, y: np.ndarray) -> np.ndarray:
    """The increment of a great circle."""
    out = rows(np.zeros(len(y)))
    gi.great_circle(np.float64(h), rows(y), out)
    return np.asarray(out)


# --- coefficients and great circles ---------------------------------------------------------------


@pytest.mark.nojit
def test_turn_coefficients() -> None:
    """Within two roundings at any angle, on both sides of a change of formula; hyperbolic below 0."""
    small = np.array([0.0, 1e-300, 1e-16, 1e-3, *np.geomspace(1e-2, 1.0, 60)])
    for s in [-1e-2, -1e-3, *small, 9.8, 1e3, 1e6]:
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
            q, p = (np.array([mp.mpf(x) for x in part], dtype=object) for part in (z[:n], z[n:]))
            q = q / mp.sqrt(sum(q * q))
            p = p - sum(p * q) * q
            size = mp.sqrt(sum(p * p))
            theta = mp.mpf(angle / speed) * size
            dq = (mp.cos(theta) - 1) * q + mp.sin(theta) * p / size
            dp = (mp.cos(theta) - 1) * p - mp.sin(theta) * q * size
        # A state is on the manifold to rounding only: what the flow puts right is part of it.
        exact = np.concatenate([dq, dp / speed]).astype(float)
        relative = np.concatenate([found[:n], found[n:] / speed])
        np.testing.assert_allclose(relative, exact, rtol=0, atol=4 * EPSILON * max(1.0, angle))


@pytest.mark.nojit
def test_great_circles_return_to_the_sphere() -> None:
    """Defects of 1e-9 of |q| and of (q, p) are gone after one flow, to their square."""
    y = neumann.initial(4)
    y[:4] *= 1.0 + 1e-9
    y[4:] += 3e-9 * y[:4]
    z = y + circled(0.3, y)
    assert abs(z[:4] @ z[:4] - 1.0) < 1e-15
    assert abs(z[:4] @ z[4:]) < 1e-15


@pytest.mark.parametrize("h", [0.3, pytest.param(0.02, marks=pytest.mark.nightly)])
def test_nothing_drifts_on_a_free_orbit(h: float) -> None:
    """10⁶ equal rotations: the same rounding of a coefficient in all of them would be seen."""
    asked = {
        "step": h,
        "method": "verlet-2",
        "observe": ["energy", "angular-momentum", "constraints"],
    }
    sol = gi.solve(
        spherical_pendulum.problem(0.0), spherical_pendulum.INITIAL, t_end=h * 10**6, **asked
    )
    for name, drift in sol.drift.items():
        assert drift.drift_class in ("roundoff", "bounded", "sqrt", "undetermined"), drift
        assert abs(drift.slope) <= 5 * drift.slope_stderr, drift
        limit = 8 * EPSILON if name in ("norm", "tangency") else 4e-14
        assert drift.max_abs_error < limit


@gi.observable
def seconds(params, t, y, work):
    return 1.0 + 0.3 * y[0] * y[0] + 0.1 * gi.cos(t)


def test_a_clock_has_the_order_of_the_method() -> None:
    """Physical time beside τ, two-sided, for the base and a composition."""
    base = neumann.problem(season=0.4)
    problem = dataclasses.replace(base, time="tau", clock=seconds)
    run = {"tau_end": 2.0, "compiled": False}
    exact = gi.solve(problem, neumann.initial(), step=0.25, method="gauss-8", **run).t[-1]
    assert exact > 2.0
    for name, order, counts in (("verlet-2", 2, (40, 80)), ("verlet-4", 4, (10, 20))):
        late = [
            abs(
                gi.solve(problem, neumann.initial(), step=2.0 / n, method=name, **run).t[-1] - exact
            )
            for n in counts
        ]
        assert late[0] > 0.0
        assert math.log2(late[0] / late[1]) == pytest.approx(order, abs=0.2), (name, late)


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
        gi.solve(problem, [1.0, 0.0], t_end=9.0, step=0.1, method=method, compiled=False)
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
