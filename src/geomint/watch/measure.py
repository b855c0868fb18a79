r"""The drift of the invariant measure of the numerical map, observed along a run.

The measure μ δ(c) dy on {c(y) = 0} (`geomint.Measure`) is kept by the flow. The method's one step
map Φ, composition included, keeps it up to the defect log [μ(Φ(y)) \|det DΦ\| / μ(y)], the determinant
between tangent spaces in bases of unit volume δ(c) dy. ``measure`` is the sum of the defects of all
steps since the start: 0 for a flow, up to what the instrument cannot see for a symplectic method,
and by steps of order hᵖ⁺¹ else. Derivatives are differences of eight neighbouring trajectories in
lanes, see `geomint.kernels.measure.measure`.

The instrument measures its own noise: the variance that rounding gives to the sum, and a bound of
its bias, ε/8 ‖E‖² a step with ``DΦ = 1 + E``. Both grow with the number of steps. The sum counts as
round-off up to four standard deviations and the bias, as they are at the end of the run: the scale of
the quantity is made so that 32 ε × scale is that (plus what rounding the end states does).
"""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import DomainError, FormError
from ..kernels.compiling.compiled import compiled
from ..kernels.compiling.recorded import Recorded
from ..kernels.measure.measure import measure_sweep
from ..kernels.measure.memory import (
    BIAS,
    CONDITION_SPACING,
    CONDITIONS_LARGEST,
    VARIANCE,
    lane_rows,
    measure_layout,
    measure_memory,
    work_size,
)
from ..kernels.numbers.blocks import Block, scalar_block
from ..methods import binding
from ..methods.stepper import Stepper
from ..problems.evaluate import derivative, rounding_scale
from ..problems.forms import Measure
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from .drift import ROUNDOFF
from .windows import Windows

__all__ = ["MeasureObserver"]

DEVIATIONS = 4.0  # a random walk leaves them behind in one of 8000 runs
BATCH = 1024  # steps of one call, between which Ctrl-C is seen


@Recorded
def no_conditions(params, t, y, out, work):  # type: ignore[no-untyped-def]
    """Write nothing: an open set of states has no conditions."""


