"""The package's problems against the audit's motion, at random points.

The motion is that of d'Alembert's principle or, at n = 3 and any momentum, of equations that the audit
has compared with it. Fields and energies are run in plain Python. The audit shares no code with the
problems, so that what agrees here was derived twice; to agree is to be within `HOLDS`. Operators are
special, diagonal and full ones by turns.
"""

from __future__ import annotations

import numpy as np
import pytest

import chaplygin
import geomint as gi
from tests.paper.algebra import apply, coordinates, inner, project, skew, wedge
from tests.paper.calculus import derivative
from tests.paper.claim import HOLDS, residual
from tests.paper.classical import capital_k, classical_field, tensor_of, veselova_field
from tests.paper.equations import flow_in_tau, log_rho, to_tau
from tests.paper.momenta import contact_momentum, true_rates, veselova_rates
from tests.paper.motion import accelerations, ball_motion, constrained_rotation
from tests.paper.points import sample
from tests.paper.stiefel import constraint_forms, rank_of, stiefel, stiefel_rates, veselova_motion

POINTS = 6  # of each problem at least, as many in each of its dimensions; with all operators


def operator(point):
    """Return an operator of each kind by turns, and its matrix."""
    kind = point.seed[-1] % 3
    if kind == 0:
        return chaplygin.SpecialInertia(point.a, point.D), point.special
    matrix = np.diag(np.diag(point.general)) if kind == 1 else point.general
    return chaplygin.GeneralInertia(matrix), matrix


def with_energy(problem, y, rate, energy, **others):
    """Return field, energy and other quantities of the problem, and the true ones."""
    quantities = {"energy": energy, **others}
    found = [gi.value(problem, name, y) for name in quantities]
    return [*gi.derivative(problem, y), *found], [*rate, *quantities.values()]


def of_contact(point, moving):
    """Return what a ball on the plane shows, by name."""
    force, V = moving.Lambda[:-1], moving.V[:-1]
    shown = {f"reaction-{i + 1}": x for i, x in enumerate(force)}
    shown |= {"reaction": np.linalg.norm(force), "power": force @ V, "speed": np.linalg.norm(V)}
    return shown | {f"contact-{i + 1}": 0.5 + i for i in range(point.n - 1)}


def of_momentum(point, k, omega):
    """Return what a ball with momentum k keeps, by name."""
    about = k - project(k, point.gamma)
    shown = {"K": inner(k, k), "momentum": inner(about, about), "trace-k4": np.trace(k @ k @ k @ k)}
    pivoting = omega - project(omega, point.gamma)
    shown["pivoting"] = np.sqrt(inner(pivoting, pivoting))
    least = {"K": 2, "momentum": 3, "pivoting": 3, "trace-k4": 4}
    return {name: x for name, x in shown.items() if point.n >= least[name]}


def rolling(point):
    """ġ, ṙ, ω̇, v̇, the energy, the reaction and all integrals, any operator and momentum."""
    inertia, matrix = operator(point)
    moving, g = ball_motion(point, matrix, point.omega), point.g
    problem = chaplygin.rolling_problem(inertia, point.m, point.rho)
    flat, V = coordinates(moving.omega), moving.V[:-1]
    y = np.concatenate([g.reshape(-1), 0.5 + np.arange(point.n - 1), flat, V])
    turned = (g @ moving.omega).reshape(-1)
    rate = [*turned, *V, *coordinates(moving.omega_dot), *moving.V_dot[:-1]]
    energy = 0.5 * (flat @ matrix @ flat) + 0.5 * point.m * (moving.V @ moving.V)
    kept = of_momentum(point, contact_momentum(point, matrix, moving)[0], moving.omega)
    return with_energy(problem, y, rate, energy, **of_contact(point, moving), **kept)


def contact(point):
    """k̇, γ̇, ġ, ṙ, and the same quantities."""
    inertia, matrix = operator(point)
    moving, g = ball_motion(point, matrix, point.omega), point.g
    k, k_dot = contact_momentum(point, matrix, moving)
    problem = chaplygin.contact_problem(inertia, point.m, point.rho)
    turned, r = (g @ moving.omega).reshape(-1), 0.5 + np.arange(point.n - 1)
    y = np.concatenate([coordinates(k), point.gamma, g.reshape(-1), r])
    rate = [*coordinates(k_dot), *turned[-point.n :], *turned, *moving.V[:-1]]
    shown = of_contact(point, moving) | of_momentum(point, k, moving.omega)
    return with_energy(problem, y, rate, 0.5 * inner(k, moving.omega), **shown)


