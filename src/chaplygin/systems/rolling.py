"""The ball that rolls on a plane, with attitude, contact point and the reaction of the plane."""

import geomint as gi

from ..ball.rolling_states import initial_attitude, initial_rolling
from ..manifold import Named, skew_components, skew_matrix
from .ball import AnyBall
from .models import ball_model, spatial_momentum
from .parameters import Numbers, Placed


class RollingParameters(AnyBall):
    """A ball; without `multipliers` the scene's own problem is (k, γ, g, r), not (g, r, ω, v)."""

    multipliers: bool = True


class RollingInitial(Placed):
    """One of p, p_tilde, k, omega, and where the ball is: gamma or the attitude g (or both), r, v.

    Where g is not given, it is the smallest rotation that takes gamma to E_n; r = 0 and the v of
    rolling unless given. A v with which the ball slips is an error.
    """

    v: Numbers | None = None
    p_tilde: Numbers | None = None

    def momentum(self, n: int, vector: bool) -> Named:
        """Return the momentum that was given, k and omega as flat triangles."""
        found = self.given("gamma", "g", "r", "v")
        for name in found.keys() & {"k", "omega"}:
            found[name] = skew_components(name, found[name], n, vector)
        return found


def _build(parameters: RollingParameters, initial: RollingInitial) -> gi.Model:
    sphere, vector = parameters.sphere(), parameters.moments is not None
    n, scale = sphere.n, parameters.mass_and_radius()
    gamma, g = initial_attitude(initial.gamma, initial.g, n)
    k, omega = initial_rolling(sphere.inertia, sphere.D, gamma, **initial.momentum(n, vector))
    k0 = spatial_momentum(g, k, n)
    rolling, contact = sphere.rolling(*scale, k0), sphere.contact(*scale, k0)
    states = {
        "rolling": rolling.state(g=g, r=initial.r, omega=omega, v=initial.v),
        "contact": contact.state(gamma=gamma, g=g, r=initial.r, k=k),
    }
    problems = {"rolling": rolling, "contact": contact}
    if not parameters.multipliers:
        problems = {"contact": contact, "rolling": rolling}
    others = ball_model(sphere, gamma, vector, g=g, k=skew_matrix(k, n))
    states = {**states, **others.states}
    problems = {**problems, **others.problems}
    return gi.Model(problems, states, others.conditions, others.reductions)


ROLLING = gi.System(
    name="rolling-ball",
    summary="the ball rolling on a plane, with attitude, contact point and reaction: (g, r, ω, v)",
    parameters=RollingParameters,
    initial=RollingInitial,
    build=_build,
)
