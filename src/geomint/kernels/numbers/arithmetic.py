"""Elementary functions that take a number of any kind: float64, lane values, extended precision.

Fields and kernels use these where ``+ - * /`` are not enough. Compiled, they become machine code
for float64 and for lane values (`geomint.kernels.numbers.typing_lanes`); in plain Python they act
on floats, on arrays of any dtype and on mpmath numbers. All of them give the same bits for the same
float64.
"""

import ctypes
import ctypes.util
import math
import operator
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np

NAN = float("nan")  # what lies outside of a function's domain, to be found at the end of the step
SHIFT = 1.5 * 2.0**52  # adding it rounds to a whole number


def _load_libm_fma() -> Callable[[float, float, float], float] | None:
    try:
        name = ctypes.util.find_library("m")
        function = ctypes.CDLL(name).fma if name else None
    except (OSError, AttributeError):
        return None
    if function is None:
        return None
    function.restype = ctypes.c_double
    function.argtypes = [ctypes.c_double] * 3
    return function


_libm_fma = getattr(math, "fma", None) or _load_libm_fma()


def _fma_float(x: float, y: float, z: float) -> float:
    if _libm_fma is not None:
        return _libm_fma(x, y, z)
    if math.isfinite(x) and math.isfinite(y) and math.isfinite(z):
        exact = Fraction(x) * Fraction(y) + Fraction(z)
        try:
            return float(exact) or x * y + z
        except OverflowError:
            return math.inf if exact > 0 else -math.inf
    return x * y + z


_fma_array = np.frompyfunc(_fma_float, 3, 1)


def is_float64(*values) -> bool:
    """Tell whether all numbers, or arrays of them, are float64."""
    return all(
        v.dtype == np.float64
        if isinstance(v, np.ndarray)
        else isinstance(v, float | int | np.integer)
        for v in values
    )


def fma(x, y, z) -> Any:
    """Return ``x * y + z`` with one rounding (float64; other kinds of number round twice)."""
    if isinstance(x, float) and isinstance(y, float) and isinstance(z, float):
        return np.float64(_fma_float(x, y, z))
    if not is_float64(x, y, z):
        own = next((v for v in (x, y, z) if hasattr(v, "fused")), None)
        return x * y + z if own is None else own.fused(x, y, z)
    cls = next((type(v) for v in (x, y, z) if isinstance(v, np.ndarray)), np.float64)
    return np.float64(_fma_array(x, y, z)).view(cls)


def of_numpy(function: Callable[..., Any]):
    """Return numpy's elementary function of that name."""
    name = function.__name__
    return getattr(np, {"pow": "power", "atan2": "arctan2"}.get(name, name))


@np.errstate(all="ignore")
def elementwise(function: Callable[..., Any], *numbers):
    """Return a function of numbers that are not all float64, as their own kind has it by its name."""
    own = [x.context for x in numbers if hasattr(x, "context")]
    objects = any(getattr(x, "dtype", None) == np.object_ for x in numbers)
    if objects and not any(hasattr(x, "chosen") for x in numbers):
        return np.frompyfunc(function, len(numbers), 1)(*numbers)
    if own:
        found = getattr(own[0], function.__name__, None)
        return (found or own[0].power)(*numbers)  # mpmath has no pow
    return of_numpy(function)(*numbers)


@np.errstate(all="ignore")
def of_our_own(function, source: Callable[..., Any], *numbers, library: Any = None, far=0.0):
    """Return a function as its source has it for float64 and lanes; of other numbers their own.

    With a library the source is for sizes up to `far` alone.
    """
    if not is_float64(*numbers):
        return elementwise(function, *numbers)
    x, *more = (v if isinstance(v, np.ndarray) else np.float64(v) for v in numbers)
    if library is None or (abs(x) <= far).all():
        return source(x, *more)
    if isinstance(x, np.ndarray):
        return np.array([function(v) for v in x]).view(type(x))
    return np.float64(NAN if np.isinf(x) else library(x))


def sqrt(x) -> Any:
    """Square root; NaN for a negative float64."""
    if isinstance(x, float | int):
        return np.float64(math.sqrt(x)) if x >= 0 else np.float64(math.nan)
    return elementwise(sqrt, x)


