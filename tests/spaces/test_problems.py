"""Problems that name their space, and the public suite for problems and methods."""

from __future__ import annotations

import copy
import dataclasses
import math

import numpy as np
import pytest

import geomint as gi
from geomint.testing import check_method, check_problem


@gi.field
def field(params, t, y, out, work):
    """A great circle: q̇ = p, ṗ = −(p, p) q."""
    pp = y[3] * y[3] + y[4] * y[4] + y[5] * y[5]
    for i in range(3):
        out[i] = 1.0 * y[3 + i]
        out[3 + i] = -pp * y[i]


@gi.field
def generator(params, t, y, out, work):
    """ξ = p∧q as a flat triangle, that of q̇ = ξq, ṗ = ξp."""
    at = 0
    for i in range(3):
        for j in range(i + 1, 3):
            out[at] = y[3 + i] * y[j] - y[i] * y[3 + j]
            at += 1


@gi.field
def gradients(params, t, q, p, dq, dp, work):
    for i in range(3):
        dq[i] = 0.0 * q[i]
        dp[i] = 1.0 * p[i]


energy = gi.observable(lambda params, t, y, work: 0.5 * (y[3] ** 2 + y[4] ** 2 + y[5] ** 2))
height = gi.observable(lambda params, t, y, work: 1.0 * y[2])
seven = gi.observable(lambda params, t, y, work: 7.0 + 0.0 * y[0])
backwards = gi.observable(lambda params, t, y, work: 0.0 * y[0] - 1.0)


@gi.field
def slower(params, t, y, out, work):
    field(params, t, y, out, work)
    out[0] = 0.999 * out[0]


SPACE = gi.TangentSphere(3, ("q", "p"))
GEODESIC = gi.Problem(
    "geodesic",
    space=SPACE,
    field=field,
    action=SPACE.action(generator),
    hamiltonian=SPACE.hamiltonian(gradients, separable=True),
    invariants={"energy": energy},
    measure=gi.Measure(),
)


def test_all_is_taken_from_the_space() -> None:
    assert GEODESIC.pieces == SPACE.pieces
    assert list(GEODESIC.constraints) == ["norm", "tangency"]
    assert GEODESIC.measure == gi.Measure(manifold=SPACE.manifold, conditions=2)
    y = GEODESIC.random_state(3)
    np.testing.assert_array_equal(y, SPACE.join(SPACE.random(np.random.default_rng(3))))
    with pytest.warns(gi.GeomintWarning, match="q has length"):
        GEODESIC.state(q=[0, 0, 2], p=[1, 0, 0])
    with pytest.raises(gi.DomainError, match="unit vector"):
        GEODESIC.canonical(2.0 * y)
    again = dataclasses.replace(GEODESIC, name="again")
    assert again.space == SPACE
    check_problem(GEODESIC)


def test_what_is_given_wins() -> None:
    given = dataclasses.replace(
        GEODESIC,
        constraints={"norm": height},
        make_state=lambda **components: np.array([0, 0, 1.0, 1, 0, 0]),
        make_random=lambda rng: {"any": 1},
        admit=lambda y: y + 0.0,
        measure=gi.Measure(manifold=field, conditions=1),
    )
    assert given.constraints["norm"] is height
    np.testing.assert_array_equal(given.random_state(), [0, 0, 1.0, 1, 0, 0])
    np.testing.assert_array_equal(given.canonical(np.ones(6)), np.ones(6))
    assert given.measure.conditions == 1
    with pytest.raises(gi.DomainError, match="those of the space"):
        dataclasses.replace(GEODESIC, pieces=(("x", 6),))
    for pieces in (1j, 3, (1, 2), np.ones(2)):
        with pytest.raises(gi.DomainError, match="pieces"):
            dataclasses.replace(GEODESIC, pieces=pieces)
    with pytest.raises(gi.DomainError, match="a Space"):
        gi.Problem("none", space="sphere", field=field)


def test_names_and_parameters_of_a_space() -> None:
    """Constraints of one name get that of their piece; parameters begin with those of the space."""
    two = gi.Problem("two", space=gi.Sphere(3, "x") * gi.Sphere(3, "w"), field=field)
    assert list(two.constraints) == ["norm-x", "norm-w"]
    assert two.measure is None

    @dataclasses.dataclass(frozen=True)
    class Scaled(gi.Euclidean):
        params = np.array([2.0, 3.0])

    assert gi.Problem("one", space=Scaled(6), params=[2, 3, 4], field=field).rows == 6
    with pytest.raises(gi.DomainError, match="begin with those of the space"):
        gi.Problem("one", space=Scaled(6), params=[2, 4, 4], field=field)


