"""Events of long steps against samples: the motions at which some had been missed.

``benchmarks/events_missed.py`` does the same for a million crossings; these are those of its motions
where it found what is wrong with an estimate from one lower order (at an extremum it vanishes), with
values of bounded functions where states are not resolved, with a middle whose sign is not known, and
with slopes from values that rounding decides.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import geomint as gi

HARD = [(0, 1), (1, 4)]
LATER = [(0, 20), (0, 55), (0, 2), (1, 72), (0, 61), (0, 110), (0, 5108), (1, 2), (1, 14)]


@pytest.fixture(scope="module")
def benchmark() -> Iterator[Any]:
    """The benchmark as a module."""
    path = Path(__file__).parents[2] / "benchmarks" / "events_missed.py"
    spec: Any = importlib.util.spec_from_file_location("events_missed", path)
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(path.parent))
        spec.loader.exec_module(module)
        yield module


@pytest.mark.parametrize(
    ("which", "seed"), [*HARD, *(pytest.param(*x, marks=pytest.mark.nightly) for x in LATER)]
)
def test_none_is_missed(which: int, seed: int, benchmark: Any) -> None:
    """Nor invented: between two samples there is an odd number of events where the sign changes."""
    found = benchmark.judged(benchmark.problems()[which], seed)
    assert found["crossings"] > 1000
    assert found["steps with several"] > 15
    assert (found["missed"], found["invented"], found["misplaced"]) == (0, 0, 0)


@pytest.mark.parametrize("tolerance", [0.0, 2.0**-56])
def test_a_middle_that_is_nearly_zero(tolerance: float, benchmark: Any) -> None:
    """Along a polynomial that is not exact the sign in the middle of a step may not be known."""
    ball, event = benchmark.problems()[0], gi.Event("gamma[2]", "up")
    run = {"method": gi.Gauss(8, iteration_tolerance=tolerance), "step": 1.4}
    section = gi.poincare_section(ball, ball.random_state(0), event, 1000, **run)
    assert abs(section.y[:, 5]).max() < 1e-14
    assert section.complete
