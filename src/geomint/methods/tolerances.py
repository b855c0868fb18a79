"""What adaptive methods may err: tolerances, bounds of the steps, and the first step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import Array, finite, switch, whole
from ..errors import DomainError, MethodError
from ..problems.evaluate import derivative
from ..problems.problem import Problem
from ..tableaux import Tableau

__all__ = ["Tolerances", "tolerances"]

LEAST_RTOL, LARGEST_RTOL = 2.0**-50, 0.1


@dataclass(frozen=True)
class Tolerances:
    """What a step may err, how long it may be, and how many there may be.

    The estimated error of a step must not exceed ``atol + rtol max |y_i|`` in any piece of the state,
    with y_i the rows of the piece before and after the step.
    """

    rtol: float = 1e-8
    atol: float = 1e-12
    max_step: float = math.inf
    max_steps: int = 10**8

    def __post_init__(self) -> None:
        if not LEAST_RTOL <= self.rtol <= LARGEST_RTOL:
            raise DomainError("rtol", self.rtol, "a number from 2⁻⁵⁰ = 8.9e-16 to 0.1")
        if not 0.0 <= self.atol < math.inf:
            raise DomainError("atol", self.atol, "a number ≥ 0")
        if not self.max_step > 0.0:
            raise DomainError("max_step", self.max_step, "a number > 0")

    def first_step(self, order: int, problem: Problem, y0: Array, end: float) -> float:
        """Return the length of a first step towards `end`, for a method of some order.

        The algorithm of Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, Section
        II.4: the explicit Euler method would make an error of the tolerance's size, from estimates
        of two derivatives.
        """
        sizes = np.zeros(problem.rows)
        for rows in problem.slices.values():
            sizes[rows] = np.max(np.abs(y0[rows]))
        allowed = self.atol + self.rtol * sizes
        allowed[allowed == 0.0] = math.inf

        def norm(v: Array) -> float:
            return float(np.max(np.abs(v) / allowed))

        with np.errstate(all="ignore"):
            slope = derivative(problem, y0)
            d0, d1 = norm(y0), norm(slope)
            h0 = 0.01 * d0 / d1 if min(d0, d1) > 1e-5 else 1e-6
            h0 = math.copysign(min(h0, abs(end)), end)
            d2 = norm(derivative(problem, y0 + h0 * slope, h0) - slope) / abs(h0)
            largest = max(d1, d2)
            h1 = (0.01 / largest) ** (1.0 / (order + 1)) if largest > 1e-15 else 1e-3 * abs(h0)
        h = min(100.0 * abs(h0), h1, self.max_step, abs(end))
        return h if 0.0 < h < math.inf else 1e-6 * abs(end)


def tolerances(
    table: Tableau,
    adaptive: bool,
    rtol: float | None,
    atol: float | None,
    max_step: float | None,
    max_steps: int | None,
) -> Tolerances | None:
    """Return what the options of a method say, None for fixed steps; or raise."""
    named: dict[str, Any] = {"rtol": rtol, "atol": atol, "max_step": max_step}
    named["max_steps"] = max_steps
    given = {name: value for name, value in named.items() if value is not None}
    if not switch("adaptive", adaptive):
        if given:
            raise MethodError(f"{', '.join(given)}: only with adaptive=True")
        return None
    if table.estimate_order is None:
        raise MethodError(f"tableau {table.name!r} has no embedded method to estimate errors with")
    limit = whole("max_steps", given.pop("max_steps", Tolerances.max_steps), 1)
    return Tolerances(**{name: _real(name, x) for name, x in given.items()}, max_steps=limit)


def _real(name: str, value: Any) -> float:
    """Return a number, which may be infinite as `max_step` is, or raise `DomainError`."""
    endless = isinstance(value, float) and math.isinf(value)
    return float(value) if endless else finite(name, value, "a number")
