"""What the two forms of the rolling ball share: acceleration, reaction, speed of the contact point.

With γ = g⁻¹E_n the motion with the reaction Λ ∈ R^(n−1) of the plane, Λ ⟂ E_n, is

    Iω̇ = [Iω, ω] − ρ (g⁻¹Λ)∧γ,   m v̇ = Λ,   ġ = gω,   ṙ = v,

eqs. (c1)–(c4) in the body frame (the torque of a force F at x is F∧x; here x = −ρE_n), under
v = ρ gωγ, eq. (ch-constr). Its derivative, v̇ = ρ gω̇γ, gives

    Λ = mρ gω̇γ,   Iω̇ + D(ω̇γγᵀ + γγᵀω̇) = [Iω, ω],   D = mρ²:

the equation that `angular_velocity` solves, with [Iω, ω] for k. No other linear system is needed.

The functions are made for each n and layout of the parameters, which has parts rho, m and inertia; see
`fields`.
"""

import functools
from typing import Any, NamedTuple

import geomint as gi
from geomint import part, section, sqrt

from ..integrable import inner
from ..operators import operator_applied
from .angular_velocity import about_vertical, apply_to_gamma, full_omega, omega_work
from .fields import turn


def rolling_work(omega: Any, n: int) -> int:
    """Rows of scratch that the functions of both forms need."""
    size = n * (n - 1) // 2
    return 4 * size + 2 * n + n * n + max(2 * n * n, omega_work(omega, n))


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
    size = n * (n - 1) // 2
    apply_inertia = operator_applied(omega is full_omega, n)

    def accelerate(params, gamma, w, out, work):
        momentum, torque = part(work, 0, size), part(work, size, size)
        rest = part(work, 2 * size, len(work) - 2 * size)
        apply_inertia(section(params, rows, "inertia"), w, momentum)
        turn(n, w, momentum, torque, rest)
        omega(n, section(params, rows, "omega"), torque, gamma, out, rest)

    return RollingDynamics(gi.helper(accelerate), apply_inertia)


@functools.cache
def contact_observables(
    dynamics: RollingDynamics, n: int, rows: Any, locate: Any
) -> dict[str, Any]:
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
    size = n * (n - 1) // 2
    accelerate = dynamics.accelerate

    def react(params, y, work):
        gamma, g, w, _, rest = locate(params, y, work)
        dw, force = part(rest, 0, size), part(rest, size, n - 1)
        left = part(rest, size + n, len(rest) - size - n)
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
