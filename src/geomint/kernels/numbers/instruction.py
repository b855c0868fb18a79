"""What functions of rows and numbers are in compiled code: a few machine instructions."""

from collections.abc import Callable
from typing import Any

from numba.core import types
from numba.core.typing.templates import AbstractTemplate, infer, infer_global
from numba.extending import overload

from ..numba_inside import make_intrinsic_template


def typed(function: Callable[..., Any]):
    """Register what gives the signature of `function` for types of arguments, or None."""

    def register(signature_of: Callable[..., Any]) -> Callable[..., Any]:
        @infer_global(function)
        class Template(AbstractTemplate):
            def generic(self, args, kws):
                return signature_of(*args)

        return signature_of

    return register


def overloaded(
    function: Callable[..., Any], compiled, word: str, fits: Callable[..., bool]
) -> None:
    """Let a function be another one of arguments that fit; `word` says of what."""
    # Symbols are made of it, and must differ (`compile._unique` says why).
    compiled.__qualname__ = f"{function.__name__}_of_{word}"

    @overload(function, strict=False)
    def choose(*numbers):
        return compiled if fits(*numbers) else None


def instruction(function: Callable[..., Any], prefer_literal: bool = False):
    """Register a typing function as what `function` is in compiled code.

    It is written as for `numba.extending.intrinsic`, and may return None for types that are not its
    own. An `overload` with ``inline="always"`` that calls an intrinsic gives the same code, but numba
    compiles it anew for every call: a fifth of the time that kernels took to compile.
    """

    def register(define: Callable[..., Any]) -> Callable[..., Any]:
        template = make_intrinsic_template(
            function, define, function.__name__, prefer_literal=prefer_literal
        )
        infer(template)
        infer_global(function, types.Function(template))
        return define

    return register
