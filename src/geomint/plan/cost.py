"""What an evaluation of a problem costs, counted: arithmetic operations in plain Python.

The functions of a problem do not branch on numbers, so that one evaluation with numbers that count
what is done to them is the cost of all. It does not depend on the machine, and takes no time.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import ACTION, CONSTRAINT, FIELD, FLOW, GRADIENTS
from ..kernels.numbers.blocks import Block
from ..kernels.numbers.traced import OWN, Algebra, Traced
from ..problems.bound import given_at
from ..problems.declaration import check_form
from ..problems.forms import GroupAction, Hamiltonian, Splitting
from ..problems.problem import Problem

Held = Callable[[Array], Block]


class Cost(NamedTuple):
    """Numbers of the state, and operations of one evaluation of the form that a method needs."""

    rows: int
    operations: int

    def below(self, other: Cost) -> bool:
        """Tell whether this has a fifth fewer numbers or better, and takes no more operations."""
        return 5 * self.rows <= 4 * other.rows and self.operations <= other.operations


class _Tally(Algebra):
    """Numbers that count the operations between them."""

    def __init__(self) -> None:
        super().__init__(
            OWN, operator.lt, operator.le, lambda condition, x, y: x if condition else y
        )
        self.count = 0

    def block(self, values: Array) -> Block:
        """Return a block of counting numbers."""
        return Block(np.array([_Number(v, self) for v in values.astype(float)], dtype=object))


class _Number(Traced):
    """A float that counts every operation in its tally."""

    context: _Tally
    __slots__ = ()

    def _by(self, symbol: Any) -> _Number:
        self.context.count += 1
        return _Number(symbol, self.context)

    def __float__(self) -> float:
        return float(self.symbol)

    def __neg__(self) -> _Number:
        return _Number(-self.symbol, self.context)  # free: a sign in the next operation

    def __abs__(self) -> _Number:
        return _Number(abs(self.symbol), self.context)

    def chosen(self, condition: Any, x: Any, y: Any) -> Any:
        return x if condition else y


@np.errstate(all="ignore")
def cost_of(problem: Problem, form: str, y: Array) -> Cost:
    """Return the cost of a problem in one of its forms, at the state y.

    Operations are those of the field; of the generator and one action of the group; of the
    gradients and the constraint; or of all flows of a splitting. A sign or a comparison is free.
    """
    check_form(problem, form, y)
    tally = _Tally()
    _EVALUATIONS[form](getattr(problem, form), given_at(problem, y, t=0.0), tally.block)
    return Cost(problem.rows, tally.count)


def _field(field: Recorded, given: dict[str, Any], block: Held) -> None:
    FIELD.run(field, block, **given)


def _action(action: GroupAction, given: dict[str, Any], block: Held) -> None:
    group = action.group
    (xi,) = FIELD.run(action.generator, block, **{**given, "out": group.algebra_rows})
    # Of the size of a small step: larger ones are scaled and squared.
    own = {"layout": group.layout, "xi": 1e-2 * xi.astype(float), "work": group.work}
    ACTION.run(group.act, block, **{**given, **own})


def _hamiltonian(form: Hamiltonian, given: dict[str, Any], block: Held) -> None:
    GRADIENTS.run(form.gradients, block, **given)
    CONSTRAINT.run(form.constraint, block, **given)


def _splitting(form: Splitting, given: dict[str, Any], block: Held) -> None:
    for k in range(form.parts):
        FLOW.run(form.flow, block, **given, k=k, h=1e-2)


_EVALUATIONS: dict[str, Callable[[Any, dict[str, Any], Held], None]] = {
    "field": _field,
    "action": _action,
    "hamiltonian": _hamiltonian,
    "splitting": _splitting,
}
