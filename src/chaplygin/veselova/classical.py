"""The classical Veselova problem, n = 3, in vectors, at any value of f₁ = (w⃗, γ⃗).

A rigid body with principal moments 𝓘 turns about a fixed point, and its angular velocity has a given
component along a direction γ⃗ that is fixed in space, eqs. (3.1), (la). With k⃗ = 𝓘w⃗ − (𝓘⁰w⃗, γ⃗)γ⃗,
𝓘⁰ = 𝓘 − 1 (the paper's K⃗),

    dk⃗/dt = k⃗ × w⃗,   dγ⃗/dt = γ⃗ × w⃗,   (k⃗, γ⃗) = (w⃗, γ⃗) = f₁,

eq. (3.2), and no solve is needed: with B = 𝓘⁻¹,

    w⃗ = B(k⃗ + m γ⃗),   m = ((k⃗, γ⃗) − (γ⃗, Bk⃗))/(γ⃗, Bγ⃗).

In the components of small moments k⃗ and mγ⃗ cancel. With the minors μ_ij = k_iγ_j − k_jγ_i that is done
by hand: w_i = b_i (Σ_j b_jγ_j μ_ij + (k⃗, γ⃗)γ_i)/(γ⃗, Bγ⃗).

w⃗ depends on the direction of γ⃗ alone: the energy is kept wherever γ⃗ ≠ 0. The equations are those of
the classical ball (`chaplygin.ball.classical`) with another w⃗, so SO(3) acts on (k⃗, γ⃗) by exp(−hw⃗).

The density of the measure is (γ⃗, Bγ⃗)^(−1/2) in (k⃗, γ⃗); it is (γ⃗, Bγ⃗)^(1/2) in (w⃗, γ⃗), as det ∂k⃗/∂w⃗ is
det 𝓘 (γ⃗, Bγ⃗) where |γ⃗| = 1.
"""

from collections import namedtuple
from typing import Any

import numpy as np

import geomint as gi
from geomint import log, section
from geomint.problems.spaces.conditions import written

from ..ball.classical import VECTORS, classical_area, classical_k, turning_vectors, vector_arrays
from ..exact.motions import exact_body
from ..initial_states import TANGENT, one_of
from ..literature import VESELOVA
from ..manifold import Array, Named, skew_components, vector_of_triangle
from .initial_states import KEYS, admit_on_level, on_level, veselova_tangent

Level = namedtuple("Level", "B f1")
LEVEL = Level(B=3, f1=1)  # the layout of the parameters: 1/𝓘_i and f₁


@gi.helper
def angular_velocity(params, y):
    """Return w⃗ and m; y = (k⃗, γ⃗)."""
    b = section(params, LEVEL, "B")
    b0, b1, b2 = b[0], b[1], b[2]
    k0, k1, k2, g0, g1, g2 = y[0], y[1], y[2], y[3], y[4], y[5]
    kg = k0 * g0 + k1 * g1 + k2 * g2
    gbk = b0 * (g0 * k0) + b1 * (g1 * k1) + b2 * (g2 * k2)
    r = 1.0 / (b0 * (g0 * g0) + b1 * (g1 * g1) + b2 * (g2 * g2))
    c0, c1, c2 = b0 * g0, b1 * g1, b2 * g2
    m01, m02, m12 = k0 * g1 - k1 * g0, k0 * g2 - k2 * g0, k1 * g2 - k2 * g1
    w0 = (b0 * r) * (c1 * m01 + c2 * m02 + kg * g0)
    w1 = (b1 * r) * (c2 * m12 - c0 * m01 + kg * g1)
    w2 = (b2 * r) * (kg * g2 - c0 * m02 - c1 * m12)
    return w0, w1, w2, (kg - gbk) * r


@gi.helper
def velocity(params, y):
    """Return w⃗."""
    w0, w1, w2, _ = angular_velocity(params, y)
    return w0, w1, w2


veselova_vectors_field, veselova_vectors_generator = turning_vectors(velocity)  # eq. (3.2)


