"""Steps that cannot follow the motion end in a warning; others, and exact ones, in none."""

from __future__ import annotations

from typing import Any

import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from tests.problems import lotka_volterra
from tests.run.motions import swing

BALL = gi.load_scene("ball-3d").model
CLASSICAL = BALL.problems["classical"], BALL.states["classical"]
SWING = swing()
QUIET: dict[str, Any] = {"progress": False, "method": "rk-4"}


@gi.observable
def norm(params: Any, t: Any, y: Any, work: Any) -> Any:
    return y[0] * y[0] + y[1] * y[1]


def oscillator(name: str) -> gi.Problem:
    """An oscillator with an integral of that name."""
    return gi.Problem(*("swing", SWING.pieces, SWING.params, SWING.field), invariants={name: norm})


TOO_LONG = {
    "ball, far too long": (*CLASSICAL, "cf-4", 50.0, "energy is off by"),
    "ball": (*CLASSICAL, "rk-4", 2.0, r"energy is off by 0\.\d+ of its size at the end"),
    "Henon-Heiles": (henon_heiles.problem(), henon_heiles.INITIAL, "rk-4", 1.5, "energy is off"),
    "an integral": (oscillator("norm"), [1.0, 0.5], "rk-4", 1.0, "norm is off"),
}


@pytest.mark.parametrize("case", TOO_LONG)
def test_steps_that_are_far_too_long_are_told(case: str) -> None:
    problem, y0, method, step, words = TOO_LONG[case]
    with pytest.warns(gi.GeomintWarning, match=f"steps of {step:g} are so long that .*{words}"):
        gi.solve(problem, y0, t_end=40 * step, step=step, method=method)
    for shorter in (None, 0.05):  # warnings are errors
        gi.solve(problem, y0, t_end=20.0, step=shorter, method=method)


def test_long_steps_that_are_good_are_not_told() -> None:
    """Of a rotation about a principal axis every step of a group method is the motion itself; and
    comparisons and order plots take steps of a third of the characteristic time."""
    y0 = CLASSICAL[0].state(gamma=[1.0, 0.0, 0.0], k=[3.0, 0.0, 0.0])
    gi.solve(CLASSICAL[0], y0, t_end=1000.0, step=50.0, method="cf-4")
    gi.solve(lotka_volterra.problem(), lotka_volterra.INITIAL, t_end=10.0, step=0.2, **QUIET)


@pytest.mark.parametrize("size", [1.0, 1e150, 1e-154])
def test_no_unit_makes_a_change_large(size: float) -> None:
    """Where sums of products would overflow, or vanish: the energy changes by 2e-7 of its size."""
    for observed in ((), ("energy",)):
        given: dict[str, Any] = {"t_end": 20.0, "observe": observed, **QUIET}
        gi.solve(oscillator("energy"), [size, 0.0], step=0.05, **given)
        with pytest.warns(gi.GeomintWarning, match=r"energy is off by 0\.\d+ of its size"):
            gi.solve(oscillator("energy"), [size, 0.0], step=1.0, **given)


@pytest.mark.parametrize("end", [20.0, 20.6])
def test_the_end_is_looked_at_whatever_is_saved(end: float) -> None:
    """Also that of a last partial step."""
    told = []
    for more in ({}, {"t_eval": [0.3]}, {"observe": "energy"}, {"t_eval": [0.3], "observe": "all"}):
        with pytest.warns(gi.GeomintWarning) as caught:
            gi.solve(oscillator("energy"), [1.0, 0.0], t_end=end, step=1.0, **QUIET, **more)
        told += [str(w.message) for w in caught]
    assert len(told) == 4
    assert len(set(told)) == 1


@pytest.mark.parametrize("pieces", [(("q", 1), ("p", 1)), (("y", 2),)])
def test_no_note_ends_a_run(pieces: Any) -> None:
    """Of a field without a value, beside a splitting that has them all."""

    @gi.field
    def undefined(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0], out[1] = 1e5 + 0.0 * y[0], (y[1] - y[1]) / (y[1] - y[1])

    @gi.helper
    def flow(k: Any, params: Any, t: Any, h: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = h * y[1] if k == 0 else 0.0 * y[0]
        out[1] = 0.0 * y[0] if k == 0 else -h * y[0]

    problem = gi.Problem("undefined", pieces, field=undefined, splitting=gi.Splitting(flow, 2))
    assert gi.solve(problem, [1.0, 0.5], t_end=1.0, method="verlet-2", step=0.1).success
