"""Events of long steps against samples: the motions at which some had been missed.

``benchmarks/events_missed.py`` does the same for a million crossings; these are those of its motions
where it found what is wrong with an estimate from one lower order (at an extremum it vanishes), with
values of bounded functions where states are not resolved, with a middle whose sign is not known, and
with slopes from values that rounding decides.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

import geomint as gi

HARD = [
    (0, 1),
    (0, 2),
    (0, 20),
    (1, 72),
    (0, 55),
    (0, 61),
    (0, 110),
    (0, 5108),
    (1, 2),
    (1, 4),
    (1, 14),
]


@pytest.fixture(scope="module")
def benchmark(monkeypatch_module: pytest.MonkeyPatch) -> Any:
    """The benchmark as a module."""
    folder = Path(__file__).parents[2] / "benchmarks"
    monkeypatch_module.syspath_prepend(str(folder))
    spec = importlib.util.spec_from_file_location("events_missed", folder / "events_missed.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def monkeypatch_module() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        yield patch


@pytest.mark.parametrize(("which", "seed"), HARD)
def test_none_is_missed(which: int, seed: int, benchmark: Any) -> None:
    """Nor invented: between two samples there is an odd number of events where the sign changes."""
    found = benchmark.judged(benchmark.problems()[which], seed)
    assert found["crossings"] > 1000
    assert found["steps with several"] > 15
    assert (found["missed"], found["invented"], found["misplaced"]) == (0, 0, 0)


@pytest.mark.parametrize("tolerance", [0.0, 2.0**-56])
def test_a_middle_that_is_nearly_zero(tolerance: float, benchmark: Any) -> None:
    """Along a polynomial that is not exact the sign in the middle of a step may not be known."""
    ball = benchmark.problems()[0]
    method = gi.Gauss(8, iteration_tolerance=tolerance)
    section = gi.poincare_section(
        ball, ball.random_state(0), gi.Event("gamma[2]", "up"), 1000, method=method, step=1.4
    )
    assert abs(section.y[:, 5]).max() < 1e-14
    assert section.complete
