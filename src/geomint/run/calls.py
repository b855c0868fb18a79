"""What `geomint.solve` does not take, and what to write instead: for users of other solvers."""

import functools
import inspect
import multiprocessing
import sys
from collections.abc import Callable, Mapping
from typing import Any, ParamSpec, TypeVar

from ..errors import ArgumentError, nearest, quoted
from ..problems.problem import Problem
from .solution import Solution

P = ParamSpec("P")
R = TypeVar("R")

_END = "t_end=…, and t0=… where the run does not begin at time 0"
_TOLERANCE = "tolerance=…; else method=geomint.Adaptive(geomint.RungeKutta('dop853'), {}=…)"
_INSTEAD = {
    **dict.fromkeys(("t_span", "tspan", "t_max", "tmax", "t_final", "t_bound"), _END),
    **{name: _TOLERANCE.format(name) for name in ("rtol", "atol", "max_step")},
    **dict.fromkeys(("first_step", "h", "h0", "dt"), "step=…"),
    **dict.fromkeys(("fun", "func", "f", "rhs"), "problem=geomint.Problem(…, field=…)"),
    **dict.fromkeys(("args", "p"), "params=… of the problem"),
    "dense_output": "dense=True, and then sol.sol(t)",
    "t": "t_eval=…, the times at which states are wanted",
}
_NEEDLESS = {
    "vectorized": "fields are compiled",
    **dict.fromkeys(("jac", "Dfun", "jac_sparsity"), "implicit steps take no Jacobian"),
}
_FUNCTION = (
    "a geomint.Problem, not a function: write it as f(params, t, y, out, work), record it with "
    "geomint.field, and give geomint.Problem(name, (('y', rows),), field=f)"
)


def explained(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function, whose wrong arguments are an `ArgumentError` that says what is right.

    It takes a problem, or problems, and where they begin; all further arguments by name.
    """
    parameters = inspect.signature(function).parameters.values()
    by_name = {p.name for p in parameters if p.kind is p.KEYWORD_ONLY}

    @functools.wraps(function)
    def asked(*args: P.args, **options: P.kwargs) -> R:
        kind = {1: Solution, 2: Problem}.get(len(args), ())
        if not (isinstance(args[0] if args else None, kind) and options.keys() <= by_name):
            _check(function, args, options)
        return function(*args, **options)

    return asked


def still(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function, in which nothing says that functions are compiled if `progress` is False."""

    @functools.wraps(function)
    def asked(*args: P.args, **options: P.kwargs) -> R:
        if getattr(multiprocessing.current_process(), "_inheriting", False):
            sys.exit(1)  # a process that begins reads a script again; whoever began it says so
        if options.get("progress") is not False:
            return function(*args, **options)
        from ..kernels.compiling.compile import listen  # imports numba

        end = listen(lambda name, seconds: None)
        try:
            return function(*args, **options)
        finally:
            end()

    return asked


def _check(function: Callable[..., Any], args: tuple[Any, ...], options: Mapping[str, Any]) -> None:
    """Raise `ArgumentError` unless a call has the arguments that the function takes."""
    name = f"geomint.{function.__name__}"
    known = list(inspect.signature(function).parameters)
    what, where = known[:2]
    several = what != "problem"
    both = "problems and states" if several else "a problem and an initial state"
    problem = args[0] if args else options.get(what)
    if callable(problem) and not isinstance(problem, Problem):
        raise ArgumentError(f"{name} takes {_FUNCTION}")
    unknown = [option for option in options if option not in known]
    if unknown:
        each = [f"no {o!r}{_instead(o, known)}" for o in unknown]
        raise ArgumentError(f"{name} has {'; '.join(each)}", tuple(unknown))
    if len(args) > 2:
        expected = "give all further ones by name, such as t_end=20.0"
        raise ArgumentError(f"{name} takes {both}, not {len(args)} arguments: {expected}")
    try:
        inspect.signature(function).bind(*args, **options)
    except TypeError as error:
        raise ArgumentError(f"{name}: {error}: expected {both}") from None
    y0 = args[1] if len(args) > 1 else options.get(where)
    if y0 is None and isinstance(problem, Problem):
        raise ArgumentError(f"{name}: missing {where}: expected {both}")
    if not (several or isinstance(problem, Problem | Solution)):
        raise ArgumentError(
            f"problem = {quoted(problem)}: expected a geomint.Problem, or a Solution to go on"
        )


def _instead(option: str, known: list[str]) -> str:
    if option in _INSTEAD:
        return f": write {_INSTEAD[option]}"
    if option in _NEEDLESS:
        return f": leave it out, {_NEEDLESS[option]}"
    return f".{nearest(option, known)}"
