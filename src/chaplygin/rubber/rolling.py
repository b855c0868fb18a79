"""The rubber ball on SO(n) × R^(n−1) with the reactions of the plane: no slip and no twist.

Beside v = ρ gωγ, eq. (ch-constr), the ball may not turn about the vertical: (gωgᵀ)_pq = 0 for
p < q < n, the remark before eq. (c1), or ω ∈ R^n∧γ. So pr ω = ω, and with the torque τ of the plane

    (I + D) ω̇ = [Iω, ω] + Σ τ_pq e_p∧e_q,   ⟨ω̇, e_p∧e_q⟩ = 0,   p < q < n,

e_p row p of g: the Veselova problem with r = 1 and the operator I + D. The reaction is Λ = mρ gω̇γ. As
in `chaplygin.ball.rolling` the acceleration is that of the *differentiated* constraints, slip and
twist are diagnostics, and rotations act on g, translations on (r, ω, v).

The part of (I + D)ω in R^n∧γ is constant in space. The measure has the density
det(pr (I + D)|_{R^n∧γ})^(1/2) in ω, r and the Haar measure of g.
"""

import functools
from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import as_vector, part, section, sqrt

from ..ball.angular_velocity import about_vertical, apply_to_gamma
from ..ball.fields import turn
from ..ball.path import carried_path
from ..ball.rolling_dynamics import (
    RollingDynamics,
    contact_observables,
    multiplier_fields,
    rolling_conditions,
    rolling_space,
)
from ..ball.rolling_states import (
    admit_velocity,
    initial_attitude,
    initial_position,
    rolling_velocity,
)
from ..inertia import GeneralInertia, Inertia, operator_parameters
from ..integrable import inner
from ..literature import RUBBER
from ..manifold import Array, Arrays, Named, triangle_rows
from ..operators import after, in_two, operator_applied, operator_entries
from ..veselova.bound_velocity import (
    BOUND,
    bound_parameters,
    bound_velocity,
    bound_work,
    log_determinant,
)
from ..veselova.stiefel_states import allowed_part, bound_solution, initial_bound, only_allowed

Rubber = namedtuple("Rubber", "bound rho m inertia")


@functools.cache
def rubber_dynamics(full: bool, n: int, rows: Rubber) -> RollingDynamics:
    """Return acceleration and inertia; parameters are those of `bound_velocity` for I + D, ρ, m, I."""
    size = triangle_rows(n)
    apply_inertia = operator_applied(full, n)
    solve = bound_velocity(full, n, 1)

    def accelerate(params, gamma, w, out, work):
        momentum, torque, rest = in_two(work, size)
        apply_inertia(section(params, rows, "inertia"), w, momentum)
        turn(n, w, momentum, torque, rest)
        solve(section(params, rows, "bound"), torque, gamma, out, rest)

    return RollingDynamics(gi.helper(accelerate), apply_inertia)


@functools.cache
def rubber_forms(full: bool, n: int, rows: Rubber) -> Named:
    """Return K, the twist, its torque and log of the density; y = (g, r, ω, v)."""
    size, square = triangle_rows(n), n * n
    turning = rolling_space(n).slices["omega"].start
    dynamics = rubber_dynamics(full, n, rows)
    apply = operator_applied(full, n)

    def total_of(params):
        """Return the block of the entries of I + D."""
        return section(section(params, rows, "bound"), BOUND, "inertia")

    total_inertia = gi.helper(total_of)

    def rubber_k(params, t, y, work):
        """K = |pr (I + D)ω|² = |((I + D)ω)γ|²."""
        moment, image = part(work, 0, size), part(work, size, n)
        apply(total_inertia(params), part(y, turning, size), moment)
        apply_to_gamma(n, moment, part(y, square - n, n), image)
        return inner(n, image, image)

    def rubber_twist(params, t, y, work):
        """Return the length of the part of ω about the vertical."""
        return sqrt(about_vertical(n, part(y, turning, size), part(y, square - n, n), work))

    def rubber_torque(params, t, y, work):
        """Return the length of (I + D)ω̇ − [Iω, ω], the torque that keeps the ball from twisting."""
        rate, left = part(work, 0, size), part(work, size, size)
        torque, rest = part(work, 2 * size, size), after(work, 3 * size)
        w = part(y, turning, size)
        dynamics.accelerate(params, part(y, square - n, n), w, rate, rest)
        dynamics.apply_inertia(section(params, rows, "inertia"), w, left)
        turn(n, w, left, torque, rest)
        apply(total_inertia(params), rate, left)
        for i in range(size):
            left[i] -= torque[i]
        return sqrt(about_vertical(n, left, part(y, square - n, n), rest))

    def rubber_log_density(params, t, y, work):
        """Return ½ log det(pr (I + D)|_{R^n∧γ})."""
        rate, rest = part(work, 0, size), after(work, 2 * size)
        w = part(y, turning, size)
        dynamics.accelerate(params, part(y, square - n, n), w, rate, rest)
        return 0.5 * log_determinant(n, after(rest, 2 * size))

    return {
        "K": gi.observable(rubber_k),
        "twist": gi.observable(rubber_twist),
        "torque": gi.observable(rubber_torque),
        "log_density": gi.observable(rubber_log_density),
    }


