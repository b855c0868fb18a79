"""Inertia operators: conversions, domains, and what the errors name."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from chaplygin.manifold import flat_triangle, skew_matrix
from tests.chaplygin.support import (
    DIMENSIONS,
    random_direction,
    random_full,
    random_special,
    rng_for,
    value_of,
)

moment = st.floats(1e-3, 1e3)


@pytest.mark.filterwarnings("ignore:moments")  # of bodies or not
@given(st.tuples(moment, moment, moment), moment, st.floats(0.1, 10))
def test_moments_round_trip(moments, m, rho):
    """Eq. (IOP1) and eq. (IOP), with I_3 = a_1 a_2 D/(D − a_1 a_2)."""
    sphere = ch.ChaplyginSphere.from_moments(moments, m, rho)
    assert sphere.special
    assert pytest.approx(m * rho * rho) == sphere.D
    a, D = sphere.inertia.a, sphere.D
    # D − a_i a_j = D²/(I + D): a relative error ε of the product becomes ε (I + D)/D
    limit = 1e-14 * (1 + max(moments) / D)
    np.testing.assert_allclose(sphere.inertia.moments, moments, rtol=limit)
    assert a[0] * a[1] * D / (D - a[0] * a[1]) == pytest.approx(moments[2], rel=limit)
    again = ch.SpecialInertia.from_moments(sphere.inertia.moments, D)
    np.testing.assert_allclose(again.a, a, rtol=1e-14 + limit)


def test_iop1_as_printed():
    moments, D = np.array([1.0, 2.0, 3.0]), 0.5
    roots = np.sqrt(np.prod(moments) * D) / np.sqrt(np.prod(moments + D))
    a = ch.SpecialInertia.from_moments(moments, D).a
    np.testing.assert_allclose(a, roots * (moments + D) / moments, rtol=1e-15)


def test_a_squared_may_exceed_d():
    """Only i ≠ j enters: a thin rod has a_1² = 9.1 D and a positive energy."""
    sphere = ch.ChaplyginSphere.from_moments([0.1, 10.0, 10.0], 1.0, 1.0)
    assert sphere.inertia.a[0] ** 2 > 9.0 * sphere.D
    for seed in range(50):
        gamma, k = random_direction(3, seed), rng_for(3, seed).normal(size=3)
        problem = sphere.ball()
        y = problem.state(gamma=gamma, k=k)
        assert value_of(problem, "energy", y) > 0.0


@pytest.mark.parametrize("n", DIMENSIONS)
def test_mass_tensor(n):
    """Iω = Jω + ωJ, in any axes."""
    rng = rng_for(n, 1)
    j = rng.uniform(0.5, 2.0, n)
    sphere = ch.ChaplyginSphere.from_tensor(j, 2.0, 3.0)
    assert sphere.D == 18.0
    i, k = np.triu_indices(n, 1)
    np.testing.assert_allclose(sphere.inertia.diagonal, j[i] + j[k], rtol=4e-15 * 10)
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    tensor = q @ np.diag(j) @ q.T
    general = ch.GeneralInertia.from_mass_tensor(tensor)
    omega = rng.normal(size=n * (n - 1) // 2)
    full = skew_matrix(omega, n)
    expected = flat_triangle(tensor @ full + full @ tensor)
    np.testing.assert_allclose(general.apply(omega), expected, atol=1e-13)


def test_mass_tensor_at_n3_gives_moments():
    sphere = ch.ChaplyginSphere.from_tensor([1.0, 2.0, 4.0], 1.0, 1.0)
    np.testing.assert_allclose(sphere.inertia.moments, [6.0, 5.0, 3.0], rtol=1e-14)


def test_inertia_tensor_round_trip():
    m = rng_for(3, 2).normal(size=(3, 3))
    tensor = m @ m.T + np.eye(3)
    general = ch.GeneralInertia.from_tensor(tensor)
    np.testing.assert_allclose(general.tensor, tensor, rtol=1e-15)
    principal = ch.GeneralInertia.from_tensor(np.diag([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(principal.diagonal, [3.0, 2.0, 1.0])


def test_physical_lagrange_body_is_special():
    """The multidimensional Lagrange case; J_n > 0 needs 2 a_n D > a_1² a_n + a_1 D."""
    a1, an, D, n = 0.9, 1.3, 2.5, 5
    j1 = a1 * a1 * D / (2 * (D - a1 * a1))
    jn = a1 * an * D / (D - a1 * an) - j1
    special = ch.SpecialInertia([a1] * (n - 1) + [an], D)
    physical = ch.GeneralInertia.from_mass_tensor([j1] * (n - 1) + [jn])
    np.testing.assert_allclose(physical.diagonal, special.diagonal, rtol=1e-14)
    assert (2 * an * D > a1 * a1 * an + a1 * D) == (jn > 0)
    a1, an = 1.5, 0.6  # here the condition with a_1 a_n, as printed, decides otherwise
    jn = a1 * an * D / (D - a1 * an) - a1 * a1 * D / (2 * (D - a1 * a1))
    assert (2 * an * D > a1 * a1 * an + a1 * D) == (jn > 0)


@pytest.mark.parametrize(
    ("n", "values", "special"),
    [
        (2, [1.3], True),
        (3, [1.0, 2.0, 3.0], True),
        (4, [1.5] * 6, True),
        (4, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], False),
    ],
)
def test_special_operators_are_recognised(n, values, special):
    sphere = ch.ChaplyginSphere(inertia=values, D=2.0)
    assert (sphere.n, sphere.special) == (n, special)
    np.testing.assert_allclose(sphere.inertia.diagonal, values, rtol=1e-14)


def test_general_inertia_has_no_hamiltonized_form():
    sphere = ch.ChaplyginSphere(inertia=random_full(4).matrix, D=2.0)
    with pytest.raises(gi.DomainError, match="special operator"):
        sphere.hamiltonized()
    with pytest.raises(gi.DomainError, match="dimension 3"):
        sphere.classical()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"a": [1.0, 2.0, 3.0], "D": 6.0}, r"a\[1\]\*a\[2\] is 6"),
        ({"a": [3.0, 1.0, 2.5], "D": 6.0}, r"a\[0\]\*a\[2\] is 7.5"),
        ({"a": [1.0, -2.0], "D": 6.0}, r"a\[1\] is not"),
        ({"a": [1.0, 0.0], "D": 6.0}, "positive"),
        ({"a": [1.0, float("nan")], "D": 6.0}, "finite"),
        ({"a": [1.0, float("inf")], "D": 6.0}, "finite"),
        ({"a": [1.0], "D": 6.0}, "n ≥ 2"),
        ({"a": [], "D": 6.0}, "n ≥ 2"),
        ({"a": 1.0, "D": 6.0}, "a sequence"),
        ({"a": ["x", "y"], "D": 6.0}, "sequence of numbers"),
        ({"a": [1e-200, 1e-200], "D": 6.0}, "vanish"),
        ({"a": [1.0, 2.0], "D": 0.0}, "D = 0.0"),
        ({"a": [1.0, 2.0], "D": -1.0}, "D = -1.0"),
        ({"a": [1.0, 2.0], "D": float("nan")}, "finite"),
        ({"a": [1.0, 2.0]}, "D = None"),
        ({"D": 1.0}, "either a or inertia"),
        ({"a": [1.0, 2.0], "inertia": [1.0], "D": 3.0}, "either a or inertia"),
        ({"inertia": [1.0, 2.0], "D": 3.0}, r"n\(n−1\)/2"),
        ({"inertia": [1.0, 2.0, -3.0], "D": 3.0}, "least eigenvalue is -3"),
        ({"inertia": [[1.0, 2.0, 0], [2.0, 1.0, 0], [0, 0, 1.0]], "D": 3.0}, "eigenvalue is -1"),
        ({"inertia": [[1.0, 0.5, 0], [0.0, 1.0, 0], [0, 0, 1.0]], "D": 3.0}, "is 0.5"),
        ({"inertia": [[1.0, 0.5], [0.0, 1.0], [0, 0]], "D": 3.0}, r"shape \(3, 3\)"),
        ({"inertia": np.zeros((3, 3)), "D": 3.0}, "positive definite"),
        ({"inertia": 3.0, "D": 3.0}, "a sequence"),
    ],
)
def test_bad_parameters(arguments, text):
    with pytest.raises(gi.DomainError, match=text):
        ch.ChaplyginSphere(**arguments)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: ch.ChaplyginSphere.from_moments([1, 2, -3], 1, 1), "positive"),
        (lambda: ch.ChaplyginSphere.from_moments([1, 2], 1, 1), "3 numbers"),
        (lambda: ch.ChaplyginSphere.from_moments([1, 2, 3], 0, 1), "m = 0"),
        (lambda: ch.ChaplyginSphere.from_moments([1, 2, 3], 1, -1), "rho = -1"),
        (lambda: ch.ChaplyginSphere.from_tensor([1.0], 1, 1), "n ≥ 2"),
        (lambda: ch.ChaplyginSphere.from_tensor([[1.0, 0.1], [0.2, 1.0]], 1, 1), "symmetric"),
        (lambda: ch.ChaplyginSphere.from_tensor([1.0, -2.0], 1, 1), "positive definite"),
        (lambda: ch.ChaplyginSphere.homogeneous(1, 1.0, 1.0), "n = 1: .* from 2"),
        (lambda: ch.ChaplyginSphere.homogeneous(3, -1.0, 1.0), "s = -1.0"),
        (lambda: ch.ChaplyginSphere(inertia=random_special(3), D=1e3), "of the inertia operator"),
    ],
)
def test_bad_constructions(make, text):
    with pytest.raises(gi.DomainError, match=text):
        make()


def test_spheres_are_frozen():
    sphere = ch.ChaplyginSphere(a=[1.0, 2.0], D=3.0)
    with pytest.raises(AttributeError):
        sphere.D = 2.0
    with pytest.raises(ValueError, match="read-only"):
        sphere.inertia.a[0] = 2.0


IMPOSSIBLE, DISC = [1.0, 2.0, 4.0], [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    "make",
    [
        lambda moments: ch.ChaplyginSphere.from_moments(moments, 1.0, 1.0),
        lambda moments: ch.ChaplyginSphere.from_moments(np.diag(moments), 1.0, 1.0),
        lambda moments: ch.RubberSphere.from_moments(moments, 1.0),
        lambda moments: ch.RubberSphere.from_moments(np.diag(moments), 1.0),
        lambda moments: ch.Veselova.from_moments(moments),
    ],
)
def test_moments_that_no_body_has(make: Any) -> None:
    """A warning at the caller's line names the inequality and by how much; a disc has its own."""
    with pytest.warns(
        gi.GeomintWarning, match=r"more than .* others, 3, by 1: .*≤ I_j \+ I_k"
    ) as told:
        make(IMPOSSIBLE)
    assert [note.filename for note in told] == [__file__]
    make(DISC)
    make([3.0, 2.0, 1.0 - 1e-14])


