"""What functions take: the arguments of problems' functions and of steppers, by name.

numba's own signatures are made of these for each type of number.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, get_type_hints

import numpy as np

from ..numbers.blocks import Block
from .code import reads
from .number_types import NumberType
from .recorded import Recorded

Kind = Callable[[NumberType], Any]  # of an argument: its numba type for a type of number

NUMBER, GIVEN, PARAMS = attrgetter("number"), attrgetter("given"), attrgetter("params")
BLOCK, OUT, SCRATCH = attrgetter("block"), attrgetter("block"), attrgetter("block")
MEMORY, COEFFICIENTS = attrgetter("memory"), attrgetter("coefficients")
WHOLE, REAL, TIME = attrgetter("whole"), attrgetter("real"), attrgetter("time")


@dataclass(frozen=True)
class Signature:
    """What a function takes and returns, for any type of number.

    Called with a type of number it is the kind of an argument: a function of this signature.

    Attributes
    ----------
    arguments : tuple of (str, kind)
    result : kind or None
    lanes : bool
        Whether numbers are eight at once whatever calls the function, as the stages of a Gauss step.
    own : NumberType, optional
        The type of number that it has whatever calls it.
    """

    arguments: tuple[tuple[str, Kind], ...]
    result: Kind | None = None
    lanes: bool = False
    own: NumberType | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of its arguments, in order."""
        return tuple(name for name, _ in self.arguments)

    def reads(self, f: Recorded, name: str) -> bool:
        """Tell whether a function's code names that argument at all: if not, it is not read."""
        return reads(f.function.__code__, self.names.index(name))

    def of(self, number_type: NumberType, rows: tuple[tuple[str, int], ...] = ()):
        """Return numba's signature for a type of number; blocks of those names have so many rows."""
        number_type = self.own or number_type
        return _of(self, number_type.in_lanes if self.lanes else number_type, rows)

    def __call__(self, number_type: NumberType):
        from numba.core import types

        return types.FunctionType(self.of(number_type))

    def laid_out(
        self, values: Mapping[str, Any], given: Callable[..., Any], fresh: Callable[..., Any]
    ) -> dict[str, Any]:
        """Return arguments for plain Python, in order, of values by name.

        Arrays become blocks, ``given(name, array)``; instead of a block's value its number of rows
        will do, for ``fresh(name, rows)``. Numbers and blocks stay.
        """
        made = {}
        for name, kind in self.arguments:
            value = made[name] = values[name]
            if kind not in (NUMBER, WHOLE) and not isinstance(value, Block):
                made[name] = (fresh if isinstance(value, int) else given)(name, value)
        return made

    def run(self, f: Callable[..., Any], held: Callable[[Any], Any] = Block, **values: Any) -> Any:
        """Return what a function returns in plain Python, or the arrays that it writes.

        Parameters
        ----------
        held : callable
            What makes a block of numbers of an array: not of parameters, nor of a group's layout.
        **values
            See `laid_out`.
        """
        real = [name for name, kind in self.arguments if kind in (PARAMS, GIVEN)]
        taken = self.laid_out(
            values,
            lambda name, x: Block(x) if name in real else held(x),
            lambda _, rows: held(np.zeros(rows)),
        )
        result = f(*taken.values())
        written = [taken[name].data for name, kind in self.arguments if kind is OUT]
        return result if self.result else written


@dataclass(frozen=True)
class OfType:
    """The kind of an argument that has its own type of number, whatever that of the others is."""

    kind: Kind
    own: NumberType

    def __call__(self, number_type: NumberType):
        """Return its numba type."""
        return self.kind(self.own)


@dataclass(frozen=True)
class Functions:
    """The kind of an argument that is a tuple of functions."""

    signatures: tuple[Signature, ...]

    def __call__(self, number_type: NumberType):
        """Return numba's type of it."""
        from numba.core import types

        return types.Tuple([signature(number_type) for signature in self.signatures])


