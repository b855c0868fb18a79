"""The rubber ball: no slip, and no turn about the vertical."""

from __future__ import annotations

import geomint as gi

from ..ball.rolling_states import initial_attitude
from ..rubber.sphere import RubberSphere
from .parameters import Matrix, Numbers, Strict, Weight, the_one_of

__all__ = ["RUBBER"]


class RubberParameters(Weight):
    """A ball: one of a, inertia, moments; and D, or m and rho.

    `a` means (I + D)(E_i∧E_j) = a_i⁻¹a_j⁻¹ E_i∧E_j; `moments` are principal moments about the centre,
    or the tensor, n = 3. With `multipliers` the scene's own problem is (g, r, ω, v), else (γ, p).
    """

    a: Numbers | None = None
    inertia: Numbers | Matrix | None = None
    moments: Numbers | Matrix | None = None
    multipliers: bool = True

    def sphere(self) -> RubberSphere:
        """Return the ball, or raise `geomint.DomainError`."""
        operators = {"a": self.a, "inertia": self.inertia, "moments": self.moments}
        the_one_of(operators)
        m, rho = self.mass_and_radius()
        D = m * rho * rho
        if self.a is not None:
            return RubberSphere.from_a(self.a, D)
        if self.moments is not None:
            return RubberSphere.from_moments(self.moments, D)
        return RubberSphere(self.inertia, D)


class RubberInitial(Strict):
    """gamma or the attitude g (or both), one of p, k, omega, and the contact point r."""

    gamma: Numbers | None = None
    g: Matrix | None = None
    r: Numbers | None = None
    p: Numbers | None = None
    k: Numbers | Matrix | None = None
    omega: Numbers | Matrix | None = None


def _build(parameters: RubberParameters, initial: RubberInitial) -> gi.Model:
    sphere = parameters.sphere()
    given = {name: getattr(initial, name) for name in ("p", "k", "omega")}
    given = {name: value for name, value in given.items() if value is not None}
    rolling = sphere.rolling(*parameters.mass_and_radius())
    _, g = initial_attitude(initial.gamma, initial.g, sphere.n)
    start = rolling.state(g=g, r=initial.r, **given)
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
    initial=RubberInitial,
    build=_build,
)
