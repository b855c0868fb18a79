"""The ball with any momentum and any inertia operator, and the homogeneous one."""

from __future__ import annotations

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from .models import ball_model
from .parameters import Dimension, Initial, Matrix, Number, Numbers, Strict

__all__ = ["BALL", "HOMOGENEOUS", "AnyBall"]


class AnyBall(Strict):
    """A ball: one of a, inertia, moments, J; and D, or m and rho.

    With `moments` (n = 3: the principal moments of inertia, or the inertia tensor), k and omega of
    the initial state are vectors in R³ under the hat map; otherwise they are flat triangles. A skew
    matrix will do in both cases.
    """

    a: Numbers | None = None
    inertia: Numbers | Matrix | None = None
    moments: Numbers | Matrix | None = None
    J: Numbers | Matrix | None = None
    D: Number | None = None
    m: Number | None = None
    rho: Number | None = None

    def mass_and_radius(self) -> tuple[float, float]:
        """Return m and ρ; where D is given, ρ = 1."""
        D, m, rho = self.D, self.m, self.rho
        if D is not None and m is None and rho is None:
            return D, 1.0
        if D is not None or m is None or rho is None:
            raise gi.DomainError("parameters", {"D": D, "m": m, "rho": rho}, "D, or m and rho")
        return m, rho

    def sphere(self) -> ChaplyginSphere:
        """Return the ball, or raise `geomint.DomainError`."""
        operators = {name: getattr(self, name) for name in ("a", "inertia", "moments", "J")}
        given = {name: value for name, value in operators.items() if value is not None}
        if len(given) != 1:
            raise gi.DomainError("parameters", list(given), f"exactly one of {list(operators)}")
        m, rho = self.mass_and_radius()
        (name, value), *_ = given.items()
        if name == "moments":
            return ChaplyginSphere.from_moments(value, m, rho)
        if name == "J":
            return ChaplyginSphere.from_tensor(value, m, rho)
        return ChaplyginSphere(**{name: value}, D=m * rho * rho)


class BallParameters(AnyBall):
    """A ball; `attitude` makes the scene's own problem carry g."""

    attitude: bool = False


class HomogeneousParameters(Strict):
    """The homogeneous ball with inertia operator s·1 in dimension n."""

    n: Dimension
    s: Number
    D: Number
    attitude: bool = False


def _build_ball(parameters: BallParameters, initial: Initial) -> gi.Model:
    vector, given = parameters.moments is not None, initial.components()
    sphere = parameters.sphere()
    return ball_model(sphere, initial.gamma, vector, parameters.attitude, **given)


def _build_homogeneous(parameters: HomogeneousParameters, initial: Initial) -> gi.Model:
    sphere = ChaplyginSphere.homogeneous(parameters.n, parameters.s, parameters.D)
    given = initial.components()
    return ball_model(sphere, initial.gamma, attitude=parameters.attitude, **given)


BALL = gi.System(
    name="chaplygin-ball",
    summary="the ball with any momentum and any inertia, in (k, γ); in vectors from moments",
    parameters=BallParameters,
    initial=Initial,
    build=_build_ball,
)
HOMOGENEOUS = gi.System(
    name="homogeneous-ball",
    summary="the ball with inertia operator s·1 in R^n, in (k, γ)",
    parameters=HomogeneousParameters,
    initial=Initial,
    build=_build_homogeneous,
)
