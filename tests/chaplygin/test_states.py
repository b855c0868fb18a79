"""States: what is accepted as it is, what is projected with a warning, what is refused."""

import warnings

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import chaplygin as ch
import geomint as gi
from chaplygin.initial_states import multiplier
from chaplygin.manifold import length, skew_matrix, triangle_of_vector, vector_of_triangle, wedge
from tests.chaplygin.support import (
    CASES,
    DIMENSIONS,
    generator_of,
    quiet_state,
    random_rotation,
    random_special,
    random_tangent,
    rng_for,
    value_of,
)

SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
ON_SPHERE = (SPHERE.reduced(), SPHERE.hamiltonized())


def close(x, y):
    np.testing.assert_allclose(x, y, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_admissible_states_are_left_as_they_are(case):
    np.testing.assert_array_equal(case.problem.canonical(case.y), case.y)


@pytest.mark.parametrize("problem", ON_SPHERE, ids=lambda p: p.name)
def test_projection_is_announced_with_its_size(problem):
    with pytest.warns(gi.GeomintWarning) as caught:
        y = problem.state(gamma=[1, 2, 3], p=[1.8, -3.0, 1.2])
    texts = [str(w.message) for w in caught]
    assert any("3.74165738677394" in text for text in texts)
    assert any("(gamma, p)/|p| is 0.0434" in text for text in texts)
    assert {w.filename for w in caught} == {__file__}
    gamma = np.array([1, 2, 3]) / np.sqrt(14)
    p = np.array([1.8, -3.0, 1.2])
    p = p - (gamma @ p) * gamma
    close(problem.physical_state(y)["gamma"], gamma)
    close(problem.physical_state(y)["k"], wedge(gamma, p))


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
        again, q = y[:3], y[3:]
        assert abs(again @ again - 1.0) < 2e-13
        assert abs(again @ (q / length(q))) < 2e-13
        expected = wedge(direction, momentum) / np.linalg.norm(direction)
        got = problem.physical_state(y)["k"] / 10.0**scale
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=2e-13)
        np.testing.assert_array_equal(problem.canonical(y), y)


@given(
    st.lists(st.one_of(st.floats(), st.none(), st.text(max_size=2)), max_size=5),
    st.lists(st.one_of(st.floats(), st.integers()), max_size=5),
)
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_anything_else_is_an_error_with_a_name(gamma, p):
    """A state is finite and admissible, or there is a DomainError."""
    for problem in (*ON_SPHERE, SPHERE.ball(), SPHERE.classical()):
        y, refused = None, None
        try:
            y = problem.state(gamma=gamma, p=p)
        except gi.DomainError as error:
            refused = error.name
        if y is None:
            assert refused in ("gamma", "p", "state")
            continue
        assert np.isfinite(y).all()
        assert abs(value_of(problem, "norm", y)) < 1e-13


@pytest.mark.parametrize("n", DIMENSIONS)
def test_all_momenta_name_the_same_state(n):
    sphere = ch.ChaplyginSphere(inertia=random_special(n))
    gamma, p = random_tangent(n)
    k = wedge(gamma, p)
    omega = -k_to_generator(sphere.ball(), gamma, k)
    p_tilde = p / multiplier(sphere.inertia.a, sphere.D, gamma)
    forms = {"p": p, "p_tilde": p_tilde, "k": k, "omega": omega}
    matrices = {"k": skew_matrix(k, n), "omega": skew_matrix(omega, n)}
    problems = [sphere.reduced(), sphere.hamiltonized(), sphere.ball(), sphere.ball(True)]
    if n == 3:
        problems.append(sphere.classical())
        vectors = {name: vector_of_triangle(forms[name]) for name in ("k", "omega")}
    for problem in problems:
        mine = forms | (vectors if problem.name == "classical-ball" else {})
        for name, value in [*mine.items(), *matrices.items()]:
            physical = problem.physical_state(problem.state(gamma=gamma, **{name: value}))
            np.testing.assert_allclose(physical["k"], k, rtol=0, atol=1e-13)
            np.testing.assert_array_equal(physical["gamma"], gamma)


def k_to_generator(problem, gamma, k):
    return generator_of(problem, quiet_state(problem, gamma=gamma, k=k))


def test_omega_gives_k_by_its_definition():
    sphere = ch.ChaplyginSphere(inertia=random_special(5))
    gamma, omega = random_tangent(5)[0], rng_for(5, 1).normal(size=10)
    y = quiet_state(sphere.ball(), gamma=gamma, omega=omega)
    close(-k_to_generator(sphere.ball(), gamma, y[:10]), omega)


