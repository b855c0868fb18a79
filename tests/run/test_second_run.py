"""What is promised of the end holds, as a second run tells, or a warning comes."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run import growth
from geomint.run.growth import end_error, hopeless
from geomint.run.second import Second, longer
from geomint.run.timeline import Timeline


@gi.field
def saddle(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = params[0] * y[0] - y[0] * y[0] * y[0]


@gi.field
def pole(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = params[0] * y[0] * y[0]
    out[1] = 0.0 * y[1]


@gi.field
def chirp(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    w = 1.0 + params[0] * t
    out[0] = y[1]
    out[1] = -w * w * y[0]


@gi.field
def switched(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = -y[0] + gi.select(t > params[0], 0.01, 0.0)


MOTIONS: dict[str, tuple[Any, float, list[float], float]] = {
    "out of a saddle": (saddle, 1.0, [1e-4, 0.0], 24.0),
    "over a saddle and back": (saddle, 1.0, [0.9, 0.4], -40.0),
    "up to a pole": (pole, 1.0, [2.0, 1.0], 0.499),
    "faster and faster": (chirp, 1.3, [0.7, 0.3], 20.0),
    "a force that switches": (switched, 7.3, [0.7, 0.3], 15.0),
    "at rest": (saddle, -1.0, [0.0, 0.0], 30.0),
}


def right(field: Any, param: float, y0: list[float], end: float) -> tuple[Any, float]:
    """Return the state at the end by SciPy, begun anew at a switch, and the largest number."""
    work, y, t, largest = [0.0], np.array(y0), 0.0, 1e-9

    def rates(t: float, y: Any, after: float) -> list[float]:
        out = [0.0, 0.0]
        field.function([param], max(t, after) if end > 0.0 else t, y, out, work)
        return out

    for stop in (param, end) if field is switched else (end,):
        late = math.nextafter(t, math.inf) if t else 0.0
        found = solve_ivp(
            rates, (t, stop), y, args=(late,), method="DOP853", rtol=3e-14, atol=1e-22
        )
        y, t, largest = found.y[:, -1], stop, max(np.abs(found.y).max(), largest)
    return y, largest


@pytest.mark.parametrize("asked", [{}, {"tolerance": 1e-7, "method": "auto"}], ids=["none", "auto"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_end_is_as_promised_or_said_not_to_be(motion: str, asked: dict[str, Any]) -> None:
    field, param, y0, end = MOTIONS[motion]
    problem = gi.Problem(motion.replace(" ", "-"), (("y", 2),), params=[param], field=field)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sol = gi.solve(problem, y0, t_end=end, progress=False, **asked)
    truth, largest = right(field, param, y0, end)
    error = np.abs(sol.y[-1] - truth).max() / largest
    assert error < 30.0 * asked.get("tolerance", 1e-9)
    assert not told


@pytest.mark.parametrize("end", [5.0, 400.0])  # at once, and in another thread
def test_the_second_run_is_that_of_longer_steps(end: float) -> None:
    problem, y0 = henon_heiles.problem(), henon_heiles.INITIAL
    integrator = gi.Integrator(problem, y0, step=0.1)
    second = Second(integrator, (Timeline(0.0, integrator.h, None, 0.0, end, None),))
    second.begin(end)
    plain = gi.Integrator(problem, y0, step=longer(integrator.method.order) * integrator.h)
    plain.propagate_until(end)
    np.testing.assert_allclose(second.state(end), plain.state, atol=1e-12)
    plain.reset()
    plain.propagate_until(0.7 * end)  # where an event has ended the run
    np.testing.assert_allclose(second.state(0.7 * end), plain.state, atol=1e-12)


def test_what_ends_tell() -> None:
    """√(r^p − 1) errors where few enough are left, or three runs agree; one where errors grow."""
    problem, y0 = henon_heiles.problem(), henon_heiles.INITIAL
    sol = gi.solve(problem, y0, t_end=40.0, step=0.8, progress=False)
    local = sol.local_error
    assert local is not None

    def found(apart: float, wanted: float = 1e-16, other: float = 0.0) -> Any:
        return end_error(sol, apart, wanted, 0.0, 50.0, other)

    assert found(1e-17).error <= max(local.total, 1e-17) * 1.1
    regular = 20.0 * local.total
    assert found(regular).error == pytest.approx(max(regular / 7.0, local.total), rel=0.3)
    grown = found(1e4 * 50.0 * local.total)
    more = 2500.0 * local.total  # errors grow 50 times, so that the order alone is not trusted
    for expected, part in ((0.0, 1.0), (0.1, 1.0), (1.5, 1 / 7), (4.0, 1.0)):
        agreed = found(more, 0.1 * more, expected * more)
        assert agreed.error == pytest.approx(part * more, rel=0.3)
    assert grown.error == pytest.approx(5e5 * local.total, rel=0.3)
    assert grown.grown == pytest.approx(1e4, rel=0.5)
    assert 0.0 <= grown.until < 40.0
    sol.end_error = grown
    assert hopeless(sol, 1e-16, sol)
    assert not hopeless(sol, 1e-6, sol)


def test_it_is_of_the_end_whatever_is_saved() -> None:
    problem, y0 = henon_heiles.problem(), henon_heiles.INITIAL
    whole = gi.solve(problem, y0, t_end=50.0, progress=False)
    some = gi.solve(problem, y0, t_end=50.0, t_eval=[3.0], progress=False)
    assert whole.end_error is not None
    assert some.end_error is not None
    assert whole.end_error[1:] == some.end_error[1:]
    assert some.end_error.error < 1e-13
    assert gi.solve(problem, y0, t_end=50.0, method="gauss-8", progress=False).end_error is None


def test_saddles_are_passed_by_variable_steps_too() -> None:
    problem = gi.Problem("saddle", (("y", 2),), params=[1.0], field=saddle)
    given: dict[str, Any] = {"method": "dop853-adaptive", "tolerance": 1e-8, "progress": False}
    sol = gi.solve(problem, [1e-4, 0.0], t_end=24.0, **given)
    assert sol.end_error is not None
    truth, _ = right(saddle, 1.0, [1e-4, 0.0], 24.0)
    assert np.abs(sol.y[-1] - truth).max() < 3e-7


@pytest.mark.parametrize(
    "behind", [0.0146, 1.0146]
)  # before the first node of a step: both err alike
def test_a_jump_behind_the_middle_of_a_window_is_measured(behind: float) -> None:
    problem = gi.Problem("s", (("y", 2),), params=[(10.0 + behind) * 0.1], field=switched)
    sol = gi.solve(problem, [0.7, 0.3], t_end=2.0, method="gauss-6", step=0.1, progress=False)
    assert sol.local_error is not None
    size = np.abs(sol.y[-1]).max()
    assert 0.3 < sol.local_error.largest * size / (0.01 * 0.0146 * 0.1) < 3.0
    assert abs(sol.local_error.time - 1.0 - 0.1 * behind) < 0.21


def test_ctrl_c_while_a_run_is_confirmed_leaves_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def pressed(self: Second, end: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Second, "state", pressed)
    sol = gi.solve(henon_heiles.problem(), henon_heiles.INITIAL, t_end=20.0, progress=False)
    assert sol.success
    assert sol.end_error is None


@gi.field
def edge(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 1.0 / gi.sqrt(params[0] - t) + 0.0 * y[0]


@pytest.mark.parametrize("asked", [{}, {"tolerance": 1e-9, "method": "auto"}], ids=["none", "auto"])
def test_a_rate_that_is_infinite_at_the_end_hides_no_error(asked: dict[str, Any]) -> None:
    problem = gi.Problem("edge", (("y", 1),), params=[3.0], field=edge)
    with pytest.warns(gi.GeomintWarning, match="end"):
        sol = gi.solve(problem, [0.0], t_end=3.0, progress=False, **asked)
    assert sol.end_error is not None
    assert sol.end_error.error > 1e-4
    assert sol.end_error.until == 0.0


@gi.field
def hump(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A rotation that is fast about time 10: Newton's method finds its steps there."""
    z = (t - 10.0) / params[0]
    w = 1.0 + params[1] / (1.0 + z * z)
    out[0] = w * y[1]
    out[1] = -w * y[0]


