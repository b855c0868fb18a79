"""A field's source, run once on another package's symbols: what it would compute, as they see it.

Sources of fields take numbers of any kind (`geomint.kernels.numbers.arithmetic`); here these are
expressions of heyoka or tracers of JAX.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partialmethod
from typing import Any

import numpy as np

from ...errors import FormError
from ...kernels.numbers.blocks import Block
from ...problems.problem import Problem

__all__ = ["Algebra", "traced_field"]


@dataclass(frozen=True)
class Algebra:
    """What a package computes with its symbols, beside ``+ - * /``.

    Attributes
    ----------
    functions : module
        With ``sin``, ``cos``, ``sqrt`` and ``log``.
    less, less_equal : callable
        Conditions on two symbols.
    select : callable
        ``select(condition, x, y)``.
    """

    functions: Any
    less: Callable[[Any, Any], Any]
    less_equal: Callable[[Any, Any], Any]
    select: Callable[[Any, Any, Any], Any]

    def _of(self, name: str, x: Traced) -> Traced:
        return Traced(getattr(self.functions, name)(x.symbol), self)

    sin, cos = partialmethod(_of, "sin"), partialmethod(_of, "cos")
    sqrt, log = partialmethod(_of, "sqrt"), partialmethod(_of, "log")


class Traced:
    """A number of a package's kind, in the protocol of `geomint.kernels.numbers.arithmetic`."""

    __slots__ = ("context", "symbol")
    __array_ufunc__ = None  # arrays leave operators to this class
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, symbol: Any, context: Algebra) -> None:
        self.symbol, self.context = symbol, context

    def _by(self, symbol: Any) -> Traced:
        return Traced(symbol, self.context)

    def __add__(self, other: Any) -> Traced:
        return self._by(self.symbol + _symbol(other))

    def __radd__(self, other: Any) -> Traced:
        return self._by(_symbol(other) + self.symbol)

    def __sub__(self, other: Any) -> Traced:
        return self._by(self.symbol - _symbol(other))

    def __rsub__(self, other: Any) -> Traced:
        return self._by(_symbol(other) - self.symbol)

    def __mul__(self, other: Any) -> Traced:
        return self._by(self.symbol * _symbol(other))

    def __rmul__(self, other: Any) -> Traced:
        return self._by(_symbol(other) * self.symbol)

    def __truediv__(self, other: Any) -> Traced:
        return self._by(self.symbol / _symbol(other))

    def __rtruediv__(self, other: Any) -> Traced:
        return self._by(_symbol(other) / self.symbol)

    def __pow__(self, power: Any) -> Traced:
        return self._by(self.symbol ** _symbol(power))

    def __neg__(self) -> Traced:
        return self._by(-self.symbol)

    def __pos__(self) -> Traced:
        return self

    def __abs__(self) -> Traced:
        return self.chosen(self < 0.0, -self, self)

    def __lt__(self, other: Any) -> Any:
        return self.context.less(self.symbol, _symbol(other))

    def __le__(self, other: Any) -> Any:
        return self.context.less_equal(self.symbol, _symbol(other))

    def __gt__(self, other: Any) -> Any:
        return self.context.less(_symbol(other), self.symbol)

    def __ge__(self, other: Any) -> Any:
        return self.context.less_equal(_symbol(other), self.symbol)

    def __bool__(self) -> bool:
        raise TypeError("a number of the state decides what is computed")

    def fused(self, x: Any, y: Any, z: Any) -> Any:
        return x * y + z

    def chosen(self, condition: Any, x: Any, y: Any) -> Traced:
        return self._by(self.context.select(condition, _symbol(x), _symbol(y)))

    def of(self, value: Any) -> Any:
        return value


def _symbol(number: Any) -> Any:
    return number.symbol if isinstance(number, Traced) else float(number)


def traced_field(problem: Problem, algebra: Algebra, time: Any, state: Sequence[Any]) -> list[Any]:
    """Return dy/dt in symbols of time and state.

    Raises
    ------
    FormError
        For a problem without a field, or one that does more with its numbers than formulas do.
    """
    if problem.field is None:
        raise FormError("the problem has no field")
    y = Block(np.array([Traced(symbol, algebra) for symbol in state], dtype=object))
    out, work = (Block(np.empty(rows, dtype=object)) for rows in (len(y), problem.work))
    try:
        problem.field(Block(problem.params), Traced(time, algebra), y, out, work)
    except Exception as error:  # whatever the source makes of such numbers
        what = f"its field is no formula: {type(error).__name__}: {error}"
        raise FormError(what) from error
    return [_symbol(rate) for rate in out.data]
