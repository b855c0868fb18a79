"""The package's problems against the audit's motion, at random points.

The motion is that of d'Alembert's principle or, at n = 3 and any momentum, of equations that the audit
has compared with it. Fields and energies are run in plain Python. The audit shares no code with the
problems, so that what agrees here was derived twice; to agree is to be within `HOLDS`.
"""

from __future__ import annotations

import numpy as np
import pytest

import chaplygin
import geomint as gi
from tests.paper.algebra import coordinates, inner, wedge
from tests.paper.calculus import derivative
from tests.paper.claim import HOLDS, residual
from tests.paper.classical import capital_k, classical_field, tensor_of, veselova_field
from tests.paper.equations import flow_in_tau, to_tau
from tests.paper.momenta import contact_momentum, true_rates, veselova_rates
from tests.paper.motion import general_motion
from tests.paper.points import sample

POINTS = 20  # of each problem at least, as many in each of its dimensions


def with_energy(problem, y, rate, energy):
    """Return field and energy of the problem, and the true ones."""
    found = gi.value(problem, problem.invariants["energy"], y)
    return [*gi.derivative(problem, y), found], [*rate, energy]


def rolling(point):
    """ġ, ṙ, ω̇, v̇ and the energy, any operator and momentum."""
    moving, g = general_motion(point), point.g
    problem = chaplygin.rolling_problem(chaplygin.GeneralInertia(point.general), point.m, point.rho)
    flat, V = coordinates(moving.omega), moving.V[:-1]
    y = np.concatenate([g.reshape(-1), np.zeros(point.n - 1), flat, V])
    turned = (g @ moving.omega).reshape(-1)
    rate = [*turned, *V, *coordinates(moving.omega_dot), *moving.V_dot[:-1]]
    energy = 0.5 * (flat @ point.general @ flat) + 0.5 * point.m * (moving.V @ moving.V)
    return with_energy(problem, y, rate, energy)


def ball(point):
    """k̇, γ̇ and the energy, any operator and momentum."""
    moving = general_motion(point)
    k, k_dot = contact_momentum(point, point.general, moving)
    problem = chaplygin.ball_problem(chaplygin.GeneralInertia(point.general), point.D)
    y = np.concatenate([coordinates(k), point.gamma])
    rate = [*coordinates(k_dot), *((point.g @ moving.omega).T @ point.Gamma)]
    return with_energy(problem, y, rate, 0.5 * inner(k, moving.omega))


def classical(point):
    """dk⃗/dt, dγ⃗/dt."""
    problem = chaplygin.classical_problem(chaplygin.GeneralInertia(point.general), point.D)
    y = np.concatenate([point.normal("k", 3), point.gamma])
    return gi.derivative(problem, y), classical_field(point, tensor_of(point.general), y)


def zero_momentum_energy(point, matrix):
    """Return ½⟨k, ω⟩ at k = γ∧p."""
    k = wedge(point.gamma, point.p)
    return 0.5 * inner(k, point.omega_of(matrix, k, point.gamma))


def reduced(point):
    """γ̇, ṗ and the energy, special and general operator."""
    special, general = (
        chaplygin.SpecialInertia(point.a, point.D),
        chaplygin.GeneralInertia(point.general),
    )
    left, right = [], []
    for matrix, inertia in ((point.special, special), (point.general, general)):
        rate = np.concatenate(true_rates(point, matrix))
        energy = zero_momentum_energy(point, matrix)
        found, true = with_energy(
            chaplygin.reduced_problem(inertia, point.D), point.state, rate, energy
        )
        left += found
        right += true
    return left, right


def hamiltonized(point):
    """γ′, p̃′ and the energy."""
    problem = chaplygin.hamiltonized_problem(chaplygin.SpecialInertia(point.a, point.D))
    rate = np.concatenate(true_rates(point, point.special))
    prime = flow_in_tau(point, point.state, rate)
    energy = zero_momentum_energy(point, point.special)
    return with_energy(problem, to_tau(point, point.state), prime, energy)


def veselova_reduced(point):
    """γ̇, ṗ."""
    problem = chaplygin.veselova_reduced_problem(point.a, point.D)
    return gi.derivative(problem, point.state), veselova_rates(point)


def veselova_hamiltonized(point):
    """γ′, p̃′."""
    problem = chaplygin.veselova_hamiltonized_problem(point.a, point.D)
    prime = flow_in_tau(point, point.state, veselova_rates(point))
    return gi.derivative(problem, to_tau(point, point.state)), prime


def veselova_classical(point):
    """dK⃗/dt, dγ⃗/dt at any f_1."""
    a = point.a
    tensor = np.diag([1.0 / (a[1] * a[2]), 1.0 / (a[0] * a[2]), 1.0 / (a[0] * a[1])])
    w = point.normal("w", 3)
    z = np.concatenate([w, point.gamma])
    K, rate = capital_k(tensor, z), veselova_field(tensor, z)
    problem = chaplygin.veselova_classical_problem(a, point.D, float(w @ point.gamma))
    K_dot = derivative(lambda x: capital_k(tensor, x), z, rate)
    return gi.derivative(problem, np.concatenate([K, point.gamma])), [*K_dot, *rate[3:]]


PROBLEMS = {
    rolling: range(2, 8),
    ball: range(2, 8),
    classical: (3,),
    reduced: range(2, 8),
    hamiltonized: range(2, 8),
    veselova_reduced: range(3, 8),
    veselova_hamiltonized: range(3, 8),
    veselova_classical: (3,),
}


@pytest.mark.parametrize("sides", PROBLEMS, ids=lambda sides: sides.__name__)
def test_a_problem_moves_as_the_motion_does(sides):
    dimensions = PROBLEMS[sides]
    found = {
        (n, index): residual(sides(sample(n, index)))
        for n in dimensions
        for index in range(-(-POINTS // len(dimensions)))
    }
    assert max(found.values()) <= HOLDS, max(found, key=found.get)
