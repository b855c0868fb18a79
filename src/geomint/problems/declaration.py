"""What a problem declares, held to what its functions do: once, in plain Python, before they run.

Compiled code has no bounds check: a row number that is negative or too large reads or writes other
memory, and a row of ``out`` that is never written keeps what was in it. So every function is run once,
at the state from which a run starts, on blocks of the sizes that the problem declares, which watch what
is read and written (`geomint.problems.watched_call`). What does not fit is a `DeclarationError`.

What has been found to fit is remembered: with the problem; of groups, which know no problem, in the
process. So another state, or another run, costs nothing, and shows nothing new. It is remembered under
what a function reaches: after a change of a global value it is run again.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np

from ..arguments import Array
from ..errors import DeclarationError
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import (
    ACTION,
    BRACKET,
    CONSTRAINT,
    EXTENT,
    FIELD,
    FLOW,
    GRADIENTS,
    TANGENT_MAP,
    TWO_FORM,
    VALUE,
    Signature,
)
from .bound import given_at
from .forms import Group, GroupAction, Hamiltonian, Measure, Splitting
from .groups import own_sizes
from .problem import Problem
from .two_form import SymplecticForm
from .watched_call import watched_call

Fingerprints = tuple[str, ...]  # of functions, after the form that they are of
T = TypeVar("T")
MOST = 64  # things that a problem keeps
FEW = 60  # rows up to which all functions are run; beyond, one that is not used may take seconds
NOW, LATER = np.float64(0.0), np.float64(1.0)
STEP = np.float64(1e-2)  # over which flows and moves are tried: groups need not scale and square
AGREES = 1e-6  # relative: how nearly a separable Hamiltonian must be one

_fitting_groups: set[tuple[Any, ...]] = set()


def check_problem(
    problem: Problem,
    y: Array,
    form: str,
    clock: bool = False,
) -> Fingerprints:
    """Raise `DeclarationError` unless the functions of a problem fit what it declares.

    Parameters
    ----------
    form : str
        The one that is integrated. Where the state is small all others are checked as well.
    clock : bool
        Whether the clock is integrated.

    Returns
    -------
    tuple
        The form, and the fingerprints of what is integrated.
    """
    seen = problem.__dict__.setdefault("_all_seen", [])
    if problem.rows <= FEW and not seen:
        _check_all(problem, y)
        seen.append(True)
    key = check_form(problem, form, y)
    if clock and problem.clock is not None:
        key += (check_value(problem, problem.clock, y),)
    return key


def check_watched(
    problem: Problem, y: Array, watched: Mapping[str, Recorded | Measure | SymplecticForm]
) -> None:
    """Raise `DeclarationError` unless what is observed, or looked for, fits the problem.

    By argument, as ``observe['K']``: functions of the problem, or others.
    """
    for name, f in watched.items():
        _check_watched(problem, f, y, name)


def check_form(problem: Problem, form: str, y: Array) -> Fingerprints:
    """Raise `DeclarationError` unless the functions of one form fit the problem.

    Returns
    -------
    tuple
        The form and the fingerprints of its functions.
    """
    given = getattr(problem, form)
    key = (form, *[f.fingerprint for f in functions_of(problem, form)])
    if is_new(problem, key):
        _FORMS[form](problem, given, y)
        remember(problem, key)
    return key


def check_value(problem: Problem, f: Recorded, y: Array, role: str = "") -> str:
    """Raise `DeclarationError` unless ``f(params, t, y, work) -> number`` fits the problem.

    Returns
    -------
    str
        The fingerprint of the function.
    """
    return _check_once(problem, f, VALUE, y, role)


def _check_once(
    problem: Problem, f: Recorded, signature: Signature, y: Array, role: str, **others: int
) -> str:
    now = f.fingerprint
    seen = *signature.names, now
    if is_new(problem, seen):
        own = next((name for name, g in _values(problem) if g.function is f.function), role)
        _watched(problem, own or f.function.__name__, f, signature, y, **others)
        remember(problem, seen)
    return now


def _watched(
    problem: Problem, role: str, f: Recorded, signature: Signature, y: Array, **others: Any
) -> dict[str, Any]:
    """Run a function at a state, and return its arguments: blocks that have watched it."""
    return watched_call(problem.name, role, f, signature, given_at(problem, y, **others))


class Kept(dict[Any, Any]):
    """What a problem keeps in this process; copies and pickles have none: addresses are no use."""

    def __reduce__(self) -> Any:
        return type(self), ()

    def __deepcopy__(self, memo: Any) -> Kept:
        return type(self)()


def kept_with(problem: Problem, key: Hashable, make: Callable[[], T]) -> T:
    """Return what a problem keeps under a key, made when it is asked for first."""
    kept = problem.__dict__.setdefault("_kept", Kept())
    found = kept.get(key)
    if found is None:
        if len(kept) >= MOST:
            kept.clear()
        found = kept[key] = make()
    return found


def unshared(problem: Problem) -> Problem:
    """Return a problem of its own for another thread: it is admitted, but has run at no state.

    That all of its functions were looked at is known to both; those that run there are again.
    """
    problem.__dict__.setdefault("_all_seen", [])
    own = object.__new__(type(problem))
    kept = {k: v for k, v in problem.__dict__.items() if k != "_fitting"}
    own.__dict__.update(kept)
    return own


def is_new(problem: Problem, what: Any) -> bool:
    """Tell whether it has not been seen to fit yet: a function's fingerprint, or a tuple with one."""
    return what not in problem.__dict__.setdefault("_fitting", set())


