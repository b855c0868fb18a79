"""Maps between systems: fields carried over, round trips, levels, integrated motions, errors."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import (
    DIMENSIONS,
    random_body,
    random_direction,
    random_geodesic,
    random_special,
    random_tangent,
    rng_for,
)

SEEDS = range(3)


def cases(n, seed):
    """Every correspondence at a random state: (correspondence, state of its source)."""
    sphere, body = ch.ChaplyginSphere(inertia=random_special(n, seed)), random_body(n, seed)
    gamma, p = random_tangent(n, seed)
    found = []
    for system in (sphere, body):
        reduction = ch.hamiltonization(system)
        found.append((reduction, reduction.source.state(gamma=gamma, p=p)))
    y = sphere.hamiltonized().state(gamma=gamma, p=p)
    found.append((ch.to_clebsch(sphere, y), y))
    y = body.hamiltonized().state(gamma=gamma, p=p)
    found.append((ch.to_neumann(body, y), y))
    x, v = random_geodesic(body.a, seed)
    gauss = ch.gauss_map(body.a)
    found.append((gauss, gauss.source.state(x=x, p=v)))
    if n == 3:
        k = rng_for(3, seed).normal(size=3)
        y = sphere.classical().state(gamma=random_direction(3, seed), k=k)
        found.append((ch.chaplygin_change(sphere, y), y))
    return found


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("n", DIMENSIONS)
def test_motions_go_to_motions(n, seed):
    for correspondence, y in cases(n, seed):
        assert correspondence.defect(y) < 3e-12, correspondence.name
        z = correspondence.forward(y)
        np.testing.assert_array_equal(correspondence.target.canonical(z), z)
        np.testing.assert_allclose(correspondence.backward(z), y, rtol=0, atol=4e-15)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_a_wrong_rate_is_a_defect(n):
    """The defect is none that is always small: of the time reversed, it is 2."""
    import dataclasses

    for correspondence, y in cases(n, 0):
        rate = correspondence.rate

        def reversed_rate(params, t, y, work, rate=rate):
            return -rate(params, t, y, work)

        wrong = dataclasses.replace(correspondence, rate=reversed_rate)
        assert wrong.defect(y) == pytest.approx(2.0, abs=1e-10)


@pytest.mark.nightly
@pytest.mark.parametrize(
    "name", ["hamiltonization", "clebsch", "neumann", "gauss-map", "chaplygin-change"]
)
def test_integrated_motions(name):
    """Source with its clock, and target, integrated apart: the same states, n = 3."""
    correspondence, y = next((c, y) for c, y in cases(3, 1) if c.name == name)
    source = correspondence.clocked()
    end = {"tau_end" if source.time == "tau" else "t_end": 2.0}
    last = gi.solve(source, np.append(y, 0.0), method="gauss-8", step=0.02, **end).y[-1]
    target, time = correspondence.target, last[-1]
    end = {"tau_end" if target.time == "tau" else "t_end": time}
    start = correspondence.forward(y)
    got = gi.solve(target, start, method="gauss-8", step=abs(time) / 200, **end).y[-1]
    np.testing.assert_allclose(got, correspondence.forward(last[:-1]), rtol=0, atol=1e-12)


def test_neumanns_level():
    """The image is the level N_0 = 0, with N_k = r_k for the others."""
    for n in DIMENSIONS:
        for correspondence, y in cases(n, 0):
            if correspondence.name not in ("neumann", "clebsch"):
                continue
            z, target = correspondence.forward(y), correspondence.target
            if "N0" in target.invariants:
                assert gi.value(target, "N0", z) == pytest.approx(0.0, abs=1e-13)
            for k in range(1, n - 2):
                expected = gi.value(correspondence.source, f"r{k - 1}", y) if k > 1 else None
                if expected is not None:
                    assert gi.value(target, f"N{k}", z) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("seed", range(6))
def test_chaplygins_change(seed):
    """Area zero, D₁ ≤ D, I₁ + D₁ = I + D; near c = 0 it is nearly the identity."""
    sphere = ch.ChaplyginSphere(inertia=random_special(3, seed))
    problem = sphere.classical()
    gamma, k = random_direction(3, seed), rng_for(3, seed).normal(size=3)
    y = problem.state(gamma=gamma, k=k)
    change = ch.chaplygin_change(sphere, y)
    z, other = change.forward(y), change.target
    assert gi.value(other, "area", z) == pytest.approx(0.0, abs=1e-14)
    D1 = other.parameters["D"]
    assert 0.0 < D1 <= sphere.D
    first = np.array(ch.SpecialInertia(other.parameters["a"], D1).moments)
    np.testing.assert_allclose(first + D1, sphere.inertia.moments + sphere.D, rtol=1e-13)
    level = k - (k @ gamma) * gamma
    near = problem.state(gamma=gamma, k=level + 1e-9 * gamma)
    change = ch.chaplygin_change(sphere, near)
    np.testing.assert_allclose(change.forward(near), near, atol=1e-7)
    assert change.rate_at(near) == pytest.approx(1.0, abs=1e-7)
    assert change.target.parameters["D"] == pytest.approx(sphere.D, rel=1e-15)


@pytest.mark.parametrize("seed", range(6))
def test_fedorovs_tori(seed):
    """F₁ = −f₁, F₃ = (f₄/2 − f₃)/D, F₄ = f₄; the printed F₁ = f₁, F₃ = f₃ are not."""
    sphere = ch.ChaplyginSphere(inertia=random_special(3, seed))
    ball, body = sphere.classical(), ch.fedorov_body(sphere)
    y = ball.state(gamma=random_direction(3, seed), k=rng_for(3, seed).normal(size=3))
    z = ch.fedorov_state(y)
    f1 = float(z[:3] @ z[3:])
    veselova = body.classical(f1)
    f3, f4 = gi.value(veselova, "energy", z), gi.value(veselova, "K", z)
    expected = gi.value(ball, "area", y), gi.value(ball, "energy", y), gi.value(ball, "K", y)
    got = ch.fedorov_constants(f1, f3, f4, sphere.D)
    np.testing.assert_allclose(got, expected, rtol=1e-12)
    assert abs(f3 - expected[1]) > 1e-3
    np.testing.assert_array_equal(ch.fedorov_state(z), y)
    back = ch.fedorov_ball(1.0 + sphere.D / sphere.inertia.moments, sphere.D)
    np.testing.assert_allclose(back.inertia.moments, sphere.inertia.moments, rtol=1e-12)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_fedorovs_tori_without_momentum(n):
    """Any n: sphere and body with the same a and D have the same K and r_k."""
    inertia, (gamma, p) = random_special(n), random_tangent(n)
    sphere, body = ch.ChaplyginSphere(inertia=inertia), ch.Veselova(inertia.a, inertia.D)
    y = sphere.hamiltonized().state(gamma=gamma, p=p)
    own, other = sphere.hamiltonized(), body.hamiltonized()
    shared = set(own.invariants) - {"energy"}
    assert shared == set(other.invariants) - {"energy"}
    for name in shared:
        assert gi.value(own, name, y) == pytest.approx(gi.value(other, name, y), rel=1e-14)
    difference = (
        gi.value(own, "K", y) / (2 * inertia.D) - gi.value(other, "energy", y) / inertia.D**2
    )
    assert gi.value(own, "energy", y) == pytest.approx(difference, rel=1e-12)


def test_errors():
    body = ch.ChaplyginSphere(inertia=ch.GeneralInertia([1.0, 2.0, 3.0, 1.5, 1.2, 0.7]), D=1.0)
    with pytest.raises(gi.DomainError, match="special operator"):
        ch.hamiltonization(body)
    with pytest.raises(gi.DomainError, match="special operator"):
        ch.to_clebsch(body, np.ones(8))
    sphere = ch.ChaplyginSphere.from_moments([1.0, 1.5, 2.0], 1.0, 1.0)
    with pytest.raises(gi.DomainError, match="not parallel"):
        ch.chaplygin_change(sphere, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    with pytest.raises(gi.DomainError, match="dimension 3"):
        ch.chaplygin_change(body, np.ones(6))
    tensor = [[1.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 2.0]]
    turned = ch.ChaplyginSphere.from_moments(tensor, 1.0, 1.0)
    with pytest.raises(gi.DomainError, match="principal axes"):
        ch.chaplygin_change(turned, np.ones(6))
    with pytest.raises(gi.DomainError, match="greater than 1"):
        ch.fedorov_ball([0.5, 2.0, 3.0], 1.0)
    with pytest.raises(gi.DomainError, match="principal axes"):
        ch.fedorov_body(body)
