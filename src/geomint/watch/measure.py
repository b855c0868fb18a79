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
from dataclasses import dataclass

import numpy as np

from ..arguments import Array
from ..errors import DomainError
from ..kernels.compiling.bound import Bound, bind
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
from ..problems.evaluate import derivative, rounding_scale
from ..problems.forms import Measure
from ..problems.problem import Problem
from ..problems.time_scale import characteristic_time
from .drift import ROUNDOFF
from .watcher import Run, Watcher

__all__ = ["InvariantMeasure"]

DEVIATIONS = 4.0  # a random walk leaves them behind in one of 8000 runs
NOISE = 4.0  # times the level of its noise: how large a random walk of the sum may be just that
BATCH = 1024  # steps of one call, between which Ctrl-C is seen


@Recorded
def no_conditions(params, t, y, out, work):  # type: ignore[no-untyped-def]
    """Write nothing: an open set of states has no conditions."""


@dataclass(eq=False, kw_only=True)
class InvariantMeasure(Watcher):
    """The sum of the defects of all steps, or of the first `steps`: 0 at the start.

    Parameters
    ----------
    steps : int, optional
        Each costs as much as tens of steps of the method.
    """

    name = "measure"
    kind = "measure"
    every_state = True
    with_clock = True
    own_noise = True
    note = (
        "the sum of log(density ratio × Jacobian determinant) of the numerical steps, 0 if the method "
        "keeps the invariant measure. Its scale is the noise that this instrument has measured of "
        "itself, which grows with the number of steps, divided by 32 ε."
    )

    def obstacle(self, problem: Problem) -> str:
        return "" if problem.measure is not None else f"{problem.name!r} states no measure"

    def evaluates(self, problem: Problem) -> Measure | None:
        return problem.measure

    def cost(self, problem: Problem) -> float:
        return 8.0 * problem.rows  # trajectories at once, tangent vectors

    def begin(self, run: Run) -> float:
        """Compile, or find in the cache, the sweep with the method's step in it."""
        problem, y0 = run.problem, run.state
        assert problem.measure is not None
        self._stepper, self._measure, self._time = run.stepper, problem.measure, run.time
        self._lanes = run.stepper.lanes()
        functions, extra = self._lane_functions(problem, y0)
        n, rows, m = problem.rows, len(run.stepper.state), self._measure.conditions
        of_method = self._lanes.memory_rows, self._lanes.work_rows + extra
        self._sizes = Sizes(n, rows, m, *of_method, problem.work)
        start = np.append(y0, np.zeros(rows - n))
        self._memory = measure_memory(start, _scales(problem, y0), self._sizes)
        self._density_scale = rounding_scale(problem, self._measure.log_density, y0)
        sizes = {"params": len(problem.params), "y": problem.rows}
        kernel = bound_stepper(self._lanes.kernel, functions).in_lanes
        density = bind(self._measure.log_density, VALUE, **sizes)
        manifold = Bound(no_conditions, FIELD)
        if self._measure.manifold is not None:
            manifold = bind(self._measure.manifold, FIELD, **sizes, out=m)
        manifold = manifold.in_lanes
        self._sweep = measure_sweep(kernel, functions, density, manifold).call(
            run.stepper.compiled,
            kernel=kernel,
            functions=functions,
            density=density,
            manifold=manifold,
            params=run.stepper.params,
            coefficients=self._lanes.coefficients,
            fractions=run.stepper.fractions,
            layout=measure_given(problem.pieces, self._sizes),
            memory=self._memory,
            lane_numbers=scalar_block(8 * sum(lane_layout(self._sizes))),
            work=scalar_block(sum(work_layout(self._sizes))),
        )
        return 0.0

    def _lane_functions(self, problem: Problem, y0: Array) -> tuple[tuple[Bound, ...], int]:
        """Return the method's functions for lanes, and how much more scratch they need."""
        functions, stepper = self._lanes.functions, self._stepper
        if [f.signature for f in stepper.functions] != [FIELD]:
            return functions, 0
        start = np.append(y0, np.zeros(len(stepper.state) - problem.rows))
        given = problem.params, start, problem.work, stepper.compiled
        field, work = lane_field(functions[0], *given)
        return (field,), work - problem.work

    def values(self, times: Array, states: Array, lengths: Array) -> Array:
        starts = np.concatenate(([self._time], times[:-1]))
        values = np.zeros(len(times))
        flat = np.array(states)
        for first in range(0, len(times), BATCH):
            here = slice(first, first + BATCH)
            self._sweep(
                starts=Block(starts[here]),
                lengths=Block(lengths[here]),
                states=Block(flat[here].reshape(-1)),
                out=Block(values[here]),
            )
        self._time = float(times[-1])
        return values

    def _remembered(self, name: str) -> float:
        return float(section(self._memory, memory_layout(self._sizes), name)[0])

    @property
    def deviation(self) -> float:
        """The standard deviation that rounding has given to the sum so far."""
        return float(np.sqrt(self._remembered("variance")))

    def scale(self) -> float:
        """Return the scale that makes 32 ε × scale the level below which nothing can be seen."""
        noise = DEVIATIONS * self.deviation + self._remembered("bias")
        coarse = CONDITIONS_LARGEST / self._remembered("condition_spacing")  # 1 for polynomials
        ends = self._density_scale + self._measure.conditions * coarse
        return float(ends + noise / ROUNDOFF)

    def noise(self, steps: int) -> float:
        return NOISE * ROUNDOFF * self.scale()


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
