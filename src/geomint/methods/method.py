"""What a method is: a value that says its order and the form it needs, and starts a stepper."""

import dataclasses
import functools
from abc import ABC, abstractmethod
from typing import Any, Literal, Self

from ..arguments import Array, number
from ..errors import FormError, MethodError, nearest, quoted
from ..problems.declaration import Kept, check_problem
from ..problems.evaluate import Rate, derivative
from ..problems.problem import Problem
from ..problems.shown import table
from ..problems.time_scale import characteristic_time
from ..references.reference import Reference
from ..tableaux import COMMUTATOR_FREE, COMPOSITIONS, RUNGE_KUTTA
from .flow import Flow
from .posed import Posed

__all__ = ["Form", "Method"]

MOST = 64  # flows that a problem keeps

Form = Literal["field", "action", "hamiltonian", "splitting", "exact"]


class Method(ABC):
    """An integration method: a frozen dataclass that inherits from this class.

    Methods are values: they compare, hash and pickle by what they are made of, `dataclasses.replace`
    changes them, and their repr can be pasted. Fields that only keywords may give are the method's
    *options*, which scenes and `with_options` may change, such as `max_iterations`. The attributes
    below are those of the class, or set by ``__post_init__`` where they depend on the fields.

    Attributes
    ----------
    name : str
        Lower case with hyphens; `geomint.methods.find_method` parses it back.
    order : int
    needs : str
        The form of the problem: ``field``, ``action``, ``hamiltonian`` or ``splitting``; of the exact
        flow ``exact``.
    step_fraction : float
        Default step, as a fraction of the state's shortest characteristic time.
    symmetric, symplectic : bool
        Structure of the method itself, in exact arithmetic: symplectic on the manifold for a method
        that needs ``hamiltonian`` or ``splitting``; for one that needs ``field``, for Hamiltonian
        fields on flat space. See `structure`. The kernel of a symmetric method takes the substeps
        `Posed.lengths`, so that `geomint.Compose` can raise its order.
    keeps : tuple of str
        What every step keeps to round-off, however long it is; `geomint.stress` holds the method to
        it. Some of ``"group orbits"``, ``"quadratic invariants"``, ``"constraints"``, and ``"steady
        motions"``: those whose generator is constant are followed exactly.
    adaptive : bool
        Whether the method chooses its steps itself.
    estimate_order : int or None
        The power of the step with which an error estimate falls, for `geomint.Adaptive`; None without.
    family : str
        What lists group it by, such as ``"Crouch–Grossman"``. May be left out.
    summary : str
        For lists and reports: what it is in a line. May be left out.
    references : tuple of Reference
        Where it is published; `geomint.cite` shows them. May be left out.
    """

    name: str
    order: int
    needs: Form
    step_fraction: float
    estimate_order: int | None = None
    symmetric: bool = False
    symplectic: bool = False
    adaptive: bool = False
    keeps: tuple[str, ...] = ()
    family: str = ""
    summary: str = ""
    references: tuple[Reference, ...] = ()

    @abstractmethod
    def flow(self, p: Posed) -> Flow:
        """Return the flow on a problem: the kernel, and what it needs whatever state and step."""

    def on(
        self,
        problem: Problem,
        y: Array,
        time: float = 0.0,
        clock: bool = False,
        compiled: bool = True,
    ) -> Flow:
        """Return the flow on a problem, which keeps it until what its functions reach has changed.

        Parameters
        ----------
        y, time : array, float
            A canonical state, at which functions are checked where that has not been done.
        clock : bool
            Whether physical time is integrated beside the state.
        compiled : bool
            False: plain Python, with the same bits.

        Raises
        ------
        FormError, DeclarationError
            If the method cannot integrate the problem, or its functions do not fit what it declares.
        """
        kept = problem.__dict__.setdefault("_flows", Kept())
        found: Flow | None = kept.get((self, clock, compiled))
        if found is None or not found.holds():
            self.check_fits(problem, clock)
            seen = check_problem(problem, y, self.needs, clock)
            found = self.flow(Posed(problem, y, time, clock, compiled))
            found.method, found.seen = self, seen
            if len(kept) >= MOST:
                kept.pop(next(iter(kept)), None)
            kept[self, clock, compiled] = found
        return found

    def adaptive_flow(self, p: Posed, allowed: Any) -> Flow:
        """Return the flow whose steps the error estimate chooses; see `geomint.Adaptive`."""
        raise NotImplementedError

    def _set(self, **attributes: Any) -> None:
        """Set what a frozen dataclass finds out when it is made: canonical fields, attributes."""
        vars(self).update(attributes)

    @property
    def options(self) -> dict[str, Any]:
        """The options and their values."""
        return {f.name: getattr(self, f.name) for f in given_to(type(self)) if f.kw_only}

    def with_options(self, **changes: Any) -> Self:
        """Return the method with other options, such as another `max_iterations`.

        Raises
        ------
        MethodError
            If it has no such option.
        DomainError
            For a value that makes no sense.
        """
        for option in changes:
            if option not in self.options:
                hint = nearest(option, self.options)
                raise MethodError(f"method {self.name!r} has no option {quoted(option)}.{hint}")
        return self._with(changes) if changes else self

    def _with(self, options: dict[str, Any]) -> Self:
        return dataclasses.replace(self, **options)  # type: ignore[type-var]

    def __repr__(self) -> str:
        fields = given_to(type(self))
        given = [pasted(getattr(self, f.name)) for f in fields if not f.kw_only]
        while len(given) > 1 and given[-1] == pasted(fields[len(given) - 1].default):
            given.pop()
        options = {f.name: f.default for f in fields if f.kw_only}
        changed = [(name, getattr(self, name)) for name in options]
        words = [f"{name}={value!r}" for name, value in changed if value != options[name]]
        return f"{type(self).__name__}({', '.join([*given, *words])})"

    def _repr_html_(self) -> str:
        kinds = ("symmetric", "symplectic", "adaptive")
        facts = {
            "name": self.name,
            "family": self.family,
            "order": self.order,
            "needs": self.needs,
            "structure": ", ".join(kind for kind in kinds if getattr(self, kind)),
            "keeps": ", ".join(self.keeps),
            "options": ", ".join(f"{name}={value!r}" for name, value in self.options.items()),
            "summary": self.summary,
        }
        return table(repr(self), {name: fact for name, fact in facts.items() if fact})

    def default_step(
        self,
        problem: Problem,
        y0: Array,
        span: float,
        start: float = 0.0,
        rate_at: Rate = derivative,
    ) -> float:
        """Return the step of a run over `span` from a time for which none is given, > 0.

        `rate_at` gives dy/dt, as `geomint.derivative` does in plain Python.
        """
        return self.step_fraction * characteristic_time(problem, y0, span, start, rate_at)

    def structure(self, problem: Problem) -> str:
        """Return in words what holds of the method's map on that problem: symmetric, symplectic.

        A method of fields is called symplectic where the problem states a symplectic form that is the
        same everywhere in flat space: the field of a flow on a manifold, extended to the space around
        it, keeps none. Nor is a splitting whose parts are not (`geomint.Splitting`).
        """
        form, omega, measure = (
            getattr(problem, self.needs),
            problem.symplectic_form,
            problem.measure,
        )
        symplectic = self.symplectic and getattr(form, "symplectic", True)
        if self.needs == "field":
            flat = measure is None or not measure.conditions
            symplectic = symplectic and omega is not None and omega.constant and flat
        return " and ".join(["symmetric"] * self.symmetric + ["symplectic"] * symplectic)

    def check_fits(self, problem: Problem, clock: bool) -> None:
        """Raise `FormError`, naming what would fit, unless the method can integrate the problem."""
        if self.needs not in problem.forms:
            raise FormError(
                f"method {self.name!r} needs the form {self.needs!r}, but problem "
                f"{problem.name!r} offers {', '.join(problem.forms)}. {fitting(problem)} "
                f"That form is given as {self.needs}={GIVEN.get(self.needs, '…')} of geomint.Problem."
            )
        if clock and problem.clock is None:
            advice = "its own time is physical, so clock=False"
            if problem.time == "tau":
                advice = "give it one, or the end as tau_end with clock=False"
            raise FormError(f"problem {problem.name!r} has no clock dt/dτ: {advice}")


