"""Local errors: measured where steps err most; runs without a step begin anew where they are large."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import chaplygin as ch
import geomint as gi
from geomint.problems.evaluate import rates_of
from geomint.problems.testproblems import henon_heiles, sphere_metric
from geomint.run.local_error import promised
from tests.problems import lotka_volterra

SPHERE = ch.ChaplyginSphere(a=(0.8, 1.1, 1.5), D=4.0).hamiltonized()
BALL = ch.ChaplyginSphere.from_moments((1.0, 2.0, 3.0), 1.0, 1.0).classical()
METRIC = sphere_metric.problem()
SYSTEMS = {
    "sphere": (SPHERE, SPHERE.random_state(3)),
    "ball": (BALL, BALL.random_state(3)),
    "henon-heiles": (henon_heiles.problem(), np.asarray(henon_heiles.INITIAL)),
    "metric": (METRIC, np.asarray(sphere_metric.initial(METRIC))),
    "lotka-volterra": (lotka_volterra.problem(), np.asarray(lotka_volterra.INITIAL)),
}


@pytest.mark.parametrize(
    ("method", "system", "step"),
    [
        ("gauss-8", "sphere", 1.5),
        ("gauss-8", "ball", 1.2),
        ("gauss-4", "henon-heiles", 0.7),
        ("gauss-2", "lotka-volterra", 0.1),
        ("rk-4", "lotka-volterra", 0.1),
        ("dop853", "henon-heiles", 0.5),
        ("heun-2", "lotka-volterra", 0.02),
        ("cf-4", "ball", 0.1),
        ("rkmk-4", "ball", 0.15),
        ("cg-3", "ball", 0.05),
        ("verlet-2", "sphere", 0.03),
        ("verlet-4", "sphere", 0.2),
        ("rattle-2", "metric", 0.02),
        ("rattle-4", "sphere", 0.3),
        ("lobatto-3", "sphere", 0.3),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_is_what_steps_err_by(method: str, system: str, step: float, sign: float) -> None:
    """Against every step once more, in eighths by the method of order 16."""
    problem, y0 = SYSTEMS[system]
    end = {f"{'tau' if problem.time == 'tau' else 't'}_end": sign * 150.4 * step}
    sol = gi.solve(problem, y0, **end, step=step, method=method, save_every=1, progress=False)
    right = gi.Integrator(problem, y0, "gauss-8", step=step / 8.0)
    errors = []
    for time, before, after in zip(sol.tau[:-2], sol.y[:-2], sol.y[1:-1], strict=True):
        right.reset(before, time)
        right.h = sign * step / 8.0
        right.step(8)
        off = np.abs(after - right.state)
        sizes = [np.abs(after[p]).max() for p in problem.slices.values()]
        errors.append(
            max(off[p].max() / s for p, s in zip(problem.slices.values(), sizes, strict=True))
        )
    found = sol.local_error
    assert found is not None
    assert found.step == pytest.approx(step)
    assert max(errors) / 30.0 < found.largest < 30.0 * max(errors)
    assert sum(errors) / 30.0 < found.total < 30.0 * sum(errors)
    worst = sol.tau[int(np.argmax(errors))]
    near = [e for e, t in zip(errors, sol.tau, strict=False) if abs(t - found.time) <= 10.0 * step]
    assert max(near) > max(errors) / 30.0, worst


def test_it_is_kept_and_the_run_is_not_disturbed(tmp_path: Path) -> None:
    given: dict[str, Any] = {"t_end": 20.0, "step": 0.1, "method": "rk-4", "progress": False}
    sol, other = (gi.solve(*SYSTEMS["ball"], **given) for _ in range(2))
    error = sol.local_error
    assert error is not None
    assert error == sol.local_error
    sol.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc")
    assert loaded.local_error == error
    assert loaded.provenance["local_error"]["largest"] == error.largest
    on, alone = (gi.solve(s, t_end=30.0, progress=False) for s in (sol, other))
    assert on.y.tobytes() == alone.y.tobytes()
    adaptive = gi.solve(*SYSTEMS["ball"], t_end=20.0, method="dop853-adaptive", progress=False)
    assert adaptive.local_error is None


# --- runs without a step ----------------------------------------------------------------------------


@gi.field
def far(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = params[0] - y[0]


@gi.field
def epidemic(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -0.5 * y[0] * y[1]
    out[1] = 0.5 * y[0] * y[1] - 0.1 * y[1]
    out[2] = 0.1 * y[1]


@gi.field
def kepler(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    r2 = y[0] * y[0] + y[1] * y[1]
    r3 = r2 * gi.sqrt(r2)
    out[0] = y[2]
    out[1] = y[3]
    out[2] = -y[0] / r3
    out[3] = -y[1] / r3


@gi.field
def rigid(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = -y[1] * y[2] / 3.0
    out[1] = y[2] * y[0]
    out[2] = -y[0] * y[1]


@gi.field
def hanging(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """A spherical pendulum."""
    force = 9.81 * y[2] - (y[3] * y[3] + y[4] * y[4] + y[5] * y[5])
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = force * y[i]
    out[5] = out[5] - 9.81


def plain(f: Any, n: int, *params: float) -> gi.Problem:
    return gi.Problem(f.function.__name__, (("y", n),), params=list(params), field=f)


CASES: dict[str, tuple[Callable[[], gi.Problem], list[float], float, float]] = {
    "far away": (lambda: plain(far, 2, 100.0), [101.0, 0.0], 100.0, 1e-4),
    "very far": (lambda: plain(far, 2, 1e4), [1e4 + 1.0, 0.0], 100.0, 1e-5),
    "epidemic": (lambda: plain(epidemic, 3), [0.999, 1e-3, 0.0], 100.0, 1e-4),
    "apocentre": (lambda: plain(kepler, 4), [1.8, 0.0, 0.0, 1.0 / 3.0], 20.0, 1e-4),
    "middle axis": (lambda: plain(rigid, 3), [1e-5, 1.0, 1e-5], 40.0, 1e-4),
    "lowest point": (
        lambda: gi.Problem("hanging", space=gi.TangentSphere(3, ("q", "v")), field=hanging),
        [0.0, 0.0, -1.0, 1e-5, 0.0, 0.0],
        10.0,
        1e-6,
    ),
}


@pytest.mark.parametrize("method", ["gauss-8", "gauss-4", "rk-4", "dop853"])
@pytest.mark.parametrize("case", CASES)
def test_a_step_that_is_not_given_follows_the_motion(case: str, method: str) -> None:
    """Silently wrong by a tenth to a million times before: the first state does not show the motion."""
    made, y0, end, bound = CASES[case]
    problem = made()
    sol = gi.solve(problem, y0, t_end=end, method=method, progress=False)
    right = gi.solve(problem, y0, t_end=end, method=gi.Gauss(8), step=0.02, progress=False).y[-1]
    off = np.abs(sol.y[-1] - right)
    for piece in problem.slices.values():
        assert off[piece].max() <= bound * np.abs(right[piece]).max()


@gi.field
def relaxing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = params[0] * (1.0 - y[0] * y[0]) * y[1] - y[0]


@gi.field
def pushed_once(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    z = (t - params[0]) / params[1]
    w = 1.0 / (1.0 + z * z)
    w = w * w * w * w
    out[0] = 1.0 * y[1]
    out[1] = params[2] * w * w


@pytest.mark.parametrize(
    ("field", "params", "y0", "end", "method"),
    [
        (relaxing, [2.37344467], [0.99398672, 0.0], 28.2, "dop853"),  # gone when it is measured
        (pushed_once, [11.31989709, 0.64322135, 0.82611992], [0.0, 0.0], 15.0, "gauss-8"),
    ],
    ids=["contraction", "one step errs"],
)
def test_each_step_errs_by_what_is_promised(
    field: Any, params: list[float], y0: list[float], end: float, method: str
) -> None:
    """Where one look at the end of a window, or a limit for steps that err alike, was 40 times off."""
    problem = gi.Problem("looks", (("y", 2),), params=params, field=field)
    sol = gi.solve(problem, y0, t_end=end, method=method, save_every=1, progress=False)
    rate, sizes, worst = rates_of(problem, sol.y[0]), np.abs(sol.y).max(), 0.0
    for k in range(len(sol.t) - 1):
        right = solve_ivp(
            lambda t, y: rate(problem, y, t).copy(),
            sol.t[k : k + 2],
            sol.y[k],
            method="DOP853",
            rtol=2.3e-14,
            atol=1e-18,
        ).y[:, -1]
        worst = max(worst, np.abs(sol.y[k + 1] - right).max() / sizes)
    assert worst < 12.0 * promised(sol.method)


def test_what_begins_with_it_is_that_of_the_last_run() -> None:
    problem = plain(kepler, 4)
    y0 = np.array([1.8, 0.0, 0.0, 1.0 / 3.0])
    given: dict[str, Any] = {"t_end": 20.0, "method": "rk-4", "progress": False}
    given |= {"t_eval": [5.0, 20.0], "events": ["y[1]"]}
    sol = gi.solve(problem, y0, **given)
    again = gi.solve(problem, y0, step=sol.step, **given)
    assert sol.y.tobytes() == again.y.tobytes()
    assert sol.steps == again.steps
    assert sol.events["y[1]"].t.tolist() == again.events["y[1]"].t.tolist()


def test_a_callback_sees_one_run_and_gets_a_warning() -> None:
    problem, times = plain(kepler, 4), []
    given: dict[str, Any] = {"t_end": 20.0, "method": "rk-4", "progress": False}
    with pytest.warns(gi.GeomintWarning, match=r"steps of .* err by .* more than is promised"):
        gi.solve(
            problem, [1.8, 0.0, 0.0, 1.0 / 3.0], callback=lambda told: times.append(told.t), **given
        )
    assert times == sorted(times)


@gi.field
def pulsed(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """An oscillator that is pushed at a time, for a time."""
    s = (t - params[0]) / params[1]
    push = 1.0 / (1.0 + s * s)
    out[0] = y[1]
    out[1] = -y[0] + 20.0 * push * push * push * push


@pytest.mark.parametrize("method", ["auto", "rk-4", "dop853"])
@pytest.mark.parametrize("width", [0.1, 0.4])
def test_a_tolerance_holds_where_something_comes_later(method: str, width: float) -> None:
    problem, y0 = plain(pulsed, 2, 37.0, width), [0.6, 0.8]
    sol = gi.solve(problem, y0, t_end=100.0, method=method, tolerance=1e-6, progress=False)

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], -y[0] + 20.0 / (1.0 + ((t - 37.0) / width) ** 2) ** 4]

    given: dict[str, Any] = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "max_step": 0.05}
    right = solve_ivp(rates, (0.0, 100.0), y0, **given).y[:, -1]
    assert np.abs(sol.y[-1] - right).max() < 1e-5 * np.abs(right).max()
    assert sol.accuracy is not None
    if "adaptive" in sol.method.name:  # steps of one length would have to be short everywhere
        assert method == "auto"
        assert "these vary" in sol.accuracy.reason
    else:
        assert (method, width) != ("auto", 0.1)
        assert sol.local_error is not None
        assert sol.local_error.total < 3e-6


@gi.field
def turned(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Angular velocities of a body that is pushed at a time, for a time."""
    s = (t - params[0]) / params[1]
    push = 1.0 / (1.0 + s * s)
    out[0] = params[2] * push * push * push * push
    out[1] = 0.3 * y[0]
    out[2] = 1.0 + 0.2 * y[1]


