"""The classical Veselova problem, n = 3, as it is first printed: (w⃗, γ⃗) with its multiplier λ.

Eqs. (3.1), (la), on all of R⁶ where γ⃗ ≠ 0:

    𝓘 dw⃗/dt = 𝓘w⃗ × w⃗ + λγ⃗,   dγ⃗/dt = γ⃗ × w⃗,   λ = −(𝓘w⃗ × w⃗, 𝓘⁻¹γ⃗)/(𝓘⁻¹γ⃗, γ⃗).

f₁ = (w⃗, γ⃗) is an integral, and so are f_3 and f_4 = (K⃗, K⃗), eq. (ints), with K⃗ = 𝓘w⃗ − (𝓘⁰w⃗, γ⃗)γ⃗,
𝓘⁰ = 𝓘 − 1. `classical` has the same motions in (K⃗, γ⃗), eq. (3.2), where SO(3) acts on all of the
state. Here it acts on γ⃗ alone, and w⃗ is moved by translations.

The density of the measure is (γ⃗, 𝓘⁻¹γ⃗)^(1/2).
"""

from typing import Any

import numpy as np

import geomint as gi
from geomint import log, section
from geomint.problems.spaces.conditions import written

from ..ball.classical import vector_arrays
from ..literature import VESELOVA
from ..manifold import Array
from .classical import LEVEL, veselova_classical_problem

SPACE = gi.Sphere(3) * gi.Euclidean(3, "w")


@gi.helper
def rates(params, y):
    """Return dw⃗/dt and λ; y = (γ⃗, w⃗)."""
    b = section(params, LEVEL, "B")
    b0, b1, b2 = b[0], b[1], b[2]
    g0, g1, g2, w0, w1, w2 = y[0], y[1], y[2], y[3], y[4], y[5]
    m0, m1, m2 = w0 / b0, w1 / b1, w2 / b2
    t0, t1, t2 = m1 * w2 - m2 * w1, m2 * w0 - m0 * w2, m0 * w1 - m1 * w0
    above = t0 * b0 * g0 + t1 * b1 * g1 + t2 * b2 * g2
    lam = -above / (b0 * g0 * g0 + b1 * g1 * g1 + b2 * g2 * g2)
    return b0 * (t0 + lam * g0), b1 * (t1 + lam * g1), b2 * (t2 + lam * g2), lam


@gi.field
def multiplier_field(params, t, y, out, work):
    """Eqs. (3.1), (la)."""
    a0, a1, a2, _ = rates(params, y)
    out[0] = y[1] * y[5] - y[2] * y[4]
    out[1] = y[2] * y[3] - y[0] * y[5]
    out[2] = y[0] * y[4] - y[1] * y[3]
    out[3] = a0
    out[4] = a1
    out[5] = a2


@gi.field
def multiplier_generator(params, t, y, out, work):
    """ξ = (−w, dw⃗/dt), the first as a flat triangle."""
    a0, a1, a2, _ = rates(params, y)
    out[0] = 1.0 * y[5]
    out[1] = -y[4]
    out[2] = 1.0 * y[3]
    out[3] = a0
    out[4] = a1
    out[5] = a2


@gi.helper
def momentum(params, y):
    """Return K⃗ and (𝓘⁰w⃗, γ⃗)."""
    w0, w1, w2 = y[3], y[4], y[5]
    b = section(params, LEVEL, "B")
    m0, m1, m2 = w0 / b[0], w1 / b[1], w2 / b[2]
    s = (m0 - w0) * y[0] + (m1 - w1) * y[1] + (m2 - w2) * y[2]
    return m0 - s * y[0], m1 - s * y[1], m2 - s * y[2], s


@gi.observable
def multiplier_energy(params, t, y, work):
    """f_3 = ½(K⃗, w⃗) − ½(K⃗, γ⃗)(𝓘⁰w⃗, γ⃗), eq. (ints); ½(𝓘w⃗, w⃗) at f₁ = 0."""
    k0, k1, k2, s = momentum(params, y)
    area = k0 * y[0] + k1 * y[1] + k2 * y[2]
    return 0.5 * (k0 * y[3] + k1 * y[4] + k2 * y[5] - area * s)