def test_mass_tensors_that_no_body_has() -> None:
    with pytest.warns(gi.GeomintWarning, match=r"J: the principal value -0\.4 is negative"):
        ch.ChaplyginSphere.from_tensor([1.0, 2.0, 0.8, -0.4], 1.0, 1.0)
    ch.ChaplyginSphere.from_tensor([1.0, 2.0, 0.8, 0.0], 1.0, 1.0)


def test_operators_need_not_be_those_of_a_body() -> None:
    """What is given as an operator is taken as it is: the same moments, without a word."""
    operator = ch.GeneralInertia(IMPOSSIBLE[::-1])
    ch.ChaplyginSphere(inertia=operator, D=1.0)
    ch.SpecialInertia.from_moments(IMPOSSIBLE, 1.0)
    ch.ChaplyginSphere(a=operator.special(1.0).a, D=1.0)


def test_scenes_with_moments_that_no_body_has() -> None:
    """A note, once, in scenes; none in those that are built in."""
    content = {
        "system": {"name": "chaplygin-ball", "moments": IMPOSSIBLE, "D": 1.0},
        "initial": {"gamma": [0.6, 0.0, 0.8], "k": [1.0, 2.0, 3.0]},
        "time": {"t_end": 1.0},
    }
    notes = gi.Scene.from_content("impossible", content).notes
    assert sum("no rigid body" in note for note in notes) == 1
    for name in gi.scene_names():
        assert not any("no rigid body" in note for note in gi.load_scene(name).notes)
