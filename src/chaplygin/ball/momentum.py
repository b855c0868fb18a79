"""The ball in (k, γ) on so(n)*×S^(n−1), and in (k, g): any n ≥ 2, any momentum, any inertia operator.

k̇ = [k, ω], eq. (ch-red), γ̇ = −ωγ, eq. (PE), and with the attitude ġ = gω, eq. (ch-red2); ω from k
and γ as in `angular_velocity`. All of k is constant in space: (Ad_g k)˙ = 0. As an action of
SO(n), ẏ = ξ·y with ξ = −ω: k ↦ E k Eᵀ, γ ↦ Eγ, g ↦ g Eᵀ.

On T*SO(n) the state is (k, g): the reduction by translations alone, with γ = g⁻¹E_n the last row of g.
That is the flow on the group itself, while (k, γ) is its reduction by the turns about the vertical.
The measure of (k, g) has the density ϱ = det(I + D pr)^(−1/2) by dk and Haar's measure, eq. (mu).
"""

from typing import Any

import numpy as np

import geomint as gi

from ..exact.motions import exact_turn
from ..inertia import Inertia, parameters_of
from ..initial_states import initial_momentum
from ..literature import BALL
from ..manifold import Array, Arrays, Named, triangle_rows
from .fields import ball_forms, ball_integrals, ball_parameters, ball_work
from .path import integrated_path
from .rolling_states import has_attitude, initial_attitude, own_attitude


def ball_problem(inertia: Inertia, D: float, attitude: bool = False, k0: Any = None) -> gi.Problem:
    """Return the ball in (k, γ), or in (k, γ, g) with the attitude.

    State: ``k`` (n(n−1)/2,), the flat triangle, ``gamma`` (n,) and with `attitude` ``g`` (n·n,),
    the rotation from body to space, row after row. Time t. Forms: ODE and action of SO(n).
    ``state(gamma=…, k=…)`` with k a skew matrix or flat; instead of k also omega, or p or p_tilde
    for k = γ∧p; g = 1 unless given.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.
    attitude : bool
        Carry g.
    k0 : array_like, flat or (n, n), optional
        The spatial momentum Ad_g k (k itself where g = 1): gives "spatial-momentum" |Ad_g k − k_0|.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a k, γ or g that describes no state; see `manifold`.
    """
    n = inertia.n
    size = triangle_rows(n)
    attitude = has_attitude(attitude, k0)
    space = gi.Product(gi.Skew(n), gi.Sphere(n), *([gi.Rotations(n)] if attitude else []))

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        last = own_attitude(g, attitude, n)
        vertical, k = initial_momentum(inertia, D, gamma, **components)
        return np.concatenate([k, vertical, *last])

    def make_random(rng: np.random.Generator) -> Named:
        if not attitude:
            return space.random(rng)
        parts = (gi.Skew(n) * gi.Rotations(n)).random(rng)
        return {**parts, "gamma": parts["g"][-n:]}

    base = ball_problem(inertia, D) if attitude else None
    made = make_state, make_random, exact_turn(inertia, D), base
    return _ball("chaplygin-ball", inertia, D, k0, space, size, size + n, *made)


def _ball(
    name: str,
    inertia: Inertia,
    D: float,
    k0: Any,
    space: gi.Space,
    vertical: int,
    frame: int,
    make_state: Any,
    make_random: Any,
    make_exact: Any = None,
    base: gi.Problem | None = None,
) -> gi.Problem:
    """Return the problem of states with k first, γ from row `vertical` and g from row `frame` on."""
    n = inertia.n
    size = triangle_rows(n)
    omega, rows, params = ball_parameters(inertia, D, k0)
    forms = ball_forms(omega, n, rows, vertical)
    kept = ball_integrals(n, rows, vertical, frame)

    def physical(y: Array) -> Arrays:
        return {"gamma": np.array(y[vertical : vertical + n]), "k": np.array(y[:size])}

    return gi.Problem(
        name=name,
        equations=(
            "k̇ = [k, ω],  γ̇ = −ωγ,  ġ = gω",
            "k = Iω + D(ωγγᵀ + γγᵀω)",
        ),
        space=space,
        params=params,
        field=forms.field,
        action=space.action(forms.generator),
        work=ball_work(omega, n),
        invariants={"energy": forms.energy, **kept.invariants},
        constraints={} if k0 is None else {"spatial-momentum": kept.spatial_momentum},
        measure=gi.Measure(forms.log_density, base=base),
        make_state=make_state,
        make_random=make_random,
        make_exact=make_exact,
        make_path=integrated_path(inertia, D, physical, space.slices.get("g")),
        physical=physical,
        parameters=parameters_of(inertia, D),
        references=BALL,
    )


def cotangent_problem(inertia: Inertia, D: float, k0: Any = None) -> gi.Problem:
    """Return the ball in (k, g).

    State: ``k`` (n(n−1)/2,), the flat triangle, and ``g`` (n·n,), the rotation from body to space, row
    after row, with γ = g⁻¹E_n. Time t. Forms: ODE and action of SO(n).
    ``state(g=…, k=…)``; instead of g (or with it) gamma, which the smallest rotation takes to E_n;
    instead of k also omega, or p or p_tilde for k = γ∧p.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.
    k0 : array_like, flat or (n, n), optional
        The spatial momentum Ad_g k: gives "spatial-momentum" |Ad_g k − k_0|.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a g that is no rotation, a gamma that is not g⁻¹E_n.
    """
    n = inertia.n
    size, square = triangle_rows(n), n * n
    vertical = size + square - n
    space = gi.Skew(n) * gi.Rotations(n)

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        gamma, attitude = initial_attitude(gamma, g, n)
        _, k = initial_momentum(inertia, D, gamma, **components)
        return np.concatenate([k, attitude])

    make_random = (gi.Rotations(n) * gi.Skew(n)).random
    return _ball("ball-on-group", inertia, D, k0, space, vertical, size, make_state, make_random)
