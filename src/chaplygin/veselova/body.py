"""The Veselova problem, r = 1 and any r: its parameters, and the problems that describe its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import geomint as gi

from ..inertia import GeneralInertia, Inertia, operator_of, positive_number, positive_vector
from ..manifold import Array
from ..rigid_body import warn_of_moments
from .classical import veselova_classical_problem
from .classical_multiplier import veselova_multiplier_problem
from .hamiltonized import veselova_hamiltonized_problem
from .lr import lr_problem
from .reduced import veselova_reduced_problem
from .stiefel import frame_count, stiefel_problem


@dataclass(frozen=True, init=False, eq=False)
class Veselova:
    """A rigid body in R^n about a fixed point whose angular velocity w lies in γ∧R^n.

    γ = e_1 is fixed in space and seen from the body, eq. (VC) with r = 1; at n = 3 the condition is
    (w⃗, γ⃗) = 0, eq. (classical).

    Parameters
    ----------
    a : array_like, shape (n,)
        The inertia operator 𝓘(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j, eq. (inertia_tensor); a_i > 0, n ≥ 2.
    D : float
        Only the unit of the time τ and of p̃, eqs. (CM), (mapping). With the a and D of a Chaplygin
        sphere, (γ, p̃) has the same invariant tori as the sphere, and τ is the same.

    Raises
    ------
    geomint.DomainError
        For parameters outside of these domains, naming the value.

    Examples
    --------
    >>> import chaplygin as ch
    >>> problem = ch.Veselova(a=[0.8, 1.1, 1.5]).reduced()
    >>> problem.state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6])
    array([ 0.6,  0. ,  0.8,  0.8,  1. , -0.6])
    """

    a: Array
    D: float

    def __init__(self, a: Any, D: Any = 1.0) -> None:
        vars(self).update(a=positive_vector("a", a), D=positive_number("D", D))

    @classmethod
    def from_moments(cls, moments: Any, D: Any = 1.0) -> Veselova:
        """Return the body in R³ with principal moments 𝓘_1, 𝓘_2, 𝓘_3: a_i = √(𝓘_1𝓘_2𝓘_3)⁻¹ 𝓘_i."""
        body = cls(veselova_factors(moments), D)
        warn_of_moments(moments)
        return body

    @property
    def n(self) -> int:
        """The dimension."""
        return len(self.a)

    def reduced(self) -> gi.Problem:
        """Return the reduced system on T*S^(n−1) in time t; see `veselova_reduced_problem`."""
        return veselova_reduced_problem(self.a, self.D)

    def hamiltonized(self) -> gi.Problem:
        """Return the flow on T*S^(n−1) in time τ; see `veselova_hamiltonized_problem`."""
        return veselova_hamiltonized_problem(self.a, self.D)

    def classical(self, f1: Any = 0.0) -> gi.Problem:
        """Return the body in R³ in vectors, (w⃗, γ⃗) = f₁; see `veselova_classical_problem`."""
        return veselova_classical_problem(self.a, self.D, f1)

    def multiplier(self, f1: Any = 0.0) -> gi.Problem:
        """Return the body in R³ in (γ⃗, w⃗), eq. (3.1); see `veselova_multiplier_problem`."""
        return veselova_multiplier_problem(self.a, self.D, f1)


def veselova_factors(moments: Any) -> Array:
    """Return a_i = √(𝓘_1𝓘_2𝓘_3)⁻¹ 𝓘_i, or raise `geomint.DomainError`."""
    values = gi.as_vector("moments", positive_vector("moments", moments), 3)
    root = np.sqrt(values)
    return values / root[0] / root[1] / root[2]


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

    inertia: Inertia
    r: int

    def __init__(self, inertia: Any, r: Any = 1) -> None:
        inertia = operator_of(inertia)
        vars(self).update(inertia=inertia, r=frame_count(r, inertia.n))

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