def flat(problem, norm=0.0, tangency=0.0):
    """Return a state whose |γ|² − 1 and (γ, p)/|p| are about the given ones."""
    gamma, p = random_tangent(3)
    y = quiet_state(problem, gamma=gamma, p=p)
    y[3:] += tangency * np.linalg.norm(y[3:]) * y[:3]
    y[:3] *= 1.0 + 0.5 * norm
    return y


@pytest.mark.parametrize("problem", ON_SPHERE, ids=lambda p: p.name)
@pytest.mark.parametrize("defect", ["norm", "tangency"])
def test_flat_states(problem, defect):
    silent = flat(problem, **{defect: 5e-14})
    np.testing.assert_array_equal(problem.canonical(silent), silent)
    repaired = flat(problem, **{defect: 3e-7})
    with pytest.warns(gi.GeomintWarning, match="3e-07"):
        y = problem.canonical(repaired)
    close(y[:3] @ y[:3], 1.0)
    assert abs(y[:3] @ y[3:]) < 1e-15
    np.testing.assert_allclose(y, repaired, atol=1e-6)
    with pytest.raises(gi.DomainError, match=r"0\.001") as caught:
        problem.canonical(flat(problem, **{defect: 1e-3}))
    assert caught.value.name == ("gamma" if defect == "norm" else problem.pieces[1][0])


def test_tangency_is_relative_to_p():
    problem = SPHERE.reduced()
    gamma, p = random_tangent(3)
    for scale in (1e-75, 1e75):
        y = np.concatenate([gamma, scale * (p + 1e-14 * gamma)])
        np.testing.assert_array_equal(problem.canonical(y), y)
        bad = np.concatenate([gamma, scale * (p + 1e-3 * gamma)])
        with pytest.raises(gi.DomainError, match="orthogonal"):
            problem.canonical(bad)


