"""One call of a function, in plain Python, on blocks that watch what it does to them."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ..errors import DeclarationError
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import Signature
from ..kernels.numbers.tangent import PARTIALS
from ..kernels.numbers.watched import AccessError, Fresh, Given
from .habits import habit_of


def watched_call(
    problem: str | None, role: str, f: Recorded, signature: Signature, values: Mapping[str, Any]
) -> dict[str, Any]:
    """Call a function, and raise `DeclarationError` for what its kind may not do.

    Parameters
    ----------
    problem, role : str
        What the error names: the problem, and what the function is to it.
    values : dict
        Of `Signature.laid_out`. All rows of what is written must be.

    Returns
    -------
    dict
        The arguments, after the call. A function that divides by zero, or leaves its domain, is not
        judged by what it had not done until then: the run will report it.
    """
    arguments = signature.laid_out(values, Given, Fresh)
    if not can_take(f.function, len(arguments)):
        wanted = ", ".join(arguments)
        what = f"takes {inspect.signature(f.function)}, where ({wanted}) is wanted {_place(f)}"
        raise DeclarationError(problem, role, what)
    habit = habit_of(f)
    if habit is not None:
        raise DeclarationError(problem, role, f"{habit.what} {_at(habit.function, habit.line)}")
    try:
        with np.errstate(all="ignore"):
            result = f(*arguments.values())
    except AccessError as error:
        what = f"{error} {_place(f, error)}"
        raise DeclarationError(problem, role, what, error.name, error.index, error.size) from None
    except (ArithmeticError, ValueError):
        return arguments
    except (TypeError, NameError, AttributeError, LookupError, RecursionError) as error:
        said = _one_line(error)
        if said.startswith("No geomint attribute"):
            said += f", but {', '.join(f'gi.{function.__name__}' for function in PARTIALS)}"
        what = f"raises {type(error).__name__}: {said} {_place(f, error)}"
        raise DeclarationError(problem, role, what) from error
    if signature.result:
        real = isinstance(result, int | float | np.number | np.bool_)
        if not real or isinstance(result, np.complexfloating):
            what = f"returns {result!r}, where a number is wanted {_place(f)}"
            raise DeclarationError(problem, role, what)
    for name, block in arguments.items():
        if isinstance(block, Fresh) and name != "work" and block.unwritten is not None:
            row, returned = block.unwritten, "" if result is None else f"; it returns {result!r}"
            what = (
                f"never writes row {row} of {name}, which has {block.count}{returned} {_place(f)}"
            )
            raise DeclarationError(problem, role, what, name, row, block.size)
    return arguments


def unwatched_call(problem: str | None, f: Recorded, *arguments: Any) -> Any:
    """Call a function that fits what it declares on other numbers, such as those with derivatives.

    Raises
    ------
    DeclarationError
        Where it does something that these numbers cannot do, or that Python cannot.
    """
    try:
        return f(*arguments)
    except (TypeError, ValueError, ArithmeticError, AttributeError, LookupError) as error:
        said = str(error).replace("'Tangent'", "a number with derivatives")
        said = said.replace("Tangent", "a number with derivatives")
        said += ": write products, or gi.pow(x, y)" if "** or pow()" in said else ""
        what = f"raises {type(error).__name__}: {said} {_place(f, error)}; see geomint.field"
        raise DeclarationError(problem, f.function.__name__, what) from error


def can_take(f: Callable[..., Any], count: int) -> bool:
    """Tell whether a function can be called with that many arguments, as far as it says."""
    try:
        inspect.signature(f).bind(*[None] * count)
    except TypeError:
        return False
    except ValueError:  # one that does not say
        return True
    return True


def _place(f: Recorded, error: BaseException | None = None) -> str:
    """Return where an error came from: the function, its file, and the line there."""
    code = f.function.__code__
    line, trace = code.co_firstlineno, error.__traceback__ if error else None
    while trace is not None:
        if trace.tb_frame.f_code is code:
            line = trace.tb_lineno
        trace = trace.tb_next
    return _at(f.function, line)


def _at(function: Any, line: int | None) -> str:
    file = function.__code__.co_filename
    return f"({function.__name__}, {file if line is None else f'{file}:{line}'})"


def _one_line(error: Exception) -> str:
    """Return what an error says, and what blocks are where arithmetic of arrays was meant."""
    text = (
        str(error).replace(f"'{Fresh.__name__}'", "block").replace(f"'{Given.__name__}'", "block")
    )
    if text == str(error):
        return text
    return f"{text}; blocks (params, y, out, work) have rows, no arithmetic: write loops over rows"