def test_auto_varies_steps_of_group_actions() -> None:
    action, pieces = gi.GroupAction(turned, gi.so3(1)), (("v", 3),)
    body = gi.Problem("turned", pieces, params=[37.0, 0.05, 30.0], action=action)
    given: dict[str, Any] = {"t_end": 60.0, "progress": False}
    right = gi.solve(body, [0.6, 0.0, 0.8], method="rkmk-dop853", step=0.001, **given).y[-1]
    sol = gi.solve(body, [0.6, 0.0, 0.8], method="auto", tolerance=1e-6, **given)
    assert sol.method.name == "rkmk-dop853-adaptive"
    assert np.abs(sol.y[-1] - right).max() < 1e-5
    assert sol.steps < 1000  # of one length that is short enough for the push there are more
    assert abs(np.linalg.norm(sol.y[-1]) - 1.0) < 1e-13


@gi.field
def rotation(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = 1.0 * y[1], -y[0]


@pytest.mark.parametrize(("method", "step"), [("gauss-8", 1.5), ("rk-4", 0.1), ("dop853", 0.4)])
def test_the_sum_goes_with_the_number_of_steps(method: str, step: float) -> None:
    """Where all steps err alike each counts, whether or not its own rank was taken."""
    problem, shares = gi.Problem("rotation", (("y", 2),), field=rotation), []
    for steps in (333, 5003):
        sol = gi.solve(problem, [1.0, 0.0], t_end=steps * step, step=step, method=method)
        assert sol.local_error is not None
        shares.append(sol.local_error.total / (steps * sol.local_error.largest))
    assert shares[0] == pytest.approx(shares[1], rel=0.03)
    assert 0.2 < shares[1] < 1.0
