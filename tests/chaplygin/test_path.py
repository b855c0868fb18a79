"""Attitude and contact point for pictures: all representations tell the same, and what is exact."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi

BALL = ch.ChaplyginSphere.from_moments([1.0, 1.7, 2.4], m=1.0, rho=1.0)
TIMES = np.linspace(0.0, 12.0, 601)
MAKERS = {
    "contact": lambda: BALL.contact(rho=1.0),
    "rolling": lambda: BALL.rolling(rho=1.0),
    "classical": BALL.classical,
    "classical-attitude": lambda: BALL.classical(attitude=True),
    "ball": BALL.ball,
    "ball-attitude": lambda: BALL.ball(attitude=True),
    "on-group": BALL.on_group,
    "poisson": BALL.poisson,
    "reduced": BALL.reduced,
    "hamiltonized": BALL.hamiltonized,
}
FIRST = BALL.reduced().state(gamma=[0.36, 0.48, 0.8], p=[0.8, -0.6, 0.0])
RESTING = BALL.reduced().state(gamma=[0.0, 0.0, 1.0], p=[0.0, 0.0, 0.0])


def truth(y0: Any) -> Any:
    """By the exact flow, which shares nothing with paths."""
    classical = BALL.classical()
    exact = classical.exact(ch.converted(y0, BALL.reduced(), classical))
    path = ch.ContactPath(exact, 1.0)
    return path.attitude(TIMES), path.contact(TIMES)


def path_of(name: str, y0: Any) -> gi.BodyPath:
    problem = MAKERS[name]()
    state = ch.converted(y0, BALL.reduced(), problem)
    if "g" in problem.slices:
        upright = BALL.contact(rho=1.0)
        g = ch.converted(y0, BALL.reduced(), upright)[upright.slices["g"]]
        state[problem.slices["g"]] = g
    solution = gi.solve(problem, state, t_end=12.0, t_eval=TIMES, method="gauss-6", step=0.1)
    assert problem.make_path is not None
    return problem.make_path(TIMES, solution.y)


@pytest.mark.parametrize("name", MAKERS)
def test_every_representation_tells_the_same(name: str) -> None:
    path = path_of(name, FIRST)
    attitude, contact = truth(FIRST)
    np.testing.assert_allclose(path.attitude, attitude, atol=1e-7)
    assert path.contact is not None
    np.testing.assert_allclose(path.contact, contact, atol=1e-7)
    own = "m" if "rho" in MAKERS[name]().parameters else "radii"
    assert path.unit == ("dimensionless" if own == "m" else "radii")


@pytest.mark.parametrize("name", MAKERS)
def test_a_ball_at_rest_stays(name: str) -> None:
    path = path_of(name, RESTING)
    assert path.contact is not None
    assert np.all(path.contact == 0.0)
    np.testing.assert_allclose(path.attitude, path.attitude[:1].repeat(len(TIMES), axis=0))


def test_samples_that_are_too_far_apart_are_refused() -> None:
    problem = BALL.classical()
    y0 = 4.0 * problem.state(gamma=[0.6, 0.0, 0.8], k=[1.0, 0.7, -0.4])
    y0[3:] /= 4.0
    solution = gi.solve(problem, y0, t_end=300.0, method="gauss-6", step=0.1, save_every=100)
    with pytest.raises(gi.DomainError, match="dense=True"):
        solution.plot_trace()


def test_other_dimensions() -> None:
    four = ch.ChaplyginSphere(a=[0.8, 1.1, 1.3, 1.5], D=4.0)
    assert four.reduced().make_path is None
    contact = four.contact(rho=1.0)
    assert contact.make_path is not None
    states = np.array([contact.random_state(seed) for seed in range(3)])
    path = contact.make_path(np.arange(3.0), states)
    assert path.attitude.shape == (3, 4, 4)
    assert path.contact is not None
    assert path.contact.shape == (3, 3)
    flat = ch.ChaplyginSphere(inertia=[1.0], D=2.0).contact(rho=1.0)
    solution = gi.solve(flat, flat.random_state(1), t_end=2.0, step=0.1, dense=True)
    with pytest.raises(gi.DomainError, match="n ≥ 3"):
        solution.plot_trace()
    solution = gi.solve(contact, states[0], t_end=2.0, step=0.1, dense=True)
    assert solution.plot_trace().axes[0].get_ylabel() == "r₂ (dimensionless)"
