"""Draws from the invariant measure: against distributions that are known exactly."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from scipy import stats

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles

SIGNIFICANT = 1e-3  # at fixed seeds: a right test fails in one of a thousand choices of these
COUNT = 300


STILL = gi.field(lambda params, t, y, out, work: None)  # draws do not ask for the motion


def level(rows: int, *energies: Any) -> gi.Problem:
    """Return a problem with these invariants, the flat measure, and a parameter of 400."""
    names = ("energy", "first", "again")
    invariants = {name: gi.observable(f) for name, f in zip(names, energies, strict=False)}
    pieces, measure = (("q", rows), ("p", rows)), gi.Measure()
    return gi.Problem(
        "level", pieces, params=[400.0], field=STILL, invariants=invariants, measure=measure
    )


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * (y[2] * y[2] + y[3] * y[3] + params[0] * y[0] * y[0] + y[1] * y[1])


OSCILLATORS = level(
    2,
    lambda params, t, y, work: energy(params, t, y, work),
    lambda params, t, y, work: 0.5 * (y[2] * y[2] + params[0] * y[0] * y[0]),
    lambda params, t, y, work: 1.0 + energy(params, t, y, work),
)
QUARTIC = level(1, lambda params, t, y, work: 0.5 * y[1] * y[1] + 0.25 * (y[0] * y[0]) ** 2)
WELLS = level(
    1, lambda params, t, y, work: 0.5 * (y[1] * y[1] - y[0] * y[0]) + 0.25 * (y[0] * y[0]) ** 2
)
TILTED = level(
    1,
    lambda params, t, y, work: (
        0.5 * (0.6 * y[0] + 0.8 * y[1]) ** 2 + 0.5 * params[0] * (0.6 * y[1] - 0.8 * y[0]) ** 2
    ),
)
BENT = level(1, lambda params, t, y, work: 0.5 * (y[0] * y[0] + (y[1] - y[0] * y[0]) ** 2))
FREE = level(1, lambda params, t, y, work: 0.5 * y[1] * y[1])
SPHERE = ch.ChaplyginSphere(a=[1.0] * 5, D=4.0).hamiltonized()
ANGLES = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 20_001)


def turned(y: Any, x: Any) -> Any:
    return np.arctan2(y, x) / (2.0 * np.pi) + 0.5


def timed(q: Any, places: Any, rate: Any) -> Any:
    """Return the part of the time from one end to the other that the motion has taken to q."""
    time = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(ANGLES))
    return np.interp(q, places, np.append(0.0, time) / time[-1])


def of_quartic(y: Any) -> list[Any]:
    """Of ½p² + ¼q⁴ = E the time between 0 and q is an integral of 1/p: far from the arc's length."""
    s = np.sin(ANGLES)  # q = s end; no root at the ends in it
    end = 16.0**0.25
    return [timed(y[:, 0], end * s, 1.0 / np.sqrt(1.0 + s * s))]


def of_wells(y: Any) -> list[Any]:
    """A level with a waist, where projections from one side may find the other."""
    root = np.sqrt(1.0 + 0.4)  # 2 p² = (1 + root − q²)(q² + root − 1)
    q = np.sqrt(1.0 + root) * np.sin(ANGLES)
    return [timed(y[:, 0], q, 1.0 / np.sqrt(q * q + root - 1.0))]


def of_oscillators(y: Any) -> list[Any]:
    """The energy of one of two is uniform, whatever their frequencies: the flow's measure, no area."""
    part = 0.5 * (y[:, 2] ** 2 + 400.0 * y[:, 0] ** 2)
    whole = part + 0.5 * (y[:, 3] ** 2 + y[:, 1] ** 2)
    np.testing.assert_allclose(whole, whole[0], rtol=1e-10)
    return [part / whole[0], turned(y[:, 2], 20.0 * y[:, 0])]


