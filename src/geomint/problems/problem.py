"""Problems: what is integrated, in the forms that methods need.

A `Problem` is data: functions recorded with `geomint.field` and parameters, no class tree. One
system offers several problems (times, representations), one problem one or more *forms*: an ODE
in redundant coordinates (``field``), a Lie group acting on the state (``action``), a Hamiltonian on
an embedded manifold (``hamiltonian``), a sum of parts with known flows (``splitting``); see
`geomint.problems.forms`. A method states the form that it needs.
"""

import copy
import dataclasses
import functools
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..arguments import MOST_NUMBERS, Array, as_array, as_vector, check_name, flat, whole
from ..errors import DomainError, FormError
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.sending import Sendable
from ..references.reference import Reference, checked_references
from .body_path import BodyPath
from .forms import FORMS, GroupAction, Hamiltonian, Measure, Splitting, check_recorded, check_types
from .shown import Shown
from .spaces.pieces import joined_pieces, piece_slices
from .spaces.space import Space
from .two_form import SymplecticForm
from .units import unit_among
from .watched_call import can_take

Time = Literal["t", "tau"]

MOST_ROWS = 10**7  # of a piece: steppers take some tens of times that
_OWN = ("invariants", "constraints", "observables")
GROUPS = (*_OWN, "all")  # what `geomint.solve` understands in `observe`


