"""A rubber ball: its parameters, and the problems that describe its motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import as_array

from ..ball.rolling_states import mass_and_radius
from ..inertia import (
    GeneralInertia,
    Inertia,
    operator_of,
    positive_number,
    positive_vector,
    product_factors,
    scale_of,
)
from ..literature import RUBBER
from ..rigid_body import warn_of_moments
from ..veselova.body import Veselova
from ..veselova.stiefel import stiefel_problem
from .rolling import rubber_rolling_problem


@dataclass(frozen=True, init=False, eq=False)
class RubberSphere:
    """A balanced ball in R^n that rolls on a hyperplane without slipping and without twisting.

    On T*S^(n−1) it is the Veselova problem, r = 1, with the operator I + D: its angular velocity lies
    in γ∧R^n, and its momentum relative to the contact point, k = γ∧p, is constant in space.

    Parameters
    ----------
    inertia : SpecialInertia, GeneralInertia or array_like
        I, or its diagonal entries (N,) or matrix (N, N) in the basis E_i∧E_j, i < j.
    D : float
        mρ² > 0. May be left out if `inertia` is a `SpecialInertia`, which has it.

    Raises
    ------
    geomint.DomainError
        For parameters outside of these domains, naming the value.

    Examples
    --------
    >>> import chaplygin as ch
    >>> problem = ch.RubberSphere.from_moments([1.0, 1.5, 2.0], D=1.2).reduced()
    >>> problem.state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6])
    array([ 0.6,  0. ,  0.8,  0.8,  1. , -0.6])
    """

    inertia: Inertia
    D: float
    total: GeneralInertia
    """The operator I + D."""

    def __init__(self, inertia: Any, D: Any = None) -> None:
        inertia = operator_of(inertia)
        scale = scale_of(inertia, D)
        if inertia.diagonal is not None:
            total = GeneralInertia(inertia.diagonal + scale)
        else:
            total = GeneralInertia(inertia.matrix + scale * np.eye(len(inertia.matrix)))
        vars(self).update(inertia=inertia, D=scale, total=total)

    @classmethod
    def from_moments(cls, moments: Any, D: Any) -> RubberSphere:
        """Return the ball in R³ with principal moments I_1, I_2, I_3, or that inertia tensor."""
        if as_array("moments", moments).ndim == 1:
            values = gi.as_vector("moments", positive_vector("moments", moments), 3)
            sphere = cls(GeneralInertia(values[::-1].copy()), D)
        else:
            sphere = cls(GeneralInertia.from_tensor(moments), D)
        warn_of_moments(moments)
        return sphere

    @classmethod
    def from_a(cls, a: Any, D: Any) -> RubberSphere:
        """Return the ball with (I + D)(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j, which can be Hamiltonised.

        Raises
        ------
        geomint.DomainError
            If a_i a_j D ≥ 1 for some i ≠ j: then I is not positive.
        """
        values, scale = positive_vector("a", a), positive_number("D", D)
        i, j = np.triu_indices(len(values), 1)
        products = values[i] * values[j]
        worst = int(np.argmax(products))
        if not products[worst] * scale < 1.0:
            expected = f"a[i]*a[j]*D < 1 for i ≠ j; a[{i[worst]}]*a[{j[worst]}]*D is "
            raise gi.DomainError("a", a, f"{expected}{products[worst] * scale:.17g}")
        return cls(GeneralInertia(1.0 / products - scale), scale)

    @property
    def n(self) -> int:
        """The dimension."""
        return self.inertia.n

    def body(self) -> Veselova | None:
        """Return the body of the same Veselova problem where I + D is a_i⁻¹a_j⁻¹, else None.

        At n = 2 and 3 every diagonal operator is of that form.
        """
        values = self.total.diagonal
        if values is None:
            return None
        a = product_factors(1.0 / values, self.n)
        return None if a is None else Veselova(a, self.D)

    def reduced(self) -> gi.Problem:
        """Return the system on T*S^(n−1) in time t; see `stiefel_problem`."""
        return _of_a_ball(stiefel_problem(self.total, 1))

    def hamiltonized(self) -> gi.Problem:
        """Return the flow on T*S^(n−1) in time τ; see `veselova_hamiltonized_problem`.

        Raises
        ------
        geomint.DomainError
            If I + D is not of the form a_i⁻¹a_j⁻¹ in its principal axes.
        """
        body = self.body()
        if body is None:
            expected = (
                "I + D with entries 1/(a_i a_j), as from RubberSphere.from_a; reduced() has any"
            )
            raise gi.DomainError("inertia", self.total.matrix, expected)
        return _of_a_ball(body.hamiltonized())

    def rolling(self, m: Any = None, rho: Any = None) -> gi.Problem:
        """Return the ball on SO(n) × R^(n−1) with its reactions; see `rubber_rolling_problem`.

        Parameters
        ----------
        m, rho : float
            Mass and radius; one of them will do, because mρ² = D.
        """
        mass, radius = mass_and_radius(self.D, m, rho)
        return rubber_rolling_problem(self.inertia, self.total, mass, radius)


def _of_a_ball(problem: gi.Problem) -> gi.Problem:
    """Return a problem of Veselova's with the sources of the ball before its own."""
    return replace(problem, references=(*RUBBER, *problem.references))
