"""Arguments made canonical where they come in: numbers, counts, switches, names; or `DomainError`.

Whatever a foreign object raises when it is asked for its numbers, or for its length, ends as one.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .errors import DomainError

__all__ = [
    "MOST_NUMBERS",
    "Array",
    "Booleans",
    "Integers",
    "as_array",
    "as_vector",
    "by_name",
    "check_name",
    "finite",
    "flat",
    "number",
    "positive",
    "switch",
    "whole",
]

T = TypeVar("T")
Array = npt.NDArray[np.float64]  # everywhere
Integers = npt.NDArray[np.int64]
Booleans = npt.NDArray[np.bool_]
MOST = 2**53  # of a count: all of them are floats too, and so fit into what kernels read
MOST_NUMBERS = 10**9  # of work and results: 8 GB
SHORT = 16  # numbers that Python looks at faster than numpy
LONGEST_NAME = 100  # characters: names are keys of files, and columns of tables
_COMPLEX = (complex, np.complexfloating)
_NO_NUMBER = (str, bytes, type(None))  # of which numpy would make one


def whole(name: str, value: Any, least: int, most: int = MOST) -> int:
    """Return a whole number from `least` to `most`, or raise `DomainError`."""
    counts = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (counts and least <= value <= most):
        to = "2⁵³" if most == MOST else f"{most}"
        over = counts and value > most
        bounds = f"from {least} to {to}" if over or most != MOST else f"≥ {least}"
        raise DomainError(name, value, f"a whole number {bounds}")
    return int(value)


def switch(name: str, value: Any, expected: str = "True or False") -> bool:
    """Return a truth value, or raise `DomainError`: no other value says yes or no."""
    if not isinstance(value, bool | np.bool_):
        raise DomainError(name, value, expected)
    return bool(value)


def finite(name: str, value: Any, expected: str = "a finite number") -> float:
    """Return a finite float, or raise `DomainError`."""
    if type(value) is float and math.isfinite(value):  # most are: what follows takes 5 µs
        return value
    if not isinstance(value, bool | np.bool_):
        numbers = as_array(name, value, expected)
        if numbers.ndim == 0 and np.isfinite(numbers):
            return float(numbers)
    raise DomainError(name, value, expected)


def positive(name: str, value: Any) -> float:
    """Return a positive finite float, or raise `DomainError`."""
    expected = "a positive number"
    result = finite(name, value, expected)
    if result <= 0.0:
        raise DomainError(name, value, expected)
    return result


def number(name: str, value: Any, low: float, high: float, expected: str) -> float:
    """Return a finite float with ``low ≤ value < high``, or raise `DomainError`."""
    result = finite(name, value, expected)
    if not low <= result < high:
        raise DomainError(name, value, expected)
    return result


def as_array(name: str, value: Any, expected: str = "numbers", kind: Any = np.float64) -> Any:
    """Return numbers as a new array of float64, or complex ones, of any shape; or raise `DomainError`.

    Masked entries are refused: there is no number; and more than 10⁹ numbers, before they are copied.
    """
    if isinstance(value, np.ndarray) and value.size > MOST_NUMBERS:  # a broadcast one needs no room
        raise DomainError(name, value, f"{expected}, at most 10⁹ of them")
    if type(value) is np.ndarray and value.dtype == kind:
        return value.copy()
    if isinstance(value, np.ma.MaskedArray) and np.ma.getmaskarray(value).any():
        raise DomainError(name, value, f"{expected}, none of them masked")
    try:
        given = np.asarray(value)
        objects = list(given.flat) if given.dtype.kind == "O" else []
        is_complex = given.dtype.kind == "c" or any(isinstance(x, _COMPLEX) for x in objects)
        if is_complex and kind == np.float64:
            expected += ": real ones"
        elif given.dtype.kind in "biufcO" and not any(isinstance(x, _NO_NUMBER) for x in objects):
            return np.array(given, dtype=kind)
    except Exception:  # whatever a foreign object raises there
        raise DomainError(name, value, expected) from None
    raise DomainError(name, value, expected)


def as_vector(name: str, value: Any, rows: int, detail: str = "") -> Array:
    """Return `value` as a new finite float64 vector of length `rows`, or raise `DomainError`."""
    if type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (rows,):
        given = value.copy()
        if math.isfinite(sum(given.tolist())) if rows <= SHORT else np.isfinite(given).all():
            return given  # a sum may overflow: see below
    rows = whole("rows", rows, 0)
    expected = f"{numbers_of(rows)}{detail}"
    vector = as_array(name, value, expected).reshape(-1)
    if len(vector) != rows:
        raise DomainError(name, value, f"{expected}, got {len(vector)}")
    if not np.isfinite(vector).all():
        raise DomainError(name, value, "finite numbers")
    return vector


def numbers_of(count: int) -> str:
    """Return ``1 number``, ``2 numbers``, …."""
    return f"{count} number{'' if count == 1 else 's'}"


def file_path(name: str, value: Any, endings: Sequence[str], strict: bool = True) -> Path:
    """Return the path of a file whose name tells its format, or raise `DomainError`.

    If not `strict` the name may also have no ending, or one that begins with no letter, as ``run-0.5``.
    """
    expected = f"a name that ends in {', '.join(endings)}"
    try:
        path = Path(value)
    except TypeError:
        raise DomainError(name, value, expected) from None
    if path.suffix not in endings and (strict or path.suffix[1:2].isalpha()):
        raise DomainError(name, str(path), expected)
    return path


def flat(name: str, value: Any) -> Array:
    """Return finite numbers as a new, read-only flat array, or raise `DomainError`."""
    numbers = np.atleast_1d(as_array(name, value, "a flat sequence of numbers"))
    if numbers.ndim > 1:
        raise DomainError(name, value, "a flat sequence of numbers")
    if not np.isfinite(numbers).all():
        raise DomainError(name, value, "finite numbers")
    numbers.setflags(write=False)
    return numbers


def piece_rows(slices: Mapping[str, slice], piece: Any) -> slice:
    """Return the rows of a piece of the state by its name, or raise `DomainError`."""
    if not (isinstance(piece, str) and piece in slices):
        raise DomainError("piece", piece, f"one of {list(slices)}")
    return slices[piece]


def check_name(what: str, name: Any) -> None:
    """Raise `DomainError` unless a name can be a key of files: what is observed is saved by it."""
    good = isinstance(name, str) and 0 < len(name) <= LONGEST_NAME and name.isprintable()
    if not good or "/" in name or name != name.strip():
        expected = (
            f"a name of 1 to {LONGEST_NAME} printable characters without '/' and outer blanks"
        )
        raise DomainError(what, name, expected)


def by_name(
    what: str, wanted: Any, made: Callable[[Any], T], name_of: Callable[[T], str], expected: str
) -> dict[str, T]:
    """Return what is `made` of each of a list, or of a mapping of names to them, by names.

    Raises
    ------
    DomainError
        For what is neither, and for two of one name.
    """
    try:
        pairs = list(wanted.items() if isinstance(wanted, Mapping) else ((None, x) for x in wanted))
    except Exception:  # whatever a foreign object raises there
        raise DomainError(what, wanted, expected) from None
    chosen = {}
    for given, one in pairs:
        found = made(one)
        name = name_of(found) if given is None else given
        check_name(what, name)
        if name in chosen:
            raise DomainError(what, name, "names unlike each other: give a mapping")
        chosen[name] = found
    return chosen
