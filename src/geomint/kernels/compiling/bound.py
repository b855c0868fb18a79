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
from .recorded import Recorded, named_as
from .signatures import Signature


@dataclass(frozen=True)
class Bound:
    """A recorded function and its signature: all that is needed to compile and to call it.

    Of some blocks it may know how many `rows` they have, as constants: LLVM unrolls its loops. What it
    takes is the same for all sizes, so that steppers are compiled once.
    """

    recorded: Recorded
    signature: Signature
    rows: tuple[tuple[str, int], ...] = ()

    @property
    def in_lanes(self) -> Bound:
        """The same function for eight numbers at once, whatever calls it."""
        return replace(self, signature=replace(self.signature, lanes=True))

    @property
    def as_helper(self) -> Recorded:
        """The function for code that it is compiled into: rows are constants there too."""
        return _as_helper(self) if self.rows else self.recorded

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
        return machine_code(self.recorded, self.signature.of(number_type, self.rows))

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
        call = Call(
            self.recorded.function,
            self.signature.names,
            own[0] if isinstance(own[0], Code) else None,
        )
        call.set(**given)
        return call


@functools.cache
def _as_helper(bound: Bound) -> Recorded:
    names, rows = bound.signature.names, dict(bound.rows)
    taken = (f"fixed_rows({name}, {rows[name]})" if name in rows else name for name in names)
    source = f"def made({', '.join(names)}): return f({', '.join(taken)})"
    return written(source, bound.recorded, fixed_rows=fixed_rows)


def written(source: str, f: Recorded, **names: Any) -> Recorded:
    """Return the function ``made`` of a source that knows `f` and `names`; it is called as `f` is."""
    space = {"__name__": __name__, **names}
    exec(f"def make(f):\n    {source}\n    return made", space)
    return named_as(space["make"](f), f)
