"""Lyapunov exponents: against the derivative of the run, against SciPy, regular and chaotic motions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geomint as gi
from geomint.methods.carried import sizes_of_pieces
from geomint.problems.derivatives import slopes_of
from geomint.problems.testproblems import henon_heiles
from geomint.run.growing import Growing
from tests.families import PROBLEMS, differentiated

STEP = 0.05
CHAOTIC = np.array([0.0, -0.25, 0.42081, 0.0])  # energy 0.125 and more: most motions are chaotic


def until(p: gi.Problem, end: float) -> dict[str, float]:
    return {"tau_end" if p.time == "tau" else "t_end": end}


def tangents(p: gi.Problem, y: np.ndarray, scales: np.ndarray, count: int) -> np.ndarray:
    """Some directions at y, orthonormal in those units, tangent to the manifold of the measure."""
    v = np.random.default_rng(5).normal(size=(p.rows, count)) / scales
    if p.measure is not None and p.measure.manifold is not None:
        C = slopes_of(p, p.measure.manifold, y, 0.0, p.measure.conditions) * scales[:, 0]
        v -= np.linalg.pinv(C) @ (C @ v)
    return scales * np.linalg.qr(v)[0]


@differentiated
def test_growth_is_that_of_the_derivative(name: str, problem: str) -> None:
    """log R_kk of DΦ, a cut last step included; both vectors of the alignment index."""
    p, y0 = PROBLEMS[problem]
    y0, end = p.canonical(y0), 60.4 * STEP
    scales = sizes_of_pieces(p, y0)[:, None]
    v = tangents(p, y0, scales, 2)
    flow = gi.tangent_flow(p, y0, **until(p, end), method=name, step=STEP, directions=v)
    found = gi.lyapunov(p, y0, **until(p, end), method=name, step=STEP, directions=v)
    np.testing.assert_allclose(found.y, flow.y, rtol=0, atol=1e-12 * np.abs(y0).max())
    expected = np.sort(np.log(np.abs(np.diag(np.linalg.qr(flow.slopes / scales)[1]))))[::-1]
    atol = 1e-8 if p.measure is not None else 1e-9  # methods that leave the manifold are projected
    if name in ("rk-4", "dop853"):
        atol = 1e-4
    np.testing.assert_allclose(found.exponents * found.t[-1], expected, rtol=0, atol=atol)
    ends = flow.slopes / scales
    ends /= np.linalg.norm(ends, axis=0)
    index = min(np.linalg.norm(ends[:, 0] - s * ends[:, 1]) for s in (1, -1))
    assert found.sali is not None
    assert found.sali[-1] == pytest.approx(index, abs=atol)


@pytest.mark.parametrize("name", ["gauss-4", "gauss-8"])
def test_stages_are_turned_with_the_directions(name: str) -> None:
    """What a step begins its iteration with fits the directions that it carries, or it takes longer."""
    p, y0 = henon_heiles.problem(), CHAOTIC
    plain = gi.solve(p, y0, t_end=50.0, method=name, step=0.1)
    found = gi.lyapunov(p, y0, t_end=50.0, method=name, step=0.1)
    assert plain.iterations < found.iterations < 1.2 * plain.iterations


def test_against_scipy() -> None:
    """The variational equations of Hénon and Heiles, written out, by another code."""

    def both(t: float, z: np.ndarray) -> np.ndarray:
        x, y, u, w = z[:4]
        force = [-x - 2 * x * y, -y - x * x + y * y]
        K = np.array([[-1 - 2 * y, -2 * x], [-2 * x, -1 + 2 * y]])
        J = np.block([[np.zeros((2, 2)), np.eye(2)], [K, np.zeros((2, 2))]])
        return np.concatenate([[u, w], force, (J @ z[4:].reshape(4, 4)).ravel()])

    end, start = 30.0, np.concatenate([CHAOTIC, np.eye(4).ravel()])
    sol = solve_ivp(both, (0.0, end), start, method="DOP853", rtol=1e-13, atol=1e-14)
    R = np.linalg.qr(sol.y[4:, -1].reshape(4, 4))[1]
    scales = sizes_of_pieces(henon_heiles.problem(), CHAOTIC)[:, None]
    R = np.linalg.qr(sol.y[4:, -1].reshape(4, 4) * scales.T / scales)[1]
    found = gi.lyapunov(
        henon_heiles.problem(), CHAOTIC, t_end=end, method="gauss-8", step=0.1,
        directions=np.diag(scales[:, 0]),
    )  # fmt: skip
    expected = np.sort(np.log(np.abs(np.diag(R))))[::-1]
    np.testing.assert_allclose(found.exponents * end, expected, atol=1e-6)


def test_chaos() -> None:
    """At energy 1/6 the largest exponent is 0.13; the spectrum is symmetric, its sum 0."""
    y0 = CHAOTIC.copy()
    y0[2] = np.sqrt(2.0 * (1.0 / 6.0 - 0.5 * 0.0625 - 0.25**3 / 3.0))
    found = gi.lyapunov(henon_heiles.problem(), y0, t_end=20_000.0, method="gauss-8", step=0.4)
    largest, error = found.exponents[0], found.errors[0]
    assert abs(largest - 0.13) <= 3.0 * error
    assert error < 0.01
    assert abs(found.exponents.sum()) < 1e-12
    np.testing.assert_allclose(found.exponents, -found.exponents[::-1], atol=1e-3)
    assert found.sali is not None
    assert found.sali[found.t > 1000.0].max() < 1e-20


@pytest.mark.parametrize("end", [1000.0, -1000.0, 10_000.0])
def test_tori(end: float) -> None:
    """On tori exponents fall like ln t / t, and are no larger than their errors allow."""
    scene = gi.load_scene("hamiltonized-n3")
    found = gi.lyapunov(scene.problem, scene.state, tau_end=end, method="gauss-8", step=0.2)
    assert found.exponents.shape == (4,)
    t = np.abs(end)
    assert (np.abs(found.exponents) < 3.0 * np.log(t) / t).all()
    assert (np.abs(found.exponents) <= 3.0 * found.errors).all()
    assert found.sali is not None
    assert found.sali[-1] > 1e-3


def test_some_of_them() -> None:
    """The first directions do not know of the others."""
    p = henon_heiles.problem()
    run = {"t_end": 50.0, "method": "rk-4", "step": 0.05}
    v = np.random.default_rng(0).normal(size=(4, 4))
    every = gi.lyapunov(p, CHAOTIC, **run, directions=v)
    first = gi.lyapunov(p, CHAOTIC, **run, directions=v[:, :1])
    np.testing.assert_allclose(first.exponents, every.exponents[:1], rtol=1e-11)
    assert first.sali is None
    assert gi.lyapunov(p, CHAOTIC, **run, count=3).exponents.shape == (3,)
    assert "0.1" in repr(first) or "exponents" in repr(first)


@pytest.mark.nightly
def test_many_directions() -> None:
    """Two passes of directions: as the derivative of the run has them."""
    scene = gi.load_scene("rolling-ball-n4")
    p, y0 = scene.problem, scene.state
    found = gi.lyapunov(p, y0, t_end=2.0, method="gauss-4", step=0.1)
    assert len(found.exponents) > 8
    keys = {"t_end": 2.0, "method": "gauss-4", "step": 0.1}
    v = np.random.default_rng(20101).normal(size=(p.rows, len(found.exponents)))
    again = gi.lyapunov(p, y0, **keys, directions=v)
    np.testing.assert_array_equal(again.exponents, found.exponents)


@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_many_directions_of_a_chaotic_motion() -> None:
    """Passes of directions stay on one motion, however far rounding would part them."""
    scene = gi.load_scene("control-momentum-n4")
    found = gi.lyapunov(scene.problem, scene.state, t_end=4000.0, method="gauss-8", step=0.25)
    assert len(found.exponents) == 9
    assert found.verdict == "chaotic"
    assert abs(found.exponents.sum()) < 1e-3  # volumes are kept
    assert found.exponents[0] + found.exponents[-1] == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("end", [0.003, 0.05, 0.0501, 0.1, -0.07])
def test_short_runs(end: float) -> None:
    """A part of a step, one step, one and a part, two, backwards."""
    p = henon_heiles.problem()
    found = gi.lyapunov(p, CHAOTIC, t_end=end, method="rk-4", step=0.05)
    assert found.t[-1] == pytest.approx(abs(end))
    flow = gi.tangent_flow(p, CHAOTIC, t_end=end, method="rk-4", step=0.05)
    np.testing.assert_allclose(found.y, flow.y, rtol=1e-14)
    volume = np.log(abs(np.linalg.det(flow.slopes)))
    assert found.exponents.sum() * abs(end) == pytest.approx(volume, abs=1e-13)
    assert np.isinf(found.errors).all()  # of so little none is known
    assert found.verdict == "undecided"


def test_verdicts() -> None:
    """By how much the first direction has grown; no verdict before there is enough."""
    p = henon_heiles.problem()
    run = {"method": "rk-4", "step": 0.1}
    assert gi.lyapunov(p, CHAOTIC, t_end=3000.0, **run).verdict == "chaotic"
    assert gi.lyapunov(p, CHAOTIC, t_end=20.0, **run).verdict == "undecided"
    regular = np.array([0.0, 0.1, 0.3, 0.0])
    for count in (None, 1):
        assert gi.lyapunov(p, regular, t_end=3000.0, **run, count=count).verdict == "regular"


def test_what_there_is_after_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    """And after Ctrl-C: all up to there."""

    @gi.field
    def blowing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = y[0] * y[0]

    p = gi.Problem("blowing up", (("x", 1),), field=blowing)
    with pytest.raises(gi.NonFiniteError) as failed:
        gi.lyapunov(p, [1.0], t_end=2.0, method="rk-4", step=0.01)
    partial = failed.value.partial
    assert partial.status == "failed"
    assert 0.5 < partial.t[-1] < 1.1
    early = partial.t < 0.9
    np.testing.assert_allclose(  # x = 1/(1 − t), ∂x/∂x₀ = (1 − t)⁻²
        partial.running[early, 0] * partial.t[early], -2 * np.log(1 - partial.t[early]), rtol=1e-4
    )
    counted = iter(range(100))

    def interrupted(self: Any, done: float) -> None:
        if next(counted) == 20:
            raise KeyboardInterrupt

    monkeypatch.setattr("geomint.run.progress.Progress.update", interrupted)
    found = gi.lyapunov(henon_heiles.problem(), CHAOTIC, t_end=3000.0, method="rk-4", step=0.1)
    assert found.status == "interrupted"
    assert 0 < len(found.t) < 60
    assert found.exponents.shape == (4,)
    counted = iter([20])  # a step of 10⁻⁶: long before directions have to be orthonormal
    found = gi.lyapunov(henon_heiles.problem(), CHAOTIC, t_end=0.2, method="rk-4", step=1e-6)
    assert 0 < found.steps < 50_000


@gi.field
def stretching(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    for i in range(3):
        out[i] = params[i] * y[i] + 0.1 * gi.sin(t)


@pytest.mark.parametrize("rates", [[0.1, 0.5, -0.2], [-0.2, 0.1, 0.5], [0.3, 0.3, 0.3]])
def test_exponents_fall(rates: list[float]) -> None:
    """In whatever order directions are; samples, errors and files with them, and after a failure."""
    p = gi.Problem("stretching", tuple((x, 1) for x in "xyz"), np.array(rates), field=stretching)
    run = {"method": "rk-4", "step": 0.05, "t_end": 40.0}
    found = gi.lyapunov(p, np.ones(3), **run, directions=np.eye(3))
    np.testing.assert_allclose(found.exponents, sorted(rates, reverse=True), atol=1e-6)
    assert (np.diff(found.exponents) <= 0.0).all()
    np.testing.assert_array_equal(found.running[-1], found.exponents)
    order = np.argsort(rates)[::-1]
    alone = [gi.lyapunov(p, np.ones(3), **run, directions=np.eye(3)[:, k : k + 1]) for k in order]
    np.testing.assert_allclose(found.errors, [one.errors[0] for one in alone], rtol=1e-3)


def abrupt(of: str) -> Any:
    @gi.field
    def field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = 1.0 * y[1]
        if of == "slope":
            out[1] = -1.0 * y[0] + gi.sqrt(abs(y[1]))
        else:
            out[1] = -1.0 / y[0]

    return gi.Problem(of, (("x", 1), ("v", 1)), field=field)


@pytest.mark.parametrize("method", ["rk-4", "gauss-4"])
@pytest.mark.parametrize(
    ("of", "y0", "said"),
    [
        ("slope", [1.0, 0.0], "derivative cannot"),
        ("rate", [0.0, 1.0], "gives no number at the state"),
    ],
)
def test_what_no_step_can_do_is_not_the_step_s_fault(
    of: str, y0: list[float], said: str, method: str
) -> None:
    """Where there is no derivative, and where the field itself is no number."""
    run = {"t_end": 1.0, "method": method, "step": 0.01}
    for follow in (gi.lyapunov, gi.tangent_flow):
        with pytest.raises(gi.NonFiniteError, match=said):
            follow(abrupt(of), y0, **run)
    motion = gi.Integrator(abrupt(of), y0, method, step=0.01, tangents=2)
    with pytest.raises(gi.NonFiniteError, match=said):
        motion.step()
    if of == "rate":
        with pytest.raises(gi.NonFiniteError, match=said):
            gi.solve(abrupt(of), y0, **run)


def test_in_a_file(tmp_path: Path) -> None:
    p = henon_heiles.problem()
    for count, names in ((2, "t,lambda_1,lambda_2,sali"), (1, "t,lambda_1")):
        found = gi.lyapunov(p, CHAOTIC, t_end=30.0, method="rk-4", step=0.1, count=count)
        found.save(tmp_path / "chaos.csv")
        text = (tmp_path / "chaos.csv").read_text("utf-8").splitlines()
        assert text[0] == names
        rows = np.array([line.split(",") for line in text[1:]], float)
        np.testing.assert_array_equal(rows[:, 0], found.t)
        np.testing.assert_array_equal(rows[:, 1 : 1 + count], found.running)


@gi.field
def oscillator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = params[0] * y[1]
    out[1] = -params[0] * y[0]


@pytest.mark.parametrize(("omega", "step"), [(1.0, 0.2), (0.0, 0.1), (1e4, 2e-5)])
def test_errors_cover_rounding(omega: float, step: float) -> None:
    """Growth of exactly nothing: what rounding makes of it has one sign for long."""
    of = gi.Problem(name="oscillator", pieces=(("y", 2),), field=oscillator, params=[omega])
    found = gi.lyapunov(of, [1.0, 0.0], t_end=20_000 * step, step=step)
    assert (np.abs(found.exponents) < 4.0 * found.errors).all()
    assert (found.errors < 1e-14 / step).all()
    assert found.verdict != "chaotic"


def test_at_rest() -> None:
    """A pendulum at its lower and at its upper equilibrium: 0, and ±1."""

    @gi.field
    def pendulum(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = y[1]
        out[1] = -gi.sin(y[0])

    p = gi.Problem("pendulum", (("q", 1), ("p", 1)), field=pendulum)
    run = {"t_end": 200.0, "method": "gauss-8", "step": 0.25}
    below = gi.lyapunov(p, [0.0, 0.0], **run)
    assert (np.abs(below.exponents) < 0.02).all()
    above = gi.lyapunov(p, [np.pi, 0.0], **{**run, "t_end": 20.0})
    np.testing.assert_allclose(above.exponents, [1.0, -1.0], atol=0.1)
    volume = gi.Problem("pendulum", p.pieces, field=pendulum, measure=gi.Measure())
    for y0 in ([np.pi, 0.0], [np.pi, 1e-30], [1e-200, 1e-100], [0.0, 0.0]):
        drift = gi.solve(volume, y0, t_end=20.0, method="gauss-8", step=0.25, observe=["measure"])
        assert drift.drift["measure"].within_roundoff


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"count": 0}, "count"),
        ({"count": 5}, "count"),
        ({"count": 2, "directions": np.eye(4)}, "beside directions"),
        ({"directions": np.ones(4)}, "directions"),
        ({"directions": np.full((4, 1), np.nan)}, "directions"),
        ({"directions": np.zeros((4, 5))}, "at most 4"),
        ({"method": "dop853-adaptive"}, "method"),
        ({"t_end": 0.0}, "t_end"),
    ],
)
def test_wrong_arguments(wrong: dict[str, Any], said: str) -> None:
    run = {"t_end": 5.0, "method": "rk-4", "step": 0.05, **wrong}
    with pytest.raises(gi.GeomintError, match=said):
        gi.lyapunov(henon_heiles.problem(), CHAOTIC, **run)


TOO_LONG = gi.Gauss(2, iteration="fixed-point")


def test_a_step_that_is_too_large() -> None:
    with pytest.raises(gi.ConvergenceError, match="t = "):
        gi.lyapunov(henon_heiles.problem(), CHAOTIC, t_end=50.0, method=TOO_LONG, step=12.0)


def test_a_picture() -> None:
    """Exponents on logarithmic axes, the index below; one direction has one panel."""
    p = henon_heiles.problem()
    found = gi.lyapunov(p, CHAOTIC, t_end=100.0, method="rk-4", step=0.05)
    figure = found.plot()
    first, second = figure.axes
    assert (first.get_xscale(), first.get_yscale(), second.get_yscale()) == ("log",) * 3
    assert len(first.lines) == 5
    one = gi.lyapunov(p, CHAOTIC, t_end=100.0, method="rk-4", step=0.05, count=1).plot()
    assert len(one.axes) == 1
    step = gi.lyapunov(p, CHAOTIC, t_end=0.05, method="rk-4", step=0.05).plot()
    assert {line.get_marker() for axes in step.axes for line in axes.lines[:4]} == {"."}
    assert "." not in {line.get_marker() for axes in figure.axes for line in axes.lines}


def test_directions_that_tell_nothing() -> None:
    """Zero, dependent, across the manifold: none is replaced by one that nobody gave."""
    p, run = henon_heiles.problem(), {"t_end": 20.0, "method": "rk-4", "step": 0.1}
    e = np.eye(4)
    for wrong in (
        np.zeros((4, 1)),
        np.ones((4, 2)),
        np.column_stack((e[0], np.zeros(4))),
        np.column_stack((e[0], e[1], e[0] - 3.0 * e[1])),
    ):
        with pytest.raises(gi.DomainError, match="independent along the manifold"):
            gi.lyapunov(p, CHAOTIC, **run, directions=wrong)
    scene = gi.load_scene("hamiltonized-n3")
    gamma = scene.problem.canonical(scene.state)[:3]
    across = np.append(gamma, np.zeros(3))[:, None]
    with pytest.raises(gi.DomainError, match="independent along the manifold"):
        gi.lyapunov(scene.problem, scene.state, tau_end=1.0, step=0.1, directions=across)


@gi.field
def shrinking(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = -y[0], -2.0 * y[1]


@pytest.mark.parametrize("sizes", [(1e-300, 1e-300), (1e300, 1e-300), (1e-300, 1.0), (0.0, 1e-300)])
def test_units_of_states(sizes: tuple[float, float]) -> None:
    """Pieces of any size: directions are those of numbers in their own units."""
    problem = gi.Problem("shrinking", (("x", 1), ("v", 1)), field=shrinking)
    run = {"t_end": 20.0, "step": 0.1, "method": "gauss-4"}
    found = gi.lyapunov(problem, sizes, **run, directions=np.eye(2))
    np.testing.assert_allclose(found.exponents, [-1.0, -2.0], rtol=1e-4)
    random = gi.lyapunov(problem, sizes, **run)
    np.testing.assert_allclose(random.exponents.sum(), -3.0, rtol=1e-4)


@gi.field
def saddle(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1], out[2] = params[0] * y[1], y[0] / params[0], -y[2]


@pytest.mark.parametrize("ratio", [1e-8, 1.0, 1e8, 1e100])
@pytest.mark.parametrize("third", [0.0, 1.0])
def test_units_at_an_equilibrium(ratio: float, third: float) -> None:
    """Where pieces are 0 and stay so, their units are those in which they move each other alike."""
    pieces = (("q", 1), ("p", 1), ("s", 1))
    problem = gi.Problem("saddle", pieces, [ratio], field=saddle, measure=gi.Measure())
    run = {"t_end": 20.0, "step": 0.1, "method": "gauss-4"}
    directions = np.array([[ratio, 1.0, 0.0], [ratio, -1.0, 0.0], [0.0, 0.0, 1.0]]).T
    found = gi.lyapunov(problem, [0.0, 0.0, third], **run, directions=directions)
    np.testing.assert_allclose(found.exponents, [1.0, -1.0, -1.0], rtol=1e-9)
    random = gi.lyapunov(problem, [0.0, 0.0, third], **run)
    np.testing.assert_allclose(random.exponents.sum(), -1.0, rtol=1e-9)
    drift = gi.solve(problem, [0.0, 0.0, third], **run, observe=["measure"]).drift["measure"]
    np.testing.assert_allclose(drift.final_error, -20.0, rtol=1e-12)


@pytest.mark.parametrize("size", [1e-310, 1e-200, 1e200, 1e308])
def test_the_length_of_a_direction_does_not_matter(size: float) -> None:
    p, run = henon_heiles.problem(), {"t_end": 20.0, "method": "rk-4", "step": 0.1}
    found = gi.lyapunov(p, CHAOTIC, **run, directions=size * np.eye(4)[:, :2])
    expected = gi.lyapunov(p, CHAOTIC, **run, directions=np.eye(4)[:, :2])
    np.testing.assert_allclose(found.exponents, expected.exponents, rtol=1e-12)


def test_interrupted_at_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Nothing has been found, and that can be shown, drawn, saved and reported."""

    def pressed(self: Growing, steps: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Growing, "take", pressed)
    found = gi.lyapunov(henon_heiles.problem(), CHAOTIC, t_end=10.0, step=0.1)
    assert (found.status, found.verdict, len(found.t)) == ("interrupted", "undecided", 0)
    found.plot()
    found.save(tmp_path / "none.csv")
    assert gi.chaos_report("sphere-n3", tmp_path / "report").status == "interrupted"
    assert (tmp_path / "report" / "chaos.html").exists()


def test_wrong_switches_and_folders() -> None:
    with pytest.raises(gi.DomainError, match="progress"):
        gi.lyapunov(henon_heiles.problem(), CHAOTIC, t_end=1.0, step=0.1, progress="x")
    for report in (gi.chaos_report, gi.drift_report):
        for out in (None, 3, b"x", ""):
            with pytest.raises(gi.GeomintError, match="the path of a file or folder"):
                report("sphere-n3", out)
