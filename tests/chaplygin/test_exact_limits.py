"""The exact flow at the limits of what double precision resolves: nearly equal a_i, tiny components,
nearly degenerate tori, times at which the phase means nothing; and that its estimates are honest."""

import dataclasses

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from chaplygin.exact import flow
from tests.chaplygin.exact_support import flow_of, problem_of, turn_of

ULP = float(np.spacing(0.8))
GAPS = (1e-1, 1e-5, 1e-9, 1e-12, 1e-14, ULP, 0.0)


def nearly_equal(gap, group, n):
    a = np.array([0.8, 1.1, 1.4, 0.65, 1.25])[:n]
    a[:group] = 0.8 + gap * np.arange(group)
    return a


@pytest.mark.parametrize(("group", "n"), [(2, 3), (3, 3), (3, 4), (3, 5)])
def test_nearly_equal_parameters(group, n):
    """To rounding at any gap: the start, a flow, and what is there without a gap."""
    for problems in (lambda a: ch.ChaplyginSphere(a, 4.0), lambda a: ch.Veselova(a, 1.3)):
        found = {}
        for gap in GAPS:
            problem = problems(nearly_equal(gap, group, n)).hamiltonized()
            y = problem.random_state(1)
            exact = problem.exact(y)
            np.testing.assert_allclose(exact.at_tau(0.0), y, rtol=0, atol=1e-14)
            found[gap] = exact.at_tau(np.array([1.0, 10.0, -100.0]))
            there = problem.exact(problem.canonical(found[gap][1])).at_tau(-10.0)
            allowed = float(exact.phase_error(20.0))
            assert allowed < 1e-11
            np.testing.assert_allclose(there, y, rtol=0, atol=allowed)
        np.testing.assert_allclose(found[1e-14], found[0.0], rtol=0, atol=1e-10)


def relative(found, y):
    """Return the largest deviation of both halves of a state, relative to their largest entries."""
    pairs = zip(np.split(found, 2), np.split(y, 2), strict=True)
    return max(np.max(np.abs(x - z)) / np.max(np.abs(z)) for x, z in pairs)


@pytest.mark.parametrize(("n", "near"), [(6, 6), (7, 7), (7, 5), (10, 10), (10, 9)])
def test_many_nearly_equal_parameters(n, near):
    """Roots of a polynomial that are all within a gap take digits in proportion to their number."""
    rng = np.random.default_rng(n + near)
    for gap in (1e-3, 1e-7, 1e-11, ULP) if n < 10 else (1e-7, 1e-14):
        a = rng.uniform(0.6, 1.6, n)
        a[:near] = 1.0 + gap * rng.permutation(near)
        for problem in (ch.ChaplyginSphere(a, 4.0).hamiltonized(), ch.Veselova(a, 1.3).reduced()):
            y = problem.random_state(rng)
            exact = problem.exact(y)
            missed = relative(exact.at_tau(0.0), y)
            assert missed < 3e-15
            assert missed < float(exact.phase_error(0.0))
            there = problem.exact(problem.canonical(exact.at_tau(10.0)))
            allowed = float(exact.phase_error(20.0))
            assert allowed < 1e-11
            np.testing.assert_allclose(there.at_tau(-10.0), y, rtol=0, atol=allowed)


def test_a_turn_within_a_nearly_equal_group():
    """ℓ² of the size of the gap: another torus, right or refused with the condition."""
    for size in 10.0 ** np.arange(-1.0, -7.0, -0.5):
        problem = ch.ChaplyginSphere([0.8, 0.8 + 1e-7, 1.5], 4.0).hamiltonized()
        y = flow_of(problem, [0.5, 0.2, 0.6], [0.5 + size, 0.2, -0.3])
        if size < 5e-3:
            with pytest.raises(gi.DomainError, match="condition"):
                problem.exact(y)
            continue
        exact = problem.exact(y)
        np.testing.assert_allclose(exact.at_tau(0.0), y, rtol=0, atol=1e-13)
        middle = problem.canonical(exact.at_tau(7.0))
        allowed = float(exact.phase_error(14.0))
        np.testing.assert_allclose(problem.exact(middle).at_tau(-7.0), y, rtol=0, atol=allowed)


