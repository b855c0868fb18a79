"""The ball in (k, γ) on so(n)*×S^(n−1): any n ≥ 2, any momentum, any inertia operator.

k̇ = [k, ω], eq. (ch-red), γ̇ = −ωγ, eq. (PE), and with the attitude ġ = gω, eq. (ch-red2); ω from k
and γ as in `angular_velocity`. All of k is constant in space: (Ad_g k)˙ = 0. As an action of
SO(n), ẏ = ξ·y with ξ = −ω: k ↦ E k Eᵀ, γ ↦ Eγ, g ↦ g Eᵀ.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint.arguments import switch

from ..exact.motions import exact_turn
from ..inertia import GeneralInertia, SpecialInertia, parameters_of
from ..initial_states import initial_momentum
from ..manifold import Array
from .fields import ball_forms, ball_parameters, ball_work
from .integrals import ball_integrals

__all__ = ["ball_problem"]


def ball_problem(
    inertia: SpecialInertia | GeneralInertia, D: float, attitude: bool = False, k0: Any = None
) -> gi.Problem:
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
    size = n * (n - 1) // 2
    attitude = switch("attitude", attitude)
    space = gi.Product(gi.Skew(n), gi.Sphere(n), *([gi.Rotations(n)] if attitude else []))
    if k0 is not None and not attitude:
        raise gi.DomainError("k0", k0, "None, or attitude=True: without g nothing is in space")
    omega, rows, params = ball_parameters(inertia, D, k0)
    forms, kept = ball_forms(omega, n, rows), ball_integrals(n, rows, size, size + n)

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        if g is not None and not attitude:
            raise gi.DomainError("g", g, "no attitude: this problem has attitude=False")
        vertical, k = initial_momentum(inertia, D, gamma, **components)
        return np.concatenate([k, vertical, *([gi.Rotations(n).point(g)] if attitude else [])])

    def make_random(rng: np.random.Generator) -> dict[str, Any]:
        if not attitude:
            return space.random(rng)
        parts = (gi.Skew(n) * gi.Rotations(n)).random(rng)
        return {**parts, "gamma": parts["g"][-n:]}

    return gi.Problem(
        name="chaplygin-ball",
        space=space,
        params=params,
        field=forms.field,
        action=space.action(forms.generator),
        work=ball_work(omega, n),
        invariants={"energy": forms.energy, **kept.invariants},
        constraints={} if k0 is None else {"spatial-momentum": kept.spatial_momentum},
        measure=gi.Measure(forms.log_density),
        make_state=make_state,
        make_random=make_random,
        make_exact=exact_turn(inertia, D),
        physical=lambda y: {"gamma": np.array(y[size : size + n]), "k": np.array(y[:size])},
        parameters=parameters_of(inertia, D),
    )
