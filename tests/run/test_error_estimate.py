"""`estimate_error=True`: against exact motions, and all that belongs to a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.compare.reference import integrate_extended
from geomint.run.error_estimate import error_estimate
from geomint.scene.load import builtin_scenes
from tests.families import FAMILIES, PROBLEMS

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")

SPHERE = gi.load_scene("sphere-n3")


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A circle, in a time that goes faster and faster."""
    out[0] = -(1.0 + 0.5 * t) * y[1]
    out[1] = (1.0 + 0.5 * t) * y[0]


CIRCLE = gi.Problem("circle", (("z", 2),), field=turning)


def on_circle(t: np.ndarray) -> np.ndarray:
    angle = t + 0.25 * t * t
    return np.column_stack((np.cos(angle), np.sin(angle)))


@pytest.mark.parametrize("name", ["rk-4", "gauss-2", "dop853", "dormand-prince-5-adaptive"])
@pytest.mark.parametrize("end", [5.0, -3.0, 0.33])
def test_against_the_motion(name: str, end: float) -> None:
    """Of every saved state, with its sign and forwards and backwards, a cut last step included."""
    step = {} if gi.find_method(name).adaptive else {"step": 0.33 if name == "dop853" else 0.1}
    sol = gi.solve(
        CIRCLE, [1.0, 0.0], t_end=end, method=name, **step, save_every=1, estimate_error=True
    )
    error = sol.y - on_circle(sol.t)
    assert sol.error_estimate is not None
    np.testing.assert_array_equal(sol.error_estimate[0], 0.0)
    assert np.abs(error[-1]).max() > 1e-11
    size = np.abs(error).max(axis=0)
    np.testing.assert_allclose(sol.error_estimate, error, rtol=0, atol=0.4 * size.max())


@pytest.mark.parametrize("name", ["rk-4", "gauss-2", "dormand-prince-5-adaptive"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.filterwarnings("ignore:step = ")
def test_states_within_the_first_step(name: str, sign: float) -> None:
    """They are one shorter step from the beginning; so is the end of a run shorter than a step."""
    adaptive = gi.find_method(name).adaptive
    chosen: Any = gi.find_method(name)
    if adaptive:
        chosen = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), rtol=1e-3, atol=1e-3)
    given = {"method": chosen, "step": 0.4, "estimate_error": True}
    t = sign * np.array([0.05, 0.11, 0.19, 0.2, 0.3, 0.9])
    several = gi.solve(CIRCLE, [1.0, 0.0], t_end=t[-1], t_eval=t, **given)
    one = gi.solve(CIRCLE, [1.0, 0.0], t_end=t[2], **given)
    for sol in (several, one):
        error = np.linalg.norm(sol.y - on_circle(sol.t), axis=1)
        assert sol.error_estimate is not None
        told = np.linalg.norm(sol.error_estimate, axis=1)
        assert (error > 1e-13).all()
        np.testing.assert_allclose(told, error, rtol=0.5)
    shifted = gi.solve(CIRCLE, [1.0, 0.0], t0=2.0, t_end=2.0 + t[-1], t_eval=2.0 + t, **given)
    assert (np.abs(shifted.error_estimate).max(axis=1) > 1e-13).all()


def test_an_interrupted_second_run() -> None:
    """There is no estimate then, which is told."""
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=1.0, step=0.1)

    def again(**options: Any) -> gi.Solution:
        found = gi.solve(CIRCLE, [1.0, 0.0], **options)
        found.status = "interrupted"
        return found

    with pytest.warns(gi.GeomintWarning, match="no error estimate: .* was interrupted"):
        assert error_estimate(sol, again, 0.0) is None


def test_early_states_by_a_clock() -> None:
    """States at physical times of a problem in τ, whose steps are of another length."""
    scene = gi.load_scene("hamiltonized-n3")
    given = {"t_end": 0.5, "t_eval": [0.05, 0.1, 0.5], "progress": False}
    sol = gi.solve(
        scene.problem, scene.state, method="rk-4", step=0.1, estimate_error=True, **given
    )
    fine = gi.solve(scene.problem, scene.state, method="gauss-8", step=0.01, **given)
    assert sol.tau[0] < 0.05
    assert sol.error_estimate is not None
    size = np.abs(sol.y - fine.y).max(axis=1)
    np.testing.assert_allclose(np.abs(sol.error_estimate).max(axis=1), size, rtol=0.3)


@pytest.mark.parametrize(("name", "problem"), FAMILIES)
def test_every_method(name: str, problem: str) -> None:
    p, y0 = PROBLEMS[problem]
    y0, end = p.canonical(y0), 1.5
    given = {"tau_end": end, "clock": False} if p.time == "tau" else {"t_end": end}
    sol = gi.solve(p, y0, **given, method=name, estimate_error=True)
    fine = gi.find_method("gauss-8")
    if p.field is None:
        truth = gi.solve(p, y0, **given, method=name, step=abs(sol.step_sizes.min) / 16).y[-1]
    else:
        step = fine.default_step(p, y0, end)
        truth = integrate_extended(p, y0, end, 0.25 * step)[: p.rows].astype(float)
    assert sol.error_estimate is not None
    estimate, error = (float(np.abs(x).max()) for x in (sol.error_estimate[-1], sol.y[-1] - truth))
    assert 0.1 * (error - 1e-15) < estimate < 10.0 * (error + 1e-15)


