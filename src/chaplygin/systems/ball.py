"""The ball with any momentum and any inertia operator, and the homogeneous one."""

from pydantic import Field

import geomint as gi

from ..ball.rolling_states import initial_attitude
from ..ball.sphere import ChaplyginSphere
from ..initial_states import initial_momentum
from ..manifold import vector_of_triangle
from .models import ball_model, spatial_momentum
from .parameters import Dimension, Initial, Matrix, Moments, Number, Numbers, Strict, Weight


class AnyBall(Weight):
    """A ball: one of a, inertia, moments, J; and D, or m and rho.

    With `moments` (n = 3: the principal moments of inertia, or the inertia tensor), k and omega of
    the initial state are vectors in R³ under the hat map; otherwise they are flat triangles. A skew
    matrix will do in both cases.
    """

    a: Numbers | None = None
    inertia: Numbers | Matrix | None = None
    moments: Moments = None
    J: Numbers | Matrix | None = None

    def sphere(self) -> ChaplyginSphere:
        """Return the ball, or raise `geomint.DomainError`."""
        name, value = self.the_one_of("a", "inertia", "moments", "J")
        m, rho = self.mass_and_radius()
        if name == "moments":
            return ChaplyginSphere.from_moments(value, m, rho)
        if name == "J":
            return ChaplyginSphere.from_tensor(value, m, rho)
        return ChaplyginSphere(**{name: value}, D=m * rho * rho)


class BallParameters(AnyBall):
    """A ball; `attitude` makes the scene's own problem carry g."""

    attitude: bool = Field(default=False, description="whether the state carries the rotation g")


class HomogeneousParameters(Strict):
    """The homogeneous ball with inertia operator s·1 in dimension n."""

    n: Dimension
    s: Number
    D: Number
    attitude: bool = Field(default=False, description="whether the state carries the rotation g")


def _build_ball(parameters: BallParameters, initial: Initial) -> gi.Model:
    vector, given = parameters.moments is not None, initial.components()
    sphere = parameters.sphere()
    return ball_model(sphere, initial.gamma, vector, parameters.attitude, **given)


def _build_homogeneous(parameters: HomogeneousParameters, initial: Initial) -> gi.Model:
    sphere = ChaplyginSphere.homogeneous(parameters.n, parameters.s, parameters.D)
    given = initial.components()
    return ball_model(sphere, initial.gamma, attitude=parameters.attitude, **given)


class GroupInitial(Initial):
    """A vertical direction or the attitude g (or both), and one of p, p_tilde, k, omega."""

    gamma: Numbers | None = None  # type: ignore[assignment]
    g: Matrix | None = None


def _build_group(parameters: AnyBall, initial: GroupInitial) -> gi.Model:
    """Return the ball in (k, g), and in (k, γ), which has not the attitude."""
    sphere, vector = parameters.sphere(), parameters.moments is not None
    given = initial.given("gamma", "g")
    gamma, g = initial_attitude(initial.gamma, initial.g, sphere.n)
    _, k = initial_momentum(sphere.inertia, sphere.D, gamma, vector, **given)
    group, ball = sphere.on_group(spatial_momentum(g, k, sphere.n)), sphere.ball()
    states = {"group": group.state(g=g, k=k), "ball": ball.state(gamma=gamma, k=k)}
    return gi.Model({"group": group, "ball": ball}, states)


def _build_poisson(parameters: AnyBall, initial: Initial) -> gi.Model:
    """Return the ball in R³ in time τ, and in time t."""
    sphere, vector = parameters.sphere(), parameters.moments is not None
    given = initial.components()
    gamma, k = initial_momentum(sphere.inertia, sphere.D, initial.gamma, vector, **given)
    problems = {"poisson": sphere.poisson(), "classical": sphere.classical()}
    x = vector_of_triangle(k)
    return gi.Model(problems, {name: q.state(gamma=gamma, k=x) for name, q in problems.items()})


BALL = gi.System(
    name="chaplygin-ball",
    summary="the ball with any momentum and any inertia, in (k, γ); in vectors from moments",
    parameters=BallParameters,
    initial=Initial,
    build=_build_ball,
)
GROUP = gi.System(
    name="ball-on-group",
    summary="the ball with any momentum and any inertia on T*SO(n), in (k, g)",
    parameters=AnyBall,
    initial=GroupInitial,
    build=_build_group,
)
POISSON = gi.System(
    name="ball-poisson",
    summary="the ball in R³ at any area constant in time τ, where it has a Poisson bracket",
    parameters=AnyBall,
    initial=Initial,
    build=_build_poisson,
)
HOMOGENEOUS = gi.System(
    name="homogeneous-ball",
    summary="the ball with inertia operator s·1 in R^n, in (k, γ)",
    parameters=HomogeneousParameters,
    initial=Initial,
    build=_build_homogeneous,
)