def test_one_more_number_leaves_the_space() -> None:
    longer = gi.with_quadrature(GEODESIC, "s", height)
    assert longer.space is None
    y = longer.random_state(1)
    assert (len(y), y[-1]) == (7, 0.0)


@gi.field
def pushed(params, t, y, out, work):
    """Off the tangent space, at later times."""
    GEODESIC.field(params, t, y, out, work)
    out[3] = out[3] + t * y[0]


ALONE = {"action": None, "hamiltonian": None}


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"field": pushed, **ALONE}, "is not constant along the motion"),
        ({"field": slower}, "not one motion"),
        ({"field": slower, "action": None}, "field and hamiltonian .* are not one motion"),
        ({"invariants": {"height": height}}, "'height' .* is not constant along the motion"),
        ({"invariants": {"seven": seven}}, "'seven' .* is the same number at all states"),
        ({"constraints": {"height": height}}, "constraint 'height' .* is not 0"),
        ({"make_random": lambda rng: {"q": [0, 0, 1], "p": [1, 0, 0]}}, "one random state"),
        ({"admit": lambda y: y + 1e-9}, "changes an admissible state"),
        ({"measure": gi.Measure(height)}, "the measure of 'geodesic' is not invariant"),
        ({"time": "tau", "clock": backwards}, "time stands"),
    ],
)
def test_a_broken_problem_is_noticed(changes: dict, text: str) -> None:
    with pytest.raises(AssertionError, match=text):
        check_problem(dataclasses.replace(GEODESIC, **changes))


def test_functions_are_held_to_what_is_declared() -> None:
    with pytest.raises(gi.DeclarationError):
        check_problem(dataclasses.replace(GEODESIC, field=generator, action=None))


def test_states_are_given_as_lists_too() -> None:
    """Of problems without random ones; what is no state is told by its number."""

    @gi.field
    def turning(params, t, y, out, work):
        out[0] = 1.0 * y[1]
        out[1] = -y[0]

    energy = gi.observable(lambda params, t, y, work: y[0] * y[0] + y[1] * y[1])
    problem = gi.Problem(
        "turning", (("q", 1), ("p", 1)), field=turning, invariants={"energy": energy}
    )
    for states in ([[2.0, 0.3]], [(2, 0)], np.ones((2, 2)), iter([[1.0, 2.0]])):
        check_problem(problem, states=states)
    for wrong, said in (
        ([2.0, 0.3], r"states\[0\] = 2.0: expected 2 numbers, got 1"),
        ([[1.0, 2.0], [3.0]], r"states\[1\] = \[3.0\]: expected 2 numbers, got 1"),
        ([[1.0, math.nan]], r"states\[0\] = .*finite"),
        (2.5, "states = 2.5"),
        (None, "states = None"),
        (2, "make_random is missing: expected it, or a space, .* 'turning'; else give states"),
    ):
        with pytest.raises(gi.DomainError, match=said):
            check_problem(problem, states=wrong)
    single = gi.Problem("single", (("q", 1),), field=turning)
    with pytest.raises(gi.DomainError, match=r"^q is missing: expected 1 number$"):
        single.state()


FIXED = [name for name in gi.method_names() if not gi.find_method(name).adaptive]
KINDS = ("rk-4", "gauss-8", "cf-4", "rkmk-4", "rkmk-cayley-4", "rattle-2", "verlet-2")
LATE = [pytest.param(n, marks=pytest.mark.nightly) for n in FIXED if n not in KINDS]


@pytest.mark.parametrize("name", [*KINDS, *LATE])
def test_every_method_is_one(name: str) -> None:
    check_method(gi.find_method(name))


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("rk-4", {"order": 5}),
        ("rk-4", {"order": 3}),
        ("rk-4", {"symmetric": True}),
        ("gauss-8", {"order": 2}),
        ("gauss-8", {"order": 8}),
        ("rattle-2", {"order": 4}),
    ],
)
def test_a_false_claim_is_noticed(name: str, changes: dict) -> None:
    method = copy.copy(gi.find_method(name))
    for attribute, claim in changes.items():  # no arguments: they follow from what a method is
        object.__setattr__(method, attribute, claim)
    with pytest.raises(AssertionError, match=r"not of order|does not go back"):
        check_method(method)


def test_what_has_no_order_to_check() -> None:
    """An order is a whole number; adaptive methods have no steps to halve."""
    method = copy.copy(gi.find_method("rk-4"))
    object.__setattr__(method, "order", 4.4)
    for wrong, told in (
        (method, r"order = 4\.4"),
        (gi.find_method("dop853-adaptive"), "fixed steps"),
    ):
        with pytest.raises(gi.DomainError, match=told):
            check_method(wrong)
