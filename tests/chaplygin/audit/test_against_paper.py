"""The package's own problems against the motion from d'Alembert's principle: no claims of the paper.

Fields and energies are evaluated in plain Python by `geomint.problems.evaluate`, at the sampler's
states.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import geomint as gi
from geomint.problems.evaluate import derivative as field_of, value

from ..ball.classical import classical_problem
from ..ball.hamiltonized import hamiltonized_problem
from ..ball.momentum import ball_problem
from ..ball.reduced import reduced_problem
from ..ball.rolling import rolling_problem
from ..inertia import GeneralInertia, SpecialInertia
from ..veselova.classical import veselova_classical_problem
from ..veselova.hamiltonized import veselova_hamiltonized_problem
from ..veselova.reduced import veselova_reduced_problem
from .algebra import Array, coordinates, inner, wedge
from .calculus import derivative
from .claim import Section, Sides
from .claims_classical import classical_field, tensor_of
from .claims_multiplier import flow_in_tau, to_tau
from .claims_reduction import true_rates
from .claims_veselova import capital_k, extended
from .claims_veselova_reduced import veselova_rates
from .momenta import contact_momentum
from .motion import general_motion
from .points import Point

__all__ = ["claim"]

claim = Section("The package's problems against the motion")


def special(point: Point) -> SpecialInertia:
    """Return the package's special operator of the point."""
    return SpecialInertia(point.a, point.D)


def general(point: Point) -> GeneralInertia:
    """Return the package's general operator of the point."""
    return GeneralInertia(point.general)


def energy_of(problem: gi.Problem, y: Array) -> float:
    """Return the problem's invariant "energy"."""
    return value(problem, problem.invariants["energy"], y)


def with_energy(problem: gi.Problem, y: Array, rate: Array, energy: Any) -> Sides:
    """Return field and energy of the problem, and the true ones."""
    return [*field_of(problem, y), energy_of(problem, y)], [*rate, energy]


@claim("package:rolling", "rolling_problem: ġ, ṙ, ω̇, v̇ and the energy", "", n=range(2, 7))
def rolling(point: Point) -> Sides:
    moving, g = general_motion(point), point.g
    problem = rolling_problem(general(point), point.m, point.rho)
    flat, V = coordinates(moving.omega), moving.V[:-1]
    y = np.concatenate([g.reshape(-1), np.zeros(point.n - 1), flat, V])
    turned = (g @ moving.omega).reshape(-1)
    rate = [*turned, *V, *coordinates(moving.omega_dot), *moving.V_dot[:-1]]
    energy = 0.5 * (flat @ point.general @ flat) + 0.5 * point.m * (moving.V @ moving.V)
    return with_energy(problem, y, np.array(rate), energy)


@claim(
    "package:ball",
    "ball_problem: k̇, γ̇ and the energy, any operator and momentum",
    "",
    n=range(2, 7),
)
def ball(point: Point) -> Sides:
    moving = general_motion(point)
    k, k_dot = contact_momentum(point, point.general, moving.omega, moving.omega_dot)
    problem = ball_problem(general(point), point.D)
    y = np.concatenate([coordinates(k), point.gamma])
    rate = np.concatenate([coordinates(k_dot), (point.g @ moving.omega).T @ point.Gamma])
    return with_energy(problem, y, rate, 0.5 * inner(k, moving.omega))


@claim("package:classical", "classical_problem: dk⃗/dt, dγ⃗/dt", "", n=(3,))
def classical(point: Point) -> Sides:
    problem = classical_problem(general(point), point.D)
    y = np.concatenate([point.normal("k", 3), point.gamma])
    return field_of(problem, y), classical_field(point, tensor_of(point, point.general), y)


@claim("package:reduced", "reduced_problem: γ̇, ṗ and the energy, special and general operator", "")
def reduced(point: Point) -> Sides:
    left, right = [], []
    for matrix, inertia in ((point.special, special(point)), (point.general, general(point))):
        k = wedge(point.gamma, point.p)
        energy = 0.5 * inner(k, point.omega_of(matrix, k, point.gamma))
        rate = np.concatenate(true_rates(point, matrix))
        problem = reduced_problem(inertia, point.D)
        found, true = with_energy(problem, point.state, rate, energy)
        left += found
        right += true
    return left, right


@claim("package:hamiltonized", "hamiltonized_problem: γ′, p̃′ and the energy", "")
def hamiltonized(point: Point) -> Sides:
    k = wedge(point.gamma, point.p)
    energy = 0.5 * inner(k, point.omega_of(point.special, k, point.gamma))
    rate = np.concatenate(true_rates(point, point.special))
    problem = hamiltonized_problem(special(point))
    prime = flow_in_tau(point, point.state, rate)
    return with_energy(problem, to_tau(point, point.state), prime, energy)


@claim("package:veselova-reduced", "veselova_reduced_problem: γ̇, ṗ", "", n=range(3, 7))
def veselova_reduced(point: Point) -> Sides:
    problem = veselova_reduced_problem(point.a, point.D)
    return field_of(problem, point.state), veselova_rates(point)


@claim("package:veselova-hamiltonized", "veselova_hamiltonized_problem: γ′, p̃′", "", n=range(3, 7))
def veselova_hamiltonized(point: Point) -> Sides:
    problem = veselova_hamiltonized_problem(point.a, point.D)
    prime = flow_in_tau(point, point.state, veselova_rates(point))
    return field_of(problem, to_tau(point, point.state)), prime


@claim(
    "package:veselova-classical", "veselova_classical_problem: dk⃗/dt, dγ⃗/dt at any f_1", "", n=(3,)
)
def veselova_classical(point: Point) -> Sides:
    a = point.a
    tensor = np.diag([1.0 / (a[1] * a[2]), 1.0 / (a[0] * a[2]), 1.0 / (a[0] * a[1])])
    w = point.normal("w", 3)
    z = np.concatenate([w, point.gamma])
    K, rate = capital_k(tensor, z), extended(tensor, z)
    problem = veselova_classical_problem(a, point.D, float(w @ point.gamma))
    K_dot = derivative(lambda x: capital_k(tensor, x), z, rate)
    return field_of(problem, np.concatenate([K, point.gamma])), [*K_dot, *rate[3:]]
