"""Lyapunov exponents: against the derivative of the run, known rates, regular and chaotic motions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles, neumann
from tests.families import PROBLEMS, pairs
from tests.run.motions import solve

STEP = 0.05
HENON = henon_heiles.problem()
CHAOTIC = np.array([0.0, -0.25, 0.42081, 0.0])  # energy 0.125 and more: most motions are chaotic
REGULAR = np.array([0.0, 0.1, 0.3, 0.0])
SPHERE, ON_SPHERE = neumann.problem(), neumann.initial()  # integrable, four dimensions of six
RK = {"method": "rk-4", "step": STEP}
GAUSS = {"method": "gauss-8", "step": 0.1}


def tangents(p: gi.Problem, y: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """Directions at y, orthonormal in those units, tangent to the manifold of the measure."""
    m = 0 if p.measure is None else p.measure.conditions
    v = np.random.default_rng(5).normal(size=(p.rows, min(p.rows - m, 4))) / scales
    if m:
        C = np.array([gi.gradient(p, name, y) for name in p.constraints.values()]) * scales[:, 0]
        v -= np.linalg.pinv(C) @ (C @ v)
    return scales * np.linalg.qr(v)[0]


MEASURED = [("rk-4", "henon-heiles"), ("gauss-8", "moving")]
LATE = [("dop853", "sphere-metric"), ("rk-4", "lotka-volterra"), ("rattle-2", "moving")]
LATE += [("rkmk-4", "pulsating-body"), ("rattle-2", "sphere-metric"), ("verlet-2", "moving")]
LATE += [("lobatto-3", "moving"), ("verlet-4", "abc-flow"), ("cf-4", "pulsating-body")]


@pairs(MEASURED + LATE, MEASURED)
def test_growth_is_that_of_the_derivative(name: str, problem: str) -> None:
    """log R_kk of DΦ, a cut last step included; both vectors of the alignment index."""
    p, y0 = {**PROBLEMS, "moving": (SPHERE, ON_SPHERE)}[problem]
    y0, step = p.canonical(y0), STEP / 4.0  # directions are made orthonormal after several
    scales = np.ones((p.rows, 1))  # the units of directions are the sizes of pieces
    for rows in p.slices.values():
        scales[rows] = np.linalg.norm(y0[rows])
    v = tangents(p, y0, scales)
    run = {"t_end": 241.4 * step, "method": name, "step": step, "directions": v}
    flow, found = gi.tangent_flow(p, y0, **run), gi.lyapunov(p, y0, **run)
    np.testing.assert_allclose(found.y, flow.y, rtol=0, atol=1e-12 * np.abs(y0).max())
    ends = flow.slopes / scales
    expected = np.sort(np.log(np.abs(np.diag(np.linalg.qr(ends)[1]))))[::-1]
    atol = 1e-8 if p.measure is not None else 1e-9  # methods that leave the manifold are projected
    if name in ("rk-4", "dop853"):
        atol = 1e-4
    np.testing.assert_allclose(found.exponents * found.t[-1], expected, rtol=0, atol=atol)
    ends /= np.linalg.norm(ends, axis=0)
    index = min(np.linalg.norm(ends[:, 0] - s * ends[:, 1]) for s in (1, -1))
    assert found.sali[-1] == pytest.approx(index, abs=atol)


def test_stages_are_turned_with_the_directions() -> None:
    """What a step begins its iteration with fits the directions that it carries, or it takes longer."""
    plain = gi.solve(SPHERE, ON_SPHERE, t_end=50.0, **GAUSS)
    found = gi.lyapunov(SPHERE, ON_SPHERE, t_end=50.0, **GAUSS)
    assert plain.iterations < found.iterations < 1.2 * plain.iterations


def test_chaos() -> None:
    """At energy 1/6 the largest exponent is 0.13; the spectrum is symmetric, its sum 0."""
    y0 = CHAOTIC.copy()
    y0[2] = np.sqrt(2.0 * (1.0 / 6.0 - 0.5 * 0.0625 - 0.25**3 / 3.0))
    found = gi.lyapunov(HENON, y0, t_end=20_000.0, **RK)
    assert abs(found.exponents[0] - 0.13) <= 3.0 * found.errors[0] < 0.03
    assert abs(found.exponents.sum()) < 1e-6
    np.testing.assert_allclose(found.exponents, -found.exponents[::-1], atol=1e-3)
    assert found.sali[found.t > 1000.0].max() < 1e-20
    assert found.verdict == "chaotic"


@pytest.mark.parametrize("end", [1000.0, -1000.0, pytest.param(1e4, marks=pytest.mark.nightly)])
def test_tori(end: float) -> None:
    """On tori exponents fall like ln t / t, and are no larger than their errors allow."""
    found = gi.lyapunov(SPHERE, ON_SPHERE, t_end=end, method="gauss-8", step=0.2)
    assert found.exponents.shape == (4,)
    t = np.abs(end)
    assert (np.abs(found.exponents) < 3.0 * np.log(t) / t).all()
    assert (np.abs(found.exponents) <= 3.0 * found.errors).all()
    assert found.sali[-1] > 1e-3
    assert found.verdict == "regular"


def test_some_of_them() -> None:
    """The first directions do not know of the others; there is no verdict of little."""
    v = np.random.default_rng(0).normal(size=(4, 4))
    every = gi.lyapunov(HENON, CHAOTIC, **RK, t_end=50.0, directions=v)
    first = gi.lyapunov(HENON, CHAOTIC, **RK, t_end=50.0, directions=v[:, :1])
    np.testing.assert_allclose(first.exponents, every.exponents[:1], rtol=1e-11)
    assert (first.sali, first.verdict) == (None, "undecided")
    assert gi.lyapunov(HENON, CHAOTIC, **RK, t_end=50.0, count=3).exponents.shape == (3,)
    assert "exponents" in repr(first)
    assert gi.lyapunov(HENON, REGULAR, **RK, t_end=2000.0, count=1).verdict == "regular"


@gi.field
def chain(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Five points between walls, with springs of third order: ergodic at high energies."""
    left = 1.0 * y[0]
    for i in range(5):
        right = (y[i + 1] if i < 4 else 0.0 * y[i]) - y[i]
        out[i] = 1.0 * y[5 + i]
        out[5 + i] = right + right * right * right - left - left * left * left
        left = 1.0 * right


