"""How much every numerical step changes the symplectic form, observed along a run.

``symplectic`` is of each step Φ the defect ‖Φ*ω − ω‖ over ‖ω‖ on the tangent spaces of the manifold
of states, in Frobenius's norm of orthonormal bases in units of the pieces: 0, up to rounding, for
symplectic methods, and of order hᵖ⁺¹ for others. It is not summed: windows have its mean and its
largest value. Where a step leaves the manifold, DΦ of tangent vectors is followed by the projection
that `geomint.watch.measure` says.

The form is that of the problem (`geomint.SymplecticForm`). The noise of the instrument is that of one
step: rounding of DΦ − 1, of the form and of tangent spaces at rounded states.
"""

from dataclasses import dataclass

import numpy as np

from ..arguments import Array
from ..kernels.compiling.call import Call
from ..kernels.compiling.signatures import TWO_FORM
from ..kernels.tangent.symplectic import symplectic_sweep
from ..methods.carried import Carried
from ..methods.stepper import Stepper
from ..problems.bound import bound
from ..problems.problem import Problem
from ..problems.two_form import SymplecticForm
from .drift import ROUNDOFF
from .steps_again import StepsAgain

EPSILON = 2.0**-52
NOISE, OFF, ANEW = 6.0, 2.0, 8.0  # roundings: of ‖D‖, of each condition's, of a form that varies


@dataclass(eq=False, kw_only=True)
class SymplecticDefect(StepsAgain):
    """The defect of each step, or of the first `steps`.

    Parameters
    ----------
    steps : int, optional
        Each costs as much as some steps of the method.
    """

    name = "symplectic"
    kind = "symplectic"
    in_all = False
    label = "‖Φ*ω − ω‖/‖ω‖"
    note = (
        "how much a step changes the symplectic form, relative: 0 for symplectic methods. Its scale is "
        "the noise of this instrument for one step, divided by 32 ε."
    )

    def obstacle(self, problem: Problem) -> str:
        if problem.symplectic_form is None:
            return f"{problem.name!r} states no symplectic form, see geomint.SymplecticForm"
        bound = problem.hamiltonian is not None and problem.measure is None
        return f"{problem.name!r} states no measure, whose manifold has the form" if bound else ""

    def evaluates(self, problem: Problem) -> SymplecticForm | None:
        return problem.symplectic_form

    def sweep(self, problem: Problem, stepper: Stepper, carried: Carried, y0: Array) -> Call:
        assert problem.symplectic_form is not None
        self._constant = problem.symplectic_form.constant
        form = bound(problem, problem.symplectic_form.form, TWO_FORM)
        sweep = symplectic_sweep(
            carried.kernel, carried.functions, form, carried.manifold, carried.numbers
        )
        constant = int(self._constant)
        return sweep.call(stepper.compiled, form=form, constant=constant, **carried.arguments)

    def scale(self) -> float:
        """Return the scale that makes 32 ε × scale the noise of a step."""
        changed = float(np.sqrt(self._carried.kept("variance")[0]))
        roundings = NOISE * changed + OFF * self._carried.sizes.m + ANEW * (not self._constant)
        return float(max(EPSILON * roundings / ROUNDOFF, 1e-300))

    def noise(self, steps: int) -> float:
        return ROUNDOFF * self.scale()
