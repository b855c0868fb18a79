"""All representations of a ball from one initial state: what the systems of balls share."""

from functools import partial
from typing import Any

import numpy as np

import geomint as gi

from ..ball.sphere import ChaplyginSphere
from ..inertia import SpecialInertia
from ..initial_states import initial_momentum, initial_tangent, momentum_free
from ..manifold import Array, flat_triangle, skew_matrix, vector_of_triangle, wedge
from .reductions import TANGENT, equal_axes, momentum_lift, tangent_reductions

Problems = dict[str, gi.Problem]


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
    return _model(sphere, problems, vertical, k, p)


def ball_model(
    sphere: ChaplyginSphere,
    gamma: Any,
    vector: bool = False,
    attitude: bool = False,
    g: Any = None,
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
    g : array_like, shape (n, n), optional
        The attitude, where a form carries it; 1 unless given.
    **components
        One of p, p_tilde, k, omega.
    """
    vertical, k = initial_momentum(sphere.inertia, sphere.D, gamma, vector, **components)
    plain, carrying = _ball_problems(sphere, k, "classical" if vector else "ball", g)
    p = momentum_free(vertical, k)
    tangent = {} if p is None else _tangent_problems(sphere)
    parts = (carrying, plain, tangent) if attitude else (plain, tangent, carrying)
    problems = {name: q for part in parts for name, q in part.items()}
    return _model(sphere, problems, vertical, k, p, g)


def _tangent_problems(sphere: ChaplyginSphere) -> Problems:
    problems = {"reduced": sphere.reduced()}
    if sphere.special:
        problems["hamiltonized"] = sphere.hamiltonized()
    return problems


def _ball_problems(
    sphere: ChaplyginSphere, k: Array, first: str, g: Any = None
) -> tuple[Problems, Problems]:
    """Return the problems without and with the attitude, `first` before the other."""
    k0 = k if g is None else spatial_momentum(g, k, sphere.n)
    makers = {"ball": (sphere.ball, k0)}
    if sphere.n == 3:
        makers["classical"] = (sphere.classical, vector_of_triangle(k0))
    makers = {first: makers[first], **makers}
    plain = {name: make() for name, (make, _) in makers.items()}
    carrying = {f"{name}-attitude": make(True, k0) for name, (make, k0) in makers.items()}
    return plain, carrying


def spatial_momentum(g: Any, k: Array, n: int) -> Array:
    """Return the flat triangle of Ad_g k."""
    attitude = np.reshape(g, (n, n))
    return flat_triangle(attitude @ skew_matrix(k, n) @ attitude.T)


def _model(
    sphere: ChaplyginSphere,
    problems: Problems,
    gamma: Array,
    k: Array,
    p: Array | None,
    g: Any = None,
) -> gi.Model:
    """Return the model whose every problem starts from the same state."""
    states = {}
    for name, problem in problems.items():
        carried = {"g": g} if "g" in problem.slices else {}
        if name.startswith("ball"):
            states[name] = problem.state(gamma=gamma, k=k, **carried)
        elif name.startswith("classical"):
            states[name] = problem.state(gamma=gamma, k=vector_of_triangle(k), **carried)
        else:
            states[name] = problem.state(gamma=gamma, p=p)
    conditions = {name: "no SO(n−1)-momentum" for name in problems if name in TANGENT}
    reductions = [*tangent_reductions(problems, states, sphere.n)]
    if isinstance(sphere.inertia, SpecialInertia):
        more = {"ball": momentum_lift(sphere.n)} if "ball" in problems else {}
        reductions += equal_axes(
            sphere.inertia.a, states, partial(ChaplyginSphere, D=sphere.D), more
        )
    return gi.Model(problems, states, conditions, tuple(reductions))
