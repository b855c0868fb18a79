"""The chain of reductions: motions of one representation are motions of the next, both ways.

`converted` is the map. Its derivatives along the motion are differences of order 8, exact to 1e-12
here. The first of each chain is compared with d'Alembert's principle in
`audit/test_problems_against_motion.py`.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin import support
from tests.chaplygin.exact_support import WEIGHTS
from tests.chaplygin.support import close, dimensions, kinds, seeds
from tests.rows import examples


def physical_rate(problem, y):
    """The derivative of the physical quantities along the motion, flat."""
    velocity = gi.derivative(problem, y)
    h = 2.0**-10 / max(1.0, np.max(np.abs(velocity)))

    around = [problem.physical_state(y + k * h * velocity) for k in range(-4, 5)]
    return WEIGHTS @ [np.concatenate(list(state.values())) for state in around] / h


def same_motion(problems, start):
    """All problems at the same physical state have the same rates of it, in physical time."""
    first = problems[0]
    y = support.quiet_state(first, **start)
    common = first.physical_state(y)
    expected = physical_rate(first, y)
    size = np.max(np.abs(expected))
    assert size > 1e-4
    for problem in problems[1:]:  # a state that needs projecting would warn, which is an error
        z = ch.converted(y, first, problem)
        for name, value in problem.physical_state(z).items():
            close(value, common[name], 10 * max(1.0, np.max(np.abs(value))))
        clock = 1.0 if problem.clock is None else gi.value(problem, problem.clock, z)
        np.testing.assert_allclose(
            physical_rate(problem, z) / clock, expected, rtol=0, atol=1e-10 * max(1.0, size)
        )
        shared = first.invariants.keys() & problem.invariants.keys()
        assert shared >= {"energy"}
        for name in shared:
            known = gi.value(first, name, y)
            assert gi.value(problem, name, z) == pytest.approx(known, rel=2e-12, abs=1e-12), name


@given(dimensions, kinds, seeds)
def test_ball_with_any_momentum(n, kind, seed):
    """(g, r, ω, v), (k, γ, g, r), (k, g), (k, γ, g), (k, γ), and vectors, in t and τ."""
    inertia, D = support.operator_of(kind, n, seed)
    m, rho = D / 0.7**2, 0.7
    problems = [
        ch.rolling_problem(inertia, m, rho),
        ch.contact_problem(inertia, m, rho),
        ch.cotangent_problem(inertia, D),
        ch.ball_problem(inertia, D, True),
        ch.ball_problem(inertia, D),
    ]
    g, omega = support.random_rotation(n, seed), support.random_triangle(n, seed)
    if n == 3:
        problems += [ch.classical_problem(inertia, D, attitude) for attitude in (False, True)]
        problems.append(ch.poisson_problem(inertia, D))
    same_motion(problems, {"g": g, "omega": omega})
    if n == 3:  # vectors take k as such
        x, gamma = support.rng_for(3, seed).normal(size=3), g[-1]
        ball, vectors = problems[4], problems[5]
        y = support.quiet_state(vectors, gamma=gamma, k=x)
        z = support.quiet_state(ball, gamma=gamma, k=support.triangle_of(x))
        close(gi.derivative(vectors, y)[3:], gi.derivative(ball, z)[3:], 30)
        area, momentum = gi.value(vectors, "area", y), gi.value(ball, "momentum", z)
        assert area == pytest.approx(x @ gamma, rel=1e-12, abs=1e-13)
        assert area**2 == pytest.approx(momentum, rel=1e-12, abs=1e-13)


@given(dimensions, kinds, seeds)
def test_ball_without_momentum(n, kind, seed):
    """Down to T*S^(n−1), in t and, with the special operator, in τ."""
    inertia, D = support.operator_of(kind, n, seed)
    gamma, p = support.random_tangent(n, seed)
    problems = [ch.ball_problem(inertia, D), ch.reduced_problem(inertia, D)]
    if kind == "special":
        problems.append(ch.hamiltonized_problem(inertia))
        # The solve, for a diagonal operator and a full one, is the closed form.
        nearly = np.diag(inertia.diagonal)
        nearly[0, -1] = nearly[-1, 0] = nearly[0, -1] + 1e-200
        others = (ch.GeneralInertia(inertia.diagonal), ch.GeneralInertia(nearly))
        problems += [ch.ball_problem(other, D) for other in others]
    same_motion(problems, {"gamma": gamma, "p": p})


@given(st.integers(2, 6), kinds, seeds)
@examples(6)
def test_veselovas_problem_for_every_r(n, kind, seed):
    """(g, w) with multipliers and (X, P) on T*V(n, r)."""
    inertia, _ = support.operator_of(kind, n, seed)
    r, g = 1 + seed % (n - 1), support.random_rotation(n, seed)
    body = ch.VeselovaLR(inertia, r)
    w = support.allowed_part(g[:r], support.random_triangle(n, seed))
    same_motion([body.lr(), body.stiefel()], {"g": g, "w": w})
    problem = body.stiefel()
    y = problem.random_state(seed)
    X, P = y.reshape(2, r, n)
    found = {f"pp-{s + 1}-{t + 1}": P[s] @ P[t] for s in range(r) for t in range(s, r) if r > 1}
    found |= {f"eps-{s + 1}-{t + 1}": X[s] @ P[t] for s in range(r) for t in range(s + 1, r)}
    for name, product in found.items():
        assert gi.value(problem, name, y) == pytest.approx(product, abs=1e-12)


@given(dimensions, seeds)
def test_veselovas_problem_in_closed_form(n, seed):
    """r = 1 and 𝓘_ij = 1/(a_i a_j): T*S^(n−1) in t and τ; at n = 3 vectors with f₁ = 0."""
    body, (gamma, p) = support.random_body(n, seed), support.random_tangent(n, seed)
    problems = [ch.VeselovaLR.from_a(body.a, 1).stiefel(), body.reduced(), body.hamiltonized()]
    if n == 3:
        problems += [body.classical(), body.multiplier()]
    same_motion(problems, {"gamma": gamma, "p": p})
    same_motion(problems[1:3], {"gamma": gamma, "p": p})  # all r_k


@pytest.mark.parametrize("f1", [0.4, -0.7])
def test_both_printed_forms_of_the_classical_problem(f1):
    """(w⃗, γ⃗) with λ, eqs. (3.1), (la), and (K⃗, γ⃗), eq. (3.2)."""
    body, (gamma, p) = support.random_body(3), support.random_tangent(3)
    problems = [body.multiplier(f1), body.classical(f1)]
    same_motion(problems, {"gamma": gamma, "k": np.cross(p, gamma) + f1 * gamma})
    printed, moments = problems[0], body.a / np.prod(body.a)
    y = support.quiet_state(printed, gamma=gamma, k=np.cross(p, gamma) + f1 * gamma)
    w, rate = (support.pieces(printed, z)["w"] for z in (y, gi.derivative(printed, y)))
    expected = np.cross(moments * w, w) + gi.value(printed, "multiplier", y) * gamma
    np.testing.assert_allclose(moments * rate, expected, atol=1e-13)


@given(dimensions, st.sampled_from(["diagonal", "full"]), seeds)
@examples(6)
def test_rubber_ball_is_the_veselova_problem(n, kind, seed):
    """Of the operator I + D: the reactions do not enter."""
    inertia, D = support.operator_of(kind, n, seed)
    ball, (gamma, p) = ch.RubberSphere(inertia, D), support.random_tangent(n, seed)
    same_motion(
        [ball.rolling(rho=0.7), ball.reduced(), ch.VeselovaLR(ball.total, 1).stiefel()],
        {"gamma": gamma, "p": p},
    )
    a = 0.4 * support.random_body(n, seed).a
    special = ch.RubberSphere.from_a(a, 1.2)
    close(special.body().a, a if n > 2 else np.sqrt(a[0] * a[1]))
    same_motion([special.reduced(), special.hamiltonized()], {"gamma": gamma, "p": p})
