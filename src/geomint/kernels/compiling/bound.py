"""A recorded function with what it takes: one value for Python and for all types of number."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

from ..numbers.blocks import fixed_rows
from .beside import in_turn
from .call import Call, Code
from .compiled import compiled as machine_code
from .number_types import SCALAR, NumberType
from .recorded import Recorded
from .signatures import Signature


@dataclass(frozen=True)
class Bound:
    """A recorded function and its signature: all that is needed to compile and to call it."""

    recorded: Recorded
    signature: Signature

    @property
    def in_lanes(self) -> Bound:
        """The same function for eight numbers at once, whatever calls it."""
        return replace(self, signature=self.signature.in_lanes)

    def of_type(self, number_type: NumberType) -> Bound:
        """Return the same function for a type of number, whatever calls it; its own one, if it has."""
        if self.signature.own is not None:
            return self
        return replace(self, signature=replace(self.signature, own=number_type))

    def entry(self, compiled: bool = True, number_type: NumberType = SCALAR):
        """Return what to call, or to hand to a kernel: compiled, or the function as it is.

        Raises
        ------
        DomainError, DeclarationError
            As `geomint.kernels.compiling.compiled.compiled`.
        """
        if not compiled:
            return self.recorded
        return machine_code(self.recorded, self.signature.of(number_type))

    def call(self, compiled: bool = True, number_type: NumberType = SCALAR, **values) -> Call:
        """Return the function as Python calls it, with some arguments given.

        Functions among them, and in tuples, are `Bound`.
        """

        def entries(value):
            if isinstance(value, tuple):
                return tuple(entries(member) for member in value)
            return value.entry(compiled, number_type) if isinstance(value, Bound) else value

        given: dict[str, Any] = {}
        own = []
        in_turn(
            lambda: given.update((name, entries(value)) for name, value in values.items()),
            lambda: own.append(self.entry(compiled, number_type)),
        )
        names = tuple(name for name, _ in self.signature.arguments)
        call = Call(self.recorded.function, names, own[0] if isinstance(own[0], Code) else None)
        call.set(**given)
        return call


@functools.cache
def bind(f: Recorded, signature: Signature, **rows: int) -> Bound:
    """Return a function whose blocks of those names have that many rows, as constants.

    LLVM unrolls its loops; what it takes is the same for all sizes, so steppers are compiled once.
    The same function and sizes give the same recorded function, compiled once a process, and again
    when what it reaches has changed: it reaches what the given one does.
    """
    names = [name for name, _ in signature.arguments]
    assert rows.keys() <= set(names)
    i, j, k, q, m, n, o = [*map(rows.get, names), *[None] * 7][:7]  # None: any number of rows

    def four(a, b, c, d):
        return f(fixed_rows(a, i), fixed_rows(b, j), fixed_rows(c, k), fixed_rows(d, q))

    def five(a, b, c, d, e):
        return f(
            fixed_rows(a, i),
            fixed_rows(b, j),
            fixed_rows(c, k),
            fixed_rows(d, q),
            fixed_rows(e, m),
        )

    def six(a, b, c, d, e, x):
        return f(
            fixed_rows(a, i),
            fixed_rows(b, j),
            fixed_rows(c, k),
            fixed_rows(d, q),
            fixed_rows(e, m),
            fixed_rows(x, n),
        )

    def seven(a, b, c, d, e, x, y):
        return f(
            fixed_rows(a, i),
            fixed_rows(b, j),
            fixed_rows(c, k),
            fixed_rows(d, q),
            fixed_rows(e, m),
            fixed_rows(x, n),
            fixed_rows(y, o),
        )

    function: Any = {4: four, 5: five, 6: six, 7: seven}[len(names)]
    function.__name__ = function.__qualname__ = f.function.__name__
    return Bound(Recorded(function), signature)