@dataclass(frozen=True, eq=False, repr=False)
class Problem(Shown, Sendable):
    """Something to integrate.

    Parameters
    ----------
    name : str
        For messages and reports.
    pieces : tuple of (name, rows), optional
        The documented order of the flat state, such as ``(("gamma", 3), ("p_tilde", 3))``; that of the
        space where there is one. Without a space all states are admissible.
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
    symplectic_form : SymplecticForm, optional
        A symplectic form that the flow keeps in the problem's own time; the canonical one where there
        is a Hamiltonian on states (q, p).
    make_state : callable
        Makes a state from keyword arguments; `Problem.state` calls it.
    make_random : callable, optional
        ``f(rng) -> dict``: components of a random admissible state, as `make_state` takes them;
        `Problem.random_state` calls it.
    make_exact : callable, optional
        ``f(y0)``: the exact motion through a state; `Problem.exact` calls it, and with
        ``method="exact"`` `geomint.solve`.
    make_path : callable, optional
        ``f(t, states)``: the `BodyPath` of a body along samples of a motion, states one a row, at
        physical times: attitude and contact point, for pictures of it.
    admit : callable
        Checks a flat state: returns it (possibly projected) or raises `DomainError`.
    physical : callable
        Maps a flat state to named arrays that other forms of the same system give too:
        what makes results in different times and representations comparable.
    parameters : mapping
        The parameters by name, for reports and files.
    equations : tuple of str
        The equations of motion, one a line, for reports.
    units : mapping of str to str
        The units of pieces of the state, quantities and times (``"t"``, ``"tau"``) by name, for labels;
        those of ``omega-1``, ``omega-2`` may be told as ``omega``. What is not named is dimensionless.
    space : Space, optional
        The space of states, such as ``geomint.TangentSphere(3)``. `make_state`, `make_random`, `admit`
        and the manifold of the measure are taken from it where they are not given, and its
        constraints are added by name.
    references : tuple of Reference
        Where the system and its equations are published; `geomint.cite` shows them.
    """

    name: str
    pieces: tuple[tuple[str, int], ...] = ()
    params: Array = dataclasses.field(default_factory=lambda: np.zeros(0))
    field: Recorded | None = None
    action: GroupAction | None = None
    hamiltonian: Hamiltonian | None = None
    splitting: Splitting | None = None
    work: int = 0
    time: Time = "t"
    clock: Recorded | None = None
    invariants: Mapping[str, Recorded] = dataclasses.field(default_factory=dict)
    constraints: Mapping[str, Recorded] = dataclasses.field(default_factory=dict)
    observables: Mapping[str, Recorded] = dataclasses.field(default_factory=dict)
    measure: Measure | None = None
    symplectic_form: SymplecticForm | None = None
    make_state: Callable[..., Array] | None = None
    make_random: Callable[[np.random.Generator], dict[str, Any]] | None = None
    make_exact: Callable[[Array], Any] | None = None
    make_path: Callable[[Array, Array], BodyPath] | None = None
    admit: Callable[[Array], Array] | None = None
    physical: Callable[[Array], dict[str, Array]] | None = None
    parameters: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    equations: tuple[str, ...] = ()
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    space: Space | None = None
    references: tuple[Reference, ...] = ()

    def __post_init__(self) -> None:
        check_types(self, {"name": str, "parameters": Mapping})
        params, parameters = flat("params", self.params), _own_parameters(self.parameters)
        vars(self).update(params=params, parameters=parameters)
        _check_text("name", self.name)
        equations = _lines(self.equations)
        vars(self).update(equations=equations, references=checked_references(self.references))
        check_types(self, {"units": Mapping})
        object.__setattr__(self, "units", dict(self.units))
        for name, unit in self.units.items():
            _check_text("units", name)
            _check_text(f"units[{name!r}]", unit)
        if self.space is not None:
            self._stand_on(self.space)
        work = whole("work", self.work, 0, MOST_NUMBERS)
        vars(self).update(work=work, pieces=_checked_pieces(self.pieces))
        if not (isinstance(self.time, str) and self.time in ("t", "tau")):
            raise DomainError("time", self.time, "'t' or 'tau'")
        self._check_functions()
        self._check_forms()

    def _stand_on(self, space: Space) -> None:
        """Take from the space what is not given."""
        check_types(self, {"space": Space, "constraints": Mapping})
        none = isinstance(self.pieces, tuple) and not self.pieces
        if not none and _checked_pieces(self.pieces) != space.pieces:
            raise DomainError("pieces", self.pieces, f"none, or those of the space, {space.pieces}")
        if not np.array_equal(self.params[: len(space.params)], space.params):
            expected = f"parameters that begin with those of the space, {space.params}"
            raise DomainError("params", self.params, expected)
        taken = {
            "pieces": space.pieces,
            "make_state": self.make_state or space.project,
            "make_random": self.make_random or space.random,
            "admit": self.admit or space.admit,
            "constraints": {**space.constraints, **self.constraints},
        }
        if isinstance(self.measure, Measure) and self.measure.manifold is None:
            density = self.measure.log_density
            base = self.measure.base
            taken["measure"] = Measure(density, space.manifold, space.conditions, base)
        vars(self).update(taken)

    def _check_functions(self) -> None:
        check_recorded(self, optional=("field", "clock"))
        if self.clock is not None and self.time == "t":
            raise DomainError("clock", self.clock, "None: the problem's own time is physical time")
        counts = {"make_random": 1, "make_exact": 1, "make_path": 2, "admit": 1, "physical": 1}
        for name in ("make_state", *counts):
            f, count = getattr(self, name), counts.get(name)
            if not (f is None or callable(f)):
                raise DomainError(name, f, "a function or None")
            if f is not None and count is not None and not can_take(f, count):
                said = "one argument" if count == 1 else "two arguments"
                raise DomainError(name, f, f"a function of {said}")
        seen = set()
        for group in _OWN:
            quantities = getattr(self, group)
            check_types(self, {group: Mapping})
            object.__setattr__(self, group, dict(quantities))
            for name, f in quantities.items():
                check_name(group, name)
                if name in seen or name in GROUPS:
                    expected = f"names unlike each other and unlike {', '.join(GROUPS)}"
                    raise DomainError(group, name, expected)
                if not isinstance(f, Recorded):
                    expected = "a function recorded with geomint.observable"
                    raise DomainError(f"{group}[{name!r}]", f, expected)
                seen.add(name)

    def _check_forms(self) -> None:
        if not self.forms:
            raise FormError(f"problem {self.name!r} has no form: give one of {', '.join(FORMS)}")
        kinds = {
            "action": GroupAction,
            "hamiltonian": Hamiltonian,
            "splitting": Splitting,
            "measure": Measure,
            "symplectic_form": SymplecticForm,
        }
        if self.symplectic_form is None and self.hamiltonian is not None:
            object.__setattr__(self, "symplectic_form", SymplecticForm())
        given = {name: kind for name, kind in kinds.items() if getattr(self, name) is not None}
        check_types(self, given)
        if self.hamiltonian is not None:
            if self.rows % 2:
                raise DomainError("pieces", self.pieces, "as many rows of q as of p")
            if self.hamiltonian.constraints >= self.rows // 2:
                expected = f"fewer than the {self.rows // 2} rows of q"
                raise DomainError("constraints", self.hamiltonian.constraints, expected)
        if self.measure is not None and self.measure.conditions >= self.rows:
            expected = f"fewer than the {self.rows} rows of the state"
            raise DomainError("conditions", self.measure.conditions, expected)
        if self.measure is not None and self.measure.base is not None:
            self._check_base(self.measure.base)

    def _check_base(self, base: Any) -> None:
        """Refuse a base that a fibre cannot lie over."""
        if not isinstance(base, Problem):
            raise DomainError("base", base, "a geomint.Problem, or None")
        if base.measure is None:
            raise FormError(f"measure.base: problem {base.name!r} has no measure")
        count = len(base.pieces)
        if count >= len(self.pieces) or base.pieces != self.pieces[:count]:
            expected = f"a problem in the first pieces of {self.pieces}"
            raise DomainError("base", base.pieces, expected)
        if base.time != self.time:
            raise DomainError("base", base.time, f"a problem in the same time, {self.time!r}")

    @functools.cached_property
    def rows(self) -> int:
        """Length of the flat state."""
        return sum(rows for _, rows in self.pieces)

    @functools.cached_property
    def _order(self) -> str:
        return f" in the order {', '.join(f'{name} ({rows})' for name, rows in self.pieces)}"

    def _shown(self) -> tuple[str, dict[str, Any]]:
        order = (f"{name} ({' × '.join(map(str, shape))})" for name, shape in self.shapes.items())
        facts = {
            "state": ", ".join(order),
            "space": "" if self.space is None else repr(self.space),
            "forms": ", ".join(self.forms),
            "time": "τ" if self.time == "tau" else "t",
            "parameters": ", ".join(self.parameters),
            **{group: ", ".join(getattr(self, group)) for group in _OWN},
            "measure": "" if self.measure is None else "stated",
            "symplectic form": "" if self.symplectic_form is None else "stated",
        }
        return f"problem {self.name!r}", {name: fact for name, fact in facts.items() if fact}

    @functools.cached_property
    def forms(self) -> tuple[str, ...]:
        """The forms that the problem offers."""
        return tuple(form for form in FORMS if getattr(self, form) is not None)

    @property
    def slices(self) -> dict[str, slice]:
        """Where each piece lies in the flat state."""
        return piece_slices(self.pieces)

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shape of each piece: that of a matrix where the space has one."""
        return (
            {name: (rows,) for name, rows in self.pieces}
            if self.space is None
            else self.space.shapes
        )

    @property
    def diagnostics(self) -> dict[str, Recorded]:
        """Everything that can be observed by name: invariants, constraints, observables."""
        return {**self.invariants, **self.constraints, **self.observables}

    def unit(self, name: str) -> str:
        """Return the unit of a piece, a component, a quantity or a time by its name."""
        return unit_among(self.units, name)

    def state(self, **components: Any) -> Array:
        """Return a flat state from named components; see the problem's own documentation."""
        if self.make_state is None:
            return self.canonical(joined_pieces(self.pieces, components))
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
            expected = f"it, or a space, for random states of {self.name!r}; else give states"
            raise DomainError("make_random", ..., expected)
        return self.state(**self.make_random(_generator(rng)))

    def exact(self, y0: Any) -> Any:
        """Return the exact motion through a state, where the problem has one: states without stepping.

        See `geomint.problems.exact_motion.ExactMotion`; what more it offers is said by the problem.

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

    def canonical(self, y: Any) -> Array:
        """Return `y` as a flat, finite, admissible float64 state, or raise `DomainError`."""
        state = as_vector("state", y, self.rows, self._order)
        if self.admit is None:
            if self.forms[0] != "hamiltonian":
                return state
            from .evaluate import on_constraints

            return on_constraints(self, state)
        return as_vector("state", self.admit(state), self.rows, f", as `admit` of {self.name!r}")

    def physical_state(self, y: Array) -> dict[str, Array]:
        """Return the named arrays by which results of different forms are compared."""
        return {"state": np.asarray(y)} if self.physical is None else self.physical(y)


def _check_text(what: str, text: Any) -> None:
    """Raise `DomainError` for what files cannot have: no text, or half of a pair of characters."""
    try:
        text.encode()
    except (AttributeError, UnicodeEncodeError):
        raise DomainError(what, text, "a text that UTF-8 can encode") from None


def _own_parameters(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters by names that files can have, with arrays and lists of the problem's own."""
    for name in parameters:
        _check_text("parameters", name)
    own = dict(parameters)
    for name, value in own.items():
        if isinstance(value, np.ndarray | list):
            with suppress(Exception):  # of what is in them
                own[name] = copy.deepcopy(value)
    return own


