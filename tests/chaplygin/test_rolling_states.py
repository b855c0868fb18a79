"""Initial states of the rolling ball, what is refused, and the system that scenes name."""

import numpy as np
import pydantic
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import skew_matrix, triangle_of_vector, upright, wedge
from chaplygin.systems.rolling import ROLLING
from tests.chaplygin.rolling_support import RHO, ball, both, pieces, start
from tests.chaplygin.support import (
    generator_of,
    quiet_state,
    random_diagonal,
    random_full,
    random_rotation,
    random_special,
    random_tangent,
    value_of,
)


def close(x, y, size=1.0):
    np.testing.assert_allclose(x, y, rtol=0, atol=4e-14 * size)


@given(
    n=st.integers(2, 7),
    seed=st.integers(0, 10**6),
    tilt=st.floats(-300.0, 0.0).map(lambda e: 10.0**e) | st.just(0.0),
    sign=st.sampled_from([1.0, -1.0]),
)
def test_upright_is_the_smallest_rotation(n, seed, tilt, sign):
    """Of a γ that makes any angle with ±E_n; its trace is n − 2 + 2 cos(angle)."""
    rng = np.random.default_rng(seed)
    u = np.append(rng.normal(size=n - 1), 0.0)
    gamma = np.sin(tilt) * u / np.sqrt(u @ u) + sign * np.cos(tilt) * np.eye(n)[-1]
    g = upright(gamma)
    np.testing.assert_array_equal(g[-1], gamma)
    np.testing.assert_allclose(g @ g.T, np.eye(n), rtol=0, atol=2e-15)
    np.testing.assert_allclose(g @ gamma, np.eye(n)[-1], rtol=0, atol=2e-15)
    assert np.linalg.det(g) == pytest.approx(1.0, abs=1e-14)
    assert np.trace(g) == pytest.approx(n - 2 + 2 * gamma[-1], abs=4e-15)


@pytest.mark.parametrize("make", [random_special, random_diagonal, random_full])
@pytest.mark.parametrize("n", [2, 3, 5])
def test_all_ways_to_give_a_state_agree(make, n):
    inertia, m, D = ball(make, n)
    reduced = ch.ball_problem(inertia, D)
    gamma, p = random_tangent(n)
    k = wedge(gamma, p)
    omega = -generator_of(reduced, quiet_state(reduced, gamma=gamma, p=p))
    ways = [{"k": k}, {"omega": omega}, {"k": skew_matrix(k, n)}]
    if make is random_special:
        ways.append({"p_tilde": p / (D * np.sqrt(gamma @ (gamma / inertia.a)))})
    for problem in (f(inertia, m, RHO) for f in (ch.rolling_problem, ch.contact_problem)):
        first = quiet_state(problem, gamma=gamma, p=p)
        g = pieces(problem, first)["g"].reshape(n, n)
        for way in ways:
            for where in ({"gamma": gamma}, {"g": g}, {"gamma": gamma, "g": g}):
                close(quiet_state(problem, **where, **way), first, 40)
        physical = problem.physical_state(first)
        close(physical["gamma"], gamma)
        close(physical["k"], k, 40)
        np.testing.assert_array_equal(problem.canonical(first), first)
        assert value_of(problem, "contact-1", first) == 0.0


def test_omega_is_kept_to_the_bit():
    (rolling, _), (y, _) = both(random_full, 4)
    part, expected = pieces(rolling, y), start(4)
    np.testing.assert_array_equal(part["omega"], expected["omega"])
    np.testing.assert_array_equal(part["r"], expected["r"])
    np.testing.assert_array_equal(quiet_state(rolling, **expected, v=part["v"]), y)


def test_a_v_that_slips():
    (rolling, _), (y, _) = both(random_diagonal, 3)
    v = pieces(rolling, y)["v"].copy()
    with pytest.raises(gi.DomainError, match=r"v = .*the contact point slips at 0\.5"):
        rolling.state(**start(3), v=v + np.array([0.3, 0.4]))
    slipping = y.copy()
    slipping[rolling.slices["v"]] += [0.3, 0.4]
    with pytest.raises(gi.DomainError, match=r"slips at 0\.5"):
        rolling.canonical(slipping)
    with pytest.warns(gi.GeomintWarning, match="slips at .*e-09: v projected"):
        found = rolling.state(**start(3), v=v + np.array([1e-9, 0.0]))
    np.testing.assert_array_equal(found, y)


def test_pivoting_on_the_spot_is_rolling():
    """ω fixes γ: the v of rolling is all round-off, which is no reason to refuse v = 0."""
    problem = ch.rolling_problem(random_diagonal(3), 1.0, RHO)
    gamma = np.array([0.48, 0.6, 0.64])
    y = quiet_state(problem, gamma=gamma, omega=triangle_of_vector(3e5 * gamma), v=[0.0, 0.0])
    assert value_of(problem, "pivoting", y) == pytest.approx(3e5, rel=1e-14)
    assert value_of(problem, "speed", y) < 1e-9


GAMMA, OMEGA = {"gamma": [0.6, 0.0, 0.8]}, {"omega": [1.0, 2.0, 3.0]}


@pytest.mark.parametrize("problem", both(random_diagonal, 3)[0], ids=lambda q: q.name)
@pytest.mark.parametrize(
    ("components", "text"),
    [
        (OMEGA, "gamma is missing: expected 3 numbers, or the attitude g"),
        (GAMMA, "exactly one of"),
        (GAMMA | OMEGA | {"k": [1.0, 2.0, 3.0]}, "exactly one of"),
        (GAMMA | OMEGA | {"g": np.eye(3)}, "the last row of g; they differ by 0.6"),
        (OMEGA | {"g": 2 * np.eye(3)}, "a rotation matrix"),
        (OMEGA | {"g": np.diag([1.0, 1.0, -1.0])}, "a rotation matrix"),
        (GAMMA | OMEGA | {"r": [1.0, 2.0, 3.0]}, "r = .*expected 2 numbers"),
        (GAMMA | {"omega": [1.0, 2.0]}, "omega = .*expected 3 numbers"),
        (GAMMA | OMEGA | {"q": 1.0}, "q = 1.0"),
    ],
)
def test_states_refused(problem, components, text):
    with pytest.raises(gi.DomainError, match=text):
        problem.state(**components)