def test_many_directions_of_a_chaotic_motion() -> None:
    """Passes of directions stay on one motion, however far rounding would part them."""
    many = gi.Problem("chain", (("q", 5), ("p", 5)), field=chain)
    y0 = np.append(np.zeros(5), [3.0, -2.0, 1.0, 2.0, -3.0])
    found = gi.lyapunov(many, y0, t_end=1000.0, **GAUSS)
    assert len(found.exponents) == 10
    assert found.verdict == "chaotic"
    assert abs(found.exponents.sum()) < 1e-10  # volumes are kept
    np.testing.assert_allclose(found.exponents, -found.exponents[::-1], atol=0.01)


@pytest.mark.parametrize("end", [0.003, 0.05, 0.0501, 0.1, -0.07])
def test_short_runs(end: float) -> None:
    """A part of a step, one step, one and a part, two, backwards."""
    found = gi.lyapunov(HENON, CHAOTIC, t_end=end, **RK)
    assert found.t[-1] == pytest.approx(abs(end))
    flow = gi.tangent_flow(HENON, CHAOTIC, t_end=end, **RK)
    np.testing.assert_allclose(found.y, flow.y, rtol=1e-14)
    volume = np.log(abs(np.linalg.det(flow.slopes)))
    assert found.exponents.sum() * abs(end) == pytest.approx(volume, abs=1e-13)
    assert np.isinf(found.errors).all()  # of so little none is known
    assert found.verdict == "undecided"


