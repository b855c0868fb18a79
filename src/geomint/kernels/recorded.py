"""Functions recorded now and compiled when needed: ``@field``, ``@helper`` and the kernels' own.

Decorating a function imports nothing and compiles nothing. What it reaches (helpers, constants,
closure values) is fingerprinted, so that the on-disk cache of compiled code never serves a stale
version (`geomint.kernels.cache`).
"""

from __future__ import annotations

import dis
import functools
import hashlib
import types
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

__all__ = ["Recorded", "field", "fingerprint", "helper", "inlined", "observable"]


class Recorded:
    """A Python function that compiled code can call and Python can run as it is.

    Attributes
    ----------
    function : callable
        The plain Python function.
    """

    def __init__(self, function: Callable[..., Any], inline: bool = False) -> None:
        if isinstance(function, Recorded):
            function = function.function
        if not isinstance(function, types.FunctionType):
            raise TypeError(f"expected a Python function written with def, got {function!r}")
        self.function = function
        self.inline = inline
        functools.update_wrapper(self, function)

    def __call__(self, *args: Any) -> Any:
        return self.function(*args)

    def __repr__(self) -> str:
        return f"<recorded {self.function.__module__}.{self.function.__qualname__}>"

    @functools.cached_property
    def fingerprint(self) -> str:
        """A hash of the function's code and of everything it reaches."""
        return fingerprint(self.function)

    @functools.cached_property
    def dispatcher(self) -> Any:
        """The numba dispatcher, made at first use."""
        from .compile import make_dispatcher

        return make_dispatcher(self)


def field(function: Callable[..., Any]) -> Recorded:
    """Record ``f(params, t, y, out, work)``, which writes dy/dt into `out`.

    Parameters
    ----------
    function : callable
        `params` is the block of parameters (always float64), `t` the time, `y` the state,
        `out` receives the derivative row by row, `work` is scratch of the size that the problem
        states. Rows are counted from 0, never from the end; all rows of `out` must be written, and
        neither `out` nor `work` holds anything before. Numbers are float64, or eight of them at once
        (a lane value), so write loops and ``+ - * /``; for square roots, sines and choices use
        `geomint.sqrt`, `geomint.sin`, `geomint.cos` and `geomint.select`, which take both.

    Examples
    --------
    >>> import geomint as gi
    >>> @gi.field
    ... def pendulum(params, t, y, out, work):
    ...     out[0] = y[1]
    ...     out[1] = -params[0] * gi.sin(y[0])
    """
    return Recorded(function)


def observable(function: Callable[..., Any]) -> Recorded:
    """Record ``f(params, t, y, work) -> number``: an invariant, a constraint, a clock, a diagnostic.

    The rules are those of `field`; what it returns is a number of the kind of ``y[0]``.
    """
    return Recorded(function)


def helper(function: Callable[..., Any]) -> Recorded:
    """Record a function that fields call; it takes and returns numbers and blocks."""
    return Recorded(function)


def inlined(function: Callable[..., Any]) -> Recorded:
    """Record a helper that LLVM inlines into callers, where constants of theirs unroll its loops."""
    return Recorded(function, inline=True)


def fingerprint(function: Callable[..., Any]) -> str:
    """Return a hash of a function's bytecode, constants, defaults, and all that these reach.

    Python functions, recorded functions and numba dispatchers found through globals, closures
    and attributes of modules count with their own code; other values count with their content.
    """
    digest = hashlib.sha256()
    for piece in _pieces(function, set()):
        digest.update(piece)
        digest.update(b"\0")
    return digest.hexdigest()[:24]


def _pieces(value: Any, seen: set[int]) -> Iterator[bytes]:
    value = getattr(value, "py_func", None) or getattr(value, "function", value)
    if isinstance(value, types.FunctionType):
        if id(value) not in seen:
            seen.add(id(value))
            yield from _function_pieces(value, seen)
    elif isinstance(value, types.ModuleType):
        yield value.__name__.encode()
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype}{value.shape}".encode()
        yield value.tobytes()
    elif isinstance(value, tuple | list):
        for item in value:
            yield from _pieces(item, seen)
    elif callable(value):
        yield f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', '')}".encode()
    else:
        yield repr(value).encode()


def _function_pieces(function: types.FunctionType, seen: set[int]) -> Iterator[bytes]:
    code = function.__code__
    yield str(function.__module__).encode()  # which the cached code imports
    yield from _code_pieces(code)
    keyword_defaults = sorted((function.__kwdefaults__ or {}).items())
    yield from _pieces((function.__defaults__ or (), keyword_defaults), seen)
    known = dict(function.__globals__)
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        known[name] = cell.cell_contents
        yield from _pieces(cell.cell_contents, seen)
    for path in sorted(set(_dotted_names(code))):
        if path[0] not in known:  # a builtin, or a local variable of the function
            continue
        target = known[path[0]]
        for attribute in path[1:]:
            if not isinstance(target, types.ModuleType):
                break
            target = getattr(target, attribute, None)
        yield ".".join(path).encode()
        yield from _pieces(target, seen)


def _code_pieces(code: types.CodeType) -> Iterator[bytes]:
    yield code.co_code
    yield repr((code.co_names, code.co_varnames, code.co_freevars)).encode()
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _code_pieces(constant)
        else:
            yield repr(constant).encode()


def _dotted_names(code: types.CodeType) -> Iterator[tuple[str, ...]]:
    """Yield what code and the functions in it refer to: ``("helper",)``, ``("module", "helper")``."""
    path: tuple[str, ...] = ()
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("LOAD_ATTR", "LOAD_METHOD") and path:
            path = (*path, instruction.argval)
            continue
        if path:
            yield path
        path = (instruction.argval,) if instruction.opname in ("LOAD_GLOBAL", "LOAD_DEREF") else ()
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _dotted_names(constant)
