"""The systems that scenes name: parameters and initial states from TOML, problems to integrate.

Every system offers all representations that are valid for the initial state: the scene's own
first, those that carry the attitude g last (unless the scene asks for the attitude).
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

import geomint as gi

from .inertia import SpecialInertia, angular_momentum, positive_number
from .manifold import REPAIRED, Array, length, skew_matrix, vector_of_triangle, wedge
from .sphere import ChaplyginSphere
from .states import initial_momentum, initial_tangent

__all__ = ["BALL", "HAMILTONIZED", "HOMOGENEOUS", "REDUCED", "ball_model", "sphere_model"]

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Numbers = list[Number]
Matrix = list[Numbers]


class Strict(BaseModel):
    """Unknown keys are errors, and so are numbers written as strings."""

    model_config = ConfigDict(extra="forbid", arbitrary_types_allowed=False)


class SpecialParameters(Strict):
    """The special inertia operator, eq. (operator)."""

    a: Numbers
    D: Number


class BallParameters(Strict):
    """A ball: one of a, inertia, moments, J; and D, or m and rho.

    With `moments` (n = 3: the principal moments of inertia, or the inertia tensor), k and omega of
    the initial state are vectors in R³ under the hat map; otherwise they are flat triangles. A skew
    matrix will do in both cases. `attitude` makes the scene's own problem carry g.
    """

    a: Numbers | None = None
    inertia: Numbers | Matrix | None = None
    moments: Numbers | Matrix | None = None
    J: Numbers | Matrix | None = None
    D: Number | None = None
    m: Number | None = None
    rho: Number | None = None
    attitude: bool = False


class HomogeneousParameters(Strict):
    """The homogeneous ball with inertia operator s·1 in dimension n."""

    n: Annotated[int, Field(strict=True, ge=2)]
    s: Number
    D: Number
    attitude: bool = False


class Initial(Strict):
    """A vertical direction and one of p, p_tilde, k, omega."""

    gamma: Numbers
    p: Numbers | None = None
    p_tilde: Numbers | None = None
    k: Numbers | Matrix | None = None
    omega: Numbers | Matrix | None = None

    def components(self) -> dict[str, Any]:
        """Return what was given, γ aside."""
        return {name: value for name, value in self if name != "gamma" and value is not None}


def sphere_model(sphere: ChaplyginSphere, first: str, gamma: Any, **components: Any) -> gi.Model:
    """Return all representations of a ball without SO(n−1)-momentum, `first` before the others."""
    vertical, p = initial_tangent(sphere.inertia, sphere.D, gamma, **components)
    problems = {
        **_tangent_problems(sphere, first),
        **_ball_problems(sphere, wedge(vertical, p), False),
    }
    return _model(problems, vertical, {"p": p}, wedge(vertical, p))


def ball_model(
    sphere: ChaplyginSphere,
    gamma: Any,
    vector: bool = False,
    attitude: bool = False,
    **components: Any,
) -> gi.Model:
    """Return all representations of a ball with any momentum.

    Parameters
    ----------
    sphere : ChaplyginSphere
    gamma : array_like, shape (n,)
    vector : bool
        k and omega are 3-vectors, and the classical form is the scene's own.
    attitude : bool
        The scene's own form carries g.
    **components
        One of p, p_tilde, k, omega.
    """
    if "p" in components or "p_tilde" in components:
        vertical, p = initial_tangent(sphere.inertia, sphere.D, gamma, **components)
        k = wedge(vertical, p)
    else:
        vertical, k = initial_momentum(sphere.inertia, sphere.D, gamma, vector, **components)
        p = -skew_matrix(k, sphere.n) @ vertical
    problems = _ball_problems(sphere, k, attitude, vector)
    size = length(k)
    if size == 0.0 or length(k / size - wedge(vertical, p / size)) <= REPAIRED * 1e-7:
        p = p - (vertical @ p) * vertical
        problems = _before_attitude(problems, _tangent_problems(sphere, "reduced"), attitude)
    return _model(problems, vertical, {"p": p}, k)


def _tangent_problems(sphere: ChaplyginSphere, first: str) -> dict[str, gi.Problem]:
    problems = {"reduced": sphere.reduced()}
    if sphere.special:
        problems["hamiltonized"] = sphere.hamiltonized()
    return {first: problems[first], **problems}


def _ball_problems(
    sphere: ChaplyginSphere, k: Array, attitude: bool, vector: bool = False
) -> dict[str, gi.Problem]:
    makers = {"ball": (sphere.ball, k)}
    if sphere.n == 3:
        makers["classical"] = (sphere.classical, vector_of_triangle(k))
    own = "classical" if vector else "ball"
    names = [own, *(name for name in makers if name != own)]
    plain = {name: makers[name][0]() for name in names}
    carrying = {f"{name}-attitude": makers[name][0](True, makers[name][1]) for name in names}
    return {**carrying, **plain} if attitude else {**plain, **carrying}


def _before_attitude(
    problems: dict[str, gi.Problem], others: dict[str, gi.Problem], attitude: bool
) -> dict[str, gi.Problem]:
    if attitude:
        return {**problems, **others}
    plain = {name: p for name, p in problems.items() if not name.endswith("-attitude")}
    return {**plain, **others, **problems}


def _model(
    problems: dict[str, gi.Problem], gamma: Array, tangent: dict[str, Array], k: Array
) -> gi.Model:
    states = {}
    for name, problem in problems.items():
        if name in ("reduced", "hamiltonized"):
            states[name] = problem.state(gamma=gamma, **tangent)
        elif name.startswith("classical"):
            states[name] = problem.state(gamma=gamma, k=vector_of_triangle(k))
        else:
            states[name] = problem.state(gamma=gamma, k=k)
    return gi.Model(problems=problems, states=states)


def _sphere_of(parameters: BallParameters) -> ChaplyginSphere:
    given = [name for name in ("a", "inertia", "moments", "J") if getattr(parameters, name) is not None]
    if len(given) != 1:
        raise gi.DomainError("[system]", given, "exactly one of a, inertia, moments, J")
    mass = (parameters.m, parameters.rho)
    if (parameters.D is None) == (None in mass) or (parameters.D is not None and any(mass)):
        raise gi.DomainError("[system] D", parameters.D, "D, or m and rho")
    if parameters.D is not None:
        m, rho = positive_number("D", parameters.D), 1.0
    else:
        m, rho = mass
    value = getattr(parameters, given[0])
    if given[0] == "moments":
        return ChaplyginSphere.from_moments(value, m, rho)
    if given[0] == "J":
        return ChaplyginSphere.from_tensor(value, m, rho)
    return ChaplyginSphere(**{given[0]: value}, D=m * rho * rho)
