"""Inertia operators: conversions, domains, and what the errors name."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import chaplygin as ch
import geomint as gi
from tests.chaplygin.support import DIMENSIONS, random_full, random_special, rng_for
from tests.paper.algebra import coordinates, skew

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


def test_a_squared_may_exceed_d():
    """Only i ≠ j enters: a thin rod has a_1² = 9.1 D and a positive energy."""
    sphere = ch.ChaplyginSphere.from_moments([0.1, 10.0, 10.0], 1.0, 1.0)
    assert sphere.inertia.a[0] ** 2 > 9.0 * sphere.D
    problem = sphere.ball()
    assert min(gi.value(problem, "energy", problem.random_state(seed)) for seed in range(50)) > 0.0


@pytest.mark.parametrize("n", DIMENSIONS)
def test_mass_tensor(n):
    """Iω = Jω + ωJ, in any axes; with all J_i equal but one it is special, and has that J."""
    rng = rng_for(n, 1)
    j, (i, k) = rng.uniform(0.5, 2.0, n), np.triu_indices(n, 1)
    sphere = ch.ChaplyginSphere.from_tensor(j, 2.0, 3.0)
    assert sphere.D == 18.0
    np.testing.assert_allclose(sphere.inertia.diagonal, j[i] + j[k], rtol=4e-14)
    q, _ = np.linalg.qr(rng.normal(size=(n, n)))
    tensor, omega = q @ np.diag(j) @ q.T, rng.normal(size=n * (n - 1) // 2)
    full = skew(omega, n)
    general = ch.GeneralInertia.from_mass_tensor(tensor)
    expected = coordinates(tensor @ full + full @ tensor)
    np.testing.assert_allclose(general.apply(omega), expected, atol=1e-13)
    sphere = ch.ChaplyginSphere.from_tensor(np.append(np.full(n - 1, 0.5), 0.9), 1.2, 1.0)
    assert sphere.special
    if n > 2:  # in the plane two J_i are one moment
        J = sphere.inertia.mass_tensor()
        np.testing.assert_allclose(J, np.append(np.full(n - 1, 0.5), 0.9), rtol=1e-13)


def test_mass_tensors_that_are_none():
    """Of the special operators for n ≥ 4 Lagrange's alone have a J, and not all a positive one."""
    with pytest.raises(gi.DomainError, match="all equal but one"):
        ch.SpecialInertia([0.7, 0.9, 1.2, 1.5], 4.0).mass_tensor()
    a1, D = 1.2, 4.0
    edge = a1 * D / (2 * D - a1 * a1)  # 2a_nD = a_1²a_n + a_1D
    assert ch.SpecialInertia([a1, a1, a1, 1.001 * edge], D).mass_tensor()[-1] > 0.0
    with pytest.raises(gi.DomainError, match=r"positive J; J\[3\]"):
        ch.SpecialInertia([a1, a1, a1, 0.999 * edge], D).mass_tensor()


