"""The Veselova problem: its forms against the LR system that it comes from, and its integrals."""

import itertools

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.commuting_integrals import coefficient_tables
from chaplygin.integrable import separation_integral
from chaplygin.manifold import flat_triangle, skew_matrix, triangle_of_vector, wedge
from tests.chaplygin.support import (
    CASES,
    DIMENSIONS,
    divergence,
    extended,
    field_of,
    gradients_of,
    mp,
    quiet_state,
    random_body,
    random_rotation,
    random_tangent,
    rate,
    rng_for,
    value_of,
)

# Random moments are those of bodies or not: the equations do not ask.
pytestmark = pytest.mark.filterwarnings("ignore:moments")

SEEDS = range(3)


def close(x, y, size=1.0):
    np.testing.assert_allclose(np.array(x, float), np.array(y, float), rtol=0, atol=4e-14 * size)


def lagrange_dalembert(a, g, omega):
    """Return ẇ of the body at rotation g: the LR system on SO(n), with multipliers.

    In space the angular velocity Ω = g w gᵀ has Ω_pq = 0 for p, q ≥ 2, and the reactions are skew
    matrices with entries at those p, q only: (d/dt) g(𝓘w)gᵀ = Λ. Unknowns are ẇ and Λ; the
    equations are that, and Ω̇_pq = 0.
    """
    n = len(a)
    i, j = np.triu_indices(n, 1)
    moments, size = 1.0 / (a[i] * a[j]), len(i)
    w, momentum = skew_matrix(omega, n), skew_matrix(moments * omega, n)
    free = np.flatnonzero(i > 0)
    basis = [skew_matrix(e, n) for e in np.eye(size)]
    columns = [flat_triangle(g @ skew_matrix(moments[c] * np.eye(size)[c], n) @ g.T)
               for c in range(size)]  # fmt: skip
    reactions = -np.eye(size)[:, free]
    upper = np.hstack([np.array(columns).T, reactions])
    # Ω̇ = g(ẇ + [w, w])gᵀ
    turned = np.array([flat_triangle(g @ e @ g.T) for e in basis]).T
    lower = np.hstack([turned[free], np.zeros((len(free), len(free)))])
    gyroscopic = flat_triangle(g @ (w @ momentum - momentum @ w) @ g.T)
    right = np.concatenate([-gyroscopic, np.zeros(len(free))])
    return np.linalg.solve(np.vstack([upper, lower]), right)[:size]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_reduced_is_the_lr_system(n, seed):
    """γ = e_1 = gᵀE_1; p = −(𝓘w)γ, the part of the momentum in γ∧R^n."""
    body, g = random_body(n, seed), random_rotation(n, seed)
    a, gamma = body.a, g[0].copy()
    v = rng_for(n, seed).normal(size=n)
    v -= (gamma @ v) * gamma
    omega = wedge(gamma, v)
    i, j = np.triu_indices(n, 1)
    moments = 1.0 / (a[i] * a[j])
    w, momentum = skew_matrix(omega, n), skew_matrix(moments * omega, n)
    acceleration = lagrange_dalembert(a, g, omega)
    gamma_rate = -w @ gamma
    p, p_rate = -momentum @ gamma, -skew_matrix(moments * acceleration, n) @ gamma
    p_rate -= momentum @ gamma_rate
    problem = body.reduced()
    size = 10.0 * max(1.0, np.max(np.abs(p_rate)))
    for components in ({"w": omega}, {"w": w}, {"p": p - (gamma @ p) * gamma}):
        y = quiet_state(problem, gamma=gamma, **components)
        close(y, np.concatenate([gamma, p]), size)
        close(field_of(problem, y), np.concatenate([gamma_rate, p_rate]), size)
    energy = 0.5 * omega @ (moments * omega)
    assert value_of(problem, "energy", y) == pytest.approx(energy, rel=1e-12)
    close(problem.physical_state(y)["k"], flat_triangle(np.outer(momentum @ gamma, gamma)
          - np.outer(gamma, momentum @ gamma)), size)  # fmt: skip


