"""Weighted averages and rotation numbers: known ones, regular and chaotic motions, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def wobbling(nu: float, count: int, step: float = 1.0, phase: float = 0.0) -> np.ndarray:
    """A point that turns with ν, unevenly and at changing distance."""
    t = step * np.arange(count) + phase
    other = nu * GOLDEN
    return (1.5 + 0.4 * np.cos(other * t)) * np.exp(
        1j * (nu * t + 0.2 * np.sin(nu * t + other * t))
    )


@pytest.mark.parametrize(("nu", "phase"), [(0.7, 0.0), (-1.1, 17.3), (0.031, 17.3)])
def test_faster_than_any_power(nu: float, phase: float) -> None:
    """To 1e-14 where the plain mean has 1/N; wherever the samples begin."""
    count = int(600 / abs(nu))
    z = wobbling(nu, count, phase=phase)
    found = gi.rotation_number(z)
    assert found.value == pytest.approx(nu, abs=1e-13)
    assert found.digits > 9
    assert found.verdict == "regular"
    assert found.samples == count - 1
    plain = np.diff(np.unwrap(np.angle(z))).mean()
    assert abs(plain - nu) > 1e-9


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e12])
def test_units(unit: float) -> None:
    """Of time and of length; pairs of real numbers are points as complex ones are."""
    z = wobbling(0.7, 2000)
    one = gi.rotation_number(z)
    assert gi.rotation_number(z, unit).value * unit == pytest.approx(one.value, rel=1e-15)
    scaled = gi.rotation_number(np.column_stack((unit * z.real, unit * z.imag)))
    assert scaled.value == pytest.approx(one.value, rel=1e-13)
    rows = np.column_stack((z.real, z.imag))
    for power in (1.0, unit):
        average = gi.birkhoff_average(power * rows)
        np.testing.assert_allclose(
            average.value, power * gi.birkhoff_average(rows).value, rtol=0, atol=1e-14 * power
        )


@given(
    nu=st.floats(-3.1, 3.1),
    shift=st.complex_numbers(max_magnitude=0.2),
    count=st.integers(17, 60),
)
def test_even_turns_are_exact(nu: float, shift: complex, count: int) -> None:
    """A circle about 0, however few samples; also as a map, near half a turn a sample."""
    z = (2.0 + shift) * np.exp(1j * nu * np.arange(count))
    found = gi.rotation_number(z)
    assert found.value == pytest.approx(nu, abs=1e-12)
    assert found.digits > 12 or abs(nu) < 1e-3  # of a turn that is hardly there


def test_half_a_turn_and_more() -> None:
    """Angles between samples may be on both sides of π: they are cut where there are none."""
    nu = 3.1
    z = wobbling(nu, 4000)
    found = gi.rotation_number(z)
    turns = np.abs(np.angle(z[1:] / z[:-1]))
    assert turns.max() > 3.13
    assert found.value == pytest.approx(nu, abs=1e-10)


def test_averages() -> None:
    """Constants, zeros, columns; a mean that is small against what swings."""
    t = np.arange(3000.0)
    swings = 5.0 * np.cos(0.7 * t) + np.cos(0.7 * GOLDEN * t)
    found = gi.birkhoff_average(np.column_stack((swings, swings**2, 0.0 * t, 3.0 + 0.0 * t)))
    np.testing.assert_allclose(found.value, [0.0, 13.0, 0.0, 3.0], rtol=0, atol=1e-13)
    assert found.digits > 10
    alone = gi.birkhoff_average(swings)
    assert isinstance(alone.value, float)
    assert abs(alone.value) < 1e-13
    assert abs(swings.mean()) > 1e-6
    same = gi.birkhoff_average(np.full(100, 7.0))
    assert (same.value, same.digits, same.verdict) == (7.0, 16.0, "regular")
    assert gi.birkhoff_average(np.zeros(16)).value == 0.0


def test_of_a_torus() -> None:
    """From a run: half whole combinations of the exact frequencies, all lines of its spectrum too."""
    problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0).hamiltonized()
    y = problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])
    omega = problem.exact(y).frequencies
    run = gi.solve(
        problem, y, tau_end=4000.0, step=0.2, method="gauss-8", save_every=1, clock=False
    )
    found = gi.rotation_number(run.y[:, 1:3], 0.2)
    whole = np.arange(-12, 13) / 2.0
    lines = np.add.outer(whole * omega[0], whole * omega[1]).ravel()
    assert np.abs(lines - found.value).min() < 3e-12
    assert found.verdict == "regular"
    for term in gi.frequencies(run.y[:, 0] + 1j * run.y[:, 1], 0.2, terms=4):
        assert np.min(np.abs(lines - term.frequency)) < 1e-9


def test_regular_and_chaotic() -> None:
    """One energy, two motions. Neither an offset nor another column makes a motion regular.

    Digits are those of what varies; those of several columns are the worst one's.
    """
    problem, runs = henon_heiles.problem(), []
    for q in (0.29, -0.15):  # whose exponents are compatible with 0, and 0.04
        y0 = [0.0, q, np.sqrt(0.25 - q * q + 2 * q**3 / 3), 0.0]
        given = {"t_end": 20_000.0, "method": "gauss-8", "step": 0.4, "save_every": 1}
        runs.append(gi.solve(problem, y0, **given))
    regular, chaotic = (gi.birkhoff_average(run.y**2) for run in runs)
    assert (regular.verdict, chaotic.verdict) == ("regular", "chaotic")
    assert regular.digits - chaotic.digits > 5
    assert chaotic.digits < 3.5
    q = runs[1].y[:, 0]
    t = np.arange(len(q))
    wave, alone = np.cos(0.7 * t), gi.birkhoff_average(q)
    for values in (
        q + 1e5,
        1e-5 * q + 1.0,
        np.column_stack((q, 1e6 * wave)),
        np.column_stack((1e6 + 0.0 * t, q)),
        np.column_stack((wave, q, wave)),
    ):
        found = gi.birkhoff_average(values)
        assert found.verdict == "chaotic"
        assert found.digits == pytest.approx(alone.digits, abs=0.01)
    assert gi.birkhoff_average(wave).digits > 10


def test_whole_periods_in_the_halves() -> None:
    """Halves that are alike are no proof: not more digits than there are."""
    for turns in range(2, 11):
        t = np.arange(2000) / 2000
        found = gi.birkhoff_average(np.sin(2 * np.pi * turns * t) ** 2)
        assert 10.0**-found.digits > 0.1 * abs(found.value - 0.5)


def test_verdicts() -> None:
    """From four digits more than √N on; up to one more, if they hardly grow; of enough samples."""
    for beyond, gained, samples, verdict in (
        (4.1, 0.0, 10_000, "regular"),
        (3.9, 0.0, 10_000, "undecided"),
        (1.1, 0.0, 10_000, "undecided"),
        (0.9, 0.0, 10_000, "chaotic"),
        (0.9, 1.4, 10_000, "chaotic"),
        (0.9, 1.6, 10_000, "undecided"),
        (0.9, 0.0, 900, "undecided"),
        (4.1, 0.0, 100, "regular"),
    ):
        digits = 0.5 * np.log10(samples) + beyond
        assert gi.Average(0.0, digits, gained, samples).verdict == verdict
    values = np.cos(0.7 * np.arange(1000)) + np.cos(0.7 * GOLDEN * np.arange(1000))
    found = gi.birkhoff_average(values)
    quarter = gi.birkhoff_average(values[:250])
    assert found.gained == pytest.approx(found.digits - quarter.digits, abs=0.02)
    assert found.gained > 2
    t = np.arange(200.0)  # a few periods
    short = gi.birkhoff_average(np.cos(0.2 * t) + np.cos(0.2 * GOLDEN * t))
    assert short.verdict != "chaotic"


def test_turns_far_from_half_a_turn() -> None:
    """Few samples with a gap elsewhere: what is below 3 rad a sample is not turned around."""
    rng = np.random.default_rng(7)
    for _ in range(300):
        turns = rng.uniform(-2.9, 2.9, 25)
        z = np.exp(1j * np.cumsum(np.r_[0.0, turns]))
        found = gi.rotation_number(z)
        assert found.value == pytest.approx(gi.birkhoff_average(turns).value, abs=1e-12)
    for size in (1e-310, 1e-200, 1e300):
        found = gi.rotation_number(size * wobbling(0.7, 2000))
        assert found.value == pytest.approx(0.7, abs=1e-7)


def test_wrong_input() -> None:
    rng, ones = np.random.default_rng(0), np.ones(19)
    for signal in (np.ones(16), np.ones((20, 3)), np.r_[ones, np.nan], np.r_[ones, 0.0], "x",
                   np.ones((20, 2)) * 1j, None):  # fmt: skip
        with pytest.raises(gi.DomainError, match="signal"):
            gi.rotation_number(signal)
    with pytest.raises(gi.DomainError, match="complex or in 2 columns"):
        gi.rotation_number(np.arange(20.0))  # angles are no points
    with pytest.raises(gi.DomainError, match="close enough"):
        gi.rotation_number(np.exp(2j * np.pi * rng.random(500)))
    for step in (0.0, -1.0, np.nan, "x", 5e-324):
        with pytest.raises(gi.DomainError, match="step"):
            gi.rotation_number(wobbling(0.7, 100), step)
    for values in (np.ones(15), np.ones((3, 3, 3)), np.full(20, np.inf), np.ones((20, 0)), "x"):
        with pytest.raises(gi.DomainError, match="values"):
            gi.birkhoff_average(values)


def test_columns_and_samples_of_very_different_sizes() -> None:
    """Each column is averaged in its own unit, and each point has an angle of its own."""
    wave = np.cos(0.3 * np.arange(500.0))
    alone = gi.birkhoff_average(1.0 + wave)
    found = gi.birkhoff_average(np.column_stack((1e300 * wave, 1e-300 * (1.0 + wave))))
    assert found.value[1] == pytest.approx(1e-300 * alone.value, rel=1e-12)
    assert found.digits == pytest.approx(alone.digits, abs=0.1)
    z = np.exp(0.3j * np.arange(500))
    z[7] *= 1e-310
    z[100:200] *= 1e300
    assert gi.rotation_number(z).value == pytest.approx(0.3, abs=1e-12)


def test_what_does_not_come_back_is_undecided() -> None:
    """An angle that grows, a place that wanders off, half of a period: few digits, and no chaos."""
    t = np.linspace(0.0, 1.0, 20_000)
    wave = np.cos(2000.0 * t)
    for values in (t, t + 0.01 * wave, np.cos(np.pi * t), np.column_stack((wave, t)), -(t**2)):
        found = gi.birkhoff_average(values)
        assert found.verdict == "undecided"
        assert not found.returning
    rng = np.random.default_rng(4)
    noise = gi.birkhoff_average(rng.normal(size=20_000))
    assert noise.returning
    assert noise.verdict == "chaotic"


TURNS = np.arange(1000.0)


@pytest.mark.parametrize(
    "signal",
    [
        np.exp(1j * np.pi * TURNS),
        np.exp(-1j * np.pi * TURNS),
        -((-1.0) ** TURNS) + 0j,
        np.exp(1j * np.cumsum(np.where(TURNS % 2 == 0, np.pi - 0.1, 0.1 - np.pi))),
        np.cos(0.7 * TURNS) + 0j,  # through 0, by which side nobody knows
        np.cos(0.7 * TURNS) + 0.001j,
    ],
)
def test_half_a_turn_is_no_number(signal):
    with pytest.raises(gi.DomainError, match="close enough to tell"):
        gi.rotation_number(signal)


@pytest.mark.parametrize("turn", [3.1, -3.14, np.pi - 1e-6, 0.0])
def test_less_than_half_a_turn_is_one(turn):
    assert gi.rotation_number(np.exp(1j * turn * TURNS)).value == pytest.approx(turn, abs=1e-12)
