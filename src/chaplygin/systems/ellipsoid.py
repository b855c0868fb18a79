"""Geodesics of the ellipsoid."""

from __future__ import annotations

import geomint as gi

from ..related.ellipsoid import ellipsoid_problem
from .parameters import Numbers, Strict

__all__ = ["ELLIPSOID"]


class EllipsoidParameters(Strict):
    """The ellipsoid (x, A⁻¹x) = 1, A = diag(a): squares of the semi-axes."""

    a: Numbers


class EllipsoidInitial(Strict):
    """A point, or the direction in which it lies, and the velocity p."""

    x: Numbers
    p: Numbers


def _build(parameters: EllipsoidParameters, initial: EllipsoidInitial) -> gi.Model:
    problem = ellipsoid_problem(parameters.a)
    state = problem.state(x=initial.x, p=initial.p)
    return gi.Model(problems={"geodesics": problem}, states={"geodesics": state})


ELLIPSOID = gi.System(
    name="ellipsoid",
    summary="geodesics of the ellipsoid (x, A⁻¹x) = 1 in R^n: a separable constrained Hamiltonian",
    parameters=EllipsoidParameters,
    initial=EllipsoidInitial,
    build=_build,
)
