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
methods that stay on the manifold nothing is projected. A fibre over a base, `Measure.base`, is left
out by methods that move it by elements of the group, whose Haar measure they keep whatever else they
do: those that step by the action, and those that keep quadratic invariants where these make the group.

The instrument knows its own noise: rounding gives a step of ``DΦ = 1 + D`` the variance ε² ‖D‖², and
a bias of at most ε/2 ‖D‖², and ε/128 for each condition, as states are off the manifold by a part of
a rounding in the mean; measured are half of that and less. Both grow with the number of steps.
The sum counts as round-off up to four standard deviations and the bias, as they are at the end of
the run: the scale of the quantity is made so that 32 ε × scale is that (plus what rounding the end
states does).
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arguments import Array
from ..kernels.compiling.call import Call
from ..kernels.compiling.signatures import VALUE
from ..kernels.tangent.measure import measure_sweep
from ..methods.carried import Carried
from ..methods.method import Method
from ..methods.stepper import Stepper
from ..problems.base import off_base
from ..problems.bound import bound
from ..problems.evaluate import rounding_scale
from ..problems.forms import Measure
from ..problems.problem import Problem
from .drift import ROUNDOFF
from .steps_again import StepsAgain
from .watcher import Run

DEVIATIONS = 4.0  # a random walk leaves them behind in one of 8000 runs
NOISE = 4.0  # times the level of its noise: how large a random walk of the sum may be just that


@dataclass(eq=False, kw_only=True)
class InvariantMeasure(StepsAgain):
    """The sum of the defects of all steps, or of the first `steps`: 0 at the start.

    Parameters
    ----------
    steps : int, optional
        Each costs as much as some steps of the method.
    """

    name = "measure"
    kind = "measure"
    note = (
        "the sum of log(density ratio × Jacobian determinant) of the numerical steps, 0 if the method "
        "keeps the invariant measure. Its scale is the noise of this instrument "
        "itself, which grows with the number of steps, divided by 32 ε."
    )

    def obstacle(self, problem: Problem) -> str:
        stated = problem.measure is not None
        return "" if stated else f"{problem.name!r} states no measure, see geomint.Measure"

    def evaluates(self, problem: Problem) -> Measure | None:
        return problem.measure

    def seen(self, run: Run) -> Run:
        """In the base alone, where the rest of the state is a fibre whose measure steps keep."""
        measure, method = run.problem.measure, run.method
        base = None if measure is None else measure.base
        if base is None or method is None or method.needs not in base.forms:
            return run
        if not _moves_by_group(method, run.problem):
            return run
        state = run.state[: base.rows].copy()
        if off_base(run.problem, base, run.state[: run.problem.rows], run.time):
            return run
        h, compiled = run.stepper.h, run.stepper.compiled
        flow = method.on(base, state, run.time, compiled=compiled)
        return replace(run, problem=base, state=state, stepper=flow.begin(state, run.time, h))

    def sweep(self, problem: Problem, stepper: Stepper, carried: Carried, y0: Array) -> Call:
        assert problem.measure is not None
        self._measure = problem.measure
        density = bound(problem, self._measure.log_density, VALUE)
        self._density_scale = rounding_scale(problem, self._measure.log_density, y0)
        sweep = measure_sweep(
            carried.kernel, carried.functions, density, carried.manifold, carried.numbers
        )
        return sweep.call(stepper.compiled, density=density, **carried.arguments)

    def scale(self) -> float:
        """Return the scale that makes 32 ε × scale the level below which nothing can be seen."""
        deviation = float(np.sqrt(self._carried.kept("variance")[0]))  # by rounding, so far
        noise = DEVIATIONS * deviation + float(self._carried.kept("bias")[0])
        ends = self._density_scale + self._measure.conditions
        return float(ends + noise / ROUNDOFF)

    def noise(self, steps: int) -> float:
        return NOISE * ROUNDOFF * self.scale()


def _moves_by_group(method: Method, problem: Problem) -> bool:
    """Tell whether steps move a fibre by elements of the group.

    A Gauss method's step is affine in what the field is affine in, g' = g P, and with quadratic
    invariants for all g the matrix P is in the group that they make, the one with Cayley coordinates.
    """
    if method.needs == "action" or problem.action is None:
        return method.needs == "action"
    solved = not method.options.get("iteration_tolerance", 0.0)
    return (
        solved
        and "quadratic invariants" in method.keeps
        and problem.action.group.cayley is not None
    )
