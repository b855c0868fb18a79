"""Every form of every system against the others, at random states."""

import numpy as np
import pytest

import chaplygin as ch
from chaplygin.manifold import (
    flat_triangle,
    skew_matrix,
    triangle_of_vector,
    vector_of_triangle,
    wedge,
)
from tests.chaplygin.support import (
    CASES,
    DIMENSIONS,
    acted,
    extended,
    field_of,
    full_matrix_path,
    generator_of,
    mp,
    quiet_state,
    random_diagonal,
    random_full,
    random_special,
    random_tangent,
    rng_for,
    value_of,
)

SEEDS = range(3)
OF_THE_ORBIT = ("K", "momentum", "trace-k4", "area", "eps", "pp")  # invariants of rotations


def close(x, y, size=1.0):
    np.testing.assert_allclose(np.array(x, float), np.array(y, float), rtol=0, atol=4e-14 * size)


def brute_force_omega(inertia, D, k, gamma):
    """Solve k = Iω + D(ωγγᵀ + γγᵀω), eq. (K), as a system of n(n−1)/2 equations."""
    n, size = inertia.n, len(k)
    columns = []
    for e in np.eye(size):
        full = skew_matrix(e, n)
        pr = full @ np.outer(gamma, gamma) + np.outer(gamma, gamma) @ full
        columns.append(inertia.apply(e) + D * flat_triangle(pr))
    return np.linalg.solve(np.array(columns).T, k)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_omega_solves_the_definition_of_k(make, n, seed):
    inertia = make(n, seed)
    D = getattr(inertia, "D", 1.3)
    gamma, _ = random_tangent(n, seed)
    k = rng_for(n, seed).normal(size=n * (n - 1) // 2)
    problem = ch.ball_problem(inertia, D)
    omega = -generator_of(problem, quiet_state(problem, gamma=gamma, k=k))
    expected = brute_force_omega(inertia, D, k, gamma)
    close(omega, expected, 10 * np.max(np.abs(expected)))
    w, full = skew_matrix(expected, n), skew_matrix(k, n)
    out = field_of(problem, quiet_state(problem, gamma=gamma, k=k))
    close(out[: len(k)], flat_triangle(full @ w - w @ full), 50)
    close(out[len(k) :], -w @ gamma, 10)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_closed_form_is_the_solve(n, seed):
    inertia = random_special(n, seed)
    gamma, _ = random_tangent(n, seed)
    k = rng_for(n, seed).normal(size=n * (n - 1) // 2)
    problems = [
        ch.ball_problem(inertia, inertia.D),
        ch.ball_problem(ch.GeneralInertia(inertia.diagonal), inertia.D),
        ch.ball_problem(full_matrix_path(inertia), inertia.D),
    ]
    states = [quiet_state(q, gamma=gamma, k=k) for q in problems]
    fields = [field_of(q, y) for q, y in zip(problems, states, strict=True)]
    names = ["energy", "K"] if n == 2 else ["energy", "K", "momentum"]
    for problem, y, field in zip(problems, states, fields, strict=True):
        close(field, fields[0], 10)
        for name in names:
            close(value_of(problem, name, y), value_of(problems[0], name, states[0]), 10)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_omega_depends_on_the_direction_of_gamma_alone(n):
    k = rng_for(n, 5).normal(size=n * (n - 1) // 2)
    for make in (random_special, random_diagonal, random_full):
        inertia = make(n)
        problem = ch.ball_problem(inertia, getattr(inertia, "D", 1.3))
        y = quiet_state(problem, gamma=random_tangent(n)[0], k=k)
        longer = np.concatenate([y[: len(k)], 3.7 * y[len(k) :]])
        close(generator_of(problem, longer), generator_of(problem, y))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_reduced_is_the_ball_at_zero_momentum(make, n, seed):
    inertia = make(n, seed)
    D = getattr(inertia, "D", 1.3)
    gamma, p = random_tangent(n, seed)
    reduced, ball = ch.reduced_problem(inertia, D), ch.ball_problem(inertia, D)
    y, z = (quiet_state(q, gamma=gamma, p=p) for q in (reduced, ball))
    dy, dz = field_of(reduced, y), field_of(ball, z)
    size = n * (n - 1) // 2
    close(wedge(dy[:n], p) + wedge(gamma, dy[n:]), dz[:size], 10)
    close(dy[:n], dz[size:], 10)
    for name in ("energy", "K"):
        close(value_of(reduced, name, y), value_of(ball, name, z), 10)
    if n > 2:
        assert abs(value_of(ball, "momentum", z)) < 1e-28


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_reduced_closed_form_is_equations_ro1_ro2(n, seed):
    """On T*S^(n−1), in the form in which the paper prints them."""
    inertia = random_special(n, seed)
    a, D = inertia.a, inertia.D
    g, p = random_tangent(n, seed)
    problem = ch.reduced_problem(inertia, D)
    u = g @ (g / a)
    dg = p / D - (p @ g) / (D * u) * g / a + (g @ (a * p)) / (D * D * u) * g
    dg -= (g @ g) / (D * D * u) * a * p
    dp = (p @ (g / a)) / (D * u) * p - (p @ p) / (D * u) * g / a
    dp += (p @ (a * p)) / (D * D * u) * g - (p @ g) / (D * D * u) * a * p
    close(field_of(problem, np.concatenate([g, p])), np.concatenate([dg, dp]), 10)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_hamiltonized_is_reduced_in_another_time(n, seed):
    """p̃ = p/(D√U) and dτ = dt/(D√U): push the reduced field forward, in extended precision."""
    inertia = random_special(n, seed)
    D, b = inertia.D, 1.0 / inertia.a
    gamma, p = random_tangent(n, seed)
    reduced, flow = ch.reduced_problem(inertia, D), ch.hamiltonized_problem(inertia)
    y, z = (quiet_state(q, gamma=gamma, p=p) for q in (reduced, flow))

    def push(state):
        u = sum(b[i] * state[i] * state[i] for i in range(n))
        return np.concatenate([state[:n], state[n:] / (D * mp.sqrt(u))])

    h, start = mp.mpf("1e-15"), extended(y)
    close(push(start), z)
    velocity = field_of(reduced, start)
    pushed = (push(start + h * velocity) - push(start - h * velocity)) / (2 * h)
    clock = value_of(flow, flow.clock, z)
    close(clock, D * np.sqrt(gamma @ (b * gamma)))
    close(pushed * clock, field_of(flow, z), 20)
    for name in ("energy", "K"):
        close(value_of(reduced, name, y), value_of(flow, name, z), 10)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_hamiltonized_field_is_equations_ham_q_ham_p(n):
    """Off the manifold too: the factors 1/(γ, γ) belong to it."""
    inertia = random_special(n)
    a, D = inertia.a, inertia.D
    rng = rng_for(n, 11)
    g, p = rng.normal(size=n), rng.normal(size=n)
    u, g2 = g @ (g / a), g @ g
    dg = D * u * p - a * p + (g @ (a * p)) / g2 * g - D * u * (p @ g) / g2 * g
    dp = -D * (p @ p) * g / a + (p @ (a * p)) / g2 * g - (g @ (a * p)) / g2 * p
    dp += D * u * (p @ g) / g2 * p
    got = field_of(ch.hamiltonized_problem(inertia), np.concatenate([g, p]))
    close(got, np.concatenate([dg, dp]), 200)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_classical_is_the_ball_under_the_hat_map(make, seed):
    inertia = make(3, seed)
    D = getattr(inertia, "D", 1.3)
    gamma, _ = random_tangent(3, seed)
    x = rng_for(3, seed).normal(size=3)
    vectors, ball = ch.classical_problem(inertia, D), ch.ball_problem(inertia, D)
    y = quiet_state(vectors, gamma=gamma, k=x)
    z = quiet_state(ball, gamma=gamma, k=triangle_of_vector(x))
    dy, dz = field_of(vectors, y), field_of(ball, z)
    close(triangle_of_vector(dy[:3]), dz[:3], 30)
    close(dy[3:], dz[3:], 30)
    close(triangle_of_vector(generator_of(vectors, y)), generator_of(ball, z), 30)
    close(value_of(vectors, "energy", y), value_of(ball, "energy", z), 30)
    close(value_of(vectors, "K", y), value_of(ball, "K", z), 30)
    close(value_of(vectors, "area", y) ** 2, value_of(ball, "momentum", z), 30)


@pytest.mark.filterwarnings("ignore:moments")  # of a body or not
def test_classical_solves_the_definition_of_k():
    """k⃗ = Iω⃗ + Dω⃗ − D(ω⃗, γ⃗)γ⃗, with the tensor as it was given."""
    rng = rng_for(3, 1)
    m = rng.normal(size=(3, 3))
    tensor = m @ m.T + np.eye(3)
    problem = ch.ChaplyginSphere.from_moments(tensor, 0.7, 1.5).classical()
    gamma, k, D = random_tangent(3)[0], rng.normal(size=3), 0.7 * 1.5**2
    omega = -generator_of(problem, quiet_state(problem, gamma=gamma, k=k))
    close(tensor @ omega + D * omega - D * (omega @ gamma) * gamma, k, 10)


def test_hat_map_is_the_papers():
    """Under (iso), X v = x⃗ × v, and γ∧p is the matrix of p⃗ × γ⃗."""
    x, y = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.7, -1.1])
    np.testing.assert_allclose(skew_matrix(triangle_of_vector(x), 3) @ y, np.cross(x, y))
    np.testing.assert_allclose(vector_of_triangle(wedge(x, y)), np.cross(y, x))
    np.testing.assert_array_equal(vector_of_triangle(triangle_of_vector(x)), x)


@pytest.mark.parametrize("case", [c for c in CASES if c.problem.action], ids=str)
def test_action_is_the_field(case):
    """The derivative of exp(hξ)·y at h = 0 is the field; at any h, exp(ξ) keeps what it should."""
    y, h = extended(case.y), mp.mpf("1e-15")
    xi = generator_of(case.problem, y)
    above, below = (acted(case.problem, s * h * xi, y) for s in (1, -1))
    close((above - below) / (2 * h), field_of(case.problem, y), 20)
    if {"omega", "w"} & set(case.problem.slices):
        return  # velocities that are moved by translations
    moved = case.y + acted(case.problem, generator_of(case.problem, case.y), case.y)
    for name in case.problem.constraints:
        start = value_of(case.problem, name, case.y)
        assert value_of(case.problem, name, moved) == pytest.approx(start, abs=1e-13)
    kept = [name for name in case.problem.invariants if name.startswith(OF_THE_ORBIT)]
    assert kept
    for name in kept:
        start = value_of(case.problem, name, case.y)
        assert value_of(case.problem, name, moved) == pytest.approx(start, rel=1e-13)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_homogeneous_ball_rolls_on_great_circles(n):
    """Eq. (sphere): γ̇ = p/(s + D), ṗ = −(p, p) γ/(s + D); ω = k/(s + D) is constant."""
    s, D = 1.5, 2.0
    sphere = ch.ChaplyginSphere.homogeneous(n, s, D)
    gamma, p = random_tangent(n)
    reduced, ball = sphere.reduced(), sphere.ball()
    y, z = (quiet_state(q, gamma=gamma, p=p) for q in (reduced, ball))
    expected = np.concatenate([p, -(p @ p) * gamma]) / (s + D)
    close(field_of(reduced, y), expected)
    general = ch.ball_problem(ch.GeneralInertia(np.full(n * (n - 1) // 2, s)), D)
    full = ch.ball_problem(full_matrix_path(general_inertia(n, s)), D)
    for problem in (ball, general, full):
        close(generator_of(problem, z), -wedge(gamma, p) / (s + D))


def general_inertia(n, s):
    return ch.GeneralInertia(np.full(n * (n - 1) // 2, s))


def test_homogeneous_ball_turns_at_constant_omega():
    """n = 4, any momentum: dω/dt = 0 along the flow, in the body and in space."""
    problem = ch.ball_problem(full_matrix_path(general_inertia(4, 1.5)), 2.0)
    gamma, k = random_tangent(4)[0], rng_for(4, 3).normal(size=6)
    y, h = extended(quiet_state(problem, gamma=gamma, k=k)), mp.mpf("1e-15")
    v = field_of(problem, y)
    above, below = generator_of(problem, y + h * v), generator_of(problem, y - h * v)
    close((above - below) / (2 * h), np.zeros(6))


@pytest.mark.parametrize("case", [c for c in CASES if "gamma" in c.problem.slices], ids=str)
def test_physical_state_is_common(case):
    """The physical arrays do not depend on the form, and have the documented shapes."""
    n = case.sphere.n
    physical = case.problem.physical_state(case.y)
    assert {name: v.shape for name, v in physical.items()} == {
        "gamma": (n,),
        "k": (n * (n - 1) // 2,),
    }
    gamma, p = random_tangent(n)
    if case.label.startswith(("lr", "stiefel", "rubber", "rolling", "contact")):
        return  # given by their velocities: see test_chain
    close(physical["gamma"], gamma)
    tangent = "p" in dict(case.problem.pieces) or "p_tilde" in dict(case.problem.pieces)
    close(
        physical["k"], wedge(gamma, p) if tangent else rng_for(n, 7).normal(size=len(physical["k"]))
    )
