"""The Veselova problem: reduced, Hamiltonised, and classical at any value of f₁."""

from functools import partial
from typing import Annotated

from pydantic import Field

import geomint as gi

from ..manifold import triangle_of_vector
from ..veselova.body import Veselova
from ..veselova.initial_states import veselova_tangent
from .parameters import Direction, Matrix, Number, Numbers, Strict, default_of
from .reductions import equal_axes


class VeselovaParameters(Strict):
    """A body: a, or at n = 3 its principal moments of inertia.

    With `moments`, k and w of the initial state are vectors in R³, the classical problem is the scene's
    own, and the constraint is (w, gamma) = f1; otherwise they are flat triangles. D is the unit of τ.
    """

    a: Numbers | None = None
    moments: Annotated[Numbers | None, Field(title="I")] = None
    D: Number = default_of(Veselova, "D")
    f1: Number = default_of(Veselova.classical, "f1")

    def body(self) -> Veselova:
        """Return the body, or raise `geomint.DomainError`."""
        if (self.a is None) == (self.moments is None):
            given = {"a": self.a, "moments": self.moments}
            raise gi.DomainError("parameters", given, "either a or moments")
        if self.moments is not None:
            return Veselova.from_moments(self.moments, self.D)
        if self.f1 != 0.0:
            raise gi.DomainError("f1", self.f1, "0, or the classical problem with moments")
        return Veselova(self.a, self.D)


class VeselovaInitial(Direction):
    """A direction that is fixed in space and one of p, p_tilde, k, w."""

    w: Numbers | Matrix | None = None


def _build(parameters: VeselovaParameters, initial: VeselovaInitial) -> gi.Model:
    """Return the model: T*S^(n−1) has only the states with f₁ = 0."""
    body, given = parameters.body(), initial.components()
    if parameters.f1 != 0.0 and "D" in parameters.model_fields_set and "p_tilde" not in given:
        expected = "none with f1 ≠ 0: it is the unit of τ and of p_tilde, and neither is there"
        raise gi.DomainError("D", parameters.D, expected)
    problems = {}
    if parameters.f1 == 0.0:
        problems = {"reduced": body.reduced(), "hamiltonized": body.hamiltonized()}
    if parameters.moments is None:
        gamma, p = veselova_tangent(body.a, body.D, initial.gamma, **given)
        if body.n == 3:
            problems |= {"classical": body.classical(), "multiplier": body.multiplier()}
        states = {name: problem.state(gamma=gamma, p=p) for name, problem in problems.items()}
        reductions = tuple(equal_axes(body.a, states, partial(Veselova, D=body.D)))
        return gi.Model(problems, states, reductions=reductions)
    classical = body.classical(parameters.f1)
    start = classical.state(gamma=initial.gamma, **given)
    gamma, k = start[3:], triangle_of_vector(start[:3])
    states = {name: problem.state(gamma=gamma, k=k) for name, problem in problems.items()}
    multiplier = body.multiplier(parameters.f1)
    states |= {"classical": start, "multiplier": multiplier.state(gamma=gamma, k=start[:3])}
    return gi.Model({"classical": classical, **problems, "multiplier": multiplier}, states)


VESELOVA = gi.System(
    name="veselova",
    summary="the Veselova problem with r = 1, on T*S^(n−1); at n = 3 in vectors from moments",
    parameters=VeselovaParameters,
    initial=VeselovaInitial,
    build=_build,
)
