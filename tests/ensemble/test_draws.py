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
from geomint.run import chains
from geomint.run.level import kept_values

SIGNIFICANT = 1e-3  # at fixed seeds: a right test fails in one of a thousand choices of these
COUNT = 600


@gi.field
def oscillators(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = y[2], y[3]
    out[2], out[3] = -params[0] * y[0], -y[1]


@gi.observable
def energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * (y[2] * y[2] + y[3] * y[3] + params[0] * y[0] * y[0] + y[1] * y[1])


@gi.observable
def first(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * (y[2] * y[2] + params[0] * y[0] * y[0])


@gi.observable
def nonsense(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 1.0 + energy(params, t, y, work)


OSCILLATORS = gi.Problem(
    "oscillators",
    pieces=(("q", 2), ("p", 2)),
    params=[400.0],
    field=oscillators,
    invariants={"energy": energy, "first": first, "again": nonsense},
    measure=gi.Measure(),
)


@gi.field
def quartic(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = y[1], -y[0] * y[0] * y[0]


@gi.observable
def quartic_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * y[1] * y[1] + 0.25 * y[0] * y[0] * y[0] * y[0]


QUARTIC = gi.Problem(
    "quartic",
    pieces=(("q", 1), ("p", 1)),
    field=quartic,
    invariants={"energy": quartic_energy},
    measure=gi.Measure(),
)


def test_one_closed_orbit_is_drawn_as_long_as_the_motion_stays() -> None:
    """Of ½p² + ¼q⁴ = E the time between 0 and q is an integral of 1/p: far from the arc's length."""
    energy = 4.0
    states = gi.draw_states(QUARTIC, 2000, keep={"energy": energy})
    end = (4.0 * energy) ** 0.25
    s = np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2001))  # q = s end; no root at the ends in it
    rate = 1.0 / np.sqrt(1.0 + s * s)
    angle = np.arcsin(s)
    time = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(angle))])
    part = np.interp(states[:, 0] / end, s, time / time[-1])
    assert stats.kstest(part, "uniform").pvalue > SIGNIFICANT
    assert abs((states[:, 1] > 0.0).mean() - 0.5) < 0.03


@gi.field
def wells(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    out[0], out[1] = y[1], y[0] - y[0] * y[0] * y[0]


@gi.observable
def wells_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    return 0.5 * y[1] * y[1] - 0.5 * y[0] * y[0] + 0.25 * y[0] * y[0] * y[0] * y[0]


WELLS = dataclasses.replace(QUARTIC, name="wells", field=wells, invariants={"energy": wells_energy})


def test_about_two_wells() -> None:
    """A level with a waist, where projections from one side may find the other."""
    energy = 0.1
    states = gi.draw_states(WELLS, COUNT, keep={"energy": energy})
    root = np.sqrt(1.0 + 4.0 * energy)  # 2 p² = (1 + root − q²)(q² + root − 1)
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 200_001)
    q = np.sqrt(1.0 + root) * np.sin(angle)
    rate = 1.0 / np.sqrt(q * q + root - 1.0)
    time = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(angle))])
    part = np.interp(states[:, 0], q, time / time[-1])
    assert stats.kstest(part, "uniform").pvalue > SIGNIFICANT


def test_a_level_of_energy_has_the_measure_of_the_flow_not_its_area() -> None:
    """The energy of one of two oscillators is uniform, whatever their frequencies (20 : 1 here)."""
    states = gi.draw_states(OSCILLATORS, COUNT, keep={"energy": 0.5})
    part = 0.5 * (states[:, 2] ** 2 + 400.0 * states[:, 0] ** 2)
    assert stats.kstest(part / 0.5, "uniform").pvalue > SIGNIFICANT
    phase = np.arctan2(states[:, 2], 20.0 * states[:, 0])
    assert stats.kstest(phase / (2.0 * np.pi) + 0.5, "uniform").pvalue > SIGNIFICANT
    assert np.allclose([gi.value(OSCILLATORS, "energy", y) for y in states], 0.5, rtol=1e-10)


def test_several_quantities_leave_a_torus() -> None:
    states = gi.draw_states(OSCILLATORS, COUNT, keep={"energy": 0.5, "first": 0.1})
    for phase in (
        np.arctan2(states[:, 2], 20.0 * states[:, 0]),
        np.arctan2(states[:, 3], states[:, 1]),
    ):
        assert stats.kstest(phase / (2.0 * np.pi) + 0.5, "uniform").pvalue > SIGNIFICANT


def test_a_temperature() -> None:
    """Coordinates are normal, with the variances of the equipartition of energy."""
    states = gi.draw_states(OSCILLATORS, COUNT, temperature=0.3)
    for row, variance in enumerate([0.3 / 400.0, 0.3, 0.3, 0.3]):
        assert stats.kstest(states[:, row] / np.sqrt(variance), "norm").pvalue > SIGNIFICANT


