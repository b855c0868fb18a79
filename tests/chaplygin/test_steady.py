"""The steady turns of balls whose operator is a multiple of 1."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin.exact_support import WEIGHTS
from tests.chaplygin.support import seeds


@given(st.integers(2, 6), st.booleans(), seeds)
def test_it_is_the_flow(n, attitude, seed):
    """It begins at the state, and has its velocity everywhere; in τ, which is t, too."""
    ball = ch.ChaplyginSphere.homogeneous(n, 1.3, 2.0).ball(attitude)
    y = ball.random_state(seed)
    motion = ball.exact(y)
    np.testing.assert_allclose(motion(0.0), y, rtol=0.0, atol=4e-15 * np.max(np.abs(y)))
    np.testing.assert_allclose(motion(-0.3), motion.at_tau([-0.3])[0], rtol=0.0, atol=4e-15)
    scale = motion.frequencies[0]
    for t in np.array([0.0, 0.7, -55.0]) / scale:
        rate = WEIGHTS @ motion(t + 0.02 * np.arange(-4, 5) / scale) * 50.0 * scale
        expected = gi.derivative(ball, motion(t))
        np.testing.assert_allclose(rate, expected, rtol=0.0, atol=1e-10 * np.max(np.abs(expected)))
    assert motion.phase_error(0.0) < 1e-14 < motion.phase_error(1e9 / scale) < 1e-5


def test_every_ball_in_the_plane_turns_steadily():
    ball = ch.ChaplyginSphere(a=[0.7, 1.2], D=3.0).ball()
    y = ball.state(gamma=[0.6, 0.8], k=[0.9])
    motion = ball.exact(y)
    far = motion(1e8)
    assert far[0] == pytest.approx(0.9, rel=1e-14)
    assert gi.value(ball, "energy", far) == pytest.approx(gi.value(ball, "energy", y), rel=1e-14)


def test_an_ulp_apart_is_another_operator():
    unequal = ch.ChaplyginSphere(a=[0.9, 0.9, 0.9, np.nextafter(0.9, 1.0)], D=4.0).ball()
    with pytest.raises(gi.FormError, match="no exact flow"):
        unequal.exact(unequal.random_state(0))


def test_what_has_no_phase_is_refused():
    ball = ch.ChaplyginSphere.homogeneous(4, 1.3, 2.0).ball()
    gamma = [0.5, 0.5, 0.5, 0.5]
    with pytest.raises(gi.DomainError, match="frequencies"):
        ball.exact(ball.state(gamma=gamma, k=np.zeros(6)))
    motion = ball.exact(ball.random_state(1))
    assert np.isfinite(motion(motion.longest)).all()
    with pytest.raises(gi.DomainError, match="radian"):
        motion(2.0 * motion.longest)
    with pytest.raises(gi.DomainError, match="finite"):
        motion([0.0, np.nan])


def test_motions_are_equal_by_their_numbers():
    ball = ch.ChaplyginSphere.homogeneous(3, 1.3, 2.0).ball()
    y = ball.random_state(2)
    assert ball.exact(y) == ball.exact(y)
    assert ball.exact(y) != ball.exact(ball.random_state(3))