def rubber(point):
    """ġ, ṙ, ω̇, v̇ of the ball that may not twist, and its reactions: both constraints by hand."""
    inertia, matrix = operator(point)
    n, size = point.n, len(matrix)
    ball = chaplygin.RubberSphere(inertia, point.D)
    problem = ball.rolling(rho=point.rho)
    omega = project(point.omega, point.gamma)
    bound = [wedge(np.eye(n)[i], np.eye(n)[j]) for i in range(n - 1) for j in range(i + 1, n - 1)]
    metric = np.block([[matrix, np.zeros((size, n))], [np.zeros((n, size)), point.m * np.eye(n)]])

    def velocity(x, v):
        half, one = 0.5 * skew(x[:size], n), np.eye(n)
        turning = np.linalg.solve(one + half, skew(v[:size], n)) @ np.linalg.inv(one - half)
        return np.concatenate([coordinates(turning), v[size:]])

    def constraints(x):
        half, one = 0.5 * skew(x[:size], n), np.eye(n)
        g = point.g @ np.linalg.solve(one - half, one + half)
        basis = np.hstack([np.eye(size), np.zeros((size, n))])
        turned = [g @ skew(velocity(x, e)[:size], n) @ g.T for e in basis]
        slip = np.hstack([-point.rho * np.array([w @ point.Gamma for w in turned]).T, np.eye(n)])
        twist = [[inner(w, C) for w in turned] + [0.0] * n for C in bound]
        return np.vstack([slip, np.reshape(twist, (-1, size + n))])

    V = point.rho * (point.g @ omega @ point.gamma)
    moving = np.concatenate([coordinates(omega), V])
    rate, forces = accelerations(velocity, metric, constraints, np.zeros(size + n), moving)
    r, flat = 0.5 + np.arange(n - 1), coordinates(omega)
    y = np.concatenate([point.g.reshape(-1), r, flat, V[:-1]])
    rates = [*(point.g @ omega).reshape(-1), *V[:-1], *rate[:-1]]
    energy = 0.5 * flat @ matrix @ flat + 0.5 * point.m * V @ V
    k = project(apply(matrix, omega) + point.D * omega, point.gamma)
    acting = forces[: n - 1]
    shown = {f"reaction-{i + 1}": x for i, x in enumerate(acting)}
    shown |= {"power": acting @ V[:-1], "speed": np.linalg.norm(V), "K": inner(k, k)}
    if bound:
        shown["torque"] = np.linalg.norm(forces[n:])
    return with_energy(problem, y, rates, energy, **shown)


def lr(point):
    """ġ, ẇ, the multipliers and the momenta in space of Veselova's problem, any r and operator."""
    r, (inertia, matrix) = rank_of(point), operator(point)
    forms, planes = constraint_forms(point), len(constraint_forms(point))
    w, _ = veselova_motion(point)
    rate, acting = constrained_rotation(point, matrix, w, forms)
    problem = chaplygin.lr_problem(inertia, r)
    y = np.concatenate([point.g.reshape(-1), coordinates(w)])
    rates = [*(point.g @ w).reshape(-1), *coordinates(rate)]
    in_space = point.g @ apply(matrix, w) @ point.g.T
    shown = {
        f"momentum-{i + 1}-{j + 1}": in_space[i, j] for i in range(r) for j in range(i + 1, point.n)
    }
    shown["multipliers"] = np.linalg.norm(acting)
    if planes <= 6:
        pairs = [(p, q) for p in range(r, point.n) for q in range(p + 1, point.n)]
        shown |= {f"multiplier-{p + 1}-{q + 1}": x for (p, q), x in zip(pairs, acting, strict=True)}
    return with_energy(problem, y, rates, 0.5 * inner(apply(matrix, w), w), **shown)


def stiefel_variety(point):
    """Ẋ and Ṗ on T*V(n, r)."""
    X, _, w = stiefel(point)
    X_rate, P_rate = stiefel_rates(point)[1]
    inertia = chaplygin.GeneralInertia(point.general)
    problem = chaplygin.stiefel_problem(inertia, rank_of(point))
    y = problem.state(**{problem.pieces[0][0]: X.T if rank_of(point) > 1 else X[:, 0], "w": w})
    energy = 0.5 * inner(apply(point.general, w), w)
    return with_energy(problem, y, [*X_rate.T.ravel(), *P_rate.T.ravel()], energy)


