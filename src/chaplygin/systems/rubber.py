"""The rubber ball: no slip, and no turn about the vertical."""

import geomint as gi

from ..ball.rolling_states import initial_attitude
from ..rubber.sphere import RubberSphere
from .parameters import Matrix, Moments, Numbers, Placed, Weight


class RubberParameters(Weight):
    """A ball: one of a, inertia, moments; and D, or m and rho.

    `a` means (I + D)(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j; `moments` are principal moments about the centre,
    or the tensor, n = 3. With `multipliers` the scene's own problem is (g, r, ω, v), else (γ, p).
    """

    a: Numbers | None = None
    inertia: Numbers | Matrix | None = None
    moments: Moments = None
    multipliers: bool = True

    def sphere(self) -> RubberSphere:
        """Return the ball, or raise `geomint.DomainError`."""
        name, value = self.the_one_of("a", "inertia", "moments")
        m, rho = self.mass_and_radius()
        makers = {"a": RubberSphere.from_a, "moments": RubberSphere.from_moments}
        return makers.get(name, RubberSphere)(value, m * rho * rho)


def _build(parameters: RubberParameters, initial: Placed) -> gi.Model:
    sphere = parameters.sphere()
    rolling = sphere.rolling(*parameters.mass_and_radius())
    _, g = initial_attitude(initial.gamma, initial.g, sphere.n)
    start = rolling.state(g=g, r=initial.r, **initial.given("gamma", "g", "r"))
    problems = {"rolling": rolling, "reduced": sphere.reduced()}
    if sphere.body() is not None:
        problems["hamiltonized"] = sphere.hamiltonized()
    if not parameters.multipliers:
        problems = {**{k: v for k, v in problems.items() if k != "rolling"}, "rolling": rolling}
    common = rolling.physical_state(start)
    states = {
        name: start if name == "rolling" else problem.state(**common)
        for name, problem in problems.items()
    }
    return gi.Model(problems, states)


RUBBER = gi.System(
    name="rubber-ball",
    summary="the ball that neither slips nor twists: (g, r, ω, v) with reactions, (γ, p), (γ, p̃)",
    parameters=RubberParameters,
    initial=Placed,
    build=_build,
)
