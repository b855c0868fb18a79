"""Local errors: measured where steps err most; runs without a step begin anew where they are large."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.run.motions import APOCENTRE, KEPLER, REGULAR, TRAPS, promised, pulsed, second, turned

QUIET: dict[str, Any] = {"progress": False}
LATE = pytest.mark.nightly
SLOW = [case for case in TRAPS if case not in ("axis", "faster later", "lowest point, fast")]


@pytest.mark.parametrize(
    ("method", "system", "step"),
    [
        ("gauss-8", "sphere", 1.5),
        ("gauss-4", "henon-heiles", 0.7),
        ("rk-4", "lotka-volterra", 0.1),
        ("dop853", "henon-heiles", 0.5),
        ("heun-2", "lotka-volterra", 0.02),
        ("cf-4", "ball", 0.1),
        ("verlet-4", "sphere", 0.2),
        ("rattle-4", "sphere", 0.3),
        pytest.param("rkmk-4", "ball", 0.15, marks=LATE),
        pytest.param("cg-3", "ball", 0.05, marks=LATE),
    ],
)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_it_is_what_steps_err_by(method: str, system: str, step: float, sign: float) -> None:
    """Against every step once more, in eighths by the method of order 16."""
    problem, y0, _ = REGULAR[system]
    end = {f"{'tau' if problem.time == 'tau' else 't'}_end": sign * 150.4 * step}
    sol = gi.solve(problem, y0, **end, step=step, method=method, save_every=1, **QUIET)
    right = gi.Integrator(problem, y0, "gauss-8", step=step / 8.0)
    errors = []
    for time, before, after in zip(sol.tau[:-2], sol.y[:-2], sol.y[1:-1], strict=True):
        right.reset(before, time)
        right.h = sign * step / 8.0
        right.step(8)
        off = np.abs(after - right.state)
        errors.append(max(off[p].max() / np.abs(after[p]).max() for p in problem.slices.values()))
    found = sol.local_error
    assert found.step == pytest.approx(step)
    assert max(errors) / 30.0 < found.largest < 30.0 * max(errors)
    assert sum(errors) / 30.0 < found.total < 30.0 * sum(errors)
    near = [e for e, t in zip(errors, sol.tau, strict=False) if abs(t - found.time) <= 10.0 * step]
    assert max(near) > max(errors) / 30.0


@pytest.mark.parametrize(("method", "step"), [("gauss-8", 1.5), ("rk-4", 0.1), ("dop853", 0.4)])
def test_the_sum_goes_with_the_number_of_steps(method: str, step: float) -> None:
    """Where all steps err alike each counts, whether or not its own rank was taken."""
    shares, one = [], second("rotation", lambda p, t, y: -y[0], pieces=(("y", 2),))
    for steps in (333, 5003):
        sol = gi.solve(one, [1.0, 0.0], t_end=steps * step, step=step, method=method, **QUIET)
        shares.append(sol.local_error.total / (steps * sol.local_error.largest))
    assert shares[0] == pytest.approx(shares[1], rel=0.03)
    assert 0.2 < shares[1] < 1.0


def test_it_is_kept_and_the_run_is_not_disturbed(tmp_path: Path) -> None:
    problem, y0, _ = REGULAR["ball"]
    sol, other = (gi.solve(problem, y0, t_end=20.0, step=0.1, method="rk-4") for _ in range(2))
    error = sol.local_error
    assert error == sol.local_error
    sol.save(tmp_path / "run.nc")
    loaded = gi.load(tmp_path / "run.nc")
    assert loaded.local_error == error
    assert loaded.provenance["local_error"]["largest"] == error.largest
    on, alone = (gi.solve(s, t_end=30.0) for s in (sol, other))
    assert on.y.tobytes() == alone.y.tobytes()
    assert not gi.solve(problem, y0, t_end=1, method="dop853-adaptive", compiled=False).local_error


# --- runs without a step ----------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["gauss-8", "gauss-4", "rk-4", "dop853"])
@pytest.mark.parametrize("case", SLOW)
def test_a_step_that_is_not_given_follows_the_motion(case: str, method: str) -> None:
    """Silently wrong by a tenth to a million times before: the first state does not show the motion."""
    problem, y0, _ = TRAPS[case]
    end = {"middle axis": 40.0, "apocentre": 20.0}.get(case, TRAPS[case][2])
    sol = gi.solve(problem, y0, t_end=end, method=method, **QUIET)
    right = gi.solve(problem, y0, t_end=end, method=gi.Gauss(8), step=0.02, **QUIET).y[-1]
    bound = 1e-6 if "slow" in case else 1e-4
    for piece in problem.slices.values():
        assert np.abs(sol.y[-1] - right)[piece].max() <= bound * np.abs(right[piece]).max()


def pushed_once(p: Any, t: Any, y: Any) -> Any:
    z = (t - p[0]) / p[1]
    w = 1.0 / (1.0 + z * z)
    w = w * w * w * w
    return p[2] * w * w


def test_each_step_errs_by_what_is_promised() -> None:
    """Where a limit for steps that err alike was 40 times off: one step errs."""
    params = (11.31989709, 0.64322135, 0.82611992)
    y0, end, method = [0.0, 0.0], 15.0, "gauss-8"
    problem = second("looks", pushed_once, *params, pieces=(("y", 2),))
    sol = gi.solve(problem, y0, t_end=end, method=method, save_every=1, **QUIET)
    right, worst = gi.Integrator(problem, y0, "gauss-8", step=1.0), 0.0
    for k in range(len(sol.t) - 1):
        right.reset(sol.y[k], sol.t[k])
        right.h = (sol.t[k + 1] - sol.t[k]) / 64.0
        right.step(64)
        worst = max(worst, np.abs(sol.y[k + 1] - right.state).max() / np.abs(sol.y).max())
    assert worst < 12.0 * promised(sol.method)


def test_what_begins_with_it_is_that_of_the_last_run() -> None:
    """Of a callback, which sees one run, there is a warning instead."""
    given: dict[str, Any] = {"t_end": 20.0, "method": "rk-4", **QUIET}
    given |= {"t_eval": [5.0, 20.0], "events": ["y[1]"]}
    sol = gi.solve(KEPLER, APOCENTRE, **given)
    again = gi.solve(KEPLER, APOCENTRE, step=sol.step, **given)
    assert sol.y.tobytes() == again.y.tobytes()
    assert sol.steps == again.steps
    assert sol.events["y[1]"].t.tolist() == again.events["y[1]"].t.tolist()
    times: list[float] = []
    with pytest.warns(gi.GeomintWarning, match=r"steps of .* err by .* more than is promised"):
        gi.solve(KEPLER, APOCENTRE, **given, callback=lambda told: times.append(told.t))
    assert times == sorted(times)


@pytest.mark.parametrize("method", ["auto", "rk-4", "dop853"])
@pytest.mark.parametrize("width", [0.1, 0.4])
def test_a_tolerance_holds_where_something_comes_later(method: str, width: float) -> None:
    problem, y0 = pulsed(37.0, width, 0.0, 20.0), [0.6, 0.8]
    sol = gi.solve(problem, y0, t_end=100.0, method=method, tolerance=1e-6, **QUIET)
    right = gi.solve(problem, y0, t_end=100.0, method="gauss-8", step=0.01, **QUIET).y[-1]
    assert np.abs(sol.y[-1] - right).max() < 1e-5 * np.abs(right).max()
    if "adaptive" in sol.method.name:  # steps of one length would have to be short everywhere
        assert method == "auto"
        assert "these vary" in sol.accuracy.reason
    else:
        assert (method, width) != ("auto", 0.1)
        assert sol.local_error.total < 3e-6


def test_auto_varies_steps_of_group_actions() -> None:
    body = turned(37.0, 0.05, 30.0)
    given: dict[str, Any] = {"t_end": 60.0, **QUIET}
    right = gi.solve(body, [0.6, 0.0, 0.8], method="rkmk-dop853", step=0.001, **given).y[-1]
    sol = gi.solve(body, [0.6, 0.0, 0.8], method="auto", tolerance=1e-6, **given)
    assert sol.method.name == "rkmk-dop853-adaptive"
    assert np.abs(sol.y[-1] - right).max() < 1e-5
    assert sol.steps < 1000  # of one length that is short enough for the push there are more
    assert abs(np.linalg.norm(sol.y[-1]) - 1.0) < 1e-13
