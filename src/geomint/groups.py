"""Matrix groups acting on states, ready for `geomint.GroupAction`."""

from __future__ import annotations

import numpy as np

from .errors import DomainError, nearest
from .forms import Group
from .kernels.so3 import so3_act, so3_bracket
from .kernels.so_n import ADJOINT, FRAME, VECTOR, so_n_act, so_n_bracket, so_n_work

__all__ = ["so3", "so_n"]

_CODES = {"vector": VECTOR, "adjoint": ADJOINT, "frame": FRAME}


def so3(vectors: int) -> Group:
    """SO(3) turning each of several 3-vectors; the algebra is R³ with the cross product."""
    if vectors < 1:
        raise DomainError("vectors", vectors, "a number ≥ 1")
    return Group("SO(3)", 3, np.array([float(vectors)]), so3_act, so3_bracket, 0)


def so_n(n: int, *pieces: str) -> Group:
    """SO(n) acting on a state made of pieces.

    Parameters
    ----------
    n : int
        At least 2.
    *pieces : str
        In the order of the state: ``"vector"`` (v ↦ E v), ``"adjoint"`` (X ↦ E X Eᵀ, X skew, as the
        flat upper triangle), ``"frame"`` (g ↦ g Eᵀ, an n×n matrix row after row).
    """
    if n < 2:
        raise DomainError("n", n, "a dimension ≥ 2")
    for piece in pieces:
        if piece not in _CODES:
            raise DomainError("pieces", piece, f"one of {list(_CODES)}.{nearest(piece, _CODES)}")
    layout = np.array([float(n), *(float(_CODES[p]) for p in pieces)])
    return Group(f"SO({n})", n * (n - 1) // 2, layout, so_n_act, so_n_bracket, so_n_work(n))
