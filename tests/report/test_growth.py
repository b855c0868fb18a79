"""The statistical rule on synthetic series whose growth is known: how often is it wrong?"""

from collections import Counter

import numpy as np
import pytest

from geomint.drift import CLASSES, measure_drift
from geomint.growth import RULE, trend_slope
from geomint.windows import Windows

SAMPLES = 20_000
T = np.arange(1, SAMPLES + 1) / SAMPLES


def windowed(series):
    windows = Windows(0.0)
    windows.add(np.arange(1.0, len(series) + 1.0), np.asarray(series, dtype=float))
    return windows


def kind_of(series, scale=0.0):
    return measure_drift("v", windowed(series), scale).kind


def oscillation(rng, low, high):
    """Return an oscillation with a random number of periods between `low` and `high`."""
    periods = np.exp(rng.uniform(np.log(low), np.log(high)))
    return np.sin(2.0 * np.pi * periods * T + rng.uniform(0.0, 2.0 * np.pi))


def walk(rng):
    """Return a random walk that reaches about 1 at the end."""
    return np.cumsum(rng.normal(size=SAMPLES)) / np.sqrt(SAMPLES)


def modes(rng):
    return sum(rng.normal() * oscillation(rng, 10, SAMPLES / 3) for _ in range(8))


# name: (class, series, greatest share of other classes)
CASES = {
    "noise": ("bounded", lambda rng: rng.normal(size=SAMPLES), 0.0),
    "many periods": ("bounded", lambda rng: oscillation(rng, 100, SAMPLES / 3), 0.03),
    "twenty to a hundred periods": ("bounded", lambda rng: oscillation(rng, 20, 100), 0.01),
    "eight to twenty periods": ("bounded", lambda rng: oscillation(rng, 8, 20), 0.01),
    "four to eight periods": ("bounded", lambda rng: oscillation(rng, 4, 8), 0.03),
    "off centre": ("bounded", lambda rng: 3.0 + oscillation(rng, 50, 500), 0.02),
    "many modes": ("bounded", modes, 0.02),
    "beats": (
        "bounded",
        lambda rng: oscillation(rng, 100, 1000) * oscillation(rng, 4, 50),
        0.02,
    ),
    "random walk": ("sqrt", walk, 0.04),
    "rare kicks": (
        "sqrt",
        lambda rng: np.cumsum(rng.integers(-1, 2, SAMPLES) * (rng.random(SAMPLES) < 0.05)),
        0.04,
    ),
    "walk in noise": ("sqrt", lambda rng: walk(rng) + 0.3 * rng.normal(size=SAMPLES), 0.07),
    "walk with oscillation": (
        "sqrt",
        lambda rng: walk(rng) + 0.3 * oscillation(rng, 20, 1000),
        0.07,
    ),
    "line": ("linear", lambda rng: rng.choice([-1.0, 1.0]) * T, 0.0),
    "line below an oscillation": (
        "linear",
        lambda rng: T + 3.0 * oscillation(rng, 100, 1000),
        0.02,
    ),
    "line in noise": ("linear", lambda rng: T + rng.normal(size=SAMPLES), 0.02),
    "line off centre": (
        "linear",
        lambda rng: 3.0 - T + 3.0 * oscillation(rng, 100, 1000),
        0.02,
    ),
    "line with a walk": ("linear", lambda rng: T + 0.1 * walk(rng), 0.05),
    "growing oscillation": (
        "linear",
        lambda rng: (2.0 + T) * oscillation(rng, 50, 3000),
        0.05,
    ),
    "oscillation that wanders": (
        "sqrt",
        lambda rng: walk(rng) * oscillation(rng, 200, 3000),
        0.12,
    ),
    "oscillation that grows as the square": (
        "faster",
        lambda rng: T**2 * oscillation(rng, 50, 3000),
        0.03,
    ),
    "instability": ("faster", lambda rng: np.exp(10 * T) * oscillation(rng, 200, 3000), 0.03),
    "oscillation in beats": (
        "bounded",
        lambda rng: (1.0 + 0.5 * oscillation(rng, 4, 8)) * oscillation(rng, 200, 3000),
        0.03,
    ),
    "square": ("faster", lambda rng: T**2, 0.0),
    "cube": ("faster", lambda rng: -(T**3), 0.0),
    "exponential": ("faster", lambda rng: np.exp(20.0 * T), 0.0),
    "square below an oscillation": ("faster", lambda rng: T**2 + oscillation(rng, 100, 1000), 0.02),
    "square with a walk": ("faster", lambda rng: T**2 + 0.1 * walk(rng), 0.1),
    "slow oscillation": ("undetermined", lambda rng: oscillation(rng, 0.7, 2.0), 0.15),
    "levelling off": ("undetermined", lambda rng: 1.0 - np.exp(-6.0 * T), 0.0),
    "jump": ("bounded", lambda rng: np.ones(SAMPLES), 0.0),
}


