"""States: what is accepted as it is, what is projected with a warning, what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin import support
from tests.chaplygin.support import close, dimensions, kinds, seeds
from tests.paper.algebra import skew
from tests.rows import examples

SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
ON_SPHERE = (SPHERE.reduced(), SPHERE.hamiltonized())
GEODESICS = ch.ellipsoid_problem([1.0, 4.0, 9.0])
RHO = 0.7


def of_plane(make, n, seed=0):
    """Return the rolling ball in both forms, an attitude with velocities, and its states."""
    inertia = make(n, seed)
    m = getattr(inertia, "D", 1.3) / RHO**2
    given = {
        "g": support.random_rotation(n, seed),
        "r": np.arange(1.0, n),
        "omega": support.random_triangle(n, seed),
    }
    problems = ch.rolling_problem(inertia, m, RHO), ch.contact_problem(inertia, m, RHO)
    return problems, given, [support.quiet_state(problem, **given) for problem in problems]


ROLLING, CONTACT = of_plane(support.random_diagonal, 3)[0]


# --- all ways to give one -------------------------------------------------------------------------


@given(dimensions, kinds, seeds)
def test_all_momenta_name_the_same_state(n, kind, seed):
    """k, ω, p and p̃ at zero momentum, as triangles, matrices and vectors; γ or an attitude."""
    inertia, D = support.operator_of(kind, n, seed)
    (gamma, p), m = support.random_tangent(n, seed), D / RHO**2
    ball, k = ch.ball_problem(inertia, D), support.flat_wedge(gamma, p)
    omega = -support.generator_of(ball, support.quiet_state(ball, gamma=gamma, k=k))
    ways = [{"p": p}, {"k": k}, {"omega": omega}, {"k": skew(k, n)}, {"omega": skew(omega, n)}]
    problems = [ch.reduced_problem(inertia, D), ball, ch.ball_problem(inertia, D, True)]
    flat = [make(inertia, m, RHO) for make in (ch.rolling_problem, ch.contact_problem)]
    if kind == "special":
        ways.append({"p_tilde": p / (D * np.sqrt(gamma @ (gamma / inertia.a)))})
        problems.append(ch.hamiltonized_problem(inertia))
    body = support.random_body(n, seed)
    u = gamma @ (gamma / body.a)
    own = {"p": p, "p_tilde": p / (body.D * np.sqrt(u)), "k": k}
    own["w"] = support.flat_wedge(gamma, body.a * p) / u
    for problem in (body.reduced(), body.hamiltonized(), *([body.classical()] if n == 3 else [])):
        for name, value in own.items():
            full = skew(value, n) if name in ("k", "w") else value
            y = support.quiet_state(problem, gamma=gamma, **{name: full})
            np.testing.assert_allclose(problem.physical_state(y)["k"], k, rtol=0, atol=1e-12)
    for problem in [*problems, *flat]:
        for way in ways:
            y = support.quiet_state(problem, gamma=gamma, **way)
            physical = problem.physical_state(y)
            np.testing.assert_allclose(physical["k"], k, rtol=0, atol=1e-12)
            close(physical["gamma"], gamma)
    for problem in flat:
        y = support.quiet_state(problem, gamma=gamma, p=p)
        g = support.pieces(problem, y)["g"].reshape(n, n)
        close(support.quiet_state(problem, g=g, p=p), y)
        close(support.quiet_state(problem, gamma=gamma, g=g, p=p), y)
        np.testing.assert_array_equal(problem.canonical(y), y)
        assert support.value_of(problem, "contact-1", y) == 0.0
    if n == 3:
        vectors = {"k": np.cross(p, gamma), "omega": [omega[2] * -1, omega[1], -omega[0]]}
        for name, vector in vectors.items():
            problem = ch.classical_problem(inertia, D)
            y = support.quiet_state(problem, gamma=gamma, **{name: vector})
            np.testing.assert_allclose(problem.physical_state(y)["k"], k, rtol=0, atol=1e-12)


@given(dimensions, kinds, seeds)
def test_omega_is_kept_to_the_bit(n, kind, seed):
    (rolling, contact), given, (y, z) = of_plane(
        lambda n, seed: support.operator_of(kind, n, seed)[0], n, seed
    )
    part = support.pieces(rolling, y)
    np.testing.assert_array_equal(part["omega"], given["omega"])
    np.testing.assert_array_equal(part["r"], given["r"])
    np.testing.assert_array_equal(support.quiet_state(rolling, **given, v=part["v"]), y)
    omega = -support.generator_of(contact, z)[: len(given["omega"])]
    close(omega, given["omega"], 100 * max(1.0, np.max(np.abs(given["omega"]))))


@given(
    n=st.integers(2, 7),
    seed=seeds,
    tilt=st.floats(-300.0, 0.0).map(lambda e: 10.0**e) | st.just(0.0),
    sign=st.sampled_from([1.0, -1.0]),
)
def test_an_attitude_is_the_smallest_rotation(n, seed, tilt, sign):
    """Of a γ that makes any angle with ±E_n; its trace is n − 2 + 2 cos(angle)."""
    u = np.append(np.random.default_rng(seed).normal(size=n - 1), 0.0)
    gamma = np.sin(tilt) * u / np.sqrt(u @ u) + sign * np.cos(tilt) * np.eye(n)[-1]
    gamma /= np.sqrt(gamma @ gamma)
    contact = ch.ChaplyginSphere.homogeneous(n, 1.0, 2.0).contact(rho=1.0)
    y = contact.state(gamma=gamma, k=np.zeros(n * (n - 1) // 2))
    g = support.pieces(contact, y)["g"].reshape(n, n)
    np.testing.assert_array_equal(g[-1], support.pieces(contact, y)["gamma"])
    close(g @ g.T, np.eye(n))
    close(g @ gamma, np.eye(n)[-1])
    assert np.linalg.det(g) == pytest.approx(1.0, abs=1e-14)
    assert np.trace(g) == pytest.approx(n - 2 + 2 * gamma[-1], abs=4e-15)


# --- what is projected ----------------------------------------------------------------------------


@pytest.mark.parametrize("problem", ON_SPHERE, ids=lambda p: p.name)
def test_projection_is_announced_with_its_size(problem):
    with pytest.warns(gi.GeomintWarning) as caught:
        y = problem.state(gamma=[1, 2, 3], p=[1.8, -3.0, 1.2])
    texts = [str(w.message) for w in caught]
    assert any("3.74165738677394" in text for text in texts)
    assert any("(gamma, p)/|p| is 0.0434" in text for text in texts)
    assert {w.filename for w in caught} == {__file__}
    gamma, p = np.array([1, 2, 3]) / np.sqrt(14), np.array([1.8, -3.0, 1.2])
    p = p - (gamma @ p) * gamma
    close(problem.physical_state(y)["gamma"], gamma)
    close(problem.physical_state(y)["k"], support.flat_wedge(gamma, p))
    gamma, p = support.random_tangent(3)
    for defect in (1e-12, 1e-9, 1e-4):  # what is named is projected from round-off on
        with pytest.warns(gi.GeomintWarning, match=r"\|p\| is "):
            y = problem.state(gamma=gamma, p=p + defect * np.linalg.norm(p) * gamma)
        close([y[:3] @ y[3:], y[:3] @ y[:3]], [0.0, 1.0])
        with pytest.warns(gi.GeomintWarning, match="length"):
            y = problem.state(gamma=(1 + defect) * gamma, p=p)
        assert abs(y[:3] @ y[:3] - 1.0) < 1e-15


@given(
    st.lists(st.floats(-1, 1), min_size=3, max_size=3),
    st.lists(st.floats(-1, 1), min_size=3, max_size=3),
    st.integers(-150, 150),
    st.integers(-75, 75),
)
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_any_direction_and_any_scale(gamma, p, size, scale):
    direction, momentum = np.array(gamma), np.array(p)
    assume(np.linalg.norm(direction) > 0.1)
    assume(np.linalg.norm(momentum) > 0.1)
    assume(np.linalg.norm(np.cross(direction, momentum)) > 0.1)
    for problem in ON_SPHERE:
        y = problem.state(gamma=direction * 10.0**size, p=momentum * 10.0**scale)
        again, q = y[:3], y[3:] / np.max(np.abs(y[3:]))
        assert abs(again @ again - 1.0) < 2e-13
        assert abs(again @ q) < 2e-13
        expected = support.flat_wedge(direction, momentum) / np.linalg.norm(direction)
        got = problem.physical_state(y)["k"] / 10.0**scale
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=2e-13)
        np.testing.assert_array_equal(problem.canonical(y), y)


@given(
    st.lists(st.one_of(st.floats(), st.sampled_from([None, "", "a", "1"])), max_size=5),
    st.lists(st.one_of(st.floats(), st.integers()), max_size=5),
)
@examples(20)
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_anything_else_is_an_error_with_a_name(gamma, p):
    """A state is finite and admissible, or there is a DomainError."""
    for problem in (*ON_SPHERE, SPHERE.ball(), SPHERE.classical()):
        try:
            y = problem.state(gamma=gamma, p=p)
        except gi.DomainError as error:
            refused = error.name
        else:
            refused = ""
            assert np.isfinite(y).all()
            assert abs(support.value_of(problem, "norm", y)) < 1e-13
        assert refused in ("", "gamma", "p", "state")


@pytest.mark.parametrize("problem", ON_SPHERE, ids=lambda p: p.name)
@pytest.mark.parametrize(
    ("defect", "scale"), [("norm", 1.0), ("tangency", 1.0), ("tangency", 1e-75), ("tangency", 1e75)]
)
def test_flat_states(problem, defect, scale):
    """|γ|² − 1 or (γ, p)/|p|: left as it is, repaired with a warning, or refused."""

    def flat(size):
        gamma, p = support.random_tangent(3)
        y = support.quiet_state(problem, gamma=gamma, p=p)
        if defect == "tangency":
            y[3:] += size * np.linalg.norm(y[3:]) * y[:3]
        else:
            y[:3] *= 1.0 + 0.5 * size
        y[3:] *= scale
        return y

    np.testing.assert_array_equal(problem.canonical(flat(5e-14)), flat(5e-14))
    with pytest.warns(gi.GeomintWarning, match="3e-07"):
        y = problem.canonical(flat(3e-7))
    close([y[:3] @ y[:3], y[:3] @ y[3:] / scale], [1.0, 0.0])
    scales = np.repeat([1.0, scale], 3)
    np.testing.assert_allclose(y / scales, flat(3e-7) / scales, atol=1e-6)
    with pytest.raises(gi.DomainError, match=r"0\.001") as caught:
        problem.canonical(flat(1e-3))
    assert caught.value.name == ("gamma" if defect == "norm" else problem.pieces[1][0])


def test_momentum_near_zero_is_projected():
    gamma, p = support.random_tangent(4)
    sphere = ch.ChaplyginSphere(inertia=support.random_special(4))
    k, other = support.flat_wedge(gamma, p), support.flat_wedge(*support.random_tangent(4, 9))
    with pytest.warns(gi.GeomintWarning, match="pr k"):
        sphere.reduced().state(gamma=gamma, k=k + 1e-9 * other)
    with pytest.raises(gi.DomainError, match="zero SO"):
        sphere.reduced().state(gamma=gamma, k=k + 1e-3 * other)


def test_rest_is_a_state():
    for problem in ON_SPHERE:
        y = problem.state(gamma=[0.0, 0.0, 1.0], p=[0.0, 0.0, 0.0])
        np.testing.assert_array_equal(y, [0, 0, 1, 0, 0, 0])
        np.testing.assert_array_equal(gi.derivative(problem, y), np.zeros(6))
    SPHERE.reduced().state(gamma=[0.0, 0.0, 1.0], k=[0.0, 0.0, 0.0])
    still = ch.Veselova.from_moments([2.0, 3.0, 4.0]).classical()
    np.testing.assert_array_equal(still.state(gamma=[0.0, 0.6, 0.8], w=np.zeros(3))[:3], 0.0)


@pytest.mark.parametrize(
    "problem", [SPHERE.ball(True), SPHERE.classical(True)], ids=lambda p: p.name
)
def test_attitudes(problem):
    given, g = (
        {"gamma": support.random_direction(3), "k": [1.0, 2.0, 3.0]},
        support.random_rotation(3),
    )
    assert "spatial-momentum" not in problem.diagnostics  # without a k_0
    np.testing.assert_array_equal(
        support.quiet_state(problem, **given)[6:].reshape(3, 3), np.eye(3)
    )
    np.testing.assert_array_equal(support.quiet_state(problem, **given, g=g)[6:].reshape(3, 3), g)
    for bad in (-g, 1.1 * g):
        with pytest.raises(gi.DomainError, match="rotation"):
            problem.state(**given, g=bad)
    with pytest.warns(gi.GeomintWarning, match="gᵀg"):
        y = problem.state(**given, g=(1 + 1e-8) * g)
    close(y[6:].reshape(3, 3) @ y[6:].reshape(3, 3).T, np.eye(3))


# --- balls on the plane ---------------------------------------------------------------------------


def test_a_v_that_slips():
    (rolling, _), given, (y, _) = of_plane(support.random_diagonal, 3)
    v = support.pieces(rolling, y)["v"].copy()
    with pytest.raises(gi.DomainError, match=r"v = .*the contact point slips at 0\.5"):
        rolling.state(**given, v=v + np.array([0.3, 0.4]))
    slipping = y.copy()
    slipping[rolling.slices["v"]] += [0.3, 0.4]
    with pytest.raises(gi.DomainError, match=r"slips at 0\.5"):
        rolling.canonical(slipping)
    with pytest.warns(gi.GeomintWarning, match="slips at .*e-09: v projected"):
        found = rolling.state(**given, v=v + np.array([1e-9, 0.0]))
    np.testing.assert_array_equal(found, y)


def test_pivoting_on_the_spot_is_rolling():
    """ω fixes γ: the v of rolling is all round-off, which is no reason to refuse v = 0."""
    gamma = np.array([0.48, 0.6, 0.64])
    y = support.quiet_state(
        ROLLING, gamma=gamma, omega=support.triangle_of(3e5 * gamma), v=[0.0, 0.0]
    )
    assert support.value_of(ROLLING, "pivoting", y) == pytest.approx(3e5, rel=1e-14)
    assert support.value_of(ROLLING, "speed", y) < 1e-9


def test_flat_states_on_the_plane():
    (rolling, contact), _, (y, z) = of_plane(support.random_diagonal, 3)
    turned = y.copy()
    turned[:9] *= 1.0 + 1e-8
    with pytest.warns(gi.GeomintWarning):
        repaired = rolling.canonical(turned)
    close(repaired, y, 10)
    assert support.value_of(rolling, "rolling", repaired) < 1e-14
    leaning, where = z.copy(), contact.slices["gamma"]
    leaning[where] = support.random_rotation(3, 1)[-1]
    with pytest.raises(gi.DomainError, match="the last row of g"):
        contact.canonical(leaning)
    g, gamma = z[contact.slices["g"]].reshape(3, 3), z[where]
    leaning[where] = np.cos(1e-8) * gamma + np.sin(1e-8) * g[0]
    with pytest.warns(gi.GeomintWarning, match="gamma differs from the last row of g by"):
        np.testing.assert_array_equal(contact.canonical(leaning), z)


def test_mass_and_radius():
    for problem in (SPHERE.rolling(m=1.0), SPHERE.rolling(rho=2.0), SPHERE.contact(1.0, 2.0)):
        assert {"m": 1.0, "rho": 2.0, "D": 4.0}.items() <= problem.parameters.items()
    full = ch.ChaplyginSphere(inertia=support.random_full(3), D=2.0)
    for make, text in (
        (lambda: SPHERE.rolling(), "the radius, the mass m, or both"),
        (lambda: SPHERE.contact(m=1.0, rho=3.0), r"m\*rho\*\*2 = 9.0: expected D = 4.0"),
        (lambda: SPHERE.contact(m=-1.0), r"m = -1\.0"),
        (lambda: full.rolling(m=1.0, rho=1.0), r"D = 2\.0"),
        (lambda: ch.rolling_problem(SPHERE.inertia, 1.0, 1.0), r"D = 4\.0"),
    ):
        with pytest.raises(gi.DomainError, match=text):
            make()


# --- levels, geodesics ----------------------------------------------------------------------------


def test_the_level_is_a_part_of_the_state():
    problem = ch.Veselova.from_moments([2.0, 3.0, 5.0]).classical(0.5)
    gamma = np.array([0.0, 0.6, 0.8])
    with pytest.warns(gi.GeomintWarning, match=r"\(w, gamma\) is 1.4, not f1 = 0.5"):
        y = problem.state(gamma=gamma, w=[1.0, 1.0, 1.0])
    assert support.value_of(problem, "constraint", y) == pytest.approx(0.0, abs=1e-15)
    with pytest.warns(gi.GeomintWarning, match=r"\(k, gamma\)"):
        y = problem.state(gamma=gamma, k=[1.0, 1.0, 1.0])
    close(y[:3], np.array([1.0, 1.0, 1.0]) - 0.9 * gamma)
    close(problem.state(gamma=gamma, k=0.5 * gamma)[:3], 0.5 * gamma)  # turns about γ
    close(problem.state(gamma=gamma, p=[1.0, 0.0, 0.0])[:3], [0.0, -0.5, 1.0])
    with pytest.raises(gi.DomainError, match=r"f1 = 0\.5"):
        problem.canonical(y + np.array([1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]))
    with pytest.warns(gi.GeomintWarning, match="of the state"):
        repaired = problem.canonical(y + np.array([0.0, 0.0, 1e-8, 0.0, 0.0, 0.0]))
    assert abs(support.value_of(problem, "constraint", repaired)) < 1e-15


def test_states_on_the_ellipsoid():
    with pytest.warns(gi.GeomintWarning, match=r"√\(x, x/a\) is 0.5, not 1"):
        y = GEODESICS.state(x=[0.0, 1.0, 0.0], p=[1.0, 0.0, 2.0])
    np.testing.assert_allclose(y, [0, 2, 0, 1, 0, 2])
    with pytest.warns(gi.GeomintWarning, match=r"\(normal, p\)/\|p\|"):
        y = GEODESICS.state(x=[0.0, 2.0, 0.0], p=[1.0, 0.5, 2.0])
    np.testing.assert_allclose(y, [0, 2, 0, 1, 0, 2])
    for scale in (1e-140, 1e140):
        with pytest.warns(gi.GeomintWarning):
            far = GEODESICS.state(x=scale * np.array([1.0, 1.0, 1.0]), p=[0.0, 0.0, 0.0])
        assert abs(support.value_of(GEODESICS, "ellipsoid", far)) < 1e-15
    np.testing.assert_array_equal(GEODESICS.canonical(y), y)
    with pytest.warns(gi.GeomintWarning, match="of the state"):
        repaired = GEODESICS.canonical(y * (1 + 1e-8))
    assert abs(support.value_of(GEODESICS, "ellipsoid", repaired)) < 1e-15
    for bad in (y * 1.001, y + np.array([0, 0, 0, 0, 0.01, 0])):
        with pytest.raises(gi.DomainError):
            GEODESICS.canonical(bad)


# --- what is refused ------------------------------------------------------------------------------

G, P, NAN = {"gamma": [0, 0, 1]}, {"p": [1, 0, 0]}, float("nan")
BODY = ch.Veselova([1.0, 2.0, 3.0])
LEANING, TURNING = {"gamma": [0.6, 0.0, 0.8]}, {"omega": [1.0, 2.0, 3.0]}
REFUSED = {
    ON_SPHERE: [
        ({"gamma": [0, 0, 0]} | P, "not zero"),
        ({"gamma": [0, 0, NAN]} | P, "gamma = .*finite"),
        ({"gamma": [0, 1]} | P, "gamma = .*3 numbers"),
        (G | {"p": [1, 0]}, "p = .*3 numbers"),
        (G | {"p": [1, 0, float("inf")]}, "p = .*finite"),
        (G | {"p": [0, 0, 2]}, "not parallel"),
        (G | {"p": [0, 1e-12, 2]}, "not parallel"),
        (G, "exactly one of"),
        (P, "gamma = None"),
        (G | P | {"k": [1, 0, 0]}, "exactly one of"),
        (G | {"k": [1, 0, 0]}, "zero SO"),
        (G | {"k": np.eye(3)}, "skew-symmetric"),
    ],
    (*ON_SPHERE, SPHERE.ball(), SPHERE.classical(), BODY.classical()): [(G | P | {"q": 1}, "q = ")],
    (SPHERE.ball(),): [(G | {"k": [1, 0, 0], "g": np.eye(3)}, "attitude=False")],
    (ROLLING, CONTACT): [
        (TURNING, "gamma is missing: expected 3 numbers, or the attitude g"),
        (LEANING, "exactly one of"),
        (LEANING | TURNING | {"k": [1.0, 2.0, 3.0]}, "exactly one of"),
        (LEANING | TURNING | {"g": np.eye(3)}, "the last row of g; they differ by 0.6"),
        (TURNING | {"g": 2 * np.eye(3)}, "a rotation matrix"),
        (TURNING | {"g": np.diag([1.0, 1.0, -1.0])}, "a rotation matrix"),
        (LEANING | TURNING | {"r": [1.0, 2.0, 3.0]}, "r = .*expected 2 numbers"),
        (LEANING | {"omega": [1.0, 2.0]}, "omega = .*expected 3 numbers"),
    ],
    (BODY.reduced(),): [
        (G, "exactly one of"),
        (G | {"omega": [1.0]}, "omega"),
        ({"gamma": [1, 0, 0], "w": [0, 0, 1]}, "velocity"),
    ],
    (GEODESICS,): [
        ({"x": [0.0, 0.0, 0.0], "p": [1.0, 0.0, 0.0]}, "not zero"),
        ({"x": [1.0, 0.0, 0.0], "p": [1.0, 0.0, 0.0]}, "parallel to normal"),
        ({"x": [1.0, 0.0, 0.0]}, "p is missing"),
        ({"x": [1.0], "p": [1.0, 0.0, 0.0]}, "x = "),
    ],
    (ch.ChaplyginSphere(inertia=np.arange(1.0, 7.0), D=2.0).ball(),): [
        ({"gamma": [0, 0, 0, 1], "p_tilde": [1, 0, 0, 0]}, "special")
    ],
}


@pytest.mark.parametrize(
    ("problems", "components", "text"),
    [(problems, *case) for problems, cases in REFUSED.items() for case in cases],
    ids=lambda given: given if isinstance(given, str) else "",
)
def test_states_refused(problems, components, text):
    for problem in problems:
        with pytest.raises(gi.DomainError, match=text):
            problem.state(**components)
