"""The Veselova problem for any r, reduced to T*V(n, r), eq. (dot_P): Theorem 7 of the paper.

X = (e_1, …, e_r) are the first vectors of the frame that is fixed in space, seen from the body, and P
the momenta, XᵀX = 1, XᵀP + PᵀX = 0, eq. (condX). With the part of the momentum 𝓘w along the allowed
planes, k = Σ e_s∧p_s = XPᵀ − PXᵀ (the correction in the remark after the theorem),

    Ẋ = −wX,   Ṗ = −wP,   w = Φ_r(X, Ẋ(X, P)) ∈ span{e_s∧R^n},

and w follows from k by a linear system (`bound_velocity`): the momentum (dotX->P) inverted. All of k
is constant in space, and all 2r vectors turn with −w: SO(n) acts on the state, group methods keep the
Gram matrix of (X, P) to round-off. Its entries are the conditions of T*V(n, r), and the integrals
(e_s, p_t), s < t, and (p_s, p_t).

The density of the measure by the symplectic volume of T*V(n, r) is det(pr_𝔡 𝓘|_𝔡)^(−1/2).
At r = 1 this is the system on T*S^(n−1) for *any* inertia operator, with γ = e_1 and p.
"""

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import part
from geomint.arguments import whole
from geomint.problems.spaces.sphere import product

from ..ball.angular_velocity import wedge_sum
from ..ball.fields import BallForms, turn_vectors, turning_forms
from ..inertia import Inertia, operator_parameters
from ..integrable import inner
from ..literature import VESELOVA
from ..manifold import Array, Arrays, Named, triangle_rows, wedge
from ..operators import in_two
from .bound_velocity import bound_parameters, bound_velocity, bound_work, log_determinant
from .stiefel_states import allowed_part, initial_stiefel


@functools.cache
def stiefel_forms(full: bool, n: int, r: int) -> tuple[BallForms, Any]:
    """Return the functions of eq. (dot_P), and K; y = (X, P), vector by vector."""
    size, rows = triangle_rows(n), n * r
    solve, wedges = bound_velocity(full, n, r), wedge_sum(n, r)

    def turning(params, y, work):
        """Return blocks (k, w, scratch of the solve)."""
        k, w, rest = in_two(work, size)
        wedges(part(y, 0, rows), part(y, rows, rows), k)
        solve(params, k, part(y, 0, rows), w, rest)
        return k, w, rest

    def stiefel_density(params, y, rest):
        """Return −½ log det(pr_𝔡 𝓘|_𝔡)."""
        return -0.5 * log_determinant(rows, rest)

    def stiefel_k(params, t, y, work):
        """K = ⟨k, k⟩."""
        k = part(work, 0, size)
        wedges(part(y, 0, rows), part(y, rows, rows), k)
        return inner(size, k, k)

    forms = turning_forms(n, turn_vectors, gi.helper(turning), gi.helper(stiefel_density))
    return forms, gi.observable(stiefel_k)


def integrals(n: int, r: int) -> Named:
    """Return (p_s, p_t), s ≤ t, and (e_s, p_t), s < t, by name."""
    rows = n * r
    found = {}
    for s in range(r):
        for t in range(s, r):
            if t > s:
                found[f"eps-{s + 1}-{t + 1}"] = product(n, s * n, rows + t * n)
            if r > 1:
                found[f"pp-{s + 1}-{t + 1}"] = product(n, rows + s * n, rows + t * n)
    return found


def stiefel_problem(inertia: Inertia, r: Any = 1) -> gi.Problem:
    """Return the Veselova problem reduced to T*V(n, r).

    State: ``X`` (r·n,), the vectors e_1, …, e_r one after another, and ``P`` (r·n,), p_1, …, p_r; at
    r = 1 they are called ``gamma`` and ``p``. Time t. Forms: ODE and action of SO(n).
    ``state(X=…, P=…)``, both as r vectors; instead of P also k (its part in span{e_s∧R^n} must be all
    of it), or w.

    Parameters
    ----------
    inertia : SpecialInertia or GeneralInertia
        𝓘, any symmetric positive definite operator on so(n).
    r : int
        1 ≤ r ≤ n − 1; r = n − 1 leaves the body free.

    Raises
    ------
    geomint.DomainError
        For another r; from ``state`` and ``canonical`` for what describes no state.
    """
    n = inertia.n
    count = frame_count(r, n)
    rows = n * count
    full, params = bound_parameters(inertia)
    forms, k_squared = stiefel_forms(full, n, count)
    space = gi.TangentStiefel(n, count) if count > 1 else gi.TangentSphere(n)

    def make_state(**components: Any) -> Array:
        return initial_stiefel(inertia, space, components)

    def make_random(rng: np.random.Generator) -> Named:
        X = gi.Rotations(n).random(rng)["g"][:rows].reshape(count, n)
        return {space.pieces[0][0]: X, "k": allowed_part(X, rng.normal(size=triangle_rows(n)))}

    def physical(y: Array) -> Arrays:
        X, P = y[:rows].reshape(count, n), y[rows:].reshape(count, n)
        k = np.sum([wedge(x, p) for x, p in zip(X, P, strict=True)], axis=0)
        return {space.pieces[0][0]: np.array(y[:rows]), "k": np.asarray(k)}

    return gi.Problem(
        name="veselova-stiefel",
        equations=(
            "Ẋ = −wX,  Ṗ = −wP",
            "XPᵀ − PXᵀ = the part of 𝓘w in span{e_s∧Rⁿ},  w ∈ span{e_s∧Rⁿ},  X = (e_1, …, e_r)",
        ),
        space=space,
        params=params,
        field=forms.field,
        action=space.action(forms.generator),
        work=n * (n - 1) + bound_work(n, count),
        invariants={"energy": forms.energy, "K": k_squared, **integrals(n, count)},
        measure=gi.Measure(forms.log_density),
        make_state=make_state,
        make_random=make_random,
        physical=physical,
        parameters={**operator_parameters(inertia), "r": count},
        references=VESELOVA,
    )


def frame_count(r: Any, n: int) -> int:
    """Return r as a whole number with 1 ≤ r ≤ n − 1, or raise `geomint.DomainError`."""
    return whole("r", r, 1, n - 1)