@pytest.mark.parametrize("kind", ["sphere-tau", "body-tau"])
def test_estimates_are_honest(kind):
    """A rounding of the state moves later states by less than the estimate, if not by much less."""
    rng, ratios = np.random.default_rng(4), []
    problem = problem_of("3", kind)
    for seed in range(24):
        small = 10.0 ** -(rng.uniform(0.0, 4.0, 6) * (rng.random(6) < 0.4))
        y = problem.random_state(seed) * small
        y = flow_of(problem, y[:3], y[3:])
        try:
            exact = problem.exact(y)
        except gi.DomainError:
            continue
        times = turn_of(exact) * np.array([3.0, 300.0, 3e5])
        size = np.max(np.abs(y[3:]))
        near = y.copy()
        near[:3] += 2.0**-53 * rng.normal(size=3)
        near[3:] += 2.0**-53 * size * rng.normal(size=3)
        moved = np.abs(problem.exact(problem.canonical(near)).at_tau(times) - exact.at_tau(times))
        off = np.maximum(np.max(moved[:, :3], axis=1), np.max(moved[:, 3:], axis=1) / size)
        ratios.extend(off / exact.phase_error(times))
    assert len(ratios) > 40
    assert max(ratios) < 1.0
    assert np.median(ratios) > 1e-3


def test_digits_that_are_lost_are_part_of_the_estimate(monkeypatch):
    """However it comes that a torus misses its start: the error of later states is not below that."""
    problem, right = problem_of("6", "sphere-tau"), flow.torus_of
    y = problem.random_state(1)
    own = float(problem.exact(y).phase_error(1.0))

    def spoilt(*given):
        torus = right(*given)
        return dataclasses.replace(torus, lead=torus.lead * (1.0 + 1e-13))

    monkeypatch.setattr(flow, "torus_of", spoilt)
    exact = problem.exact(y)
    missed = relative(exact.at_tau(0.0), y)
    assert 1e-14 < missed < float(exact.phase_error(0.0)) < 4.0 * missed
    assert float(exact.phase_error(1.0)) > 5.0 * own


FORMS = {
    "sphere-tau": lambda a: ch.ChaplyginSphere(a, 4.0).hamiltonized(),
    "sphere-t": lambda a: ch.ChaplyginSphere(a, 4.0).reduced(),
    "body-tau": lambda a: ch.Veselova(a, 1.3).hamiltonized(),
    "body-t": lambda a: ch.Veselova(a, 1.3).reduced(),
    "rubber": lambda a: ch.RubberSphere.from_a(0.5 * a, 0.3).hamiltonized(),
    "ball": lambda a: ch.ChaplyginSphere(inertia=a, D=1.0).classical(),
    "body-0": lambda a: ch.Veselova(a, 1.3).classical(0.0),
    "body-1": lambda a: ch.Veselova(a, 1.3).classical(0.4),
}


@pytest.mark.parametrize("form", FORMS)
def test_states_that_are_off_by_roundings(form):
    """What `canonical` leaves as it is: |γ| and the constraint off by ε, the start missed by that."""
    problem = FORMS[form](np.array([0.8, 1.1, 1.5]))
    vertical = slice(3, 6) if problem.pieces[0][0] == "k" else slice(0, 3)
    other = slice(3 - vertical.start, 6 - vertical.start)
    for seed in range(4):
        for off in (1e-15, -1e-14, 4e-14):
            y = problem.random_state(seed)
            if vertical.start and np.linalg.norm(np.cross(y[:3], y[3:])) < 0.15:
                continue
            y[vertical] *= 1.0 + off
            if form != "ball":
                y[other] += 0.9 * off * np.linalg.norm(y[other]) * y[vertical]
            assert np.array_equal(problem.canonical(y), y)
            exact = problem.exact(y)
            missed = relative(exact.at_tau(0.0), y)
            assert missed < 2.0 * abs(off) + 3e-15
            assert missed < float(exact.phase_error(0.0))


