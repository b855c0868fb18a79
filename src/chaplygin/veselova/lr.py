"""The Veselova problem on SO(n) for any r, with its multipliers: a nonholonomic LR system.

A rigid body with left-invariant kinetic energy turns so that its angular velocity in space lies in
𝔡 = span{E_i∧E_j, i ≤ r}, eq. (VC): the reactions act in the planes of the other vectors,

    𝓘ẇ = [𝓘w, w] + Σ λ_pq e_p∧e_q,   ⟨w, e_p∧e_q⟩ = 0,   r < p < q ≤ n,   ġ = gw,

eqs. (PoissonV), (VFK) with their indices as they must be. e_i = g⁻¹E_i is row i of g. The acceleration
follows from the *differentiated* constraint ⟨ẇ, e_p∧e_q⟩ = 0: it is the ẇ in span{e_s∧R^n} whose 𝓘ẇ has
there the part of [𝓘w, w] (`bound_velocity`), and the multipliers are what is left,

    λ_pq = ⟨𝓘ẇ − [𝓘w, w], e_p∧e_q⟩.

So ⟨w, e_p∧e_q⟩ is a diagnostic: constant along the exact flow, cubic in (g, w). The part of Ad_g 𝓘w in
𝔡 is constant, by d'Alembert's principle. As an action of SO(n) × R^N rotations act on g, and w is
moved by translations.

The density of the measure, in w on the constraint and the Haar measure of g, is det(pr_𝔡 𝓘|_𝔡)^(1/2).
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import part, section, sqrt

from ..ball.angular_velocity import apply_to_gamma
from ..ball.fields import opposite, turn, turn_vectors
from ..inertia import Inertia, operator_parameters
from ..initial_states import one_of
from ..integrable import inner
from ..literature import VESELOVA
from ..manifold import Array, Arrays, Named, skew_components, triangle_rows
from ..operators import after, in_two, operator_applied
from .bound_velocity import BOUND, bound_parameters, bound_velocity, bound_work, log_determinant
from .stiefel import frame_count
from .stiefel_states import allowed_part, bound_solution, only_allowed

SHOWN = 6  # multipliers up to which each is an observable of its own


@functools.cache
def lr_forms(full: bool, n: int, r: int) -> Named:
    """Return the functions of a body; y = (g, w)."""
    size, square, rows = triangle_rows(n), n * n, n * r
    solve = bound_velocity(full, n, r)
    apply = operator_applied(full, n)

    def accelerate(params, y, out, work):
        """Write ẇ, and return blocks ([𝓘w, w], scratch of the solve)."""
        moment, torque, rest = in_two(work, size)
        w = part(y, square, size)
        apply(section(params, BOUND, "inertia"), w, moment)
        turn(n, w, moment, torque, rest)
        solve(params, torque, part(y, 0, rows), out, rest)
        return torque, rest

    accelerated = gi.helper(accelerate)

    def react(params, y, work):
        """Return the block 𝓘ẇ − [𝓘w, w], a flat triangle, and scratch."""
        rate, left, rest = in_two(work, size)
        torque, _ = accelerated(params, y, rate, rest)
        apply(section(params, BOUND, "inertia"), rate, left)
        for i in range(size):
            left[i] -= torque[i]
        return left, after(work, 4 * size)

    reacted = gi.helper(react)

    def lr_field(params, t, y, out, work):
        """Eqs. (PoissonV), (VFK)."""
        w = part(y, square, size)
        turn_vectors(n, w, part(y, 0, square), part(out, 0, square), work)
        accelerated(params, y, part(out, square, size), work)

    def lr_generator(params, t, y, out, work):
        """ξ = (−w, ẇ)."""
        opposite(size, part(y, square, size), out)
        accelerated(params, y, part(out, size, size), work)

    def lr_energy(params, t, y, work):
        """½⟨𝓘w, w⟩."""
        w, moment = part(y, square, size), part(work, 0, size)
        apply(section(params, BOUND, "inertia"), w, moment)
        return 0.5 * inner(size, moment, w)

    def lr_log_density(params, t, y, work):
        """Return ½ log det(pr_𝔡 𝓘|_𝔡)."""
        _, rest = accelerated(params, y, part(work, 0, size), after(work, size))
        return 0.5 * log_determinant(rows, rest)

    def component(p: int, q: int) -> Any:
        def multiplier(params, t, y, work):
            left, rest = reacted(params, y, work)
            return in_plane(n, left, part(y, p * n, n), part(y, q * n, n), rest)

        return gi.observable(multiplier)

    def multiplier_size(params, t, y, work):
        """Return the length of Σ λ_pq e_p∧e_q."""
        left, rest = reacted(params, y, work)
        return size_in_planes(n, r, left, part(y, 0, square), rest)

    def forbidden(params, t, y, work):
        """Return the length of the part of w that the constraint forbids, eq. (VC)."""
        return size_in_planes(n, r, part(y, square, size), part(y, 0, square), work)

    def momentum(i: int, j: int) -> Any:
        def spatial_momentum(params, t, y, work):
            moment, rest = part(work, 0, size), part(work, size, n)
            apply(section(params, BOUND, "inertia"), part(y, square, size), moment)
            return in_plane(n, moment, part(y, i * n, n), part(y, j * n, n), rest)

        return gi.observable(spatial_momentum)

    planes = [(p, q) for p in range(r, n) for q in range(p + 1, n)]
    shown = planes if len(planes) <= SHOWN else []
    return {
        "field": gi.field(lr_field),
        "generator": gi.field(lr_generator),
        "energy": gi.observable(lr_energy),
        "log_density": gi.observable(lr_log_density),
        "forbidden": gi.observable(forbidden),
        "momenta": {
            f"momentum-{i + 1}-{j + 1}": momentum(i, j) for i in range(r) for j in range(i + 1, n)
        },
        "multipliers": {
            "multipliers": gi.observable(multiplier_size),
            **{f"multiplier-{p + 1}-{q + 1}": component(p, q) for p, q in shown},
        },
    }


@gi.helper
def in_plane(n, triangle, u, v, work):
    """Return ⟨X, u∧v⟩ = (u, Xv)."""
    image = part(work, 0, n)
    apply_to_gamma(n, triangle, v, image)
    return inner(n, u, image)


@gi.helper
def size_in_planes(n, r, triangle, g, work):
    """Return the square root of the sum of all ⟨X, e_p∧e_q⟩², r < p < q."""
    total = 0.0 * triangle[0]
    for p in range(r, n):
        for q in range(p + 1, n):
            entry = in_plane(n, triangle, part(g, p * n, n), part(g, q * n, n), work)
            total += entry * entry
    return sqrt(total)


@functools.cache
def lr_conditions(n: int, r: int) -> Any:
    """Return the function that writes g gᵀ − 1 and the ⟨w, e_p∧e_q⟩."""
    rotation, square = gi.Rotations(n).manifold_at(0), n * n
    size, first = triangle_rows(n), n * (n + 1) // 2

    def conditions(params, t, y, out, work):
        rotation(params, t, y, out, work)
        at = first
        w = part(y, square, size)
        for p in range(r, n):
            for q in range(p + 1, n):
                out[at] = in_plane(n, w, part(y, p * n, n), part(y, q * n, n), work)
                at += 1

    return gi.field(conditions)


def lr_problem(inertia: Inertia, r: Any = 1) -> gi.Problem:
    """Return the Veselova problem on SO(n), with its multipliers.

    State: ``g`` (n·n,), the rotation from body to space, row after row, and ``w`` (n(n−1)/2,), the
    flat triangle of g⁻¹ġ, body frame. Time t. Forms: ODE and action of SO(n) × R^N.
    ``state(g=…, w=…)``; g = 1 unless given; instead of w also k, the part of 𝓘w in span{e_s∧R^n}.
    Observables: "multipliers", the length of Σ λ_pq e_p∧e_q, and where they are few, "multiplier-p-q".

    Parameters
    ----------
    inertia : SpecialInertia or GeneralInertia
        𝓘, any symmetric positive definite operator on so(n).
    r : int
        1 ≤ r ≤ n − 1; r = n − 1 leaves the body free.

    Raises
    ------
    geomint.DomainError
        For another r; from ``state`` and ``canonical`` for a g that is no rotation, and a w that
        the constraint forbids.
    """
    n = inertia.n
    count = frame_count(r, n)
    size, square = triangle_rows(n), n * n
    space = gi.Rotations(n) * gi.Euclidean(size, "w")
    full, params = bound_parameters(inertia)
    forms = lr_forms(full, n, count)
    bound = (n - count) * (n - count - 1) // 2

    def make_state(g: Any = None, **components: Any) -> Array:
        attitude = gi.Rotations(n).point(g)
        X = attitude.reshape(n, n)[:count]
        name = one_of(components, ("w", "k"))
        inside = only_allowed(X, skew_components(name, components[name], n), name)
        w = inside if name == "w" else bound_solution(inertia, X, inside)
        return np.concatenate([attitude, w])

    def make_random(rng: np.random.Generator) -> Named:
        parts = space.random(rng)
        return {**parts, "w": allowed_part(parts["g"].reshape(n, n)[:count], parts["w"])}

    def admit(y: Array) -> Array:
        parts = space.split(space.admit(y))
        inside = only_allowed(parts["g"].reshape(n, n)[:count], parts["w"], "w")
        return space.join({**parts, "w": inside})

    def physical(y: Array) -> Arrays:
        X = y[: count * n].reshape(count, n)
        k = allowed_part(X, inertia.apply(y[square:]))
        return {"gamma" if count == 1 else "X": np.array(y[: count * n]), "k": k}

    return gi.Problem(
        name="veselova-lr",
        equations=(
            "𝓘ẇ = [𝓘w, w] + Σ λ_pq e_p∧e_q,  ġ = gw",
            "⟨w, e_p∧e_q⟩ = 0 for r < p < q ≤ n,  e_i row i of g",
        ),
        space=space,
        params=params,
        field=forms["field"],
        action=space.action(forms["generator"]),
        work=4 * size + max(2 * square, bound_work(n, count)) + n,
        invariants={"energy": forms["energy"], **forms["momenta"]},
        constraints={"forbidden": forms["forbidden"]} if bound else {},
        observables=forms["multipliers"] if bound else {},
        measure=gi.Measure(forms["log_density"], lr_conditions(n, count), n * (n + 1) // 2 + bound),
        make_state=make_state,
        make_random=make_random,
        admit=admit,
        physical=physical,
        parameters={**operator_parameters(inertia), "r": count},
        references=VESELOVA,
    )
