"""Recorded functions as machine code, with the errors that users are to see."""

import functools
import os
import re
from typing import Any

from ...errors import DeclarationError, SpeedWarning, tell
from .recorded import Recorded

# What numba says of numbers of which there are eight, and what to write.
_SELECT = "`if`, `and`, `or` and `not` do not take numbers of the state: gi.select(condition, x, y)"
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")  # of letters: numba has them where colorama is installed
_LONGEST = 300  # characters of what numba says
_ADVICE = (
    (r"(bool|not_)\(lanemask8", _SELECT),
    (
        r"(mul|add|sub|truediv)\(.*lanemask8",
        "a condition is no number: gi.select(condition, 1.0, 0.0)",
    ),
    (r"i?pow\(.*tangent\(", "`**` has no derivatives here: write products, or gi.pow(x, y)"),
    (r"i?pow\(lanes8", "`**` takes one number at a time: write products, or gi.pow(x, y)"),
    (r"(min|max)\(.*lanes8", "min and max take one number at a time: write gi.maximum"),
    (
        r"setitem\(array",
        "an array made in the function holds no number of the state: write to work",
    ),
    (
        r"Untyped global name '(\w+)':",
        r"reads \1: what it reads are numbers, tuples, numpy arrays, recorded functions, or params",
    ),
)


def compiled(function: Recorded, signature):
    """Return a function compiled for a signature: found, or made if it is new or reaches new values.

    Every run begins with this for each of its functions, and holds what it got.

    Raises
    ------
    DomainError
        If the function reaches what numba has compiled by itself, or objects of unknown content.
    DeclarationError
        If it cannot be compiled; numba's own error is the cause.
    """
    take_note, compile_function, numba_error = _machinery()
    try:
        found = compile_function(function, signature)
    except (numba_error, AssertionError, RecursionError) as error:
        what = f"cannot be compiled: {reason_of(error, function)}; see geomint.field"
        raise DeclarationError(None, function.function.__name__, what) from error
    if note := take_note():
        tell(SpeedWarning(note, "compiled code"))
    return found


@functools.cache
def _machinery() -> tuple[Any, Any, Any]:
    """Return what imports numba, imported when something is compiled first."""
    from .cache import take_note
    from .compile import compile_function
    from .foreign import NumbaError

    return take_note, compile_function, NumbaError


def reason_of(error: BaseException, function: Recorded) -> str:
    """Return what could not be compiled, or what to write, and where, out of a long message."""
    lines = [line.strip() for line in _COLOUR.sub("", str(error)).splitlines()]
    unknown = [line.removeprefix(">>>").strip() for line in lines if line.startswith(">>>")]
    plain = [line for line in lines if line and not line.startswith("Failed in")]
    what = f"{unknown[0]} is not known" if unknown else (plain or [repr(error)])[0]
    fits = ((re.match(form, what), text) for form, text in _ADVICE)
    advice = next((match.expand(text) for match, text in fits if match), what[:_LONGEST])
    advice = re.sub(
        r"^(\w+)\(.*tangent\(.*is not known", r"\1 takes no numbers with derivatives", advice
    )
    single = re.sub(r"^(\w+)\(.*lanes8.*is not known", r"\1 takes one number at a time", advice)
    return f"{single}{_place(lines, function)}"


def _place(lines: list[str], function: Recorded) -> str:
    """Return the first place in the functions that are reached, with the name of that function."""
    found = [re.search(r'(?: at (.*) \((\d+)\)|File "(.*)", line (\d+):)$', line) for line in lines]
    for match in filter(None, found):
        file, line = os.path.abspath(match[1] or match[3]), int(match[2] or match[4])
        inside = [f.__code__ for f in function.reach.functions if f.__code__.co_filename == file]
        above = [code for code in inside if code.co_firstlineno <= line]
        if above:
            name = max(above, key=lambda code: code.co_firstlineno).co_name
            return f" ({name}, {file}:{line})"
    return ""