@pytest.mark.parametrize("n", [3, 4])
def test_extended2_as_printed_has_the_wrong_sign(n):
    """Eq. (extended2) prints +Φ_1 p: then neither (γ, p) nor the energy would be kept."""
    body, (gamma, p) = random_body(n), random_tangent(n)
    a, problem = body.a, body.reduced()
    u = gamma @ (gamma / a)
    y = quiet_state(problem, gamma=gamma, p=p)
    first = (a * p - (p @ (a * gamma)) * gamma) / u
    printed = ((p @ (a * p)) * gamma - (p @ gamma) * a * p) / u
    got = field_of(problem, y)
    close(got[:n], first, 10)
    close(got[n:], -printed, 10)
    assert abs(first @ p + gamma @ printed) > 0.1
    assert abs(first @ p + gamma @ got[n:]) < 1e-13


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_hamiltonized_is_reduced_in_another_time(n, seed):
    """p̃ = p/(D√U) and dτ = dt/(D√U): push the reduced field forward, in extended precision."""
    body, (gamma, p) = random_body(n, seed), random_tangent(n, seed)
    reduced, flow = body.reduced(), body.hamiltonized()
    y, z = (quiet_state(q, gamma=gamma, p=p) for q in (reduced, flow))

    def push(state):
        u = sum(state[i] * state[i] / body.a[i] for i in range(n))
        return np.concatenate([state[:n], state[n:] / (body.D * mp.sqrt(u))])

    h, start = mp.mpf("1e-15"), extended(y)
    close(push(start), z)
    velocity = field_of(reduced, start)
    pushed = (push(start + h * velocity) - push(start - h * velocity)) / (2 * h)
    close(pushed * value_of(flow, flow.clock, z), field_of(flow, z), 50)
    assert set(reduced.invariants) == set(flow.invariants)
    for name in reduced.invariants:
        expected = pytest.approx(value_of(reduced, name, y), rel=1e-12, abs=1e-12)
        assert value_of(flow, name, z) == expected
    assert (
        value_of(flow, "energy", z)
        == pytest.approx(  # 𝓗 = ½D²(p̃, Ap̃)
            0.5 * body.D**2 * z[n:] @ (body.a * z[n:]), rel=1e-13
        )
    )


@pytest.mark.parametrize("n", DIMENSIONS)
def test_gradients_and_the_hamiltonian_form(n):
    """The gradients are those of 𝓗 − D²(γ, p̃)(γ, Ap̃), and the form has the field's flow."""
    body = random_body(n)
    problem, a, d2 = body.hamiltonized(), extended(body.a), mp.mpf(body.D) ** 2
    h = mp.mpf("1e-15")

    def modified(state):
        q, p = state[:n], state[n:]
        return value_of(problem, "energy", state) - d2 * (q @ p) * (q @ (a * p))

    off = extended(rng_for(n, 41).normal(size=2 * n))
    dq, dp = gradients_of(problem, off)
    for i, e in enumerate(np.eye(2 * n)):
        slope = (modified(off + h * extended(e)) - modified(off - h * extended(e))) / (2 * h)
        assert abs(slope - (dq[i] if i < n else dp[i - n])) < 1e-14 * max(1, abs(slope))
    gamma, p = random_tangent(n)
    y = extended(quiet_state(problem, gamma=gamma, p_tilde=p))
    dq, dp = gradients_of(problem, y)
    field, q = field_of(problem, y), y[:n]
    assert max(abs(dp - field[:n])) < 1e-14
    rest = -dq - field[n:]
    assert max(abs(rest - (q @ rest) * q)) < 1e-14 * max(1, max(abs(rest)))
    leaving = np.concatenate([q, y[n:] + 0.25 * q])  # the hidden constraint is (γ, p̃) = 0
    hidden = q @ gradients_of(problem, leaving)[1]
    assert abs(hidden + 0.25 * d2 * (q @ (a * q))) < 1e-14


@pytest.mark.parametrize("n", [3, 4, 5])
def test_the_flows_of_the_sphere_and_the_body_share_their_integrals(n):
    """Theorem CH-VP (ii): H = K/(2D) − 𝓗/D², and all r_k are constant along both flows."""
    body = random_body(n)
    largest = np.sort(body.a)[-1] * np.sort(body.a)[-2]
    D = 1.5 * largest
    body, sphere = ch.Veselova(body.a, D), ch.ChaplyginSphere(a=body.a, D=D)
    gamma, p = random_tangent(n)
    veselova, chaplygin = body.hamiltonized(), sphere.hamiltonized()
    y = quiet_state(veselova, gamma=gamma, p=p)
    np.testing.assert_array_equal(y, quiet_state(chaplygin, gamma=gamma, p=p))
    energy, K = (value_of(veselova, name, y) for name in ("energy", "K"))
    expected = K / (2 * D) - energy / D**2
    assert value_of(chaplygin, "energy", y) == pytest.approx(expected, rel=1e-12)
    velocity = field_of(chaplygin, extended(y))
    for name in veselova.invariants:
        value = float(value_of(veselova, name, y))
        assert abs(rate(veselova, name, y, velocity)) < 1e-14 * max(1.0, abs(value))


