"""Invariants, constraints and gradients, by derivatives in extended precision."""

import numpy as np
import pytest

import chaplygin as ch
from geomint.kernels.numbers.blocks import Block
from tests.chaplygin.support import (
    CASES,
    DIMENSIONS,
    extended,
    field_of,
    gradients_of,
    mp,
    random_special,
    random_tangent,
    rate,
    rng_for,
    value_of,
)

ROOTS = {  # norms: no derivative at zero
    *("orthogonality", "spatial-momentum", "vertical", "rolling", "twist", "forbidden"),
    *("orthonormality", "cotangency"),
}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_invariants_and_constraints_are_constant(case):
    velocity = field_of(case.problem, extended(case.y))
    assert max(abs(float(v)) for v in velocity) > 1e-3
    for name in set(case.problem.invariants) | (set(case.problem.constraints) - ROOTS):
        value = float(value_of(case.problem, name, case.y))
        assert abs(rate(case.problem, name, case.y, velocity)) < 4e-15 * max(1.0, abs(value)), name


@pytest.mark.parametrize("case", CASES, ids=str)
def test_constraints_vanish(case):
    names = set(case.problem.constraints)
    if "spatial-momentum" in names and "attitude" in case.label:
        names.remove("spatial-momentum")  # k0 is k here, while g is not 1
    for name in names:
        assert abs(value_of(case.problem, name, case.y)) < 2e-15 * max(1.0, max(abs(case.y)))


@pytest.mark.parametrize("case", CASES, ids=str)
def test_every_invariant_varies_off_the_orbit(case):
    """A diagnostic that never moves would pass all the tests above."""
    direction = extended(rng_for(case.sphere.n, 21).normal(size=len(case.y)))
    quantities = {**case.problem.invariants, **case.problem.constraints}
    if case.sphere.n > 2:  # on a line nothing accelerates
        quantities = case.problem.diagnostics
    for name in quantities:
        if name not in ROOTS:
            assert abs(rate(case.problem, name, case.y, direction)) > 1e-4, name


def off_manifold(case):
    return case.y * rng_for(case.sphere.n, 31).uniform(0.6, 1.5, len(case.y))


def stays_off(case):
    """Constraints that are differentiated, and frames, hold on the manifold only."""
    return not {"g", "omega", "w"} & set(case.problem.slices)


@pytest.mark.parametrize("case", [c for c in CASES if stays_off(c)], ids=str)
def test_kept_off_the_manifold(case):
    """Round-off leaves the manifold; what is kept there does not drift."""
    y = off_manifold(case)
    velocity = field_of(case.problem, extended(y))
    names = {"energy", "norm", "tangency", "constraint", "ellipsoid"}
    if "hamiltonized" not in case.label:
        names.add("K")
    for name in names & set(case.problem.diagnostics):
        size = max(1.0, abs(float(value_of(case.problem, name, y))))
        assert abs(rate(case.problem, name, y, velocity)) < 1e-14 * size, name


def test_ro1_ro2_as_printed_lose_the_energy_off_the_manifold():
    """Why the reduced field has q = (γ, γ)p − (γ, p)γ for p in ω: the printed one drifts."""
    inertia = random_special(3)
    a, D = extended(inertia.a), mp.mpf(inertia.D)
    gamma, p = (extended(v) for v in random_tangent(3))
    p = p + gamma / 100
    u = gamma @ (gamma / a)

    def omega_on(x):
        closed = gamma / a * (p @ x) - p * ((gamma / a) @ x)
        return (closed - (gamma * ((a * p) @ x) - a * p * (gamma @ x)) / D) / (D * u)

    printed = np.concatenate([-omega_on(gamma), -omega_on(p)])
    h, problem = mp.mpf("1e-15"), ch.reduced_problem(inertia, inertia.D)

    def energy(state):  # eq. (ham0), with the printed ω
        g, q = state[:3], state[3:]
        v = g @ (g / a)
        first = v * (q @ q) - (g @ q) * (q @ (g / a))
        second = (g @ g) * (q @ (a * q)) - (g @ (a * q)) * (g @ q)
        return (first - second / D) / (2 * D * v)

    y = np.concatenate([gamma, p])
    drift = (energy(y + h * printed) - energy(y - h * printed)) / (2 * h)
    assert abs(drift) > 1e-8
    assert abs(rate(problem, "energy", y, field_of(problem, y))) < 1e-15


