"""The Veselova problem for any r, with multipliers and reduced to the Stiefel variety."""

import geomint as gi

from ..inertia import GeneralInertia
from ..rigid_body import warn_of_mass_tensor
from ..veselova.body import VeselovaLR
from .parameters import Matrix, Numbers, Strict, default_of


class LRParameters(Strict):
    """A body: one of a, inertia (entries or matrix on so(n)), J (mass tensor); and r.

    With `multipliers` the scene's own problem is (g, w), else (X, P) on T*V(n, r).
    """

    a: Numbers | None = None
    inertia: Numbers | Matrix | None = None
    J: Numbers | Matrix | None = None
    r: int = default_of(VeselovaLR, "r")
    multipliers: bool = True

    def body(self) -> VeselovaLR:
        """Return the body, or raise `geomint.DomainError`."""
        name, value = self.the_one_of("a", "inertia", "J")
        if name == "a":
            return VeselovaLR.from_a(value, self.r)
        if name == "inertia":
            return VeselovaLR(value, self.r)
        body = VeselovaLR(GeneralInertia.from_mass_tensor(value), self.r)
        warn_of_mass_tensor(value)
        return body


class LRInitial(Strict):
    """The attitude g (1 unless given), and one of w, k: flat triangles or skew matrices."""

    g: Matrix | None = None
    w: Numbers | Matrix | None = None
    k: Numbers | Matrix | None = None


def _build(parameters: LRParameters, initial: LRInitial) -> gi.Model:
    body = parameters.body()
    lr, stiefel = body.lr(), body.stiefel()
    start = lr.state(**initial.given())
    states = {"lr": start, "stiefel": stiefel.state(**lr.physical_state(start))}
    problems = {"lr": lr, "stiefel": stiefel}
    if not parameters.multipliers:
        problems = {"stiefel": stiefel, "lr": lr}
    return gi.Model(problems, states)


LR = gi.System(
    name="veselova-lr",
    summary="the Veselova problem on SO(n) for any r: (g, w) with multipliers, (X, P) on T*V(n, r)",
    parameters=LRParameters,
    initial=LRInitial,
    build=_build,
)
