"""References: right to more digits than float64 shows, kept on disk, honest about their error."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

import geomint as gi
from geomint.compare import reference, reference_record
from geomint.compare.reference import reference_solution
from geomint.compare.reference_record import name_of
from geomint.kernels.compiling.private import PrivateFolder
from tests.problems import morse


@gi.field
def pendulum(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * gi.sin(y[0]) + 0.1 * gi.cos(t)


@gi.field
def circle(params, t, y, out, work):
    out[0] = -y[1]
    out[1] = y[0]


@gi.field
def circle_rate(params, t, y, work):
    return 2.0 + y[0]


@pytest.fixture
def forget(monkeypatch, tmp_path):
    folder = PrivateFolder(tmp_path, "")
    monkeypatch.setattr(reference_record, "private_folder", lambda _: folder)
    monkeypatch.setattr(reference, "name_of", lambda *a: "reference.json")
    return tmp_path / "reference.json"


def test_circle_to_the_last_bit(forget):
    problem = gi.Problem("circle", (("x", 2),), field=circle, clock=circle_rate, time="tau")
    found = reference_solution(problem, np.array([1.0, 0.0]), 100.0)
    with mp.workdps(50):
        truth = [float(mp.cos(100)), float(mp.sin(100))]
        clock = float(200 + mp.sin(100))
    np.testing.assert_array_equal(found.y, truth)
    assert found.physical_end == clock
    assert found.error < 1e-25


def test_non_autonomous_pendulum_against_mpmath(forget):
    problem = gi.Problem("pendulum", (("x", 2),), params=[1.3], field=pendulum)
    found = reference_solution(problem, np.array([0.5, 0.25]), 5.0)
    with mp.workdps(30):
        k = mp.mpf(1.3)  # the parameter as float64 has it
        tenth = mp.mpf(0.1)
        solution = mp.odefun(
            lambda t, y: [y[1], -k * mp.sin(y[0]) + tenth * mp.cos(t)], 0, [0.5, 0.25]
        )
        truth = np.array([float(v) for v in solution(5)])
    np.testing.assert_allclose(found.y, truth, rtol=2**-52, atol=0)


def test_exponential_forces_to_the_last_bit(forget):
    """Morse's oscillator against its closed solution, in 50 digits."""
    problem = morse.problem(1.5, 0.75)  # products of parameters are exact
    found = reference_solution(problem, morse.INITIAL, 20.0)
    with mp.workdps(50):
        depth, a = (mp.mpf(x) for x in problem.params)
        q, p = (mp.mpf(x) for x in morse.INITIAL)
        u = mp.exp(a * q)
        h = p**2 / 2 + depth * (1 - 1 / u) ** 2
        omega, size = a * mp.sqrt(2 * (depth - h)), mp.sqrt(depth * h)
        angle = 20 * omega + mp.atan2(-a * u * p * (depth - h) / omega, u * (depth - h) - depth)
        u = (depth + size * mp.cos(angle)) / (depth - h)
        truth = [mp.log(u) / a, -omega * size * mp.sin(angle) / (depth - h) / (a * u)]
    np.testing.assert_allclose(found.y, [float(x) for x in truth], rtol=2**-52, atol=0)


def test_second_time_comes_from_disk(forget, monkeypatch):
    problem = gi.Problem("circle", (("x", 2),), field=circle)
    y0 = np.array([1.0, 0.0])
    first = reference_solution(problem, y0, 3.0)
    assert forget.exists()
    monkeypatch.setattr(reference, "integrate_extended", lambda *a: pytest.fail("integrated again"))
    second = reference_solution(problem, y0, 3.0)
    np.testing.assert_array_equal(first.y, second.y)
    assert second.steps == first.steps


def test_broken_file_is_ignored(forget):
    forget.write_text("{not json")
    problem = gi.Problem("circle", (("x", 2),), field=circle)
    assert reference_solution(problem, np.array([1.0, 0.0]), 1.0).y[0] == pytest.approx(np.cos(1.0))


def test_hash_depends_on_everything():
    make = lambda **k: gi.Problem("circle", (("x", 2),), **{"field": circle, **k})  # noqa: E731
    y0 = np.array([1.0, 0.0])
    names = {
        name_of(make(), y0, 1.0),
        name_of(make(), y0, 2.0),
        name_of(make(), y0 + 1e-16 * np.array([0, 1]), 1.0),
        name_of(make(params=[1.0]), y0, 1.0),
        name_of(make(field=pendulum), y0, 1.0),
        name_of(gi.Problem("circle", (("x", 1), ("y", 1)), field=circle), y0, 1.0),
        name_of(make(clock=circle_rate, time="tau"), y0, 1.0),
    }
    assert len(names) == 7


def test_no_field_no_reference():
    problem = gi.Problem(
        "action only",
        (("x", 3),),
        action=gi.GroupAction(circle, gi.so3(1)),
    )
    with pytest.raises(gi.FormError, match="no field"):
        reference_solution(problem, np.ones(3), 1.0)


def test_a_motion_that_becomes_faster_on_a_space_with_parameters(forget):
    """The default step fails at the rim of the ellipsoid; its semi-axes are those of the space."""
    scene = gi.load_scene("ellipsoid-uneven").changed(time={"clock": None})
    problem, y0 = scene.problem, scene.state
    too_long = 0.75 * gi.Gauss(8).default_step(problem, y0, 40.0)
    with pytest.raises(gi.ConvergenceError):
        reference.integrate_extended(problem, y0, 40.0, too_long)
    found = reference_solution(problem, y0, 40.0)
    uneven = gi.time_transformed(problem, "normal_squared", y0)
    sol = gi.solve(uneven, y0, t_end=40.0, method=gi.Gauss(8), step=2.0)
    np.testing.assert_allclose(sol.y[-1], found.y, rtol=0, atol=1e-12)
