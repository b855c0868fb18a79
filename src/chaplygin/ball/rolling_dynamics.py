"""What the two forms of the rolling ball share: acceleration, reaction, speed of the contact point.

With γ = g⁻¹E_n the motion with the reaction Λ ∈ R^(n−1) of the plane, Λ ⟂ E_n, is

    Iω̇ = [Iω, ω] − ρ (g⁻¹Λ)∧γ,   m v̇ = Λ,   ġ = gω,   ṙ = v,

eqs. (c1)–(c4) in the body frame (the torque of a force F at x is F∧x; here x = −ρE_n), under
v = ρ gωγ, eq. (ch-constr). Its derivative, v̇ = ρ gω̇γ, gives

    Λ = mρ gω̇γ,   Iω̇ + D(ω̇γγᵀ + γγᵀω̇) = [Iω, ω],   D = mρ²:

the equation that `angular_velocity` solves, with [Iω, ω] for k. No other linear system is needed.

The functions are made for each n and layout of the parameters, which has parts rho, m and inertia; see
`fields`.

Of the form with multipliers, (g, r, ω, v), here is all that does not depend on what decides the
acceleration (`RollingDynamics`): see `rolling` for the equations.
"""

import functools
from typing import Any, NamedTuple

import geomint as gi
from geomint import part, section, sqrt

from ..integrable import inner
from ..manifold import Named, triangle_rows
from ..operators import after, in_two, operator_applied
from .angular_velocity import about_vertical, apply_to_gamma, full_omega, omega_work
from .fields import opposite, turn, turn_vectors


def rolling_work(omega: Any, n: int) -> int:
    """Rows of scratch that the functions of both forms need."""
    size = triangle_rows(n)
    return 4 * size + 2 * n + n * n + max(2 * n * n, omega_work(omega, n))


@gi.helper
def distance(n, x, z):
    """Return |x − z| over n rows."""
    total = 0.0 * x[0]
    for i in range(n):
        entry = x[i] - z[i]
        total += entry * entry
    return sqrt(total)


@gi.helper
def rolled(n, rho, g, gamma, w, out, work):
    """Write the n−1 horizontal components of ρ gwγ: v for w = ω, v̇ for w = ω̇."""
    u = part(work, 0, n)
    apply_to_gamma(n, w, gamma, u)
    for i in range(n - 1):
        out[i] = rho * inner(n, part(g, i * n, n), u)


class RollingDynamics(NamedTuple):
    """What a ball's way of rolling decides.

    accelerate : recorded ``f(params, gamma, w, out, work)``
        Writes ω̇ from ω = w.
    apply_inertia : recorded ``f(entries, w, out)``
        Writes Iw, of the part "inertia" of the parameters.
    """

    accelerate: Any
    apply_inertia: Any


@functools.cache
def rolling_dynamics(omega: Any, n: int, rows: Any) -> RollingDynamics:
    """Return those of the ball that may turn about the vertical; see the module's docstring."""
    size = triangle_rows(n)
    apply_inertia = operator_applied(omega is full_omega, n)

    def accelerate(params, gamma, w, out, work):
        momentum, torque, rest = in_two(work, size)
        apply_inertia(section(params, rows, "inertia"), w, momentum)
        turn(n, w, momentum, torque, rest)
        omega(n, section(params, rows, "omega"), torque, gamma, out, rest)

    return RollingDynamics(gi.helper(accelerate), apply_inertia)


@functools.cache
def contact_observables(dynamics: RollingDynamics, n: int, rows: Any, locate: Any) -> Named:
    r"""Return the observables that both forms have, by name.

    * ``contact-i``, i = 1 … n−1: the component r_i of the contact point;
    * ``reaction-i``: the component Λ_i of the reaction, in space; ``reaction``: \|Λ\|;
    * ``power``: (Λ, v), at which energy goes from turning to travelling: the whole reaction does no
      work, because the point where it acts is at rest;
    * ``speed``: \|v\| = ρ\|ωγ\|;
    * ``pivoting``, n > 2: the length of the part of ω that fixes γ, \|(ω⃗, γ⃗)\| at n = 3.

    Parameters
    ----------
    dynamics
    n
    rows : named tuple
        The layout of the parameters, with parts rho and m.
    locate : recorded ``f(params, y, work) -> (gamma, g, w, r, rest)``
        Where these lie, w being ω and `rest` what is left of the scratch.
    """
    size = triangle_rows(n)
    accelerate = dynamics.accelerate

    def react(params, y, work):
        gamma, g, w, _, rest = locate(params, y, work)
        dw, force = part(rest, 0, size), part(rest, size, n - 1)
        left = after(rest, size + n)
        accelerate(params, gamma, w, dw, left)
        mass = section(params, rows, "m")[0] * section(params, rows, "rho")[0]
        rolled(n, mass, g, gamma, dw, force, left)
        return gamma, g, w, force, left

    reaction_of = gi.helper(react)

    def component(i: int) -> Any:
        def reaction(params, t, y, work):
            _, _, _, force, _ = reaction_of(params, y, work)
            return force[i]

        return gi.observable(reaction)

    def position(i: int) -> Any:
        def contact(params, t, y, work):
            _, _, _, r, _ = locate(params, y, work)
            return r[i]

        return gi.observable(contact)

    def reaction_size(params, t, y, work):
        _, _, _, force, _ = reaction_of(params, y, work)
        return sqrt(inner(n - 1, force, force))

    def power(params, t, y, work):
        gamma, g, w, force, rest = reaction_of(params, y, work)
        v = part(rest, n, n)
        rolled(n, section(params, rows, "rho")[0], g, gamma, w, v, rest)
        return inner(n - 1, force, v)

    def speed(params, t, y, work):
        gamma, _, w, _, rest = locate(params, y, work)
        apply_to_gamma(n, w, gamma, rest)
        return section(params, rows, "rho")[0] * sqrt(inner(n, rest, rest))

    def pivoting(params, t, y, work):
        gamma, _, w, _, rest = locate(params, y, work)
        return sqrt(about_vertical(n, w, gamma, rest))

    found = {f"contact-{i + 1}": position(i) for i in range(n - 1)}
    found |= {f"reaction-{i + 1}": component(i) for i in range(n - 1)}
    found |= {"reaction": gi.observable(reaction_size), "power": gi.observable(power)}
    found["speed"] = gi.observable(speed)
    if n > 2:
        found["pivoting"] = gi.observable(pivoting)
    return found


