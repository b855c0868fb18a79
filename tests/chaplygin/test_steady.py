"""The steady turns of balls whose operator is a multiple of 1, against steps."""

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi


@pytest.mark.parametrize("attitude", [False, True])
@pytest.mark.parametrize("n", [2, 3, 4])
def test_states_are_those_of_steps(n, attitude):
    ball = ch.ChaplyginSphere.homogeneous(n, 1.3, 2.0).ball(attitude)
    times = np.array([0.0, 0.7, 5.0])
    for seed in range(3):
        y = ball.random_state(seed)
        motion = ball.exact(y)
        steps = gi.solve(ball, y, t_end=5.0, step=0.02, method="gauss-8", t_eval=times)
        np.testing.assert_allclose(motion(times), steps.y, rtol=0.0, atol=2e-13)
        np.testing.assert_allclose(motion(-0.3), motion.at_tau([-0.3])[0], rtol=0.0, atol=1e-15)
        scale = motion.frequencies[0]
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