def ball(point):
    """k̇, γ̇, ġ, the energy and the density ϱ up to a constant, any operator and momentum."""
    inertia, matrix = operator(point)
    moving = ball_motion(point, matrix, point.omega)
    k, k_dot = contact_momentum(point, matrix, moving)
    turned = (point.g @ moving.omega).reshape(-1)
    problem = chaplygin.ball_problem(inertia, point.D, attitude=True)
    y = np.concatenate([coordinates(k), point.gamma, point.g.reshape(-1)])
    rate = [*coordinates(k_dot), *((point.g @ moving.omega).T @ point.Gamma), *turned]
    kept = of_momentum(point, k, moving.omega)
    kept.pop("pivoting", None)
    return with_energy(problem, y, rate, 0.5 * inner(k, moving.omega), **kept)


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
    """γ̇, ṗ and the energy."""
    problem, rate = chaplygin.veselova_reduced_problem(point.a, point.D), veselova_rates(point)
    return with_energy(problem, point.state, rate, 0.5 * point.p @ rate[: point.n])


def veselova_hamiltonized(point):
    """γ′, p̃′ and the energy."""
    problem = chaplygin.veselova_hamiltonized_problem(point.a, point.D)
    rate = veselova_rates(point)
    prime = flow_in_tau(point, point.state, rate)
    return with_energy(problem, to_tau(point, point.state), prime, 0.5 * point.p @ rate[: point.n])


def veselova_classical(point):
    """dK⃗/dt, dγ⃗/dt and the energy at any f_1."""
    a, gamma = point.a, point.gamma
    moments = a / np.prod(a)
    tensor, w = np.diag(moments), point.normal("w", 3)
    z = np.concatenate([w, gamma])
    K, rate = capital_k(tensor, z), veselova_field(tensor, z)
    problem = chaplygin.veselova_classical_problem(a, point.D, float(w @ gamma))
    K_dot = derivative(lambda x: capital_k(tensor, x), z, rate)
    energy = 0.5 * (K @ w - (K @ gamma) * ((moments - 1.0) * w @ gamma))
    return with_energy(problem, np.concatenate([K, gamma]), [*K_dot, *rate[3:]], energy)


def densities(point):
    """Return log ϱ of the ball, with momentum and without, up to a constant."""
    inertia, matrix = operator(point)
    other = point.with_(gamma=sample(point.n, point.seed[-1] + 1).gamma)
    makers = {chaplygin.ball_problem: "k", chaplygin.reduced_problem: "p"}
    if point.n == 3:
        makers[chaplygin.classical_problem] = "k"
    found = []
    for make, name in makers.items():
        problem = make(inertia, point.D)
        given = {name: np.zeros(len(matrix) if name == "k" else point.n)}
        ends = [problem.state(gamma=at.gamma, **given) for at in (point, other)]
        one, two = (gi.value(problem, problem.measure.log_density, y) for y in ends)
        found.append(one - two)
    expected = log_rho(point, matrix, point.gamma) - log_rho(other, matrix, other.gamma)
    return found, [expected] * len(found)


PROBLEMS = {
    rolling: (2, 3, 5),
    contact: (2, 3, 4),
    ball: (2, 3, 5),
    rubber: (2, 3, 4),
    lr: (3, 4, 5),
    stiefel_variety: (3, 4, 5),
    densities: (2, 3, 4, 6),
    classical: (3,),
    reduced: (2, 3, 4, 6),
    hamiltonized: (2, 3, 4, 7),
    veselova_reduced: (3, 4, 6),
    veselova_hamiltonized: (3, 4, 7),
    veselova_classical: (3,),
}


@pytest.mark.parametrize("sides", PROBLEMS, ids=lambda sides: sides.__name__)
def test_a_problem_moves_as_the_motion_does(sides):
    """Fields, energies, reactions and integrals."""
    dimensions = PROBLEMS[sides]
    found = {
        (n, index): residual(sides(sample(n, index)))
        for n in dimensions
        for index in range(n, n - (-POINTS // len(dimensions)))
    }
    assert max(found.values()) <= HOLDS, max(found, key=found.get)