def test_balls_that_start_where_others_have_come_to():
    """Restarts, whose |γ| is 1 up to some roundings, at any angle of k and γ."""
    worst = 0.0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        ball = ch.ChaplyginSphere(inertia=rng.uniform(0.6, 1.6, 3), D=rng.uniform(0.2, 2.0))
        problem = ball.classical()
        y = problem.random_state(seed)
        if np.linalg.norm(np.cross(y[:3], y[3:])) < 0.03 * np.linalg.norm(y[:3]):
            continue
        there = problem.canonical(problem.exact(y).at_tau(7.3))
        exact = problem.exact(there)
        missed = relative(exact.at_tau(0.0), there)
        assert missed < float(exact.phase_error(0.0))
        worst = max(worst, missed)
    assert worst < 1e-14


def test_times_without_a_phase_are_refused():
    problem = problem_of("3", "sphere-tau")
    exact = problem.exact(problem.random_state(1))
    assert float(exact.phase_error(exact.longest)) == pytest.approx(1.0)
    assert 0.0 < float(exact.time_error(3.0)) < 1e-13
    assert np.isfinite(exact.at_tau(-0.99 * exact.longest)).all()
    assert np.isfinite(exact(0.99 * exact.longest * exact.clock.mean)).all()
    integral = exact.quadrature(lambda phi: np.cos(phi[:, 0]))
    for call, name in ((exact.at_tau, "tau"), (exact.time, "tau"), (integral, "tau"),
                       (exact, "t"), (exact.tau, "t")):  # fmt: skip
        for far in (1e300, [0.0, -1e17]):
            with pytest.raises(gi.DomainError, match=rf"\|{name}\| up to .*e\+1") as caught:
                call(far)
            assert caught.value.name == name
    ball = ch.ChaplyginSphere(inertia=problem.parameters["a"], D=1.0).classical()
    with pytest.raises(gi.DomainError, match="radian"):
        ball.exact(ball.random_state(1))(1e300)


@pytest.mark.nightly
def test_clocks_whose_series_do_not_decay_are_refused():
    """Of a ball next to a separatrix; states at any τ are right nonetheless."""
    ball = ch.ChaplyginSphere(inertia=[0.7, 1.0, 1.6], D=1.0).classical()
    gamma = np.array([-0.0013, 0.0012, 1.0])
    exact = ball.exact(ball.state(k=[0.0018, 0.45, -0.0005], gamma=gamma / np.linalg.norm(gamma)))
    with pytest.raises(gi.DomainError, match="Fourier series that decays"):
        exact.time(1.0)


def test_a_series_with_gaps():
    """Nearly equal a_i: coefficients that matter beyond others that do not."""
    a = [0.91464134, 0.91464134 + 4.6e-7, 0.91464134 + 1.08e-6, 1.2313585]
    problem = ch.ChaplyginSphere(a, 4.0).hamiltonized()
    assert max(problem.exact(problem.random_state(s)).clock.edge for s in range(4)) < 1e-13


@pytest.mark.parametrize("n", [2, 3, 5])
def test_states_of_any_size(n):
    """Unequal sizes of everything: the torus goes through its start, or there is none."""
    rng, found = np.random.default_rng(n), 0
    for count in range(30):
        a = 10.0 ** rng.uniform(-6, 6, n) if count % 2 else rng.uniform(0.6, 1.6, n)
        gamma, p = rng.normal(size=(2, n)) * 10.0 ** -(
            rng.choice([0, 0, 1, 9, 17, 160, 300], (2, n))
        )
        gamma[rng.integers(n)], p[rng.integers(n)] = 1.0, 1.0
        problem = ch.Veselova(a, 1.3).hamiltonized()
        y = flow_of(problem, gamma, p - (gamma @ p) / (gamma @ gamma) * gamma)
        y[n:] *= 10.0 ** rng.choice([-290, 0, 250])
        if not np.any(y[n:]):
            continue
        try:
            exact = problem.exact(y)
        except gi.DomainError:
            continue
        z, found = exact.at_tau(0.0), found + 1
        np.testing.assert_allclose(z[:n], y[:n], rtol=0, atol=1e-12)
        np.testing.assert_allclose(z[n:], y[n:], rtol=0, atol=1e-12 * np.max(np.abs(y[n:])))
    assert found > 10


