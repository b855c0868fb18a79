"""The derivative of every method's map, against differences of the map itself."""

from __future__ import annotations

import numpy as np
import pytest
from families import FAMILIES, PROBLEMS

import geomint as gi
from geomint.methods import find_method

STEP, STEPS = 0.05, 7
FIXED = [
    pytest.param(name, problem, id=f"{name}-{problem}")
    for name, problem in FAMILIES
    if not find_method(name).adaptive
]


def ends(p: gi.Problem, y: np.ndarray, name: str, end: float) -> np.ndarray:
    stop = {"tau_end" if p.time == "tau" else "t_end": end}
    clock = {"clock": False} if p.time == "tau" else {}
    run = gi.solve(p, y, **stop, **clock, method=name, step=STEP, progress=False)
    return run.y[-1]


@pytest.mark.parametrize(("name", "problem"), FIXED)
def test_differences_of_the_map(name: str, problem: str) -> None:
    """Along curves on the manifold; the state is that of the run, to a rounding; a last step is cut."""
    p, y0 = PROBLEMS[problem]
    y0, rng = p.canonical(y0), np.random.default_rng(4)
    end = (STEPS + 0.4) * STEP
    stop = {"tau_end" if p.time == "tau" else "t_end": end}
    found = gi.tangent_flow(p, y0, **stop, method=name, step=STEP)
    np.testing.assert_allclose(found.y, ends(p, y0, name, end), rtol=1e-15, atol=1e-15)
    assert found.slopes.shape == (p.rows, p.rows)
    for _ in range(3):
        v = rng.normal(size=p.rows)
        v /= np.abs(v).max() / max(np.abs(y0).max(), 1.0)

        def difference(e: float, of, v=v) -> np.ndarray:
            points = [near(p, y0, s * e * v) for s in (1, -1)]
            return (of(points[0]) - of(points[1])) / (2 * e)

        def slope(of, difference=difference) -> np.ndarray:
            fine, coarse = difference(5e-4, of), difference(1e-3, of)
            return (4 * fine - coarse) / 3

        expected = slope(lambda y: ends(p, y, name, end))
        direction = slope(lambda y: y)
        size = np.abs(expected).max()
        np.testing.assert_allclose(found.slopes @ direction, expected, rtol=0, atol=1e-8 * size)


def near(p: gi.Problem, y: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return a state of the manifold near y, in a direction like v."""
    return y + v if p.space is None else p.space.retract(y, p.space.tangent(y, v))


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
        gi.Gauss(4, tolerance=1e-6)
        if isinstance(base, gi.Gauss)
        else gi.Compose(gi.Gauss(1, tolerance=1e-6), "suzuki-4")
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


def test_wrong_input() -> None:
    p, y0 = PROBLEMS["henon-heiles"]
    tau = gi.load_scene("hamiltonized-n3").problem
    usual = {"problem": p, "y0": y0, "t_end": 1.0, "step": 0.1}
    for given, kind, said in (
        ({"problem": 3}, gi.DomainError, "a geomint.Problem"),
        ({"method": "dop853-adaptive"}, gi.MethodError, "no steps of a given length"),
        ({"method": "exact"}, gi.MethodError, "no steps of a given length"),
        ({"problem": tau, "y0": tau.random_state(0)}, gi.DomainError, "moves with the state"),
        ({"directions": np.eye(3)}, gi.DomainError, "4 rows"),
        ({"directions": np.ones(4)}, gi.DomainError, "4 rows"),
        ({"directions": "x"}, gi.DomainError, "directions"),
        ({"directions": np.full((4, 1), np.nan)}, gi.DomainError, "directions"),
        ({"t_end": 0.0}, gi.DomainError, "t_end"),
        ({"t0": "x"}, gi.DomainError, "t0"),
        ({"step": 50.0, "t_end": 100.0, "method": "gauss-8"}, gi.StepError, "too large"),
    ):
        with pytest.raises(kind, match=said):
            gi.tangent_flow(**{**usual, **given})
