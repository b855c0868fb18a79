"""`estimate_error=True`: against exact motions, and all that belongs to a run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.run.motions import solve

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")

METHODS = ["rk-4", "gauss-2", "dormand-prince-5-adaptive"]
COARSE = gi.Adaptive(gi.RungeKutta("dormand-prince-5"), rtol=1e-3, atol=1e-3)


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A circle, in a time that goes faster and faster."""
    out[0], out[1] = -(1.0 + 0.5 * t) * y[1], (1.0 + 0.5 * t) * y[0]


@gi.observable
def pace(params: Any, t: Any, y: Any, work: Any) -> Any:
    """So that the angle is the time that goes on evenly."""
    return (1.0 + 0.5 * t) * (y[0] * y[0] + y[1] * y[1])


CIRCLE = gi.Problem("circle", (("z", 2),), field=turning)
IN_TAU = gi.Problem("circle", (("z", 2),), field=turning, time="tau", clock=pace)


def on_circle(t: np.ndarray, angle: Any = None) -> np.ndarray:
    angle = t + 0.25 * t * t if angle is None else angle
    return np.column_stack((np.cos(angle), np.sin(angle)))


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("end", [5.0, -3.0, 0.33])
def test_against_the_motion(name: str, end: float) -> None:
    """Of every saved state, with its sign and forwards and backwards, a cut last step included."""
    run = {} if gi.find_method(name).adaptive else {"step": 0.1}
    run |= {"method": name, "save_every": 1, "estimate_error": True}
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=end, **run)
    error = sol.y - on_circle(sol.t)
    np.testing.assert_array_equal(sol.error_estimate[0], 0.0)
    assert np.abs(error[-1]).max() > 1e-11
    size = np.abs(error).max(axis=0)
    np.testing.assert_allclose(sol.error_estimate, error, rtol=0, atol=0.4 * size.max())
    np.testing.assert_array_equal(sol.to_xarray()["z_error"], sol.error_estimate)


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.filterwarnings("ignore:step = ")
def test_states_within_the_first_step(name: str, sign: float) -> None:
    """They are one shorter step from the beginning; so is the end of a run shorter than a step."""
    chosen = COARSE if gi.find_method(name).adaptive else name
    given = {"method": chosen, "step": 0.4, "estimate_error": True}
    t = sign * np.array([0.05, 0.11, 0.19, 0.2, 0.3, 0.9])
    several = gi.solve(CIRCLE, [1.0, 0.0], t_end=t[-1], t_eval=t, **given)
    one = gi.solve(CIRCLE, [1.0, 0.0], t_end=t[2], **given)
    for sol in (several, one):
        error, told = sol.y - on_circle(sol.t), sol.error_estimate
        assert (np.linalg.norm(error, axis=1) > 1e-13).all()
        sizes = [np.linalg.norm(each, axis=1) for each in (told, error)]
        np.testing.assert_allclose(*sizes, rtol=0.5)
    shifted = gi.solve(CIRCLE, [1.0, 0.0], t0=2.0, t_end=2.0 + t[-1], t_eval=2.0 + t, **given)
    assert (np.abs(shifted.error_estimate).max(axis=1) > 1e-13).all()


def test_an_interrupted_second_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """There is no estimate then, which is told."""
    take = gi.Integrator.take

    def pressed(self: gi.Integrator, *given: Any) -> Any:
        if self.h < 0.1:
            raise KeyboardInterrupt
        return take(self, *given)

    monkeypatch.setattr(gi.Integrator, "take", pressed)
    run = {"t_end": 1.0, "step": 0.1, "method": "rk-4", "estimate_error": True}
    with pytest.warns(gi.GeomintWarning, match="no error estimate: .* was interrupted"):
        sol = gi.solve(CIRCLE, [1.0, 0.0], **run)
    assert (sol.status, sol.error_estimate) == ("success", None)


def test_in_physical_time() -> None:
    """A run to a physical time is compared at physical times, one to τ at τ; early ones too."""
    times = np.array([0.05, 2.0, 6.0])
    for given, exact in (
        ({"t_end": 6.0, "t_eval": times}, on_circle(times, angle=times)),
        ({"tau_end": 6.0, "tau_eval": times}, on_circle(times)),
    ):
        run = {"method": "rk-4", "step": 0.1, "estimate_error": True}
        sol = gi.solve(IN_TAU, [1.0, 0.0], **given, **run)
        error, told = sol.y - exact, sol.error_estimate
        np.testing.assert_allclose(told, error, rtol=0, atol=0.1 * np.abs(error).max())
        sizes = [np.abs(each).max(axis=1) for each in (told, error)]
        np.testing.assert_allclose(*sizes, rtol=0.3)


def test_what_ends_early() -> None:
    """At a terminal event, by a callback, at the first state; after a failure there is none."""
    given = {"method": "rk-4", "step": 0.1, "estimate_error": True}
    falls = gi.Event("z[0]", terminal=True)
    sol = gi.solve(CIRCLE, [1.0, 0.0], t_end=9.0, events=falls, **given)
    assert sol.t[-1] == pytest.approx(math.sqrt(4.0 + 2.0 * math.pi) - 2.0, abs=1e-5)
    error = sol.y - on_circle(sol.t)
    np.testing.assert_allclose(sol.error_estimate, error, rtol=0, atol=0.3 * np.abs(error).max())
    first = gi.solve(CIRCLE, [1.0, 0.0], t_end=9.0, t_eval=[0.0], **given)
    np.testing.assert_array_equal(first.error_estimate, [[0.0, 0.0]])
    stopped = gi.solve(CIRCLE, [1.0, 0.0], t_end=9e3, callback=lambda reached: True, **given)
    assert len(stopped.error_estimate) == len(stopped.y)


def test_wrong_input() -> None:
    whole = {"t_end": 1.0, "estimate_error": True}
    first = gi.solve(CIRCLE, [1.0, 0.0], t_end=0.5, method="rk-4", step=0.1)
    with pytest.raises(gi.DomainError, match="errors from before"):
        gi.solve(first, **whole)
    scene = gi.load_scene("sphere-n3")
    with pytest.raises(gi.DomainError, match="takes no steps"):
        gi.solve(scene.problem, scene.state, method="exact", **whole)


@gi.field
def blowing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[0] * y[0]


def test_a_finer_run_that_fails() -> None:
    """A coarse step may leap over what a finer one finds: the run stays, with a warning."""
    problem = gi.Problem("blowing up", (("x", 1),), field=blowing)
    with pytest.warns(gi.GeomintWarning, match="no error estimate"):
        sol = solve(problem, [1.0], t_end=3.0, method="rk-4", step=1.0, estimate_error=True)
    assert sol.success
    assert sol.error_estimate is None
