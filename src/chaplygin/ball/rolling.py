"""The rolling ball on SO(n) × R^(n−1) with the reaction of the plane: the nonholonomic system.

Newton's and Euler's equations with the multipliers Λ, eqs. (c1)–(c4), as in `rolling_dynamics`. The
acceleration follows from the *differentiated* constraint (index 1), so v is a state of its own and
the slip

    v − ρ gωγ,   γ = g⁻¹E_n the last row of g,

is a diagnostic: it is constant along the exact flow, for any g and v, but *cubic* in (g, ω, v). So
no Runge–Kutta method keeps it, Gauss neither: it is lost at the order of the method, while g gᵀ,
which is quadratic, is kept by Gauss to round-off. (With Ω = gωg⁻¹ in place of ω the constraint
v = ρΩE_n would be linear, and kept by all of them.) As an action of SO(n) × R^(n−1) × R^(N+n−1) the
rotation acts on g, and (r, ω, v) are moved by translations: then g gᵀ is kept by group methods.

The measure has the density det(I + D pr)^(1/2) in ω, r and the Haar measure of g, on v = ρ gωγ.

E_n is the vertical in space, from the plane to the centre of the ball; r and v have the other n−1
coordinates of space. Gravity and the normal reaction are equal, and go through the centre: they do
not enter, and Λ is the horizontal part (friction). Everything is dimensionless.
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector, part, section

from ..inertia import Inertia, angular_momentum, parameters_of
from ..integrable import inner
from ..literature import BALL
from ..manifold import Array, Arrays, triangle_rows
from ..operators import after, operator_applied
from .angular_velocity import GENERAL, apply_to_gamma, full_omega, log_density_after
from .fields import ball_integrals, ball_parameters
from .path import carried_path
from .rolling_dynamics import (
    contact_observables,
    multiplier_fields,
    rolling_conditions,
    rolling_dynamics,
    rolling_space,
    rolling_work,
)
from .rolling_states import (
    admit_velocity,
    initial_attitude,
    initial_position,
    initial_rolling,
    rolling_scale,
    rolling_velocity,
)


@functools.cache
def through_momentum(observable: Any, full: bool, n: int, rows: Any) -> Any:
    """Return an observable of the ball in (k, γ, g) as one of (g, r, ω, v)."""
    size, square = triangle_rows(n), n * n
    apply_inertia = operator_applied(full, n)
    turning = rolling_space(n).slices["omega"].start

    def through(params, t, y, work):
        z, u = part(work, 0, size + n + square), part(work, size + n + square, n)
        used = size + 2 * n + square
        w = part(y, turning, size)
        for i in range(n):
            z[size + i] = y[square - n + i]
        for i in range(square):
            z[size + n + i] = y[i]
        gamma = part(z, size, n)
        apply_inertia(section(params, rows, "inertia"), w, part(z, 0, size))
        apply_to_gamma(n, w, gamma, u)
        scale = section(section(params, rows, "omega"), GENERAL, "D")[0] / inner(n, gamma, gamma)
        pair = 0
        for i in range(n):
            for j in range(i + 1, n):
                z[pair] += scale * (u[i] * gamma[j] - gamma[i] * u[j])
                pair += 1
        return observable(params, t, z, after(work, used))

    return gi.observable(through)


@functools.cache
def density_in_omega(omega: Any, n: int, rows: Any) -> Any:
    """Return log det(I + D pr)^(1/2): the measure of `momentum` in ω, as dk = det(I + D pr) dω."""
    size, square = triangle_rows(n), n * n
    log_density = log_density_after(omega)
    turning = rolling_space(n).slices["omega"].start

    def rolling_log_density(params, t, y, work):
        gamma, rest = part(y, square - n, n), after(work, size)
        own = section(params, rows, "omega")
        omega(n, own, part(y, turning, size), gamma, part(work, 0, size), rest)
        return -log_density(n, own, gamma, rest)

    return gi.observable(rolling_log_density)


def rolling_problem(inertia: Inertia, m: Any, rho: Any, k0: Any = None) -> gi.Problem:
    """Return the rolling ball on SO(n) × R^(n−1), with the reaction of the plane.

    State: ``g`` (n·n,), the rotation from body to space, row after row; ``r`` (n−1,), the contact
    point in the plane; ``omega`` (n(n−1)/2,), the flat triangle of ω = g⁻¹ġ, body frame; ``v``
    (n−1,), the velocity of the centre, in space. Time t. Forms: ODE and action.
    ``state(g=…, omega=…)``: instead of g (or with it) gamma, which the smallest rotation takes to
    E_n; instead of omega also k, or p or p_tilde for k = γ∧p; r = 0 and v = ρ gωγ unless given.

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
        g that is no rotation, a gamma that is not g⁻¹E_n, a v with which the ball slips.
    """
    n = inertia.n
    size, space = triangle_rows(n), rolling_space(n)
    velocities = gi.Euclidean(size, "omega")
    D = rolling_scale(inertia, m, rho)
    m, rho = float(m), float(rho)
    omega, rows, params = ball_parameters(inertia, D, k0, m, rho)
    dynamics = rolling_dynamics(omega, n, rows)
    forms = multiplier_fields(dynamics, n, rows)

    def reused(observable: Any) -> Any:
        return through_momentum(observable, omega is full_omega, n, rows)

    kept = ball_integrals(n, rows, size, size + n)
    found = {name: reused(observable) for name, observable in kept.invariants.items()}
    constraints = {"rolling": forms["rolling"]}
    if k0 is not None:
        constraints["spatial-momentum"] = reused(kept.spatial_momentum)

    def make_state(
        gamma: Any = None, g: Any = None, r: Any = None, v: Any = None, **components: Any
    ) -> Array:
        vertical, attitude = initial_attitude(gamma, g, n)
        _, w = initial_rolling(inertia, D, vertical, **components)
        velocity = rolling_velocity(rho, attitude, w) if v is None else as_vector("v", v, n - 1)
        return np.concatenate([attitude, initial_position(r, n), w, velocity])

    def admit(y: Array) -> Array:
        parts = space.split(space.admit(y))
        velocity = admit_velocity(parts["v"], rho, parts["g"], parts["omega"])
        return space.join({**parts, "v": velocity})

    def physical(y: Array) -> Arrays:
        parts = space.split(y)
        gamma, w = parts["g"][-n:], parts["omega"]
        return {"gamma": gamma, "k": angular_momentum(inertia, D, gamma, w)}

    return gi.Problem(
        name="rolling-ball",
        equations=(
            "Iω̇ = [Iω, ω] − ρ(g⁻¹Λ)∧γ,  m v̇ = Λ,  ġ = gω,  ṙ = v",
            "v = ρ gωγ,  γ = g⁻¹E_n,  Λ ⟂ E_n",
        ),
        space=space,
        params=params,
        field=forms["field"],
        action=space.action(forms["generator"]),
        work=rolling_work(omega, n),
        invariants={"energy": forms["energy"], **found},
        constraints=constraints,
        measure=gi.Measure(
            density_in_omega(omega, n, rows),
            rolling_conditions(n, rows, False),
            n * (n + 1) // 2 + n - 1,
        ),
        observables=contact_observables(dynamics, n, rows, forms["locate"]),
        make_state=make_state,
        make_path=carried_path(space, rho),
        make_random=(gi.Rotations(n) * velocities * gi.Euclidean(n - 1, "r")).random,
        admit=admit,
        physical=physical,
        parameters={**parameters_of(inertia, D), "m": m, "rho": rho},
        references=BALL,
    )
