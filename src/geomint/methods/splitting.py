"""Störmer–Verlet, and Strang's splitting of more parts, on the splitting form."""

from __future__ import annotations

from dataclasses import dataclass

from ..kernels.numbers.blocks import packed, scalar_block
from ..kernels.solve.splitting import (
    SPLITTING,
    splitting_memory,
    splitting_stepper,
    splitting_work,
)
from .bound_forms import splitting_of, substeps
from .method import Method, Start
from .stepper import Stepper, filled_block

__all__ = ["Verlet"]


@dataclass(frozen=True, repr=False)
class Verlet(Method):
    """Strang's composition of the flows of a problem's parts, order 2: explicit.

    Of two parts, such as kick and drift, this is the method of Störmer and Verlet. Symmetric, so
    that `geomint.Compose` raises its order; symplectic where the parts are Hamiltonian. What the
    flow of every part keeps is kept to rounding: on T*S^(n−1) the constraints.

    Notes
    -----
    A part that depends on time is frozen at the middle of the step.
    """

    name = "verlet-2"
    order = 2
    needs = "splitting"
    step_fraction = 0.02
    family = "Störmer–Verlet splitting"
    symmetric = True
    symplectic = True
    keeps = ("constraints",)
    summary = "Störmer–Verlet, Strang splitting of the parts; explicit"
    reference = "Hairer, Lubich, Wanner, Geometric Numerical Integration, II.5"

    def start(self, s: Start) -> Stepper:
        functions, parts = splitting_of(s)
        rows = s.problem.rows
        memory = scalar_block(sum(splitting_memory(rows, int(s.clock))))
        memory.data[:rows] = s.y0
        return Stepper(
            kernel=splitting_stepper(),
            functions=functions,
            params=filled_block(s.problem.params),
            coefficients=packed(SPLITTING, rows=rows, parts=parts, clock_rows=float(s.clock)),
            fractions=substeps(s),
            memory=memory,
            work=scalar_block(sum(splitting_work(rows, s.problem.work))),
            rows=rows + s.clock,
            t0=s.t0,
            h=s.h,
            evaluations=2 * parts - 1,
            compiled=s.compiled,
        )
