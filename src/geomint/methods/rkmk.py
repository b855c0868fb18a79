"""Runge–Kutta–Munthe-Kaas methods on the group-action form."""

import functools
from dataclasses import dataclass
from fractions import Fraction
from math import comb, factorial
from typing import Literal

from ..errors import DomainError, FormError
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.blocks import packed
from ..kernels.solve.compensated import compensated_state
from ..kernels.solve.rkmk import (
    dexpinv_series,
    dexpinv_work,
    rkmk_coefficients,
    rkmk_stepper,
    rkmk_work,
)
from ..kernels.solve.rkmk_adaptive import adaptive_rkmk_stepper
from ..problems.forms import Group
from ..references.literature import MUNTHE_KAAS_1999
from ..tableaux import Tableau
from .adaptive import Adaptive
from .adaptive_stepper import controlled
from .explicit import explicit_tableau, fixed_step_numbers, step_fraction
from .flow import Flow
from .method import Method
from .posed import Posed, maps_of, unrolled

COORDINATES = ("exp", "cayley")
MAPS = {"exp": "exponentials", "cayley": "Cayley maps"}
FAMILIES = {"exp": "exponential coordinates", "cayley": "Cayley coordinates"}


def dexpinv_weights(terms: int) -> list[Fraction]:
    """Return B_k / k! for k < terms: ``dexp_u⁻¹ = Σ (B_k / k!) ad_u^k`` with B_1 = −1/2."""
    bernoulli: list[Fraction] = []
    for k in range(terms):
        total = sum((comb(k + 1, j) * bernoulli[j] for j in range(k)), Fraction(0))
        bernoulli.append(Fraction(1) if k == 0 else -total / (k + 1))
    return [b / factorial(k) for k, b in enumerate(bernoulli)]


def coordinates_of(group: Group, coordinates: str, order: int) -> tuple[Recorded, Recorded, int]:
    """Return (map, inverse of its differential, rows of scratch) for a method of some order.

    Raises
    ------
    FormError
        If the group has no Cayley map.
    """
    if coordinates == "exp":
        if group.dexpinv is not None:
            return group.act, group.dexpinv, group.work
        weights = dexpinv_weights(max(order - 1, 1))
        numerators = tuple(float(w.numerator) for w in weights)
        denominators = tuple(float(w.denominator) for w in weights)
        series = dexpinv_series(group.bracket, numerators, denominators, group.extent)
        return group.act, series, sum(dexpinv_work(group.algebra_rows, group.work))
    if group.cayley is None or group.dcayinv is None:
        raise FormError(
            f"the group {group.name} has no Cayley map: give its cayley and dcayinv, or take "
            "coordinates='exp'"
        )
    return group.cayley, group.dcayinv, group.work


@dataclass(frozen=True, repr=False)
class RKMK(Method):
    """Runge–Kutta–Munthe-Kaas method of an explicit tableau; `geomint.Adaptive` chooses its steps.

    Parameters
    ----------
    tableau : str or Tableau
        A name from `geomint.tableaux.RUNGE_KUTTA` or an explicit tableau.
    coordinates : ``"exp"`` or ``"cayley"``
        The map ψ from the algebra to the group: the exponential, or on quadratic groups
        ``cay(u) = (1 − u/2)⁻¹ (1 + u/2)``.

    Raises
    ------
    DomainError, MethodError
        For other coordinates, and for a tableau that is implicit.

    Notes
    -----
    The state is ψ(u)·y, and ``u̇ = dψ_u⁻¹ ξ`` is solved in the algebra by the tableau. dexp⁻¹ has a
    closed form on SO(3); elsewhere its series keeps the terms up to ad^(p−2) that order p needs,
    H. Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115. dcay⁻¹ is a polynomial of degree 2 and exact,
    so the Cayley map gives any order without series or brackets. What the group's orbits keep is
    kept to rounding. A step that turns so far that the coordinates end (2π, for cay π) is rejected,
    or at fixed step a `StepSizeError`. With `geomint.Adaptive` the error is that of the exponent,
    e = u₁ − û₁ in the algebra, measured by what it does to the state, ψ(e)·y − y: so tolerances mean
    the same for all groups and states.
    """

    tableau: str | Tableau = "rk-4"
    coordinates: Literal["exp", "cayley"] = "exp"

    needs = "action"

    def __post_init__(self) -> None:
        if not (isinstance(self.coordinates, str) and self.coordinates in COORDINATES):
            raise DomainError("coordinates", self.coordinates, f"one of {list(COORDINATES)}")
        table = explicit_tableau(self.tableau)
        exponential = self.coordinates == "exp"
        prefix = "rkmk" if exponential else f"rkmk-{self.coordinates}"
        maps = f"{table.used_stages} {MAPS[self.coordinates]}"
        self._set(
            tableau=table,
            name=f"{prefix}-{table.order}" if table.name == "rk-4" else f"{prefix}-{table.name}",
            order=table.order,
            estimate_order=table.estimate_order,
            step_fraction=step_fraction(table.order),
            keeps=("group orbits", "steady motions") if exponential else ("group orbits",),
            family=f"Runge–Kutta–Munthe-Kaas, {FAMILIES[self.coordinates]}",
            summary=f"Runge–Kutta–Munthe-Kaas, {maps} a step",
            references=(MUNTHE_KAAS_1999, *table.references),
        )

    @property
    def table(self) -> Tableau:
        """The tableau."""
        assert isinstance(self.tableau, Tableau)
        return self.tableau

    def flow(self, p: Posed) -> Flow:
        generator, group = p.action
        *chart, group_work = coordinates_of(group, self.coordinates, self.order)
        maps = maps_of(group, *chart)
        stages, numbers = fixed_step_numbers(self.table)
        rows, m = p.rows, group.algebra_rows
        layout = rkmk_coefficients(len(group.layout), stages, 0)
        return p.flow(
            kernel=rkmk_stepper(*maps.inline, *unrolled(rows, m)),
            functions=(generator, *maps.functions),
            coefficients=packed(layout, **p.group_sizes(group, stages), **numbers),
            memory=compensated_state(rows),
            work=rkmk_work(rows, m, stages, p.problem.work, group_work),
            evaluations=stages,
            lane_by_lane=group.inline,
        )

    def adaptive_flow(self, p: Posed, allowed: Adaptive) -> Flow:
        _, group = p.action
        *chart, group_work = coordinates_of(group, self.coordinates, self.order)
        maps = maps_of(group, *chart)
        stages, rows, m, work = self.table.stages, p.rows, group.algebra_rows, p.problem.work
        return controlled(
            p,
            self.table,
            allowed,
            self.flow(p),
            kernel=adaptive_rkmk_stepper(*maps.inline, *unrolled(rows, m)),
            derivative_rows=m,
            layout=functools.partial(rkmk_coefficients, len(group.layout)),
            sizes=p.group_sizes(group, stages),
            work_rows=sum(rkmk_work(rows, m, stages, work, group_work)),
        )
