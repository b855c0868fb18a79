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


def _ellipsoid(parameters: EllipsoidParameters, initial: EllipsoidInitial) -> gi.Model:
    problem = ellipsoid_problem(parameters.a)
    state = problem.state(x=initial.x, p=initial.p)
    return gi.Model(problems={"geodesics": problem}, states={"geodesics": state})


def _neumann(parameters: NeumannParameters, initial: SphereInitial) -> gi.Model:
    problem = neumann_problem(parameters.a, parameters.strength)
    return gi.Model({"neumann": problem}, {"neumann": problem.state(q=initial.q, v=initial.v)})


def _clebsch(parameters: ClebschParameters, initial: SphereInitial) -> gi.Model:
    problem = clebsch_problem(parameters.a, parameters.strength, parameters.x, parameters.y)
    return gi.Model({"clebsch": problem}, {"clebsch": problem.state(q=initial.q, v=initial.v)})


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
