"""What functions of a problem may not do, read off their code: with what to write instead.

Plain Python would do all of it, the compiler some, at some steps, for one kind of number. So that a
function is not accepted here and refused there, the rules of `geomint.field` are looked at before
either of them runs it, in all functions that are reached.
"""

import math
from collections.abc import Iterator
from dis import get_instructions
from inspect import CO_ASYNC_GENERATOR, CO_COROUTINE, CO_VARKEYWORDS
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from ..kernels.compiling.code import Path, paths_in
from ..kernels.compiling.contents import MISSING, home_of, looked_up
from ..kernels.compiling.fingerprint import COMPILER, LIBRARIES
from ..kernels.compiling.recorded import Recorded
from ..kernels.numbers.arithmetic import of_numpy
from ..kernels.numbers.tangent import PARTIALS

_LISTS = {"BUILD_LIST", "BUILD_SET", "BUILD_MAP", "BUILD_CONST_KEY_MAP", "LIST_APPEND", "MAP_ADD"}
_TO_TUPLE = {"LIST_TO_TUPLE", "INTRINSIC_LIST_TO_TUPLE"}  # of f(*x) and (*x, y), which are no lists
_RAISES = (
    "raises an exception: a function cannot end a run; outside of its domain it gives math.nan"
)
_NAMED = "namedtuple_"  # where Python keeps the constructors of named tuples, as of layouts
_KEYWORDS = "has arguments that go by keyword alone: leave out `*` and `**`"
_ASYNC = "is asynchronous: write def"
_STATEMENTS = {
    "RAISE_VARARGS": _RAISES,
    "LOAD_ASSERTION_ERROR": _RAISES.replace("raises an exception", "asserts"),
    "PUSH_EXC_INFO": "has a try or with statement: choose by gi.select(condition, x, y)",
    "YIELD_VALUE": "has a generator: write a loop",
    "IMPORT_NAME": "imports: do it outside of the function",
    "DELETE_FAST": "deletes a variable: leave it where it is",
    "STORE_GLOBAL": "writes a global variable: what it writes goes to out or work",
}
_MAKES = (
    "makes a list, dict or set: nothing is allocated; results are written row by row (out[0] = …), "
    "scratch is work"
)
_BUILTINS = {
    *("abs", "bool", "complex", "divmod", "enumerate", "float", "int", "isinstance", "len"),
    *("max", "min", "range", "round", "slice", "sum", "tuple", "zip"),
}
_OF_NUMBERS = {"math", "_operator"}
_FUNCTIONS = (FunctionType, BuiltinFunctionType, np.ufunc, type(np.dot))
_ARITHMETIC = "write arithmetic, loops over rows, and the functions of geomint"
_INSTEAD: dict[Any, str] = {
    **{getattr(math, f.__name__): f"gi.{f.__name__}" for f in PARTIALS},
    **{of_numpy(f): f"gi.{f.__name__}" for f in PARTIALS},
    pow: "gi.pow",
    np.maximum: "gi.maximum",
    math.fabs: "abs",
    np.abs: "abs",
    np.fabs: "abs",
    np.minimum: "-gi.maximum(-x, -y)",
    np.where: "gi.select(condition, x, y)",
    print: "observe=… of gi.solve, or call the function in Python",
}


class Habit(NamedTuple):
    """What a function does that it may not: in words, which of those that are reached, and where."""

    what: str
    function: FunctionType
    line: int | None


def habit_of(recorded: Recorded) -> Habit | None:
    """Return the first thing that a function, or one that it reaches, may not do; None if nothing."""
    return recorded.made(_first_habit)


def _first_habit(recorded: Recorded) -> Habit | None:
    for function in recorded.reach.functions:
        if (function.__module__ or "").startswith(_NAMED):
            continue
        code = function.__code__
        if code.co_kwonlyargcount or code.co_flags & CO_VARKEYWORDS:
            return Habit(_KEYWORDS, function, code.co_firstlineno)
        if code.co_flags & (CO_COROUTINE | CO_ASYNC_GENERATOR):
            return Habit(_ASYNC, function, code.co_firstlineno)
        for what, line in _habits(function, function.__code__):
            return Habit(what, function, line)
    return None


def _habits(function: FunctionType, code: CodeType) -> Iterator[tuple[str, int | None]]:
    for path, line in paths_in(code, set()):
        what = _of_value(*_read(function, path))
        if what:
            yield what, line
    instructions, line = list(get_instructions(code)), code.co_firstlineno
    lists = not any({i.opname, i.argrepr} & _TO_TUPLE for i in instructions)
    for instruction in instructions:
        if instruction.positions and instruction.positions.lineno:
            line = instruction.positions.lineno
        what = _STATEMENTS.get(instruction.opname)
        if what is None and lists and instruction.opname in _LISTS:
            what = _MAKES
        if what:
            yield what, line
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _habits(function, inner)


def _read(function: FunctionType, path: Path) -> tuple[str, Any]:
    """Return what a path leads to, up to the first value that is no module, and by what name."""
    steps = [*looked_up(function, path)]
    words = (word for space, word, _ in steps if isinstance(space, ModuleType))
    return ".".join([path.name, *words]), steps[-1][2] if steps else MISSING


def _of_value(name: str, value: Any) -> str | None:
    """Return what is wrong with reading such a value, if anything."""
    if isinstance(value, list | dict | set):
        kind = type(value).__name__
        return f"reads {name}, a {kind}: what it reads are numbers, tuples, numpy arrays, or params"
    if isinstance(value, MethodType):
        return f"calls {name}: {_ARITHMETIC}"
    if not isinstance(value, _FUNCTIONS):
        return None
    if value in _INSTEAD:
        return f"calls {name}: write {_INSTEAD[value]}"
    if isinstance(value, np.ufunc):  # of single numbers the compiler has them
        single = value.__name__.replace("arc", "a")
        if not hasattr(math, single):
            return None
        return f"calls {name}: write math.{single}, which takes one number at a time and is slower"
    if isinstance(value, FunctionType):
        return _of_plain_function(name, value)
    home = value.__module__ or ""
    if home.partition(".")[0] == "numpy":
        return f"calls {name}: write loops over rows"
    if home not in _OF_NUMBERS and not (home == "builtins" and value.__name__ in _BUILTINS):
        return f"calls {name}: {_ARITHMETIC}"
    return None


def _of_plain_function(name: str, function: FunctionType) -> str | None:
    home = home_of(function)
    library = home.partition(".")[0]
    if library == "numpy":
        return f"calls {name}: write loops over rows"
    if home.startswith(COMPILER) or library in LIBRARIES:
        return None
    return f"calls {name}, a plain function: record it with gi.helper"
