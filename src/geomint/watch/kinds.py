"""Kinds of quantities: how reports group what is watched."""

from typing import NamedTuple


class Kind(NamedTuple):
    """What headings call all quantities of a kind, and what tables call one of them."""

    title: str
    one: str
    conserved: bool = True


# In the order of reports.
KINDS = {
    "energy": Kind("energy", "energy"),
    "integrals": Kind("other integrals", "integral"),
    "constraints": Kind("constraints", "constraint"),
    "measure": Kind("invariant measure", "measure"),
    "symplectic": Kind("symplectic form", "symplectic form"),
    "others": Kind("not conserved", "not conserved", conserved=False),
}