def test_rest_is_a_state():
    for problem in ON_SPHERE:
        y = problem.state(gamma=[0.0, 0.0, 1.0], p=[0.0, 0.0, 0.0])
        np.testing.assert_array_equal(y, [0, 0, 1, 0, 0, 0])
    SPHERE.reduced().state(gamma=[0.0, 0.0, 1.0], k=[0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("components", "text"),
    [
        ({"gamma": [0, 0, 0], "p": [1, 0, 0]}, "not zero"),
        ({"gamma": [0, 0, float("nan")], "p": [1, 0, 0]}, "gamma = .*finite"),
        ({"gamma": [0, 0, float("inf")], "p": [1, 0, 0]}, "gamma = .*finite"),
        ({"gamma": [0, 1], "p": [1, 0, 0]}, "gamma = .*3 numbers"),
        ({"gamma": [0, 0, 1], "p": [1, 0]}, "p = .*3 numbers"),
        ({"gamma": [0, 0, 1], "p": [1, 0, float("nan")]}, "p = .*finite"),
        ({"gamma": [0, 0, 1], "p": [0, 0, 2]}, "not parallel"),
        ({"gamma": [0, 0, 1], "p": [0, 1e-12, 2]}, "not parallel"),
        ({"gamma": [0, 0, 1]}, "exactly one of"),
        ({"p": [1, 0, 0]}, "gamma = None"),
        ({"gamma": [0, 0, 1], "p": [1, 0, 0], "k": [1, 0, 0]}, "exactly one of"),
        ({"gamma": [0, 0, 1], "k": [1, 0, 0]}, "zero SO"),
        ({"gamma": [0, 0, 1], "k": np.eye(3)}, "skew-symmetric"),
    ],
)
def test_bad_components(components, text):
    for problem in ON_SPHERE:
        with pytest.raises(gi.DomainError, match=text):
            problem.state(**components)


def test_unknown_components_are_errors():
    for problem in (*ON_SPHERE, SPHERE.ball(), SPHERE.classical()):
        with pytest.raises(gi.DomainError, match="q = "):
            problem.state(gamma=[0, 0, 1], p=[1, 0, 0], q=1)
    with pytest.raises(gi.DomainError, match="attitude=False"):
        SPHERE.ball().state(gamma=[0, 0, 1], k=[1, 0, 0], g=np.eye(3))


def test_momentum_near_zero_is_projected():
    gamma, p = random_tangent(4)
    sphere = ch.ChaplyginSphere(inertia=random_special(4))
    other = wedge(*random_tangent(4, 9))
    with pytest.warns(gi.GeomintWarning, match="pr k"):
        sphere.reduced().state(gamma=gamma, k=wedge(gamma, p) + 1e-9 * other)
    with pytest.raises(gi.DomainError, match="zero SO"):
        sphere.reduced().state(gamma=gamma, k=wedge(gamma, p) + 1e-3 * other)


def test_p_tilde_needs_the_special_operator():
    sphere = ch.ChaplyginSphere(inertia=np.arange(1.0, 7.0), D=2.0)
    gamma, p = random_tangent(4)
    with pytest.raises(gi.DomainError, match="special"):
        sphere.ball().state(gamma=gamma, p_tilde=p)


@pytest.mark.parametrize(
    "problem", [SPHERE.ball(True), SPHERE.classical(True)], ids=["so_n", "so3"]
)
def test_attitude(problem):
    gamma, g = random_tangent(3)[0], random_rotation(3)
    y = quiet_state(problem, gamma=gamma, k=[1.0, 2.0, 3.0])
    np.testing.assert_array_equal(y[6:].reshape(3, 3), np.eye(3))
    y = quiet_state(problem, gamma=gamma, k=[1.0, 2.0, 3.0], g=g)
    np.testing.assert_array_equal(y[6:].reshape(3, 3), g)
    with pytest.raises(gi.DomainError, match="rotation"):
        problem.state(gamma=gamma, k=[1.0, 2.0, 3.0], g=-g)
    with pytest.raises(gi.DomainError, match="rotation"):
        problem.state(gamma=gamma, k=[1.0, 2.0, 3.0], g=1.1 * g)
    with pytest.warns(gi.GeomintWarning, match="gᵀg"):
        y = problem.state(gamma=gamma, k=[1.0, 2.0, 3.0], g=(1 + 1e-8) * g)
    close(y[6:].reshape(3, 3) @ y[6:].reshape(3, 3).T, np.eye(3))


def test_k0_is_observed_only_if_given():
    x = np.array([1.0, 2.0, 3.0])
    k0 = triangle_of_vector(x)
    for with_k0 in (SPHERE.ball(True, k0), SPHERE.ball(True, skew_matrix(k0, 3))):
        assert "spatial-momentum" in with_k0.diagnostics
    assert "spatial-momentum" in SPHERE.classical(True, x).diagnostics
    assert "spatial-momentum" not in SPHERE.ball(True).diagnostics
    assert "orthogonality" not in SPHERE.ball().diagnostics


@pytest.mark.parametrize("problem", ON_SPHERE, ids=lambda p: p.name)
@pytest.mark.parametrize("defect", [1e-12, 1e-9, 1e-4])
def test_named_components_are_projected_from_round_off_on(problem, defect):
    gamma, p = random_tangent(3)
    with pytest.warns(gi.GeomintWarning) as caught:
        y = problem.state(gamma=gamma, p=p + defect * np.linalg.norm(p) * gamma)
    (message,) = [str(w.message) for w in caught]
    assert f"|p| is {defect:.2g}"[:11] in message
    assert abs(y[:3] @ y[3:]) < 1e-15
    np.testing.assert_allclose(problem.physical_state(y)["k"], wedge(gamma, p), atol=1e-15)
    with pytest.warns(gi.GeomintWarning, match="length"):
        y = problem.state(gamma=(1 + defect) * gamma, p=p)
    assert abs(y[:3] @ y[:3] - 1.0) < 1e-15


@pytest.mark.parametrize("case", CASES, ids=str)
def test_random_states(case):
    """Admissible without a projection, all different, and the same for the same seed."""
    problem = case.problem
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        states = [problem.random_state(seed) for seed in (1, 2, 1)]
    np.testing.assert_array_equal(states[0], states[2])
    assert (states[0] != states[1]).all()
    for name in set(problem.constraints) - {"spatial-momentum"}:
        assert abs(value_of(problem, name, states[0])) < 4e-14, name
    again = problem.random_state(np.random.default_rng(1))
    np.testing.assert_array_equal(again, states[0])


def test_no_random_states():
    problem = gi.Problem("free", (("x", 1),), field=gi.field(lambda params, t, y, out, work: None))
    with pytest.raises(gi.DomainError, match="random states"):
        problem.random_state()