UNIFORM: dict[str, Any] = {
    "a closed orbit, as long as the motion stays": (QUARTIC, {"keep": {"energy": 4.0}}, of_quartic),
    "two wells": (WELLS, {"keep": {"energy": 0.1}}, of_wells),
    "a level of energy": (OSCILLATORS, {"keep": {"energy": 0.5}}, of_oscillators),
    "where chains begin is forgotten": (
        OSCILLATORS,
        {"at": [0.01, 0.3, 0.4, -0.2]},
        of_oscillators,
    ),
    "a torus": (
        OSCILLATORS,
        {"keep": {"energy": 0.5, "first": 0.1}},
        lambda y: [turned(y[:, 2], 20.0 * y[:, 0]), turned(y[:, 3], y[:, 1])],
    ),
    "a narrow level across the numbers": (
        TILTED,
        {"at": [0.6, 0.8]},
        lambda y: [turned(20.0 * (y @ [-0.8, 0.6]), y @ [0.6, 0.8])],
    ),
    # A circle in (u, y − u²), of the same areas: normals there meet other parts of it.
    "a bent level": (BENT, {"at": [0.0, 1.0]}, lambda y: [turned(y[:, 1] - y[:, 0] ** 2, y[:, 0])]),
    # Equal moments: γ₁ has the marginal of a uniform direction.
    "another dimension": (
        SPHERE,
        {"keep": {"energy": 0.5}, "seed": 5},
        lambda y: [stats.beta(2.0, 2.0).cdf(0.5 + 0.5 * y[:, k]) for k in range(2)],
    ),
}


@pytest.mark.parametrize("what", UNIFORM)
def test_draws_are_uniform_by_the_measure_of_the_flow(what: str) -> None:
    problem, given, parts = UNIFORM[what]
    for part in parts(gi.draw_states(problem, COUNT, **given)):
        assert stats.kstest(part, "uniform").pvalue > SIGNIFICANT


@pytest.mark.parametrize("theta", [0.3, 1e-12])
def test_a_temperature(theta: float) -> None:
    """Coordinates are normal, with the variances of the equipartition of energy."""
    variances = theta * np.array([1.0 / 400.0, 1.0, 1.0, 1.0])
    near = None if theta > 0.1 else np.sqrt(variances)  # the problem has no random states
    states = gi.draw_states(OSCILLATORS, COUNT, temperature=theta, at=near)
    for numbers in (states / np.sqrt(variances)).T:
        assert stats.kstest(numbers, "norm").pvalue > SIGNIFICANT


def test_of_the_reduced_sphere_the_multiplier_is_the_density() -> None:
    """γ by quadrature over the sphere; without the multiplier the same test says no.

    The density of γ comes, up to a factor, from the Gaussian integral over tangent momenta.
    """
    problem, theta = ch.ChaplyginSphere(a=[0.3, 1.0, 2.5], D=3.0).reduced(), 0.5
    found = gi.draw_states(problem, 2 * COUNT, temperature=theta)[:, 0] ** 2
    steps = np.arange(120) + 0.5
    z, turn = 1.0 - steps / 60.0, np.pi * (1.0 + np.sqrt(5.0)) * steps
    flat = np.sqrt(1.0 - z * z)
    gammas = np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])  # evenly spread
    weights = np.zeros((2, len(gammas)))
    for k, gamma in enumerate(gammas):
        u = np.linalg.svd(gamma[None, :])[2][1:]
        a, b, c = (gi.value(problem, "energy", [*gamma, *e]) for e in (*u, u[0] + u[1]))
        plain = 1.0 / np.sqrt(4.0 * a * b - (c - a - b) ** 2)
        log = gi.value(problem, problem.measure.log_density, [*gamma, *u[0]])
        weights[:, k] = np.exp(log) * plain, plain
    off = abs(found.mean() - weights @ gammas[:, 0] ** 2 / weights.sum(axis=1))
    error = found.std() / np.sqrt(len(found))
    assert off[0] < 3.5 * error
    assert off[1] > 4.0 * error


LATE = ["hamiltonized-n5", "clebsch-n4", "veselova-n4"]


@pytest.mark.usefixtures("short_chains")
@pytest.mark.parametrize(
    "name",
    ["ball-3d", "ball-on-group-n4", *(pytest.param(n, marks=pytest.mark.nightly) for n in LATE)],
)
def test_of_every_kind_of_state(name: str) -> None:
    """Draws are admissible states with the energy, all different; the seed decides."""
    scene = gi.load_scene(name)
    states, again, other = (
        gi.draw_states(scene.problem, 8, at=scene.state, seed=seed) for seed in (0, 0, 1)
    )
    assert np.array_equal(states, again)
    wanted = gi.value(scene.problem, "energy", scene.state)
    for y in states:
        assert gi.value(scene.problem, "energy", y) == pytest.approx(wanted, rel=1e-9)
        assert np.allclose(scene.problem.canonical(y), y, atol=1e-12)
    assert len({tuple(y) for y in (*states, *other)}) == 16


