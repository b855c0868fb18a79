"""Attitude and contact point for pictures: all representations tell the same, and what is exact."""

from __future__ import annotations

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi

BALL = ch.ChaplyginSphere.from_moments([1.0, 1.7, 2.4], m=1.0, rho=1.0)
TIMES = np.linspace(0.0, 2.0, 101)
CONTACT, CLASSICAL = BALL.contact(rho=1.0), BALL.classical()
FORMS = {
    "contact": CONTACT,
    "rolling": BALL.rolling(rho=1.0),
    "classical": CLASSICAL,
    "classical-attitude": BALL.classical(attitude=True),
    "ball": BALL.ball(),
    "ball-attitude": BALL.ball(attitude=True),
    "on-group": BALL.on_group(),
    "poisson": BALL.poisson(),
    "reduced": BALL.reduced(),
    "hamiltonized": BALL.hamiltonized(),
}


@pytest.fixture(scope="module")
def truth() -> ch.ContactPath:
    """By the exact flow, which shares nothing with paths."""
    first = CLASSICAL.state(gamma=[0.36, 0.48, 0.8], p=[0.8, -0.6, 0.0])
    return ch.ContactPath(CLASSICAL.exact(first), 1.0)


@pytest.mark.parametrize("name", FORMS)
def test_every_representation_tells_the_same(name: str, truth: ch.ContactPath) -> None:
    problem = FORMS[name]
    states = np.array([ch.converted(y, CONTACT, problem) for y in truth.state(TIMES)])
    path = problem.make_path(TIMES, states)
    np.testing.assert_allclose(path.attitude, truth.attitude(TIMES), atol=1e-7)
    np.testing.assert_allclose(path.contact, truth.contact(TIMES), atol=1e-7)
    carried = "r" in problem.slices
    assert (path.unit, path.radius) == ("dimensionless" if carried else "radii", 1.0)
    resting = problem.state(gamma=[0.0, 0.0, 1.0], p=[0.0, 0.0, 0.0])
    still = problem.make_path(TIMES, np.tile(resting, (len(TIMES), 1)))
    assert np.all(still.contact == 0.0)
    np.testing.assert_allclose(still.attitude, np.tile(np.eye(3), (len(TIMES), 1, 1)))


def test_samples_that_are_too_far_apart_are_refused() -> None:
    times = 10.0 * np.arange(30)
    states = CLASSICAL.exact(CLASSICAL.state(gamma=[0.6, 0.0, 0.8], k=[4.0, 2.8, -1.6]))(times)
    with pytest.raises(gi.DomainError, match="dense=True"):
        CLASSICAL.make_path(times, states)


def test_other_dimensions() -> None:
    four = ch.ChaplyginSphere(a=[0.8, 1.1, 1.3, 1.5], D=4.0)
    assert four.reduced().make_path is None
    contact = four.contact(rho=1.0)
    states = np.array([contact.random_state(seed) for seed in range(3)])
    path = contact.make_path(np.arange(3.0), states)
    assert (path.attitude.shape, path.contact.shape) == ((3, 4, 4), (3, 3))
    flat = ch.ChaplyginSphere(inertia=[1.0], D=2.0).contact(rho=1.0)
    run = {"t_end": 1.0, "step": 0.1, "save_every": 1, "method": "cf-4", "compiled": False}
    with pytest.raises(gi.DomainError, match="n ≥ 3"):
        gi.solve(flat, flat.random_state(1), **run).plot_trace()
    solution = gi.solve(contact, states[0], **run)
    assert solution.plot_trace().axes[0].get_ylabel() == "r[1] (dimensionless)"
