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
from ..errors import DomainError
from ..kernels.compiling.bound import Bound, bind
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD, VALUE
from ..kernels.measure.measure import measure_sweep
from ..kernels.measure.memory import (
    CONDITIONS_LARGEST,
    Sizes,
    lane_layout,
    measure_given,
    measure_memory,
    memory_layout,
    work_layout,
)
from ..kernels.numbers.blocks import Block, scalar_block, section
from ..kernels.solve.advance import bound_stepper
from ..methods.binding import lane_field
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
        of_method = self._lanes.memory_rows, self._lanes.work_rows + extra
        self._sizes = Sizes(n, rows, m, *of_method, problem.work)
        self._given = measure_given(problem.pieces, self._sizes)
        start = np.append(y0, np.zeros(rows - n))
        self._memory = measure_memory(start, _scales(problem, y0), self._sizes)
        self._lane_numbers = scalar_block(8 * sum(lane_layout(self._sizes)))
        self._work = scalar_block(sum(work_layout(self._sizes)))
        self._time, self._left = stepper.t0, limit
        self._sweep: Call | None = None
        self.windows = Windows(0.0)
        self._end = np.zeros(0), np.zeros(0)  # time and sum after the last step
        self._density_scale = rounding_scale(problem, self._measure.log_density, y0)

    def _lane_functions(self, y0: Array) -> tuple[tuple[Bound, ...], int]:
        """Return the method's functions for lanes, and how much more scratch they need."""
        functions, problem = self._lanes.functions, self._problem
        if [f.signature for f in self._stepper.functions] != [FIELD]:
            return functions, 0
        start = np.append(y0, np.zeros(len(self._stepper.state) - problem.rows))
        field, work = lane_field(functions[0], problem.params, start, problem.work, self._compiled)
        return (field,), work - problem.work

    def prepare(self) -> None:
        """Compile, or find in the cache, the sweep with the method's step in it."""
        if self._sweep is not None:
            return
        problem, measure = self._problem, self._measure
        sizes = {"params": len(problem.params), "y": problem.rows}
        kernel = bound_stepper(self._lanes.kernel, self._functions).in_lanes
        density = bind(measure.log_density, VALUE, **sizes)
        manifold = Bound(no_conditions, FIELD)
        if measure.manifold is not None:
            manifold = bind(measure.manifold, FIELD, **sizes, out=measure.conditions)
        manifold = manifold.in_lanes
        self._sweep = measure_sweep(kernel, self._functions, density, manifold).call(
            self._compiled,
            kernel=kernel,
            functions=self._functions,
            density=density,
            manifold=manifold,
            params=self._stepper.params,
            coefficients=self._lanes.coefficients,
            fractions=self._stepper.fractions,
            layout=self._given,
            memory=self._memory,
            lane_numbers=self._lane_numbers,
            work=self._work,
        )

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
        assert self._sweep is not None
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
            self._sweep(
                starts=Block(starts[here]),
                lengths=Block(lengths[here]),
                states=Block(flat[here].reshape(-1)),
                out=Block(values[here]),
            )
        self._time = float(times[-1])
        self._end = labels[-1:].copy(), values[-1:]
        self.windows.add(labels[watched], values[watched])

    def add_end(self) -> None:
        """Sample the sum after the last of the steps that were taken, if that is still to do."""
        labels, values = self._end
        if len(labels) and labels[0] != self.windows.last_time:
            self.windows.add(labels, values)

    def _remembered(self, name: str) -> float:
        return float(section(self._memory, memory_layout(self._sizes), name)[0])

    @property
    def deviation(self) -> float:
        """The standard deviation that rounding has given to the sum so far."""
        return float(np.sqrt(self._remembered("variance")))

    @property
    def scale(self) -> float:
        """The scale that makes 32 ε × scale the level below which nothing can be seen."""
        noise = DEVIATIONS * self.deviation + self._remembered("bias")
        coarse = CONDITIONS_LARGEST / self._remembered("condition_spacing")  # 1 for polynomials
        ends = self._density_scale + self._measure.conditions * coarse
        return float(ends + noise / ROUNDOFF)


def _scales(problem: Problem, y0: Array) -> Array:
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