def test_flat_states_are_repaired_or_refused():
    (rolling, contact), (y, z) = both(random_diagonal, 3)
    turned = y.copy()
    turned[:9] *= 1.0 + 1e-8
    with pytest.warns(gi.GeomintWarning):
        repaired = rolling.canonical(turned)
    close(repaired, y, 10)
    assert value_of(rolling, "rolling", repaired) < 1e-14
    leaning = z.copy()
    leaning[contact.slices["gamma"]] = random_rotation(3, 1)[-1]
    with pytest.raises(gi.DomainError, match="the last row of g"):
        contact.canonical(leaning)
    g, gamma = z[contact.slices["g"]].reshape(3, 3), z[contact.slices["gamma"]]
    leaning[contact.slices["gamma"]] = np.cos(1e-8) * gamma + np.sin(1e-8) * g[0]
    with pytest.warns(gi.GeomintWarning, match="gamma differs from the last row of g by"):
        np.testing.assert_array_equal(contact.canonical(leaning), z)


def test_mass_and_radius():
    sphere = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
    for problem in (sphere.rolling(m=1.0), sphere.rolling(rho=2.0), sphere.contact(1.0, 2.0)):
        assert {"m": 1.0, "rho": 2.0, "D": 4.0}.items() <= problem.parameters.items()
    for make in (sphere.rolling, sphere.contact):
        with pytest.raises(gi.DomainError, match="the radius, the mass m, or both"):
            make()
        with pytest.raises(gi.DomainError, match=r"m\*rho\*\*2 = 9.0: expected D = 4.0"):
            make(m=1.0, rho=3.0)
        with pytest.raises(gi.DomainError, match=r"m = -1\.0"):
            make(m=-1.0)
    full = ch.ChaplyginSphere(inertia=random_full(3), D=2.0)
    with pytest.raises(gi.DomainError, match=r"D = 2\.0"):
        full.rolling(m=1.0, rho=1.0)
    with pytest.raises(gi.DomainError, match=r"D = 4\.0"):
        ch.rolling_problem(sphere.inertia, 1.0, 1.0)


# --- the system -----------------------------------------------------------------------------------

MOMENTS = {"moments": [0.4, 0.5, 0.7], "m": 2.0, "rho": 0.5}


def build(parameters, initial):
    return ROLLING.build(ROLLING.parameters(**parameters), ROLLING.initial(**initial))


def test_model_has_every_form_of_the_ball():
    flat = {"inertia": [0.7, 0.5, 0.4], "m": 2.0, "rho": 0.5}
    at = {"gamma": [0.48, 0.6, 0.64], "r": [1.0, 2.0]}
    vectors = build(MOMENTS, at | {"omega": [1.0, -2.0, 1.5]})
    triangles = build(flat, at | {"omega": [-1.5, -2.0, -1.0]})
    own = ["rolling", "contact", "classical", "ball", "classical-attitude", "ball-attitude"]
    assert list(vectors.problems) == own
    assert set(triangles.problems) == set(own)
    for name in own:
        close(vectors.states[name], triangles.states[name])
    found = [q.physical_state(vectors.states[name]) for name, q in vectors.problems.items()]
    for physical in found:
        close(physical["gamma"], found[0]["gamma"])
        close(physical["k"], found[0]["k"])
    for name in ("rolling", "contact"):
        problem, y = vectors.problems[name], vectors.states[name]
        assert value_of(problem, "spatial-momentum", y) < 1e-15
        np.testing.assert_array_equal(pieces(problem, y)["r"], [1.0, 2.0])
    other = build(MOMENTS | {"multipliers": False}, at | {"p": [0.8, 0.0, -0.6]})
    assert list(other.problems)[:2] == ["contact", "rolling"]
    assert {"reduced", "hamiltonized"} <= set(other.problems)


def test_model_from_an_attitude_with_a_velocity():
    g = random_rotation(4).tolist()
    parameters, omega = {"J": [1.0, 2.0, 3.0, 4.0], "D": 1.5}, [1.0, 0.0, -1.0, 0.5, 0.2, 0.3]
    first = build(parameters, {"g": g, "omega": omega})
    v = pieces(first.problems["rolling"], first.states["rolling"])["v"]
    second = build(parameters, {"g": g, "omega": omega, "v": v.tolist()})
    np.testing.assert_array_equal(second.states["rolling"], first.states["rolling"])
    with pytest.raises(gi.DomainError, match="slips at"):
        build(parameters, {"g": g, "omega": omega, "v": [0.0, 0.0, 0.0]})
    with pytest.raises(pydantic.ValidationError):
        build(parameters | {"attitude": True}, {"g": g, "omega": omega})


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "end"), [("rolling-ball-n3", 50.0), ("rolling-ball-n4", 20.0)])
def test_scenes_run(name, end):
    """What is to be kept is kept, and the ball gets somewhere."""
    drift = gi.run_scene(gi.load_scene(name).changed(time={"t_end": end})).drift
    kept = {"K", "momentum", "orthogonality", "spatial-momentum", "rolling", "vertical"}
    for quantity in kept & set(drift):
        assert drift[quantity].max_abs_error < 2e-14, quantity
    assert drift["contact-1"].max_abs_error > 1.0