@pytest.mark.parametrize(("width", "step"), [(1.0, 0.25), (2.0, 0.25), (2.0, 0.35)])
def test_the_worst_of_steps_by_newtons_method_is_found(width: float, step: float) -> None:
    problem = gi.Problem("hump", (("y", 2),), params=[width, 20.0], field=hump)
    sol = gi.solve(problem, [1.0, 0.0], t_end=20.0, method="gauss-8", step=step, progress=False)
    angle = 20.0 + 40.0 * width * math.atan(10.0 / width)
    off = np.abs(sol.y[-1] - [math.cos(angle), -math.sin(angle)]).max()
    assert sol.local_error is not None
    assert abs(sol.local_error.time - 10.0) < 1.0
    assert 0.05 < sol.local_error.total / off < 20.0


@gi.field
def stiffened(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    d = (t - 50.0) / 0.3
    out[0] = 1.0 * y[1]
    out[1] = -y[0] * (1.0 + 3000.0 / (1.0 + d * d * d * d))


@pytest.mark.parametrize(
    "asked", [{}, {"method": "rk-4"}, {"tolerance": 1e-8}, {"method": "dop853", "tolerance": 1e-6}]
)
def test_a_run_that_goes_on_keeps_what_was_promised_or_says_so(
    asked: dict[str, Any], tmp_path: Path
) -> None:
    problem = gi.Problem("stiffened", (("y", 2),), field=stiffened)
    first = gi.solve(problem, [1.0, 0.0], t_end=10.0, **asked, progress=False)
    first.save(tmp_path / "first.nc")
    assert not first.warnings
    loaded = gi.load(tmp_path / "first.nc", problem)
    for former in (first, loaded):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                gi.solve(former, t_end=100.0, progress=False)
            except gi.ConvergenceError:  # a typed error is no silence
                continue
        assert any("than is promised" in str(warning.message) for warning in told)
    given = gi.solve(problem, [1.0, 0.0], t_end=10.0, step=0.05, progress=False)
    assert not gi.solve(given, t_end=20.0, progress=False).warnings
    assert not gi.solve(first, t_end=20.0, progress=False).warnings


def test_errors_are_those_up_to_an_event_that_ends_the_run() -> None:
    """Steps were ranked up to beyond it, where a wall is met."""
    event = gi.Event("y[0]", terminal=True)
    for stiffness in (4.0, 1e4):
        problem = gi.Problem("fall", (("y", 2),), params=[stiffness], field=contact)
        for step in (None, 0.1) if stiffness < 10.0 else (None,):
            sol = gi.solve(problem, [1.0, 0.0], t_end=10.0, step=step, events=event, progress=False)
            assert sol.t[-1] == pytest.approx(np.sqrt(2.0), abs=1e-12)
            assert sol.local_error is not None
            assert sol.local_error.largest < 1e-14
            assert not sol.warnings


@gi.field
def contact(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 1.0 * y[1]
    out[1] = -1.0 + gi.select(y[0] < 0.0, -params[0] * y[0], 0.0)


@pytest.mark.parametrize(("end", "few"), [(25.0, True), (60.0, False)])
def test_two_runs_of_few_steps_may_agree_by_chance(
    end: float, few: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of so few what steps err by counts, however near the ends of both runs are."""
    problem, wanted = henon_heiles.problem(), 1e-6
    sol = gi.solve(problem, henon_heiles.INITIAL, t_end=end, method="auto", tolerance=wanted)
    assert sol.steps > growth.SHORT
    assert (sol.steps <= 20) is few
    monkeypatch.setattr(growth, "_local", lambda found: 50.0 * wanted)
    error = end_error(sol, 0.5 * wanted, wanted, 0.0, 10.0, 0.0).error
    assert error == (50.0 * wanted if few else 0.5 * wanted)


@gi.field
def relaxed(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -params[0] * (y[0] - gi.cos(t)) - gi.sin(t)


def test_steps_that_are_not_stable_are_shortened() -> None:
    """Such a run is off by more than the motion is large, and says nothing of how errors grow."""
    problem = gi.Problem("relaxed", (("y", 1),), params=[336.0966], field=relaxed)
    length, tolerance = 1.688, 9e-4
    for begin in np.linspace(-2.0, 2.0, 9):
        given: dict[str, Any] = {"t0": begin, "t_end": begin + length, "method": "dop853"}
        sol = gi.solve(problem, [0.601332], **given, tolerance=tolerance, progress=False)
        assert abs(sol.y[-1, 0] - math.cos(begin + length)) < 10.0 * tolerance
        assert not sol.warnings
