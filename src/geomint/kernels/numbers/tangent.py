"""Tangent numbers: a number and its derivatives along some directions, through the same arithmetic.

The Python half. ``x = Tangent(value, slopes)`` stands for ``value + Σ_k ε_k slopes[k]`` with
ε_j ε_k = 0, so that a function of such numbers gives its exact derivatives beside its value. Values
may be any numbers: float64, lane values, mpmath numbers, and tangent numbers again (second
derivatives). Conditions look at the values alone, and what is chosen brings its own derivatives.
`geomint.kernels.numbers.typing_tangent` makes the same sources compile for them.

A. Griewank, A. Walther, Evaluating Derivatives, SIAM 2008, chapter 3.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from ...arguments import Array
from . import arithmetic, circular, exponential
from .blocks import Block
from .lanes import LANES, Lanes


def _compared(relation: Callable[[Any, Any], Any]):
    return lambda x, y: relation(x.value, _value(y))


def _summed(combine: Callable[[Any, Any], Any]):
    def of_tangents(x, y) -> Tangent:
        value = combine(x.value, _value(y))
        slopes = _shaped(x.slopes, value)
        if isinstance(y, Tangent):
            slopes = combine(slopes, _shaped(y.slopes, value))
        return Tangent(value, slopes)

    return of_tangents


class Tangent:
    """A number and its derivatives along some directions.

    Parameters
    ----------
    value : number
        Any; of lane values shape (lanes,).
    slopes : array, shape (directions, …)
        Of the same kind of number.
    """

    __slots__ = ("slopes", "value")
    __array_ufunc__ = None  # arrays leave operators to this class
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value, slopes) -> None:
        self.value, self.slopes = value, slopes

    def __repr__(self) -> str:
        return f"Tangent({self.value!r}, {self.slopes!r})"

    __add__ = __radd__ = _summed(operator.add)

    def __neg__(self) -> Tangent:
        return Tangent(-self.value, -self.slopes)

    def __pos__(self) -> Tangent:
        return self

    __sub__ = _summed(operator.sub)

    def __rsub__(self, other) -> Tangent:
        return Tangent(other - self.value, -_shaped(self.slopes, other - self.value))

    def __mul__(self, other) -> Tangent:
        if isinstance(other, Tangent):
            slopes = _fused(self.value, other.slopes, _times(other.value, self.slopes))
            return Tangent(self.value * other.value, slopes)
        return Tangent(self.value * other, _times(other, self.slopes))

    __rmul__ = __mul__

    def __truediv__(self, other) -> Tangent:
        if isinstance(other, Tangent):
            quotient = self.value / other.value
            own = _fused(-quotient, other.slopes, self.slopes)
            return Tangent(quotient, _times(1.0 / other.value, own))
        return Tangent(self.value / other, _over(self.slopes, other))

    def __rtruediv__(self, other) -> Tangent:
        quotient = other / self.value
        return Tangent(quotient, _times(1.0 / self.value, _times(-quotient, self.slopes)))

    def __abs__(self) -> Tangent:
        return arithmetic.select(self.value < 0.0, -self, self)

    def __bool__(self) -> bool:
        return bool(self.value)

    def __int__(self) -> int:
        return int(self.value)

    __lt__, __le__ = _compared(operator.lt), _compared(operator.le)
    __gt__, __ge__ = _compared(operator.gt), _compared(operator.ge)
    __eq__, __ne__ = _compared(operator.eq), _compared(operator.ne)

    # What `geomint.kernels.numbers.arithmetic` asks of numbers that it does not know.

    @property
    def context(self) -> type[_Functions]:
        """The functions of such numbers."""
        return _Functions

    def fused(self, x, y, z) -> Tangent:
        """Return ``x * y + z``, the value with one rounding; one of them is this number."""
        value = arithmetic.fma(_value(x), _value(y), _value(z))
        slopes: Any = z.slopes if isinstance(z, Tangent) else None
        for number, other in ((y, x), (x, y)):
            if isinstance(other, Tangent):
                by = _value(number)
                slopes = (
                    _times(by, other.slopes) if slopes is None else _fused(by, other.slopes, slopes)
                )
        return Tangent(value, _shaped(slopes, value))

    def chosen(self, condition, x, y) -> Tangent:
        """Return x where the condition holds and y elsewhere; one of them is this number."""
        x, y = self.of(x), self.of(y)
        if not isinstance(condition, np.ndarray):
            return x if condition else y
        value = arithmetic.select(condition, x.value, y.value)
        if x.slopes.dtype == object:
            by = functools.partial(arithmetic.select, condition)
            return Tangent(value, _each(by, x.slopes, y.slopes))
        slopes = (_shaped(x.slopes, value), _shaped(y.slopes, value))
        return Tangent(value, np.where(condition, *slopes))

    def of(self, value) -> Tangent:
        """Return a number as one of these: a constant has no derivatives."""
        if isinstance(value, Tangent):
            return value
        return Tangent(arithmetic.like(value, self.value), 0.0 * self.slopes)

    def part(self, take: Callable[[Any], Any]) -> Tangent:
        """Return what is made of the value, and in the same way of the derivatives."""
        return Tangent(take(self.value), np.array([take(slope) for slope in self.slopes]))


def _each(function: Callable[..., Any], *slopes: Array) -> Array:
    """Return what a function makes of each slope: objects, perhaps with slopes of their own."""
    found = np.empty(len(slopes[0]), dtype=object)
    for k, given in enumerate(zip(*slopes, strict=True)):
        found[k] = function(*given)
    return found


def _fused(number, slopes: Array, more: Array) -> Array:
    """Return slopes times a number and others added, with one rounding."""
    if slopes.dtype == object:
        return _each(functools.partial(arithmetic.fma, number), slopes, more)
    of = number if isinstance(number, np.ndarray) else more[0] if more.ndim == 2 else number
    slopes, more = _shaped(slopes, of), _shaped(more, of)
    rows = zip(slopes, more, strict=True)
    return np.array([arithmetic.fma(number, slope, other) for slope, other in rows])


def _times(number, slopes: Array) -> Array:
    """Return slopes times a number; of one number times eight there are eight."""
    if slopes.dtype == object:
        return _each(functools.partial(operator.mul, number), slopes)
    return number * _shaped(slopes, number)


def _over(slopes: Array, number) -> Array:
    """Return slopes divided by a number."""
    if slopes.dtype == object:
        return _each(lambda slope: slope / number, slopes)
    return _shaped(slopes, number) / number


def _shaped(slopes: Array, value) -> Array:
    """Return slopes as those of such a value: of one number in every lane."""
    if slopes.ndim == 1 and isinstance(value, np.ndarray):
        return np.broadcast_to(slopes[:, None], (len(slopes), len(value)))
    return slopes


def _value(x):
    return x.value if isinstance(x, Tangent) else x


def _of_tanh(f, x):
    e = exponential.exp(-2.0 * abs(x))  # 1 − tanh² would lose its digits
    return (4.0 * e / ((1.0 + e) * (1.0 + e)),)


def _of_pow(f, x, y):
    base = x + 0.0 * y  # a constant gets the digits of the exponent
    by_power = arithmetic.select((x == 0.0) & (y > 0.0), 0.0, f * exponential.log(base))
    constant = (x == 0.0) & (y == 0.0)
    return y * arithmetic.select(constant, 0.0, exponential.pow(x, y - 1.0)), by_power


def _of_atan2(f, y, x):
    size = arithmetic.maximum(abs(x), abs(y))  # squares of the numbers may be too large or small
    x, y = x / size, y / size
    square = x * x + y * y
    return x / square / size, -y / square / size


# The derivatives of elementary functions by each number, of the value f and the numbers.
PARTIALS: dict[Any, Callable[..., tuple[Any, ...]]] = {
    arithmetic.sqrt: lambda f, x: (0.5 / f,),
    exponential.exp: lambda f, x: (f,),
    exponential.log: lambda f, x: (1.0 / x,),
    exponential.pow: _of_pow,
    exponential.tanh: _of_tanh,
    circular.sin: lambda f, x: (circular.cos(x),),
    circular.cos: lambda f, x: (-circular.sin(x),),
    circular.tan: lambda f, x: (1.0 + f * f,),
    circular.atan2: _of_atan2,
}


def _elementary(function, partials: Callable[..., tuple[Any, ...]]):
    def of_tangents(*numbers) -> Tangent:
        values = [_value(x) for x in numbers]
        f = function(*values)
        pairs = zip(partials(f, *values), numbers, strict=True)
        slopes = [_times(by, x.slopes) for by, x in pairs if isinstance(x, Tangent)]
        return Tangent(f, functools.reduce(operator.add, slopes))

    return staticmethod(of_tangents)


class _Functions:
    """Elementary functions of tangent numbers."""

    eps = 2.0**-52


for _function, _partials in PARTIALS.items():
    setattr(_Functions, _function.__name__, _elementary(_function, _partials))


class TangentBlock(Block):
    """A block of tangent numbers: `data` holds a value and its slopes, row after row.

    Of `width` numbers each; subclasses have it. Uncompiled they may be numbers of any kind.
    """

    __slots__ = ()
    width = 1

    def __len__(self) -> int:
        return len(self.data) // self.width

    def __getitem__(self, row: int) -> Tangent:
        numbers = super().part(row * self.width, self.width).data
        return Tangent(numbers[0], numbers[1:].copy())

    def __setitem__(self, row: int, value) -> None:
        numbers = super().part(row * self.width, self.width).data
        numbers[0] = _value(value)
        numbers[1:] = value.slopes if isinstance(value, Tangent) else 0.0

    def part(self, start: int, rows: int) -> TangentBlock:
        """Return `rows` rows from `start` on, sharing memory."""
        inner = Block(self.data).part(start * self.width, rows * self.width)
        return type(self)(inner.data)

    def as_lanes(self, start: int, rows: int) -> TangentLaneBlock:  # type: ignore[override]
        """Return ``rows * LANES`` rows from `start` on as `rows` rows of eight numbers each."""
        numbers = self.part(start, rows * LANES).data
        return TangentLaneBlock(numbers.reshape(rows, self.width, LANES))


class TangentLaneBlock(Block):
    """A block of eight tangent numbers a row: a lane value, and one for each of its slopes.

    Subclasses have the shape of a row.
    """

    __slots__ = ()

    def __getitem__(self, row: int) -> Tangent:
        numbers = super().__getitem__(row)
        return Tangent(Lanes(numbers[0]), numbers[1:].copy())

    def __setitem__(self, row: int, value) -> None:
        numbers = super().__getitem__(row)
        numbers[0] = _value(value)
        numbers[1:] = _shaped(value.slopes, numbers[0]) if isinstance(value, Tangent) else 0.0

    def as_singles(self) -> TangentBlock:
        """Return the memory as a block of single numbers."""
        return tangent_block(self.data.shape[1] - 1)(self.data.reshape(-1))

    def set_lane(self, row: int, index: int, value) -> None:
        """Store one of the numbers of a row."""
        numbers = super().__getitem__(row)
        numbers[0, index] = _value(value)
        numbers[1:, index] = value.slopes if isinstance(value, Tangent) else 0.0


@functools.cache
def tangent_block(directions: int) -> type[TangentBlock]:
    """Return the class of blocks of numbers with so many directions."""
    name = f"TangentBlock{directions}"
    return type(name, (TangentBlock,), {"__slots__": (), "width": 1 + directions})


@functools.cache
def tangent_lane_block(directions: int) -> type[TangentLaneBlock]:
    """Return the class of blocks of eight numbers a row with so many directions."""
    name = f"TangentLaneBlock{directions}"
    shape = (1 + directions, LANES)
    return type(name, (TangentLaneBlock,), {"__slots__": (), "row_shape": shape, "width": shape[0]})


def as_tangents(block, directions: int) -> TangentLaneBlock:
    """Return rows of lane values as eight numbers a row with so many directions, sharing memory.

    A value and its slopes are a row each. Compiled, the number of directions is a constant.
    """
    return tangent_lane_block(directions)(block.data.reshape(-1, 1 + directions, LANES))
