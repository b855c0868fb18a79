"""The Hamiltonisation of the ball in R³ at *any* area constant (k⃗, γ⃗): a Poisson bracket in time τ.

In the time dτ = dt/f, f = D√U = c√(γ⃗, Wγ⃗), W = (I + D)⁻¹I, c⁴ = D³/det W, the equations (Chap) are
Hamiltonian, y′ = Π ∂H/∂y with H = ½(k⃗, ω⃗) and

    {k_i, k_j} = −f ε_ijl (k_l − s γ_l),   {k_i, γ_j} = −f ε_ijl γ_l,   {γ_i, γ_j} = 0,

s = D(ω⃗, γ⃗) = D(γ⃗, Bk⃗)/(γ⃗, Wγ⃗), B = (I + D)⁻¹. Its Casimir functions are (γ⃗, γ⃗) and (k⃗, γ⃗); where the
latter is 0, τ and the bracket are those of the Hamiltonised sphere, `hamiltonized`. For n ≥ 4 and
momentum there is no such bracket with a multiplier: see `chaplygin.controls`. The bracket is Borisov's
and Mamaev's (2001); the factors here are our own.

In τ the density of the measure is 1/(γ⃗, Wγ⃗).
"""

import functools

import numpy as np

import geomint as gi
from geomint import log, section, sqrt

from ..inertia import Inertia, inertia_tensor, parameters_of
from ..literature import POISSON_BALL
from ..manifold import Array, Named
from .classical import (
    DIAGONAL,
    FULL,
    classical_parameters,
    classical_problem,
    diagonal_omega,
    diagonal_weight,
    full_omega,
    full_weight,
    turning_vectors,
    vector_arrays,
)
from .path import integrated_path


@functools.cache
def poisson_forms(full: bool) -> Named:
    """Return field, generator, clock and log of the density; params: those of `classical`, c²."""
    omega_of = full_omega if full else diagonal_omega
    weight = full_weight if full else diagonal_weight
    rows = FULL if full else DIAGONAL

    def scaled(params, y):
        """Return f = dt/dτ."""
        return sqrt(section(params, rows, "own")[0] * weight(params, y))

    scale = gi.helper(scaled)

    def scaled_omega(params, y):
        """Return fω⃗."""
        f = scale(params, y)
        w0, w1, w2 = omega_of(params, y)
        return f * w0, f * w1, f * w2

    field, generator = turning_vectors(gi.helper(scaled_omega))

    def poisson_clock(params, t, y, work):
        """dt/dτ = f."""
        return scale(params, y)

    def poisson_log_density(params, t, y, work):
        """Return −log(γ⃗, Wγ⃗)."""
        return -log(weight(params, y))

    return {
        "field": field,
        "generator": generator,
        "clock": gi.observable(poisson_clock),
        "log_density": gi.observable(poisson_log_density),
    }


def poisson_problem(inertia: Inertia, D: float) -> gi.Problem:
    """Return the ball in R³ in time τ, at any area constant.

    State: ``k`` (3,) and ``gamma`` (3,), vectors. Time τ, with the clock dt/dτ = f. Forms: ODE and
    action of SO(3). ``state`` as of `classical_problem`. `poisson_tensor` gives the bracket.

    Parameters
    ----------
    inertia, D
        See `ChaplyginSphere`.

    Raises
    ------
    geomint.DomainError
        If n is not 3; from ``state`` and ``canonical`` for what describes no state.
    """
    classical = classical_problem(inertia, D)
    moments = inertia_tensor(inertia)
    weights = np.linalg.eigvalsh(moments) / (np.linalg.eigvalsh(moments) + D)
    square = D * np.sqrt(D / np.prod(weights))
    full, params = classical_parameters(moments, D, square)
    forms = poisson_forms(full)

    return gi.Problem(
        name="ball-poisson",
        equations=(
            "k′ = f k × ω,  γ′ = f γ × ω",
            "k = Iω + Dω − D(ω, γ)γ",
            "′ = d/dτ,  dτ = dt/f,  f = c√(γ, Wγ),  W = (I + D)⁻¹I,  c⁴ = D³/det W",
        ),
        space=classical.space,
        params=params.data,
        field=forms["field"],
        action=gi.GroupAction(forms["generator"], gi.so3(2)),
        time="tau",
        clock=forms["clock"],
        invariants={name: classical.invariants[name] for name in ("energy", "K", "area")},
        measure=gi.Measure(forms["log_density"]),
        make_state=classical.make_state,
        make_random=classical.make_random,
        make_path=integrated_path(inertia, D, vector_arrays),
        physical=vector_arrays,
        parameters=parameters_of(inertia, D),
        references=POISSON_BALL,
    )


def poisson_tensor(inertia: Inertia, D: float, y: Array) -> Array:
    """Return Π(y), shape (6, 6), of a state y = (k⃗, γ⃗) with |γ⃗| = 1: y′ = Π ∂H/∂y, Π_ab = {y_a, y_b}.

    As a function of any y with γ⃗ ≠ 0, of any dtype; Jacobi's identity holds there.
    """
    tensor = inertia_tensor(inertia)
    b = np.linalg.inv(tensor + D * np.eye(3))
    w = b @ tensor
    k, gamma = y[:3], y[3:]
    weight = gamma @ w @ gamma
    f = np.sqrt(D * np.sqrt(D / np.linalg.det(w)) * weight)
    s = D * (gamma @ b @ k) / weight
    result = np.zeros((6, 6), dtype=np.result_type(y))
    result[:3, :3] = _hat(k - s * gamma)
    result[:3, 3:] = result[3:, :3] = _hat(gamma)
    return f * result


def _hat(x: Array) -> Array:
    """Return the matrix of v ↦ x⃗ × v⃗."""
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]], dtype=x.dtype)