def _lines(equations: Any) -> tuple[str, ...]:
    """Return lines of text as a tuple."""
    expected = "a list of texts, a line each"
    if isinstance(equations, str) or not isinstance(equations, list | tuple):
        raise DomainError("equations", equations, expected)
    for line in equations:
        _check_text("equations", line)
    return tuple(equations)


def _generator(rng: Any) -> np.random.Generator:
    """Return what numpy makes of a seed, or raise `DomainError`."""
    expected = "what numpy.random.default_rng takes"
    if isinstance(rng, list | tuple) and as_array("rng", rng, expected).ndim != 1:
        raise DomainError("rng", rng, expected)  # numpy crashes where lists are nested too deep
    try:
        return np.random.default_rng(rng)
    except Exception:  # of several types
        raise DomainError("rng", rng, expected) from None


def _checked_pieces(pieces: Any) -> tuple[tuple[str, int], ...]:
    """Return pairs of a name and a number of rows, or raise `DomainError`."""
    expected = (
        "pairs (name, rows) with names unlike each other and whole numbers rows from 1 to 10⁷"
    )
    try:
        given = [(name, rows) for name, rows in pieces]
    except Exception as error:  # whatever a foreign object raises there
        raise DomainError("pieces", pieces, expected) from error
    for name, _ in given:
        check_name("pieces", name)
    try:
        pairs = [(name, whole("rows", rows, 1, MOST_ROWS)) for name, rows in given]
    except DomainError as error:
        raise DomainError("pieces", pieces, expected) from error
    if not pairs or len({name for name, _ in pairs}) < len(pairs):
        raise DomainError("pieces", pieces, expected)
    return tuple(pairs)
