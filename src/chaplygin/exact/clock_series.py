"""The Fourier series of physical time, on tori of up to four or five dimensions.

D√U is a product of functions of one θ_k each, as is e^{im·φ}, and φ is a sum of such functions. So with
the Jacobian of θ ↦ φ every coefficient is a determinant of one-dimensional integrals,

    f_m = D/√Πα det_jk [(1/2π) ∫ √λ_k ∂φ_j/∂θ_k e^{−i(m_kθ_k + m·shift_k(θ_k))} dθ_k],

and is computed where it is large enough to matter: from m = 0 outwards. How much work that is shows as
it goes on, and it ends with an error before it is too much.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.fft

import geomint as gi

from ..manifold import Array
from .clock import QUIET, Clock, Sampled, refuse_slow
from .clock_functions import product_integral, product_rows
from .packing import evaluated
from .torus import Torus

Wave = tuple[int, ...]  # m, a number for each angle
COMPLETE = 2e-15  # of the mean, times the root of their number: nothing is missing from a series
MOST_PATIENCE = 3
MOST_MODES, MOST_IN_LAYER = 200_000, 20_000  # layers are those of equal Σ|m_k|
FEWEST_POINTS, POINTS_PER_TERM = 128, 3  # of the one-dimensional integrals
MOST_NUMBERS, MOST_WORK = 2**24, 2e9  # in tables; multiplications, some seconds
FIRST_BOUND = 24  # largest m_k of the first tables
CHECKS = 16  # angles at which a series is compared


def product_clock(torus: Torus, scale: float, rate: Sampled) -> Clock:
    """Return the clock of dt/dτ = scale Π √λ_k.

    Parameters
    ----------
    torus : Torus
    scale : float
    rate : callable
        dt/dτ at angles φ, shape (N, d) ↦ (N,): the series is compared with it.

    Raises
    ------
    geomint.DomainError
        Where too many coefficients matter, or the series is not what it should be: next to a
        separatrix.
    """
    size = len(torus.middle)
    integrals = _Integrals(torus)
    mean = scale * float(integrals(np.zeros((1, size)))[0])
    phi = np.random.default_rng(size).uniform(0.0, 2.0 * np.pi, (CHECKS, size))
    expected = rate(phi)
    for patience in range(MOST_PATIENCE + 1):
        waves, coefficients = _series(torus, integrals, scale, mean, patience)
        found = np.array([mean + np.cos(waves @ x) @ coefficients.real for x in phi])
        edge = float(np.max(np.abs(found - expected))) / abs(mean)
        if edge <= COMPLETE * np.sqrt(1.0 + len(waves)):
            break
    refuse_slow(edge, torus)
    return Clock(mean, waves, coefficients, 1, edge)


def _series(
    torus: Torus, integrals: _Integrals, scale: float, mean: float, patience: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.complex128]]:
    """Return the m and 2f_m that matter, from m = 0 outwards.

    Beyond m that do not matter it goes on for some steps, `patience` of them: next to symmetries there
    are gaps between those that do.
    """
    size = len(torus.middle)
    quiet = {(0,) * size: 0}  # steps since one that mattered
    waves, values = [np.zeros((0, size), dtype=np.int64)], [np.zeros(0)]
    layer, count = _neighbours([(0,) * size], quiet), 0
    while layer:
        if len(layer) > MOST_IN_LAYER or count > MOST_MODES:
            raise _too_many(torus, f"there are more than {count}")
        block = np.array(layer, dtype=np.int64)
        found = scale * integrals(block)
        loud = np.abs(found) > QUIET * abs(mean)
        waves.append(block[loud])
        values.append(found[loud])
        count += int(np.count_nonzero(loud))
        for m, matters in zip(layer, loud.tolist(), strict=True):
            quiet[m] = 0 if matters else quiet[m] + 1
        # Some of the first vanish by symmetry.
        outward = [m for m in layer if quiet[m] <= patience or sum(map(abs, m)) < 3]
        outward = [m for m in outward if max(map(abs, m)) < integrals.points]
        layer = _neighbours(outward, quiet)
    return np.concatenate(waves), 2.0 * np.concatenate(values).astype(np.complex128)


def _too_many(torus: Torus, found: str) -> gi.DomainError:
    expected = (
        "a motion whose time has few enough Fourier coefficients that matter, or a call of at_tau, "
        f"which takes any; {found}, and the narrowest strip of analyticity is "
        f"{float(np.min(torus.strips)):.2g}"
    )
    return gi.DomainError("state", torus.middle, expected)


def _neighbours(waves: list[Wave], quiet: dict[Wave, int]) -> list[Wave]:
    """Return the m next to given ones and farther out that are new, one of each pair ±m.

    They are noted with the fewest quiet steps of those next to which they are.
    """
    found: dict[Wave, int] = {}
    for m in waves:
        for k, value in enumerate(m):
            for step in (1, -1):
                if value * step < 0:
                    continue
                other = (*m[:k], value + step, *m[k + 1 :])
                if next((x for x in other if x), 0) > 0 and (other in found or other not in quiet):
                    found[other] = quiet[other] = min(quiet[m], found.get(other, quiet[m]))
    return sorted(found)


class _Integrals:
    """The determinants of `product_clock`, for many m at once, compiled.

    Beyond |m_k| = `points` they are those of smaller m. Powers of e^{iφ_j} at the points of integration
    are kept in tables, which grow as m does.
    """

    def __init__(self, torus: Torus) -> None:
        self._torus, self._left = torus, MOST_WORK
        self._columns = [_column(torus, k) for k in range(len(torus.middle))]
        self.points = min((phases.shape[1] for phases, _ in self._columns), default=0)
        self._bound = 0
        self._params = np.zeros(0)

    def __call__(self, waves: npt.NDArray[np.float64] | npt.NDArray[np.int64]) -> Array:
        """Return the determinant of m, shape (M, d) ↦ (M,)."""
        size = len(self._columns)
        if size == 0:
            return np.ones(len(waves))
        largest = int(np.max(np.abs(waves)))
        points = sum(phases.shape[1] for phases, _ in self._columns)
        self._left -= float(len(waves)) * points * size
        if self._left < 0.0:
            raise _too_many(self._torus, f"they take more than {MOST_WORK:.0g} multiplications")
        if largest > self._bound or not self._params.size:
            self._bound = max(FIRST_BOUND, 2 * largest)
            if 2.0 * self._bound * points * size > MOST_NUMBERS:
                raise _too_many(self._torus, f"they reach as far as m = {largest}")
            self._params = self._tables()
        most = max(phases.shape[1] for phases, _ in self._columns)
        work = 2 * most + size * size
        return evaluated(product_integral, self._params, waves, 1, work)[:, 0]

    def _tables(self) -> Array:
        """Return the parameters of `product_integral`."""
        size = len(self._columns)
        parts = []
        for phases, weights in self._columns:
            powers = np.arange(self._bound + 1)[:, None] * phases[:, None, :]
            waves = np.stack([np.cos(powers), np.sin(powers)], axis=2)  # j, m, cos or sin, point
            parts.append(np.concatenate([weights.T.reshape(-1), waves.reshape(-1)]))
        counts, tables = [phases.shape[1] for phases, _ in self._columns], np.concatenate(parts)
        rows = product_rows(size)
        return gi.packed(rows, size=size, bound=self._bound, counts=counts, tables=tables).data


def _column(torus: Torus, k: int) -> tuple[Array, Array]:
    """Return φ_j as far as θ_k makes it, (d, N), and √λ_k ∂φ_j/∂θ_k, weighted, (N, d).

    Over half of the circle: the phases are odd and the rest is even. As many points as the waves
    that matter want, which do not reach much further than the terms of the shifts.
    """
    size, series = len(torus.middle), torus.shifts[k][: len(torus.middle)]
    terms = series.shape[1]
    count = max(FEWEST_POINTS, POINTS_PER_TERM * terms)
    theta = np.pi * (np.arange(count) + 0.5) / count
    own = (np.arange(size) == k)[:, None]
    sines, cosines = np.zeros((2, size, count))
    sines[:, :terms] = 0.5 * series
    cosines[:, 1 : terms + 1] = 0.5 * series * np.arange(1, terms + 1)
    phases = own * theta + scipy.fft.dst(sines, type=3)
    slopes = own + scipy.fft.dct(cosines, type=3)
    lam = torus.branch_gaps[k, 0] + 2.0 * torus.radius[k] * np.sin(0.5 * theta) ** 2
    return phases, (slopes * np.sqrt(lam) / count).T