@gi.observable
def multiplier_k(params, t, y, work):
    """f_4 = (K⃗, K⃗), eq. (ints)."""
    k0, k1, k2, _ = momentum(params, y)
    return k0 * k0 + k1 * k1 + k2 * k2


@gi.observable
def multiplier_constraint(params, t, y, work):
    """(w⃗, γ⃗) − f₁, eq. (classical)."""
    return y[0] * y[3] + y[1] * y[4] + y[2] * y[5] - section(params, LEVEL, "f1")[0]


@gi.observable
def multiplier(params, t, y, work):
    """λ, eq. (la)."""
    _, _, _, lam = rates(params, y)
    return lam


@gi.observable
def multiplier_log_density(params, t, y, work):
    """Return ½ log(γ⃗, 𝓘⁻¹γ⃗)."""
    b = section(params, LEVEL, "B")
    total = b[0] * y[0] * y[0] + b[1] * y[1] * y[1] + b[2] * y[2] * y[2]
    return 0.5 * log(total)


# (γ⃗, γ⃗) − 1 and (w⃗, γ⃗) − f₁
multiplier_conditions = written(SPACE.constraints["norm"], multiplier_constraint)


def veselova_multiplier_problem(a: Array, D: float, f1: Any = 0.0) -> gi.Problem:
    """Return the classical Veselova problem in (γ⃗, w⃗) with its multiplier; n = 3.

    State: ``gamma`` (3,) and ``w`` (3,), vectors, with (w⃗, γ⃗) = f₁. Time t. Forms: ODE and action of
    SO(3) × R³. ``state`` as of `veselova_classical_problem`.

    Parameters
    ----------
    a, D
        See `Veselova`.
    f1 : float
        The value of the constraint (w⃗, γ⃗).

    Raises
    ------
    geomint.DomainError
        If n is not 3; from ``state`` and ``canonical`` for what describes no state.
    """
    classical = veselova_classical_problem(a, D, f1)
    inverse = classical.params[: LEVEL.B]

    def from_momentum(y: Array) -> Array:
        """Return (γ⃗, w⃗) of (K⃗, γ⃗): w⃗ = B(K⃗ + mγ⃗)."""
        k, gamma = y[:3], y[3:]
        m = (k @ gamma - gamma @ (inverse * k)) / (gamma @ (inverse * gamma))
        return np.concatenate([gamma, inverse * (k + m * gamma)])

    def to_momentum(y: Array) -> Array:
        gamma, w = y[:3], y[3:]
        full = w / inverse
        return np.concatenate([full - ((full - w) @ gamma) * gamma, gamma])

    def admit(y: Array) -> Array:
        state = to_momentum(SPACE.admit(y))
        admitted = classical.canonical(state)
        return y if np.array_equal(admitted, state) else from_momentum(admitted)

    assert classical.make_state is not None
    make_state = classical.make_state
    return gi.Problem(
        name="veselova-multiplier",
        equations=(
            "𝓘ẇ = 𝓘w × w + λγ,  γ̇ = γ × w",
            "λ = −(𝓘w × w, 𝓘⁻¹γ)/(𝓘⁻¹γ, γ)",
        ),
        space=SPACE,
        params=classical.params,
        field=multiplier_field,
        action=SPACE.action(multiplier_generator),
        invariants={"energy": multiplier_energy, "K": multiplier_k},
        constraints={"constraint": multiplier_constraint},
        observables={"multiplier": multiplier},
        measure=gi.Measure(multiplier_log_density, multiplier_conditions, 2),
        make_state=lambda **components: from_momentum(make_state(**components)),
        make_random=classical.make_random,
        admit=admit,
        physical=lambda y: vector_arrays(to_momentum(np.asarray(y))),
        parameters=classical.parameters,
        references=VESELOVA,
    )
