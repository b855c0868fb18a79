"""Commutator-free Lie group methods on the group-action form."""

from dataclasses import dataclass

from ..kernels.numbers.blocks import packed
from ..kernels.solve.commutator_free import (
    commutator_free_coefficients,
    commutator_free_stepper,
    commutator_free_work,
)
from ..kernels.solve.compensated import compensated_state
from ..tableaux import COMMUTATOR_FREE, CommutatorFreeTableau
from .explicit import step_fraction, tableau_of
from .flow import Flow
from .method import Method
from .posed import Posed, maps_of, unrolled


@dataclass(frozen=True, repr=False)
class CommutatorFree(Method):
    """Lie group method whose stages are products of exponentials, without commutators.

    Parameters
    ----------
    tableau : str or CommutatorFreeTableau
        A name from `geomint.tableaux.COMMUTATOR_FREE`.

    Notes
    -----
    Whatever the group's orbits keep (|γ|, K, the spectrum of k) is kept to rounding. The energy
    and the invariant measure drift; that of the ball by a rate of one order more than the method's.
    """

    tableau: str | CommutatorFreeTableau = "cf-4"

    needs = "action"
    keeps = ("group orbits", "steady motions")

    def __post_init__(self) -> None:
        table = tableau_of(COMMUTATOR_FREE, self.tableau, CommutatorFreeTableau)
        self._set(
            tableau=table,
            name=table.name,
            order=table.order,
            step_fraction=step_fraction(table.order),
            family="Crouch–Grossman" if table.name.startswith("cg-") else "commutator-free",
            summary=f"commutator-free, {table.exponentials} exponentials a step",
            references=table.references,
        )

    def flow(self, p: Posed) -> Flow:
        table = self.tableau
        assert isinstance(table, CommutatorFreeTableau)
        generator, group = p.action
        maps = maps_of(group, group.act)
        rows, m = p.rows, group.algebra_rows
        stages, work = len(table.stages), p.problem.work
        return p.flow(
            kernel=commutator_free_stepper(*maps.inline, *unrolled(rows, m)),
            functions=(generator, *maps.functions),
            coefficients=packed(
                commutator_free_coefficients(len(group.layout), stages, len(table.numbers)),
                **p.group_sizes(group, stages),
                c=table.classical.c_float,
                flows=table.numbers,
            ),
            memory=compensated_state(rows),
            work=commutator_free_work(rows, m, stages, work, group.work),
            evaluations=stages,
            lane_by_lane=group.inline,
        )
