"""Maps between systems: fields carried over, round trips, levels, integrated motions, errors."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import (
    dimensions,
    random_body,
    random_direction,
    random_special,
    random_tangent,
    rng_for,
    seeds,
)
from tests.rows import examples


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
    gauss = ch.gauss_map(body.a)
    found.append((gauss, gauss.source.random_state(seed)))
    if n == 3:
        k = rng_for(3, seed).normal(size=3)
        y = sphere.classical().state(gamma=random_direction(3, seed), k=k)
        found.append((ch.chaplygin_change(sphere, y), y))
    return found


@given(dimensions, seeds)
@examples(6)
def test_motions_go_to_motions(n, seed):
    """To the level N_0 = 0 of Neumann's family, with N_k = r_(k−1) for the others."""
    for correspondence, y in cases(n, seed):
        assert correspondence.defect(y) < 1e-11, correspondence.name
        source, target, z = correspondence.source, correspondence.target, correspondence.forward(y)
        np.testing.assert_array_equal(target.canonical(z), z)
        np.testing.assert_allclose(correspondence.backward(z), y, rtol=0, atol=1e-13)
        if correspondence.name in ("neumann", "clebsch"):
            if "N0" in target.invariants:
                assert gi.value(target, "N0", z) == pytest.approx(0.0, abs=1e-12)
            for k in range(2, n - 2):
                expected = gi.value(source, f"r{k - 1}", y)
                assert gi.value(target, f"N{k}", z) == pytest.approx(expected, rel=1e-11)
        if n == 3:  # the defect is none that is always small: of the time reversed, it is 2
            wrong = dataclasses.replace(correspondence, rate=reverse(correspondence.rate))
            assert wrong.defect(y) == pytest.approx(2.0, abs=1e-9)


def reverse(rate):
    return gi.observable(lambda params, t, y, work: -rate(params, t, y, work))


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


@given(seeds)
@examples(6)
def test_chaplygins_change(seed):
    """Area zero, D₁ ≤ D, I₁ + D₁ = I + D; near c = 0 it is nearly the identity."""
    sphere = ch.ChaplyginSphere(inertia=random_special(3, seed))
    problem = sphere.classical()
    gamma, k = random_direction(3, seed), rng_for(3, seed).normal(size=3)
    y = problem.state(gamma=gamma, k=k)
    change = ch.chaplygin_change(sphere, y)
    z, other = change.forward(y), change.target
    assert gi.value(other, "area", z) == pytest.approx(0.0, abs=1e-13)
    D1 = other.parameters["D"]
    assert 0.0 < D1 <= sphere.D
    first = np.array(ch.SpecialInertia(other.parameters["a"], D1).moments)
    np.testing.assert_allclose(first + D1, sphere.inertia.moments + sphere.D, rtol=1e-12)
    level = k - (k @ gamma) * gamma
    near = problem.state(gamma=gamma, k=level + 1e-9 * gamma)
    change = ch.chaplygin_change(sphere, near)
    np.testing.assert_allclose(change.forward(near), near, atol=1e-7)
    assert change.rate_at(near) == pytest.approx(1.0, abs=1e-7)
    assert change.target.parameters["D"] == pytest.approx(sphere.D, rel=1e-14)


@given(seeds)
@examples(6)
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
    np.testing.assert_allclose(got, expected, rtol=1e-11, atol=1e-13)
    np.testing.assert_array_equal(ch.fedorov_state(z), y)
    back = ch.fedorov_ball(1.0 + sphere.D / sphere.inertia.moments, sphere.D)
    np.testing.assert_allclose(back.inertia.moments, sphere.inertia.moments, rtol=1e-12)


def test_errors():
    body = ch.ChaplyginSphere(inertia=ch.GeneralInertia([1.0, 2.0, 3.0, 1.5, 1.2, 0.7]), D=1.0)
    sphere = ch.ChaplyginSphere.from_moments([1.0, 1.5, 2.0], 1.0, 1.0)
    tensor = [[1.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 2.0]]
    turned = ch.ChaplyginSphere.from_moments(tensor, 1.0, 1.0)
    for make, text in (
        (lambda: ch.hamiltonization(body), "special operator"),
        (lambda: ch.to_clebsch(body, np.ones(8)), "special operator"),
        (lambda: ch.chaplygin_change(sphere, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]), "not parallel"),
        (lambda: ch.chaplygin_change(body, np.ones(6)), "dimension 3"),
        (lambda: ch.chaplygin_change(turned, np.ones(6)), "principal axes"),
        (lambda: ch.fedorov_ball([0.5, 2.0, 3.0], 1.0), "greater than 1"),
        (lambda: ch.fedorov_body(body), "principal axes"),
    ):
        with pytest.raises(gi.DomainError, match=text):
            make()
