"""Explicit Lie group methods without commutators; a method is one literal."""

from __future__ import annotations

from ._commutator_free import CommutatorFreeTableau, flow

__all__ = ["COMMUTATOR_FREE"]

_CMO = "E. Celledoni, A. Marthinsen, B. Owren, Future Gener. Comput. Syst. 19 (2003) 341"

_METHODS = (
    CommutatorFreeTableau(
        name="cf-1",
        order=1,
        stages=(flow(0),),
        update=flow(0, "1"),
        reference="Lie-Euler method",
    ),
    CommutatorFreeTableau(
        name="cf-2",
        order=2,
        stages=(flow(0), flow(0, "1/2")),
        update=flow(0, "0 1"),
        reference="Lie midpoint method",
    ),
    # Three exponentials: the update goes on from the second stage, exp(K_1 / 3) y.
    CommutatorFreeTableau(
        name="cf-3",
        order=3,
        stages=(flow(0), flow(0, "1/3"), flow(0, "0 2/3")),
        update=flow(2, "-1/12 0 3/4"),
        reference=f"{_CMO}: three stages of order 3",
    ),
    # Built on the classical method of order 4; the fourth stage goes on from the second.
    CommutatorFreeTableau(
        name="cf-4",
        order=4,
        stages=(flow(0), flow(0, "1/2"), flow(0, "0 1/2"), flow(2, "-1/2 0 1")),
        update=flow(0, "1/4 1/6 1/6 -1/12", "-1/12 1/6 1/6 1/4"),
        reference=f"{_CMO}: four stages of order 4",
    ),
    CommutatorFreeTableau(
        name="cg-3",
        order=3,
        stages=(flow(0), flow(0, "3/4"), flow(0, "119/216", "0 17/108")),
        update=flow(0, "13/51", "0 -2/3", "0 0 24/17"),
        reference="P. E. Crouch, R. Grossman, J. Nonlinear Sci. 3 (1993) 1",
    ),
)

COMMUTATOR_FREE: dict[str, CommutatorFreeTableau] = {method.name: method for method in _METHODS}
"""Commutator-free and Crouch-Grossman methods by name."""
