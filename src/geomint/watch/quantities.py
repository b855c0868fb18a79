"""Kinds of quantities: what a named quantity is to a problem, and how reports group them."""

from __future__ import annotations

from typing import NamedTuple

from ..problems.problem import Problem
from .observe import MEASURE

__all__ = ["ENERGY", "KINDS", "Kind", "kind_of"]

ENERGY = "energy"  # the invariant that is shown apart from the others where it has this name


class Kind(NamedTuple):
    """What headings call all quantities of a kind, and what tables call one of them."""

    title: str
    one: str


# In the order of reports.
KINDS = {
    "energy": Kind("energy", "energy"),
    "integrals": Kind("other integrals", "integral"),
    "constraints": Kind("constraints", "constraint"),
    "measure": Kind("invariant measure", "measure"),
    "others": Kind("not conserved", "not conserved"),
}


def kind_of(name: str, *problems: Problem) -> str:
    """Return the kind, a key of `KINDS`, of a quantity that one of the problems has."""
    if name == MEASURE:
        return "measure"
    if any(name in problem.invariants for problem in problems):
        return "energy" if name == ENERGY else "integrals"
    if any(name in problem.constraints for problem in problems):
        return "constraints"
    return "others"
