"""Geodesics of the ellipsoid, and the systems of Neumann and Clebsch on the sphere."""

from __future__ import annotations

import geomint as gi

from ..related.clebsch import clebsch_problem, neumann_problem
from ..related.ellipsoid import ellipsoid_problem
from .parameters import Number, Numbers, Strict

__all__ = ["CLEBSCH", "ELLIPSOID", "NEUMANN"]


class EllipsoidParameters(Strict):
    """The ellipsoid (x, A⁻¹x) = 1, A = diag(a): squares of the semi-axes."""

    a: Numbers


class EllipsoidInitial(Strict):
    """A point, or the direction in which it lies, and the velocity p."""

    x: Numbers
    p: Numbers


class NeumannParameters(Strict):
    """The potential ½σ(q, Aq), A = diag(a), σ = strength."""

    a: Numbers
    strength: Number = 1.0


class ClebschParameters(NeumannParameters):
    """The weights of the two flows; x = 1, y = 0 is Neumann's."""

    x: Number
    y: Number


class SphereInitial(Strict):
    """A point of the sphere and a tangent vector."""

    q: Numbers
    v: Numbers


def _only(name: str, problem: gi.Problem, initial: Strict) -> gi.Model:
    return gi.Model({name: problem}, {name: problem.state(**dict(initial))})


def _ellipsoid(parameters: EllipsoidParameters, initial: EllipsoidInitial) -> gi.Model:
    return _only("geodesics", ellipsoid_problem(parameters.a), initial)


def _neumann(parameters: NeumannParameters, initial: SphereInitial) -> gi.Model:
    return _only("neumann", neumann_problem(parameters.a, parameters.strength), initial)


def _clebsch(parameters: ClebschParameters, initial: SphereInitial) -> gi.Model:
    return _only("clebsch", clebsch_problem(**dict(parameters)), initial)


ELLIPSOID = gi.System(
    name="ellipsoid",
    summary="geodesics of the ellipsoid (x, A⁻¹x) = 1 in R^n: a separable constrained Hamiltonian",
    parameters=EllipsoidParameters,
    initial=EllipsoidInitial,
    build=_ellipsoid,
)
NEUMANN = gi.System(
    name="neumann",
    summary="Neumann's system on S^(n−1): a point in the potential ½σ(q, Aq), a natural system",
    parameters=NeumannParameters,
    initial=SphereInitial,
    build=_neumann,
)
CLEBSCH = gi.System(
    name="clebsch",
    summary="Clebsch's system on T*S^(n−1), which commutes with Neumann's",
    parameters=ClebschParameters,
    initial=SphereInitial,
    build=_clebsch,
)
