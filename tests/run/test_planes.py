"""Planes of sections, and the boundary that the energy sets; states on a level of the energy."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.level import states_on_level
from geomint.run.plane import boundary, plane_of
from tests.problems import lotka_volterra

CONTROL = henon_heiles.problem()
SPHERE = gi.load_scene("sphere-n3").problem
CASES = [
    (CONTROL, "q[0]", 0.0), (CONTROL, "q[1]", 0.1), (SPHERE, "gamma[0]", 0.0),
    (SPHERE, "gamma[1]", -0.3), (SPHERE, "gamma[2]", 0.999),
]  # fmt: skip


@pytest.mark.parametrize(("problem", "what", "level"), CASES)
def test_coordinates(problem: gi.Problem, what: str, level: float) -> None:
    """States of given coordinates have them, lie on the surface and are admissible; w is free."""
    plane = plane_of(problem, gi.Event(what, level=level))
    assert plane is not None
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-3.0, 3.0, 50), rng.normal(size=50)
    one, other = plane.states(x, y, 0.7), plane.states(x, y, -2.0)
    for states in (one, other):
        np.testing.assert_allclose(plane.coordinates(states), (x, y), rtol=0, atol=1e-13)
        row = problem.slices[what[:-3]].start + int(what[-2])
        np.testing.assert_allclose(states[:, row], level, rtol=0, atol=1e-15)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for state in states:
                np.testing.assert_allclose(problem.canonical(state), state, rtol=0, atol=1e-14)
    assert (np.abs(one - other).max(axis=1) > 1.0).all()


def test_momentum_about_the_axis() -> None:
    """The second coordinate on the sphere is (γ × p)_i; the first turns from e_(i+1) to e_(i+2)."""
    for axis in range(3):
        plane = plane_of(SPHERE, gi.Event(f"gamma[{axis}]", level=0.2))
        assert plane is not None
        state = plane.states(np.array([0.0, 0.5 * np.pi]), np.array([1.5, -0.5]), 0.3)
        turned = np.cross(state[:, :3], state[:, 3:])[:, axis]
        np.testing.assert_allclose(turned, [1.5, -0.5], rtol=0, atol=1e-15)
        radius = np.sqrt(1.0 - 0.04)
        assert state[0, (axis + 1) % 3] == pytest.approx(radius)
        assert state[1, (axis + 2) % 3] == pytest.approx(radius)


@pytest.mark.parametrize(
    ("problem", "what", "level"),
    [
        (SPHERE, "p[0]", 0.0), (SPHERE, "gamma[0]", 1.0), (SPHERE, "gamma[0]", -2.0),
        (SPHERE, "energy", 1.0), (lotka_volterra.problem(), "x", 1.0),
        (gi.load_scene("sphere-n5").problem, "gamma[0]", 0.0),
    ],
)  # fmt: skip
def test_no_plane(problem: gi.Problem, what: str, level: float) -> None:
    name = what if what in problem.slices or "[" in what or what == "energy" else None
    event = gi.Event(name or next(iter(problem.slices)) + "[0]", level=level)
    assert plane_of(problem, event) is None


def test_boundary_of_henon_and_heiles() -> None:
    """½ p₂² + ½ q₂² − q₂³/3 on q₁ = 0, whose line at energy 1/8 is closed and within the grid."""
    y0 = [0.0, 0.1, np.sqrt(2.0 * (0.125 - 0.005 + 1e-3 / 3.0)), 0.0]
    plane = plane_of(CONTROL, gi.Event("q[0]"))
    assert plane is not None
    found = boundary(CONTROL, plane, np.array([y0]))
    assert found is not None
    assert found.energy == pytest.approx(0.125, rel=1e-14)
    q, p = np.meshgrid(found.x, found.y)
    exact = 0.5 * p**2 + 0.5 * q**2 - q**3 / 3.0
    np.testing.assert_allclose(found.least, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
    edge = np.concatenate([found.least[0], found.least[-1]])
    assert (edge > 0.125).all()


def test_no_boundary() -> None:
    """Motions of different energies; an energy that is no parabola in what is free; no points."""
    plane = plane_of(CONTROL, gi.Event("q[0]"))
    other = plane_of(CONTROL, gi.Event("p[1]"))
    assert plane is not None
    assert other is not None
    states = np.array([[0.0, 0.1, 0.2, 0.0], [0.0, 0.1, 0.3, 0.0]])
    assert boundary(CONTROL, plane, states) is None
    assert boundary(CONTROL, plane, np.zeros((0, 4))) is None
    assert boundary(CONTROL, other, np.array([[0.1, 0.1, 0.1, 0.0]])) is None


def test_points_lie_within() -> None:
    """Where the least energy is more than that of the motions there are no points."""
    y0 = gi.load_scene("sphere-n3").state
    others = states_on_level(SPHERE, y0, 5, seed=2)
    found = gi.poincare_section(SPHERE, [y0, *others], gi.Event("gamma[2]", "up"), 40, step=0.5)
    assert found.boundary is not None
    for x, y in zip(*found.coordinates(), strict=True):
        i, j = np.searchsorted(found.boundary.x, x), np.searchsorted(found.boundary.y, y)
        cell = found.boundary.least[max(j - 1, 0) : j + 1, max(i - 1, 0) : i + 1]
        assert cell.min() < found.boundary.energy


@pytest.mark.parametrize(("problem", "event", "y0"), [
    (CONTROL, "q[0]", [0.0, 0.1, 0.48, 0.0]), (SPHERE, "gamma[2]", gi.load_scene("sphere-n3").state),
])  # fmt: skip
def test_the_picture_shows_what_the_energy_allows(problem: gi.Problem, event: str, y0: Any) -> None:
    """All of it, and nearly nothing else."""
    found = gi.poincare_section(problem, y0, event, 20)
    assert found.boundary is not None
    x, y, least, energy = found.boundary
    inside = least <= energy
    panel = found.plot().axes[0]
    for values, some, (low, high) in (
        (x, inside.any(axis=0), panel.get_xlim()),
        (y, inside.any(axis=1), panel.get_ylim()),
    ):
        allowed = values[some]
        assert low <= allowed[0] < allowed[-1] <= high
        assert high - low < 1.15 * (allowed[-1] - allowed[0])


def test_levels() -> None:
    """None of them; several quantities; from rest; what cannot be kept."""
    y0 = gi.load_scene("sphere-n3").state
    assert states_on_level(SPHERE, y0, 0).shape == (0, 6)
    for y in states_on_level(SPHERE, y0, 3, keep=["energy", "K"]):
        for name in ("energy", "K"):
            assert gi.value(SPHERE, name, y) == pytest.approx(gi.value(SPHERE, name, y0), rel=1e-10)
    (moved,) = states_on_level(CONTROL, [0.0, 0.0, 1e-8, 0.0], 1)
    assert gi.value(CONTROL, "energy", moved) == pytest.approx(5e-17, rel=1e-10, abs=0.0)
    with pytest.raises(gi.DomainError, match="keep"):
        states_on_level(SPHERE, y0, 1, keep=["heat"])
