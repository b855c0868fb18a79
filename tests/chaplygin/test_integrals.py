"""Integrals and Hamiltonians on T*S^(n−1) and the ellipsoid: definitions, and off the manifold."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin import support
from tests.chaplygin.support import close, dimensions, kinds, seeds
from tests.rows import examples

TO_T = {"sphere-reduced", "body-reduced"}


def polynomial(a, minors, squares):
    """Return the coefficients, lowest first, of Σ m_ij² P/((z − a_i)(z − a_j)) + Σ c_i P/(z − a_i)."""
    n = len(a)
    total = np.zeros(n)
    for i in range(n):
        total += squares[i] * np.poly(np.delete(a, i))
        for j in range(i):
            total[1:] += minors[i, j] ** 2 * np.poly(np.delete(a, [i, j]))
    return total[::-1]


@given(dimensions, st.integers(1, 3), seeds)
def test_integrals_are_coefficients_of_polynomials(n, equal, seed):
    """r_k, N_k and F_k by their definitions, for equal a_i too; energies and linear integrals."""
    for name, problem in support.of_parameters(n, seed, min(equal, n)).items():
        a = np.array(problem.parameters["a"])
        y = problem.random_state(seed)
        q, p = y[:n], y[n:]
        if "classical" in name or "multiplier" in name:
            continue
        u, D = q @ (q / a), problem.parameters.get("D")
        if name in TO_T:
            p = p / (D * np.sqrt(u))
        m = np.outer(q, p) - np.outer(p, q)
        i, j = np.triu_indices(n, 1)
        if name in ("neumann", "clebsch"):
            sigma, x, z = (1.3, 1.0, 0.0) if name == "neumann" else (-0.7, 0.4, 1.1)
            known = dict(enumerate(polynomial(a, m, sigma * q * q)))
            c, d = x + z / (a[i] * a[j]), sigma * (x * a - z / a)
            energy = 0.5 * c @ m[i, j] ** 2 + 0.5 * d @ q**2
        elif name == "ellipsoid":
            known = dict(enumerate(polynomial(a, m, p * p)))
            energy = 0.5 * p @ p
            joachimsthal = (p @ (p / a)) * ((q / a) @ (q / a))
            assert gi.value(problem, "joachimsthal", y) == pytest.approx(joachimsthal, rel=1e-12)
        else:
            minors = np.append(0.0, polynomial(a, m, 0 * q))[:n]  # times z
            known = dict(enumerate(minors - (p @ p) * polynomial(a, 0 * m, q * q)))
            K = D * D * u * (p @ p)
            assert gi.value(problem, "K", y) == pytest.approx(K, rel=1e-12)
            energy = 0.5 * D * D * p @ (a * p)
            if name.startswith("sphere"):
                energy = K / (2 * D) - energy / D**2
        assert gi.value(problem, "energy", y) == pytest.approx(energy, rel=2e-12)
        size = np.max(np.abs(list(known.values())))
        for letter, f in problem.invariants.items():
            if letter[0] in "rNF" and letter[1:].isdecimal():
                assert gi.value(problem, f, y) == pytest.approx(
                    known[int(letter[1:])], abs=1e-12 * size
                )
            elif letter.startswith("f-"):
                first, second = (int(index) - 1 for index in letter.split("-")[1:])
                assert a[first] == a[second]
                assert gi.value(problem, f, y) == pytest.approx(m[first, second], abs=1e-13)


def test_linear_integrals_of_equal_parameters():
    """Two pairs: f-1-2, f-3-4; four equal: neighbours and the sum of all squares."""
    pairs, four = (
        ch.Veselova([1.0, 1.0, 2.0, 2.0]).reduced(),
        ch.Veselova([2.0, 1.0, 1.0, 1.0, 1.0]),
    )
    assert [name for name in pairs.invariants if name[0] == "f"] == ["f-1-2", "f-3-4"]
    problem = four.hamiltonized()
    names = [name for name in problem.invariants if name[0] in "fc"]
    assert names == ["f-2-3", "f-3-4", "f-4-5", "casimir-2"]
    y = problem.random_state(1)
    q, p = y[1:5], y[6:]
    casimir = (q @ q) * (p @ p) - (q @ p) ** 2
    assert gi.value(problem, "casimir-2", y) == pytest.approx(casimir, rel=1e-13)


def canonical(f, g):
    n = len(f) // 2
    return f[:n] @ g[n:] - f[n:] @ g[:n]


@given(st.integers(3, 7), seeds)
def test_the_integrals_commute_and_are_independent(n, seed):
    """All Dirac brackets vanish, of n − 1 integrals whose differentials are independent."""
    for name, problem in support.of_parameters(n, seed).items():
        if problem.hamiltonian is None:
            continue
        y = problem.random_state(seed)
        names = problem.invariants.keys() - ({"energy"} if name == "clebsch" else set())
        slopes = {f: gi.gradient(problem, f, y) for f in names}
        first, second = (gi.gradient(problem, f, y) for f in problem.constraints)
        assert len(slopes) == n - 1, name
        between = canonical(first, second)
        for f, g in itertools.combinations(slopes.values(), 2):
            terms = (
                canonical(f, first) * canonical(g, second),
                canonical(f, second) * canonical(g, first),
            )
            bracket = canonical(f, g) - (terms[0] - terms[1]) / between
            assert abs(bracket) < 1e-11 * np.linalg.norm(f) * np.linalg.norm(g), name
        stacked = np.array([*slopes.values(), first, second])
        stacked /= np.linalg.norm(stacked, axis=1)[:, None]
        assert np.linalg.svd(stacked, compute_uv=False)[-1] > 1e-9, name


# --- off the manifold -----------------------------------------------------------------------------


@given(dimensions, kinds, seeds)
@examples(4)
def test_what_is_kept_off_the_manifold(n, kind, seed):
    """Round-off leaves the manifold; what is kept there does not drift.

    Constraints that are differentiated, and frames, hold on the manifold only.
    """
    for name, problem in {
        **support.of_operator(kind, n, seed),
        **support.of_parameters(n, seed),
    }.items():
        if {"g", "omega", "w"} & problem.slices.keys() or problem.rows > 30:
            continue
        y = problem.random_state(seed) * support.rng_for(n, seed + 31).uniform(
            0.6, 1.5, problem.rows
        )
        velocity, kept = gi.derivative(problem, y), {"energy", "norm", "tangency", "constraint"}
        kept |= {"ellipsoid"} | ({"K"} if "hamiltonized" not in name else set())
        for quantity in kept & problem.diagnostics.keys():
            slope = gi.gradient(problem, quantity, y)
            size = max(1.0, np.linalg.norm(slope) * np.linalg.norm(velocity))
            assert abs(slope @ velocity) < 1e-13 * size, (name, quantity)


@given(dimensions, kinds, seeds)
def test_omega_depends_on_the_direction_of_gamma_alone(n, kind, seed):
    problem = ch.ball_problem(*support.operator_of(kind, n, seed))
    y = problem.state(gamma=support.random_tangent(n, seed)[0], k=support.random_triangle(n, seed))
    longer = np.concatenate([y[:-n], 3.7 * y[-n:]])
    close(support.generator_of(problem, longer), support.generator_of(problem, y), 10)


@given(dimensions, seeds)
def test_hamiltonian_forms_off_the_manifold(n, seed):
    """The gradients are those of H and c (q, p)(q, Bp), whose hidden constraint is (q, p) = 0."""
    a, D = support.random_body(n, seed).a, support.random_body(n, seed).D
    largest = 1.3 * np.max(a) ** 2
    one = np.ones(n)
    for problem, c, b in (
        (ch.ChaplyginSphere(a, largest).hamiltonized(), 1.0, a),
        (ch.Veselova(a, D).hamiltonized(), -D * D, a),
        (ch.clebsch_problem(a, -0.7, 0.4, 1.1), 0.5, one),
        (ch.ellipsoid_problem(a), 0.0, one),
    ):
        y = support.rng_for(n, seed + 41).normal(size=2 * n)
        q, p = y[:n], y[n:]
        form, params = problem.hamiltonian, problem.params.view(support.Rows)
        dq, dp, g, G = (np.zeros(size).view(support.Rows) for size in (n, n, 1, n))
        work = np.zeros(problem.work).view(support.Rows)
        form.gradients(params, 0.0, q.view(support.Rows), p.view(support.Rows), dq, dp, work)
        along, weighted = q @ p, q @ (b * p)
        more = c * np.concatenate([p * weighted + along * b * p, q * weighted + along * b * q])
        expected = gi.gradient(problem, "energy", y) + more
        close(np.concatenate([dq, dp]), expected, 100 * max(1.0, np.max(np.abs(expected))))
        form.constraint(params, q.view(support.Rows), g, G, work)
        metric = 1 / a if problem.name == "ellipsoid" else one
        close([g[0], *G], [0.5 * (q @ (metric * q) - 1.0), *(metric * q)], 10)
        assert form.separable == (problem.name == "ellipsoid")


@given(dimensions, seeds)
def test_geodesics_and_neumanns_motion_are_newtonian(n, seed):
    """ẍ and the force differ by a normal; the field, off the manifold too, keeps the surface."""
    of = support.of_parameters(n, seed)
    a = np.array(of["ellipsoid"].parameters["a"])
    for name, force, normal in (("ellipsoid", 0 * a, 1 / a), ("neumann", -1.3 * a, 1 + 0 * a)):
        y = of[name].random_state(seed)
        x, v = y[:n], y[n:]
        rate, normal = gi.derivative(of[name], y), normal * x
        close(rate[:n], v, 10)
        left = rate[n:] - force * x
        close(left - (left @ normal) / (normal @ normal) * normal, 0 * x, 100)


@given(dimensions, kinds, seeds)
def test_constraints_measure_how_much_is_wrong(n, kind, seed):
    """Slip, twist, what a velocity has that is forbidden, and how far γ is from the last row of g."""
    of, rng = support.of_operator(kind, n, seed), support.rng_for(n, seed + 5)
    triangle, vector = rng.normal(size=n * (n - 1) // 2), rng.normal(size=n)
    wrong = [("rolling", "rolling", "v", vector[1:]), ("contact", "vertical", "gamma", vector)]
    if n > 2:
        for name, constraint, piece, rows in (
            ("rubber", "twist", "omega", slice(-n, None)),
            ("lr-1", "forbidden", "w", slice(0, n)),
        ):
            away = triangle - support.allowed_part(
                of[name].random_state(seed)[of[name].slices["g"]][rows], triangle
            )
            wrong.append((name, constraint, piece, away))
    for name, constraint, piece, off in wrong:
        y = of[name].random_state(seed)
        y[of[name].slices[piece]] += off
        assert gi.value(of[name], constraint, y) == pytest.approx(np.linalg.norm(off), rel=1e-11)
    of = support.of_parameters(n, seed)
    longer = 1.1 * of["ellipsoid"].random_state(seed)
    assert gi.value(of["ellipsoid"], "ellipsoid", longer) == pytest.approx(0.21, rel=1e-12)
    for name in ("body-classical", "body-multiplier") if n == 3 else ():
        y = of[name].random_state(seed)
        y[of[name].slices["k" if name == "body-classical" else "w"]] += (
            0.3 * y[of[name].slices["gamma"]]
        )
        assert gi.value(of[name], "constraint", y) == pytest.approx(0.3, rel=1e-12)
