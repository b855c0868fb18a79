"""Steps chosen by the error that they make."""

import math
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from ..arguments import Array, finite, whole
from ..errors import DomainError, MethodError
from ..problems.evaluate import Rate, derivative
from ..problems.problem import Problem
from .flow import Flow
from .method import Method, checked_method
from .posed import Posed

LEAST_RTOL, LARGEST_RTOL = 2.0**-50, 0.1
_TINY = 1e-300  # where a rate overflows against the state


@dataclass(frozen=True, repr=False)
class Adaptive(Method):
    """A method whose every step is as long as the error that it estimates allows.

    Parameters
    ----------
    base : Method
        One with an embedded method: `geomint.RungeKutta` or `geomint.RKMK` of a tableau that has one.
    rtol, atol : float
        A step is accepted if its estimated error is at most ``atol + rtol max |y_i|`` in every piece
        of the state, with y_i the rows of the piece before and after the step.
    max_step : float
        No step is longer, in the problem's own time. Default: no bound.
    max_steps : int
        A run that needs more is a `StepLimitError`.

    Raises
    ------
    DomainError
        For tolerances that make no sense.
    MethodError
        If `base` has no embedded method.

    Notes
    -----
    Local extrapolation and a PI controller (`geomint.kernels.solve.step_control`); a last stage that is
    the new value serves the next step. A clock beside a problem in τ is one more piece of the state.
    """

    base: Method
    _: KW_ONLY
    rtol: float = 1e-8
    atol: float = 1e-12
    max_step: float = math.inf
    max_steps: int = 10**8

    adaptive = True

    def __post_init__(self) -> None:
        if checked_method("base", self.base).estimate_order is None:
            what = "has no embedded method to estimate errors with"
            raise MethodError(f"method {self.base.name!r} {what}")
        limit = whole("max_steps", self.max_steps, 1)
        numbers = {name: _real(name, getattr(self, name)) for name in ("rtol", "atol", "max_step")}
        self._set(max_steps=limit, **numbers)
        if not LEAST_RTOL <= self.rtol <= LARGEST_RTOL:
            raise DomainError("rtol", self.rtol, "a number from 2⁻⁵⁰ = 8.9e-16 to 0.1")
        if not 0.0 <= self.atol < math.inf:
            raise DomainError("atol", self.atol, "a number ≥ 0")
        if not self.max_step > 0.0:
            raise DomainError("max_step", self.max_step, "a number > 0")
        base = self.base
        self._set(
            name=f"{base.name}-adaptive",
            order=base.order,
            needs=base.needs,
            step_fraction=base.step_fraction,
            keeps=base.keeps,
            family=base.family,
            summary=f"{base.summary}; adaptive, error estimate of order {base.estimate_order}",
            references=base.references,
        )

    def flow(self, p: Posed) -> Flow:
        return self.base.adaptive_flow(p, self)

    def default_step(
        self,
        problem: Problem,
        y0: Array,
        span: float,
        start: float = 0.0,
        rate_at: Rate = derivative,
    ) -> float:
        """Return the length of a first step of a run over `span`.

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
            slope = rate_at(problem, y0, start)
            d0, d1 = norm(y0), norm(slope)
            h0 = 0.01 * d0 / d1 if min(d0, d1) > 1e-5 else 1e-6
            h0 = math.copysign(min(max(h0, _TINY), abs(span)), span)
            d2 = norm(rate_at(problem, y0 + h0 * slope, start + h0) - slope) / abs(h0)
            largest = max(d1, d2)
            h1 = (0.01 / largest) ** (1.0 / (self.order + 1)) if largest > 1e-15 else 1e-3 * abs(h0)
        h = min(100.0 * abs(h0), h1, self.max_step, abs(span))
        return h if 0.0 < h < math.inf else min(1e-6 * abs(span), 1.0) or abs(span)


def _real(name: str, value: Any) -> float:
    """Return a number, which may be infinite as `max_step` is, or raise `DomainError`."""
    endless = isinstance(value, float) and math.isinf(value)
    return float(value) if endless else finite(name, value, "a number") + 0.0  # no -0.0