@pytest.mark.parametrize("n", [4, 5])
def test_the_integrals_commute(n):
    """All Dirac brackets of energy, K, r_1, … vanish, and the differentials are independent."""
    problem = random_body(n).hamiltonized()
    gamma, p = random_tangent(n)
    y = extended(quiet_state(problem, gamma=gamma, p_tilde=p))
    gradients = {name: slopes(problem, name, y) for name in problem.invariants}
    constraints = [slopes(problem, name, y) for name in ("norm", "tangency")]
    assert len(gradients) == n - 1
    between = canonical(*constraints)
    for f, g in itertools.combinations(gradients.values(), 2):
        first = canonical(f, constraints[0]) * canonical(g, constraints[1])
        second = canonical(f, constraints[1]) * canonical(g, constraints[0])
        bracket = canonical(f, g) - (first - second) / between
        assert abs(bracket) < 1e-12
    stacked = np.array([*gradients.values(), *constraints], dtype=float)
    assert np.linalg.svd(stacked / np.linalg.norm(stacked, axis=1)[:, None])[1][-1] > 1e-6


def slopes(problem, name, y):
    return np.array([rate(problem, name, y, extended(e)) for e in np.eye(len(y))])


def canonical(f, g):
    n = len(f) // 2
    return f[:n] @ g[n:] - f[n:] @ g[:n]


@pytest.mark.parametrize("n", [3, 4, 6])
def test_the_ends_of_the_polynomial(n):
    """r_0 = (−1)ⁿ K Πa/D², r_(n−2) = 2𝓗/D²; and R(λ_k) = −4λ_k P(λ_k) μ_k² ."""
    body, (gamma, p) = random_body(n), random_tangent(n)
    a, flow = body.a, body.hamiltonized()
    y = quiet_state(flow, gamma=gamma, p_tilde=p)
    tables = coefficient_tables(a, range(n), 1)
    params = np.concatenate([[body.D], 1.0 / a, a, tables])
    other = gi.Problem(name="all", pieces=flow.pieces, params=params, field=flow.field)
    r = [value_of(other, separation_integral(n, 0, k, False), y) for k in range(n)]
    expected = (-1) ** n * value_of(flow, "K", y) * np.prod(a) / body.D**2
    assert r[0] == pytest.approx(expected, rel=1e-12)
    assert r[n - 2] == pytest.approx(2 * value_of(flow, "energy", y) / body.D**2, rel=1e-12)
    assert abs(r[n - 1]) < 1e-12
    numerator = np.sum([g * g * np.poly(np.delete(a, i)) for i, g in enumerate(gamma)], axis=0)
    for lam in np.roots(numerator).real:  # the spheroconical coordinates of γ
        mu = 0.5 * np.sum(p * gamma / (lam - a))
        size = np.sum(np.abs(r) * lam ** np.arange(n))
        expected = -4 * lam * np.prod(lam - a) * mu**2
        assert np.polyval(r[::-1], lam) == pytest.approx(expected, abs=1e-12 * size)


def test_equal_parameters():
    """Nothing is divided by a_i − a_j; γ_1 p̃_2 − γ_2 p̃_1 is one more integral."""
    body = ch.Veselova([0.7, 0.7, 1.2, 1.2, 1.2])
    problem, (gamma, p) = body.hamiltonized(), random_tangent(5)
    y = extended(quiet_state(problem, gamma=gamma, p_tilde=p))
    velocity = field_of(problem, y)
    for name in problem.invariants:
        assert np.isfinite(float(value_of(problem, name, y)))
        assert abs(rate(problem, name, y, velocity)) < 1e-14

    def linear(params, t, y, work):
        return y[0] * y[6] - y[1] * y[5]

    assert abs(rate(problem, linear, y, velocity)) < 1e-14


# The classical problem.


def printed_rates(moments, w, gamma):
    """Return ẇ and γ̇ of eqs. (3.1), (la)."""
    momentum = moments * w
    gyroscopic = np.cross(momentum, w)
    lam = -(gyroscopic @ (gamma / moments)) / ((gamma / moments) @ gamma)
    return (gyroscopic + lam * gamma) / moments, np.cross(gamma, w)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("f1", [0.0, 0.7, -2.0])
