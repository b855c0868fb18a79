"""The systems that scenes name: parameters and initial states from TOML, problems to integrate.

Every system offers all representations that are valid for the initial state: the scene's own
first, those that carry the attitude g last (unless the scene asks for the attitude).
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

import geomint as gi

from .manifold import Array, vector_of_triangle, wedge
from .sphere import ChaplyginSphere
from .states import initial_momentum, initial_tangent, momentum_free

__all__ = ["BALL", "HAMILTONIZED", "HOMOGENEOUS", "REDUCED", "ball_model", "sphere_model"]

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Numbers = list[Number]
Matrix = list[Numbers]


class Strict(BaseModel):
    """Unknown keys are errors, and so are numbers written as strings."""

    model_config = ConfigDict(extra="forbid")


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
    """Return all representations of a ball without SO(n−1)-momentum, `first` before the others.

    Parameters
    ----------
    sphere : ChaplyginSphere
    first : ``"reduced"`` or ``"hamiltonized"``
    gamma : array_like, shape (n,)
    **components
        One of p, p_tilde, k, omega.
    """
    vertical, p = initial_tangent(sphere.inertia, sphere.D, gamma, **components)
    k = wedge(vertical, p)
    tangent = _tangent_problems(sphere)
    # Vectors cost a fifth of triangles where both will do.
    plain, carrying = _ball_problems(sphere, k, "classical" if sphere.n == 3 else "ball")
    problems = {first: tangent[first], **tangent, **plain, **carrying}
    return _model(problems, vertical, k, p)


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
    vertical, k = initial_momentum(sphere.inertia, sphere.D, gamma, vector, **components)
    plain, carrying = _ball_problems(sphere, k, "classical" if vector else "ball")
    p = momentum_free(vertical, k)
    tangent = {} if p is None else _tangent_problems(sphere)
    parts = (carrying, plain, tangent) if attitude else (plain, tangent, carrying)
    return _model({name: q for part in parts for name, q in part.items()}, vertical, k, p)


def _tangent_problems(sphere: ChaplyginSphere) -> dict[str, gi.Problem]:
    problems = {"reduced": sphere.reduced()}
    if sphere.special:
        problems["hamiltonized"] = sphere.hamiltonized()
    return problems


def _ball_problems(
    sphere: ChaplyginSphere, k: Array, first: str
) -> tuple[dict[str, gi.Problem], dict[str, gi.Problem]]:
    """Return the problems without and with the attitude, `first` before the other."""
    makers: dict[str, Any] = {"ball": (sphere.ball, k)}
    if sphere.n == 3:
        makers["classical"] = (sphere.classical, vector_of_triangle(k))
    makers = {first: makers[first], **makers}
    plain = {name: make() for name, (make, _) in makers.items()}
    carrying = {f"{name}-attitude": make(True, k0) for name, (make, k0) in makers.items()}
    return plain, carrying


def _model(problems: dict[str, gi.Problem], gamma: Array, k: Array, p: Array | None) -> gi.Model:
    """Return the model whose every problem starts from the same state."""
    states = {}
    for name, problem in problems.items():
        if name.startswith("ball"):
            states[name] = problem.state(gamma=gamma, k=k)
        elif name.startswith("classical"):
            states[name] = problem.state(gamma=gamma, k=vector_of_triangle(k))
        else:
            states[name] = problem.state(gamma=gamma, p=p)
    return gi.Model(problems=problems, states=states)


def _sphere_of(parameters: BallParameters) -> ChaplyginSphere:
    operators = {name: getattr(parameters, name) for name in ("a", "inertia", "moments", "J")}
    given = {name: value for name, value in operators.items() if value is not None}
    if len(given) != 1:
        raise gi.DomainError("parameters", list(given), f"exactly one of {list(operators)}")
    D, m, rho = parameters.D, parameters.m, parameters.rho
    if D is not None and m is None and rho is None:
        m, rho = D, 1.0
    elif D is not None or m is None or rho is None:
        raise gi.DomainError("parameters", {"D": D, "m": m, "rho": rho}, "D, or m and rho")
    (name, value), *_ = given.items()
    if name == "moments":
        return ChaplyginSphere.from_moments(value, m, rho)
    if name == "J":
        return ChaplyginSphere.from_tensor(value, m, rho)
    return ChaplyginSphere(**{name: value}, D=m * rho * rho)


def _build_reduced(parameters: SpecialParameters, initial: Initial) -> gi.Model:
    sphere = ChaplyginSphere(a=parameters.a, D=parameters.D)
    return sphere_model(sphere, "reduced", initial.gamma, **initial.components())


def _build_hamiltonized(parameters: SpecialParameters, initial: Initial) -> gi.Model:
    sphere = ChaplyginSphere(a=parameters.a, D=parameters.D)
    return sphere_model(sphere, "hamiltonized", initial.gamma, **initial.components())


def _build_ball(parameters: BallParameters, initial: Initial) -> gi.Model:
    vector, sphere = parameters.moments is not None, _sphere_of(parameters)
    given = initial.components()
    return ball_model(sphere, initial.gamma, vector, parameters.attitude, **given)


def _build_homogeneous(parameters: HomogeneousParameters, initial: Initial) -> gi.Model:
    sphere = ChaplyginSphere.homogeneous(parameters.n, parameters.s, parameters.D)
    given = initial.components()
    return ball_model(sphere, initial.gamma, attitude=parameters.attitude, **given)


REDUCED = gi.System(
    name="chaplygin-sphere-reduced",
    summary="the Chaplygin sphere without SO(n−1)-momentum, on T*S^(n−1), in time t",
    parameters=SpecialParameters,
    initial=Initial,
    build=_build_reduced,
)
HAMILTONIZED = gi.System(
    name="chaplygin-sphere-hamiltonized",
    summary="the Hamiltonised Chaplygin sphere, a geodesic flow on T*S^(n−1), in time τ",
    parameters=SpecialParameters,
    initial=Initial,
    build=_build_hamiltonized,
)
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