class MeasureObserver:
    """Sums the defects of all steps, or of the first `limit`, and keeps the windows of the sum.

    Attributes
    ----------
    windows : Windows
        Of the sum, which is 0 at the start.
    """

    def __init__(
        self, problem: Problem, stepper: Stepper, y0: Array, limit: int | None = None
    ) -> None:
        assert problem.measure is not None  # choose_observables has refused others
        self._problem, self._stepper = problem, stepper
        self._compiled = stepper.compiled
        self._measure: Measure = problem.measure
        self._lanes = stepper.lanes()
        self._functions, extra = self._lane_functions(y0)
        n, rows, m = problem.rows, len(stepper.state), self._measure.conditions
        sizes = (self._lanes.memory_rows, self._lanes.work_rows + extra)
        self._layout = measure_layout(problem.pieces, rows, m, *sizes, problem.work)
        start = np.append(y0, np.zeros(rows - n))
        self._memory = measure_memory(start, _sizes(problem, y0), m)
        count = lane_rows(n, m, *sizes, problem.work)
        self._lane_numbers = scalar_block(8 * count)
        self._work = scalar_block(work_size(n, m, problem.work))
        self._time, self._left = stepper.t0, limit
        self._entry: Any = None
        self._arguments: tuple[Any, ...] = ()
        self.windows = Windows(0.0)
        self._end = np.zeros(0), np.zeros(0)  # time and sum after the last step
        self._density_scale = rounding_scale(problem, self._measure.log_density, y0)

    def _lane_functions(self, y0: Array) -> tuple[tuple[Recorded, ...], int]:
        """Return the method's functions for lanes, and how much more scratch they need."""
        lanes, problem = self._lanes, self._problem
        if lanes.signatures != ("field",):
            return lanes.functions, 0
        (field,), rows = lanes.functions, len(self._stepper.state)
        if self._compiled:
            in_lanes = binding.compiles_for_lanes(field)
        else:
            start = np.append(y0, np.zeros(rows - problem.rows))
            in_lanes = binding.runs_on_lanes(field, Block(problem.params), start, problem.work)
        if in_lanes:
            return lanes.functions, 0
        extra = -(-(2 * rows + problem.work) // 8)
        return (binding.lane_adapter(field, rows, problem.work),), extra

    def prepare(self) -> None:
        """Compile, or find in the cache, the sweep with the method's step in it."""
        if self._entry is not None:
            return
        problem, measure, lanes = self._problem, self._measure, self._lanes
        sweep = measure_sweep(len(self._functions))
        n, params = problem.rows, len(problem.params)
        density = binding.bind_value(measure.log_density, params, n)
        manifold = no_conditions
        if measure.manifold is not None:
            manifold = binding.bind_field(measure.manifold, params, n, measure.conditions)
        functions = (lanes.kernel, *self._functions, density, manifold)
        if not self._compiled:
            self._entry, self._arguments = sweep, functions
            return
        from numba.core.errors import NumbaError

        from ..kernels.compiling import signatures
        from ..kernels.compiling.compile import LANE, SCALAR

        kinds = [getattr(signatures, name.partition("-")[0])(LANE) for name in lanes.signatures]
        kinds = [
            signatures.advance_signature(kinds, LANE),
            *kinds,
            signatures.value(SCALAR),
            signatures.field(LANE),
        ]
        try:
            self._arguments = tuple(
                compiled(f, kind) for f, kind in zip(functions, kinds, strict=True)
            )
        except NumbaError as error:
            raise FormError(
                f"'measure' of {problem.name!r} needs functions that take eight numbers at a time, "
                f"see geomint.field: {' '.join(str(error).split())[:300]}"
            ) from error
        self._entry = compiled(sweep, signatures.sweep(kinds))

    def add(self, times: Array, labels: Array, states: Array, watched: Any, step: float) -> None:
        """Take the states after the next steps, one a row.

        Parameters
        ----------
        times, labels : array
            The problem's own times, and those that drifts are measured in.
        watched : array of bool
            The steps after which the sum is sampled.
        step : float
            The length of the steps; 0: the differences of their times.
        """
        self.prepare()
        if self._left is not None:
            if self._left == 0:
                return
            here = slice(0, self._left)
            times, labels, states, watched = times[here], labels[here], states[here], watched[here]
            self._left -= len(times)
        starts = np.concatenate(([self._time], times[:-1]))
        lengths = np.full(len(times), step) if step else times - starts
        values = np.zeros(len(times))
        flat = np.ascontiguousarray(states)
        for first in range(0, len(times), BATCH):
            here = slice(first, first + BATCH)
            with np.errstate(all="ignore"):
                self._entry(
                    *self._arguments,
                    self._stepper.params,
                    self._lanes.coefficients,
                    self._stepper.fractions,
                    self._layout,
                    self._memory,
                    self._lane_numbers,
                    self._work,
                    Block(starts[here]),
                    Block(lengths[here]),
                    Block(flat[here].reshape(-1)),
                    Block(values[here]),
                )
        self._time = float(times[-1])
        self._end = labels[-1:].copy(), values[-1:]
        self.windows.add(labels[watched], values[watched])

    def add_end(self) -> None:
        """Sample the sum after the last of the steps that were taken, if that is still to do."""
        labels, values = self._end
        if len(labels) and labels[0] != self.windows.last_time:
            self.windows.add(labels, values)

    @property
    def deviation(self) -> float:
        """The standard deviation that rounding has given to the sum so far."""
        return float(np.sqrt(self._memory[VARIANCE]))

    @property
    def scale(self) -> float:
        """The scale that makes 32 ε × scale the level below which nothing can be seen."""
        noise = DEVIATIONS * self.deviation + self._memory[BIAS]
        coarse = CONDITIONS_LARGEST / self._memory[CONDITION_SPACING]  # 1 for polynomials
        ends = self._density_scale + self._measure.conditions * coarse
        return float(ends + noise / ROUNDOFF)


def _sizes(problem: Problem, y0: Array) -> Array:
    """Return the sizes of the pieces, row by row; where one is 0, what it is after a typical time."""
    sizes = np.zeros(problem.rows)
    for piece in problem.slices.values():
        sizes[piece] = np.abs(y0[piece]).max()
    if (sizes == 0.0).any():
        with contextlib.suppress(DomainError):  # without a finite derivative the first step fails
            rates = np.abs(characteristic_time(problem, y0) * derivative(problem, y0))
            for piece in problem.slices.values():
                sizes[piece] = sizes[piece].max() or rates[piece].max()
    return np.where((sizes > 0.0) & (sizes < np.inf), sizes, 1.0)
