"""The rolling ball on SO(n) × R^(n−1) with the reaction of the plane: the nonholonomic system.

Newton's and Euler's equations with the multipliers Λ, eqs. (c1)–(c4), as in `rolling_forms`. The
acceleration follows from the *differentiated* constraint (index 1), so v is a state of its own and
the slip

    v − ρ gωγ,   γ = g⁻¹E_n the last row of g,

is a diagnostic: it is constant along the exact flow, for any g and v, but *cubic* in (g, ω, v). So
no Runge–Kutta method keeps it, Gauss neither: it is lost at the order of the method, while g gᵀ,
which is quadratic, is kept by Gauss to round-off. (With Ω = gωg⁻¹ in place of ω the constraint
v = ρΩE_n would be linear, and kept by all of them.) As an action of SO(n) × R^(n−1) × R^(N+n−1) the
rotation acts on g, and (r, ω, v) are moved by translations: then g gᵀ is kept by group methods.

E_n is the vertical in space, from the plane to the centre of the ball; r and v have the other n−1
coordinates of space. Gravity and the normal reaction are equal, and go through the centre: they do
not enter, and Λ is the horizontal part (friction). Everything is dimensionless.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector, part, sqrt

from ..inertia import GeneralInertia, SpecialInertia, angular_momentum, parameters_of
from ..manifold import Array, admit_frame, skew_components
from .angular_velocity import apply_to_gamma, full_omega
from .momentum import (
    ball_k,
    ball_momentum,
    ball_orthogonality,
    ball_spatial_momentum,
    ball_trace_k4,
)
from .rolling_forms import (
    acceleration,
    contact_observables,
    inertia_applied,
    rolled,
    rolling_parameters,
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

__all__ = ["rolling_problem"]


@functools.cache
def multiplier_forms(omega: Any, n: int, at: int) -> dict[str, Any]:
    """Return field, generator, energy, slip and where things lie; y = (g, r, ω, v)."""
    size, square = n * (n - 1) // 2, n * n
    turning, moving = square + n - 1, square + n - 1 + size  # where ω and v begin
    accelerate = acceleration(omega, n, at)
    apply_inertia = inertia_applied(omega is full_omega, n, at)

    def locate(params: Any, y: Any, work: Any) -> Any:
        """Return blocks (γ, g, ω, r, scratch)."""
        gamma, g = part(y, square - n, n), part(y, 0, square)
        return gamma, g, part(y, turning, size), part(y, square, n - 1), work

    def translate(params: Any, y: Any, out: Any, work: Any) -> None:
        """Write (ṙ, ω̇, v̇)."""
        gamma, g, w = part(y, square - n, n), part(y, 0, square), part(y, turning, size)
        for i in range(n - 1):
            out[i] = y[moving + i]
        dw = part(out, n - 1, size)
        accelerate(params, gamma, w, dw, work)
        rolled(n, params[at], g, gamma, dw, part(out, n - 1 + size, n - 1), work)

    translation = gi.helper(translate)

    def rolling_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        """Eqs. (c1)–(c4) in the body frame."""
        w = part(y, turning, size)
        for row in range(0, square, n):
            apply_to_gamma(n, w, part(y, row, n), part(out, row, n))
            for i in range(row, row + n):
                out[i] = -out[i]
        translation(params, y, part(out, square, len(out) - square), work)

    def rolling_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        """ξ = (−ω, ṙ, ω̇, v̇)."""
        for i in range(size):
            out[i] = -y[turning + i]
        translation(params, y, part(out, size, len(out) - size), work)

    def rolling_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
        """½⟨Iω, ω⟩ + ½m(v, v), eq. (ch-lagr); ½⟨k, ω⟩ where the ball does not slip."""
        w, momentum = part(y, turning, size), part(work, 0, size)
        apply_inertia(params, w, momentum)
        total = momentum[0] * w[0]
        for i in range(1, size):
            total += momentum[i] * w[i]
        for i in range(moving, moving + n - 1):
            total += params[at + 1] * y[i] * y[i]
        return 0.5 * total

    def rolling_slip(params: Any, t: Any, y: Any, work: Any) -> Any:
        """|v − ρ gωγ|, eq. (ch-constr): the speed of the point of the ball in contact."""
        g, w = part(y, 0, square), part(y, turning, size)
        v, rest = part(work, 0, n - 1), part(work, n, n)
        rolled(n, params[at], g, part(y, square - n, n), w, v, rest)
        total = 0.0 * y[0]
        for i in range(n - 1):
            entry = y[moving + i] - v[i]
            total += entry * entry
        return sqrt(total)

    return {
        "field": gi.field(rolling_field),
        "generator": gi.field(rolling_generator),
        "locate": gi.helper(locate),
        "energy": gi.observable(rolling_energy),
        "rolling": gi.observable(rolling_slip),
    }


@functools.cache
def through_momentum(observable: Any, full: bool, n: int, at: int) -> Any:
    """Return an observable of the ball in (k, γ, g) as one of (g, r, ω, v)."""
    size, square = n * (n - 1) // 2, n * n
    apply_inertia = inertia_applied(full, n, at)

    def through(params: Any, t: Any, y: Any, work: Any) -> Any:
        z, u = part(work, 0, size + n + square), part(work, size + n + square, n)
        used = size + 2 * n + square
        w = part(y, square + n - 1, size)
        for i in range(n):
            z[size + i] = y[square - n + i]
        for i in range(square):
            z[size + n + i] = y[i]
        gamma = part(z, size, n)
        apply_inertia(params, w, part(z, 0, size))
        apply_to_gamma(n, w, gamma, u)
        length = gamma[0] * gamma[0]
        for i in range(1, n):
            length += gamma[i] * gamma[i]
        scale = params[1] / length
        pair = 0
        for i in range(n):
            for j in range(i + 1, n):
                z[pair] = z[pair] + scale * (u[i] * gamma[j] - gamma[i] * u[j])
                pair += 1
        return observable(params, t, z, part(work, used, len(work) - used))

    return gi.observable(through)


def rolling_problem(
    inertia: SpecialInertia | GeneralInertia, m: Any, rho: Any, k0: Any = None
) -> gi.Problem:
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
    size, square = n * (n - 1) // 2, n * n
    D = rolling_scale(inertia, m, rho)
    m, rho = float(m), float(rho)
    omega, params, at = rolling_parameters(inertia, D, m, rho)
    forms = multiplier_forms(omega, n, at)

    def reused(observable: Any) -> Any:
        return through_momentum(observable, omega is full_omega, n, at)

    invariants = {"energy": forms["energy"], "K": reused(ball_k)}
    if n > 2:
        invariants["momentum"] = reused(ball_momentum)
    if n > 3:
        invariants["trace-k4"] = reused(ball_trace_k4)
    constraints = {"rolling": forms["rolling"], "orthogonality": reused(ball_orthogonality)}
    if k0 is not None:
        params = np.concatenate([params, skew_components("k0", k0, n)])
        constraints["spatial-momentum"] = reused(ball_spatial_momentum)

    def make_state(
        gamma: Any = None, g: Any = None, r: Any = None, v: Any = None, **components: Any
    ) -> Array:
        vertical, attitude = initial_attitude(gamma, g, n)
        _, w = initial_rolling(inertia, D, vertical, **components)
        velocity = rolling_velocity(rho, attitude, w) if v is None else as_vector("v", v, n - 1)
        return np.concatenate([attitude, initial_position(r, n), w, velocity])

    def admit(y: Array) -> Array:
        w = y[square + n - 1 : square + n - 1 + size]
        g = admit_frame(y[:square], n)
        v = admit_velocity(y[square + n - 1 + size :], rho, g, w)
        return np.concatenate([g, y[square : square + n - 1], w, v])

    def physical(y: Array) -> dict[str, Array]:
        gamma, w = np.array(y[square - n : square]), y[square + n - 1 : square + n - 1 + size]
        return {"gamma": gamma, "k": angular_momentum(inertia, D, gamma, w)}

    return gi.Problem(
        name="rolling-ball",
        pieces=(("g", square), ("r", n - 1), ("omega", size), ("v", n - 1)),
        params=params,
        field=forms["field"],
        action=gi.GroupAction(
            forms["generator"], gi.so_n(n, "frame", translations=size + 2 * (n - 1))
        ),
        work=rolling_work(omega, n),
        invariants=invariants,
        constraints=constraints,
        observables=contact_observables(omega, n, at, forms["locate"]),
        make_state=make_state,
        admit=admit,
        physical=physical,
        parameters={**parameters_of(inertia, D), "m": m, "rho": rho},
    )
