"""Attitude and contact point along reduced motions, in any dimension; the geometric phase."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import pieces, random_rotation, random_special


@pytest.mark.parametrize("n", [3, *(pytest.param(n, marks=pytest.mark.nightly) for n in (2, 4, 5))])
def test_along_the_exact_flow(n):
    """Against the contact problem integrated; vertical and contact point to rounding."""
    sphere = ch.ChaplyginSphere(inertia=random_special(n, 1))
    reduced, contact = sphere.reduced(), sphere.contact(rho=0.7)
    exact = reduced.exact(reduced.random_state(2))
    turn = 1.0 / np.max(np.abs(exact.mean_frequencies))
    t = np.linspace(0.0, -30 * turn, 1200)
    upright = pieces(contact, ch.converted(exact(0.0), reduced, contact))["g"].reshape(n, n)
    g0 = np.eye(n)
    g0[:-1, :-1] = random_rotation(n - 1) if n > 2 else 1.0  # about the vertical
    path = ch.rolled_path(contact, reduced, t, exact(t), g0 @ upright, np.arange(n - 1.0))
    np.testing.assert_allclose(path.attitude[0], g0 @ upright, atol=1e-15)
    assert path.error < 1e-12
    assert ch.rolled_path(contact, reduced, t[:120:2], exact(t[:120:2])).error < 4e-14  # order 6
    np.testing.assert_allclose(path.contact[0], np.arange(n - 1.0))
    run = gi.solve(
        contact, contact.canonical(path.states[0]), t_end=t[-1], step=0.01 * turn,
        method="dop853", progress=False,
    )  # fmt: skip
    np.testing.assert_allclose(path.states[-1], run.y[-1], rtol=0, atol=1e-12)
    eye = np.einsum("tij,tkj->tik", path.attitude, path.attitude)
    np.testing.assert_allclose(eye, np.broadcast_to(np.eye(n), eye.shape), atol=1e-14)


@pytest.mark.parametrize("momentum", [True, False])
def test_the_reaction_along_the_exact_motion(momentum):
    """n = 3: algebraic attitude, transported attitude, reaction Λ = m dv/dt."""
    sphere = ch.ChaplyginSphere(inertia=random_special(3, 1))
    contact, classical = sphere.contact(rho=0.7), sphere.classical()
    y = classical.random_state(4)
    if not momentum:
        y[:3] -= (y[:3] @ y[3:]) * y[3:]
    exact = classical.exact(y)
    path = ch.ContactPath(exact, 0.7)
    t = np.linspace(0.0, 2.0, 200)
    start = pieces(contact, path.state(0.0))
    ball = sphere.ball()
    triangles = [ch.converted(z, classical, ball) for z in exact(t)]
    for problem, states in ((classical, exact(t)), (ball, triangles)):
        transported = ch.rolled_path(contact, problem, t, states, start["g"], start["r"])
        np.testing.assert_allclose(path.state(t), transported.states, rtol=0, atol=1e-12)
    h, mass = 1e-2, contact.parameters["m"]
    for at, allowed in ((0.0, 1e-10), (7.3, 1e-10), (1e5, 1e-6)):  # a rounding of t, over h²
        ahead = path.contact(at + h * np.arange(-2, 3))
        acceleration = np.array([-1, 16, -30, 16, -1]) @ ahead / (12 * h * h)
        for i in (1, 2):
            found = gi.value(contact, f"reaction-{i}", path.state(at))
            assert found == pytest.approx(mass * acceleration[i - 1], abs=allowed)


def test_the_geometric_phase_is_the_area_gone_round():
    """Gauss and Bonnet: γ along a circle of latitude, n = 3; a great circle has none."""
    sphere = ch.ChaplyginSphere.homogeneous(3, 1.5, 2.0)
    reduced, contact = sphere.reduced(), sphere.contact(rho=1.0)
    probe = reduced.state(gamma=[1.0, 0.0, 0.0], p=[0.0, 1.0, 0.0])
    speed = gi.derivative(reduced, probe)[1]  # γ̇ = speed · p
    t = np.linspace(0.0, 2 * np.pi, 600)
    for height in (0.0, -0.8):
        radius = np.sqrt(1 - height**2)
        gamma = np.stack([radius * np.cos(t), radius * np.sin(t), np.full_like(t, height)], -1)
        rate = radius * np.stack([-np.sin(t), np.cos(t), 0 * t], -1)
        path = ch.rolled_path(contact, reduced, t, np.concatenate([gamma, rate / speed], -1))
        phase = ch.geometric_phase(path)
        area = 2 * np.pi * (1 - height)
        np.testing.assert_allclose(np.trace(phase), 2 * np.cos(area), atol=1e-10)
        np.testing.assert_allclose(abs(phase[0, 1]), abs(np.sin(area)), atol=1e-10)
    half = np.concatenate([gamma, rate / speed], -1)[:300]
    path = ch.rolled_path(contact, reduced, t[:300], half)
    with pytest.raises(gi.DomainError, match="comes back"):
        ch.geometric_phase(path)


def test_refusals():
    sphere = ch.ChaplyginSphere(inertia=random_special(3, 1))
    reduced, contact = sphere.reduced(), sphere.contact(rho=1.0)
    exact = reduced.exact(reduced.random_state(1))
    mixed = np.array([0.0, 2.0, 1.0, 3.0, 4.0, 5.0, 6.0, 7.0])
    for target, t, states, text in (
        (contact, [0.0, 1.0], 2, "at least 8 times"),
        (contact, mixed, 8, "in order"),
        (contact, np.arange(9.0), 10, "a state for every time"),
        (reduced, np.arange(9.0), 9, "contact"),
    ):
        with pytest.raises(gi.DomainError, match=text):
            ch.rolled_path(target, reduced, t, exact(np.arange(float(states))))
    t = np.linspace(0.0, 400.0, 60)  # far too few: said by the error
    assert ch.rolled_path(contact, reduced, t, exact(t)).error > 1e-3
