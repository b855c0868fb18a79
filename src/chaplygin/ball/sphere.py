"""A Chaplygin sphere: its parameters, and the problems that describe its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import geomint as gi
from geomint.arguments import as_array

from ..inertia import (
    GeneralInertia,
    Inertia,
    SpecialInertia,
    operator_of,
    positive_number,
    scale_of,
)
from ..rigid_body import warn_of_mass_tensor, warn_of_moments
from .classical import classical_problem
from .contact import contact_problem
from .hamiltonized import hamiltonized_problem
from .momentum import ball_problem, cotangent_problem
from .poisson import poisson_problem
from .reduced import reduced_problem
from .rolling import rolling_problem
from .rolling_states import mass_and_radius


@dataclass(frozen=True, init=False, eq=False)
class ChaplyginSphere:
    """A balanced ball in R^n that rolls without slipping on a hyperplane.

    Parameters
    ----------
    a : array_like, shape (n,)
        The special inertia operator I(E_i∧E_j) = a_i a_j D/(D − a_i a_j) E_i∧E_j, eq. (operator);
        a_i > 0 and a_i a_j < D for i ≠ j.
    D : float
        mρ² > 0. May be left out if `inertia` is a `SpecialInertia`, which has it.
    inertia : SpecialInertia, GeneralInertia, or array_like
        Instead of `a`: an operator, its diagonal entries (N,) or its matrix (N, N) in the basis
        E_i∧E_j, i < j. Where it is a special one by its shape (diagonal and n ≤ 3, or a multiple of
        the identity) it is taken as such.

    Raises
    ------
    geomint.DomainError
        For parameters outside of these domains, naming the value.

    Examples
    --------
    >>> import chaplygin as ch
    >>> sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    >>> problem = sphere.reduced()
    >>> problem.state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6])
    array([ 0.6,  0. ,  0.8,  0.8,  1. , -0.6])
    """

    inertia: Inertia
    D: float

    def __init__(self, a: Any = None, D: Any = None, inertia: Any = None) -> None:
        if (a is None) == (inertia is None):
            raise gi.DomainError("a", a, "either a or inertia")
        if D is None and not isinstance(inertia, SpecialInertia):
            raise gi.DomainError("D", D, "a number > 0")
        if inertia is None:
            inertia = SpecialInertia(a, positive_number("D", D))
        operator = operator_of(inertia)
        scale = scale_of(operator, D)
        if isinstance(operator, GeneralInertia):
            operator = operator.special(scale) or operator
        vars(self).update(inertia=operator, D=scale)

    @classmethod
    def from_tensor(cls, J: Any, m: Any, rho: Any) -> ChaplyginSphere:
        """Return the sphere of mass m and radius ρ with mass tensor J: Iω = Jω + ωJ, D = mρ².

        Parameters
        ----------
        J : array_like, shape (n,) or (n, n)
            Principal values, or symmetric. At n = 3 the moments of inertia are then J_2 + J_3,
            J_3 + J_1, J_1 + J_2; for these use `from_moments`.
        m, rho : float

        Warns
        -----
        geomint.GeomintWarning
            If no rigid body has such a mass tensor; see `chaplygin.rigid_body`.
        """
        sphere = cls(inertia=GeneralInertia.from_mass_tensor(J), D=_scale(m, rho))
        warn_of_mass_tensor(J)
        return sphere

    @classmethod
    def from_moments(cls, moments: Any, m: Any, rho: Any) -> ChaplyginSphere:
        """Return the sphere in R³ of mass m and radius ρ, D = mρ².

        Parameters
        ----------
        moments : array_like, shape (3,) or (3, 3)
            The principal moments of inertia about the centre, or the inertia tensor.
        m, rho : float

        Warns
        -----
        geomint.GeomintWarning
            If no rigid body has such moments; see `chaplygin.rigid_body`.
        """
        D = _scale(m, rho)
        if as_array("moments", moments).ndim == 1:
            sphere = cls(inertia=SpecialInertia.from_moments(moments, D))
        else:
            sphere = cls(inertia=GeneralInertia.from_tensor(moments), D=D)
        warn_of_moments(moments)
        return sphere

    @classmethod
    def homogeneous(cls, n: int, s: Any, D: Any) -> ChaplyginSphere:
        """Return the homogeneous ball with inertia operator s·1 in dimension n."""
        return cls(inertia=SpecialInertia.homogeneous(n, s, D))

    @property
    def n(self) -> int:
        """The dimension."""
        return self.inertia.n

    @property
    def special(self) -> bool:
        """Whether the inertia operator is the special one, eq. (operator)."""
        return isinstance(self.inertia, SpecialInertia)

    def reduced(self) -> gi.Problem:
        """Return the reduced system on T*S^(n−1) in time t; see `reduced_problem`."""
        return reduced_problem(self.inertia, self.D)

    def hamiltonized(self) -> gi.Problem:
        """Return the Hamiltonised flow on T*S^(n−1) in time τ; see `hamiltonized_problem`."""
        if isinstance(self.inertia, SpecialInertia):
            return hamiltonized_problem(self.inertia)
        expected = "the special operator, a_i a_j D/(D − a_i a_j), which hamiltonized() needs"
        raise gi.DomainError("inertia", self.inertia.matrix, expected)

    def ball(self, attitude: bool = False, k0: Any = None) -> gi.Problem:
        """Return the ball in (k, γ) or (k, γ, g); see `ball_problem`."""
        return ball_problem(self.inertia, self.D, attitude, k0)

    def classical(self, attitude: bool = False, k0: Any = None) -> gi.Problem:
        """Return the ball in R³ in vectors; see `classical_problem`."""
        return classical_problem(self.inertia, self.D, attitude, k0)

    def poisson(self) -> gi.Problem:
        """Return the ball in R³ in time τ, at any area constant; see `poisson_problem`."""
        return poisson_problem(self.inertia, self.D)

    def on_group(self, k0: Any = None) -> gi.Problem:
        """Return the ball on T*SO(n), in (k, g); see `cotangent_problem`."""
        return cotangent_problem(self.inertia, self.D, k0)

    def rolling(self, m: Any = None, rho: Any = None, k0: Any = None) -> gi.Problem:
        """Return the ball on SO(n) × R^(n−1) with the reaction of the plane; see `rolling_problem`.

        Parameters
        ----------
        m, rho : float
            Mass and radius; one of them will do, because mρ² = D.
        k0 : array_like, optional
        """
        return rolling_problem(self.inertia, *mass_and_radius(self.D, m, rho), k0)

    def contact(self, m: Any = None, rho: Any = None, k0: Any = None) -> gi.Problem:
        """Return the ball in (k, γ, g, r), with attitude and contact point; see `contact_problem`.

        Parameters
        ----------
        m, rho : float
            Mass and radius; one of them will do, because mρ² = D.
        k0 : array_like, optional
        """
        return contact_problem(self.inertia, *mass_and_radius(self.D, m, rho), k0)


def _scale(m: Any, rho: Any) -> float:
    radius = positive_number("rho", rho)
    return positive_number("m*rho**2", positive_number("m", m) * radius * radius)
