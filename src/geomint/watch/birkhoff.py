"""Averages along a motion by weights that vanish at both ends, and what they tell of it.

The mean of a function over N samples of a quasi-periodic motion differs from that over its torus by
1/N. With the weights ``w(s) = exp(−1/(s(1 − s)))``, s from 0 to 1 along the run, the difference falls
faster than any power of 1/N, if the frequencies are not too near to a resonance (S. Das, Y. Saiki,
E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111). Along a chaotic motion nothing falls faster than
1/√N. So the number of digits that a run and its halves agree in tells regular from chaotic motions
(E. Sander, J. D. Meiss, Physica D 411 (2020) 132569).
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import Array, as_array, positive
from ..errors import DomainError

FEWEST, ENOUGH = 16, 1000  # samples for an average, and to call a motion chaotic
DIGITS = 16.0  # more than float64 has are not told
# Digits beyond those of √N: from which on, up to which; those that four times as many samples bring.
REGULAR, CHAOTIC, GAIN = 4.0, 1.0, 1.5
RETURNS = 0.1  # of the range: less than that in both halves of a run, and it has not come back
STEADY = 1e-9  # of its size: what varies by less is a constant, with its rounding
# Radians: turns that may be wrapped to the other side of π; what is no less than half a turn.
NEAR_HALF, HALF = 3.0, np.pi - 1e-9


@dataclass(frozen=True)
class Average:
    """An average along a motion.

    Attributes
    ----------
    value : float, or array of shape (k,)
        Over the whole run.
    digits : float
        Decimal digits that the whole and its halves agree in, relative to the range of the samples; of
        several columns the fewest. The whole run is better than its halves. Columns that vary by less
        than 10⁻⁹ of their size, such as integrals, are not counted.
    gained : float
        How many of them the last three quarters of the run have brought.
    samples : int
        N.
    returning : bool
        Whether every column comes back: one whose halves share less than a tenth of its range, as an
        angle that grows or less than half a period, is no function along a bounded motion.
    """

    value: Any
    digits: float
    gained: float
    samples: int
    returning: bool = True

    @property
    def verdict(self) -> str:
        """``"regular"`` or ``"chaotic"`` by the digits, or ``"undecided"``.

        Chaotic motions have about ½ log₁₀ N digits, regular ones more. Four more are regular; up to one
        more that hardly grow with the run are chaotic, of a thousand samples or more that come back.
        Near resonances, and in few periods, regular motions have few digits too.
        """
        beyond = self.digits - 0.5 * float(np.log10(self.samples))
        if beyond >= REGULAR:
            return "regular"
        few = self.samples < ENOUGH or self.gained >= GAIN or not self.returning
        return "undecided" if few or beyond > CHAOTIC else "chaotic"


def birkhoff_average(values: Any) -> Average:
    """Return the average of samples at equal steps along a motion.

    Parameters
    ----------
    values : array_like, shape (N,) or (N, k)
        Such as components of the states, or of quantities, that a run with ``save_every=1`` has saved.

    Raises
    ------
    DomainError
        For fewer than 16 samples, and numbers that are not finite.

    Examples
    --------
    >>> import geomint as gi
    >>> scene = gi.load_scene("sphere-n3")
    >>> run = gi.solve(scene.problem, scene.state, t_end=2000.0, step=0.2, save_every=1)
    >>> gi.birkhoff_average(run.piece("gamma") ** 2).verdict
    'regular'
    """
    expected = f"at least {FEWEST} finite numbers, or rows of them"
    samples = as_array("values", values, expected)
    shaped = samples.ndim in (1, 2) and samples.size > 0 and len(samples) >= FEWEST
    if not (shaped and np.isfinite(samples).all()):
        raise DomainError("values", values, expected)
    columns = np.ascontiguousarray(samples.reshape(len(samples), -1).T)
    size = np.abs(columns).max(axis=1, keepdims=True)  # of each: one may be a rounding of another
    columns = columns / np.where(size > 0.0, size, 1.0)
    digits, before = _digits(columns), _digits(columns[:, : len(samples) // 4])
    value = size[:, 0] * _mean(columns)
    found = float(value[0]) if samples.ndim == 1 else value
    return Average(found, digits, digits - before, len(samples), _returns(columns))


def rotation_number(signal: Any, step: float = 1.0) -> Average:
    """Return how fast a signal turns about 0, on average.

    Of samples at equal steps along a motion that is a frequency of it, if the signal never comes near
    to 0: the one with which the angle grows. Of points of a section about the middle of an island,
    given as offsets from there, it is 2π times the island's rotation number.

    Parameters
    ----------
    signal : array_like, shape (N,) of complex numbers, or (N, 2)
        Points of the plane, such as two components of the states; of an angle φ ``np.exp(1j * φ)``.
    step : float
        Time between samples.

    Returns
    -------
    Average
        In radians per unit of time, from −π/step to π/step: faster turns cannot be told from slower
        ones by samples.

    Raises
    ------
    DomainError
        For fewer than 17 samples, numbers that are not finite, points at 0, samples between some of
        which the angle turns by half a turn more than between others, so that nobody can tell how often
        it has turned, and samples half a turn apart, of which nobody can tell whither.

    Examples
    --------
    >>> import numpy as np
    >>> import geomint as gi
    >>> t = 0.1 * np.arange(5000)
    >>> found = gi.rotation_number(np.exp(1j * np.sqrt(2) * t + 0.3j * np.sin(t)), 0.1)
    >>> print(f"{found.value:.12f}")
    1.414213562373
    """
    expected = (
        f"more than {FEWEST} finite points of the plane, complex or in 2 columns, none of them 0"
    )
    z = as_array("signal", signal, expected, np.complex128)
    if z.ndim == 2 and z.shape[1] == 2 and not z.imag.any():
        z = z[:, 0] + 1j * z[:, 1]
    good = z.ndim == 1 and len(z) > FEWEST and np.isfinite(z).all() and (z != 0.0).all()
    if not good:
        raise DomainError("signal", signal, expected)
    step = positive("step", step)
    largest = np.maximum(np.abs(z.real), np.abs(z.imag))
    z = times_power_of_two(z, -np.frexp(largest)[1])  # |z| may be no number, or lose digits
    directions = z / np.abs(z)
    turns = np.angle(directions[1:] * np.conj(directions[:-1]))
    if np.abs(turns).max() > NEAR_HALF:
        turns = _cut(turns, signal)
    found = birkhoff_average(turns)
    turn = in_a_turn(found.value)
    if abs(turn) >= HALF:
        said = "samples close enough to tell which way the angle turns: not half a turn apart"
        raise DomainError("signal", signal, said)
    value = turn / step
    if not math.isfinite(value):
        raise DomainError("step", step, "a time whose inverse is a number")
    return Average(value, found.digits, found.gained, found.samples, found.returning)


def _cut(turns: Array, signal: Any) -> Array:
    """Return angles that may be on both sides of π, but lie within half a turn."""
    middle = np.angle(np.exp(1j * turns).sum())
    beside = in_a_turn(turns - middle)
    if not np.ptp(beside) < np.pi:
        said = "samples close enough to tell by how much the angle has turned: not by any angle"
        raise DomainError("signal", signal, said)
    return middle + beside


def in_a_turn(angles: Any) -> Any:
    """Return angles from −π to π."""
    return (angles + np.pi) % (2.0 * np.pi) - np.pi


def times_power_of_two(z: Any, powers: Any) -> Any:
    """Return complex numbers times powers of two, which may be beyond what a number holds."""
    return np.ldexp(z.real, powers) + 1j * np.ldexp(z.imag, powers)


def _mean(rows: Array) -> Array:
    """Return weighted means; of what is left by the plain ones, so that the weights round little."""
    count = rows.shape[1]
    s = np.arange(1, count + 1) / (count + 1)
    w = np.exp(4.0 - 1.0 / (s * (1.0 - s)))  # 1 in the middle
    plain = rows.mean(axis=1)
    return plain + (w * (rows - plain[:, None])).sum(axis=1) / w.sum()


def _varies(rows: Array) -> tuple[Array, Array]:
    """Return the range of each row, and whether it is more than rounding."""
    spread = np.ptp(rows, axis=1)
    return spread, spread > STEADY * np.abs(rows).max(axis=1)


def _returns(rows: Array) -> bool:
    """Tell whether both halves of every row that varies share a part of its range."""
    half = rows.shape[1] // 2
    parts = (rows[:, :half], rows[:, -half:])
    shared = np.min([p.max(axis=1) for p in parts], axis=0) - np.max(
        [p.min(axis=1) for p in parts], axis=0
    )
    spread, varies = _varies(rows)
    return bool((shared >= RETURNS * spread)[varies].all())


def _digits(rows: Array) -> float:
    """Return how many digits the whole and both halves agree in: the fewest of all rows.

    Relative to what a row varies by, so that neither an offset nor another row makes a chaotic one look
    regular. The whole tells where halves are alike because each has whole periods.
    """
    half = rows.shape[1] // 2
    if half < 2:
        return 0.0
    spread, varies = _varies(rows)
    if not varies.any():
        return DIGITS
    means = np.array([_mean(part) for part in (rows, rows[:, :half], rows[:, -half:])])
    apart = float((np.ptp(means, axis=0)[varies] / spread[varies]).max())
    return min(max(-float(np.log10(max(apart, 1e-300))), 0.0), DIGITS)
