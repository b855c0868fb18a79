"""The ball in (k, γ, g, r): attitude and contact point reconstructed from the reduced system.

k̇ = [k, ω], γ̇ = −ωγ, ġ = gω as in `momentum`, and ṙ = ρ gωγ, eq. (ch-constr): the constraint holds by
construction, and no multiplier is integrated. The reaction Λ = mρ gω̇γ follows from (k, γ, g) in
closed form; see `rolling_dynamics`. As an action of SO(n) × R^(n−1), with ξ = (−ω, ρ gωγ): rotations
act on k, γ and g, and r is moved by translations, so that group methods keep the momentum in space.

E_n is the vertical in space, from the plane to the centre of the ball, so γ is the last row of g as
well; "vertical" says how far they are apart. Everything is dimensionless. The measure is that of the
ball with attitude (`momentum`), times that of the plane.
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import part, section

from ..inertia import Inertia, parameters_of
from ..literature import BALL
from ..manifold import Array, Named, triangle_rows
from ..operators import after
from .fields import ball_forms, ball_integrals, ball_parameters, opposite, turn
from .momentum import ball_problem
from .path import carried_path
from .rolling_dynamics import contact_observables, distance, rolled, rolling_dynamics, rolling_work
from .rolling_states import (
    admit_vertical,
    initial_attitude,
    initial_position,
    initial_rolling,
    rolling_scale,
)


@functools.cache
def contact_forms(omega: Any, n: int, rows: Any) -> Named:
    """Return field, generator, defect of the vertical, and where things lie; y = (k, γ, g, r)."""
    size, square = triangle_rows(n), n * n
    turning = size + n + square  # rows that turn; r comes after them

    def locate(params, y, work):
        """Return blocks (γ, g, ω, r, scratch)."""
        gamma, w = part(y, size, n), part(work, 0, size)
        rest = after(work, size)
        omega(n, section(params, rows, "omega"), part(y, 0, size), gamma, w, rest)
        return gamma, part(y, size + n, square), w, part(y, turning, n - 1), rest

    located = gi.helper(locate)

    def contact_field(params, t, y, out, work):
        """Eqs. (ch-red), (PE), (ch-red2) and (ch-constr)."""
        gamma, g, w, _, rest = located(params, y, work)
        turn(n, w, part(y, 0, turning), part(out, 0, turning), rest)
        rolled(n, section(params, rows, "rho")[0], g, gamma, w, part(out, turning, n - 1), rest)

    def contact_generator(params, t, y, out, work):
        """ξ = (−ω, ρ gωγ)."""
        gamma, g, w, _, rest = located(params, y, work)
        opposite(size, w, out)
        rolled(n, section(params, rows, "rho")[0], g, gamma, w, part(out, size, n - 1), rest)

    def contact_vertical(params, t, y, work):
        """|γ − g⁻¹E_n|."""
        return distance(n, part(y, size, n), part(y, turning - n, n))

    return {
        "field": gi.field(contact_field),
        "generator": gi.field(contact_generator),
        "locate": located,
        "vertical": gi.observable(contact_vertical),
    }


def contact_problem(inertia: Inertia, m: Any, rho: Any, k0: Any = None) -> gi.Problem:
    """Return the ball in (k, γ, g, r), with attitude and contact point.

    State: ``k`` (n(n−1)/2,), the flat triangle, and ``gamma`` (n,), both in the body; ``g`` (n·n,),
    the rotation from body to space, row after row; ``r`` (n−1,), the contact point in the plane.
    Time t. Forms: ODE and action of SO(n) × R^(n−1).
    ``state(gamma=…, k=…)``: instead of gamma (or with it) g; where g is not given, it is the
    smallest rotation that takes γ to E_n. Instead of k also omega, or p or p_tilde; r = 0 unless
    given.

    Parameters
    ----------
    inertia : SpecialInertia or GeneralInertia
    m, rho : float
        Mass and radius, > 0; mρ² = D.
    k0 : array_like, flat or (n, n), optional
        The spatial momentum Ad_g k: gives "spatial-momentum" |Ad_g k − k_0|.

    Raises
    ------
    geomint.DomainError
        For an mρ² that is not the D of a special operator; from ``state`` and ``canonical`` for a
        g that is no rotation, or a gamma that is not g⁻¹E_n.
    """
    n = inertia.n
    size = triangle_rows(n)
    D = rolling_scale(inertia, m, rho)
    m, rho = float(m), float(rho)
    omega, rows, params = ball_parameters(inertia, D, k0, m, rho)
    forms, ball = contact_forms(omega, n, rows), ball_forms(omega, n, rows, size)
    kept = ball_integrals(n, rows, size, size + n)
    constraints = {"vertical": forms["vertical"]}
    space = gi.Skew(n) * gi.Sphere(n) * gi.Rotations(n) * gi.Euclidean(n - 1, "r")
    if k0 is not None:
        constraints["spatial-momentum"] = kept.spatial_momentum

    def make_state(gamma: Any = None, g: Any = None, r: Any = None, **components: Any) -> Array:
        vertical, attitude = initial_attitude(gamma, g, n)
        k, _ = initial_rolling(inertia, D, vertical, **components)
        return np.concatenate([k, vertical, attitude, initial_position(r, n)])

    def admit(y: Array) -> Array:
        parts = space.split(space.admit(y))
        return space.join({**parts, "gamma": admit_vertical(parts["gamma"], parts["g"])})

    return gi.Problem(
        name="ball-with-contact",
        equations=(
            "k̇ = [k, ω],  γ̇ = −ωγ,  ġ = gω,  ṙ = ρ gωγ",
            "k = Iω + D(ωγγᵀ + γγᵀω),  D = mρ²",
        ),
        space=space,
        params=params,
        field=forms["field"],
        action=space.action(forms["generator"]),
        work=rolling_work(omega, n),
        invariants={"energy": ball.energy, **kept.invariants},
        constraints=constraints,
        measure=gi.Measure(ball.log_density, base=ball_problem(inertia, D)),
        observables=contact_observables(rolling_dynamics(omega, n, rows), n, rows, forms["locate"]),
        make_state=make_state,
        make_path=carried_path(space, rho),
        make_random=(gi.Rotations(n) * gi.Skew(n) * gi.Euclidean(n - 1, "r")).random,
        admit=admit,
        physical=lambda y: {"gamma": np.array(y[size : size + n]), "k": np.array(y[:size])},
        parameters={**parameters_of(inertia, D), "m": m, "rho": rho},
        references=BALL,
    )
