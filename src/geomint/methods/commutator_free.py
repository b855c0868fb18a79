"""Commutator-free Lie group methods on the group-action form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..kernels.numbers.blocks import packed, scalar_block
from ..kernels.solve.commutator_free import (
    commutator_free_coefficients,
    commutator_free_stepper,
    commutator_free_work,
)
from ..kernels.solve.compensated import compensated_state
from ..tableaux import COMMUTATOR_FREE, CommutatorFreeTableau
from .bound_forms import action_of, maps_of, substeps, unrolled
from .explicit import step_fraction, tableau_of
from .method import Method, Start
from .stepper import Stepper, filled_block

__all__ = ["CommutatorFree"]


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
            reference=table.reference,
        )

    def start(self, s: Start) -> Stepper:
        table = self.tableau
        assert isinstance(table, CommutatorFreeTableau)
        generator, group, y0 = action_of(s)
        maps = maps_of(group, group.act)
        rows, m = len(y0), group.algebra_rows
        stages, work = len(table.stages), s.problem.work
        memory = scalar_block(sum(compensated_state(rows)))
        memory.data[:rows] = y0
        counts, starts, coefficients = table.counts, table.starts, table.coefficients
        ends = np.cumsum(counts)
        table_rows = [
            np.concatenate(([starts[i] - 1.0, counts[i]], coefficients[end - n : end].ravel()))
            for i, (n, end) in enumerate(zip(counts, ends, strict=True))
        ]
        flows = np.concatenate(table_rows)
        return Stepper(
            kernel=commutator_free_stepper(*maps.inline, *unrolled(rows, m)),
            functions=(generator, *maps.functions),
            params=filled_block(s.problem.params),
            coefficients=packed(
                commutator_free_coefficients(len(group.layout), stages, len(flows)),
                rows=rows,
                algebra_rows=m,
                stages=stages,
                layout_rows=len(group.layout),
                field_work=work,
                layout=group.layout,
                c=table.classical.c_float,
                flows=flows,
            ),
            fractions=substeps(s),
            memory=memory,
            work=scalar_block(sum(commutator_free_work(rows, m, stages, work, group.work))),
            rows=rows,
            t0=s.t0,
            h=s.h,
            evaluations=stages,
            compiled=s.compiled,
        )
