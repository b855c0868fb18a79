"""The methods: Gauss collocation, and explicit ones as baselines."""

import functools
from typing import Any

import numpy as np

from ..tableaux import RUNGE_KUTTA, gauss_legendre
from .solver import FixedStep
from .steps import explicit, gauss


class _Gauss(FixedStep):
    stages: int
    kernel = staticmethod(gauss)

    @classmethod
    def coefficients(cls) -> tuple[Any, Any, Any]:
        table = gauss_legendre(cls.stages)
        return table.mu, table.b, table.c

    def guess(self, t: float, y: Any, h: float) -> Any:
        self.nfev += 1
        return np.outer(h * self.tables[1], self._function(t, y))

    def predicted(self, increments: Any) -> Any:
        return _predictor(self.stages) @ increments

    def guess_within(self, increments: Any, theta: float) -> Any:
        powers = theta ** np.arange(1, self.stages + 1)
        return np.tensordot(powers, gauss_legendre(self.stages).between, 1) @ increments


@functools.cache
def _predictor(stages: int) -> Any:
    return gauss_legendre(stages).predictor(1.0)


class GAUSS1(_Gauss):
    """The implicit midpoint rule: symplectic, symmetric, order 2; `geomint.Gauss` (1)."""

    stages, order = 1, 2


class GAUSS2(_Gauss):
    """Gauss collocation with two stages: symplectic, symmetric, order 4; `geomint.Gauss` (2)."""

    stages, order = 2, 4


class GAUSS4(_Gauss):
    """Gauss collocation with four stages: symplectic, symmetric, order 8; `geomint.Gauss` (4)."""

    stages, order = 4, 8


class GAUSS6(_Gauss):
    """Gauss collocation with six stages: symplectic, symmetric, order 12; `geomint.Gauss` (6)."""

    stages, order = 6, 12


class GAUSS8(_Gauss):
    """Gauss collocation with eight stages: symplectic, symmetric, order 16; `geomint.Gauss` (8)."""

    stages, order = 8, 16


class _Explicit(FixedStep):
    table: str
    kernel = staticmethod(explicit)

    @classmethod
    def coefficients(cls) -> tuple[Any, Any, Any]:
        table = RUNGE_KUTTA[cls.table]
        used = table.used_stages
        rows = np.ascontiguousarray(table.A_float[:used, :used])
        return rows, table.b_float[:used].copy(), table.c_float[:used].copy()


class RK4(_Explicit):
    """The classical Runge–Kutta method, order 4, at a fixed step: a baseline that preserves nothing."""

    table, order = "rk-4", 4


class DOP853(_Explicit):
    """Dormand's and Prince's method of order 8 at a fixed step; SciPy's own varies it."""

    table, order = "dop853", 8
