"""How the end of a run depends on where it began and on the parameters of its problem."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from types import FunctionType
from typing import Any

import numpy as np

from ..arguments import Array, finite
from ..errors import DomainError, GeomintError, quoted, raised
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import CONSTRAINT
from ..methods import Method
from ..problems.bound import given_at
from ..problems.derivatives import gradient
from ..problems.deviation import sizes_of
from ..problems.evaluate import derivative, observable_of, value
from ..problems.problem import Problem
from ..problems.shown import Shown
from .tangent_flow import tangent_flow

WIDEST, HALVINGS, TRIES = 0.1, 4, 6  # differences over a tenth of a parameter, and over less
WIDER = 16.0  # over so much more, where a parameter is tiny beside what it is added to
RELIABLE = 1e-10  # relative: a derivative by differences that does not settle so far is refused
LEFT = 1e-6  # likewise of one that loses more to rounding
ROUNDING = 2.0 ** (HALVINGS - 51)  # of differences over the least width, of numbers over the widest
LEAST_KINK = 1e-2  # rounding makes of differences of both sides up to so much less of a kink
APART = 0.1  # of the size of a piece: where functions are compared beside the run


@dataclass(frozen=True)
class Quantity:
    """A number at the end of a run, and its derivatives.

    Attributes
    ----------
    value : float
    by_state : array, shape (rows,)
    by_parameters : array, shape (k,)
    """

    value: float
    by_state: Array
    by_parameters: Array


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivities(Shown):
    """The end of a run and its derivatives.

    Attributes
    ----------
    y : array, shape (rows,)
        The state at the end.
    by_state : array, shape (rows, rows)
        ∂y/∂y₀.
    parameters : tuple of str
        The names of the k parameters.
    by_parameters : array, shape (rows, k)
        dy/dθ of each of them, the initial state moving with it if it depends on it.
    quantities : dict of name to Quantity
        The same of what was observed.
    """

    y: Array
    by_state: Array
    parameters: tuple[str, ...]
    by_parameters: Array
    quantities: dict[str, Quantity]

    def _shown(self) -> tuple[str, dict[str, Any]]:
        facts = {
            "parameters": ", ".join(self.parameters),
            "largest ∂y/∂y₀": _largest(self.by_state),
        }
        if self.parameters:
            facts["largest dy/dθ"] = _largest(self.by_parameters)
        facts |= {name: f"{q.value:.6g}" for name, q in self.quantities.items()}
        return "sensitivities", {name: fact for name, fact in facts.items() if fact}


def _largest(x: Array) -> str:
    return f"{np.abs(x).max():.6g}"


def sensitivities(
    problem: Problem | Callable[..., Any],
    y0: Any = None,
    *,
    parameters: Mapping[str, float] | None = None,
    observe: str | Recorded | Iterable[str | Recorded] = (),
    t_end: Any = None,
    tau_end: Any = None,
    method: str | Method | None = None,
    step: Any = None,
    t0: float = 0.0,
) -> Sensitivities:
    """Return how the end of a run depends on the initial state and on parameters.

    The derivatives are those of the numerical map, to rounding (`geomint.tangent_flow`), so that they
    are as near to those of the motion as the run is to the motion. Integrals along a motion are
    numbers of the state by `geomint.with_quadrature`.

    Parameters
    ----------
    problem : Problem, or callable
        With `parameters` a function of them by name that returns the problem, or the problem and the
        initial state. How the flat parameters and the state depend on them is found by differences
        over up to a tenth of the parameter, extrapolated to about 1e-13; how the run depends on these
        is exact.
    y0 : array_like
        The initial state, unless the function returns it.
    parameters : mapping of str to float, optional
        Values of the parameters.
    observe : names or functions
        Quantities at the end: the problem's own by name, or recorded with `geomint.observable`.
    t_end, tau_end, method, step, t0
        As those of `geomint.tangent_flow`.

    Returns
    -------
    Sensitivities

    Raises
    ------
    DomainError
        For parameters on which the problem does not depend smoothly, or by other ways than its flat
        parameters: a recorded function that uses the value itself does not change with it. That is
        looked for where the run begins and ends, and beside. For a quantity that has no derivative at
        the end.
    ArgumentError, FormError, DeclarationError, MethodError, ConvergenceError, NonFiniteError, \
