"""The chain of reductions: motions of one representation are motions of the next, both ways.

`converted` is the map. Its derivatives along the
motion are differences of order 8, exact to 1e-12 here.
"""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import wedge
from chaplygin.veselova.stiefel_states import allowed_part
from tests.chaplygin.support import (
    DIMENSIONS,
    quiet_state,
    random_body,
    random_diagonal,
    random_direction,
    random_frame,
    random_full,
    random_special,
    random_tangent,
    rng_for,
)

SEEDS = range(2)
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def physical_rate(problem, y):
    """The derivative of the physical quantities along the motion, flat."""
    velocity = gi.derivative(problem, y)
    h = 2.0**-10 / max(1.0, np.max(np.abs(velocity)))

    def flat(state):
        return np.concatenate(list(problem.physical_state(state).values()))

    total = 0.0
    for k, w in enumerate(WEIGHTS, 1):
        total = total + w * (flat(y + k * h * velocity) - flat(y - k * h * velocity))
    return total / h


def same_motion(problems, start):
    """All problems at the same physical state have the same rates of it, in physical time."""
    first = problems[0]
    y = quiet_state(first, **start)
    common = first.physical_state(y)
    expected = physical_rate(first, y)
    size = np.max(np.abs(expected))
    energy = gi.value(first, "energy", y)
    assert size > 1e-3
    for problem in problems[1:]:  # a state that needs projecting would warn, which is an error
        z = ch.converted(y, first, problem)
        for name, value in problem.physical_state(z).items():
            np.testing.assert_allclose(
                value, common[name], rtol=0, atol=1e-13 * max(1.0, np.max(np.abs(value)))
            )
        clock = 1.0 if problem.clock is None else gi.value(problem, problem.clock, z)
        np.testing.assert_allclose(
            physical_rate(problem, z) / clock, expected, rtol=0, atol=3e-11 * max(1.0, size)
        )
        if first.time == problem.time:
            assert gi.value(problem, "energy", z) == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_ball_with_any_momentum(make, n, seed):
    """(g, r, ω, v), (k, γ, g, r), (k, g), (k, γ, g), (k, γ), and vectors, in t and τ."""
    inertia = make(n, seed)
    D = getattr(inertia, "D", 1.3)
    sphere = ch.ChaplyginSphere(inertia=inertia, D=D)
    problems = [
        sphere.rolling(rho=0.7),
        sphere.contact(rho=0.7),
        sphere.on_group(),
        sphere.ball(True),
        sphere.ball(),
    ]
    if n == 3:  # vectors, which take k as such
        start = {
            "gamma": random_direction(3, seed),
            "k": rng_for(3, seed + 70).normal(size=3),
        }
        same_motion([sphere.classical(), sphere.classical(True)], start)
        poisson, classical = sphere.poisson(), sphere.classical()
        y = quiet_state(classical, **start)
        f = gi.value(poisson, poisson.clock, y)
        got = gi.derivative(poisson, y) / f
        np.testing.assert_allclose(got, gi.derivative(classical, y), rtol=0, atol=1e-13)
    g = random_frame(random_direction(n, seed))
    omega = rng_for(n, seed + 70).normal(size=n * (n - 1) // 2)
    same_motion(problems, {"g": g, "omega": omega})


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
def test_ball_without_momentum(make, n, seed):
    """Down to T*S^(n−1), in t and, with the special operator, in τ."""
    inertia = make(n, seed)
    sphere = ch.ChaplyginSphere(inertia=inertia, D=getattr(inertia, "D", 1.3))
    gamma, p = random_tangent(n, seed)
    problems = [sphere.rolling(rho=0.7), sphere.ball(), sphere.reduced()]
    if isinstance(sphere.inertia, ch.SpecialInertia):
        problems.append(sphere.hamiltonized())
    same_motion(problems, {"gamma": gamma, "k": wedge(gamma, p)})


@pytest.mark.parametrize("n", range(2, 7))
@pytest.mark.parametrize("make", [random_diagonal, random_full])
def test_veselova_for_every_r(make, n):
    """(g, w) with multipliers and (X, P) on T*V(n, r)."""
    inertia, g = make(n), random_frame(random_direction(n))
    for r in range(1, n):
        body = ch.VeselovaLR(inertia, r)
        w = allowed_part(g[:r], rng_for(n, r).normal(size=n * (n - 1) // 2))
        same_motion([body.lr(), body.stiefel()], {"g": g, "w": w})


@pytest.mark.parametrize("n", DIMENSIONS)
def test_veselova_with_r_1_is_the_closed_form(n):
    body, (gamma, p) = random_body(n), random_tangent(n)
    general = ch.VeselovaLR.from_a(body.a, 1)
    same_motion([general.stiefel(), body.reduced(), body.hamiltonized()], {"gamma": gamma, "p": p})


@pytest.mark.parametrize("f1", [0.0, -0.7])
def test_both_printed_forms_of_the_classical_problem(f1):
    """(w⃗, γ⃗) with λ, eqs. (3.1), (la), and (K⃗, γ⃗), eq. (3.2); with f₁ = 0 also T*S²."""
    body, (gamma, p) = random_body(3), random_tangent(3)
    problems = [body.multiplier(f1), body.classical(f1)]
    if f1 == 0.0:
        problems.append(body.reduced())
    same_motion(problems, {"gamma": gamma, "k": np.cross(p, gamma) + f1 * gamma})
    y = quiet_state(problems[0], gamma=gamma, p=p)
    moment = y[3:] / problems[0].params[:3]
    rate = gi.derivative(problems[0], y)[3:] / problems[0].params[:3]
    expected = np.cross(moment, y[3:]) + gi.value(problems[0], "multiplier", y) * gamma
    np.testing.assert_allclose(rate, expected, atol=1e-13)


@pytest.mark.parametrize("n", DIMENSIONS)
@pytest.mark.parametrize("make", [random_diagonal, random_full])
def test_rubber_ball_is_the_veselova_problem(make, n):
    """Of the operator I + D: the reactions do not enter."""
    inertia, D = make(n), 1.7
    ball, (gamma, p) = ch.RubberSphere(inertia, D), random_tangent(n)
    body = ch.VeselovaLR(ball.total, 1)
    same_motion(
        [ball.rolling(rho=0.7), ball.reduced(), body.stiefel()],
        {"gamma": gamma, "k": wedge(gamma, p)},
    )


@pytest.mark.parametrize("n", DIMENSIONS)
def test_special_rubber_ball(n):
    a = 0.4 * random_body(n).a
    ball, (gamma, p) = ch.RubberSphere.from_a(a, 1.2), random_tangent(n)
    np.testing.assert_allclose(ball.body().a, ch.Veselova(a).a if n > 2 else np.sqrt(a[0] * a[1]))
    same_motion([ball.reduced(), ball.hamiltonized()], {"gamma": gamma, "p": p})


@pytest.mark.parametrize("n", range(2, 6))
@pytest.mark.parametrize("make", [random_diagonal, random_full])
def test_rubber_ball_by_newton_and_euler(make, n):
    """m v̇ = Λ, (I ω̇ − [Iω, ω] + ρ g⁻¹Λ∧γ) has no part in R^n∧γ: by hand, with dense matrices."""
    from chaplygin.manifold import flat_triangle, skew_matrix

    inertia, rho, m = make(n), 0.7, 2.5
    ball = ch.RubberSphere(inertia, m * rho**2)
    problem = ball.rolling(m, rho)
    g = random_frame(random_direction(n))
    gamma = g[-1]
    w = allowed_part(g[-1:], rng_for(n, 3).normal(size=n * (n - 1) // 2))
    y = quiet_state(problem, g=g, omega=w)
    rates = dict(
        zip(problem.slices, np.split(gi.derivative(problem, y), _cuts(problem)), strict=True)
    )
    reaction = np.append(m * rates["v"], 0.0)
    omega, moment = skew_matrix(w, n), skew_matrix(inertia.apply(w), n)
    torque = np.outer(g.T @ reaction, gamma) - np.outer(gamma, g.T @ reaction)
    left = skew_matrix(inertia.apply(rates["omega"]), n) - (moment @ omega - omega @ moment)
    rest = flat_triangle(left + rho * torque)
    np.testing.assert_allclose(allowed_part(gamma[None], rest), 0.0, atol=1e-11)
    if n > 2:
        np.testing.assert_allclose(
            np.linalg.norm(rest), gi.value(problem, "torque", y), rtol=1e-10, atol=1e-12
        )
        size = np.linalg.norm(reaction)
        assert gi.value(problem, "reaction", y) == pytest.approx(size, rel=1e-12)


def _cuts(problem):
    return [where.stop for where in problem.slices.values()][:-1]


@pytest.mark.parametrize("n", range(3, 6))
def test_multipliers_of_the_veselova_problem(n):
    """𝓘ẇ − [𝓘w, w] = Σ λ_pq e_p∧e_q, r < p < q: with the λ that are observables."""
    from chaplygin.manifold import skew_matrix

    inertia, r, g = random_full(n), 1 if n == 3 else n - 2, random_frame(random_direction(n))
    problem = ch.lr_problem(inertia, r)
    w = allowed_part(g[:r], rng_for(n, 5).normal(size=n * (n - 1) // 2))
    y = quiet_state(problem, g=g, w=w)
    rate = gi.derivative(problem, y)[n * n :]
    omega, moment = skew_matrix(w, n), skew_matrix(inertia.apply(w), n)
    left = skew_matrix(inertia.apply(rate), n) - (moment @ omega - omega @ moment)
    right = np.zeros((n, n))
    for p in range(r, n):
        for q in range(p + 1, n):
            value = gi.value(problem, f"multiplier-{p + 1}-{q + 1}", y)
            right += value * (np.outer(g[p], g[q]) - np.outer(g[q], g[p]))
    np.testing.assert_allclose(left, right, atol=1e-11)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_permutations_of_the_axes(n):
    """a_i, γ_i, p_i permuted: the same motion, permuted."""
    order = rng_for(n, 9).permutation(n)
    inertia, body, (gamma, p) = random_special(n), random_body(n), random_tangent(n)
    pairs = [
        (ch.ChaplyginSphere(inertia=inertia), ch.ChaplyginSphere(inertia.a[order], inertia.D)),
        (body, ch.Veselova(body.a[order], body.D)),
    ]
    both = np.concatenate([order, n + order])
    for plain, permuted in pairs:
        for form in ("reduced", "hamiltonized"):
            one, other = getattr(plain, form)(), getattr(permuted, form)()
            y = quiet_state(one, gamma=gamma, p=p)
            z = quiet_state(other, gamma=gamma[order], p=p[order])
            np.testing.assert_allclose(z, y[both], atol=1e-15)
            np.testing.assert_allclose(
                gi.derivative(other, z), gi.derivative(one, y)[both], rtol=0, atol=1e-13
            )
            for name in one.invariants:
                expected = gi.value(one, name, y)
                assert gi.value(other, name, z) == pytest.approx(expected, rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_scaling_laws(n):
    """p ↦ sp is t ↦ t/s; I, D ↦ cI, cD, that is a ↦ √c a, D ↦ cD, is t ↦ ct."""
    inertia, (gamma, p), s, c = random_special(n), random_tangent(n), 3.0, 1.7
    sphere = ch.ChaplyginSphere(inertia=inertia)
    scaled = ch.ChaplyginSphere(np.sqrt(c) * inertia.a, c * inertia.D)
    y = quiet_state(sphere.reduced(), gamma=gamma, p=p)
    rate = gi.derivative(sphere.reduced(), y)
    faster = gi.derivative(sphere.reduced(), quiet_state(sphere.reduced(), gamma=gamma, p=s * p))
    np.testing.assert_allclose(faster, np.concatenate([s * rate[:n], s * s * rate[n:]]), rtol=1e-12)
    slower = gi.derivative(scaled.reduced(), y)
    np.testing.assert_allclose(c * slower, rate, rtol=1e-11, atol=1e-13)
