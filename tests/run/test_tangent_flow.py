"""The derivative of every method's map, against differences of the map itself in many digits."""

from __future__ import annotations

from typing import Any

import mpmath as mp
import numpy as np
import pytest

import geomint as gi
from geomint.kernels.numbers.blocks import Block
from geomint.kernels.solve.status import OK
from geomint.methods.method import Start
from geomint.methods.stepper import Stepper
from geomint.run.carried_directions import CarriedDirections
from tests.families import PROBLEMS, differentiated

STEP, STEPS = 0.05, 3


def digits(numbers: Any) -> np.ndarray:
    return np.array([mp.mpf(float(v)) for v in np.ravel(numbers)], dtype=object)


def in_digits(stepper: Stepper, params: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return where the steps, and a cut one, lead in 50 digits: the same sources in plain Python."""
    functions = tuple(f.recorded for f in stepper.functions)
    work, kept = Block(digits(np.zeros(len(stepper.work)))), digits(np.zeros(len(stepper.memory)))
    kept[: len(y)] = y
    given = functions, Block(params), stepper.coefficients, stepper.fractions
    for t, h, steps in ((0.0, STEP, STEPS), (STEPS * STEP, 0.4 * STEP, 1)):
        kept[2 * stepper.rows :] = mp.mpf(0)
        memory = Block(kept)
        done = stepper.kernel.function(
            *given, memory, work, stepper.rows, t, h, 0, steps, steps + 1, memory, ()
        )
        assert done[0] == OK
    return kept[: stepper.rows]


SYSTEMS = [("hamiltonized-n3", "verlet-2"), ("ball-3d", "cf-4"), ("control-physical-n4", "gauss-2")]


@pytest.mark.nightly
@pytest.mark.parametrize(("scene", "name"), SYSTEMS)
@pytest.mark.filterwarnings("ignore::geomint.GeomintWarning")
def test_systems_to_rounding(scene: str, name: str) -> None:
    """Systems whose parameters are tables; they count with some of them, which do not move."""
    found = gi.load_scene(scene)
    p = found.problem
    check(p, p.canonical(found.state), name, p.params != np.round(p.params))


@differentiated
def test_to_rounding(name: str, problem: str) -> None:
    """Along states, off the manifold too, and parameters; the state is that of the run."""
    p, y0 = PROBLEMS[problem]
    check(p, p.canonical(y0), name)


def check(p: gi.Problem, y0: np.ndarray, name: str, moving: Any = True) -> None:
    rng, end = np.random.default_rng(4), (STEPS + 0.4) * STEP
    stop = {"tau_end" if p.time == "tau" else "t_end": end}
    clock = {"clock": False} if p.time == "tau" else {}
    run = gi.solve(p, y0, **stop, **clock, method=name, step=STEP)
    u, v = rng.normal(size=(p.rows, 3)), (rng.normal(size=(3, len(p.params))) * moving).T
    u[:, 1] = v[:, 2] = 0.0  # parameters alone; the state alone
    both = {"parameters": v} if len(v) else {}
    found = gi.tangent_flow(p, y0, **stop, method=name, step=STEP, directions=u, **both)
    np.testing.assert_allclose(found.y, run.y[-1], rtol=1e-15, atol=1e-15)
    by = 2.0 ** np.array([700, -700, 40])
    both = {name: w * by for name, w in both.items()}
    longer = gi.tangent_flow(p, y0, **stop, method=name, step=STEP, directions=by * u, **both)
    np.testing.assert_array_equal(longer.slopes / by, found.slopes)
    stepper = gi.find_method(name).start(Start(p, y0, 0.0, STEP))
    with mp.workdps(50):
        e = mp.mpf(10) ** -20
        for k in range(3):
            ends = []
            for s in (e, -e):
                params, y = (digits(x) + s * digits(w[:, k]) for x, w in ((p.params, v), (y0, u)))
                ends.append(in_digits(stepper, params, y))
            expected = ((ends[0] - ends[1]) / (2 * e)).astype(float)
            size = np.abs(found.slopes).max()
            np.testing.assert_allclose(found.slopes[:, k], expected, rtol=0, atol=1e-13 * size)


GROWN = ["gauss-3", "gauss-1-suzuki-4", "rattle-2", "rattle-4", "lobatto-3", "lobatto-8"]


@pytest.mark.parametrize("name", GROWN)
def test_slopes_may_grow(name: str) -> None:
    """Where they are much larger than the state the state is solved for as it was before."""
    p, y0 = PROBLEMS["double-pendulum" if name[0] in "rl" else "henon-heiles"]
    stepper = gi.find_method(name).start(Start(p, p.canonical(y0), 0.0, 0.1))
    y, slopes = [], []
    for grown in (1.0, 2.0**40, 2.0**500):
        carried = CarriedDirections(stepper, np.eye(p.rows))
        for group in carried._groups:
            group.memory[:, 1:] *= grown
        carried.take(0.0, 0.1, 5)
        y.append(carried.state)
        slopes.append(carried.slopes / grown)
    for k in (1, 2):
        np.testing.assert_allclose(y[k], y[0], rtol=0.0, atol=1e-14)
        size = np.abs(slopes[0]).max()
        np.testing.assert_allclose(slopes[k], slopes[0], rtol=0.0, atol=1e-13 * size)


J = np.kron([[0.0, 1.0], [-1.0, 0.0]], np.eye(2))


@pytest.mark.parametrize("name", ["gauss-1", "gauss-3", "gauss-8", "gauss-12", "gauss-1-suzuki-4"])
@pytest.mark.parametrize("step", [0.05, 0.6])
@pytest.mark.parametrize("size", [1.0, 0.0, 1e-150])
def test_symplectic_to_rounding(name: str, step: float, size: float) -> None:
    """Of converged equations: at the equilibrium the values need no iteration, and slopes do."""
    p, y0 = PROBLEMS["henon-heiles"]
    y0 = size * np.asarray(y0)
    D = gi.tangent_flow(p, y0, t_end=20 * step, method=name, step=step).slopes
    assert np.abs(D.T @ J @ D - J).max() < 2e-14 * np.abs(D).max() ** 2
    assert np.abs(D - np.eye(4)).max() > 0.1


@pytest.mark.parametrize("base", [gi.Gauss(4), gi.Compose(gi.Gauss(1), "suzuki-4")])
def test_tolerances_do_not_matter(base: gi.Method) -> None:
    p, y0 = PROBLEMS["henon-heiles"]
    coarse = (
        gi.Gauss(4, iteration_tolerance=1e-6)
        if isinstance(base, gi.Gauss)
        else gi.Compose(gi.Gauss(1, iteration_tolerance=1e-6), "suzuki-4")
    )
    exact, found = (gi.tangent_flow(p, y0, t_end=2.0, method=m, step=0.2) for m in (base, coarse))
    np.testing.assert_array_equal(found.slopes, exact.slopes)


def test_not_symplectic() -> None:
    p, y0 = PROBLEMS["henon-heiles"]
    D = gi.tangent_flow(p, y0, t_end=4.0, method="rk-4", step=0.2).slopes
    assert np.abs(D.T @ J @ D - J).max() > 1e-5


def test_directions() -> None:
    """More than eight, given ones, one; backwards and from rest."""
    p = gi.load_scene("hamiltonized-n5").problem
    y0 = p.random_state(0)
    assert p.rows > 8
    whole = gi.tangent_flow(p, y0, tau_end=-0.3, step=0.1, method="rk-4")
    some = gi.tangent_flow(
        p, y0, tau_end=-0.3, step=0.1, method="rk-4", directions=np.eye(p.rows)[:, 3:5]
    )
    np.testing.assert_array_equal(some.slopes, whole.slopes[:, 3:5])
    rest = gi.tangent_flow(*PROBLEMS["neumann-at-rest"], t_end=0.5, method="gauss-4", step=0.1)
    assert np.isfinite(rest.slopes).all()


@gi.field
def swing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = y[1]
    out[1] = -y[0]


SWING = gi.Problem("swing", (("q", 1), ("p", 1)), field=swing)


@pytest.mark.parametrize("size", [0.0, 1e-310, 1e-160, 1e-150, 1.0, 1e150, 1e300])
@pytest.mark.parametrize("name", ["rk-4", "dop853", "gauss-2", "gauss-8"])
def test_lengths_of_directions_do_not_matter(name: str, size: float) -> None:
    """To the last bit, with states of any size: units are exact powers of two."""
    lengths = 2.0 ** np.array([-900, -52, 0, 300, 1010])
    given = np.repeat([[1.0], [0.7]], len(lengths), axis=1)
    p, y0 = SWING, np.array([size, 0.3 * size])
    once = gi.tangent_flow(p, y0, t_end=2.0, method=name, step=0.25, directions=given[:, :1])
    found = gi.tangent_flow(p, y0, t_end=2.0, method=name, step=0.25, directions=given * lengths)
    np.testing.assert_array_equal(found.slopes / lengths, np.repeat(once.slopes, 5, axis=1))


@gi.field
def still(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = 0.0 * y[0]


def test_wrong_input() -> None:
    p, y0 = PROBLEMS["henon-heiles"]
    tau = gi.load_scene("hamiltonized-n3").problem
    usual = {"problem": p, "y0": y0, "t_end": 1.0, "step": 0.1}
    fixed = gi.Gauss(8, iteration="fixed-point")
    for given, kind, said in (
        ({"problem": 3}, gi.DomainError, "a geomint.Problem"),
        ({"method": "exact"}, gi.MethodError, "no steps of a given length"),
        ({"problem": tau, "y0": tau.random_state(0)}, gi.DomainError, "moves with the state"),
        ({"directions": np.eye(3)}, gi.DomainError, "4 rows"),
        ({"directions": np.ones(4)}, gi.DomainError, "4 rows"),
        ({"directions": "x"}, gi.DomainError, "directions"),
        ({"directions": np.full((4, 1), np.nan)}, gi.DomainError, "directions"),
        ({"t0": "x"}, gi.DomainError, "t0"),
        ({"step": 50.0, "t_end": 100.0, "method": fixed}, gi.StepError, "too large"),
    ):
        with pytest.raises(kind, match=said):
            gi.tangent_flow(**{**usual, **given})
    free = gi.Problem("free", (("x", 1),), field=still)
    with pytest.raises(gi.DomainError, match="no parameters"):
        gi.tangent_flow(free, [1.0], t_end=1.0, step=0.1, parameters=np.eye(1))
    p, y0 = PROBLEMS["neumann"]
    count, usual = len(p.params), {"problem": p, "y0": y0, "t_end": 1.0, "step": 0.1}
    for given, said in (
        ({"parameters": np.eye(count - 1)}, f"{count} rows"),
        ({"parameters": np.ones(count)}, f"{count} rows"),
        ({"parameters": np.ones((count, 2)), "directions": np.eye(p.rows)}, "as many as"),
    ):
        with pytest.raises(gi.DomainError, match=said):
            gi.tangent_flow(**{**usual, **given})


@gi.field
def growing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0] = params[0] * y[0]


@pytest.mark.parametrize("name", ["rk-4", "gauss-4"])
def test_derivatives_that_overflow(name: str) -> None:
    """A state at rest stays a number when what is next to it does not: no run succeeds with NaN."""
    problem = gi.Problem("growing", (("x", 1),), [1.0], field=growing)
    with pytest.raises(gi.NonFiniteError) as failed:
        gi.tangent_flow(problem, [0.0], t_end=1000.0, method=name, step=0.5)
    assert failed.value.t == pytest.approx(709.0, abs=10.0)
    motion = gi.Integrator(problem, [0.0], name, step=0.5, tangents=1)
    with pytest.raises(gi.NonFiniteError) as stopped:
        motion.step(2000)
    assert motion.steps == stopped.value.step == failed.value.step
    assert np.isfinite(motion.tangents).all()
    assert motion.tangents > 1e300
