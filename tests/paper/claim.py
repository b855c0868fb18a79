"""Claims and their verdicts.

A claim's function returns the two sides of what is printed, at a point: ``(left, right)`` or
``(left, right, size)``. The residual is max|left − right| divided by the largest of |left|, |right|
and `size`, the size of the terms where both sides vanish, and at least by LEAST. With ``amended``
true the function returns the corrected or restricted statement instead.

The rule. With HOLDS and FAILS the two thresholds, and residuals the largest over all points and n:

====================================================  ================================
printed ≤ HOLDS (off the manifold too, if claimed)    holds
printed ≤ HOLDS on the manifold, ≥ FAILS off it       holds on the manifold only
printed ≥ FAILS, restricted ≤ HOLDS                   needs a restriction
printed ≥ FAILS, with a wider condition ≤ HOLDS       condition stronger than needed
printed ≥ FAILS, corrected ≤ HOLDS                    misprint
no function, but a reason                             not checkable numerically
anything else                                         unexplained: the audit has failed
====================================================  ================================

A *negative* claim says that two things differ: it holds if its residual is ≥ FAILS. A correction of
something that holds as printed is `unexplained` as well, and so is a residual between the
thresholds.

Every statement is evaluated off the manifold too, where |γ| ≠ 1 and (γ, p) ≠ 0: that residual is shown,
but it decides only about a statement that is made there (`everywhere`).

Several claims may show one *finding*: a formula that is misprinted, and what is said of it. They name
the first of them (`finding`), so that findings can be counted. A statement that holds may cite a
formula that does not (`cites`): then it holds of the formula as corrected, and its remark says so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .points import Point

__all__ = [
    "FAILS",
    "FINDINGS",
    "HOLDS",
    "ON_MANIFOLD",
    "VERDICTS",
    "Claim",
    "Result",
    "Section",
    "evaluate",
    "half",
    "residual",
]

HOLDS = 1e-12
FAILS = 1e-3
LEAST = 1e-3  # sizes below it count as this: the numbers of a random point are of order 1

TRUE, ON_MANIFOLD, RESTRICTED = "holds", "holds on the manifold only", "needs a restriction"
STRONGER, MISPRINT = "condition stronger than needed", "misprint"
UNCHECKED, UNEXPLAINED = "not checkable numerically", "unexplained"
FINDINGS = (ON_MANIFOLD, RESTRICTED, STRONGER, MISPRINT)
VERDICTS = (TRUE, *FINDINGS, UNCHECKED)
AMENDMENTS = {
    "misprint": MISPRINT,
    "restriction": RESTRICTED,
    "wider": STRONGER,
    "off_manifold": ON_MANIFOLD,
}

Sides = tuple[Any, ...]
Check = Callable[..., Sides]


@dataclass(frozen=True)
class Claim:
    """One statement of the paper.

    Attributes
    ----------
    label : str
        The source's own, or a descriptive one: ``remark:…``, ``proof:…``, ``text:…``.
    statement, section, lines : str
        What is said in a few words, under which heading, and where in the source.
    check : callable or None
        ``check(point)``, or ``check(point, amended)`` if there is an amendment.
    dimensions : sequence of int
    everywhere : bool
        The statement is made off T*S^(n−1) (or |γ| = 1) too.
    negative : bool
    verdict_if_amended : str or None
        The verdict if the printed form fails and the amended one holds.
    amendment, reason : str
        The amended form, or why nothing can be evaluated.
    finding : str
        The label of the claim that shows the same finding first; empty for that one.
    cites : tuple of str
        Labels of formulas that the statement cites and that do not hold as printed.
    """

    label: str
    statement: str
    section: str = ""
    lines: str = ""
    check: Check | None = None
    dimensions: Sequence[int] = range(2, 8)
    everywhere: bool = False
    negative: bool = False
    verdict_if_amended: str | None = None
    amendment: str = ""
    reason: str = ""
    finding: str = ""
    cites: tuple[str, ...] = ()


@dataclass(frozen=True)
class Result:
    """A claim with its verdict; residuals are the largest over the points, None if not evaluated.

    That off the manifold is infinite where the statement has no value there.
    """

    claim: Claim
    verdict: str
    residual: float | None = None
    off_manifold: float | None = None
    amended: float | None = None
    points: int = 0
    dimensions: tuple[int, ...] = ()

    @property
    def reason(self) -> str:
        """Why nothing was evaluated, or an empty string."""
        if self.claim.reason or self.verdict != UNCHECKED:
            return self.claim.reason
        return f"speaks of n = {', '.join(map(str, self.claim.dimensions))} only"

    @property
    def remark(self) -> str:
        """What is to be said beside the verdict, or an empty string."""
        claim = self.claim
        if claim.negative:
            return "they differ"
        if claim.cites and self.verdict == TRUE:
            labels = ", ".join(f"({label})" for label in claim.cites)
            return f"cites {labels}: true of what holds there, not of what is printed"
        return self.reason


class Section:
    """The claims of one part of the paper, in its order; `n` are the dimensions that most speak of."""

    def __init__(self, title: str, n: Sequence[int] = range(2, 8)) -> None:
        self.title, self.n = title, n
        self.claims: list[Claim] = []

    def __call__(
        self,
        label: str,
        statement: str,
        lines: str,
        *,
        n: Sequence[int] | None = None,
        **said: Any,
    ) -> Callable[[Check], Check]:
        """Register a function as a claim; at most one amendment, named by a key of `AMENDMENTS`.

        `off_manifold` is the form that holds off the manifold as well, `wider` a weaker condition under
        which the statement holds. Other keywords are fields of `Claim`.
        """
        amendments = {kind: said.pop(kind) for kind in said.keys() & AMENDMENTS.keys()}
        for kind, text in amendments.items():
            said |= {"verdict_if_amended": AMENDMENTS[kind], "amendment": text}
        assert len(amendments) <= 1, label
        dimensions = self.n if n is None else n

        def register(check: Check) -> Check:
            claim = Claim(label, statement, self.title, lines, check, dimensions, **said)
            self.claims.append(claim)
            return check

        return register

    def unchecked(self, label: str, statement: str, lines: str, reason: str) -> None:
        """Register a statement that cannot be evaluated, with the reason."""
        self.claims.append(Claim(label, statement, self.title, lines, reason=reason))


def residual(sides: Sides) -> float:
    """Return the relative difference of two sides; infinite if anything is not finite."""
    left, right = np.asarray(sides[0]), np.asarray(sides[1])
    sizes = [np.max(np.abs(part), initial=0.0) for part in (left, right, *sides[2:])]
    if not np.isfinite(sizes).all():
        return float("inf")
    return float(np.max(np.abs(left - right), initial=0.0) / max(LEAST, *sizes))


def half(check: Check, which: int) -> Check:
    """Return a check of the first (0) or second (1) half of both sides: of γ or p in (γ, p)."""
    return lambda point: tuple(np.split(np.asarray(side), 2)[which] for side in check(point))


def evaluate(claim: Claim, points: Sequence[Point]) -> Result:
    """Return the verdict on a claim at those of the points whose dimension it speaks of."""
    chosen = [point for point in points if point.n in claim.dimensions]
    if claim.check is None or not chosen:
        return Result(claim, UNCHECKED)
    on, off, amended = _residuals(claim, claim.check, chosen)
    dimensions = tuple(sorted({point.n for point in chosen}))
    return Result(
        claim, _verdict(claim, on, off, amended), on, off, amended, len(chosen), dimensions
    )


def _residuals(
    claim: Claim, check: Check, points: Sequence[Point]
) -> tuple[float, float, float | None]:
    """Return the residuals on the manifold and off it, and of the amended form where it is claimed."""

    def largest(places: Sequence[Point], *amended: bool) -> float:
        return max(residual(check(point, *amended)) for point in places)

    beyond = [point.off for point in points]
    printed = [False] if claim.verdict_if_amended else []
    on, off = largest(points, *printed), largest(beyond, *printed)
    claimed = [*points, *beyond] if claim.everywhere else points
    return on, off, largest(claimed, True) if claim.verdict_if_amended else None


def _verdict(claim: Claim, on: float, off: float, amended: float | None) -> str:
    if claim.negative:
        return TRUE if on >= FAILS else UNEXPLAINED
    explained = amended is None or amended <= HOLDS
    if on <= HOLDS:
        if off <= HOLDS or not claim.everywhere:
            return TRUE if claim.verdict_if_amended is None else UNEXPLAINED
        fits = off >= FAILS and explained and claim.verdict_if_amended in (None, ON_MANIFOLD)
        return ON_MANIFOLD if fits else UNEXPLAINED
    if on >= FAILS and claim.verdict_if_amended in (MISPRINT, RESTRICTED, STRONGER) and explained:
        return str(claim.verdict_if_amended)
    return UNEXPLAINED
