"""The roots of a motion's polynomial T, in fixed-point arithmetic of as many bits as one asks for.

All of them are real and between the first and the last α_g, and where several α_g are near to one
another there are about as many roots. From starts that are so the iteration takes 5 to 10 steps, in
clusters as elsewhere; from those of double precision it would first have to find the clusters.

Numbers are whole ones over 2^bits: α_g ≤ 1, so that none is large.
"""

import itertools

from ..manifold import Array

BESIDE = 5  # the next distance over it: starts of the iteration, off the real axis
ITERATIONS = 200
CONVERGED = 10**18  # the next root's distance over a step: the next step would be over its cube


def real_roots(monic: list[int], alpha: list[int], paired: Array, bits: int) -> list[int] | None:
    """Return the real roots of T over its leading coefficient, from its coefficients, ascending.

    The iteration of Ehrlich and Aberth for all at once. None where it does not come to an end, or ends
    off the real axis: two of them cannot be separated with the bits that there are.
    """
    if len(monic) < 3:
        return [-c for c in monic[:-1]]
    found = _starts(alpha, paired)
    for _ in range(ITERATIONS):
        try:
            done = _improve(monic, found, bits)
            if done:
                _improve(monic, found, bits)
        except ZeroDivisionError:  # two are one
            return None
        if done:
            real = all(CONVERGED * abs(y) <= _nearest(found, i) for i, (_, y) in enumerate(found))
            return [x for x, _ in found] if real else None
    return None


def _improve(monic: list[int], found: list[tuple[int, int]], bits: int) -> bool:
    """Improve the roots; return whether the steps were small enough to be the last but one."""
    small = True
    for i, (x, y) in enumerate(found):
        value, slope, over = (monic[-1], 0), (0, 0), (0, 0)
        for c in monic[-2::-1]:
            u, v = value
            slope = (
                ((slope[0] * x - slope[1] * y) >> bits) + u,
                ((slope[0] * y + slope[1] * x) >> bits) + v,
            )
            value = ((u * x - v * y) >> bits) + c, (u * y + v * x) >> bits
        for s, (u, v) in enumerate(found):
            if s != i:
                away = _quotient((1 << bits, 0), (x - u, y - v), bits)
                over = over[0] + away[0], over[1] + away[1]
        u, v = value
        below = (
            slope[0] - ((u * over[0] - v * over[1]) >> bits),
            slope[1] - ((u * over[1] + v * over[0]) >> bits),
        )
        u, v = _quotient(value, below, bits)
        found[i] = x - u, y - v
        small = small and CONVERGED * max(abs(u), abs(v)) <= _nearest(found, i)
    return small


def _quotient(a: tuple[int, int], b: tuple[int, int], bits: int) -> tuple[int, int]:
    square = b[0] * b[0] + b[1] * b[1]
    return (
        ((a[0] * b[0] + a[1] * b[1]) << bits) // square,
        ((a[1] * b[0] - a[0] * b[1]) << bits) // square,
    )


def _nearest(found: list[tuple[int, int]], i: int) -> int:
    """Return about how far it is from a root to the next one, or to 0."""
    x, y = found[i]
    others = (max(abs(x - u), abs(y - v)) for s, (u, v) in enumerate(found) if s != i)
    return min([max(abs(x), abs(y)), *others])


def _starts(alpha: list[int], paired: Array) -> list[tuple[int, int]]:
    """Return where to look for the roots: between neighbours, and beside each pair's α_g.

    So it is the right number wherever several are near, up to one or two.
    """
    starts = [((x + y) // 2, (y - x) // BESIDE) for x, y in itertools.pairwise(alpha)]
    widest = max(range(len(starts)), key=lambda k: alpha[k + 1] - alpha[k])
    del starts[widest]
    for g, x in enumerate(alpha):
        if paired[g]:
            beside = min(abs(x - y) for h, y in enumerate(alpha) if h != g) // BESIDE
            starts.append((x - beside, -beside))
    return starts
