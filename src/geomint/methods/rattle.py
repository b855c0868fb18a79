"""RATTLE on the Hamiltonian form: symplectic on embedded constraint manifolds."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from ..arguments import number, whole
from ..kernels.numbers.blocks import packed, scalar_block
from ..kernels.solve.rattle import RATTLE, rattle_memory, rattle_stepper, rattle_work
from ..kernels.solve.rattle_separable import (
    separable_rattle_memory,
    separable_rattle_stepper,
    separable_rattle_work,
)
from .bound_forms import hamiltonian_of, substeps
from .method import Method, Start
from .stepper import Stepper, filled_block

__all__ = ["Rattle"]

MAX_UNROLLED_ROWS = 9
MAX_UNROLLED_CONSTRAINTS = 3


def Rattle(  # noqa: N802 - reads as the method it is
    *, tolerance: float = 0.0, max_iterations: int = 200
) -> Method:
    """RATTLE for any Hamiltonian H(t, q, p) with holonomic constraints g(q) = 0, order 2.

    H need not be separable: both half steps are then implicit, and solved by fixed point. Where
    the form says `separable`, only the multipliers are unknown, and found by Newton's method: the
    same map at a third to two thirds of the cost. Symmetric, so that `geomint.Compose` raises its
    order; symplectic on the constraint manifold.

    Parameters
    ----------
    tolerance, max_iterations
        As for `geomint.Gauss`; the unknowns are measured relative to the size of q and of p.
    """
    tolerance = number("tolerance", tolerance, 0.0, 1e-2, "a number in [0, 0.01)")
    max_iterations = whole("max_iterations", max_iterations, 1)

    def compose(lengths: Any, starts: Any) -> Callable[[Start], Stepper]:
        return functools.partial(_start, tolerance, max_iterations, lengths, starts)

    return Method(
        name="rattle-2",
        order=2,
        needs="hamiltonian",
        family="RATTLE",
        start=compose((1.0,), (0.0,)),
        compose=compose,
        step_fraction=0.02,
        symmetric=True,
        symplectic=True,
        keeps=("constraints",),
        summary="RATTLE, implicit; only in the multipliers if H is separable",
        reference="Hairer, Lubich, Wanner, Geometric Numerical Integration, VII.1.4",
        options={"tolerance": tolerance, "max_iterations": max_iterations},
        remake=Rattle,
    )


def _start(tolerance: float, cap: int, lengths: Any, starts: Any, s: Start) -> Stepper:
    assert s.problem.hamiltonian is not None
    separable = s.problem.hamiltonian.separable
    functions, n, m = hamiltonian_of(s)
    rows = 2 * n + s.clock
    sizes = separable_rattle_memory if separable else rattle_memory
    scratch = separable_rattle_work if separable else rattle_work
    stepper = separable_rattle_stepper if separable else rattle_stepper
    unrolled = (n, m) if n <= MAX_UNROLLED_ROWS and m <= MAX_UNROLLED_CONSTRAINTS else (0, 0)
    memory = scalar_block(sum(sizes(n, m, int(s.clock))))
    memory.data[: 2 * n] = s.y0
    return Stepper(
        kernel=stepper(*unrolled),
        functions=functions,
        params=filled_block(s.problem.params),
        coefficients=packed(
            RATTLE,
            rows=n,
            constraints=m,
            cap=cap,
            tolerance=tolerance,
            clock_rows=float(s.clock),
        ),
        fractions=substeps(lengths, starts),
        memory=memory,
        work=scalar_block(sum(scratch(n, m, s.problem.work))),
        rows=rows,
        t0=s.t0,
        h=s.h,
        evaluations=2,
        compiled=s.compiled,
    )
