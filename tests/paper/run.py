"""Evaluate all claims at random points."""

from __future__ import annotations

import functools
import importlib
import pkgutil
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .claim import FAILS, FINDINGS, UNEXPLAINED, Claim, Result, evaluate
from .points import Point, sample

__all__ = ["CLAIMS", "Audit", "audit"]

# The files of sections are named by their numbers: their order is the paper's.
_SECTIONS = sorted(
    m.name for m in pkgutil.iter_modules([str(Path(__file__).parent)]) if re.match(r"s\d", m.name)
)
CLAIMS: tuple[Claim, ...] = tuple(
    claim
    for name in _SECTIONS
    for claim in importlib.import_module(f".{name}", __package__).claim.claims
)


@dataclass(frozen=True)
class Audit:
    """What an audit has found.

    Attributes
    ----------
    results : tuple of Result
    dimensions : tuple of int
    points : int
        How many random points each claim has at least, on the manifold and as many off it.
    seed : int
    seconds : float
    """

    results: tuple[Result, ...]
    dimensions: tuple[int, ...]
    points: int
    seed: int
    seconds: float

    @property
    def findings(self) -> dict[str, list[Result]]:
        """What does not hold as printed: the claims that show it, by the first label."""
        found: dict[str, list[Result]] = {}
        for result in self.results:
            if result.verdict in FINDINGS:
                found.setdefault(result.claim.finding or result.claim.label, []).append(result)
        return found

    @property
    def unexplained(self) -> list[Result]:
        """The results that make the audit fail."""
        return [result for result in self.results if result.verdict == UNEXPLAINED]

    @property
    def gap(self) -> tuple[float, float]:
        """The largest residual of anything that holds, and the least of anything that fails."""
        values = [
            x
            for r in self.results
            for x in (r.residual, r.off_manifold if r.claim.everywhere else None, r.amended)
            if x is not None
        ]
        below, above = [x for x in values if x < FAILS], [x for x in values if x >= FAILS]
        return max(below, default=0.0), min(above, default=float("inf"))


def audit(
    dimensions: Sequence[int] = range(2, 8),
    points: int = 20,
    seed: int = 0,
    claims: Sequence[Claim] = CLAIMS,
    progress: Callable[[int, int], None] | None = None,
) -> Audit:
    """Evaluate each claim at `points` random points or more, spread evenly over its dimensions.

    Parameters
    ----------
    dimensions : sequence of int
        2 … 7 by default; each claim takes those that it speaks of.
    points : int
    seed : int
        The same numbers give the same points, bit for bit, on one machine.
    claims : sequence of Claim
    progress : callable
        Called with the number of claims done and their total.
    """
    start = time.perf_counter()
    place = functools.cache(lambda n, index: sample(n, index, seed))
    results = []
    with np.errstate(all="ignore"):  # residuals show what matters
        for done, claim in enumerate(claims, 1):
            results.append(evaluate(claim, _places(claim, dimensions, points, place)))
            if progress is not None:
                progress(done, len(claims))
    seconds = time.perf_counter() - start
    return Audit(tuple(results), tuple(dimensions), points, seed, seconds)


def _places(
    claim: Claim, dimensions: Sequence[int], points: int, place: Callable[[int, int], Point]
) -> list[Point]:
    """Return the points of a claim, as many in each of its dimensions."""
    chosen = [n for n in dimensions if n in claim.dimensions]
    each = -(-points // max(len(chosen), 1))
    return [place(n, index) for n in chosen for index in range(each)]