def test_balls_of_any_momentum():
    ball = ch.ChaplyginSphere(inertia=[0.7, 1.0, 1.6], D=1.0).classical()
    body = ch.Veselova([0.8, 1.1, 1.5], 1.3).classical(0.0)
    gamma = np.array([0.48, 0.6, 0.64])
    for unit in (1e-290, 1e-100, 1.0, 1e100):
        for problem, k in ((ball, [0.3, -0.4, 0.5]), (body, np.cross(gamma, [0.3, -0.4, 0.5]))):
            y = np.r_[unit * np.array(k), gamma]
            z = problem.exact(y).at_tau(0.0)
            np.testing.assert_allclose(z[:3] / unit, y[:3] / unit, rtol=0, atol=1e-12)
            np.testing.assert_allclose(z[3:], gamma, rtol=0, atol=1e-12)


def assert_integrated(problem, y, t, step=0.02):
    exact = problem.exact(y)
    run = gi.solve(problem, y, t_end=t, step=step, method="dop853", progress=False)
    tau = exact.tau(t)
    allowed = float(exact.phase_error(tau) + exact.time_error(tau)) + 1e-14
    assert relative(exact(t), run.y[-1]) < allowed


@pytest.mark.parametrize("form", ["ball", pytest.param("body", marks=pytest.mark.nightly)])
def test_nearly_parallel_vectors_against_integration(form):
    """The start to rounding over the angle, and no error beyond the estimate."""
    for seed, angle in enumerate((0.1, 1e-3)):
        rng = np.random.default_rng(seed)
        inertia = rng.uniform(0.6, 1.6, 3)
        gamma, across = np.linalg.qr(rng.normal(size=(3, 2)))[0].T
        if form == "ball":
            problem = ch.ChaplyginSphere(inertia=inertia, D=1.0).classical()
        else:
            problem = ch.Veselova(inertia, 1.3).classical(1.0)
        y = np.r_[gamma + angle * across, gamma]
        exact = problem.exact(y)
        assert relative(exact.at_tau(0.0), y) < 3e-15 / angle
        assert_integrated(problem, y, 2.0)


@pytest.mark.parametrize("f1", [0.0, 0.3, 3.0])
def test_nearly_equal_moments_of_the_body(f1):
    """Two flows on its torus are nearly one, and which it is hardly matters then."""
    for gap in (1e-2, 1e-6, 1e-10, 1e-12, 1e-14, ULP, 0.0):
        problem = ch.Veselova(1.0 + gap * np.arange(3), 1.0).classical(f1)
        y = problem.random_state(1)
        exact = problem.exact(y)
        assert exact.condition < 300.0
        assert exact.longest > 1e12
        assert_integrated(problem, y, 3.0)


def test_large_constants():
    """f₁ ≫ |k⃗|: right up to the estimate, or refused."""
    for f1 in (10.0, 100.0, 1e4):
        problem = ch.Veselova([0.8, 1.1, 1.5], 4.0).classical(f1)
        y = problem.random_state(3)
        if f1 > 1e3:
            with pytest.raises(gi.DomainError):
                problem.exact(y)
            continue
        turn = 1.0 / np.max(np.abs(problem.exact(y).mean_frequencies))
        assert_integrated(problem, y, 30 * turn, 0.02 * turn)


def test_a_torus_that_misses_its_state_is_refused(monkeypatch):
    problem = problem_of("3", "sphere-tau")
    y = problem.random_state(1)
    right = flow.component_signs
    monkeypatch.setattr(flow, "component_signs", lambda *given: -right(*given))
    with pytest.raises(gi.DomainError, match="misses the state by"):
        problem.exact(y)
