"""Planes of sections, and the boundary that the energy sets."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.problems import lotka_volterra

CONTROL, LOTKA = henon_heiles.problem(), lotka_volterra.problem()
SCENE = gi.load_scene("sphere-n3")
SPHERE, Y0 = SCENE.problem, SCENE.state


def section_of(problem: gi.Problem, what: str, level: float, states: Any = ()) -> gi.Section:
    """Return the section that has these points."""
    y = np.array(states, float).reshape(-1, problem.rows)
    times, event = np.zeros(len(y)), gi.Event(what, level=level)
    at = {"event": event, "name": what, "status": "success", "step": 1.0, "steps": 1}
    rows = {"tau": times, "t": times, "y": y, "directions": times, "motions": times.astype(int)}
    return gi.Section(problem=problem, method=gi.Gauss(8), **at, **rows)


@pytest.mark.parametrize(
    ("problem", "what", "level"),
    [
        *((CONTROL, "q[0]", 0.0), (CONTROL, "q[1]", 0.1), (CONTROL, "p[0]", 0.2)),
        *((SPHERE, f"gamma[{i}]", level) for i, level in ((0, 0.0), (1, -0.3), (2, 0.999))),
    ],
)
def test_coordinates(problem: gi.Problem, what: str, level: float) -> None:
    """States of given coordinates have them, lie on the surface and are admissible; w is free."""
    plane: Any = section_of(problem, what, level).plane
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-3.0, 3.0, 50), rng.normal(size=50)
    one, other = plane.states(x, y, 0.7), plane.states(x, y, -2.0)
    row = problem.slices[what[:-3]].start + int(what[-2])
    for states in (one, other):
        np.testing.assert_allclose(plane.coordinates(states), (x, y), rtol=0, atol=1e-13)
        np.testing.assert_allclose(states[:, row], level, rtol=0, atol=1e-15)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for state in states:
                np.testing.assert_allclose(problem.canonical(state), state, rtol=0, atol=1e-14)
    assert (np.abs(one - other).max(axis=1) > 1.0).all()
    if problem is SPHERE:  # the second one is (γ × p)_i; the first turns from e_(i+1) to e_(i+2)
        axis, radius = row, np.sqrt(1.0 - level * level)
        state = plane.states(np.array([0.0, 0.5 * np.pi]), np.array([1.5, -0.5]), 0.3)
        turned = np.cross(state[:, :3], state[:, 3:])[:, axis]
        np.testing.assert_allclose(turned, [1.5, -0.5], rtol=0, atol=1e-14)
        assert state[0, (axis + 1) % 3] == pytest.approx(radius)
        assert state[1, (axis + 2) % 3] == pytest.approx(radius)


def test_no_plane() -> None:
    for problem, what, level in (
        *((SPHERE, "p[0]", 0.0), (SPHERE, "gamma[0]", 1.0), (SPHERE, "gamma[0]", -2.0)),
        *((SPHERE, "energy", 1.0), (LOTKA, f"{next(iter(LOTKA.slices))}[0]", 1.0)),
        (gi.load_scene("sphere-n5").problem, "gamma[0]", 0.0),
    ):
        assert section_of(problem, what, level).plane is None


def test_boundary_of_henon_and_heiles() -> None:
    """½ p₂² + ½ q₂² − q₂³/3 on q₁ = 0, whose line at energy 1/8 is closed and within the grid."""
    y0 = [0.0, 0.1, np.sqrt(2.0 * (0.125 - 0.005 + 1e-3 / 3.0)), 0.0]
    section: Any = section_of(CONTROL, "q[0]", 0.0, [y0])
    found, (panel,) = section.boundary, section.plot().axes
    ends = np.array([np.sort(np.roots([-1.0 / 3.0, 0.5, 0.0, -0.125]))[:2], [-0.5, 0.5]])
    limits = ends + 0.06 * np.diff(ends) * [-1.0, 1.0]
    np.testing.assert_allclose([panel.get_xlim(), panel.get_ylim()], limits, atol=0.01)
    assert found.energy == pytest.approx(0.125, rel=1e-14)
    q, p = np.meshgrid(found.x, found.y)
    exact = 0.5 * p**2 + 0.5 * q**2 - q**3 / 3.0
    np.testing.assert_allclose(found.least, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
    edge = np.concatenate([found.least[0], found.least[-1], found.least[:, 0]])
    assert (edge > 0.125).all()


def test_no_boundary() -> None:
    """Of different energies; of one that is no parabola in what is free; of no motion."""
    several = [[0.0, 0.1, 0.2, 0.0], [0.0, 0.1, 0.3, 0.0]]
    for what, states in (("q[0]", several), ("p[1]", [[0.1, 0.1, 0.1, 0.0]]), ("q[0]", [])):
        section = section_of(CONTROL, what, 0.0, states)
        assert section.plane is not None
        assert section.boundary is None


@pytest.mark.usefixtures("short_chains")
def test_points_lie_within() -> None:
    """Where the least energy is more than that of the motions there are no points."""
    states = [Y0, *gi.draw_states(SPHERE, 2, at=Y0, seed=2)]
    found = gi.poincare_section(SPHERE, states, gi.Event("gamma[2]", "up"), 40, step=0.5)
    for x, y in zip(*found.coordinates(), strict=True):
        i, j = np.searchsorted(found.boundary.x, x), np.searchsorted(found.boundary.y, y)
        cell = found.boundary.least[max(j - 1, 0) : j + 1, max(i - 1, 0) : i + 1]
        assert cell.min() < found.boundary.energy
