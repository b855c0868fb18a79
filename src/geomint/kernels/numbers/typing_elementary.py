"""The numba half of elementary functions of our own."""

import math

from numba.extending import overload

from . import circular, exponential
from .arithmetic import lane, like, polynomial, top
from .double_double import divided, multiplied, summed
from .tangent import PARTIALS
from .typing_lanes import LANE_VALUE, LANES, insert_lane, is_plain

_OPTIONS = {"error_model": "numpy"}


def _elementary(function, one, eight):
    """Let a function be code of numbers, and other code where some are lanes."""
    # Symbols are made of names, and must differ for each function (`compile._unique` says why).
    one.__qualname__ = f"{function.__name__}_of_one"
    eight.__qualname__ = f"{function.__name__}_of_eight"

    @overload(function, strict=False, jit_options=_OPTIONS)
    def choose(*numbers):
        code = eight if LANE_VALUE in numbers else one
        return code if all(map(is_plain, numbers)) else None


def _own(function, source):
    def of_one(x):
        return source(1.0 * x)

    def of_two(x, y):
        return source(like(1.0 * x, y), like(1.0 * y, x))

    code = of_one if function.__code__.co_argcount == 1 else of_two
    _elementary(function, code, code)


def _with_library(function, source):
    library, far = getattr(math, function.__name__), circular.FAR

    def one(x):
        return source(1.0 * x) if abs(x) <= far else library(1.0 * x)

    def eight(x):
        if top(abs(x)) <= far:
            return source(x)
        for i in range(LANES):
            x = insert_lane(x, i, function(lane(x, i)))
        return x

    _elementary(function, one, eight)


def _inlined(source):
    overload(source, strict=False, jit_options={**_OPTIONS, "forceinline": True})(lambda *_: source)


for _source in (summed, multiplied, divided, polynomial):
    _inlined(_source)
for _module in (circular, exponential):
    for _name, _source in list(vars(_module).items()):
        if getattr(_source, "__module__", None) == _module.__name__ and _source not in PARTIALS:
            _inlined(_source)
            _function = getattr(_module, _name.removeprefix("of_"))
            if _function in PARTIALS:
                (_with_library if _name in ("of_sin", "of_cos", "of_tan") else _own)(
                    _function, _source
                )
