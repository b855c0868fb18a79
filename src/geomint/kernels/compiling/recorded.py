"""Functions recorded now and compiled when needed: ``@field``, ``@helper`` and the kernels' own.

Decorating a function imports nothing and compiles nothing. What it reaches (helpers, constants,
closure values) is fingerprinted, so that compiled code is never stale: neither that of the on-disk
cache (`geomint.kernels.compiling.cache`), nor that of this process after a change.
"""

from __future__ import annotations

import functools
import types
from collections.abc import Callable
from typing import Any

from ...errors import DeclarationError, quoted
from .contents import Wrapped
from .fingerprint import Reach
from .sending import Sendable


class Recorded(Sendable, Wrapped):
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
            name = str(getattr(function, "__name__", type(function).__name__))
            what = f"is {quoted(function)}: expected a Python function written with def"
            raise DeclarationError(None, name, what)
        functools.update_wrapper(self, function)
        self.function = function
        self.inline = inline
        self._reach: Reach | None = None
        self._made: dict[str, tuple[str, Any]] = {}

    def __call__(self, *args, **named) -> Any:
        return self.function(*args, **named)

    __eq__ = object.__eq__  # what it reaches may change
    __hash__ = object.__hash__

    def __copy__(self) -> Recorded:
        return self  # as functions are

    def __deepcopy__(self, memo: dict[int, Any]) -> Recorded:
        return self

    def __repr__(self) -> str:
        return f"<recorded {self.function.__module__}.{self.function.__qualname__}>"

    @property
    def reach(self) -> Reach:
        """What the function reaches: looked up anew if any of it has changed."""
        reach = self._reach
        if reach is None or not reach.holds():
            self._reach = reach = Reach(self)
        return reach

    @property
    def fingerprint(self) -> str:
        """A hash of the function's code and of everything it reaches, as it is now."""
        return self.reach.fingerprint

    def made(self, make: Callable[[Recorded], Any]):
        """Return what `make` makes of the function, made anew if what it reaches has changed."""
        now = self.fingerprint
        before, found = self._made.get(make.__name__, ("", None))
        if before != now:
            found = make(self)
            self._made[make.__name__] = (now, found)
        return found


def field(function: Callable[..., Any]) -> Recorded:
    """Record ``f(params, t, y, out, work)``, which writes dy/dt into `out`.

    Parameters
    ----------
    function : callable
        `params` is the block of parameters (always float64), `t` the time, `y` the state,
        `out` receives the derivative row by row, `work` is scratch of the size that the problem
        states. Rows are counted from 0, never from the end; all rows of `out` must be written, and
        neither `out` nor `work` holds anything before. Numbers are float64, or eight of them at once
        (a lane value), so write loops and ``+ - * /``; functions and choices are `geomint.sqrt`,
        `geomint.exp`, `geomint.log`, `geomint.pow`, `geomint.sin`, `geomint.cos`, `geomint.tan`,
        `geomint.atan2`, `geomint.tanh`, `geomint.maximum` and `geomint.select`, which take both. It may
        read global numbers, arrays and modules: compiled code is made anew when a run finds them
        changed.

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
    """Record a function that fields call; it takes and returns numbers and blocks.

    Functions that numba has compiled by itself cannot be called from fields.
    """
    return Recorded(function)


def inlined(function: Callable[..., Any]) -> Recorded:
    """Record a helper that LLVM inlines into callers, where constants of theirs unroll its loops."""
    return Recorded(function, inline=True)


def named_as(function: Any, f: Recorded) -> Recorded:
    """Record a function under the name of another one: what "compiling …" says."""
    function.__name__ = f.function.__name__
    return Recorded(function)
