r"""The drift of the invariant measure of the numerical map, observed along a run.

The measure μ δ(c) dy on {c(y) = 0} (`geomint.Measure`) is kept by the flow. The method's one step
map Φ, composition included, keeps it up to the defect log [μ(Φ(y)) \|det DΦ\| / μ(y)], the determinant
between tangent spaces in bases of unit volume δ(c) dy. ``measure`` is the sum of the defects of all
steps since the start: 0 for a flow, up to what the instrument cannot see for a symplectic method,
and by steps of order hᵖ⁺¹ else. Every step is taken once more in tangent numbers, see
`geomint.kernels.tangent.measure`: DΦ is that of the map itself, of implicit methods where their
iteration has converged in the derivatives too (to the method's tolerance, where it has one).

Where a step leaves the manifold, by its error, DΦ of tangent vectors is followed by the orthogonal
projection onto the kernel of Dc at Φ(y). Orthogonal is meant in units of the pieces of the state: a
piece's unit is its norm where the run begins (where that is 0 what the motion makes of it in a
characteristic time), doubled as often as the piece has outgrown four of it. So the value does not
depend on the units in which a problem is stated, nor on rotations of a piece's coordinates. For
methods that stay on the manifold nothing is projected.

The instrument knows its own noise: rounding gives a step of ``DΦ = 1 + D`` the variance ε² ‖D‖², and
a bias of at most ε/8 ‖D‖², and ε/128 for each condition, as states are off the manifold by a part of
a rounding in the mean; measured are a third of that and less. Both grow with the number of steps.
The sum counts as round-off up to four standard deviations and the bias, as they are at the end of
the run: the scale of the quantity is made so that 32 ε × scale is that (plus what rounding the end
states does).
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
from ..kernels.numbers.blocks import Block, scalar_block, section
from ..kernels.solve.advance import bound_stepper
from ..kernels.tangent.layout import (
    Sizes,
    given_block,
    kept_block,
    kept_layout,
    lanes_for,
    work_layout,
)
from ..kernels.tangent.measure import CONDITIONS, measure_sweep
from ..methods.tangent import directions_at_once, tangent_type
from ..problems.derivatives import slopes_of
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
        return 1.5 * problem.rows  # tangent vectors, eight at once

    def begin(self, run: Run) -> float:
        """Compile, or find in the cache, the sweep with the method's step in it."""
        problem, y0, stepper = run.problem, run.state, run.stepper.fixed_step
        assert problem.measure is not None
        self._measure, self._time = problem.measure, run.time
        sizes = {"params": len(problem.params), "y": problem.rows}
        density = bind(self._measure.log_density, VALUE, **sizes)
        manifold = Bound(no_conditions, FIELD)
        if self._measure.manifold is not None:
            manifold = bind(self._measure.manifold, FIELD, **sizes, out=self._measure.conditions)
        d, m = problem.rows - self._measure.conditions, self._measure.conditions
        at_once = directions_at_once(stepper, d)
        numbers = tangent_type(stepper, at_once)
        rows = len(stepper.memory)
        stages = lanes_for(2 * stepper.rows) if stepper.stages_in_lanes else rows
        self._sizes = Sizes(problem.rows, stepper.rows, m, d, at_once, rows, stages, problem.work)
        passes = -(-d // at_once)
        self._density_scale = rounding_scale(problem, self._measure.log_density, y0)
        self._memory = self._start(problem, y0, run.time)
        kernel = bound_stepper(stepper.kernel, stepper.functions).of_type(numbers)
        functions = tuple(f.of_type(numbers) for f in stepper.functions)
        manifold = manifold.of_type(CONDITIONS)
        held, of_conditions = numbers.memory.held, CONDITIONS.block.held
        memory = scalar_block(passes * rows * held.width)
        conditions = scalar_block((problem.rows + m + problem.work) * of_conditions.width)
        self._sweep = measure_sweep(kernel, functions, density, manifold, numbers).call(
            stepper.compiled,
            kernel=kernel,
            functions=functions,
            density=density,
            manifold=manifold,
            params=stepper.params,
            coefficients=stepper.coefficients,
            fractions=stepper.fractions,
            layout=given_block(problem.pieces, self._sizes),
            memory=self._memory,
            work=scalar_block(sum(work_layout(self._sizes))),
            numbers=held(memory.data),
            plain=memory,
            scratch=held(scalar_block(len(stepper.work) * held.width).data),
            conditions=of_conditions(conditions.data),
            conditions_plain=conditions,
        )
        return 0.0

    def _start(self, problem: Problem, y0: Array, time: float) -> Block:
        """Return what is kept, as it is at the start: the state, its units, directions along them."""
        s = self._sizes
        scales = _scales(problem, y0)
        basis = np.zeros((s.n, lanes_for(s.d)))
        gradients = np.zeros((0, s.n))
        with np.errstate(all="ignore"):
            if self._measure.manifold is not None:
                gradients = scales * slopes_of(problem, self._measure.manifold, y0, time, s.m)
            sizes = 1.0 / np.linalg.norm(gradients, axis=1)
        gradients = np.where(np.isfinite(gradients), gradients, 0.0)
        sizes = np.where(np.isfinite(sizes), sizes, 1.0)
        basis[:, : s.d] = np.linalg.qr(gradients.T, mode="complete")[0][:, s.m :]
        state = np.append(y0, np.zeros(s.rows - s.n))
        given = {"state": state, "scales": scales, "condition_scales": sizes}
        return kept_block(s, basis=basis.ravel(), **given)

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

    def _kept(self, name: str) -> float:
        return float(section(self._memory, kept_layout(self._sizes), name)[0])

    @property
    def deviation(self) -> float:
        """The standard deviation that rounding has given to the sum so far."""
        return float(np.sqrt(self._kept("variance")))

    def scale(self) -> float:
        """Return the scale that makes 32 ε × scale the level below which nothing can be seen."""
        noise = DEVIATIONS * self.deviation + self._kept("bias")
        ends = self._density_scale + self._measure.conditions
        return float(ends + noise / ROUNDOFF)

    def noise(self, steps: int) -> float:
        return NOISE * ROUNDOFF * self.scale()


def _scales(problem: Problem, y0: Array) -> Array:
    """Return the norms of the pieces, row by row; where one is 0, what it is after a typical time."""
    sizes = np.zeros(problem.rows)
    for piece in problem.slices.values():
        sizes[piece] = _norm(y0[piece])
    if (sizes == 0.0).any():
        with contextlib.suppress(DomainError):  # without a finite derivative the first step fails
            rates = characteristic_time(problem, y0) * derivative(problem, y0)
            for piece in problem.slices.values():
                sizes[piece] = sizes[piece].max() or _norm(rates[piece])
    return np.where((sizes > 0.0) & (sizes < np.inf), sizes, 1.0)


def _norm(x: Array) -> float:
    """Return ‖x‖ whatever the size of its numbers."""
    largest = float(np.abs(x).max())
    inside = 0.0 < largest < np.inf
    return largest * float(np.linalg.norm(x / largest)) if inside else largest
