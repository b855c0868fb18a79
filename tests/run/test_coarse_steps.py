"""Steps that cannot follow the motion end in a warning; others, and exact ones, in none."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.compare.runs import compare
from geomint.problems.testproblems import henon_heiles
from tests.problems import lotka_volterra

BALL = gi.load_scene("ball-3d").model
CLASSICAL = BALL.problems["classical"], BALL.states["classical"]


@gi.field
def turning(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """An oscillator of frequency params[0]."""
    out[0] = params[0] * y[1]
    out[1] = -params[0] * y[0]


@gi.observable
def norm(params: Any, t: Any, y: Any, work: Any) -> Any:
    return y[0] * y[0] + y[1] * y[1]


def oscillator(**given: Any) -> gi.Problem:
    return gi.Problem("turning", (("x", 1), ("v", 1)), params=[1.0], field=turning, **given)


@pytest.mark.parametrize(
    ("problem", "y0", "method", "step", "words"),
    [
        (*CLASSICAL, "cf-4", 50.0, "energy is off by"),
        (*CLASSICAL, "rk-4", 2.0, r"energy is off by 0\.\d+ of its size at the end"),
        (henon_heiles.problem(), henon_heiles.INITIAL, "rk-4", 1.5, "energy is off"),
        (oscillator(invariants={"norm": norm}), [1.0, 0.5], "rk-4", 1.0, "norm is off"),
    ],
    ids=["ball, far too long", "ball", "Henon-Heiles", "an integral"],
)
def test_steps_that_are_far_too_long_are_told(
    problem: gi.Problem, y0: Any, method: str, step: float, words: str
) -> None:
    given: dict[str, Any] = {"method": method, "progress": False}
    with pytest.warns(gi.GeomintWarning, match=f"steps of {step:g} are so long that .*{words}"):
        gi.solve(problem, y0, t_end=40 * step, step=step, **given)
    for shorter in (None, 0.05):  # warnings are errors
        gi.solve(problem, y0, t_end=20.0, step=shorter, **given)


def test_long_steps_that_are_exact_are_not_told() -> None:
    """Of a rotation about a principal axis every step of a group method is the motion itself."""
    problem = CLASSICAL[0]
    y0 = problem.state(gamma=[1.0, 0.0, 0.0], k=[3.0, 0.0, 0.0])
    gi.solve(problem, y0, t_end=1000.0, step=50.0, method="cf-4", progress=False)


def test_a_slow_end_of_an_explicit_run_is_not_told() -> None:
    """Steps of a third of the characteristic time, as comparisons and order plots take them."""
    problem = lotka_volterra.problem()
    gi.solve(problem, lotka_volterra.INITIAL, t_end=10.0, step=0.2, method="rk-4", progress=False)


def test_comparisons_show_errors_and_say_nothing() -> None:
    scene = gi.load_scene("hamiltonized-n3")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        points = compare(scene.model, {"tau_end": 40.0}, ["rk-4"], steps=[0.5], repeats=1).points
    assert not [w for w in caught if "so long" in str(w.message)]
    state = scene.state
    with pytest.warns(gi.GeomintWarning, match="so long"):
        gi.solve(scene.problem, state, tau_end=40.0, step=0.5, method="rk-4", progress=False)
    assert points[0].error is not None
    assert np.isfinite(points[0].error)


@gi.observable
def square(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * norm(params, t, y, work)


@pytest.mark.parametrize("observed", [(), ("energy",)])
@pytest.mark.parametrize("size", [1.0, 1e150, 1e-154])
def test_no_unit_makes_a_change_large(size: float, observed: tuple[str, ...]) -> None:
    """Where sums of products would overflow, or vanish: the energy changes by 2e-7 of its size."""
    problem = oscillator(invariants={"energy": square})
    given: dict[str, Any] = {"observe": observed, "progress": False, "method": "rk-4"}
    gi.solve(problem, [size, 0.0], t_end=20.0, step=0.05, **given)
    with pytest.warns(gi.GeomintWarning, match=r"energy is off by 0\.\d+ of its size"):
        gi.solve(problem, [size, 0.0], t_end=20.0, step=1.0, **given)


@pytest.mark.parametrize("end", [20.0, 20.6])
def test_the_end_is_looked_at_whatever_is_saved(end: float) -> None:
    """Also that of a last partial step."""
    problem = oscillator(invariants={"energy": square})
    given: dict[str, Any] = {"method": "rk-4", "step": 1.0, "t_end": end, "progress": False}
    told = []
    for more in ({}, {"t_eval": [0.3]}, {"observe": "energy"}, {"t_eval": [0.3], "observe": "all"}):
        with pytest.warns(gi.GeomintWarning) as caught:
            gi.solve(problem, [1.0, 0.0], **given, **more)
        told += [str(w.message) for w in caught]
    assert len(told) == 4
    assert len(set(told)) == 1


@pytest.mark.parametrize("pieces", [(("q", 1), ("p", 1)), (("y", 2),)])
def test_no_note_ends_a_run(pieces: Any) -> None:
    """Of a field without a value, beside a splitting that has them all."""

    def undefined(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = 1e5 + 0.0 * y[0]
        out[1] = (y[1] - y[1]) / (y[1] - y[1])

    def flow(k: Any, params: Any, t: Any, h: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = h * y[1] if k == 0 else 0.0 * y[0]
        out[1] = 0.0 * y[0] if k == 0 else -h * y[0]

    forms: dict[str, Any] = {
        "field": gi.field(undefined),
        "splitting": gi.Splitting(gi.helper(flow), 2),
    }
    problem = gi.Problem("undefined", pieces, **forms)
    run = gi.solve(problem, [1.0, 0.5], t_end=1.0, method="verlet-2", step=0.1, progress=False)
    assert run.success
