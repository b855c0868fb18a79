"""RATTLE on the Hamiltonian form: symplectic on embedded constraint manifolds."""

from dataclasses import KW_ONLY, dataclass

from ..arguments import whole
from ..kernels.numbers.blocks import packed
from ..kernels.solve.rattle import RATTLE, rattle_memory, rattle_stepper, rattle_work
from ..kernels.solve.rattle_separable import (
    separable_rattle_memory,
    separable_rattle_stepper,
    separable_rattle_work,
)
from ..references.literature import ANDERSEN_1983, HLW_2006
from .flow import Flow
from .method import Method, iteration_tolerance
from .posed import Posed

MAX_UNROLLED_ROWS = 9
MAX_UNROLLED_CONSTRAINTS = 3


@dataclass(frozen=True, repr=False)
class Rattle(Method):
    """RATTLE for any Hamiltonian H(t, q, p) with holonomic constraints g(q) = 0, order 2.

    H need not be separable: both half steps are then implicit, and solved by fixed point. Where
    the form says `separable`, only the multipliers are unknown, and found by Newton's method: the
    same map at a third to two thirds of the cost. Symmetric, so that `geomint.Compose` raises its
    order; symplectic on the constraint manifold.

    Parameters
    ----------
    iteration_tolerance, max_iterations
        As for `geomint.Gauss`; the unknowns are measured relative to the size of q and of p.
    """

    _: KW_ONLY
    iteration_tolerance: float = 0.0
    max_iterations: int = 200

    name = "rattle-2"
    order = 2
    needs = "hamiltonian"
    step_fraction = 0.02
    family = "RATTLE"
    symmetric = True
    symplectic = True
    keeps = ("constraints",)
    summary = "RATTLE, implicit; only in the multipliers if H is separable"
    references = (ANDERSEN_1983, HLW_2006.at("Section VII.1.4"))

    def __post_init__(self) -> None:
        self._set(
            iteration_tolerance=iteration_tolerance(self.iteration_tolerance),
            max_iterations=whole("max_iterations", self.max_iterations, 1),
        )

    def flow(self, p: Posed) -> Flow:
        assert p.problem.hamiltonian is not None
        separable = p.problem.hamiltonian.separable
        functions, n, m = p.hamiltonian
        memory = separable_rattle_memory if separable else rattle_memory
        work = separable_rattle_work if separable else rattle_work
        stepper = separable_rattle_stepper if separable else rattle_stepper
        return p.flow(
            kernel=stepper(*unrolled_sizes(n, m)),
            functions=functions,
            coefficients=packed(
                RATTLE,
                rows=n,
                constraints=m,
                cap=self.max_iterations,
                tolerance=self.iteration_tolerance,
                clock_rows=float(p.clock),
            ),
            memory=memory(n, m, int(p.clock)),
            work=work(n, m, p.problem.work),
            evaluations=2,
        )


def unrolled_sizes(n: int, m: int) -> tuple[int, int]:
    """Return the length of q and the number of constraints for the compiler; (0, 0) where large."""
    return (n, m) if n <= MAX_UNROLLED_ROWS and m <= MAX_UNROLLED_CONSTRAINTS else (0, 0)
