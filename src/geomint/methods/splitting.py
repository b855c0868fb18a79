"""Störmer–Verlet, and Strang's splitting of more parts, on the splitting form."""

from dataclasses import dataclass

from ..kernels.numbers.blocks import packed
from ..kernels.solve.splitting import SPLITTING, splitting_memory, splitting_stepper, splitting_work
from ..problems.time_scale import names_time
from ..references.literature import HLW_2006, STRANG_1968, VERLET_1967
from .flow import Flow
from .method import Method
from .posed import Posed


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
    references = (STRANG_1968, VERLET_1967, HLW_2006.at("Section II.5"))

    def flow(self, p: Posed) -> Flow:
        functions, parts = p.splitting
        rows, clock = p.problem.rows, int(p.clock)
        return p.flow(
            kernel=splitting_stepper(),
            functions=functions,
            coefficients=packed(
                SPLITTING,
                rows=rows,
                parts=parts,
                clock_rows=clock,
                substeps=len(p.lengths),
                merged=float(not names_time(p.problem)),
            ),
            memory=splitting_memory(rows, clock),
            work=splitting_work(rows, p.problem.work),
            evaluations=2 * parts - 1,
            lane_by_lane=True,
        )
