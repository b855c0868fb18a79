"""Problems: what is integrated, in the forms that methods need.

A `Problem` is data: functions recorded with `geomint.field` and parameters, no class tree. One
system offers several problems (times, representations), one problem one or more *forms*: an ODE
in redundant coordinates (``field``), a Lie group acting on the state (``action``), a Hamiltonian on
an embedded manifold (``hamiltonian``), a sum of parts with known flows (``splitting``); see
`geomint.forms`. A method states the form that it needs.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .errors import DomainError, FormError, nearest
from .forms import FORMS, GroupAction, Hamiltonian, Measure, Splitting
from .kernels.recorded import Recorded

__all__ = ["Problem"]

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """Something to integrate.

    Parameters
    ----------
    name : str
        For messages and reports.
    pieces : tuple of (name, rows)
        The documented order of the flat state, such as ``(("gamma", 3), ("p_tilde", 3))``.
    params : array_like
        The flat parameters that all functions get.
    field, action, hamiltonian, splitting
        The forms; at least one.
    work : int
        Rows of scratch that the functions need.
    time : ``"t"`` or ``"tau"``
        The problem's own time. With ``"tau"``, `clock` is needed for physical time.
    clock : recorded ``f(params, t, y, work) -> number``
        dt/dτ along the flow, for a problem in τ only.
    invariants, constraints, observables : mapping of name to recorded ``f(params, t, y, work)``
        Constants of motion; functions that vanish on the manifold of states; others of interest.
    measure : Measure, optional
        An invariant measure of the flow in the problem's own time.
    make_state : callable
        Makes a state from keyword arguments; `Problem.state` calls it.
    make_random : callable, optional
        ``f(rng) -> dict``: components of a random admissible state, as `make_state` takes them;
        `Problem.random_state` calls it.
    make_exact : callable, optional
        ``f(y0)``: the exact motion through a state; `Problem.exact` calls it.
    admit : callable
        Checks a flat state: returns it (possibly projected) or raises `DomainError`.
    physical : callable
        Maps a flat state to named arrays that other forms of the same system give too:
        what makes results in different times and representations comparable.
    parameters : mapping
        The parameters by name, for reports.
    """

    name: str
    pieces: tuple[tuple[str, int], ...]
    params: Array = dataclasses.field(default_factory=lambda: np.zeros(0))
    field: Recorded | None = None
    action: GroupAction | None = None
    hamiltonian: Hamiltonian | None = None
    splitting: Splitting | None = None
    work: int = 0
    time: str = "t"
    clock: Recorded | None = None
    invariants: Mapping[str, Recorded] = dataclasses.field(default_factory=dict)
    constraints: Mapping[str, Recorded] = dataclasses.field(default_factory=dict)
    observables: Mapping[str, Recorded] = dataclasses.field(default_factory=dict)
    measure: Measure | None = None
    make_state: Callable[..., Array] | None = None
    make_random: Callable[[np.random.Generator], dict[str, Any]] | None = None
    make_exact: Callable[[Array], Any] | None = None
    admit: Callable[[Array], Array] | None = None
    physical: Callable[[Array], dict[str, Array]] | None = None
    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        params = np.array(self.params, dtype=np.float64, ndmin=1)
        if not np.isfinite(params).all():
            raise DomainError("params", params, "finite numbers")
        params.setflags(write=False)
        object.__setattr__(self, "params", params)
        if not self.pieces or any(rows < 1 for _, rows in self.pieces):
            raise DomainError("pieces", self.pieces, "pairs (name, rows) with rows ≥ 1")
        if not self.forms:
            raise FormError(f"problem {self.name!r} has no form: give one of {', '.join(FORMS)}")
        if self.time not in ("t", "tau"):
            raise DomainError("time", self.time, "'t' or 'tau'")
        if self.time == "t" and self.clock is not None:
            raise DomainError("clock", self.clock, "None, or time='tau': t is physical time itself")

    @property
    def rows(self) -> int:
        """Length of the flat state."""
        return sum(rows for _, rows in self.pieces)

    @property
    def forms(self) -> tuple[str, ...]:
        """The forms that the problem offers."""
        return tuple(form for form in FORMS if getattr(self, form) is not None)

    @property
    def slices(self) -> dict[str, slice]:
        """Where each piece lies in the flat state."""
        result, start = {}, 0
        for name, rows in self.pieces:
            result[name] = slice(start, start + rows)
            start += rows
        return result

    @property
    def diagnostics(self) -> dict[str, Recorded]:
        """Everything that can be observed by name: invariants, constraints, observables."""
        return {**self.invariants, **self.constraints, **self.observables}

    def state(self, **components: Any) -> Array:
        """Return a flat state from named components; see the problem's own documentation."""
        if self.make_state is None:
            return self._assemble(components)
        return self.canonical(self.make_state(**components))

    def random_state(self, rng: Any = None) -> Array:
        """Return a random admissible state: directions uniform, momenta and velocities normal.

        Parameters
        ----------
        rng : Generator, int or None
            As `numpy.random.default_rng` takes it; the same seed gives the same state.

        Raises
        ------
        DomainError
            If the problem has no random states.
        """
        if self.make_random is None:
            raise DomainError("rng", rng, f"a problem with random states; {self.name!r} has none")
        return self.state(**self.make_random(np.random.default_rng(rng)))

    def exact(self, y0: Any) -> Any:
        """Return the exact motion through a state, where the problem has one: states without stepping.

        See `geomint.exact.ExactMotion`; what more it offers is said by the problem.

        Raises
        ------
        FormError
            If the problem has no exact flow.
        DomainError
            If there is none through this state.
        """
        if self.make_exact is None:
            raise FormError(f"problem {self.name!r} has no exact flow")
        return self.make_exact(self.canonical(y0))

    def _assemble(self, components: Mapping[str, Any]) -> Array:
        names = [name for name, _ in self.pieces]
        for name in components:
            if name not in names:
                raise DomainError(name, components[name], f"one of {names}.{nearest(name, names)}")
        parts = []
        for name, rows in self.pieces:
            if name not in components:
                raise DomainError(name, None, f"{rows} numbers")
            parts.append(as_vector(name, components[name], rows))
        return self.canonical(np.concatenate(parts))

    def canonical(self, y: Any) -> Array:
        """Return `y` as a flat, finite, admissible float64 state, or raise `DomainError`."""
        order = ", ".join(f"{name} ({rows})" for name, rows in self.pieces)
        state = as_vector("state", y, self.rows, f" in the order {order}")
        return state if self.admit is None else self.admit(state)

    def physical_state(self, y: Array) -> dict[str, Array]:
        """Return the named arrays by which results of different forms are compared."""
        return {"state": np.asarray(y)} if self.physical is None else self.physical(y)


def as_vector(name: str, value: Any, rows: int, detail: str = "") -> Array:
    """Return `value` as a new finite float64 vector of length `rows`, or raise `DomainError`."""
    try:
        vector = np.array(value, dtype=np.float64).reshape(-1)
    except (TypeError, ValueError):
        raise DomainError(name, value, f"{rows} numbers{detail}") from None
    if np.iscomplexobj(value):
        raise DomainError(name, value, f"{rows} real numbers{detail}")
    if len(vector) != rows:
        raise DomainError(name, value, f"{rows} numbers{detail}, got {len(vector)}")
    if not np.isfinite(vector).all():
        raise DomainError(name, value, "finite numbers")
    return vector