def test_classical_is_the_printed_problem(seed, f1):
    rng = rng_for(3, seed)
    moments, gamma = rng.uniform(0.4, 3.0, 3), random_tangent(3, seed)[0]
    problem = ch.Veselova.from_moments(moments).classical(f1)
    w = rng.normal(size=3)
    w += (f1 - gamma @ w) * gamma
    y = quiet_state(problem, gamma=gamma, w=w)
    w_rate, gamma_rate = printed_rates(moments, w, gamma)

    def momentum(w, gamma):
        return moments * w - ((moments - 1.0) * w @ gamma) * gamma

    close(y[:3], momentum(w, gamma), 10)
    out = field_of(problem, y)
    close(out[3:], gamma_rate, 10)
    h = 1e-6
    ahead, behind = (momentum(w + s * h * w_rate, gamma + s * h * gamma_rate) for s in (1, -1))
    np.testing.assert_allclose(out[:3], (ahead - behind) / (2 * h), atol=1e-7)
    energy = 0.5 * (y[:3] @ w) - 0.5 * (y[:3] @ gamma) * ((moments - 1.0) * w @ gamma)
    assert value_of(problem, "energy", y) == pytest.approx(energy, abs=1e-12)
    if f1 == 0.0:  # as the text after eq. (ints) says, with 𝓘 for the misprinted I
        assert value_of(problem, "energy", y) == pytest.approx(0.5 * moments * w @ w, abs=1e-12)
        K = (moments * w) @ (moments * w) - (moments * w @ gamma) ** 2
        assert value_of(problem, "K", y) == pytest.approx(K, abs=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_classical_is_the_reduced_problem_at_zero(seed):
    """Under the hat map k⃗ = p⃗ × γ⃗; 𝓘_1 = 1/(a_2 a_3) and so on."""
    body, (gamma, p) = random_body(3, seed), random_tangent(3, seed)
    reduced, classical = body.reduced(), body.classical()
    y, z = (quiet_state(q, gamma=gamma, p=p) for q in (reduced, classical))
    dy, dz = field_of(reduced, y), field_of(classical, z)
    close(dy[:3], dz[3:], 30)
    close(wedge(dy[:3], p) + wedge(gamma, dy[3:]), triangle_of_vector(dz[:3]), 30)
    for name in ("energy", "K"):
        close(value_of(reduced, name, y), value_of(classical, name, z), 30)
    again = ch.Veselova.from_moments(1.0 / (np.prod(body.a) / body.a))
    close(again.a, body.a)


@pytest.mark.parametrize("f1", [0.0, 0.7])
def test_printed_measure_in_w(f1):
    """Density (𝓘⁻¹γ, γ)^(1/2) in (w, γ): as printed, and the power −1/2 fails there."""
    moments = np.array([0.7, 1.3, 2.9])

    @gi.field
    def printed(params, t, y, out, work):
        w, gamma = (np.array([y[i] for i in range(at, at + 3)], dtype=object) for at in (0, 3))
        rates = np.concatenate(printed_rates(extended(moments), w, gamma))
        for i in range(6):
            out[i] = rates[i]

    def density(power):
        def log_density(params, t, y, work):
            return power * mp.log(sum(y[3 + i] ** 2 / mp.mpf(moments[i]) for i in range(3)))

        return log_density

    measure = ch.Veselova.from_moments(moments).classical(f1).measure
    problem = gi.Problem(
        name="printed", pieces=(("w", 3), ("gamma", 3)), params=[0.0, 0.0, 0.0, f1],
        field=printed, measure=measure,
    )  # fmt: skip
    gamma, p = random_tangent(3)
    y = np.concatenate([np.cross(gamma, p) + f1 * gamma, gamma])
    assert abs(divergence(problem, y, density(mp.mpf(1) / 2))) < 1e-15
    assert abs(divergence(problem, y, density(-mp.mpf(1) / 2))) > 1e-3


# States.


def test_states_from_every_component():
    body, (gamma, p) = random_body(3), random_tangent(3)
    w = wedge(gamma, body.a * p) / (gamma @ (gamma / body.a))
    clock = body.D * np.sqrt(gamma @ (gamma / body.a))
    flat = {"p": p, "p_tilde": p / clock, "k": wedge(gamma, p), "w": w}
    for problem in (body.reduced(), body.hamiltonized(), body.classical()):
        for name, value in flat.items():
            vector = problem.name == "veselova-classical" and name in ("k", "w")
            given = skew_matrix(value, 3) if vector else value
            y = quiet_state(problem, gamma=gamma, **{name: given})
            close(problem.physical_state(y)["k"], wedge(gamma, p), 10)


def test_the_level_is_a_part_of_the_state():
    problem = ch.Veselova.from_moments([2.0, 3.0, 5.0]).classical(0.5)
    gamma = np.array([0.0, 0.6, 0.8])
    with pytest.warns(gi.GeomintWarning, match=r"\(w, gamma\) is 1.4, not f1 = 0.5"):
        y = problem.state(gamma=gamma, w=[1.0, 1.0, 1.0])
    assert value_of(problem, "constraint", y) == pytest.approx(0.0, abs=1e-15)
    with pytest.warns(gi.GeomintWarning, match=r"\(k, gamma\)"):
        y = problem.state(gamma=gamma, k=[1.0, 1.0, 1.0])
    close(y[:3], np.array([1.0, 1.0, 1.0]) - 0.9 * gamma)
    close(problem.state(gamma=gamma, k=0.5 * gamma)[:3], 0.5 * gamma)  # turns about γ
    close(problem.state(gamma=gamma, p=[1.0, 0.0, 0.0])[:3], [0.0, -0.5, 1.0])
    with pytest.raises(gi.DomainError, match=r"f1 = 0\.5"):
        problem.canonical(y + np.array([1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]))
    with pytest.warns(gi.GeomintWarning, match="of the state"):
        repaired = problem.canonical(y + np.array([0.0, 0.0, 1e-8, 0.0, 0.0, 0.0]))
    assert abs(value_of(problem, "constraint", repaired)) < 1e-15
    still = ch.Veselova.from_moments([2.0, 3.0, 5.0]).classical().state(gamma=gamma, w=np.zeros(3))
    np.testing.assert_array_equal(still[:3], 0.0)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: ch.Veselova([1.0]), "n ≥ 2"),
        (lambda: ch.Veselova(1.0), "sequence"),
        (lambda: ch.Veselova([1.0, -2.0]), r"a\[1\] is not"),
        (lambda: ch.Veselova([1.0, 1e-320]), r"a\[1\] is not"),
        (lambda: ch.Veselova([1.0, 2.0], D=0.0), "D = 0.0"),
        (lambda: ch.Veselova.from_moments([1.0, 2.0]), "3 numbers"),
        (lambda: ch.Veselova.from_moments([1.0, 2.0, 0.0]), "positive"),
        (lambda: ch.Veselova([1.0, 2.0]).classical(), "dimension 3"),
        (lambda: ch.Veselova([1.0, 2.0, 3.0]).classical(float("nan")), "f1"),
        (lambda: ch.Veselova([1.0, 2.0]).reduced().state(gamma=[1, 0]), "exactly one of"),
        (lambda: ch.Veselova([1.0, 2.0]).reduced().state(gamma=[1, 0], omega=[1.0]), "omega"),
        (lambda: ch.Veselova([1.0, 2.0, 3.0]).classical().state(gamma=[1, 0, 0], q=1), "q = 1"),
        (
            lambda: ch.Veselova([1.0, 2.0, 3.0]).reduced().state(gamma=[1, 0, 0], w=[0, 0, 1]),
            "velocity",
        ),
    ],
)
def test_bad_input_is_named(make, text):
    with pytest.raises(gi.DomainError, match=text):
        make()


def test_methods_of_all_forms_agree():
    """Gauss on T*S² in t, RATTLE in τ with physical time beside it, a Lie-group method in vectors."""
    body = ch.Veselova([0.8, 1.1, 1.5], D=2.0)
    gamma, p = [0.6, 0.0, 0.8], [0.8, 1.0, -0.6]
    runs = [
        (body.reduced(), "gauss-8", 0.1),
        (body.hamiltonized(), "rattle-6", 0.005),
        (body.classical(), "cf-4", 0.002),
    ]
    ends = []
    for problem, method, step in runs:
        y0 = quiet_state(problem, gamma=gamma, p=p)
        end = gi.solve(problem, y0, t_end=2.0, method=method, step=step, progress=False)
        ends.append(problem.physical_state(end.y[-1]))
    for end in ends[1:]:
        np.testing.assert_allclose(end["gamma"], ends[0]["gamma"], atol=1e-9)
        np.testing.assert_allclose(end["k"], ends[0]["k"], atol=1e-9)


def test_every_form_is_among_the_cases():
    names = {case.problem.name for case in CASES}
    assert {"veselova-reduced", "veselova-hamiltonized", "veselova-classical"} <= names