def power_of_two(k):
    """Return 2^k for whole k from −1022 to 1023: float64 and lanes."""
    found = (np.asarray(k + (SHIFT + 1023.0)).view(np.int64) << 52).view(np.float64)
    return found.view(type(k)) if isinstance(k, np.ndarray) else found


def exponent(x):
    """Return k of |x| in [2^k, 2^(k+1)), and above 1024 where the sign bit is set: no subnormals."""
    found = (np.asarray(x).view(np.uint64) >> np.uint64(52)) - 1023.0
    return found.view(type(x)) if isinstance(x, np.ndarray) else found


def polynomial(x, c: tuple[float, ...]):
    """Return Σ c_k x^k of four terms or more, by two of Horner's chains beside each other."""
    square = x * x
    first, second = fma(square, c[-1], c[-3]), fma(square, c[-2], c[-4])
    for k in range(len(c) - 5, -1, -1):
        first, second = second, fma(first, square, c[k])
    return fma(first, x, second)


def maximum(x, y) -> Any:
    """Return the larger of two numbers, lane by lane; NaN where either is NaN."""
    return select(x > y, x, select(x >= x, y, x))


def plain(x) -> Any:
    """Return a number without derivatives: the value of a tangent number."""
    return x.value if hasattr(x, "slopes") else x


def slope_count(x) -> int:
    """Return how many derivatives a number carries: 0 but for tangent numbers."""
    return len(x.slopes) if hasattr(x, "slopes") else 0


def magnitude(x) -> Any:
    """Return |x|; of a tangent number the largest of its value and slopes, a number of their kind."""
    if hasattr(x, "slopes"):
        found = abs(x.value)
        for slope in x.slopes:
            found = maximum(abs(slope), found)
        return found
    return abs(x)


def select(condition, x, y) -> Any:
    """Return ``x`` where `condition` holds and ``y`` elsewhere, lane by lane."""
    own = next((v for v in (x, y) if hasattr(v, "chosen")), None)
    if own is not None:
        return own.chosen(condition, x, y)
    if isinstance(condition, np.ndarray):
        return np.where(condition, x, y).view(type(condition))
    return x if condition else y


def like(value, example) -> Any:
    """Return `value` as a number of the same kind as `example`: in every lane of a lane value."""
    if hasattr(example, "of"):
        return example.of(value)
    if isinstance(example, np.ndarray):
        return np.full(example.shape, value, dtype=example.dtype).view(type(example))
    return type(example)(value) if isinstance(example, np.floating) else value


def lane(x, index: int) -> Any:
    """Return one lane of a lane value; a plain number is its own only lane."""
    if hasattr(x, "part"):
        return x.part(lambda number: lane(number, index))
    return np.asarray(x)[index] if isinstance(x, np.ndarray) else x


def _fold(combine: Callable[[Any, Any], Any], x):
    values = list(np.asarray(x))
    while len(values) > 1:
        half = len(values) // 2
        pairs = [combine(values[i], values[i + half]) for i in range(half)]
        values = pairs + values[2 * half :]
    return values[0]


def top(x) -> Any:
    """Return the largest lane; NaN if any lane is NaN. Of a tangent number that of its value.

    A problem's function may use it to leave out what no lane needs, not to compute with: lanes may be
    those of several motions, each of which has the bits that it has alone.
    """
    x = getattr(x, "value", x)
    return _fold(maximum, x) if isinstance(x, np.ndarray) else x


def total(x) -> Any:
    """Return the sum of the lanes, added pairwise: ((0+4)+(2+6)) + ((1+5)+(3+7))."""
    return _fold(operator.add, x) if isinstance(x, np.ndarray) else x


def epsilon(x) -> float:
    """Return the relative spacing of numbers of the kind of `x`; 2⁻⁵² for float64 and lanes."""
    dtype = getattr(x, "dtype", None)
    if dtype is not None:
        if dtype != np.object_:
            return float(np.finfo(dtype).eps)
        x = np.ravel(x)[0]
    return float(getattr(getattr(x, "context", None), "eps", 2.0**-52))
