"""Section 1, Introduction: nonholonomic systems, symmetries, reduction."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from .algebra import Array, apply, bracket, coordinates, inner, project, rank, skew, wedge
from .calculus import derivative, gradient, slope_at_zero
from .claim import Section, Sides
from .equations import multiplier, ro
from .momenta import contact_momentum, space_momentum
from .motion import ball_motion, general_motion
from .particles import Particles
from .points import Point, around_vertical, horizontal_rotation
from .reduction import (
    CONVENTION,
    Vector,
    almost_hamiltonian_on_bundle,
    canonical_group_form,
    closed_form,
    curvature_form,
    energy_slope,
    group_exterior_derivative,
    reduced_form,
    truncated_form,
)
from .two_forms import canonical, exterior_derivative, symplectic_divergence, tangent_basis

__all__ = ["claim"]

claim = Section("1 Introduction")
claim.unchecked("constraints", "(α^j, q̇) = 0", "74", "definition")


@claim(
    "Hamilton", "d/dt ∂L/∂q̇ + ∂L/∂q = Σ λ_j α^j", "80–84", misprint="d/dt ∂L/∂q̇ − ∂L/∂q = Σ λ_j α^j"
)
def hamilton(point: Point, corrected: bool) -> Sides:
    system = Particles(point)
    rate, force = system.newton()
    slope = gradient(lambda q: system.lagrangian(q, system.v), system.q)
    left = system.momentum_rate(rate) + (-slope if corrected else slope)
    return left, system.constraints(system.q).T @ force


@claim("ham:eq", "q̇ = ∂H/∂p, ṗ = −∂H/∂q + Σ λ_j α^j on p = κ q̇", "94–105")
def ham_eq(point: Point) -> Sides:
    system = Particles(point)
    rate, force = system.newton()
    q, p = system.q, system.metric(system.q) @ system.v
    left = np.concatenate([system.v, system.momentum_rate(rate)])
    second = -gradient(lambda z: system.hamiltonian(z, p), q)
    first = gradient(lambda z: system.hamiltonian(q, z), p)
    return left, np.concatenate([first, second + system.constraints(q).T @ force])


@claim("text:energy", "H is a first integral of (ham:eq)", "106–107")
def energy(point: Point) -> Sides:
    system = Particles(point)
    q, p = system.q, system.metric(system.q) @ system.v
    slope = gradient(
        lambda z: system.hamiltonian(z[: system.d], z[system.d :]), np.concatenate([q, p])
    )
    terms = slope * np.concatenate([system.v, system.momentum_rate(system.newton()[0])])
    return np.sum(terms), 0.0, np.sum(np.abs(terms))


@claim(
    "moment_map",
    "Noether: (p, ξ_Q) is conserved if ξ_Q is a section of 𝒟; rotations of the ball about Γ",
    "109–124",
    n=range(3, 8),
)
def noether(point: Point) -> Sides:
    xi = around_vertical(point, "xi")
    moving = general_motion(point)
    M, rate = space_momentum(point, point.general, moving)
    return inner(rate, xi), 0.0, np.sqrt(inner(M, M) * inner(xi, xi))


@claim(
    "text:sections",
    "the vector fields of rotations about Γ are sections of 𝒟",
    "204–206",
    n=range(3, 8),
)
def sections(point: Point) -> Sides:
    xi = around_vertical(point, "xi")
    return np.zeros(point.n) - point.rho * (xi @ point.Gamma), np.zeros(point.n), np.abs(xi)


claim.unchecked(
    "dim:uslov", "T_qQ = 𝒟_q ⊕ 𝔨_q", "129–132", "definition; for the ball it is checked as bundle*"
)


@claim(
    "red:eq",
    "i_X(Ω + Ξ) = dH_red on T*SO(n), Ξ from momentum and curvature",
    "140–148",
    restriction=CONVENTION,
)
def red_eq(point: Point, restricted: bool) -> Sides:
    return almost_hamiltonian(point, partial(curvature_form, point), restricted)


def almost_hamiltonian(point: Point, extra: Any, convention: bool) -> Sides:
    """Return w(X, Y) or, with the convention, w(Y, X), and dH(Y), at a random tangent vector Y.

    w is Ω + `extra`.
    """
    moving = general_motion(point)
    k, k_dot = contact_momentum(point, point.general, moving)
    X, Y = (moving.omega, k_dot), (point.skew("eta"), point.skew("kappa"))
    pair = (Y, X) if convention else (X, Y)
    left = canonical_group_form(k, *pair) + extra(moving.omega, *pair)
    size = np.sqrt(inner(k_dot, k_dot) * inner(Y[0], Y[0]))
    return left, energy_slope(point, point.general, k, Y), size


@claim(
    "text:measure",
    "d(𝒩(Ω+Ξ)) = 0 ⇒ invariant measure 𝒩^(d−1) Ω^d; special ball on T*S^(n−1)",
    "156–161",
)
def measure_of_multiplier(point: Point) -> Sides:
    y, d = point.state, point.n - 1
    value, size = symplectic_divergence(lambda z: ro(point, z), y)
    rate = derivative(lambda z: np.log(multiplier(point, z[: point.n])), y, ro(point, y))
    return value, -(d - 1) * rate, size


@claim(
    "text:d=2",
    "d = 2: an invariant measure ⇒ Ω + Ξ (printed ω + Ξ) conformally symplectic; any "
    "ball, n = 3, 𝒩 = density",
    "161–164",
    n=(3,),
)
def conformal_in_dimension_two(point: Point) -> Sides:
    def form(y: Array, Y: Array, Z: Array) -> Any:
        gamma, p = y[:3], y[3:]
        factor = 1.0 / np.sqrt(np.linalg.det(point.metric(point.general, gamma)))
        omega = point.omega_of(point.general, wedge(gamma, p), gamma)
        return factor * reduced_form(point.D, y, omega, Y, Z)

    value, size = exterior_derivative(form, point.state, *tangent_basis(point.state)[:3])
    return value, 0.0, size


@claim(
    "text:LR",
    "LR systems have an invariant measure: √det⟨C_i, I⁻¹C_j⟩, random constraints C_i",
    "168–170",
    n=range(2, 6),
)
def lr_measure(point: Point) -> Sides:
    n, size = point.n, len(point.general)
    inverse = np.linalg.inv(point.general)
    rows = point.normal("forms", max(1, size // 2), size)
    bodies = [point.g.T @ skew(row, n) @ point.g for row in rows]

    def gram(forms: list[Array]) -> Array:
        flat = np.array([coordinates(C) for C in forms])
        return np.asarray(flat @ inverse @ flat.T)

    def rate(w: Array) -> Array:
        omega = skew(w, n)
        free = inverse @ coordinates(bracket(apply(point.general, omega), omega))
        flat = np.array([coordinates(C) for C in bodies])
        return np.asarray(free - inverse @ flat.T @ np.linalg.solve(gram(bodies), flat @ free))

    w = coordinates(point.omega)
    terms = [derivative(rate, w, e)[i] for i, e in enumerate(np.eye(size))]

    def log_density(s: Any) -> Any:
        moved = [C + s * bracket(C, point.omega) for C in bodies]
        return 0.5 * np.log(np.linalg.det(gram(moved)))

    return sum(terms), -slope_at_zero(log_density), np.sum(np.abs(terms))


@claim(
    "bundle*",
    "the ball is an R^(n−1)-Chaplygin system: T(SO(n)×R^(n−1)) = 𝒟 ⊕ R^(n−1), dim 𝒟 = dim SO(n)",
    "183–200",
)
def chaplygin_system(point: Point) -> Sides:
    n = point.n
    size = n * (n - 1) // 2
    rolled = [point.rho * (point.g @ skew(e, n) @ point.gamma) for e in np.eye(size)]
    distribution = [np.concatenate([e, V]) for e, V in zip(np.eye(size), rolled, strict=True)]
    planes = [np.concatenate([np.zeros(size), e]) for e in np.eye(n)[:-1]]
    ranks = [rank(distribution), rank(planes), rank([*distribution, *planes])]
    return ranks, [size, n - 1, size + n - 1]


@claim("mom:map", "Φ = pr_so(n−1) Ad_g k: equivariant, and Φ̇ = 0", "206–212", n=range(3, 8))
def momentum_map(point: Point) -> Sides:
    moving = general_motion(point)
    k, k_dot = contact_momentum(point, point.general, moving)
    turn = horizontal_rotation(point)
    first = vertical_part(point, turn @ point.g @ k @ point.g.T @ turn.T)
    second = turn @ vertical_part(point, point.g @ k @ point.g.T) @ turn.T
    change = point.g @ (bracket(moving.omega, k) + k_dot) @ point.g.T
    left = np.concatenate([coordinates(first), coordinates(vertical_part(point, change))])
    return left, np.concatenate([coordinates(second), np.zeros(len(left) // 2)])


def vertical_part(point: Point, X: Array) -> Array:
    """Return pr_so(n−1) X in space."""
    return X - project(X, point.Gamma)


@claim(
    "text:symmetry",
    "the reduced system is invariant under g ↦ hg, hΓ = Γ",
    "202–203",
    n=range(3, 8),
)
def symmetry(point: Point) -> Sides:
    turned = point.with_(g=horizontal_rotation(point) @ point.g)
    one = general_motion(point)
    other = ball_motion(turned, point.general, point.omega)
    return one.omega_dot, other.omega_dot


@claim(
    "text:not-momentum",
    "Φ is not the momentum mapping of SO(n−1) for Ω + Ξ",
    "214–215",
    n=range(3, 8),
    negative=True,
)
def not_momentum(point: Point) -> Sides:
    return momentum_defect(point, partial(curvature_form, point))


@claim(
    "text:truncated",
    "Ξ̃ exists for which Φ is the momentum mapping; D(η_Zγ, ωη_Yγ)",
    "215–219",
    n=range(3, 8),
)
def truncated_momentum(point: Point) -> Sides:
    return momentum_defect(point, partial(truncated_form, point.D, point.gamma))


def momentum_defect(point: Point, extra: Any) -> Sides:
    """Return w(Y, ξ) and d⟨Φ, ξ⟩(Y) for the field ξ of a rotation about Γ."""
    k, xi = point.skew("k"), around_vertical(point, "xi")
    omega = point.omega_of(point.general, k, point.gamma)
    body = point.g.T @ xi @ point.g
    field, Y = (body, np.zeros_like(k)), (point.skew("eta"), point.skew("kappa"))
    # The rotation moves g by gη with η = g⁻¹ξg and leaves k as it is; Φ_ξ = ⟨k, g⁻¹ξg⟩.
    left = canonical_group_form(k, Y, field) + extra(omega, Y, field)
    return left, inner(Y[1], body) + inner(k, bracket(body, Y[0]))


@claim(
    "text:truncated-flow",
    "i_X(Ω + Ξ̃) = dH_red",
    "219–221",
    restriction=CONVENTION,
    finding="red:eq",
)
def truncated_flow(point: Point, restricted: bool) -> Sides:
    extra = partial(truncated_form, point.D, point.gamma)
    return almost_hamiltonian(point, extra, restricted)


claim(
    "red:eq2",
    "i_X w_η = dH_η, evaluated at η = 0 on T*S^(n−1)",
    "223–233",
    restriction=CONVENTION,
    finding="red:eq",
)(almost_hamiltonian_on_bundle)


@claim(
    "text:homogeneous-hamiltonian",
    "homogeneous ball: the reduced systems are Hamiltonian in t, any η",
    "235–237",
    n=range(2, 6),
)
def homogeneous_hamiltonian(point: Point) -> Sides:
    """Ω + (D/s)⟨k, [·,·]⟩ on the vertical momentum differs from Ω + Ξ̃ by a form with i_X = 0."""
    return homogeneous(point, closed=True, momentum=True)


@claim(
    "text:homogeneous-forms",
    "homogeneous ball: the forms w_η = Ω + Ξ̃ are closed on Φ = η",
    "235–237",
    n=range(2, 6),
    restriction="n = 3 or η = 0; for n ≥ 4 and η ≠ 0 a form with i_X = 0 must be added to Ξ̃: "
    "(D/s)⟨k, [η_Y, η_Z]⟩ of the parts in so(n−1)",
)
def homogeneous_forms(point: Point, restricted: bool) -> Sides:
    if restricted:
        return homogeneous(point, closed=False, momentum=point.n < 4)
    return homogeneous(point, closed=False, momentum=True)


def homogeneous(point: Point, closed: bool, momentum: bool) -> Sides:
    """Return dw on vectors tangent to Φ = η, and i_X w − dH, for I = s."""
    n = point.n
    inertia = 0.7 * np.eye(n * (n - 1) // 2)
    k = point.skew("k") if momentum else project(point.skew("k"), point.gamma)

    def form(g: Array, k: Array, Y: Vector, Z: Vector) -> Any:
        gamma = g.T @ point.Gamma
        if closed:
            extra = closed_form(point.D / 0.7, gamma, k, Y, Z)
        else:
            extra = truncated_form(point.D, gamma, point.omega_of(inertia, k, gamma), Y, Z)
        return canonical_group_form(k, Y, Z) + extra

    def tangent(key: str) -> Vector:
        """Φ_η = const: the part of κ + [η, k] orthogonal to R^n∧γ vanishes."""
        eta, kappa = point.skew(key), point.skew(key + "k")
        change = kappa + bracket(eta, k)
        return eta, kappa - (change - project(change, point.gamma))

    Y, Z, W = (tangent(key) for key in ("Y", "Z", "W"))
    value, size = group_exterior_derivative(form, point.g, k, Y, Z, W)
    omega = point.omega_of(inertia, k, point.gamma)
    X = (omega, bracket(k, omega))
    flow = form(point.g, k, Y, X) - energy_slope(point, inertia, k, Y)
    return [value, flow], [0.0, 0.0], size


@claim(
    "sym:red",
    "M_η is an 𝒪_η-bundle over T*S^(n−1) (printed T*S) in so(n)*×S^(n−1): dimensions",
    "239–251",
    n=range(3, 8),
)
def symplectic_reduction(point: Point) -> Sides:
    n = point.n
    eta = around_vertical(point, "eta")
    generators = [np.eye(n - 1)[[i, j]] for i in range(n - 1) for j in range(i + 1, n - 1)]
    group = len(generators)
    orbit = rank([coordinates(bracket(eta[:-1, :-1], wedge(*pair))) for pair in generators])
    reduced = n * (n - 1) - group - (group - orbit)
    inside = n * (n - 1) // 2 + n - 1 - (group - orbit)
    return [reduced, inside], [2 * (n - 1) + orbit] * 2


@claim(
    "text:trivial-orbits",
    "n = 3: all M_η are T*S²; n > 3, η ≠ 0: the orbits 𝒪_η are not points",
    "283–289",
    n=range(3, 8),
)
def trivial_orbits(point: Point) -> Sides:
    eta, other = around_vertical(point, "eta"), around_vertical(point, "xi")
    moves = np.max(np.abs(bracket(eta, other))) > 1e-3
    return float(moves), float(point.n > 3)


@claim("text:semi-basic", "w_0 is a semi-basic perturbation of ω on T*S^(n−1)", "253–257")
def semi_basic(point: Point) -> Sides:
    n, y = point.n, point.state
    omega = point.omega_of(point.general, wedge(point.gamma, point.p), point.gamma)
    Y = point.normal("Y", tangent_basis(y).shape[0]) @ tangent_basis(y)
    along = point.normal("Z", n)
    fibre = np.concatenate([np.zeros(n), along - (along @ point.gamma) * point.gamma])
    return reduced_form(point.D, y, omega, Y, fibre), canonical(y, Y, fibre)