StepSizeError
        As `geomint.tangent_flow`.

    Examples
    --------
    >>> import chaplygin as ch, geomint as gi
    >>> def sphere(D):
    ...     problem = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=D).hamiltonized()
    ...     return problem, problem.state(gamma=[0.48, 0.6, 0.64], p=[0.8, 1.0, -1.5375])
    >>> found = gi.sensitivities(sphere, parameters={"D": 4.0}, tau_end=2.0, step=0.1)
    >>> found.by_parameters.shape
    (6, 1)
    """
    family = _Family(problem, y0, {} if parameters is None else parameters)
    p, start = family.problem, family.state
    directions, moved = np.eye(p.rows), np.zeros((len(p.params), 0))
    if family.values:
        changes = [family.slopes(name) for name in family.values]
        directions = np.column_stack([directions, *(of_state for _, of_state in changes)])
        moved = np.column_stack([np.zeros((len(p.params), p.rows)), *(c for c, _ in changes)])
    flow = tangent_flow(
        p, start, t_end=t_end, tau_end=tau_end, method=method, step=step, t0=t0,
        directions=directions, parameters=moved if moved.any() else None,
    )  # fmt: skip
    by_state, by_parameters = flow.slopes[:, : p.rows], flow.slopes[:, p.rows :]
    end = float(t_end if tau_end is None else tau_end)
    names = [observe] if isinstance(observe, str | Recorded | FunctionType) else observe
    if not isinstance(names, Iterable):
        raise DomainError("observe", observe, "names of quantities, or functions")
    quantities = {}
    functions: dict[str, Recorded] = {}
    for each in names:
        f = observable_of(p, each, flow.y)
        name = each if isinstance(each, str) else f.function.__name__
        if functions.setdefault(name, f).function is not f.function:
            raise DomainError("observe", observe, f"functions of different names: two are {name!r}")
        by_y = gradient(p, f, flow.y, end)
        direct = np.zeros(len(family.values))
        if moved.any():
            direct = gradient(p, f, flow.y, end, by="parameters") @ moved[:, p.rows :]
        if not np.isfinite(by_y).all() or not np.isfinite(direct).all():
            expected = "quantities with derivatives where the run ends: |x| has none at 0"
            raise DomainError("observe", name, expected)
        quantities[name] = Quantity(
            value(p, f, flow.y, end), by_y @ by_state, by_y @ by_parameters + direct
        )
    own = [name for name in functions if name in p.diagnostics]
    family.check(own, [(start, float(t0)), (flow.y, end)])
    return Sensitivities(flow.y, by_state, tuple(family.values), by_parameters, quantities)


class _Family:
    """A problem and its initial state as functions of parameters."""

    def __init__(self, problem: Any, y0: Any, parameters: Any) -> None:
        if not isinstance(parameters, Mapping):
            raise DomainError("parameters", parameters, "a mapping of names to numbers")
        if not all(isinstance(name, str) for name in parameters):
            raise DomainError("parameters", parameters, "a mapping of names to numbers")
        self._moved: dict[str, float] = {}
        self.values = {name: finite(f"parameters[{name!r}]", x) for name, x in parameters.items()}
        self._given, self._y0 = problem, y0
        if isinstance(problem, Problem) and self.values:
            expected = "none of a problem: give a function of them that returns the problem"
            raise DomainError("parameters", parameters, expected)
        self.problem, self.state = self._made(self.values)

    def _made(self, values: Mapping[str, float]) -> tuple[Problem, Array]:
        """Return the problem and its initial state for some values."""
        found = self._given if isinstance(self._given, Problem) else None
        y0 = self._y0
        if found is None:
            if not callable(self._given):
                raise DomainError("problem", self._given, "a geomint.Problem, or a function")
            try:
                inspect.signature(self._given).bind(**values)
            except TypeError as error:
                given = ", ".join(values) or "none"
                raise DomainError("parameters", given, f"those of the function: {error}") from None
            except ValueError:  # of one that does not say
                pass
            try:
                found = self._given(**values)
            except GeomintError:
                raise
            except Exception as error:
                said = f"a function that returns a problem for {quoted(dict(values))}"
                reason = f"{said}: {raised(error)}"
                raise DomainError("problem", self._given, reason) from error
        if isinstance(found, tuple) and len(found) == 2:
            if y0 is not None:
                raise DomainError("y0", y0, "None: the function returns an initial state")
            found, y0 = found
        if not isinstance(found, Problem):
            expected = "a function that returns a geomint.Problem, or one and a state"
            raise DomainError("problem", self._given, expected)
        return found, found.canonical(y0)

    def slopes(self, name: str) -> tuple[Array, Array]:
        """Return the derivatives of the flat parameters and of the state by a parameter.

        By central differences over h, h/2, … that are extrapolated to 0 (L. F. Richardson); where the
        parameter cannot move so far, or they do not settle, over less; where they are lost in rounding,
        as those of a tiny number in a sum are, over more.
        """
        value, count = self.values[name], len(self.problem.params)
        least, most = WIDEST * (abs(value) or 1.0), WIDEST * max(abs(value), 1.0)
        here = self._flat(self.values)
        best, lost, width = np.zeros(len(here)), np.inf, least
        failure: GeomintError = self._rough(name)
        for _ in range(2 * TRIES):
            settled, part = False, np.inf
            try:
                found, off = self._extrapolated(name, value, width, here)
            except GeomintError as error:
                failure = error
            else:
                size = float(np.abs(found).max())
                moved = (found != 0.0) | (off != 0.0)
                rounding = ROUNDING * float(np.abs(here[moved]).max(initial=0.0)) / width
                settled = bool((off <= RELIABLE * size + rounding).all())
                part = rounding / size if size > rounding else 1.0
                failure = failure if settled else self._rough(name)
            if settled and (part < lost or width == most):
                best, lost = found, part if width < most else 0.0
                self._moved[name] = value + width
            if lost <= RELIABLE:
                break
            if settled:
                width = min(max(part / RELIABLE, WIDER) * width if part < 1.0 else most, most)
            elif lost < 1.0 or (lost < np.inf and width <= least):
                break
            else:
                width *= 0.25
        if lost == np.inf:
            raise failure
        if lost > LEFT and (lost < 1.0 or self._depends(name, here)):
            expected = "a value that is not lost in rounding beside what it is added to"
            raise DomainError(f"parameters[{name!r}]", value, expected)
        return best[:count], best[count:]

    def _rough(self, name: str) -> DomainError:
        expected = "a value near which parameters and initial state are smooth functions of it"
        return DomainError(f"parameters[{name!r}]", self.values[name], expected)

    def _depends(self, name: str, here: Array) -> bool:
        """Tell whether anything depends on a parameter: over more than a part of a tiny one."""
        far = self.values[name] + max(abs(self.values[name]), 1.0)
        try:
            return bool((self._flat({**self.values, name: far}) != here).any())
        except GeomintError:
            return False

    def _extrapolated(
        self, name: str, value: float, widest: float, here: Array
    ) -> tuple[Array, Array]:
        """Return derivatives, and how far off they are: by the last differences, and by a kink.

        At a kink differences of both sides have a limit too, but it is not that of one side.
        """
        slopes, kinks = [], []
        for h in (widest / 2**i for i in range(HALVINGS + 1)):
            ahead, behind = (self._flat({**self.values, name: value + s * h}) for s in (1.0, -1.0))
            slopes.append((ahead - behind) / ((value + h) - (value - h)))
            kinks.append((ahead - here) / ((value + h) - value) - (here - behind) / h)
        found, before = _limit(slopes, 4.0)
        kink, _ = _limit(kinks, 2.0)
        return found, np.maximum(np.abs(found - before), LEAST_KINK * np.abs(kink))

    def _flat(self, values: Mapping[str, float]) -> Array:
        problem, state = self._made(values)
        if len(problem.params) != len(self.problem.params) or len(state) != len(self.state):
            raise DomainError("parameters", quoted(dict(values)), "values of one and the same form")
        return np.concatenate([problem.params, state])

    def check(self, names: Iterable[str], ends: Iterable[tuple[Array, float]]) -> None:
        """Raise `DomainError` where a function changes with a parameter that it does not get.

        Functions are compared where the run begins and ends, and beside: what a function holds may not
        be seen at a state at rest, or at time 0.
        """
        rng = np.random.default_rng(20103)
        places = []
        for y, t in ends:
            shifts = APART * sizes_of(self.problem, y) * rng.normal(size=(2, len(y)))
            places += [(y, t), *((y + shift, t) for shift in shifts)]
        for name, moved in self._moved.items():
            other, _ = self._made({**self.values, name: moved})
            own = _with_params(self.problem, other.params)
            for y, t in places:
                expected, found = (_numbers(problem, names, y, t) for problem in (other, own))
                for x, z in zip(found, expected, strict=True):
                    size = float(np.abs(z[np.isfinite(z)]).max(initial=0.0))
                    if not np.allclose(x, z, rtol=1e-9, atol=1e-12 * size, equal_nan=True):
                        said = (
                            "a parameter that functions read from params: they hold this one as a "
                            "constant"
                        )
                        raise DomainError(f"parameters[{name!r}]", self.values[name], said)


def _limit(table: list[Array], factor: float) -> tuple[Array, Array]:
    """Return what differences over h, h/2, … tend to, and what all but the last step say of it.

    Their errors are of two orders of h more each time, the first one halved by the root of `factor`.
    """
    before = table[-1]
    while len(table) > 1:
        before = table[-1]
        pairs = pairwise(table)
        table = [fine + (fine - coarse) / (factor - 1.0) for coarse, fine in pairs]
        factor *= 4.0
    return table[0], before


@np.errstate(all="ignore")
def _numbers(problem: Problem, names: Iterable[str], y: Array, t: float) -> list[Array]:
    """Return what the functions of a problem give: all its forms, and quantities by name."""
    forms = problem.forms
    found = []
    for form in forms:
        others = dict.fromkeys((name for name in forms if name != form), None)
        found.append(derivative(replace(problem, **others, clock=None), y, t))  # type: ignore[arg-type]
    if problem.hamiltonian is not None:
        found += CONSTRAINT.run(problem.hamiltonian.constraint, **given_at(problem, y))
    return found + [np.array([value(problem, name, y, t)]) for name in names]


def _with_params(problem: Problem, params: Array) -> Problem:
    """Return the problem with other flat parameters, for its functions alone."""
    own = {"space": None, "make_state": None, "make_random": None, "make_exact": None}
    return replace(problem, params=params, admit=None, **own)  # type: ignore[arg-type]
