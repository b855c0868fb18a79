"""Growth over members: exponents of walks that are known, how often the error bar holds, classes."""

from __future__ import annotations

import numpy as np
import pytest

from geomint.watch.over_members import LEVELS, class_of_exponent, growth_over_members

SAMPLES, COUNT = 640, 32
PARTS = np.array_split(np.arange(SAMPLES), COUNT)
EDGES = np.concatenate(([0.5], 0.5 + np.cumsum([len(part) for part in PARTS])))
TIMES = np.arange(1, SAMPLES + 1)


def windows(deviations: np.ndarray) -> np.ndarray:
    parts = np.array_split(deviations, COUNT, axis=1)
    return np.array([np.sqrt((part**2).mean(axis=1)) for part in parts]).T


def drawn(kind: str, seed: int, members: int) -> np.ndarray:
    rng = np.random.default_rng(seed)

    def walk() -> np.ndarray:
        return np.cumsum(rng.standard_normal((members, SAMPLES)), axis=1)

    amplitudes, phases = rng.standard_normal((members, 1)), rng.uniform(0, 6, (members, 1))
    deviations = {
        "oscillation": lambda: amplitudes * np.sin(0.7 * TIMES + phases),
        "walk": walk,
        "walks of other sizes": lambda: np.exp(amplitudes / 2) * walk(),
        "biased": lambda: walk() + 3.0 * amplitudes * TIMES,
        "walk of a walk": lambda: np.cumsum(walk(), axis=1),
    }
    return windows(deviations[kind]())


EXPONENTS = {
    "oscillation": 0.0, "walk": 0.5, "walks of other sizes": 0.5, "walk of a walk": 1.5,
}  # fmt: skip


LATE = [pytest.param("walks of other sizes", marks=pytest.mark.nightly)]


@pytest.mark.parametrize(
    ("members", "seeds", "spread"),
    [(30, 6, 2.5), *(pytest.param(n, 60, 1.4, marks=pytest.mark.nightly) for n in (30, 90))],
)
@pytest.mark.parametrize("kind", ["oscillation", "walk", "walk of a walk", *LATE])
def test_the_interval_holds_as_often_as_it_says(
    kind: str, members: int, seeds: int, spread: float
) -> None:
    found = [growth_over_members(drawn(kind, s, members), EDGES, s) for s in range(seeds)]
    held = [one.low <= EXPONENTS[kind] <= one.high for one in found]
    assert np.mean(held) >= 0.8  # of 60 as good as never fewer, if it is 19 of 20
    exponents = np.array([one.exponent for one in found])
    assert abs(exponents.mean() - EXPONENTS[kind]) < 4 * exponents.std() / seeds**0.5 + 0.01
    assert 1 / spread < np.mean([one.stderr for one in found]) / exponents.std() < spread


@pytest.mark.parametrize("seeds", [3, pytest.param(60, marks=pytest.mark.nightly)])
@pytest.mark.parametrize(
    ("kind", "known"),
    [
        ("oscillation", "bounded"), ("walk", "sqrt"), ("walks of other sizes", "sqrt"),
        ("biased", "linear"), ("walk of a walk", "faster"),
    ],
)  # fmt: skip
def test_classes(kind: str, known: str, seeds: int) -> None:
    """Of many members nearly always the right one, of few never a wrong one, as good as."""

    def classes(members: int, count: int) -> list[str]:
        found = [growth_over_members(drawn(kind, s, members), EDGES) for s in range(count)]
        return [class_of_exponent(one) for one in found]

    many, few = classes(150, seeds // 3), classes(8, seeds if kind == "walk" else 0)
    assert many.count(known) >= len(many) - len(many) // 3
    assert {*many} <= {known, "undetermined"}
    assert sum(c not in (known, "undetermined") for c in few) <= seeds / 12


def test_numbers_are_those_that_they_have_been() -> None:
    """What changes one of them is a change of what is published."""
    for kind, known in (
        ("walk", [0.534979234207, 0.0504645414364, 0.431767658185, 0.63819081023, 25.4355577515]),
        ("biased", [0.998883700096, 0.00343432113006, 0.99185972472, 1.00590767547, 1569.64898907]),
    ):
        one = growth_over_members(drawn(kind, 1, 30), EDGES)
        found = [one.exponent, one.stderr, one.low, one.high, one.size]
        assert found == pytest.approx(known, rel=1e-9)


@pytest.mark.parametrize(
    ("low", "high", "known"),
    [
        (-9.0, 0.24, "bounded"), (-0.1, 0.26, "undetermined"), (0.26, 0.74, "sqrt"),
        (0.24, 0.5, "undetermined"), (0.26, 0.76, "undetermined"), (0.76, 1.24, "linear"),
        (0.74, 1.0, "undetermined"), (0.76, 1.26, "undetermined"), (1.26, 9.0, "faster"),
        (1.24, 9.0, "undetermined"),
    ],
)  # fmt: skip
def test_classes_on_both_sides_of_each_limit(low: float, high: float, known: str) -> None:
    """Halves may differ by ¼ and two of their errors."""
    found = growth_over_members(drawn("walk", 1, 30), EDGES)._replace(low=low, high=high)
    for apart, said in ((0.44, known), (0.46, "undetermined")):
        halves, errors = np.array([1.0 + apart, 1.0]), np.array([0.06, 0.08])
        other = found._replace(halves=halves, halves_stderr=errors)
        assert class_of_exponent(other) == said


def test_powers_are_found_exactly() -> None:
    """In windows of one sample too, and where the first window is long."""
    for count in (8, SAMPLES):
        parts = np.array_split(TIMES, count)
        edges = np.concatenate(([0.5], 0.5 + np.cumsum([len(part) for part in parts])))
        for b in (0.0, 0.5, 2.0)[count > 8 :]:
            rms = [np.sqrt(np.mean(part ** (2.0 * b))) for part in parts]
            found = growth_over_members(np.tile(rms, (9, 1)), edges)
            assert abs(found.exponent - b) < 5e-3
            assert abs(found.size / edges[-2:].mean() ** b - 1.0) < 0.01


def test_what_is_no_power_of_time() -> None:
    """An offset, then a walk or a drift: the halves tell, and nothing is claimed."""
    rng = np.random.default_rng(1)
    offset = 200.0 * rng.standard_normal((200, 1))
    found = growth_over_members(windows(offset + 2.0 * TIMES), EDGES)
    assert found.halves[1] > found.halves[0] + 0.3
    assert class_of_exponent(found) == "undetermined"


def test_nothing_deviates() -> None:
    found = growth_over_members(np.zeros((20, COUNT)), EDGES)
    assert class_of_exponent(found) == "roundoff"
    assert np.isnan(found.exponent)
    assert found.size == 0.0
    some = np.zeros((20, COUNT))
    some[:, 9:] = drawn("walk", 1, 20)[:, 9:]
    assert np.isfinite(growth_over_members(some, EDGES).exponent)


def test_many_members_are_drawn_in_groups() -> None:
    values = drawn("walk", 1, 5000)
    found = growth_over_members(values, EDGES)
    assert 0.5 < found.stderr / (0.29 / np.sqrt(5000)) < 1.5  # as 0.29/√N of fewer members
    assert np.array_equal(found.quantiles, np.quantile(values, LEVELS, axis=0))
    assert np.allclose(found.rms**2, (values**2).mean(axis=0))