@gi.observable
def veselova_vectors_energy(params, t, y, work):
    """f_3 = ½(k⃗, w⃗) − ½(k⃗, γ⃗)(𝓘⁰w⃗, γ⃗), eq. (ints); ½(𝓘w⃗, w⃗) at f₁ = 0."""
    w0, w1, w2, m = angular_velocity(params, y)
    area = y[0] * y[3] + y[1] * y[4] + y[2] * y[5]
    return 0.5 * (y[0] * w0 + y[1] * w1 + y[2] * w2 - area * m)


@gi.observable
def veselova_constraint(params, t, y, work):
    """(w⃗, γ⃗) − f₁ = (k⃗, γ⃗) − f₁, eq. (classical)."""
    return classical_area(params, t, y, work) - section(params, LEVEL, "f1")[0]


@gi.observable
def veselova_vectors_log_density(params, t, y, work):
    """Return −½ log(γ⃗, Bγ⃗)."""
    b = section(params, LEVEL, "B")
    w = b[0] * y[3] * y[3] + b[1] * y[4] * y[4] + b[2] * y[5] * y[5]
    return -0.5 * log(w)


# (γ⃗, γ⃗) − 1 and (k⃗, γ⃗) − f₁
level_conditions = written(VECTORS.constraints["norm"], veselova_constraint)


def veselova_classical_problem(a: Array, D: float, f1: Any = 0.0) -> gi.Problem:
    """Return the classical Veselova problem; n = 3.

    State: ``k`` (3,) and ``gamma`` (3,), vectors, with (k⃗, γ⃗) = f₁. Time t. Forms: ODE and action of
    SO(3). ``state(gamma=…, k=…)``; instead of k also w with (w⃗, γ⃗) = f₁, or p or p_tilde for
    k⃗ = p⃗ × γ⃗ + f₁γ⃗.

    Parameters
    ----------
    a, D
        See `Veselova`; 𝓘_1 = 1/(a_2 a_3), 𝓘_2 = 1/(a_1 a_3), 𝓘_3 = 1/(a_1 a_2).
    f1 : float
        The value of the constraint (w⃗, γ⃗); Veselova's own problem has 0, and is the reduced one.

    Raises
    ------
    geomint.DomainError
        If n is not 3; from ``state`` and ``canonical`` for what describes no state.
    """
    if len(a) != 3:
        raise gi.DomainError("n", len(a), "dimension 3, where so(n) is R³")
    level = float(gi.as_vector("f1", f1, 1)[0])
    inverse = np.array([a[1] * a[2], a[0] * a[2], a[0] * a[1]])

    def make_state(gamma: Any = None, **components: Any) -> Array:
        name = one_of(components, KEYS)
        if name in TANGENT:
            vertical, p = veselova_tangent(a, D, gamma, **components)
            return np.concatenate([np.cross(p, vertical) + level * vertical, vertical])
        vertical = gi.Sphere(3).point(gamma)
        triangle = skew_components(name, components[name], 3, vector=True)
        v = on_level(vertical, vector_of_triangle(triangle), level, name)
        if name == "w":
            momentum = v / inverse
            v = momentum + (level - vertical @ momentum) * vertical
        return np.concatenate([v, vertical])

    def make_random(rng: np.random.Generator) -> Named:
        gamma, p = gi.TangentSphere(3).random(rng).values()
        return {"gamma": gamma, "k": p + level * gamma}

    def admit(y: Array) -> Array:
        k, vertical = VECTORS.split(VECTORS.admit(y)).values()
        return np.concatenate([admit_on_level(vertical, k, level), vertical])

    return gi.Problem(
        name="veselova-classical",
        equations=(
            "k̇ = k × w,  γ̇ = γ × w",
            "w = 𝓘⁻¹(k + mγ),  (w, γ) = (k, γ) = f₁",
        ),
        space=VECTORS,
        params=gi.packed(LEVEL, B=inverse, f1=level).data,
        field=veselova_vectors_field,
        action=gi.GroupAction(veselova_vectors_generator, gi.so3(2)),
        invariants={"energy": veselova_vectors_energy, "K": classical_k},
        constraints={"constraint": veselova_constraint},
        measure=gi.Measure(veselova_vectors_log_density, level_conditions, 2),
        make_state=make_state,
        make_exact=exact_body(inverse, level),
        make_random=make_random,
        admit=admit,
        physical=vector_arrays,
        parameters={"a": a.tolist(), "D": D, "f1": level},
        references=VESELOVA,
    )
