"""The roots of a motion's polynomial T, with as many digits as the arithmetic has.

All of them are real and between the first and the last α_g, and where several α_g are near to one
another there are about as many roots. From starts that are so the iteration takes 5 to 10 steps, in
clusters as elsewhere; from those of double precision it would first have to find the clusters.
"""

from __future__ import annotations

import itertools
from typing import Any

import mpmath

from ..manifold import Array

__all__ = ["mp", "real_roots"]

mp: Any = mpmath.mp.clone()  # type: ignore[no-untyped-call]
mp.dps = 40  # where nothing else is said
BESIDE = mp.mpf("0.2")  # of the next distance: starts of the iteration, off the real axis
ITERATIONS = 200
CONVERGED = mp.mpf("1e-18")  # steps over the distance of the next root; the next would be its cube


def real_roots(polynomial: list[Any], alpha: list[Any], paired: Array) -> list[Any] | None:
    """Return the real roots of T, whose leading coefficient (p̃, Ap̃) is positive.

    The iteration of Ehrlich and Aberth for all at once. None where it does not come to an end, or ends
    off the real axis: two of them cannot be separated with the digits that there are.
    """
    if len(polynomial) == 1:
        return []
    monic = [c / polynomial[-1] for c in polynomial]
    found = _starts(alpha, paired)
    for _ in range(ITERATIONS):
        try:
            change, off_axis = _improve(monic, found)
        except ZeroDivisionError:  # two are one
            return None
        if change < CONVERGED:
            return [mp.re(e) for e in found] if off_axis < CONVERGED else None
    return None


def _improve(monic: list[Any], found: list[Any]) -> tuple[Any, Any]:
    """Improve the roots; return the largest step and imaginary part over the next root's distance."""
    change, off_axis = mp.mpf(0), mp.mpf(0)
    for i, e in enumerate(found):
        value, slope, repelled, nearest = mp.mpc(0), mp.mpc(0), mp.mpc(0), abs(e)
        for c in reversed(monic):
            slope = slope * e + value
            value = value * e + c
        for s, other in enumerate(found):
            if s != i:
                repelled += 1 / (e - other)
                nearest = min(nearest, abs(e - other))
        step = value / (slope - value * repelled)
        found[i] = e - step
        change = max(change, abs(step) / nearest)
        off_axis = max(off_axis, abs(mp.im(found[i])) / nearest)
    return change, off_axis


def _starts(alpha: list[Any], paired: Array) -> list[Any]:
    """Return where to look for the roots: between neighbours, and beside each pair's α_g.

    So it is the right number wherever several are near, up to one or two.
    """
    starts = [(x + y) / 2 + mp.mpc(0, BESIDE) * (y - x) for x, y in itertools.pairwise(alpha)]
    widest = max(range(len(starts)), key=lambda k: float(alpha[k + 1] - alpha[k]))
    del starts[widest]
    for g, x in enumerate(alpha):
        if paired[g]:
            nearest = min(abs(x - y) for h, y in enumerate(alpha) if h != g)
            starts.append(x - mp.mpc(BESIDE, BESIDE) * nearest)
    return starts
