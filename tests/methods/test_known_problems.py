"""Test problems from the literature, against what is known of them by other means."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.problems import (
    fast_rotor,
    fast_top,
    morse,
    outer_solar_system,
    schwarzschild,
    spring_pendulum,
    toda,
)

HOLE = schwarzschild.problem()
PROBLEMS = {
    "henon-heiles": (henon_heiles.problem(), henon_heiles.CHAOTIC, 20.0),
    "outer-solar-system": (outer_solar_system.problem(), outer_solar_system.initial(), 10_000.0),
    "schwarzschild": (HOLE, schwarzschild.initial(HOLE), 2000.0),
    "spring-pendulum": (spring_pendulum.problem(), spring_pendulum.INITIAL, 1.0),
    "fast-rotor": (fast_rotor.problem(), fast_rotor.INITIAL, 1.0),
    "fast-top": (fast_top.problem(), fast_top.initial(), 2.0),
    "toda": (toda.problem(5), toda.initial(5), 20.0),
    "morse": (morse.problem(), morse.INITIAL, 21.0),
}


def truth(problem: gi.Problem, y0: np.ndarray, end: float) -> np.ndarray:
    """Return the state at the end by SciPy, on the field in plain Python."""
    found = solve_ivp(
        lambda t, y: gi.derivative(problem, y, t),
        (0.0, end),
        y0,
        "DOP853",
        rtol=1e-13,
        atol=1e-13 * np.abs(y0).max() * 1e-3,
    )
    return np.asarray(found.y[:, -1])


def off(problem: gi.Problem, y: np.ndarray, right: np.ndarray) -> float:
    """The largest difference of a piece, relative to its largest row."""
    pieces = problem.slices.values()
    return max(np.abs(y[p] - right[p]).max() / np.abs(right[p]).max() for p in pieces)


FAST = [("schwarzschild", "auto")]


@pytest.mark.parametrize(
    ("name", "method"),
    [
        pytest.param(name, method, marks=[pytest.mark.nightly] * ((name, method) not in FAST))
        for name, (problem, *_) in PROBLEMS.items()
        for method in ("auto", *["verlet-6"] * ("splitting" in problem.forms))
    ],
)
def test_the_tolerance_is_met(name: str, method: str) -> None:
    """By the default method, and by the splitting where there is one; nothing that is kept changes."""
    problem, y0, end = PROBLEMS[name]
    tolerance = 1e-8 if method == "auto" else 1e-6
    sol = gi.solve(problem, y0, t_end=end, method=method, tolerance=tolerance, observe="invariants")
    right = truth(problem, y0, end)
    assert off(problem, sol.y[-1], right) < 4.0 * tolerance
    assert off(problem, y0, right) > 0.1
    for name_, drift in sol.drift.items():
        scale = max(abs(gi.value(problem, name_, y0)), 1e-3 * np.abs(y0).max())
        assert drift.max_abs_error < 10.0 * tolerance * scale, name_


def radial(problem: gi.Problem, y0: np.ndarray) -> tuple[float, float, float]:
    """Return proper time and angle between pericentres of a geodesic, and the sine of its tilt."""
    energy, momentum = (mp.mpf(x) for x in problem.params[:2])
    total = mp.sqrt(mp.mpf(y0[3]) ** 2 + momentum**2)
    # (dr/dτ)² = E² − (1 − 2/r)(1 + ℓ²/r²), with w = 1/r a cubic −: three roots, two turning points
    cubic = [2 * total**2, -(total**2), 2, energy**2 - 1]
    near = np.sort(np.roots(np.array(cubic, dtype=float)).real)

    def square(w: Any) -> Any:
        return ((cubic[0] * w + cubic[1]) * w + cubic[2]) * w + cubic[3]

    low, high, third = (mp.findroot(square, w) for w in near)
    middle, size = (low + high) / 2, (high - low) / 2

    def part(angle: Any, power: int) -> Any:
        w = middle + size * mp.cos(angle)
        return w**-power / mp.sqrt(2 * total**2 * (third - w))

    time = 2 * mp.quad(lambda s: part(s, 2), [0, mp.pi / 2, mp.pi])
    turn = 2 * mp.quad(lambda s: total * part(s, 0), [0, mp.pi / 2, mp.pi])
    return float(time), float(turn), float(mp.mpf(y0[3]) / total)


def test_a_geodesic_precesses_as_relativity_says() -> None:
    """Without a magnetic field: after a radial period it is at the angle of the quadrature."""
    problem = schwarzschild.problem(magnetic=0.0)
    y0 = schwarzschild.initial(problem)
    period, turn, tilt = radial(problem, y0)
    sol = gi.solve(problem, y0, t_end=period, tolerance=1e-12, observe="invariants")
    r, theta, pr, _ = sol.y[-1]
    assert abs(r - y0[0]) < 1e-9
    assert abs(pr) < 1e-10
    assert abs(np.cos(theta) + tilt * np.sin(turn)) < 1e-10
    assert turn > 2.2 * np.pi  # far from an ellipse
    assert set(sol.drift) == {"hamiltonian", "angular-momentum-squared"}