def rubber_rolling_problem(
    inertia: Inertia, total: GeneralInertia, m: float, rho: float
) -> gi.Problem:
    """Return the rubber ball on SO(n) × R^(n−1), with the reactions of the plane.

    State: ``g`` (n·n,), the rotation from body to space, row after row; ``r`` (n−1,), the contact
    point in the plane; ``omega`` (n(n−1)/2,), the flat triangle of ω = g⁻¹ġ, body frame; ``v``
    (n−1,), the velocity of the centre, in space. Time t. Forms: ODE and action.
    ``state(g=…, omega=…)``: instead of g (or with it) gamma, which the smallest rotation takes to
    E_n; instead of omega also k = γ∧p or p; r = 0 and v = ρ gωγ unless given.

    Parameters
    ----------
    inertia : SpecialInertia or GeneralInertia
        I, about the centre.
    total : GeneralInertia
        I + D.
    m, rho : float
        Mass and radius, mρ² = D.

    Raises
    ------
    geomint.DomainError
        From ``state`` and ``canonical``: a g that is no rotation, a gamma that is not g⁻¹E_n, an
        omega with which the ball twists, a v with which it slips.
    """
    n = inertia.n
    size, square, space = triangle_rows(n), n * n, rolling_space(n)
    full, bound = bound_parameters(total)
    kept_full, entries = operator_entries(inertia)
    if full != kept_full:
        entries = np.diag(entries).reshape(-1)
    rows = Rubber(bound=len(bound), rho=1, m=1, inertia=len(entries))
    dynamics, own = rubber_dynamics(full, n, rows), rubber_forms(full, n, rows)
    forms = multiplier_fields(dynamics, n, rows)

    def make_state(
        gamma: Any = None, g: Any = None, r: Any = None, v: Any = None, **components: Any
    ) -> Array:
        vertical, attitude = initial_attitude(gamma, g, n)
        k, w = initial_bound(total, vertical, "omega", **components)
        w = bound_solution(total, vertical[None], k) if w is None else w
        velocity = rolling_velocity(rho, attitude, w) if v is None else as_vector("v", v, n - 1)
        return np.concatenate([attitude, initial_position(r, n), w, velocity])

    def make_random(rng: np.random.Generator) -> Named:
        g = gi.Rotations(n).random(rng)["g"]
        p = gi.Sphere(n).tangent(g[-n:], rng.normal(size=n))
        return {"g": g, "p": p, "r": rng.normal(size=n - 1)}

    def admit(y: Array) -> Array:
        parts = space.split(space.admit(y))
        w = only_allowed(parts["g"][None, -n:], parts["omega"], "omega", "gamma")
        velocity = admit_velocity(parts["v"], rho, parts["g"], w)
        return space.join({**parts, "omega": w, "v": velocity})

    def physical(y: Array) -> Arrays:
        parts = space.split(y)
        gamma, moment = parts["g"][-n:], total.apply(parts["omega"])
        return {"gamma": gamma, "k": allowed_part(gamma[None], moment)}

    constraints = {"rolling": forms["rolling"]}
    if n > 2:
        constraints["twist"] = own["twist"]
    observables = contact_observables(dynamics, n, rows, forms["locate"])
    observables.pop("pivoting", None)  # which is the twist
    return gi.Problem(
        name="rubber-ball-rolling",
        equations=(
            "(I + D)ω̇ = [Iω, ω] + Σ τ_pq e_p∧e_q,  ġ = gω,  ṙ = v",
            "v = ρ gωγ,  ⟨ω, e_p∧e_q⟩ = 0 for p < q < n,  e_p row p of g",
        ),
        space=space,
        params=gi.packed(rows, bound=bound, rho=rho, m=m, inertia=entries).data,
        field=forms["field"],
        action=space.action(forms["generator"]),
        work=7 * size + 2 * n + max(2 * square, bound_work(n, 1)),
        invariants={"energy": forms["energy"], "K": own["K"]},
        constraints=constraints,
        observables={**observables, "torque": own["torque"]} if n > 2 else observables,
        measure=gi.Measure(
            own["log_density"],
            rolling_conditions(n, rows, True),
            n * (n + 1) // 2 + n - 1 + (n - 1) * (n - 2) // 2,
        ),
        make_state=make_state,
        make_random=make_random,
        make_path=carried_path(space, rho),
        admit=admit,
        physical=physical,
        parameters={**operator_parameters(inertia), "m": m, "rho": rho},
        references=RUBBER,
    )
