"""The ball on T*SO(n) in (k, g): the reduction by translations, any n, momentum and inertia operator.

k̇ = [k, ω], ġ = gω, eqs. (ch-red), (ch-red2), with γ = g⁻¹E_n the last row of g: (k, g) is the flow on
the group itself, while (k, γ) of `momentum` is its reduction by the turns about the vertical. All of
Ad_g k is constant. As an action of SO(n): k ↦ E k Eᵀ, g ↦ g Eᵀ with ξ = −ω.

The measure has the density ϱ = det(I + D pr)^(−1/2) by dk and the Haar measure of g, eq. (mu).
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi

from ..inertia import GeneralInertia, SpecialInertia, parameters_of
from ..initial_states import initial_momentum
from ..manifold import Array
from .fields import ball_forms, ball_parameters, ball_work
from .integrals import ball_integrals
from .rolling_states import initial_attitude

__all__ = ["cotangent_problem"]


def cotangent_problem(
    inertia: SpecialInertia | GeneralInertia, D: float, k0: Any = None
) -> gi.Problem:
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
    size, square = n * (n - 1) // 2, n * n
    vertical = size + square - n
    omega, rows, params = ball_parameters(inertia, D, k0)
    forms, kept = ball_forms(omega, n, rows, vertical), ball_integrals(n, rows, vertical, size)
    space = gi.Skew(n) * gi.Rotations(n)

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        gamma, attitude = initial_attitude(gamma, g, n)
        _, k = initial_momentum(inertia, D, gamma, **components)
        return np.concatenate([k, attitude])

    return gi.Problem(
        name="ball-on-group",
        space=space,
        params=params,
        field=forms.field,
        action=space.action(forms.generator),
        work=ball_work(omega, n),
        invariants={"energy": forms.energy, **kept.invariants},
        constraints={} if k0 is None else {"spatial-momentum": kept.spatial_momentum},
        measure=gi.Measure(forms.log_density),
        make_state=make_state,
        make_random=(gi.Rotations(n) * gi.Skew(n)).random,
        physical=lambda y: {"gamma": np.array(y[vertical:]), "k": np.array(y[:size])},
        parameters=parameters_of(inertia, D),
    )