@pytest.mark.parametrize("n", DIMENSIONS)
def test_hamiltonian_gradients(n):
    """The gradients are those of H + (γ, p̃)(γ, Ap̃), everywhere."""
    inertia = random_special(n)
    problem = ch.hamiltonized_problem(inertia)
    rng = rng_for(n, 41)
    y = extended(np.concatenate([rng.normal(size=n), rng.normal(size=n)]))
    a, h = extended(inertia.a), mp.mpf("1e-15")

    def modified(state):
        q, p = state[:n], state[n:]
        return value_of(problem, "energy", state) + (q @ p) * (q @ (a * p))

    dq, dp = gradients_of(problem, y)
    for i, e in enumerate(np.eye(2 * n)):
        direction = extended(e)
        slope = (modified(y + h * direction) - modified(y - h * direction)) / (2 * h)
        assert abs(slope - (dq[i] if i < n else dp[i - n])) < 1e-14 * max(1, abs(slope))


@pytest.mark.parametrize("n", DIMENSIONS)
def test_hamiltonian_form_gives_the_field(n):
    """q̇ = ∂H̃/∂p, ṗ = −∂H̃/∂q − λ q with λ from (q, q̇)˙ = 0; the hidden constraint is (q, p) = 0."""
    inertia = random_special(n)
    problem = ch.hamiltonized_problem(inertia)
    y = extended(problem.state(**dict(zip(("gamma", "p"), random_tangent(n), strict=True))))
    dq, dp = gradients_of(problem, y)
    field = field_of(problem, y)
    q = y[:n]
    assert max(abs(dp - field[:n])) < 1e-15
    rest = -dq - field[n:]
    assert max(abs(rest - (q @ rest) * q)) < 4e-15
    leaving = np.concatenate([q, y[n:] + 0.25 * q])
    a = inertia.a
    size = inertia.D * sum(q * q / a) + sum(q * q * a)
    assert abs(q @ gradients_of(problem, leaving)[1] - 0.25 * size) < 1e-14


@pytest.mark.parametrize("n", DIMENSIONS)
def test_constraint_and_its_jacobian(n):
    problem = ch.hamiltonized_problem(random_special(n))
    q, g, jacobian = rng_for(n, 51).normal(size=n), np.zeros(1), np.zeros(n)
    problem.hamiltonian.constraint(
        Block(problem.params), Block(q), Block(g), Block(jacobian), Block(np.zeros(0))
    )
    assert g[0] == pytest.approx(0.5 * (q @ q - 1.0), rel=1e-14)
    np.testing.assert_array_equal(jacobian, q)
    assert problem.hamiltonian.constraints == 1


@pytest.mark.parametrize("case", [c for c in CASES if "attitude" in c.label], ids=str)
def test_attitude_and_spatial_momentum(case):
    """ġ = gω, and |Ad_g k − k_0| is what it says."""
    n, pieces = case.sphere.n, case.problem.slices
    g = case.y[pieces["g"]].reshape(n, n)
    out = field_of(case.problem, case.y)
    gamma, dgamma = case.y[pieces["gamma"]], out[pieces["gamma"]]
    vertical = out[pieces["g"]].reshape(n, n) @ gamma + g @ dgamma
    np.testing.assert_allclose(vertical, 0.0, atol=1e-14)  # Γ = gγ is fixed in space
    k = case.problem.physical_state(case.y)["k"]
    full = np.zeros((n, n))
    full[np.triu_indices(n, 1)] = k
    full = full - full.T
    difference = g @ full @ g.T - full
    expected = np.sqrt(0.5 * np.sum(difference**2))
    got = value_of(case.problem, "spatial-momentum", case.y)
    assert got == pytest.approx(expected, abs=1e-13)
    still = case.y.copy()
    still[pieces["g"]] = np.eye(n).reshape(-1)
    assert value_of(case.problem, "spatial-momentum", still) < 1e-15
    still[pieces["g"]] *= 1.01
    assert value_of(case.problem, "orthogonality", still) == pytest.approx(0.0201 * np.sqrt(n))
