"""The Veselova problem for any r: its parameters, and the problems that describe its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from ..inertia import GeneralInertia, SpecialInertia, positive_vector
from .lr import lr_problem
from .stiefel import frame_count, stiefel_problem

__all__ = ["VeselovaLR"]


@dataclass(frozen=True, init=False, eq=False)
class VeselovaLR:
    """A rigid body in R^n about a fixed point whose angular velocity is bound in space, eq. (VC).

    g w gᵀ lies in span{E_i∧E_j, i ≤ r}: a nonholonomic LR system. r = 1 is the Veselova problem, on
    T*S^(n−1) after reduction; r = n − 1 leaves the body free.

    Parameters
    ----------
    inertia : SpecialInertia, GeneralInertia or array_like
        𝓘, or its diagonal entries (N,) or matrix (N, N) in the basis E_i∧E_j, i < j.
    r : int
        1 ≤ r ≤ n − 1.

    Raises
    ------
    geomint.DomainError
        For parameters outside of these domains, naming the value.

    Examples
    --------
    >>> import chaplygin as ch
    >>> body = ch.VeselovaLR.from_a([0.7, 0.9, 1.2, 1.5], r=2)
    >>> [problem.rows for problem in (body.lr(), body.stiefel())]
    [22, 16]
    """

    inertia: SpecialInertia | GeneralInertia
    r: int

    def __init__(self, inertia: Any, r: Any = 1) -> None:
        if not isinstance(inertia, SpecialInertia | GeneralInertia):
            inertia = GeneralInertia(inertia)
        object.__setattr__(self, "inertia", inertia)
        object.__setattr__(self, "r", frame_count(r, inertia.n))

    @classmethod
    def from_a(cls, a: Any, r: Any = 1) -> VeselovaLR:
        """Return the body with 𝓘(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j, eq. (inertia_tensor)."""
        values = positive_vector("a", a)
        i, j = np.triu_indices(len(values), 1)
        return cls(GeneralInertia(1.0 / values[i] / values[j]), r)

    @property
    def n(self) -> int:
        """The dimension."""
        return self.inertia.n

    def lr(self) -> gi.Problem:
        """Return the system on SO(n) with its multipliers; see `lr_problem`."""
        return lr_problem(self.inertia, self.r)

    def stiefel(self) -> gi.Problem:
        """Return the system reduced to T*V(n, r); see `stiefel_problem`."""
        return stiefel_problem(self.inertia, self.r)
