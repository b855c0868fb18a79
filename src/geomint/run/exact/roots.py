"""Roots of a function of time, all of them: along pieces, by Chebyshev's and Bernstein's coefficients.

On every piece the function is known at nine points. The polynomial through them is taken for it if its
Chebyshev coefficients decay, to what the last of them say is left out. Bernstein's coefficients bound
it: all of one sign, by more than that: no root; one change of sign: one root. Else the piece is halved.
It is the rule by which events of steps are found (`geomint.kernels.solve.events`), where only real
steps can say what a value is; here every value is as good as any other, and many are asked for at once.

The sign of 0 is that before: a root exactly where two pieces meet counts once, where the sign has
changed, and one where the motion begins does not count.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...arguments import Array, Booleans, Integers
from .polynomials import judged, points_of, polynomial

Values = Callable[[Array], Array]

MOST_IN_PIECE = 64  # roots
ROUNDING = 2.0**-49  # of the function's size
TIMES = 8.0  # roundings of the time, over a piece
TOUCH = 2.0**-40  # of the function's size: values no larger do not decide
NARROWEST = 2.0**-22  # of a piece
ROUGH = 2.0**-20  # of the function's size: where narrow parts are larger, it jumps
TOGETHER = 8  # pieces that are halved at once
LARGEST = 1e308
# A root with a smaller slope, in parts of the values beside it over their distance, may be multiple.
PLAIN = 2.0**-10
MOST = 100  # values at a root


class Failure(NamedTuple):
    """Which piece cannot be told, when, how large the function is there, and why."""

    piece: int
    time: float
    value: float
    why: str


class Found(NamedTuple):
    """Times of roots in their order, 1 where the function rises and −1 where it falls."""

    times: Array
    directions: Array
    failure: Failure | None


class _Parts(NamedTuple):
    """Parts of pieces: ends, of which piece; values; the first sign, and whether there is one root."""

    low: Array
    high: Array
    piece: Integers
    values: Array
    first: Array
    one: Booleans

    def of(self, which: Any) -> _Parts:
        """Return some of them."""
        return _Parts._make(own[which] for own in self)

    @property
    def size(self) -> Array:
        """The largest |value| of each."""
        return np.abs(self.values).max(axis=1, initial=0.0)


class Roots:
    """The roots of one function along a motion, whose pieces come one after the other.

    Parameters
    ----------
    span : float
        The length of a piece, > 0; the last one may be shorter.
    """

    def __init__(self, span: float) -> None:
        self._span = span
        # The largest |value| so far; the last sign that was not 0, and up to when it is known.
        self._size = self._sign = self._until = 0.0

    def within(self, edges: Array, known: Array, values: Values) -> Found:
        """Return the roots between edges.

        Parameters
        ----------
        edges : array, shape (m + 1,)
            Of pieces, in the order of the run.
        known : array, shape (m, 9)
            Values at the `points_of` the pieces.
        values : callable
            Of times, shape (k,) ↦ (k,).
        """
        low, high = edges[:-1], edges[1:]
        largest = np.abs(known).max(axis=1)
        sizes = np.maximum.accumulate(
            np.maximum(np.where(largest < LARGEST, largest, 0.0), self._size)
        )
        noise = ROUNDING + TIMES * np.spacing(np.maximum(np.abs(low), np.abs(high))) / self._span
        search = _Search(sizes, noise * sizes, NARROWEST * self._span)
        # Halving is done for few pieces at once: if one of them cannot be told, later ones are not.
        ahead = [_parts(low, high, np.arange(len(low)), known)]
        while ahead:
            halves = search.taken(ahead.pop())
            if search.failure is not None:
                ahead.clear()
            points = points_of(halves.low, halves.high)
            found = values(points.reshape(-1)).reshape(points.shape)
            ahead += _in_groups(halves._replace(values=found))
        if len(sizes):
            self._size = float(sizes[-1])
        parts = search.found
        order = np.argsort(parts.low * (1.0 if edges[-1] > edges[0] else -1.0), kind="stable")
        return self._told(parts.of(order), values, search.failure)

    def _told(self, parts: _Parts, values: Values, failure: Failure | None) -> Found:
        """Return the roots of parts in their order, each with one root or none."""
        last = np.where(parts.one, -parts.first, parts.first)
        before = np.concatenate([[self._sign], last[:-1]])[: len(last)]
        until = np.concatenate([[self._until], parts.high])[: len(last)]
        # The root was where the part begins, or in what was too small to decide.
        edges, inside = np.flatnonzero(before == -parts.first), parts.of(parts.one)
        signed = np.argmax(parts.values * parts.first[:, None] > 0.0, axis=1)
        ends = points_of(parts.low, parts.high)[edges, signed[edges]]
        small = _Bracket(until[edges], ends, parts.first[edges], parts.size[edges])
        known = _Bracket(inside.low.copy(), inside.high.copy(), -inside.first, inside.size)
        at_edges = _met(small, 0.5 * (small.a + small.b), 0.0 * ends, values)
        times = np.concatenate([at_edges, _met(known, *_guessed(inside), values)])
        directions = np.concatenate([parts.first[edges], -inside.first])
        which = np.concatenate([edges, np.flatnonzero(parts.one)])
        order = np.argsort(which, kind="stable")
        if len(last):
            self._sign, self._until = float(last[-1]), float(parts.high[-1])
        return Found(times[order], directions[order], failure)


class _Search:
    """What is known of pieces so far.

    Parameters
    ----------
    sizes, roundings : array, shape (m,)
        Of the function along each piece, the largest so far; to what its values are known.
    narrowest : float
        How long parts are of which nothing is decided any more.
    """

    def __init__(self, sizes: Array, roundings: Array, narrowest: float) -> None:
        self._sizes, self._roundings, self._narrowest = sizes, roundings, narrowest
        self._roots = np.zeros(len(sizes), dtype=np.int64)
        self._decided: list[_Parts] = []
        self.failure: Failure | None = None

    @property
    def found(self) -> _Parts:
        """All parts with one root or none, up to the piece that cannot be told."""
        return self._before(_joined(self._decided))

    def taken(self, parts: _Parts) -> _Parts:
        """Decide what can be decided of parts; return the halves of the others, without values."""
        self._note(_not_finite(parts))
        self._note(self._crowded(parts))
        parts = self._before(parts)
        parts = parts.of(parts.size > TOUCH * self._sizes[parts.piece])
        first, one, sure = judged(parts.values, self._roundings[parts.piece])
        parts = parts._replace(first=first, one=one)
        self._decided.append(parts.of(sure))
        np.add.at(self._roots, parts.piece[sure & one], 1)
        parts = parts.of(~sure)
        resolution = 16.0 * np.spacing(np.maximum(np.abs(parts.low), np.abs(parts.high)))
        wide = np.abs(parts.high - parts.low) > np.maximum(self._narrowest, resolution)
        self._note(_rough(parts.of(~wide & (parts.size > ROUGH * self._sizes[parts.piece]))))
        return _halves(self._before(parts.of(wide)))

    def _note(self, failure: Failure | None) -> None:
        if failure is not None and (self.failure is None or failure.piece < self.failure.piece):
            self.failure = failure

    def _before(self, parts: _Parts) -> _Parts:
        return parts if self.failure is None else parts.of(parts.piece < self.failure.piece)

    def _crowded(self, parts: _Parts) -> Failure | None:
        """Return the first piece with more roots, or parts of which nothing is known, than may be."""
        count = self._roots + np.bincount(parts.piece, minlength=len(self._roots))
        crowded = np.flatnonzero(count[parts.piece] > MOST_IN_PIECE)
        if not len(crowded):
            return None
        i = crowded[np.argmin(parts.piece[crowded])]
        why = f"is 0 more than {MOST_IN_PIECE} times in a quarter of a period, or may be"
        return Failure(int(parts.piece[i]), float(parts.low[i]), 0.0, why)


def _parts(low: Array, high: Array, piece: Integers, values: Array) -> _Parts:
    count = len(low)
    return _Parts(low, high, piece, values, np.zeros(count), np.zeros(count, dtype=bool))


def _joined(parts: list[_Parts]) -> _Parts:
    return _Parts._make(map(np.concatenate, zip(*parts, strict=True)))


def _in_groups(parts: _Parts) -> list[_Parts]:
    """Return parts of some pieces each, the earliest last; none without parts."""
    pieces = np.unique(parts.piece)
    firsts = pieces[::TOGETHER]
    group = np.searchsorted(firsts, parts.piece, side="right")
    return [parts.of(group == k) for k in range(len(firsts), 0, -1)]


def _halves(parts: _Parts) -> _Parts:
    middle = parts.low + 0.5 * (parts.high - parts.low)
    low, high = np.concatenate([parts.low, middle]), np.concatenate([middle, parts.high])
    return _parts(low, high, np.concatenate([parts.piece, parts.piece]), np.zeros((len(low), 0)))


def _not_finite(parts: _Parts) -> Failure | None:
    bad = ~(np.abs(parts.values) < LARGEST)
    rows = np.flatnonzero(bad.any(axis=1))
    if not len(rows):
        return None
    i = rows[np.argmin(parts.piece[rows])]
    times, k = points_of(parts.low[i : i + 1], parts.high[i : i + 1])[0], int(np.argmax(bad[i]))
    why = "is not a finite number"
    return Failure(int(parts.piece[i]), float(times[k]), float(parts.values[i, k]), why)


def _rough(parts: _Parts) -> Failure | None:
    if not len(parts.low):
        return None
    i = int(np.argmin(parts.piece))
    why = "changes too fast to tell how often it is 0: it may jump"
    return Failure(int(parts.piece[i]), float(parts.low[i]), float(parts.size[i]), why)


class _Bracket(NamedTuple):
    """Times with one root each between them; the sign at b, which is not that at a; |values| beside."""

    a: Array
    b: Array
    sign: Array
    size: Array


def _guessed(parts: _Parts) -> tuple[Array, Array]:
    """Return where polynomials with one root each are 0, and their slopes."""
    low, high = np.zeros(len(parts.low)), np.ones(len(parts.low))
    for _ in range(30):
        middle = 0.5 * (low + high)
        beyond = polynomial(parts.values, middle) * parts.first <= 0.0
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    span = parts.high - parts.low
    rise = polynomial(parts.values, low + 1e-4) - polynomial(parts.values, low - 1e-4)
    return parts.low + low * span, rise / (2e-4 * span)


def _met(bracket: _Bracket, times: Array, slopes: Array, values: Values) -> Array:
    """Return where the function turns to the sign at b, from times on: the sign of 0 is that before.

    By the secant method where the slope is plain, and stays about what it is at first; else roots may
    be multiple, and moves get small far away from them: there the bracket is halved.
    """
    a, b, sign, size = bracket
    span, first = b - a, 0.25 * np.abs(slopes)
    active, before, at = np.arange(len(times)), np.zeros(len(times)), np.full(len(times), np.nan)
    plain = np.abs(slopes * span) > PLAIN * size
    for k in range(MOST):
        if not len(active):
            break
        t, value = times[active], values(times[active])
        change, rise = t - at[active], value - before[active]
        with np.errstate(all="ignore"):
            secant = rise / change
            slope = np.where(np.isfinite(secant) & (secant != 0.0), secant, slopes[active])
            step = -value / slope
        slopes[active], before[active], at[active] = slope, value, t
        plain[active] &= np.abs(slope) > first[active]
        beyond = value * sign[active] > 0.0
        a[active], b[active] = np.where(beyond, a[active], t), np.where(beyond, t, b[active])
        least = np.maximum(2.0**-48 * np.abs(span[active]), 0.5 * np.spacing(np.abs(t)))
        near = plain[active] & (value != 0.0) & (np.abs(step) <= least)
        within = ~near & (np.abs(b - a)[active] <= 2.0 * least)
        ahead = t + step
        strayed = ~((ahead - a[active]) * (ahead - b[active]) < 0.0) | (k % 8 == 7)
        ahead = np.where(strayed | ~plain[active], 0.5 * (a + b)[active], ahead)
        times[active] = np.where(near, t, np.where(within, a[active], ahead))
        active = active[~(near | within)]
    return times
