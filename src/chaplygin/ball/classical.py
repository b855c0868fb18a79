"""The classical Chaplygin ball, n = 3, in vectors: any momentum, any inertia tensor.

dk⃗/dt = k⃗ × ω⃗, dγ⃗/dt = γ⃗ × ω⃗, eq. (Chap), with k⃗ = Iω⃗ + Dω⃗ − D(ω⃗, γ⃗)γ⃗.

No solve is needed: with B = (I + D)⁻¹ and W = BI,

    ω⃗ = B(k⃗ + m γ⃗),   m = D (γ⃗, Bk⃗)/(γ⃗, Wγ⃗).

The denominator is (γ, γ) − D(γ, Bγ) written without its cancellation, and ω⃗ depends on the
direction of γ⃗ alone: the energy is kept wherever γ⃗ ≠ 0.

The hat map (iso) takes vectors to so(3); there k⃗ is p⃗ × γ⃗ for k = γ∧p. The rows of the attitude
g turn as γ⃗ does, so that SO(3) acts on k⃗, γ⃗ and the rows of g by one rotation exp(−hω⃗).
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

import geomint as gi
from geomint import fma, log, sqrt
from geomint.arguments import switch

from ..exact.motions import exact_ball
from ..inertia import GeneralInertia, SpecialInertia, parameters_of
from ..initial_states import initial_momentum
from ..manifold import (
    Array,
    skew_components,
    triangle_of_vector,
    vector_of_triangle,
)

__all__ = ["classical_problem"]

# params: D; B_11, B_22, B_33; W_11, W_22, W_33; with a full tensor also B_12, B_13, B_23, W_12,
# W_13, W_23; k0 where it is given
DIAGONAL_SIZE = 7
VECTORS = gi.Euclidean(3, "k", turned=True) * gi.Sphere(3)


@gi.helper
def diagonal_omega(params: Any, y: Any) -> Any:
    """Return ω⃗ for an inertia tensor in principal axes."""
    b0, b1, b2 = params[1], params[2], params[3]
    g0, g1, g2 = y[3], y[4], y[5]
    k0, k1, k2 = b0 * y[0], b1 * y[1], b2 * y[2]
    w = params[4] * g0 * g0 + params[5] * g1 * g1 + params[6] * g2 * g2
    m = params[0] * (g0 * k0 + g1 * k1 + g2 * k2) / w
    return fma(m, b0 * g0, k0), fma(m, b1 * g1, k1), fma(m, b2 * g2, k2)


@gi.helper
def product(params: Any, diagonal: int, rest: int, x0: Any, x1: Any, x2: Any) -> Any:
    """Return S x for the symmetric matrix with those entries in `params`."""
    s01, s02, s12 = params[rest], params[rest + 1], params[rest + 2]
    return (
        params[diagonal] * x0 + s01 * x1 + s02 * x2,
        s01 * x0 + params[diagonal + 1] * x1 + s12 * x2,
        s02 * x0 + s12 * x1 + params[diagonal + 2] * x2,
    )


@gi.helper
def full_omega(params: Any, y: Any) -> Any:
    """Return ω⃗ for any inertia tensor."""
    g0, g1, g2 = y[3], y[4], y[5]
    k0, k1, k2 = product(params, 1, 7, y[0], y[1], y[2])
    b0, b1, b2 = product(params, 1, 7, g0, g1, g2)
    w0, w1, w2 = product(params, 4, 10, g0, g1, g2)
    w = w0 * g0 + w1 * g1 + w2 * g2
    m = params[0] * (g0 * k0 + g1 * k1 + g2 * k2) / w
    return fma(m, b0, k0), fma(m, b1, k1), fma(m, b2, k2)


@gi.helper
def turn(w0: Any, w1: Any, w2: Any, y: Any, out: Any) -> None:
    """Write v × ω for each vector v of the state."""
    for i in range(0, len(y), 3):
        v0, v1, v2 = y[i], y[i + 1], y[i + 2]
        out[i] = v1 * w2 - v2 * w1
        out[i + 1] = v2 * w0 - v0 * w2
        out[i + 2] = v0 * w1 - v1 * w0


@gi.field
def diagonal_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Eq. (Chap), and rows of g: ġ = gω."""
    w0, w1, w2 = diagonal_omega(params, y)
    turn(w0, w1, w2, y, out)


