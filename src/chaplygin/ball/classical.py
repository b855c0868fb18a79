"""The classical Chaplygin ball, n = 3, in vectors: any momentum, any inertia tensor.

dk⃗/dt = k⃗ × ω⃗, dγ⃗/dt = γ⃗ × ω⃗, eq. (Chap), with k⃗ = Iω⃗ + Dω⃗ − D(ω⃗, γ⃗)γ⃗.

No solve is needed: with B = (I + D)⁻¹ and W = BI,

    ω⃗ = B(k⃗ + m γ⃗),   m = D (γ⃗, Bk⃗)/(γ⃗, Wγ⃗).

The denominator is (γ, γ) − D(γ, Bγ) written without its cancellation, and ω⃗ depends on the
direction of γ⃗ alone: the energy is kept wherever γ⃗ ≠ 0.

The hat map (iso) takes vectors to so(3); there k⃗ is p⃗ × γ⃗ for k = γ∧p. The rows of the attitude
g turn as γ⃗ does, so that SO(3) acts on k⃗, γ⃗ and the rows of g by one rotation exp(−hω⃗).
"""

import functools
from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import fma, log, section, sqrt
from geomint.problems.spaces.sphere import product as product_of

from ..exact.motions import exact_ball
from ..inertia import Inertia, inertia_tensor, parameters_of
from ..initial_states import initial_momentum
from ..literature import CLASSICAL_BALL
from ..manifold import Array, Arrays, Named, skew_components, triangle_of_vector, vector_of_triangle
from .path import integrated_path
from .rolling_states import has_attitude, own_attitude

# D; diagonals of B and W, and what is beside them; what else a problem has
Classical = namedtuple("Classical", "D B W B_rest W_rest own")
DIAGONAL = Classical(D=1, B=3, W=3, B_rest=0, W_rest=0, own=gi.REST)
FULL = Classical(D=1, B=3, W=3, B_rest=3, W_rest=3, own=gi.REST)
VECTORS = gi.Euclidean(3, "k", turned=True) * gi.Sphere(3)

classical_k = product_of(3, 0, 0)  # F_4 = (k⃗, k⃗) = ⟨k, k⟩, eq. (cl:int)
classical_area = product_of(3, 0, 3)  # F_1 = (k⃗, γ⃗), eq. (cl:int)


@gi.helper
def diagonal_weight(params, y):
    """Return (γ⃗, Wγ⃗) for an inertia tensor in principal axes."""
    w = section(params, DIAGONAL, "W")
    return w[0] * y[3] * y[3] + w[1] * y[4] * y[4] + w[2] * y[5] * y[5]


@gi.helper
def diagonal_omega(params, y):
    """Return ω⃗ for an inertia tensor in principal axes."""
    b = section(params, DIAGONAL, "B")
    g0, g1, g2 = y[3], y[4], y[5]
    k0, k1, k2 = b[0] * y[0], b[1] * y[1], b[2] * y[2]
    w = diagonal_weight(params, y)
    m = section(params, DIAGONAL, "D")[0] * (g0 * k0 + g1 * k1 + g2 * k2) / w
    return fma(m, b[0] * g0, k0), fma(m, b[1] * g1, k1), fma(m, b[2] * g2, k2)


@gi.helper
def product(diagonal, rest, x0, x1, x2):
    """Return S x for the symmetric matrix with those entries, beside the diagonal S_12, S_13, S_23."""
    s01, s02, s12 = rest[0], rest[1], rest[2]
    return (
        diagonal[0] * x0 + s01 * x1 + s02 * x2,
        s01 * x0 + diagonal[1] * x1 + s12 * x2,
        s02 * x0 + s12 * x1 + diagonal[2] * x2,
    )


@gi.helper
def full_weight(params, y):
    """Return (γ⃗, Wγ⃗) for any inertia tensor."""
    diagonal, rest = section(params, FULL, "W"), section(params, FULL, "W_rest")
    w0, w1, w2 = product(diagonal, rest, y[3], y[4], y[5])
    return w0 * y[3] + w1 * y[4] + w2 * y[5]


@gi.helper
def full_omega(params, y):
    """Return ω⃗ for any inertia tensor."""
    g0, g1, g2 = y[3], y[4], y[5]
    diagonal, rest = section(params, FULL, "B"), section(params, FULL, "B_rest")
    k0, k1, k2 = product(diagonal, rest, y[0], y[1], y[2])
    b0, b1, b2 = product(diagonal, rest, g0, g1, g2)
    w = full_weight(params, y)
    m = section(params, FULL, "D")[0] * (g0 * k0 + g1 * k1 + g2 * k2) / w
    return fma(m, b0, k0), fma(m, b1, k1), fma(m, b2, k2)


@gi.helper
def turn(w0, w1, w2, y, out):
    """Write v × ω for each vector v of the state."""
    for i in range(0, len(y), 3):
        v0, v1, v2 = y[i], y[i + 1], y[i + 2]
        out[i] = v1 * w2 - v2 * w1
        out[i + 1] = v2 * w0 - v0 * w2
        out[i + 2] = v0 * w1 - v1 * w0


def turning_vectors(omega_of: Any) -> tuple[Any, Any]:
    """Return field and generator of vectors that turn with −ω⃗, which `omega_of(params, y)` returns."""

    def vectors_field(params, t, y, out, work):
        """v̇ = v × ω⃗."""
        w0, w1, w2 = omega_of(params, y)
        turn(w0, w1, w2, y, out)

    def vectors_generator(params, t, y, out, work):
        """ξ = −ω⃗: every vector of the state has v̇ = ξ × v."""
        w0, w1, w2 = omega_of(params, y)
        out[0] = -w0
        out[1] = -w1
        out[2] = -w2

    return gi.field(vectors_field), gi.field(vectors_generator)