@pytest.mark.nightly
@pytest.mark.parametrize("name", sorted(builtin_scenes()))
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_built_in_scenes(name: str) -> None:
    """Within a factor of 10, of the scene's method and of one whose errors are larger."""
    scene = gi.load_scene(name)
    p, y0, end = scene.problem, scene.problem.canonical(scene.state), 20.0
    given = {"tau_end": end, "clock": False} if p.time == "tau" else {"t_end": end}
    step = gi.find_method("gauss-8").default_step(p, y0, end)
    truth = integrate_extended(p, y0, end, 0.25 * step)[: p.rows].astype(float)
    for method in (scene.method, "rk-4"):
        sol = gi.solve(p, y0, **given, method=method, estimate_error=True)
        assert sol.error_estimate is not None
        estimate = float(np.abs(sol.error_estimate[-1]).max())
        error = float(np.abs(sol.y[-1] - truth).max())
        assert 0.1 * error < estimate < 10.0 * error


def test_in_physical_time() -> None:
    """A run to a physical time is compared at physical times, one to τ at τ."""
    scene = gi.load_scene("hamiltonized-n3")
    p, y0 = scene.problem, scene.state
    motion = p.exact(y0)
    for given, exact in (
        ({"t_end": 6.0, "t_eval": [0.0, 2.0, 6.0]}, motion),
        ({"tau_end": 6.0, "tau_eval": [0.0, 2.0, 6.0]}, motion.at_tau),
    ):
        sol = gi.solve(p, y0, **given, method="rk-4", step=0.05, estimate_error=True)
        error = sol.y - exact(np.array([0.0, 2.0, 6.0]))
        assert sol.error_estimate is not None
        np.testing.assert_allclose(
            sol.error_estimate, error, rtol=0, atol=0.1 * np.abs(error).max()
        )


def test_what_ends_early() -> None:
    """At a terminal event, by a callback, at the first state; after a failure there is none."""
    given = {"method": "rk-4", "step": 0.1, "estimate_error": True}
    falls = gi.Event("z[0]", terminal=True)
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=9.0, events=falls, **given)
    assert sol.t[-1] == pytest.approx(math.sqrt(4.0 + 2.0 * math.pi) - 2.0, abs=1e-5)
    assert sol.error_estimate is not None
    error = sol.y - on_circle(sol.t)
    np.testing.assert_allclose(sol.error_estimate, error, rtol=0, atol=0.3 * np.abs(error).max())
    first = gi.solve(CIRCLE, [1.0, 0.0], t_end=9.0, t_eval=[0.0], **given)
    np.testing.assert_array_equal(first.error_estimate, [[0.0, 0.0]])
    stopped = gi.solve(CIRCLE, [1.0, 0.0], t_end=9e3, callback=lambda reached: True, **given)
    assert stopped.error_estimate is not None
    assert len(stopped.error_estimate) == len(stopped.y)


def test_kept_in_files(tmp_path: Path) -> None:
    sol = gi.solve(
        CIRCLE, [1.0, 0.0], t_end=2.0, step=0.1, save_every=3, method="rk-4", estimate_error=True
    )
    sol.save(tmp_path / "run.nc")
    np.testing.assert_array_equal(gi.load(tmp_path / "run.nc").error_estimate, sol.error_estimate)
    data = sol.to_xarray()
    np.testing.assert_array_equal(data["z_error"], sol.error_estimate)
    plain = gi.solve(CIRCLE, [1.0, 0.0], t_end=2.0, step=0.1)
    assert plain.error_estimate is None
    plain.save(tmp_path / "plain.nc")
    assert gi.load(tmp_path / "plain.nc").error_estimate is None


def test_wrong_input() -> None:
    whole = {"t_end": 1.0, "estimate_error": True}
    first = gi.solve(CIRCLE, [1.0, 0.0], t_end=0.5)
    with pytest.raises(gi.DomainError, match="errors from before"):
        gi.solve(first, **whole)
    with pytest.raises(gi.DomainError, match="takes no steps"):
        gi.solve(SPHERE.problem, SPHERE.state, method="exact", **whole)
    with pytest.raises(gi.DomainError, match="estimate_error"):
        gi.solve(CIRCLE, [1.0, 0.0], **{**whole, "estimate_error": "yes"})


@gi.field
def blowing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[0] * y[0]


def test_a_finer_run_that_fails() -> None:
    """A coarse step may leap over what a finer one finds: the run stays, with a warning."""
    problem = gi.Problem("blowing up", (("x", 1),), field=blowing)
    with pytest.warns(gi.GeomintWarning, match="no error estimate"):
        sol = gi.solve(problem, [1.0], t_end=3.0, method="rk-4", step=1.0, estimate_error=True)
    assert sol.success
    assert sol.error_estimate is None
