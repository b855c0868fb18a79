"""What functions take: the arguments of problems' functions and of steppers, by name.

numba's own signatures are made of these for each type of number.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, get_type_hints

from .number_types import NumberType

Kind = Callable[[NumberType], Any]  # of an argument: its numba type for a type of number

NUMBER, BLOCK, GIVEN = attrgetter("number"), attrgetter("block"), attrgetter("given")
PARAMS = attrgetter("params")
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
    def in_lanes(self) -> Signature:
        """The same for eight numbers at once."""
        return replace(self, lanes=True)

    def of(self, number_type: NumberType):
        """Return numba's signature for a type of number."""
        number_type = self.own or number_type
        return _of(self, number_type.in_lanes if self.lanes else number_type)

    def __call__(self, number_type: NumberType):
        from numba.core import types

        return types.FunctionType(self.of(number_type))


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
def _of(signature: Signature, number_type: NumberType):
    from numba.core import types

    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore"
        )  # numba calls functions as arguments experimental every time
        result = types.void if signature.result is None else signature.result(number_type)
        return result(*(kind(number_type) for _, kind in signature.arguments))


def takes(result: Kind | None = None, **arguments: Kind) -> Signature:
    """Return the signature of functions of such arguments."""
    return Signature(tuple(arguments.items()), result)


# Vector fields; invariants, observables, clocks; generators; a group acting, or a Lie bracket.
FIELD = takes(params=PARAMS, t=NUMBER, y=BLOCK, out=BLOCK, work=BLOCK)
VALUE = takes(NUMBER, params=PARAMS, t=NUMBER, y=BLOCK, work=BLOCK)
GENERATOR = takes(params=PARAMS, t=NUMBER, y=BLOCK, xi=BLOCK, work=BLOCK)
ACTION = takes(layout=GIVEN, x=BLOCK, y=BLOCK, out=BLOCK, work=BLOCK)
# Both gradients of a Hamiltonian; constraints and their Jacobian, row after row.
GRADIENTS = takes(params=PARAMS, t=NUMBER, q=BLOCK, p=BLOCK, dq=BLOCK, dp=BLOCK, work=BLOCK)
CONSTRAINT = takes(params=PARAMS, q=BLOCK, g=BLOCK, G=BLOCK, work=BLOCK)
# A two-form of two vectors.
TWO_FORM = takes(NUMBER, params=PARAMS, t=NUMBER, y=BLOCK, u=BLOCK, v=BLOCK, work=BLOCK)
# The increment of the flow of part k over h.
FLOW = takes(k=WHOLE, params=PARAMS, t=NUMBER, h=NUMBER, y=BLOCK, out=BLOCK, work=BLOCK)


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