@functools.cache
def classical_forms(full: bool) -> Named:
    """Return field, eq. (Chap), generator, energy, log of the density and the momentum in space."""
    omega_of = full_omega if full else diagonal_omega
    weight = full_weight if full else diagonal_weight
    rows = FULL if full else DIAGONAL
    field, generator = turning_vectors(omega_of)

    def classical_energy(params, t, y, work):
        """F_3 = ½(k⃗, ω⃗), eq. (cl:int)."""
        w0, w1, w2 = omega_of(params, y)
        return 0.5 * (y[0] * w0 + y[1] * w1 + y[2] * w2)

    def classical_log_density(params, t, y, work):
        """Return log ϱ = −½ log(γ⃗, Wγ⃗), eq. (mu-ch) without its cancellation."""
        return -0.5 * log(weight(params, y))

    def classical_spatial_momentum(params, t, y, work):
        """|g k⃗ − k⃗_0|."""
        k0, total = section(params, rows, "own"), 0.0 * y[0]
        for i in range(3):
            row = 6 + 3 * i
            entry = y[row] * y[0] + y[row + 1] * y[1] + y[row + 2] * y[2] - k0[i]
            total += entry * entry
        return sqrt(total)

    return {
        "field": field,
        "generator": generator,
        "energy": gi.observable(classical_energy),
        "log_density": gi.observable(classical_log_density),
        "spatial_momentum": gi.observable(classical_spatial_momentum),
    }


@functools.cache
def routh_integral(axis: int) -> Any:
    """Return ω_i √(γ⃗, Wγ⃗), constant where the moments of the other two axes are equal.

    The last remark of the paper, for ω_3 and not for k_3, as which it is misprinted; and at any
    value of the area constant.
    """

    def routh(params, t, y, work):
        omega = diagonal_omega(params, y)
        return omega[axis] * sqrt(diagonal_weight(params, y))

    return gi.observable(routh)


def vector_arrays(y: Array) -> Arrays:
    """Return γ⃗ and the flat triangle of k⃗ of a state (k⃗, γ⃗, …)."""
    return {"gamma": np.array(y[3:6]), "k": triangle_of_vector(y[:3])}


def classical_parameters(tensor: Array, D: float, own: Any) -> tuple[bool, Any]:
    """Return whether the tensor is not in principal axes, and the block of the parameters."""
    upper = np.triu_indices(3, 1)
    if np.count_nonzero(tensor[upper]) == 0:
        moments = np.diag(tensor)
        numbers = {
            "B": 1.0 / (moments + D),
            "W": moments / (moments + D),
            "B_rest": (),
            "W_rest": (),
        }
        return False, gi.packed(DIAGONAL, D=D, own=own, **numbers)
    b = np.linalg.inv(tensor + D * np.eye(3))
    w = np.linalg.solve(tensor + D * np.eye(3), tensor)
    b, w = 0.5 * (b + b.T), 0.5 * (w + w.T)
    numbers = {"B": np.diag(b), "W": np.diag(w), "B_rest": b[upper], "W_rest": w[upper]}
    return True, gi.packed(FULL, D=D, own=own, **numbers)


def classical_problem(
    inertia: Inertia, D: float, attitude: bool = False, k0: Any = None
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
    tensor, attitude = inertia_tensor(inertia), has_attitude(attitude, k0)
    space = gi.Product(*VECTORS.factors, *([gi.Rotations(3)] if attitude else []))
    own = () if k0 is None else vector_of_triangle(skew_components("k0", k0, 3, vector=True))
    full, params = classical_parameters(tensor, D, own)
    forms, b = classical_forms(full), section(params, DIAGONAL, "B").data
    routh = {
        f"routh-{i + 1}": routh_integral(i)
        for i in range(3)
        if not full and b[i - 1] == b[i - 2]  # the moments of the other two axes
    }

    def make_state(gamma: Any = None, g: Any = None, **components: Any) -> Array:
        last = own_attitude(g, attitude, 3)
        vertical, k = initial_momentum(inertia, D, gamma, vector=True, **components)
        return np.concatenate([vector_of_triangle(k), vertical, *last])

    def make_random(rng: np.random.Generator) -> Named:
        g = gi.Rotations(3).random(rng)["g"]
        return {"gamma": g[-3:], "k": rng.normal(size=3), **({"g": g} if attitude else {})}

    group, frame = gi.so3(5 if attitude else 2), space.slices.get("g")
    return gi.Problem(
        name="classical-ball",
        equations=(
            "k̇ = k × ω,  γ̇ = γ × ω",
            "k = Iω + Dω − D(ω, γ)γ",
        ),
        space=space,
        params=params.data,
        field=forms["field"],
        action=gi.GroupAction(forms["generator"], group),
        invariants={
            "energy": forms["energy"],
            "K": classical_k,
            "area": classical_area,
            **routh,
        },
        constraints={} if k0 is None else {"spatial-momentum": forms["spatial_momentum"]},
        measure=gi.Measure(
            forms["log_density"], base=classical_problem(inertia, D) if attitude else None
        ),
        make_state=make_state,
        make_exact=None if attitude else exact_ball(inertia, D),
        make_path=integrated_path(inertia, D, vector_arrays, frame),
        make_random=make_random,
        physical=vector_arrays,
        parameters=parameters_of(inertia, D),
        references=CLASSICAL_BALL,
    )
