"""What a method is: a name, an order, the form it needs, and how to start it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import FormError
from ..problem import Problem
from .stepper import Stepper

__all__ = ["Method", "Start"]


@dataclass(frozen=True)
class Start:
    """What a method is started with.

    Attributes
    ----------
    y0 : array
        Canonical initial state, without the clock's row.
    clock : bool
        Whether physical time is integrated beside the state, as one more row.
    compiled : bool
        Whether kernels are compiled; plain Python otherwise, with the same bits.
    """

    problem: Problem
    y0: npt.NDArray[np.float64]
    t0: float
    h: float
    clock: bool = False
    compiled: bool = True


@dataclass(frozen=True)
class Method:
    """An integration method.

    Parameters
    ----------
    name : str
        Lower case with hyphens; `geomint.methods.find_method` parses it back.
    order : int
    needs : str
        The form of the problem: ``field``, ``action`` or ``hamiltonian``.
    symmetric, symplectic : bool
        Structure of the method itself, in exact arithmetic.
    step_fraction : float
        Default step, as a fraction of the state's shortest characteristic time.
    start : callable
        ``start(Start) -> Stepper``.
    compose : callable or None
        For symmetric methods: ``compose(fractions, starts) -> start``.
    summary, reference : str
    """

    name: str
    order: int
    needs: str
    start: Callable[[Start], Stepper] = field(repr=False, compare=False)
    step_fraction: float
    symmetric: bool = False
    symplectic: bool = False
    summary: str = ""
    reference: str = ""
    compose: Callable[..., Callable[[Start], Stepper]] | None = field(
        default=None, repr=False, compare=False
    )
    options: dict[str, Any] = field(default_factory=dict, compare=False)

    def check_fits(self, problem: Problem, clock: bool) -> None:
        """Raise `FormError`, naming what would fit, unless the method can integrate the problem."""
        if self.needs not in problem.forms:
            raise FormError(
                f"method {self.name!r} needs the form {self.needs!r}, but problem "
                f"{problem.name!r} offers {', '.join(problem.forms)}. {_advice(problem)}"
            )
        if clock and problem.clock is None:
            raise FormError(f"problem {problem.name!r} has no clock: its own time is physical time")
        if clock and self.needs == "action":
            raise FormError(
                f"method {self.name!r} acts by a group and cannot integrate a clock beside it: "
                f"give the end in {problem.time!r}"
            )


_FITTING = {
    "field": "gauss-8, dop853, rk-4",
    "action": "cf-4, rkmk-4",
    "hamiltonian": "rattle-2, rattle-4, rattle-6",
}


def _advice(problem: Problem) -> str:
    fitting = [f"{_FITTING[form]} (form {form!r})" for form in problem.forms]
    return f"Methods that fit: {'; '.join(fitting)}."