def remember(problem: Problem, what: Any) -> None:
    """Let it be known that something fits."""
    problem.__dict__["_fitting"].add(what)


def functions_of(problem: Problem, form: str) -> tuple[Recorded, ...]:
    """Return all functions of a form, with those of its group."""
    given = getattr(problem, form)
    return kept_with(problem, ("functions", form), lambda: tuple(_functions(given)))


def _functions(form: Any) -> Iterator[Recorded]:
    if isinstance(form, Recorded):
        yield form
        return
    for part in vars(form).values():
        if isinstance(part, Recorded | Group):
            yield from _functions(part)


def _check_all(problem: Problem, y: Array) -> None:
    for form in problem.forms:
        check_form(problem, form, y)
    for f in (*dict(_values(problem)).values(), problem.measure, problem.symplectic_form):
        if f is not None:
            _check_watched(problem, f, y)


def _values(problem: Problem) -> Iterator[tuple[str, Recorded]]:
    """Yield the functions of a problem that return a number, with what they are to it."""
    if problem.clock is not None:
        yield "clock", problem.clock
    if problem.measure is not None:
        yield "measure.log_density", problem.measure.log_density
    for group in ("invariants", "constraints", "observables"):
        for name, f in getattr(problem, group).items():
            yield f"{group}[{name!r}]", f


# --- forms ----------------------------------------------------------------------------------------


def _check_watched(
    problem: Problem, f: Recorded | Measure | SymplecticForm, y: Array, role: str = ""
) -> None:
    if isinstance(f, Recorded):
        check_value(problem, f, y, role)
    elif isinstance(f, SymplecticForm):
        _check_once(problem, f.form, TWO_FORM, y, "symplectic_form.form")
    else:
        check_value(problem, f.log_density, y)
        if f.manifold is not None:
            _check_once(problem, f.manifold, FIELD, y, "measure.manifold", out=f.conditions)


def _check_field(problem: Problem, f: Recorded, y: Array) -> None:
    _watched(problem, "field", f, FIELD, y)


def _check_action(problem: Problem, action: GroupAction, y: Array) -> None:
    rows = action.group.algebra_rows
    _watched(problem, "action.generator", action.generator, FIELD, y, out=rows)
    own = own_sizes(action.group)
    if own is None:
        _check_group(problem, action.group)
        return
    declared = (rows, problem.rows, action.group.work)
    for block, has, wanted in zip(("xi", "y", "work"), declared, own, strict=True):
        if has != wanted and not (block == "work" and has > wanted):
            what = f"({action.group.name}) wants {wanted} rows of {block}, where there are {has}"
            raise DeclarationError(problem.name, "action.group", what, block, wanted, has)


