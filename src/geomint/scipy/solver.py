"""Solvers with steps of one length, as `scipy.integrate.solve_ivp` drives them."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import DenseOutput, OdeSolver

from ..arguments import MOST, positive
from ..errors import ConvergenceError, DomainError, SpeedWarning, tell
from .step_choice import Watched, chosen_step, tolerances
from .steps import ITERATIONS, NOT_FINITE, OK, REASONS, TOO_SHORT, added, compiled


class FixedStep(OdeSolver):
    """Base of the methods here: steps of one length, for `scipy.integrate.solve_ivp`.

    Its options are those of `geomint.scipy`. Complex states are taken. The function is asked for times
    from `t0` to `t_bound` alone.

    Raises
    ------
    DomainError
        For options that make no sense; a `ValueError`, as SciPy's own.
    """

    order: int
    kernel: Callable[..., Any]

    def __init__(
        self,
        fun: Callable[..., Any],
        t0: float,
        y0: Any,
        t_bound: float,
        max_step: float = math.inf,
        rtol: float = 1e-3,
        atol: Any = 1e-6,
        vectorized: bool = False,
        first_step: float | None = None,
        step: float | None = None,
    ) -> None:
        super().__init__(fun, t0, y0, t_bound, vectorized, support_complex=True)
        self.plain = self._fun  # does not count: steps do
        if max_step != math.inf:
            positive("max_step", max_step)
        if step is not None and first_step is not None:
            raise DomainError("first_step", first_step, "None: step= is another name of it")
        self.tables = self.coefficients()
        self.begin, self.done = float(t0), 0
        self._use(fun)
        self.carry = np.zeros_like(self.y)
        self.increments: Any = None
        span = abs(t_bound - self.begin)
        name, given = ("step", step) if first_step is None else ("first_step", first_step)
        if math.isnan(span) or (math.isinf(span) and given is None):
            raise DomainError("t_span", (t0, t_bound), "two times at a finite distance, or step=…")
        self._watched: Watched | None = None
        if given is not None:
            self.h = min(positive(name, given), max_step)
        elif span == 0.0 or self.n == 0:
            self.h = 1.0
        else:
            allowed = tolerances(rtol, atol, self.n)
            h = chosen_step(self, min(span, max_step), *allowed)
            self._watched = Watched(allowed)
            self.h = h and span / np.ceil(span / h * (1.0 - 1e-9))
        self.h *= self.direction

    @classmethod
    def coefficients(cls) -> tuple[Any, Any, Any]:
        """Return the arrays that the kernel takes: a matrix, weights and nodes."""
        raise NotImplementedError

    def _use(self, fun: Callable[..., Any]) -> None:
        """Take the compiled kernel for a function that numba has compiled, or the plain one."""
        self._call, self._function = type(self).kernel, self.plain
        if hasattr(fun, "py_func"):
            from numba.core.errors import NumbaError

            try:
                run, (*table, c) = compiled(type(self).kernel), self.tables
                run(fun, self._inside(c), self.y, 0.0, *table, self._at_rest())
                self._call, self._function = run, fun
            except NumbaError as error:
                said = str(error).strip().splitlines()[0]
                text = f"the steps of {type(self).__name__} are not compiled with this function: {said}"
                tell(SpeedWarning(text, "fun"))

    def _at_rest(self) -> Any:
        return np.zeros((len(self.tables[2]), self.n), self.y.dtype)

    def guess(self, t: float, y: Any, h: float) -> Any:
        """Return increments to begin with at the beginning of a step."""
        return self._at_rest()

    def guess_within(self, increments: Any, theta: float) -> Any:
        """Return increments to begin with for a step that is shorter by a factor."""
        return self._at_rest()

    def stepped(self, t: float, y: Any, h: float, guess: Any) -> tuple[Any, int]:
        """Return the increments of a step and its status."""
        *table, c = self.tables
        times = self._inside(t + c * h)  # a sum may round to beyond the end
        increments, evaluations, status = self._call(self._function, times, y, h, *table, guess)
        self.nfev += evaluations
        return increments, status

    def _inside(self, t: Any) -> Any:
        """Return times, or the nearest of the run."""
        return np.clip(t, *sorted((self.begin, self.t_bound)))

    def _step_impl(self) -> tuple[bool, str | None]:
        t, end = self.t, self.begin + self.h * (self.done + 1)
        if end == t or MOST * abs(self.h) < abs(self.t_bound - self.begin) < math.inf:
            return False, self._failed(TOO_SHORT, self.h)
        rest = self.direction * (self.t_bound - end)
        whole = rest > 1e-9 * abs(self.h)
        last = abs(rest) <= 1e-9 * abs(self.h)  # but for rounding a whole step
        h = self.h if whole or last else self.t_bound - t
        if self.increments is None or h != self.h:
            guess = self.guess(t, self.y, h)
        else:
            guess = self.predicted(self.increments)
        increments, status = self.stepped(t, self.y, h, guess)
        if status != OK:
            return False, self._failed(status, h)
        self.before = self.y, self.carry, h
        self.y, self.carry = added(self.y, self.carry, increments)
        if not np.all(np.isfinite(self.y)):
            self.y = self.before[0]
            return False, self._failed(NOT_FINITE, h)
        self.increments, self.done = increments, self.done + 1
        if self._watched is not None:
            self._watched.look(self, t, end if whole else self.t_bound)
        self.t = end if whole else self.t_bound
        return True, None

    def _failed(self, status: int, h: float) -> str:
        return f"{type(self).__name__} at t = {self.t:.9g}, step {h:.3g}: {REASONS[status]}"

    def predicted(self, increments: Any) -> Any:
        """Return increments to begin with after a step of the same length."""
        return self._at_rest()

    def _dense_output_impl(self) -> DenseOutput:
        return _Within(self)


class _Within(DenseOutput):
    """States within a step: those of shorter steps from where it began."""

    def __init__(self, solver: FixedStep) -> None:
        super().__init__(solver.t_old, solver.t)
        self.solver, self.increments, self.end = solver, solver.increments, solver.y
        self.y, self.carry, self.h = solver.before

    def _at(self, t: float) -> Any:
        if t in (self.t_old, self.t):
            return self.y if t == self.t_old else self.end
        if not self.t_min <= t <= self.t_max:
            raise DomainError("t", t, f"a time within {self.t_min:.17g} … {self.t_max:.17g}")
        h = t - self.t_old
        guess = self.solver.guess_within(self.increments, h / self.h)
        increments, status = self.solver.stepped(self.t_old, self.y, h, guess)
        if status != OK:
            raise ConvergenceError(self.t_old, 0, math.nan, ITERATIONS, REASONS[status])
        return added(self.y, self.carry, increments)[0]

    def _call_impl(self, t: Any) -> Any:
        if t.ndim == 0:
            return self._at(float(t))
        return np.stack([self._at(float(time)) for time in t], axis=-1)