@functools.cache
def _of(signature: Signature, number_type: NumberType, rows: tuple[tuple[str, int], ...]):
    from numba.core import types

    with warnings.catch_warnings():
        # numba calls functions as arguments experimental every time.
        warnings.simplefilter("ignore")
        taken = {name: kind(number_type) for name, kind in signature.arguments}
        taken.update((name, taken[name].of_rows(count)) for name, count in rows)
        result = types.void if signature.result is None else signature.result(number_type)
        return result(*taken.values())


def takes(result: Kind | None = None, **arguments: Kind) -> Signature:
    """Return the signature of functions of such arguments."""
    return Signature(tuple(arguments.items()), result)


_KINDS: dict[str, Kind] = {"params": PARAMS, "layout": GIVEN, "k": WHOLE, "work": SCRATCH}
_KINDS |= dict.fromkeys("th", NUMBER) | dict.fromkeys(("out", "dq", "dp", "g", "G"), OUT)


def _named(names: str, result: Kind | None = None) -> Signature:
    """Return the signature of functions of problems: kinds follow from names, else it is a block."""
    return Signature(tuple((name, _KINDS.get(name, BLOCK)) for name in names.split()), result)


# Vector fields, generators, conditions; invariants, observables, clocks; what is evaluated at points.
FIELD = _named("params t y out work")
VALUE = _named("params t y work", NUMBER)
MAP = _named("params t x out work")
# A group acting on states; Lie brackets; maps of tangents; how far it is to where coordinates end.
ACTION = _named("layout xi y out work")
BRACKET = _named("layout x y out work")
TANGENT_MAP = _named("layout u v out work")
EXTENT = _named("layout u work", NUMBER)
# Both gradients of a Hamiltonian; constraints and their Jacobian, row after row.
GRADIENTS = _named("params t q p dq dp work")
CONSTRAINT = _named("params q g G work")
# A two-form of two vectors.
TWO_FORM = _named("params t y u v work", NUMBER)
# The increment of the flow of part k over h.
FLOW = _named("k params t h y out work")


def counted(number_type: NumberType):
    """Return the type of (status, count, iterations, residual)."""
    from numba.core import types

    whole = number_type.whole
    return types.Tuple([whole, whole, whole, number_type.real])


_ADVANCE = takes(
    counted,
    params=PARAMS,
    coefficients=COEFFICIENTS,
    fractions=GIVEN,
    memory=MEMORY,
    work=MEMORY,
    rows=WHOLE,
    t0=TIME,
    h=TIME,
    first=WHOLE,
    count=WHOLE,
    every=WHOLE,
    out=MEMORY,
    ranks=GIVEN,
)


def advance(functions: Iterable[Signature]) -> Signature:
    """Return the signature of a stepper that takes functions of the given ones."""
    taken = Functions(tuple(functions))
    return replace(_ADVANCE, arguments=(("functions", taken), *_ADVANCE.arguments))


def ADDRESSES(number_type: NumberType):  # noqa: N802 - a kind as the others
    """Return the type of functions behind their addresses."""
    from ..numbers import typing_addresses

    return typing_addresses.ADDRESSES


# A stepper of any kind, see `geomint.kernels.solve.by_address`.
STEPPED = replace(_ADVANCE, arguments=(("functions", ADDRESSES), *_ADVANCE.arguments))


_WRITTEN: dict[Any, Kind] = {int: WHOLE, float: REAL}


def of_header(recorded, **others: Kind) -> Signature:
    """Return the signature that a kernel's header says: whole numbers, float64 ones, and else blocks.

    Arguments of other kinds are given by name. Without a type of what it returns, that is nothing,
    else what a stepper returns.
    """
    code, written = recorded.function.__code__, get_type_hints(recorded.function)
    names = code.co_varnames[: code.co_argcount]
    kinds = {name: _WRITTEN.get(written.get(name), BLOCK) for name in names}
    assert others.keys() <= kinds.keys()
    result = counted if "return" in written else None
    return Signature(tuple({**kinds, **others}.items()), result)


def of_stepper(recorded, **others: Kind) -> Signature:
    """Return the signature of what drives a stepper: it takes that, and all of its up to its rows."""
    taken = dict(STEPPED.arguments)
    names = [*taken][: [*taken].index("rows") + 1]
    return of_header(recorded, advance=STEPPED, **{name: taken[name] for name in names}, **others)