def rolling_space(n: int) -> gi.Space:
    """Return SO(n) × R^(n−1) with velocities: (g, r, ω, v)."""
    motions = gi.Rotations(n) * gi.Euclidean(n - 1, "r")
    return motions * gi.Euclidean(triangle_rows(n), "omega") * gi.Euclidean(n - 1, "v")


@functools.cache
def multiplier_fields(dynamics: RollingDynamics, n: int, rows: Any) -> Named:
    """Return field, generator, energy, slip and where things lie; y = (g, r, ω, v)."""
    size, square = triangle_rows(n), n * n
    slices = rolling_space(n).slices
    turning, moving = slices["omega"].start, slices["v"].start
    accelerate, apply_inertia = dynamics

    def locate(params, y, work):
        """Return blocks (γ, g, ω, r, scratch)."""
        gamma, g = part(y, square - n, n), part(y, 0, square)
        return gamma, g, part(y, turning, size), part(y, square, n - 1), work

    def translate(params, y, out, work):
        """Write (ṙ, ω̇, v̇)."""
        gamma, g, w = part(y, square - n, n), part(y, 0, square), part(y, turning, size)
        for i in range(n - 1):
            out[i] = y[moving + i]
        dw = part(out, n - 1, size)
        accelerate(params, gamma, w, dw, work)
        rolled(
            n, section(params, rows, "rho")[0], g, gamma, dw, part(out, n - 1 + size, n - 1), work
        )

    translation = gi.helper(translate)

    def rolling_field(params, t, y, out, work):
        """Eqs. (c1)–(c4) in the body frame."""
        w = part(y, turning, size)
        turn_vectors(n, w, part(y, 0, square), part(out, 0, square), work)
        translation(params, y, after(out, square), work)

    def rolling_generator(params, t, y, out, work):
        """ξ = (−ω, ṙ, ω̇, v̇)."""
        opposite(size, part(y, turning, size), out)
        translation(params, y, after(out, size), work)

    def rolling_energy(params, t, y, work):
        """½⟨Iω, ω⟩ + ½m(v, v), eq. (ch-lagr); ½⟨k, ω⟩ where the ball does not slip."""
        w, momentum = part(y, turning, size), part(work, 0, size)
        apply_inertia(section(params, rows, "inertia"), w, momentum)
        mass = section(params, rows, "m")
        total = inner(size, momentum, w)
        for i in range(moving, moving + n - 1):
            total += mass[0] * y[i] * y[i]
        return 0.5 * total

    def rolling_slip(params, t, y, work):
        """|v − ρ gωγ|, eq. (ch-constr): the speed of the point of the ball in contact."""
        g, w = part(y, 0, square), part(y, turning, size)
        v, rest = part(work, 0, n - 1), part(work, n, n)
        rolled(n, section(params, rows, "rho")[0], g, part(y, square - n, n), w, v, rest)
        return distance(n - 1, part(y, moving, n - 1), v)

    return {
        "field": gi.field(rolling_field),
        "generator": gi.field(rolling_generator),
        "locate": gi.helper(locate),
        "energy": gi.observable(rolling_energy),
        "rolling": gi.observable(rolling_slip),
    }


@functools.cache
def rolling_conditions(n: int, rows: Any, twist_free: bool) -> Any:
    """Return the function that writes g gᵀ − 1, v − ρ gωγ and, if `twist_free`, (gωgᵀ)_pq, p < q < n.

    `rows` is the layout of the parameters; y = (g, r, ω, v).
    """
    size, square = triangle_rows(n), n * n
    rotation, slipping = gi.Rotations(n).manifold_at(0), gi.Rotations(n).conditions
    slices = rolling_space(n).slices
    turning, moving = slices["omega"].start, slices["v"].start

    def conditions(params, t, y, out, work):
        rotation(params, t, y, out, work)
        g, w = part(y, 0, square), part(y, turning, size)
        v = part(out, slipping, n - 1)
        rolled(n, section(params, rows, "rho")[0], g, part(y, square - n, n), w, v, work)
        for i in range(n - 1):
            v[i] = y[moving + i] - v[i]
        if twist_free:
            entry, image = slipping + n - 1, part(work, 0, n)
            for q in range(1, n - 1):
                apply_to_gamma(n, w, part(y, q * n, n), image)
                for p in range(q):
                    out[entry] = inner(n, part(y, p * n, n), image)
                    entry += 1

    return gi.field(conditions)