@pytest.mark.parametrize("name", CASES)
def test_misclassification(name):
    wanted, series, tolerated = CASES[name]
    rng = np.random.default_rng(20)
    repeats = 60
    kinds = Counter(kind_of(series(rng)) for _ in range(repeats))
    assert repeats - kinds[wanted] <= tolerated * repeats + 0.5, kinds


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_misclassification_in_many_runs(name):
    wanted, series, tolerated = CASES[name]
    rng = np.random.default_rng(21)
    repeats = 1000
    kinds = Counter(kind_of(series(rng)) for _ in range(repeats))
    assert repeats - kinds[wanted] <= tolerated * repeats + 2.0, kinds


@pytest.mark.parametrize("count", [64, 100, 512, 1023, 1024, 5000, 200_000])
def test_the_rule_does_not_depend_on_the_number_of_samples(count):
    t = np.arange(1, count + 1) / count
    rng = np.random.default_rng(3)
    right = Counter()
    for _ in range(20):
        right["line"] += kind_of(t + 0.05 * rng.normal(size=count)) == "linear"
        right["square"] += kind_of(t**2) == "faster"
        right["walk"] += kind_of(np.cumsum(rng.normal(size=count))) == "sqrt"
        right["noise"] += kind_of(rng.normal(size=count)) == "bounded"
    assert min(right.values()) >= 18, right


def test_round_off_is_round_off():
    rng = np.random.default_rng(0)
    epsilon = 2.0**-52
    assert kind_of(20 * epsilon * (rng.random(SAMPLES) - 0.5), scale=1.0) == "roundoff"
    assert kind_of(20 * epsilon * T, scale=1.0) == "roundoff"
    assert kind_of(40 * epsilon * T, scale=1.0) == "linear"
    assert kind_of(np.zeros(SAMPLES), scale=1.0) == "roundoff"


def test_a_short_series_is_undetermined():
    assert kind_of(T[:63]) == "undetermined"
    assert kind_of([]) == "undetermined"


def test_what_is_not_finite_grows():
    series = T.copy()
    series[-1] = np.inf
    assert kind_of(series) == "faster"
    series[SAMPLES // 2] = np.nan
    assert kind_of(series) == "faster"


@pytest.mark.parametrize("factor", [1e-300, 1e-16, 1.0, 1e16, 1e150])
def test_scale_and_sign_do_not_matter(factor):
    rng = np.random.default_rng(5)
    for _, series, _ in CASES.values():
        values = series(rng)
        assert kind_of(values) == kind_of(-values)
        assert kind_of(factor * values) == kind_of(values)


def _parts(windows):
    return windows.times, windows.means


def test_every_class_is_explained():
    assert set(RULE) == set(CLASSES)


@pytest.mark.parametrize(
    ("name", "least"),
    [("noise", 0.3), ("random walk", 0.8), ("walk in noise", 0.7), ("line in noise", 0.2)],
)
def test_the_standard_error_of_the_slope_is_honest(name, least):
    """(slope − true slope) / error has a standard deviation of about 1, at most 1.2."""
    _, series, _ = CASES[name]
    true = 1.0 / SAMPLES if name.startswith("line") else 0.0
    rng = np.random.default_rng(8)
    scores = []
    for _ in range(200):
        slope, error = trend_slope(*_parts(windowed(series(rng))))
        scores.append((slope - true) / error)
    assert least < np.std(scores) < 1.2
    assert abs(np.mean(scores)) < 0.3


def test_the_slope_of_a_line_is_its_slope():
    slope, error = trend_slope(*_parts(windowed(-3.0 * T)))
    assert slope == pytest.approx(-3.0 / SAMPLES, rel=1e-12)
    assert 0.0 <= error < 1e-12
    assert trend_slope(np.arange(3.0), np.arange(3.0)) == (None, None)
    assert trend_slope(np.arange(100.0), np.ones(100)) == (0.0, 0.0)
