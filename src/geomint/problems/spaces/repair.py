"""States made admissible: what is left as it is, what is repaired with a warning, what is refused.

A component that a user names (``gamma=[1, 2, 3]``) may be far from the space: it is projected, with a
warning that says by how much. A flat state that was made elsewhere is only repaired: a defect up to
`SILENT` is left as it is, bit for bit, one up to `REPAIRED` is projected with a warning, and a
larger one is an error. Defects of vectors are relative to their length: any scale is served.
"""

from __future__ import annotations

import functools
import math
import sys
import warnings
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

import numpy as np

from ...arguments import SHORT, Array
from ...errors import DomainError, GeomintWarning

__all__ = ["PARALLEL", "REPAIRED", "SILENT", "length", "repaired", "warn"]

SILENT = 1e-13
REPAIRED = 1e-6
PARALLEL = 1e-8  # a vector whose tangent part is a smaller fraction of it is mostly round-off


def warn(text: str) -> None:
    """Warn at the line of the first caller outside of geomint and systems."""
    frame, level = sys._getframe(1), 2
    while frame.f_back and str(frame.f_globals.get("__name__")).partition(".")[0] in _packages():
        frame, level = frame.f_back, level + 1
    warnings.warn(text, GeomintWarning, stacklevel=level)


@functools.cache
def _packages() -> set[str]:
    """Return geomint and the packages that register systems: a user did not write their lines."""
    return {"geomint", *(p.module.split(".")[0] for p in entry_points(group="geomint.systems"))}


def length(v: Array) -> float:
    """Return |v| without overflow or underflow of its square."""
    largest = max(map(abs, v.tolist())) if len(v) <= SHORT else float(np.abs(v).max())
    if largest == 0.0 or not math.isfinite(largest):
        return largest
    scaled = v / largest
    return largest * math.sqrt(scaled.dot(scaled))


def repaired(
    name: str, value: Array, defect: float, said: str, expected: str, mended: Callable[[], Any]
) -> Array:
    """Return a component of a flat state, or what `mended` returns, or raise: by its defect.

    Parameters
    ----------
    name, expected : str
        Of the component, for the error.
    defect : float
    said : str
        What the defect is, in symbols.
    """
    if defect <= SILENT:
        return value
    if not defect <= REPAIRED:
        raise DomainError(name, value, f"{expected}; {said} is {defect:.3g}")
    warn(f"{said} of the state is {defect:.3g}: projected to 0")
    return np.asarray(mended())