def test_inertia_tensors_round_trip():
    m = rng_for(3, 2).normal(size=(3, 3))
    tensor = m @ m.T + np.eye(3)
    np.testing.assert_allclose(ch.GeneralInertia.from_tensor(tensor).tensor, tensor, rtol=1e-15)
    principal = ch.GeneralInertia.from_tensor(np.diag([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(principal.diagonal, [3.0, 2.0, 1.0])
    sphere = ch.ChaplyginSphere.from_tensor([1.0, 2.0, 4.0], 1.0, 1.0)
    np.testing.assert_allclose(sphere.inertia.moments, [6.0, 5.0, 3.0], rtol=1e-14)


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


BAD = {
    ch.ChaplyginSphere: [
        ({"a": [1.0, 2.0, 3.0], "D": 6.0}, r"a\[1\]\*a\[2\] is 6"),
        ({"a": [3.0, 1.0, 2.5], "D": 6.0}, r"a\[0\]\*a\[2\] is 7.5"),
        ({"a": [1.0, -2.0], "D": 6.0}, r"a\[1\] is not"),
        ({"a": [1.0, 0.0], "D": 6.0}, "positive"),
        ({"a": [1.0, float("nan")], "D": 6.0}, "finite"),
        ({"a": [1.0], "D": 6.0}, "n ≥ 2"),
        ({"a": 1.0, "D": 6.0}, "a sequence"),
        ({"a": ["x", "y"], "D": 6.0}, "sequence of numbers"),
        ({"a": [1e-200, 1e-200], "D": 6.0}, "vanish"),
        ({"a": [1.0, 2.0], "D": 0.0}, "D = 0.0"),
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
        ({"inertia": random_special(3), "D": 1e3}, "of the inertia operator"),
    ],
    ch.ChaplyginSphere.from_moments: [
        ({"moments": [1, 2, -3], "m": 1, "rho": 1}, "positive"),
        ({"moments": [1, 2], "m": 1, "rho": 1}, "3 numbers"),
        ({"moments": [1, 2, 3], "m": 0, "rho": 1}, "m = 0"),
        ({"moments": [1, 2, 3], "m": 1, "rho": -1}, "rho = -1"),
    ],
    ch.ChaplyginSphere.from_tensor: [
        ({"J": [1.0], "m": 1, "rho": 1}, "n ≥ 2"),
        ({"J": [[1.0, 0.1], [0.2, 1.0]], "m": 1, "rho": 1}, "symmetric"),
        ({"J": [1.0, -2.0], "m": 1, "rho": 1}, "positive definite"),
    ],
    ch.ChaplyginSphere.homogeneous: [
        ({"n": 1, "s": 1.0, "D": 1.0}, "n = 1: .* from 2"),
        ({"n": 3, "s": -1.0, "D": 1.0}, "s = -1.0"),
    ],
    ch.RubberSphere.from_a: [({"a": [1.0, 2.0, 3.0], "D": 0.2}, r"a\[1\]\*a\[2\]\*D is 1.2")],
    ch.RubberSphere([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 1.0).hamiltonized: [({}, "from_a")],
    ch.ChaplyginSphere(inertia=random_full(4), D=2.0).hamiltonized: [({}, "special operator")],
    ch.ChaplyginSphere(inertia=random_full(4), D=2.0).classical: [({}, "dimension 3")],
    ch.Veselova: [
        ({"a": [1.0]}, "n ≥ 2"),
        ({"a": 1.0}, "sequence"),
        ({"a": [1.0, -2.0]}, r"a\[1\] is not"),
        ({"a": [1.0, 1e-320]}, r"a\[1\] is not"),
        ({"a": [1.0, 2.0], "D": 0.0}, "D = 0.0"),
    ],
    ch.Veselova.from_moments: [
        ({"moments": [1.0, 2.0]}, "3 numbers"),
        ({"moments": [1.0, 2.0, 0.0]}, "positive"),
    ],
    ch.Veselova([1.0, 2.0]).classical: [({}, "dimension 3")],
    ch.Veselova([1.0, 2.0, 3.0]).classical: [({"f1": float("nan")}, "f1")],
    ch.VeselovaLR: [
        ({"inertia": random_full(4), "r": 4}, "r = 4"),
        ({"inertia": random_full(4), "r": 0}, "r = 0"),
    ],
    ch.ellipsoid_problem: [
        ({"a": [1.0]}, "n ≥ 2"),
        ({"a": [1.0, 0.0]}, r"a\[1\] is not"),
        ({"a": [1.0, float("nan")]}, "finite"),
    ],
}


@pytest.mark.parametrize(
    ("make", "arguments", "text"),
    [(make, *case) for make, cases in BAD.items() for case in cases],
    ids=lambda given: given if isinstance(given, str) else "",
)
def test_bad_parameters(make, arguments, text):
    with pytest.raises(gi.DomainError, match=text):
        make(**arguments)


def test_arrays_of_spheres_are_frozen():
    sphere = ch.ChaplyginSphere(a=[1.0, 2.0], D=3.0)
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