def marginals(problem: gi.Problem, theta: float, gammas: np.ndarray) -> np.ndarray:
    """Return the density of γ, up to a factor, by the Gaussian integral over tangent momenta.

    In two rows, with the multiplier and without.
    """
    found = np.zeros((2, len(gammas)))
    for k, gamma in enumerate(gammas):
        u = np.linalg.svd(gamma[None, :])[2][1:]
        pairs = [gi.value(problem, "energy", np.concatenate([gamma, e])) for e in (*u, u[0] + u[1])]
        quadratic = np.array([[2 * pairs[0], 0.0], [0.0, 2 * pairs[1]]])
        quadratic[0, 1] = quadratic[1, 0] = pairs[2] - pairs[0] - pairs[1]
        state = np.concatenate([gamma, u[0]])
        density = np.exp(gi.value(problem, problem.measure.log_density, state))
        plain = 2 * np.pi * theta / np.sqrt(np.linalg.det(quadratic))
        found[:, k] = density * plain, plain
    return found


def test_of_the_reduced_sphere_the_multiplier_is_the_density() -> None:
    """γ by quadrature over the sphere; without the multiplier the same test says no."""
    count = 1200
    problem = ch.ChaplyginSphere(a=[0.3, 1.0, 2.5], D=3.0).reduced()
    states = gi.draw_states(problem, count, temperature=0.5)
    rng = np.random.default_rng(5)
    gammas = rng.normal(size=(count, 3))
    gammas /= np.linalg.norm(gammas, axis=1, keepdims=True)
    found = states[:, 0] ** 2
    off = []
    for weights in marginals(problem, 0.5, gammas):
        squares = gammas[:, 0] ** 2
        mean = np.average(squares, weights=weights)
        variance = np.average((weights / weights.mean()) ** 2 * (squares - mean) ** 2)
        error = np.sqrt(variance / len(gammas) + found.var() / len(found))
        off.append(abs(found.mean() - mean) / error)
    assert off[0] < 3.5
    assert off[1] > 5.0


def test_directions_of_a_free_particle_on_a_sphere_are_uniform() -> None:
    """Of the homogeneous sphere both γ and the momentum's axis."""
    problem = ch.ChaplyginSphere(a=[1.0, 1.0, 1.0], D=4.0).hamiltonized()
    states = gi.draw_states(problem, COUNT, keep={"energy": 0.5})
    axes = np.cross(states[:, :3], states[:, 3:])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    for directions in (states[:, :3], axes):
        for k in range(3):
            assert stats.kstest(0.5 + 0.5 * directions[:, k], "uniform").pvalue > SIGNIFICANT


@pytest.mark.usefixtures("short_chains")
@pytest.mark.parametrize(
    "name", ["hamiltonized-n5", "ball-3d", "clebsch-n4", "veselova-n4", "ball-on-group-n4"]
)
def test_of_every_kind_of_state(name: str) -> None:
    """Draws are admissible states with the energy, all different."""
    scene = gi.load_scene(name)
    states = gi.draw_states(scene.problem, 8, at=scene.state)
    wanted = gi.value(scene.problem, "energy", scene.state)
    for y in states:
        assert gi.value(scene.problem, "energy", y) == pytest.approx(wanted, rel=1e-9)
        assert np.allclose(scene.problem.canonical(y), y, atol=1e-12)
    assert len({tuple(y) for y in states}) == 8


@pytest.mark.usefixtures("short_chains")
def test_the_seed_decides() -> None:
    scene = gi.load_scene("hamiltonized-n3")
    one, again, other = (
        gi.draw_states(scene.problem, 8, at=scene.state, seed=seed) for seed in (0, 0, 1)
    )
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("theta", [1e-200, 1e-12])
def test_a_temperature_that_chains_do_not_come_to_is_told(theta: float) -> None:
    """Energies in units of it are large, their squares too large for numbers: no success of that."""
    with pytest.warns(gi.GeomintWarning, match="depend on where chains began"):
        gi.draw_states(OSCILLATORS, 9, temperature=theta)
    near = np.sqrt(theta) * np.array([0.05, 1.0, 1.0, 1.0])  # the problem has no random states
    states = gi.draw_states(OSCILLATORS, 400, temperature=1e-12, at=near * np.sqrt(1e-12 / theta))
    assert stats.kstest(states[:, 1] / 1e-6, "norm").pvalue > SIGNIFICANT


def test_a_level_without_bounds_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """The contact point of a rolling ball may be anywhere."""
    monkeypatch.setattr(chains, "TRIED", 100)
    scene = gi.load_scene("rolling-ball-n3")
    with pytest.warns(gi.GeomintWarning, match="'r'.*no bounds"):
        gi.draw_states(scene.problem, 8, at=scene.state)


def test_in_other_dimensions() -> None:
    """On the sphere with equal moments γ₁ has the marginal of a uniform direction; n = 3: above."""
    n = 5
    problem = ch.ChaplyginSphere(a=[1.0] * n, D=4.0).hamiltonized()
    states = gi.draw_states(problem, COUNT, keep={"energy": 0.5}, seed=n)
    half = stats.beta((n - 1) / 2, (n - 1) / 2)
    assert stats.kstest(0.5 + 0.5 * states[:, 0], half.cdf).pvalue > SIGNIFICANT


