"""A ball of a laboratory: what it tells in SI units is what mechanics says of a rigid ball."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi

MASS, RADIUS, MOMENTS = 0.4, 0.1, np.array([1.2e-3, 1.6e-3, 2.0e-3])
BALL = ch.Ball(mass=MASS, radius=RADIUS, moments=MOMENTS)
PROBLEM = BALL.problem()
UP = np.array([0.0, 0.0, 1.0])


def read(y: Any, *names: str) -> Any:
    return np.array([gi.value(PROBLEM, name, y) for name in names])


def vector(y: Any, name: str) -> Any:
    return read(y, *(f"{name}-{i}" for i in (1, 2, 3)))


def states() -> list[Any]:
    found = [PROBLEM.random_state(seed) for seed in range(4)]
    turns = ([0.0, 0.0, 0.0], [0.0, 0.0, 30.0], [4.0, 0.0, 0.0], [1.0, -2.0, 1e3])
    tilts = (UP, -UP, [1.0, 0.0, 0.0], [0.48, 0.6, 0.64])
    return found + [
        PROBLEM.state(gamma=g, omega_space=w) for g, w in zip(tilts, turns, strict=True)
    ]


@pytest.mark.parametrize("y", states(), ids=range(8))
def test_mechanics(y: Any) -> None:
    """Velocities, energy and momentum of a rigid body by their definitions, not by k."""
    parts = PROBLEM.space.split(y)  # type: ignore[union-attr]
    g = parts["g"].reshape(3, 3)
    body, space = vector(y, "omega-body"), vector(y, "omega-space")
    size = max(np.abs(space).max(), 1.0)
    np.testing.assert_allclose(g @ body, space, atol=1e-13 * size)
    v = np.cross(space, RADIUS * UP)
    assert read(y, "speed")[0] == pytest.approx(np.linalg.norm(v), abs=1e-14 * size)
    kinetic = 0.5 * MASS * v @ v + 0.5 * body @ (MOMENTS * body)
    assert read(y, "energy")[0] == pytest.approx(kinetic, rel=1e-12, abs=1e-300)
    about_contact = g @ (MOMENTS * body) + MASS * np.cross(RADIUS * UP, v)
    k = np.array([-parts["k"][2], parts["k"][1], -parts["k"][0]])
    np.testing.assert_allclose(g @ k, about_contact, atol=1e-13 * size)


RUN = {"method": "cf-4", "compiled": False}


def test_newton() -> None:
    """The reaction is mass times acceleration; the contact point moves as the centre."""
    y0 = PROBLEM.state(gamma=[0.48, 0.6, 0.64], omega_space=[3.0, -4.0, 12.0], r=[0.2, -0.1])
    h = 1e-4
    times = np.array([0.1 - h, 0.1, 0.1 + h])
    solution = gi.solve(PROBLEM, y0, t_end=0.2, t_eval=times, step=2e-3, **RUN)
    before, here, after = (np.cross(vector(y, "omega-space"), RADIUS * UP)[:2] for y in solution.y)
    force = MASS * (after - before) / (2 * h)
    np.testing.assert_allclose(read(solution.y[1], "reaction-1", "reaction-2"), force, rtol=1e-5)
    r = solution.piece("r")
    np.testing.assert_allclose((r[2] - r[0]) / (2 * h), here, rtol=1e-5)


def test_velocities_and_their_frames() -> None:
    attitude = gi.Rotations(3).random(np.random.default_rng(1))["g"]
    y = PROBLEM.state(g=attitude, omega_space=[1.0, 2.0, 3.0])
    body = attitude.reshape(3, 3).T @ [1.0, 2.0, 3.0]
    np.testing.assert_allclose(y, PROBLEM.state(g=attitude, omega_body=body), atol=1e-15)
    np.testing.assert_allclose(vector(y, "omega-space"), [1.0, 2.0, 3.0], atol=1e-14)
    with pytest.raises(gi.DomainError, match="one of omega_space"):
        PROBLEM.state(gamma=UP, omega_space=[1.0, 0.0, 0.0], omega_body=[1.0, 0.0, 0.0])
    with pytest.raises(gi.DomainError, match="one of omega_space"):
        PROBLEM.state(gamma=UP, omega_body=[1.0, 0.0, 0.0], k=[1.0, 0.0, 0.0])
    with pytest.raises(gi.DomainError, match="omega_space"):
        PROBLEM.state(gamma=UP, omega_space=[1.0, np.inf, 0.0])


def test_everything_has_its_unit() -> None:
    for name in (*PROBLEM.slices, *PROBLEM.diagnostics, "t"):
        known = name in PROBLEM.constraints or PROBLEM.unit(name) != "dimensionless"
        assert known or name in ("gamma", "g"), name
    assert PROBLEM.unit("r[1]") == PROBLEM.unit("contact-2") == "m"
    assert (PROBLEM.unit("omega-body-3"), PROBLEM.unit("reaction-1")) == ("rad/s", "N")
    assert (
        ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).contact(rho=1.0).unit("r") == "dimensionless"
    )


def test_labels_have_units() -> None:
    y0 = PROBLEM.state(gamma=[0.48, 0.6, 0.64], omega_space=[3.0, -4.0, 12.0])
    run = {"save_every": 1, "observe": ["energy"], **RUN}
    solution = gi.solve(PROBLEM, y0, t_end=0.2, step=1e-3, **run)
    figure = solution.plot("contact", "speed", "r")
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == ["contact\n(m)", "speed\n(m/s)", "r\n(m)"]
    assert [len(axes.lines) for axes in figure.axes] == [2, 1, 2]
    assert figure.axes[-1].get_xlabel() == "t (s)"
    assert "t = 0 … 0.2 s" in figure.axes[0].get_title(loc="left")
    assert solution.plot_trace().axes[0].get_xlabel() == "r[0] (m)"
    phase = solution.plot_phase("speed", "omega-space-1")
    assert phase.axes[0].get_ylabel() == "omega-space-1 (rad/s)"
    assert "t (s)" in {axes.get_xlabel() for axes in solution.plot_drift().axes}


def test_a_file_keeps_the_units(tmp_path: Any) -> None:
    """Also where the code of the problem is not there."""
    y0 = PROBLEM.state(gamma=UP, omega_body=[3.0, -4.0, 12.0])
    solution = gi.solve(PROBLEM, y0, t_end=0.1, step=0.01, save_every=1, **RUN)
    solution.save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc")
    saved.about = dataclasses.replace(saved.about, content=b"")
    assert saved.plot("r").axes[0].get_ylabel() == "r\n(m)"
    assert saved.plot().axes[-1].get_xlabel() == "t (s)"


@pytest.mark.parametrize(
    "wrong",
    [{"mass": 0.0}, {"radius": -1.0}, {"mass": np.nan}, {"moments": [1.0, 2.0]}, {"moments": "a"}],
)
def test_balls_that_are_none(wrong: dict[str, Any]) -> None:
    given = {"mass": MASS, "radius": RADIUS, "moments": MOMENTS, **wrong}
    with pytest.raises(gi.DomainError, match=next(iter(wrong))):
        ch.Ball(**given)


@pytest.mark.parametrize(
    ("mass", "radius", "moments", "words"),
    [
        (1.0, 1.0, [0.1, 0.1, 0.3], "I_i ≤ I_j \\+ I_k"),
        (1.0, 1.0, np.diag([0.1, 0.1, 0.3]), "I_i ≤ I_j \\+ I_k"),
        (0.2, 0.05, [1.0, 1.0, 1.0], "0.004 m r² … 2 m r².* 0.0002 three times"),
        (1.0, 1.0, [0.7, 0.7, 0.7], "2 m r²"),
        (200, 0.05, [2e-4] * 3, "in kg m²"),  # grams
        (0.2, 5, [2e-4] * 3, "in kg m²"),  # centimetres
        (200, 5, [2e-4] * 3, "in kg m²"),
        (0.2, 0.05, [2e3] * 3, "in kg m²"),  # moments in g cm²
    ],
)
def test_moments_that_no_ball_has(mass: float, radius: float, moments: Any, words: str) -> None:
    """Of a body inside of it, or in another unit; a hollow ball and a heavy core are balls."""
    with pytest.raises(gi.DomainError, match=f"(?s)moments = .*{words}"):
        ch.Ball(mass, radius, moments)
    for share in (2.0 / 3.0, 0.4, 2e-3):
        ch.Ball(mass, radius, [share * mass * radius**2] * 3)
    ch.Ball(mass, radius, [0.5 * mass * radius**2, 0.5 * mass * radius**2, mass * radius**2])


def test_an_inertia_tensor() -> None:
    tensor = np.diag(MOMENTS)
    tensor[0, 1] = tensor[1, 0] = 1e-4
    ball = ch.Ball(mass=MASS, radius=RADIUS, moments=tensor).problem()
    w = np.array([3.0, -4.0, 12.0])
    y = ball.state(gamma=UP, omega_space=w)
    expected = 0.5 * w @ tensor @ w + 0.5 * MASS * RADIUS**2 * (w[0] ** 2 + w[1] ** 2)
    assert gi.value(ball, "energy", y) == pytest.approx(expected, rel=1e-12)
