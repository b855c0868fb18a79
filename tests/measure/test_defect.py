"""The defect of single steps, against the definition in many digits, and its order."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.measure.exact_maps import PROBLEMS, exact_defect
from tests.problems import spherical_pendulum

# Steps are as long as a test wants them.
pytestmark = pytest.mark.filterwarnings("ignore:steps of .* are so long:geomint.GeomintWarning")
NOISE = 2.0**-47  # of the scale of a drift


def observed(problem: gi.Problem, name: str, y0: Any, h: float, steps: int = 1, **options: Any):
    """The drift of the measure after some steps."""
    run = {"step": abs(h), "method": name, "observe": ["measure"], **options}
    sol = gi.solve(problem, y0, t_end=steps * h, **run)
    assert sol.steps == steps
    return sol.drift["measure"]


@gi.observable
def volume(params, t, y, work):
    """Lebesgue's measure."""
    return 0.0 * y[0]


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("name", "problem", "h"),
    [
        ("rk-4", "lotka-volterra", 0.1),  # a density that depends on time
        ("rk-4", "lotka-volterra", -0.1),
        ("rk-4", "spherical-pendulum", 1.1),  # off the manifold, normals that turn by a radian
        ("rk-4", "double-pendulum", 0.05),  # pieces of different sizes, four conditions
        ("gauss-3", "lotka-volterra", 0.3),
        pytest.param("gauss-2", "spherical-pendulum", 0.1, marks=pytest.mark.nightly),
        pytest.param("gauss-1-suzuki-4", "lotka-volterra", 0.1, marks=pytest.mark.nightly),
        ("cf-4", "pulsating-body", 0.2),
        ("rkmk-4", "pulsating-body", 0.2),
        ("rattle-2", "double-pendulum", 0.05),
        ("rattle-4", "spherical-pendulum", 0.1),
        pytest.param("lobatto-3", "spherical-pendulum", 0.1, marks=pytest.mark.nightly),
    ],
)
def test_defect_is_the_definition(name: str, problem: str, h: float) -> None:
    """To the noise that the instrument states, in plain Python."""
    p, y0 = PROBLEMS[problem]
    expected = exact_defect(p, name, 0.0, y0, h)
    drift = observed(p, name, y0, h, compiled=False)
    noise = drift.scale * NOISE
    assert abs(drift.final_error - expected) <= noise < 1e-12 + 1e-9 * abs(expected)
    assert (drift.initial, drift.max_rel_error) == (0.0, None)


@pytest.mark.nojit
def test_defects_are_summed() -> None:
    """From the states between steps and at their times; a last partial step counts."""
    p, y0 = PROBLEMS["lotka-volterra"]
    run = {"step": 0.1, "method": "rk-4", "observe": ["measure"], "save_every": 1}
    sol = gi.solve(p, y0, t_end=0.35, compiled=False, **run)
    lengths = (0.1, 0.1, 0.1, 0.05)
    parts = [exact_defect(p, "rk-4", 0.1 * k, sol.y[k], h) for k, h in enumerate(lengths)]
    drift = sol.drift["measure"]
    assert drift.final_error == pytest.approx(sum(parts), rel=1e-9)
    assert drift.windows.samples == 4
    assert abs(sum(parts)) > 2 * abs(parts[0])


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("rk-4", "spherical-pendulum"),
        ("cf-4", "pulsating-body"),
        pytest.param("gauss-2", "henon-heiles", marks=pytest.mark.nightly),
        pytest.param("rattle-2", "double-pendulum", marks=pytest.mark.nightly),
    ],
)
def test_compiled_is_plain(name: str, problem: str) -> None:
    """Bit for bit, over some steps that try other spacings."""
    p, y0 = PROBLEMS[problem]
    plain, fast = (observed(p, name, y0, 0.05, 3, compiled=c) for c in (False, True))
    assert fast == plain