@gi.field
def full_field(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """Eq. (Chap), and rows of g: ġ = gω."""
    w0, w1, w2 = full_omega(params, y)
    turn(w0, w1, w2, y, out)


@gi.field
def diagonal_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ = −ω⃗: every vector of the state has v̇ = ξ × v."""
    w0, w1, w2 = diagonal_omega(params, y)
    out[0] = -w0
    out[1] = -w1
    out[2] = -w2


@gi.field
def full_generator(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
    """ξ = −ω⃗: every vector of the state has v̇ = ξ × v."""
    w0, w1, w2 = full_omega(params, y)
    out[0] = -w0
    out[1] = -w1
    out[2] = -w2


@gi.observable
def diagonal_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """F_3 = ½(k⃗, ω⃗), eq. (cl:int)."""
    w0, w1, w2 = diagonal_omega(params, y)
    return 0.5 * (y[0] * w0 + y[1] * w1 + y[2] * w2)


@gi.observable
def full_energy(params: Any, t: Any, y: Any, work: Any) -> Any:
    """F_3 = ½(k⃗, ω⃗), eq. (cl:int)."""
    w0, w1, w2 = full_omega(params, y)
    return 0.5 * (y[0] * w0 + y[1] * w1 + y[2] * w2)


@gi.observable
def diagonal_log_density(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return log ϱ = −½ log(γ⃗, Wγ⃗), eq. (mu-ch) without its cancellation."""
    w = params[4] * y[3] * y[3] + params[5] * y[4] * y[4] + params[6] * y[5] * y[5]
    return -0.5 * log(w)


@gi.observable
def full_log_density(params: Any, t: Any, y: Any, work: Any) -> Any:
    """Return log ϱ = −½ log(γ⃗, Wγ⃗), eq. (mu-ch) without its cancellation."""
    w0, w1, w2 = product(params, 4, 10, y[3], y[4], y[5])
    return -0.5 * log(w0 * y[3] + w1 * y[4] + w2 * y[5])


@gi.observable
def classical_k(params: Any, t: Any, y: Any, work: Any) -> Any:
    """F_4 = (k⃗, k⃗) = ⟨k, k⟩, eq. (cl:int)."""
    return y[0] * y[0] + y[1] * y[1] + y[2] * y[2]


@gi.observable
def classical_area(params: Any, t: Any, y: Any, work: Any) -> Any:
    """F_1 = (k⃗, γ⃗), eq. (cl:int)."""
    return y[0] * y[3] + y[1] * y[4] + y[2] * y[5]


@gi.observable
def classical_spatial_momentum(params: Any, t: Any, y: Any, work: Any) -> Any:
    """|g k⃗ − k⃗_0|; params ends with k⃗_0."""
    first = len(params) - 3
    total = 0.0 * y[0]
    for i in range(3):
        row = 6 + 3 * i
        entry = y[row] * y[0] + y[row + 1] * y[1] + y[row + 2] * y[2] - params[first + i]
        total += entry * entry
    return sqrt(total)


@functools.cache
def routh_integral(axis: int) -> Any:
    """Return ω_i √(γ⃗, Wγ⃗), constant where the moments of the other two axes are equal.

    The last remark of the paper, for ω_3 and not for k_3, as which it is misprinted; and at any
    value of the area constant.
    """

    def routh(params: Any, t: Any, y: Any, work: Any) -> Any:
        omega = diagonal_omega(params, y)
        w = params[4] * y[3] * y[3] + params[5] * y[4] * y[4] + params[6] * y[5] * y[5]
        return omega[axis] * sqrt(w)

    return gi.observable(routh)


def axes_of_symmetry(params: Array) -> list[int]:
    """Return the axes whose other two moments are equal, from the parameters; of a diagonal tensor."""
    if len(params) > DIAGONAL_SIZE:
        return []
    b = params[1:4]
    return [i for i in range(3) if b[i - 1] == b[i - 2]]


def inertia_tensor(inertia: SpecialInertia | GeneralInertia) -> Array:
    """Return the inertia tensor of an operator on so(3), shape (3, 3)."""
    if isinstance(inertia, SpecialInertia):
        return np.diag(inertia.moments)
    return inertia.tensor


def coefficients(tensor: Array, D: float) -> Array:
    """Return D, B and W as the functions of this module read them."""
    upper = np.triu_indices(3, 1)
    if np.count_nonzero(tensor[upper]) == 0:
        moments = np.diag(tensor)
        return np.concatenate([[D], 1.0 / (moments + D), moments / (moments + D)])
    b = np.linalg.inv(tensor + D * np.eye(3))
    w = np.linalg.solve(tensor + D * np.eye(3), tensor)
    b, w = 0.5 * (b + b.T), 0.5 * (w + w.T)
    return np.concatenate([[D], np.diag(b), np.diag(w), b[upper], w[upper]])


def classical_problem(
    inertia: SpecialInertia | GeneralInertia, D: float, attitude: bool = False, k0: Any = None
) -> gi.Problem:
    """Return the classical ball of a sphere with n = 3.

    State: ``k`` (3,), ``gamma`` (3,) and with `attitude` ``g`` (9,), the rows of the rotation from
    body to space. Time t. Forms: ODE and action of SO(3).
    ``state(gamma=…, k=…)``; instead of k also omega, or p for k⃗ = p⃗ × γ⃗; g = 1 unless given.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.
    attitude : bool
        Carry g.
    k0 : array_like, shape (3,), optional
        The spatial momentum g k⃗ (k⃗ itself where g = 1): gives "spatial-momentum" |g k⃗ − k⃗_0|.

    Raises
    ------
    geomint.DomainError
        If n is not 3; from ``state`` and ``canonical`` for what describes no state.
    """
    params = coefficients(inertia_tensor(inertia), D)
    full = len(params) > DIAGONAL_SIZE
    routh = {f"routh-{i + 1}": routh_integral(i) for i in axes_of_symmetry(params)}
    attitude = switch("attitude", attitude)
    space = gi.Product(*VECTORS.factors, *([gi.Rotations(3)] if attitude else []))
    if k0 is not None and not attitude:
        raise gi.DomainError("k0", k0, "None, or attitude=True: without g nothing is in space")
    constraints = {}
    if k0 is not None:
        momentum = vector_of_triangle(skew_components("k0", k0, 3, vector=True))
        params = np.concatenate([params, momentum])
        constraints["spatial-momentum"] = classical_spatial_momentum

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        if g is not None and not attitude:
            raise gi.DomainError("g", g, "no attitude: this problem has attitude=False")
        vertical, k = initial_momentum(inertia, D, gamma, vector=True, **components)
        last = [gi.Rotations(3).point(g)] if attitude else []
        return np.concatenate([vector_of_triangle(k), vertical, *last])

    def make_random(rng: np.random.Generator) -> dict[str, Any]:
        g = gi.Rotations(3).random(rng)["g"]
        return {"gamma": g[-3:], "k": rng.normal(size=3), **({"g": g} if attitude else {})}

    def physical(y: Array) -> dict[str, Array]:
        return {"gamma": np.array(y[3:6]), "k": triangle_of_vector(y[:3])}

    group = gi.so3(5 if attitude else 2)
    return gi.Problem(
        name="classical-ball",
        space=space,
        params=params,
        field=full_field if full else diagonal_field,
        action=gi.GroupAction(full_generator if full else diagonal_generator, group),
        invariants={
            "energy": full_energy if full else diagonal_energy,
            "K": classical_k,
            "area": classical_area,
            **routh,
        },
        constraints=constraints,
        measure=gi.Measure(full_log_density if full else diagonal_log_density),
        make_state=make_state,
        make_exact=None if attitude else exact_ball(inertia, D),
        make_random=make_random,
        physical=physical,
        parameters=parameters_of(inertia, D),
    )
