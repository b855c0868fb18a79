"""What a method is: a name, an order, the form it needs, and how to start it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import DomainError, FormError, MethodError, nearest, quoted
from ..problems.problem import Problem
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
    end : float or None
        Where an adaptive method stops, in the problem's own time; None if that is not known.
    """

    problem: Problem
    y0: npt.NDArray[np.float64]
    t0: float
    h: float
    clock: bool = False
    compiled: bool = True
    end: float | None = None


@dataclass(frozen=True)
class Method:
    """An integration method.

    Parameters
    ----------
    name : str
        Lower case with hyphens; `geomint.methods.find_method` parses it back.
    order : int
    needs : str
        The form of the problem: ``field``, ``action``, ``hamiltonian`` or ``splitting``.
    symmetric, symplectic : bool
        Structure of the method itself, in exact arithmetic: symplectic on the manifold for a method
        that needs ``hamiltonian`` or ``splitting``; for one that needs ``field``, for Hamiltonian
        fields on flat space. See `structure`.
    keeps : tuple of str
        What every step keeps to round-off, however long it is; `geomint.stress` holds the method to
        it. Some of ``"group orbits"``, ``"quadratic invariants"``, ``"constraints"``, and ``"steady
        motions"``: those whose generator is constant are followed exactly.
    step_fraction : float
        Default step, as a fraction of the state's shortest characteristic time.
    first_step : callable or None
        For adaptive methods: ``first_step(problem, y0, end) -> float``, the default first step.
    start : callable
        ``start(Start) -> Stepper``.
    compose : callable or None
        For symmetric methods: ``compose(fractions, starts) -> start``.
    options : dict
        The options that `with_options` may change, and their values.
    remake : callable or None
        ``remake(**options) -> Method``, for methods with options.
    family : str
        What lists group it by, such as ``"Crouch–Grossman"``. May be left out.
    summary, reference : str
        For lists and reports: what it is in a line, and where it is published. Both may be left out.
    """

    name: str
    order: int
    needs: str
    start: Callable[[Start], Stepper] = field(repr=False, compare=False)
    step_fraction: float
    symmetric: bool = False
    symplectic: bool = False
    keeps: tuple[str, ...] = ()
    family: str = ""
    summary: str = ""
    reference: str = ""
    compose: Callable[..., Callable[[Start], Stepper]] | None = field(
        default=None, repr=False, compare=False
    )
    options: dict[str, Any] = field(default_factory=dict, compare=False)
    remake: Callable[..., Method] | None = field(default=None, repr=False, compare=False)
    first_step: Callable[..., float] | None = field(default=None, repr=False, compare=False)

    @property
    def adaptive(self) -> bool:
        """Whether the method chooses its steps itself."""
        return self.first_step is not None

    def structure(self, problem: Problem) -> str:
        """Return in words what holds of the method's map on that problem: symmetric, symplectic.

        A field does not say whether it is Hamiltonian, and that of a flow on a manifold, extended to
        the flat space around it, is not: no method of fields is called symplectic. Nor is a splitting
        whose parts are not (`geomint.Splitting`).
        """
        form = getattr(problem, self.needs)
        symplectic = self.symplectic and self.needs != "field" and getattr(form, "symplectic", True)
        return " and ".join(["symmetric"] * self.symmetric + ["symplectic"] * symplectic)

    def with_options(self, **changes: Any) -> Method:
        """Return the method with other options, such as its tolerance."""
        if not changes:
            return self
        remake = self.remake
        for option in changes:
            if option not in self.options or remake is None:
                hint = nearest(option, self.options)
                raise MethodError(f"method {self.name!r} has no option {quoted(option)}.{hint}")
            _check_type(option, changes[option], self.options[option])
        assert remake is not None
        return replace(remake(**{**self.options, **changes}), name=self.name)

    def check_fits(self, problem: Problem, clock: bool) -> None:
        """Raise `FormError`, naming what would fit, unless the method can integrate the problem."""
        if self.needs not in problem.forms:
            raise FormError(
                f"method {self.name!r} needs the form {self.needs!r}, but problem "
                f"{problem.name!r} offers {', '.join(problem.forms)}. {_advice(problem)}"
            )
        if clock and problem.clock is None:
            raise FormError(
                f"problem {problem.name!r} in τ has no clock dt/dτ: give it one, or the end as "
                f"tau_end with clock=False"
            )
        if clock and self.needs == "action":
            raise FormError(
                f"method {self.name!r} acts by a group and cannot integrate a clock beside it: "
                f"give the end in {problem.time!r}"
            )


def _check_type(name: str, value: Any, like: Any) -> None:
    """Raise `DomainError` unless `value` is of the kind of the option's present value."""
    kinds = {bool: "true or false", int: "a whole number", float: "a number"}
    accepted = (int, float) if isinstance(like, float) else type(like)
    if not isinstance(value, accepted) or isinstance(value, bool) != isinstance(like, bool):
        raise DomainError(name, value, kinds.get(type(like), type(like).__name__))


_FITTING = {
    "field": "gauss-8, dop853, rk-4",
    "action": "cf-4, rkmk-4",
    "hamiltonian": "rattle-2, rattle-4, rattle-6",
    "splitting": "verlet-2, verlet-4, verlet-6",
}


def _advice(problem: Problem) -> str:
    fitting = [f"{_FITTING[form]} (form {form!r})" for form in problem.forms]
    return f"Methods that fit: {'; '.join(fitting)}."
