"""The numba half of elementary functions of our own."""

import math
from collections.abc import Callable
from typing import Any

from numba import njit
from numba.extending import overload

from . import arithmetic, circular, exponential
from .arithmetic import like, top
from .circular import FAR
from .typing_lanes import LANE_VALUE, LANES, extract_lane, insert_lane, is_plain

_OPTIONS = {"error_model": "numpy"}


def _named(function, of: Callable[..., Any], what: str) -> Any:
    # Symbols are made of names, and must differ for each function (`compile._unique` says why).
    function.__qualname__ = f"{of.__name__}_of_{what}"
    return function


def _of_numbers(function, compiled) -> None:
    @overload(function, strict=False, jit_options=_OPTIONS)
    def choose(*numbers):
        return compiled if all(map(is_plain, numbers)) else None

    _named(compiled, function, "numbers")


def _of_one(function, source) -> None:
    _of_numbers(function, lambda x: source(1.0 * x))


def _of_two(function, source) -> None:
    _of_numbers(function, lambda x, y: source(like(1.0 * x, y), like(1.0 * y, x)))


def _with_library(function, source, library) -> None:
    def one(x):
        return source(x) if abs(x) <= FAR else library(x)

    single = njit(**_OPTIONS)(_named(one, function, "one"))

    def eight(x):
        if top(abs(x)) <= FAR:
            return source(x)
        for i in range(LANES):
            x = insert_lane(x, i, single(extract_lane(x, i)))
        return x

    lanes = njit(**_OPTIONS)(_named(eight, function, "eight"))

    @overload(function)
    def choose(x):
        if x == LANE_VALUE:
            return lambda x: lanes(x)
        return (lambda x: single(float(x))) if is_plain(x) else None


for _part in (
    arithmetic.polynomial,
    exponential.halved,
    exponential.exponential,
    exponential.logarithm,
    exponential.whole,
    exponential.of_exp,
    exponential.of_log,
    exponential.of_pow,
    exponential.of_tanh,
    circular.quarter,
    circular.rest_of,
    circular.turned,
    circular.of_sin,
    circular.of_cos,
    circular.of_tan,
    circular.of_atan2,
):
    overload(_part, strict=False, jit_options={**_OPTIONS, "forceinline": True})(
        lambda *_, part=_part: part
    )

_with_library(circular.sin, circular.of_sin, math.sin)
_with_library(circular.cos, circular.of_cos, math.cos)
_with_library(circular.tan, circular.of_tan, math.tan)
_of_one(exponential.exp, exponential.of_exp)
_of_one(exponential.log, exponential.of_log)
_of_one(exponential.tanh, exponential.of_tanh)
_of_two(exponential.pow, exponential.of_pow)
_of_two(circular.atan2, circular.of_atan2)
