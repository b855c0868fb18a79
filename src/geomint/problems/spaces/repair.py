"""States made admissible: what is left as it is, what is repaired with a warning, what is refused.

A component that a user names (``gamma=[1, 2, 3]``) may be far from the space: it is projected, with a
warning that says by how much. A flat state that was made elsewhere is only repaired: a defect up to
`SILENT` is left as it is, bit for bit, one up to `REPAIRED` is projected with a warning, and a
larger one is an error. Defects of vectors are relative to their length: any scale is served.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ...arguments import SHORT, Array
from ...errors import DomainError, GeomintWarning, StateWarning, tell

__all__ = ["PARALLEL", "REPAIRED", "SILENT", "length", "repaired", "warn"]

SILENT = 1e-13
REPAIRED = 1e-6
PARALLEL = 1e-8  # a vector whose tangent part is a smaller fraction of it is mostly round-off


def warn(
    text: str,
    quantity: str = "",
    size: float | None = None,
    kind: type[GeomintWarning] = StateWarning,
) -> None:
    """Warn of a state at the line of the user: which piece of it is off, and by how much."""
    tell(kind(text, quantity, size))


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
    warn(f"{said} of the state is {defect:.3g}: projected to 0", name, defect)
    return np.asarray(mended())