def test_a_temperature_that_chains_do_not_come_to_is_told() -> None:
    """Energies in units of it are large, their squares too large for numbers: no success of that."""
    with pytest.warns(gi.GeomintWarning, match="depend on where chains began"):
        gi.draw_states(OSCILLATORS, 9, temperature=1e-200)


def test_a_level_without_bounds_is_told() -> None:
    """A free particle may be anywhere."""
    with pytest.warns(gi.GeomintWarning, match="'q'.*no bounds"):
        gi.draw_states(FREE, 8, keep={"energy": 0.5}, at=[0.0, 1.0])


def test_a_bounded_part_is_not_left_for_an_unbounded_one() -> None:
    """Hénon–Heiles below the saddles: in two dimensions q is uniform where the potential is below."""
    energy = 0.16  # of 1/6
    problem = henon_heiles.problem()
    states = gi.draw_states(problem, COUNT, at=[0.0, 0.0, np.sqrt(2.0 * energy), 0.0])
    x, y = states[:, 0], states[:, 1]
    assert np.all((y >= -0.5) & (y + np.sqrt(3.0) * np.abs(x) <= 1.0))
    rng = np.random.default_rng(3)
    q = rng.uniform([-1.0, -0.5], [1.0, 1.0], size=(200_000, 2))
    u, v = q.T
    potential = 0.5 * (u * u + v * v) + u * u * v - v**3 / 3.0
    q = q[(v + np.sqrt(3.0) * np.abs(u) <= 1.0) & (potential <= energy)]
    for seen, known in ((x, q[:, 0]), (y, q[:, 1]), (x * x + y * y, (q * q).sum(axis=1))):
        assert stats.ks_2samp(seen, known).pvalue > SIGNIFICANT


BALL = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
CONSTRAINT = r"keep = 'norm': expected no constraint"


@pytest.mark.parametrize(
    ("problem", "given", "said"),
    [
        (OSCILLATORS, {}, "at="),
        (OSCILLATORS, {"keep": []}, "infinite"),
        (OSCILLATORS, {"keep": {"enrgy": 1.0}}, "energy"),
        (OSCILLATORS, {"keep": {"energy": np.nan}}, "energy"),
        (OSCILLATORS, {"keep": {"energy": -1.0}}, "keep"),
        (OSCILLATORS, {"keep": {"energy": 1.0, "again": 2.0}}, "depend"),
        (OSCILLATORS, {"keep": 7}, "names"),
        (OSCILLATORS, {"temperature": 0.0}, "temperature"),
        (OSCILLATORS, {"temperature": "warm"}, "temperature"),
        (OSCILLATORS, {"temperature": 1.0, "keep": {"energy": 1.0}}, "energy is kept"),
        (OSCILLATORS, {"keep": {"energy": 1.0}, "seed": -1}, "seed"),
        (OSCILLATORS, {"keep": {"energy": 1.0}, "at": [1.0]}, "state"),
        (OSCILLATORS, {"keep": {"energy": 1.0}, "count": 0}, "count"),
        (dataclasses.replace(OSCILLATORS, measure=None), {"keep": {"energy": 1.0}}, "measure"),
        (7, {}, "problem"),
        (BALL, {"at": BALL.random_state(1), "keep": ["energy", "norm"]}, CONSTRAINT),
        (BALL, {"temperature": 0.1, "keep": {"norm": 0.0}}, CONSTRAINT),
    ],
)
def test_what_makes_no_sense(problem: Any, given: dict[str, Any], said: str) -> None:
    with pytest.raises(gi.DomainError, match=said):
        gi.draw_states(problem, **{"count": 3, **given})


@pytest.mark.usefixtures("short_chains")
def test_what_is_zero_but_for_rounding_can_be_kept() -> None:
    """A ball without momentum about the vertical: (k, γ) is 1e-17 there, not 0."""
    scene = gi.load_scene("ball-3d")
    problem, state = scene.model.problems["classical"], scene.model.states["classical"].copy()
    gamma = state[3:]
    for momentum in np.eye(3):
        state[:3] = momentum - gamma * (momentum @ gamma) / (gamma @ gamma)
        if gi.value(problem, "area", state) != 0.0:
            break
    assert 0.0 < abs(gi.value(problem, "area", state)) < 1e-15
    states = gi.draw_states(problem, 9, at=state, keep=["energy", "area"])
    assert max(abs(gi.value(problem, "area", y)) for y in states) < 1e-11