def _check_group(problem: Problem, group: Group) -> None:
    """Run the functions of a group on a state and on elements of no special kind."""
    n, m = problem.rows, group.algebra_rows
    element, state = STEP * np.cos(np.arange(1.0, m + 1.0)), np.sin(np.arange(1.0, n + 1.0))
    other = np.sin(element)
    given = {"layout": group.layout, "work": group.work, "v": other}
    given |= dict.fromkeys(("xi", "x", "u"), element)
    for name, signature in _MAPS.items():
        f = getattr(group, name)
        key = f and (name, f.fingerprint, group.layout.tobytes(), m, n, group.work)
        if key and key not in _fitting_groups:
            given |= {"y": state, "out": n} if signature is ACTION else {"y": other, "out": m}
            watched_call(problem.name, f"action.group.{name}", f, signature, given)
            _fitting_groups.add(key)


def _check_hamiltonian(problem: Problem, form: Hamiltonian, y: Array) -> None:
    _gradients(problem, form, y)
    _watched(problem, "hamiltonian.constraint", form.constraint, CONSTRAINT, y)
    if form.separable:
        _check_separable(problem, form, *np.split(y, 2))


def _gradients(problem: Problem, form: Hamiltonian, *y: Array, t: Any = NOW) -> list[Array]:
    role = "hamiltonian.gradients"
    found = _watched(problem, role, form.gradients, GRADIENTS, np.concatenate(y), t=t)
    return [found[name].data for name in ("dq", "dp")]


@np.errstate(all="ignore")
def _check_separable(problem: Problem, form: Hamiltonian, q: Array, p: Array) -> None:
    """Refuse `separable` where ∂H/∂q depends on p, or ∂H/∂p on q or t, or not linearly on p."""
    shape = np.cos(np.arange(len(q)))
    p1 = p + (float(np.max(np.abs(p))) or 1.0) * shape
    dq, _ = _gradients(problem, form, q, p)
    dq1, dp1 = _gradients(problem, form, q, p1)
    _, dp2 = _gradients(problem, form, q + 0.1 * np.max(np.abs(q)) * shape, 2.0 * p1, t=LATER)
    for block, depends, x, z in (
        ("dq", "on q and t alone", dq, dq1),
        ("dp", "on p alone, linearly", 2.0 * dp1, dp2),
    ):
        defects, largest = np.abs(x - z), np.max(np.abs([x, z]))
        if np.isfinite(largest) and np.max(defects) > AGREES * largest:
            row = int(np.argmax(defects))
            what = f"is declared separable, so that {block} depends {depends}: row {row} does not"
            role = "hamiltonian.gradients"
            raise DeclarationError(problem.name, role, what, block, row, len(q))


def _check_splitting(problem: Problem, form: Splitting, y: Array) -> None:
    other = y + 0.1 * (float(np.max(np.abs(y))) or 1.0) * np.cos(np.arange(len(y)))
    seen: dict[bytes, int] = {}
    for k in range(form.parts):
        move = _flow(problem, form, k, y)
        j = seen.setdefault(move.tobytes(), k)
        if j == k or not np.any(move):
            continue
        if np.array_equal(_flow(problem, form, j, other), _flow(problem, form, k, other)):
            what = f"moves part {k} as it moves part {j}, where parts = {form.parts}"
            raise DeclarationError(problem.name, "splitting.flow", what, "parts", k, form.parts)


def _flow(problem: Problem, form: Splitting, k: int, y: Array) -> Array:
    role = f"splitting.flow of part {k}"
    arguments = _watched(problem, role, form.flow, FLOW, y, k=k, h=STEP)
    return np.asarray(arguments["out"].data)


_FORMS: dict[str, Any] = {
    "field": _check_field,
    "action": _check_action,
    "hamiltonian": _check_hamiltonian,
    "splitting": _check_splitting,
}
_MAPS = dict.fromkeys(("act", "cayley"), ACTION) | {"bracket": BRACKET, "extent": EXTENT}
_MAPS |= dict.fromkeys(("dexpinv", "dcayinv"), TANGENT_MAP)