def interrupt(monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    """Press Ctrl-C where progress is shown for the so-manieth time, and then always."""
    counted = iter(range(after))

    def pressed(self: Any, done: float) -> None:
        if next(counted, None) is None:
            raise KeyboardInterrupt

    monkeypatch.setattr("geomint.run.progress.Progress.update", pressed)


def test_what_there_is_after_a_failure_and_ctrl_c(monkeypatch: pytest.MonkeyPatch) -> None:
    """All up to there, in falling order."""
    with pytest.raises(gi.NonFiniteError) as failed:  # it leaves the well, and gets to infinity
        gi.lyapunov(HENON, [0.0, 1.2, 1.0, 1.5], t_end=50.0, **RK)
    partial = failed.value.partial
    assert partial.status == "failed"
    assert 1.0 < partial.t[-1] <= failed.value.t
    assert (np.diff(partial.running[-1]) <= 0.0).all()
    early = partial.t < 1.0  # of which rk-4 keeps volumes
    assert early.sum() > 5
    np.testing.assert_allclose(partial.running[early].sum(axis=1), 0.0, atol=1e-5)
    interrupt(monkeypatch, 20)
    found = gi.lyapunov(HENON, CHAOTIC, t_end=3000.0, **RK)
    assert found.status == "interrupted"
    assert 0 < len(found.t) < 60
    assert found.exponents.shape == (4,)
    interrupt(monkeypatch, 1)  # steps of 10⁻⁶: long before directions have to be orthonormal
    found = gi.lyapunov(HENON, CHAOTIC, t_end=0.2, method="rk-4", step=1e-6)
    assert 0 < found.steps < 50_000


@pytest.mark.usefixtures("blank_pictures")
def test_interrupted_at_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Nothing has been found, and that can be drawn and saved."""
    interrupt(monkeypatch, 0)
    found = gi.lyapunov(HENON, CHAOTIC, t_end=10.0, **RK)
    assert (found.status, found.verdict, len(found.t)) == ("interrupted", "undecided", 0)
    found.plot()
    found.save(tmp_path / "none.csv")


@gi.field
def linear(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = params[0] * y[0] + params[1] * y[1], params[2] * y[0] + params[3] * y[1]
    for i in range(2, len(y)):
        out[i] = params[4] * y[i]


def of_rates(*rates: float, beside: int = 8) -> gi.Problem:
    """Return a linear motion of a plane and of a vector beside it, of the size of the chain."""
    pieces = (("q", 1), ("p", 1), ("s", beside))
    return gi.Problem("linear", pieces, np.array(rates), field=linear, measure=gi.Measure())


@pytest.mark.parametrize(
    ("rates", "sizes"),
    [
        *(([0.1, 0.5, -0.2], (1.0, 1.0)), ([-0.2, 0.1, 0.5], (1e-300, 1e-300))),
        *(([-1.0, -2.0, -3.0], (1e300, 1e-300)), ([0.1, 0.5, -0.2], (0.0, 1e-300))),
    ],
)
def test_exponents_fall(rates: list[float], sizes: tuple[float, float]) -> None:
    """In whatever order directions are, which are numbers in units of their pieces, of any size."""
    p, y0 = of_rates(rates[0], 0.0, 0.0, *rates[1:]), (*sizes, 1.0, *[0.0] * 7)
    found = gi.lyapunov(p, y0, t_end=20.0, **GAUSS, directions=np.eye(10))
    expected = sorted([*rates, *[rates[2]] * 7], reverse=True)
    np.testing.assert_allclose(found.exponents, expected, rtol=1e-4)
    np.testing.assert_array_equal(found.running[-1], found.exponents)
    random = gi.lyapunov(p, y0, t_end=20.0, **GAUSS)
    np.testing.assert_allclose(random.exponents.sum(), sum(expected), atol=1e-4)


NEWTON = pytest.param(100.0, 0.2, marks=pytest.mark.nightly)  # steps too long for iterations


@pytest.mark.parametrize(("omega", "step"), [(1.0, 0.2), (0.0, 0.1), (1e4, 2e-5), NEWTON])
def test_errors_cover_rounding(omega: float, step: float) -> None:
    """Growth of exactly nothing: what rounding makes of it has one sign for long."""
    p, run = of_rates(0.0, omega, -omega, 0.0, 0.0), {"method": "gauss-8", "step": step}
    found = gi.lyapunov(p, np.eye(10)[0], t_end=20_000 * step, count=5, **run)
    assert (np.abs(found.exponents) < 4.0 * found.errors).all()
    assert (found.errors < 1e-14 / step).all()
    assert found.verdict != "chaotic"


@pytest.mark.parametrize("ratio", [1e-8, 1.0, 1e8, 1e100])
@pytest.mark.parametrize("third", [0.0, 1.0])
def test_units_at_an_equilibrium(ratio: float, third: float) -> None:
    """Where pieces are 0 and stay so, their units are those in which they move each other alike."""
    p, y0 = of_rates(0.0, ratio, 1.0 / ratio, 0.0, -1.0), [0.0, 0.0, third, *[0.0] * 7]
    run = {"t_end": 20.0, **GAUSS}
    directions = np.eye(10)
    directions[:2, :2] = [[ratio, ratio], [1.0, -1.0]]
    found = gi.lyapunov(p, y0, **run, directions=directions)
    np.testing.assert_allclose(found.exponents, [1.0, *[-1.0] * 9], rtol=1e-9)
    random = gi.lyapunov(p, y0, **run)
    np.testing.assert_allclose(random.exponents.sum(), -8.0, rtol=1e-9)
    few = of_rates(0.0, ratio, 1.0 / ratio, 0.0, -1.0, beside=1)
    drift = solve(few, y0[:3], **{**run, "t_end": 0.5}, observe=["measure"]).drift["measure"]
    np.testing.assert_allclose(drift.final_error, -0.5, rtol=1e-12)


def test_at_rest() -> None:
    """The bottom of the well, and the saddle at its rim; nothing of a volume is lost beside one."""
    below = gi.lyapunov(HENON, np.zeros(4), t_end=200.0, **RK)
    assert (np.abs(below.exponents) < 0.02).all()
    rim = gi.lyapunov(HENON, [0.0, 1.0, 0.0, 0.0], t_end=40.0, **RK)
    np.testing.assert_allclose(rim.exponents, [1.0, 0.0, 0.0, -1.0], atol=0.1)
    saddle = of_rates(0.0, 1.0, 1.0, 0.0, 0.0, beside=1)
    for y0 in ([0.0, 1e-30, 1.0], [1e-200, 1e-100, 0.0], [0.0, 0.0, 0.0]):
        run = solve(saddle, y0, t_end=8.0, method="gauss-8", step=1.0, observe=["measure"])
        assert run.drift["measure"].within_roundoff


@gi.field
def abrupt(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Has no derivative from t = 1 on, and none at rest; no number at 0, and where there is no run."""
    rate = gi.sqrt(gi.select(t > 1.0, 0.0 * y[0], 1.0 + 0.0 * y[0]))
    out[0] = y[1] * rate + 0.0 * gi.sqrt((t + 0.01) * (1.41 - t))
    out[1], out[2], out[3] = gi.sqrt(abs(y[1])) - 1.0 / y[0], 0.0 * y[2], 0.0 * y[3]


ABRUPT = gi.Problem("abrupt", (("x", 1), ("v", 1), ("c", 2)), field=abrupt)


def test_what_no_step_can_do_is_not_the_step_s_fault() -> None:
    """Where there is no derivative, and where the field itself is no number."""
    for y0, said in zip(np.eye(4)[:2], ("derivative cannot", "gives no number at"), strict=True):
        for each in [gi.lyapunov, gi.tangent_flow] + [gi.solve] * int(y0[1]):
            with pytest.raises(gi.NonFiniteError, match=said):
                each(ABRUPT, y0, t_end=1.0, **RK)
        motion = gi.Integrator(ABRUPT, y0, **RK, tangents=2)
        with pytest.raises(gi.NonFiniteError, match=said):
            motion.step()


def test_what_no_step_can_do_later() -> None:
    """The steps are tried again at their own times."""
    with pytest.raises(gi.NonFiniteError, match="derivative cannot") as caught:
        gi.lyapunov(ABRUPT, np.ones(4), t_end=1.4, method="rk-4", step=0.1)
    assert (pytest.approx(caught.value.t), caught.value.step) == (1.0, 10)


def test_files_and_pictures(tmp_path: Path) -> None:
    """Exponents on logarithmic axes, the index below; one direction has one panel."""
    for count, names in ((2, "t,lambda_1,lambda_2,sali"), (1, "t,lambda_1")):
        found = gi.lyapunov(HENON, CHAOTIC, t_end=30.0, **RK, count=count)
        found.save(tmp_path / "chaos.csv")
        text = (tmp_path / "chaos.csv").read_text("utf-8").splitlines()
        assert text[0] == names
        rows = np.array([line.split(",") for line in text[1:]], float)
        np.testing.assert_array_equal(rows[:, 0], found.t)
        np.testing.assert_array_equal(rows[:, 1 : 1 + count], found.running)
        figure = found.plot()
        assert len(figure.axes) == count
        assert all((axes.get_xscale(), axes.get_yscale()) == ("log",) * 2 for axes in figure.axes)
        assert len(figure.axes[0].lines) == count + 1
        assert "." not in {line.get_marker() for axes in figure.axes for line in axes.lines}
    step = gi.lyapunov(HENON, CHAOTIC, t_end=STEP, **RK).plot()
    assert {line.get_marker() for axes in step.axes for line in axes.lines[:4]} == {"."}


def test_wrong_arguments() -> None:
    for wrong, said in (
        ({"count": 5}, "count"),
        ({"count": 2, "directions": np.eye(4)}, "beside directions"),
        ({"directions": np.full((4, 1), np.nan)}, "directions"),
        ({"directions": np.zeros((4, 5))}, "at most 4"),
        ({"method": "dop853-adaptive"}, "method"),
        ({"t_end": 0.0}, "t_end"),
    ):
        with pytest.raises(gi.GeomintError, match=said):
            gi.lyapunov(HENON, CHAOTIC, **{"t_end": 5.0, **RK, **wrong})


def test_directions_that_tell_nothing() -> None:
    """Zero, dependent, across the manifold: none is replaced by one that nobody gave."""
    e, none = np.eye(4), np.zeros(4)
    across = np.append(ON_SPHERE[:3], np.zeros(3))
    for problem, y0, wrong in (
        (HENON, CHAOTIC, [none]),
        (HENON, CHAOTIC, [e[0] + e[1], e[0] + e[1]]),
        (HENON, CHAOTIC, [e[0], none]),
        (HENON, CHAOTIC, [e[0], e[1], e[0] - 3.0 * e[1]]),
        (SPHERE, ON_SPHERE, [across]),
    ):
        with pytest.raises(gi.DomainError, match="independent along the manifold"):
            gi.lyapunov(problem, y0, t_end=20.0, **GAUSS, directions=np.array(wrong).T)
