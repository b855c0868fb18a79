"""Symbols in place of numbers: what a function would compute, as they see it.

Sources of functions take numbers of any kind (`geomint.kernels.numbers.arithmetic`); here these are
expressions of heyoka, tracers of JAX, or symbols that only tell whether numbers are used for more.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import partialmethod
from types import SimpleNamespace
from typing import Any

from .tangent import PARTIALS

OWN = SimpleNamespace(**{f.__name__: f for f in PARTIALS})


@dataclass
class Algebra:
    """What a package computes with its symbols, beside ``+ - * /``.

    Attributes
    ----------
    functions : module
        With the functions of `tangent.PARTIALS`, by their names.
    less, less_equal : callable
        Conditions on two symbols.
    select : callable
        ``select(condition, x, y)``.
    """

    functions: Any
    less: Callable[[Any, Any], Any]
    less_equal: Callable[[Any, Any], Any]
    select: Callable[[Any, Any, Any], Any]

    def _of(self, name: str, *numbers) -> Traced:
        own = next(x for x in numbers if isinstance(x, Traced))
        return own._by(getattr(self.functions, name)(*map(symbol, numbers)))


for _function in PARTIALS:
    setattr(Algebra, _function.__name__, partialmethod(Algebra._of, _function.__name__))


def _both(operation: Callable[[Any, Any], Any]) -> tuple[Any, Any]:
    return (
        lambda x, y: x._by(operation(x.symbol, symbol(y))),
        lambda x, y: x._by(operation(symbol(y), x.symbol)),
    )


def _ordered(name: str) -> tuple[Any, Any]:
    return (
        lambda x, y: getattr(x.context, name)(x.symbol, symbol(y)),
        lambda x, y: getattr(x.context, name)(symbol(y), x.symbol),
    )


class Traced:
    """A number of a package's kind, in the protocol of `geomint.kernels.numbers.arithmetic`."""

    __slots__ = ("context", "symbol")
    __array_ufunc__ = None  # arrays leave operators to this class
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, symbol, context: Algebra) -> None:
        self.symbol, self.context = symbol, context

    def _by(self, symbol) -> Traced:
        return Traced(symbol, self.context)

    __add__, __radd__ = _both(operator.add)
    __sub__, __rsub__ = _both(operator.sub)
    __mul__, __rmul__ = _both(operator.mul)
    __truediv__, __rtruediv__ = _both(operator.truediv)
    __pow__, _ = _both(operator.pow)

    def __neg__(self) -> Traced:
        return self._by(-self.symbol)

    def __pos__(self) -> Traced:
        return self

    def __abs__(self) -> Traced:
        return self.chosen(self < 0.0, -self, self)

    __lt__, __gt__ = _ordered("less")
    __le__, __ge__ = _ordered("less_equal")

    def _decide(self, *_) -> bool:
        raise TypeError("a number of the state decides what is computed")

    __bool__ = __eq__ = __ne__ = _decide

    def fused(self, x, y, z):
        return x * y + z

    def chosen(self, condition, x, y) -> Traced:
        return self._by(self.context.select(condition, symbol(x), symbol(y)))

    def of(self, value):
        return value


def symbol(number):
    """Return the symbol of a number, or its value."""
    return number.symbol if isinstance(number, Traced) else float(number)


class _Symbol:
    """Any number: what is computed with it is any number, too."""

    def _same(self, *_) -> _Symbol:
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __pow__ = __neg__ = _same
    __truediv__ = __rtruediv__ = less = select = _same
    __bool__ = Traced._decide


for _function in PARTIALS:
    setattr(_Symbol, _function.__name__, _Symbol._same)
_ANY = _Symbol()
ANYTHING = Traced(_ANY, Algebra(_ANY, _ANY.less, _ANY.less, _ANY.select))