@functools.cache
def given_to(kind: type) -> tuple[dataclasses.Field[Any], ...]:
    """Return the fields that a constructor takes; none of a class that is no dataclass."""
    known = dataclasses.fields(kind) if dataclasses.is_dataclass(kind) else ()
    return tuple(f for f in known if f.init)


def checked_method(what: str, method: Any, expected: str = "a geomint method") -> Method:
    """Return a method that says what every method has to say, or raise `MethodError`."""
    if not isinstance(method, Method):
        raise MethodError(f"{what} = {quoted(method)}: expected {expected}")
    missing = [name for name in _SAID if getattr(method, name, None) is None]
    if missing:
        raise MethodError(f"method {type(method).__name__} does not say its {', '.join(missing)}")
    return method


def pasted(value: Any) -> str:
    """Return what gives a field in a constructor: its name, for a tableau of a registry."""
    name = getattr(value, "name", "")
    known = any(table.get(name) == value for table in (RUNGE_KUTTA, COMMUTATOR_FREE, COMPOSITIONS))
    return repr(name if known else value)


_SAID = ("name", "order", "needs", "step_fraction")
FITTING = {
    "field": "gauss-8, dop853, rk-4",
    "action": "rkmk-dop853, cf-4, rkmk-4",
    "hamiltonian": "lobatto-8, rattle-2, rattle-4",
    "splitting": "verlet-8, verlet-4, verlet-2",
}
GIVEN = {
    "field": "f",
    "action": "geomint.GroupAction(generator, group)",
    "hamiltonian": "geomint.Hamiltonian(gradients, constraint, m)",
    "splitting": "geomint.natural_in_space(acceleration)",
}


def fitting(problem: Problem) -> str:
    """Return a sentence on which methods fit the forms of a problem."""
    named = [f"{FITTING[form]} (form {form!r})" for form in problem.forms]
    return f"Methods that fit: {'; '.join(named)}."


def iteration_tolerance(value: Any) -> float:
    """Return the tolerance of a fixed-point iteration, or raise `DomainError`."""
    return number("iteration_tolerance", value, 0.0, 1e-2, "a number in [0, 0.01)")