@pytest.mark.parametrize(
    ("name", "problem", "order", "h"),
    [
        ("rk-4", "lotka-volterra", 4, 0.1),
        ("dormand-prince-5", "lotka-volterra", 5, 0.2),
        ("gauss-2", "lotka-volterra", 4, 0.2),
        ("rk-4", "spherical-pendulum", 4, 0.1),
        ("cf-4", "pulsating-body", 4, 0.2),
        ("cf-3", "pulsating-body", 3, 0.1),
        ("cf-1", "pulsating-body", 1, 0.01),
    ],
)
def test_order_of_the_defect(name: str, problem: str, order: int, h: float) -> None:
    """One step of a method of order p has a defect of order p + 1, on both sides."""
    p, y0 = PROBLEMS[problem]
    run = {"compiled": False}
    sizes = [abs(observed(p, name, y0, h * 2.0**-k, 1, **run).final_error) for k in range(5)]
    slopes = np.log2(sizes[:-1]) - np.log2(sizes[1:])
    above = np.array(sizes[1:]) > 1e-13
    assert above.sum() >= 2
    np.testing.assert_allclose(slopes[above][-2:], order + 1, atol=0.3)


@pytest.mark.parametrize("size", [1e-150, 1e-7, 1e5, 1e150])
def test_momenta_of_any_size(size: float) -> None:
    """Momenta, and time against them, scale without a change of the defects."""
    p = spherical_pendulum.problem(gravity=0.0)
    q, momentum = np.split(spherical_pendulum.INITIAL, 2)
    h, steps = 0.1, 20
    expected = observed(p, "rk-4", np.concatenate([q, momentum]), h, steps)
    found = observed(p, "rk-4", np.concatenate([q, size * momentum]), h / size, steps)
    assert abs(expected.final_error) > 1e-9
    assert abs(found.final_error - expected.final_error) <= expected.scale * NOISE
    assert found.scale == pytest.approx(expected.scale, rel=1.0)


def test_wrong_density_is_found() -> None:
    """The Lebesgue measure is not kept by predators and prey: a linear drift from the first step."""
    p, y0 = PROBLEMS["lotka-volterra"]
    lebesgue = dataclasses.replace(p, measure=gi.Measure(volume))
    found = [observed(x, "rk-4", y0, 0.01, 12, compiled=False) for x in (p, lebesgue)]
    assert found[0].max_abs_error < 1e-8 < 0.01 < found[1].max_abs_error


def test_pieces_that_begin_at_zero() -> None:
    """A pendulum that starts at the bottom, nearly, and one at rest."""

    @gi.field
    def pendulum(params, t, y, out, work):
        out[0] = y[1]
        out[1] = -gi.sin(y[0])

    pieces = (("q", 1), ("p", 1))
    p = gi.Problem("pendulum", pieces, field=pendulum, measure=gi.Measure(volume))
    for y0 in ([0.0, 1.2], [1e-20, 1.2], [0.0, 0.0]):
        drift = observed(p, "gauss-2", y0, 0.1, 2, compiled=False)
        assert drift.within_roundoff
        assert drift.scale * NOISE < 1e-12


@pytest.mark.nojit
def test_units_that_grow_do_not_count() -> None:
    """The momentum passes 1 on the way, where its unit doubles and the basis is made anew."""
    y0 = spherical_pendulum.INITIAL
    assert np.abs(y0[3:]).max() < 1.0
    drift = observed(spherical_pendulum.problem(3.0), "rattle-2", y0, 0.2, 8, compiled=False)
    assert drift.max_abs_error < 1e-12


@pytest.mark.nojit
def test_noise_is_that_of_increments() -> None:
    """A step adds hε/δ, not ε/δ: the carries of the nodes and of their ends count."""
    p, y0 = PROBLEMS["henon-heiles"]
    drift = observed(p, "rk-4", y0, 1e-3, 1, compiled=False)
    assert (drift.scale - 1.0) * NOISE < 1e-16


@pytest.mark.nojit
def test_other_conditions_of_the_same_manifold() -> None:
    """No polynomials; their unit, a power of two, is that of the initial state: for one of these
    their gradients pass it in the first step."""
    p, y0 = PROBLEMS["spherical-pendulum"]
    for k in range(11):
        factor = float(2.0 ** (0.1 * k))

        @gi.field
        def conditions(params, t, y, out, work, factor=factor):
            q2 = y[0] * y[0] + y[1] * y[1] + y[2] * y[2]
            out[0] = factor * 0.5 * gi.log(q2)
            out[1] = factor * (y[0] * y[3] + y[1] * y[4] + y[2] * y[5]) / gi.sqrt(q2)

        measure = gi.Measure(p.measure.log_density, conditions, 2)
        scaled, h = dataclasses.replace(p, measure=measure), 0.2 * (-1) ** k
        drift = observed(scaled, "rattle-2", y0, h, compiled=False)
        assert drift.max_abs_error <= drift.scale * NOISE < 1e-10