def test_where_chains_begin_is_forgotten() -> None:
    """From one and the same state all draws have the distribution that others have."""
    problem = dataclasses.replace(OSCILLATORS, make_random=None)
    start = [0.01, 0.3, 0.4, -0.2]
    states = gi.draw_states(problem, COUNT, at=start)
    energy = gi.value(problem, "energy", start)
    part = 0.5 * (states[:, 2] ** 2 + 400.0 * states[:, 0] ** 2)
    assert stats.kstest(part / energy, "uniform").pvalue > SIGNIFICANT


@gi.observable
def tilted_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    along, across = 0.6 * y[0] + 0.8 * y[1], 0.6 * y[1] - 0.8 * y[0]
    return 0.5 * (along * along + params[0] * across * across)


@gi.field
def tilted(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    along, across = 0.6 * y[0] + 0.8 * y[1], 0.6 * y[1] - 0.8 * y[0]
    out[0] = 0.8 * along + 0.6 * params[0] * across
    out[1] = -0.6 * along + 0.8 * params[0] * across


def test_a_narrow_level_across_the_numbers() -> None:
    """An ellipse at an angle to the axes, all chains begun at one state of it: uniform in time."""
    ratio = 20.0
    problem = dataclasses.replace(
        QUARTIC,
        name="tilted",
        params=[ratio**2],
        field=tilted,
        invariants={"energy": tilted_energy},
    )
    states = gi.draw_states(problem, COUNT, at=[0.6, 0.8])
    along = states @ [0.6, 0.8]
    across = ratio * (states @ [-0.8, 0.6])
    phase = np.arctan2(across, along) / (2.0 * np.pi) + 0.5
    assert stats.kstest(phase, "uniform").pvalue > SIGNIFICANT


@gi.observable
def bent_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    v = y[1] - y[0] * y[0]
    return 0.5 * (y[0] * y[0] + v * v)


@gi.field
def bent(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    v = y[1] - y[0] * y[0]
    out[0], out[1] = v, -y[0] + 2.0 * y[0] * v


def test_a_bent_level() -> None:
    """A circle in (u, y − u²), of the same areas: normals there meet other parts of it."""
    problem = dataclasses.replace(
        QUARTIC, name="bent", field=bent, invariants={"energy": bent_energy}
    )
    states = gi.draw_states(problem, COUNT, at=[0.0, 1.0])
    phase = np.arctan2(states[:, 1] - states[:, 0] ** 2, states[:, 0]) / (2.0 * np.pi) + 0.5
    assert stats.kstest(phase, "uniform").pvalue > SIGNIFICANT


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


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "at="),
        ({"keep": []}, "infinite"),
        ({"keep": {"enrgy": 1.0}}, "energy"),
        ({"keep": {"energy": np.nan}}, "energy"),
        ({"keep": {"energy": -1.0}}, "keep"),
        ({"keep": {"energy": 1.0, "again": 2.0}}, "depend"),
        ({"keep": 7}, "names"),
        ({"temperature": 0.0}, "temperature"),
        ({"temperature": "warm"}, "temperature"),
        ({"temperature": 1.0, "keep": {"energy": 1.0}}, "energy is kept"),
        ({"keep": {"energy": 1.0}, "seed": -1}, "seed"),
        ({"keep": {"energy": 1.0}, "at": [1.0]}, "state"),
    ],
)
def test_what_makes_no_sense(given: dict[str, Any], said: str) -> None:
    with pytest.raises(gi.DomainError, match=said):
        gi.draw_states(OSCILLATORS, 3, **given)


@pytest.mark.parametrize("more", [{"keep": ["energy", "norm"]}, {"keep": {"norm": 0.0}}])
@pytest.mark.parametrize("temperature", [None, 0.1])
def test_a_constraint_is_nothing_to_keep(more: dict[str, Any], temperature: float | None) -> None:
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    at = problem.random_state(1)
    with pytest.raises(gi.DomainError, match=r"keep = 'norm': expected no constraint"):
        gi.draw_states(problem, 9, at=at, temperature=temperature, **more)


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
    small = np.concatenate([1e-9 * state[:3] + 1e-12 * gamma, gamma])
    kept = kept_values(problem, ["area", "energy"], small)  # 1e-12, 1e-19 are no rounding
    assert kept == {name: gi.value(problem, name, small) for name in kept}


def test_no_measure_no_draws() -> None:
    bare = dataclasses.replace(OSCILLATORS, measure=None)
    with pytest.raises(gi.DomainError, match="measure"):
        gi.draw_states(bare, 3, keep={"energy": 1.0})
    with pytest.raises(gi.DomainError, match="count"):
        gi.draw_states(OSCILLATORS, 0, keep={"energy": 1.0})
    with pytest.raises(gi.DomainError, match="problem"):
        gi.draw_states(7, 3)
