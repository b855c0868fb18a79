"""Spaces: every one of them is held to the public suite, and what the suite cannot know is here."""

from __future__ import annotations

import functools
import importlib
import itertools
import pkgutil
from contextlib import nullcontext as nothing
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, strategies as st

import geomint as gi
from geomint.problems import spaces
from geomint.problems.spaces.repair import repaired
from geomint.testing import check_group, check_method, check_problem, check_space

pytestmark = pytest.mark.nojit
SPACES = [
    gi.Euclidean(1),
    gi.Euclidean(4, "v", turned=True),
    *(space(n) for n in (2, 3, 5) for space in (gi.Sphere, gi.TangentSphere, gi.Skew)),
    *(gi.Rotations(n) for n in (2, 3, 4)),
    gi.RigidMotions(3),
    *(space(n, r) for n, r in ((3, 2), (4, 2)) for space in (gi.Stiefel, gi.TangentStiefel)),
    gi.Stiefel(3, 3),
    gi.TangentBundle(gi.Rotations(3), "m"),
    gi.TangentBundle(gi.Euclidean(2), "v"),
    gi.TangentBundle(gi.Skew(3), "v"),
    gi.Product(gi.Sphere(3)),
    gi.Skew(3) * gi.Sphere(3) * gi.Rotations(3) * gi.Euclidean(2, "r"),
    gi.Sphere(3, "x") * gi.Sphere(3, "w"),
    gi.Euclidean(2, "r") * gi.TangentSphere(4) * gi.Euclidean(1, "s") * gi.Sphere(2, "w"),
]


for found in pkgutil.iter_modules(spaces.__path__):  # kinds that the list has not
    module = importlib.import_module(f"{spaces.__name__}.{found.name}")
    for kind in (getattr(module, name) for name in module.__all__):
        if isinstance(kind, type) and issubclass(kind, gi.Space) and "pieces" in vars(kind):
            known = any(isinstance(f, kind) for space in SPACES for f in (space, *space.factors))
            SPACES += [] if known else [kind(n) for n in (2, 3, 5)]
KINDS = {type(f).__name__: type(f) for space in SPACES for f in space.factors}


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_every_space_is_one(space: gi.Space) -> None:
    check_space(space)
    assert eval(repr(space), {**KINDS, **{name: getattr(gi, name) for name in gi.__all__}}) == space


def test_spaces_are_different() -> None:
    """By every field; and a product is one of its factors, however it is written."""
    for one, other in itertools.combinations(SPACES, 2):
        assert one != other, (one, other)
    a, b, c = gi.Sphere(3), gi.Skew(3), gi.Euclidean(2)
    assert a * (b * c) == (a * b) * c == gi.Product(a, b, c)
    assert a * b != b * a


# --- each property is looked at: what breaks it is noticed ----------------------------------------


above_one = gi.observable(lambda params, t, y, work: y[0] * y[0] + y[1] * y[1] - 1.0 + 1e-9 * y[0])
doubled = gi.observable(lambda params, t, y, work: 3.0 * (y[0] * y[0] + y[1] * y[1] - 1.0))
half_tangent = gi.observable(lambda params, t, y, work: y[0] * y[2] + y[1] * y[3] - 0.1)


@gi.field
def shifted(params, q, g, G, work):
    gi.Sphere(2).constraint(params, q, g, G, work)
    g[0] = g[0] + 1e-9


@gi.field
def bent(params, q, g, G, work):
    gi.Sphere(2).constraint(params, q, g, G, work)
    G[0] = 2.0 * G[0]


@gi.field
def too_long(params, q, g, G, work):
    g[1] = 0.0 * q[0]


def unit(y):
    return y / np.linalg.norm(y)


def off(y):
    return abs(np.linalg.norm(y) - 1.0)


def badly(space, y):
    return repaired("gamma", y, off(y), "|γ| − 1", "unit", lambda: y + 1e-9)


@functools.cache
def circle(k):
    """Return the k-th sphere some of whose parts are others."""
    changes = {"__reduce__": lambda space: (circle, (k,)), **BROKEN[k][1]}
    return type("Circle", (gi.Sphere,), changes)(2)


def refused(space, y):
    raise gi.DomainError("gamma", y, "another")


def longer(space, rng):
    return {"gamma": 2.0 * S.random(space, rng)["gamma"]}


class Dependent(gi.Space):
    """Two conditions that are one."""

    def constraints_at(self, first):
        return {"one": gi.Sphere(2).constraints["norm"], "two": doubled}


@dataclass(frozen=True)
class Twice(gi.Space):
    """A circle by two conditions that are one."""

    n: int = 3
    codes = None

    @property
    def pieces(self):
        return (("x", 3),)

    constraints_at = Dependent.constraints_at

    def random(self, rng):
        angle, height = rng.normal(size=2)
        return {"x": np.array([np.cos(angle), np.sin(angle), height])}


class Unequal(gi.Euclidean):
    """Compared by identity."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__


S = gi.Sphere
BROKEN = [
    ("constraint 'norm' .* is not 0", {"constraints_at": lambda s, first: {"norm": above_one}}),
    (
        "constraint 'norm' of Euclidean.* is not 0",
        {"constraints_at": lambda s, first: S.constraints_at(s, 0)},
    ),
    (
        "constraint 'tangency' of TangentBundle.* is not 0",
        {"tangencies_at": lambda s, *at: {"tangency": half_tangent}},
    ),
    ("as many conditions as rows", {"conditions": 2}),
    ("without a warning", {"admit": lambda s, y: y}),
    ("without a warning", {"admit": lambda s, y: y if off(y) < 1e-12 else unit(y)}),
    ("repairs a state badly", {"admit": badly}),
    ("`project` changes a random point", {"project": lambda s, **x: -S.project(s, **x)}),
    (
        "`project` .* without a warning",
        {"point": lambda s, x: unit(x) if off(x) > 1e-12 else S.point(s, x)},
    ),
    ("tangent parts .* are not tangent", {"tangent": lambda s, y, v: v}),
    ("retractions .* leave it", {"retract": lambda s, y, v: y + v}),
    ("another point for the same seed", {"random": lambda s, rng: S.random(s, FREE)}),
    ("one point for two seeds", {"random": lambda s, rng: {"gamma": np.array([0.0, 1.0])}}),
    ("`constraint` .* is not 0 on it", {"constraint": shifted}),
    ("another Jacobian", {"constraint": bent}),
    ("IndexError.* by a function of Circle", {"constraint": too_long}),
    (r"R\^2 moves points out", {"group": gi.translations(2)}),
    ("the other way round", {"distance": lambda s, y, z: float(y[0] - z[0])}),
    ("`settled` of Circle.* is not admitted so", {"settled": lambda s, y: S.settled(s, y) | True}),
    ("another", {"admit": refused}),
    ("the state uses", {"random": longer}),
    ("", {}),
]
FREE = np.random.default_rng(1)


@pytest.mark.parametrize("k", range(len(BROKEN) - 1), ids=lambda k: BROKEN[k][0])
def test_a_broken_space_is_noticed(k: int) -> None:
    check_space(circle(len(BROKEN) - 1))  # with nothing broken
    kinds = {"another": gi.DomainError, "the state uses": gi.GeomintWarning}
    with pytest.raises(kinds.get(BROKEN[k][0], AssertionError), match=BROKEN[k][0]):
        check_space(circle(k))


def test_other_broken_spaces_are_noticed() -> None:
    for space, told in (
        (Twice(), "depend on each other"),
        (Unequal(2), "is not the value that it pickles"),
    ):
        with pytest.raises(AssertionError, match=told):
            check_space(space)


def test_checks_say_what_they_are_for_and_look_at_something() -> None:
    for check in (check_space, check_group, check_problem, check_method):
        for value in (3, None, "Sphere", gi.Sphere):
            with pytest.raises(gi.DomainError, match=r"expected a geomint\."):
                check(value)
    resting = gi.field(lambda params, t, y, out, work: None)
    problem = gi.Problem("p", space=gi.Euclidean(1), field=resting)
    for check, *args in (
        (check_space, gi.Sphere(2), 0),
        (check_group, gi.translations(2), 2, 0),
        (check_problem, problem, 0),
        (check_problem, problem, []),
    ):
        with pytest.raises(gi.DomainError, match="a whole number ≥ 1"):
            check(*args)


# --- what is admitted -----------------------------------------------------------------------------


@given(st.integers(2, 7), st.integers(-300, 300))
def test_directions_of_any_length(n: int, power: int) -> None:
    """γ/|γ| and the tangent part of p, without overflow; parallel to rounding is refused."""
    space, rng, size = gi.TangentSphere(n), np.random.default_rng(n), 10.0**power
    gamma, p = rng.normal(size=(2, n))
    with pytest.warns(gi.GeomintWarning, match="the state uses"):
        y = space.project(gamma=size * gamma, p=size * p)
    q, v = y[:n], y[n:] / size
    np.testing.assert_allclose(q, gamma / np.linalg.norm(gamma), rtol=0, atol=1e-15)
    np.testing.assert_allclose(v, p - (q @ p) * q, rtol=0, atol=1e-14)
    for small in (0.0, 1e-12):
        away = q + small * v / np.linalg.norm(v)
        with pytest.raises(gi.DomainError, match="not parallel to gamma"):
            space.project(gamma=q, p=size * away)
    rest = space.project(gamma=q, p=np.zeros(n))
    np.testing.assert_array_equal(rest, [*q, *np.zeros(n)])


@pytest.mark.parametrize("defect", [1e-12, 3e-7])
def test_repairs_say_what_and_by_how_much(defect: float) -> None:
    y = gi.Sphere(3, "q").point([0.6, 0.0, 0.8])
    with pytest.warns(gi.GeomintWarning, match=rf"\|q\|² − 1 of the state is {2 * defect:.2g}"):
        gi.Sphere(3, "q").admit((1.0 + defect) * y)
    frame = np.eye(3).ravel() * (1.0 + defect)
    with pytest.warns(gi.GeomintWarning, match="largest entry of gᵀg − 1 of the state"):
        np.testing.assert_allclose(gi.Rotations(3).admit(frame), np.eye(3).ravel(), atol=1e-15)
    with pytest.warns(gi.GeomintWarning, match="the vectors X are not orthonormal"):
        gi.Stiefel(3, 2).point(frame[:6])


@pytest.mark.parametrize(
    ("space", "components", "text"),
    [
        (gi.Sphere(3), {"gamma": [0, 0, 0]}, "not zero"),
        (gi.Sphere(3), {}, "gamma is missing"),
        (gi.Sphere(3), {"gamma": [0, 0, 1], "gama": 1}, "Did you mean 'gamma'"),
        (gi.Rotations(2), {"g": [[0, 1], [1, 0]]}, "determinant 1"),
        (gi.Rotations(2), {"g": [[2, 0], [0, 2]]}, "a rotation matrix; the largest entry"),
        (gi.Skew(3), {"k": np.eye(3)}, "skew-symmetric"),
        (gi.Skew(3), {"k": [1, 2]}, "3 numbers"),
        (gi.Stiefel(3, 2), {"X": [[1, 0, 0], [2, 0, 0]]}, "2 linearly independent"),
        (gi.TangentSphere(2), {"gamma": [0, 1]}, "p is missing"),
        (gi.Sphere(3) * gi.Euclidean(1), {"gamma": [0, 0, 1]}, "x is missing"),
        (gi.Sphere(3) * gi.Euclidean(1), {"gamma": [0, 0, 1], "x": 1, "y": 1}, "y = 1"),
    ],
)
def test_what_describes_no_point(space: gi.Space, components: dict, text: str) -> None:
    with pytest.raises(gi.DomainError, match=text):
        space.project(**components)


def test_what_is_no_space() -> None:
    for make, *values in (
        (gi.Sphere, 1),
        (gi.Sphere, 3, ""),
        (gi.Euclidean, 0),
        (gi.Euclidean, 2, "x", 1),
        (gi.Stiefel, 3, 4),
        (gi.Stiefel, 3, None),
        (gi.Product,),
        (gi.Product, gi.Sphere(3), 3),
        (gi.Product, gi.Sphere(3), gi.Sphere(3)),
        (gi.TangentSphere, 3, ("p", "p")),
        (gi.TangentBundle, gi.TangentSphere(3), "v"),
        (gi.TangentBundle, Twice(), "v"),
    ):
        with pytest.raises(gi.DomainError):
            make(*values)


def test_a_tangent_vector_too_long_is_refused() -> None:
    for length in (1.0, 1e300):
        with pytest.raises(gi.DomainError, match="a shorter vector"):
            gi.Sphere(2).retract(np.array([1.0, 0.0]), np.array([-length, 0.0]))


# --- groups of spaces -----------------------------------------------------------------------------


def told(group: gi.Group) -> tuple:
    return group.name, group.layout.tolist(), group.functions


def test_neighbours_turn_together() -> None:
    """One SO(n) for factors of one n, one kernel with translations behind them, else a product."""
    space = gi.Skew(4) * gi.Sphere(4) * gi.Rotations(4) * gi.Euclidean(3, "r") * gi.Euclidean(1)
    pieces = "adjoint", "vector", "frame"
    assert told(space.group) == told(gi.so_n(4, *pieces) * gi.translations(4))
    assert space.group.name == "SO(4) × R^4"
    assert (gi.Sphere(3) * gi.Sphere(4, "w")).group.name == "SO(3) × SO(4)"
    turning = gi.field(lambda params, t, y, out, work: None)
    assert told(gi.TangentSphere(3).action(turning).group) == told(gi.so3(2))
    four = gi.TangentSphere(4).action(turning).group
    assert told(four) == told(gi.so_n(4, "vector", "vector"))
    no_group = gi.TangentBundle(gi.Euclidean(2), "v")
    assert no_group.group is None
    with pytest.raises(gi.FormError, match="no group"):
        no_group.action(turning)


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_garbage_is_refused_by_name(space: gi.Space) -> None:
    """As states and as vectors, by every method that takes them; lists are taken as arrays are."""
    y = space.join(space.random(np.random.default_rng(4)))
    assert space.admit(list(y)).tobytes() == space.admit(y=y).tobytes() == y.tobytes()
    of_states = (space.admit, space.split, space.defects, space.normals)
    of_vectors = (space.tangent, space.distance, space.retract)
    garbage = np.nan * y, y + np.inf, np.append(y, 1.0), y[:-1], 1j * y, np.ma.masked_equal(y, y[0])
    for value in (*garbage, None, "x", []):
        for method in of_states:
            with pytest.raises(gi.DomainError, match=r"\w = "):
                method(value)
        for method in of_vectors:
            with pytest.raises(gi.DomainError, match=r"\w = "):
                method(y, value)
    with pytest.raises(gi.DomainError, match="shorter vector") if space.conditions else nothing():
        space.retract(y, np.full(len(y), 1e300))


def test_products_admit_by_the_admit_of_a_mixin():
    class Rounded:
        def admit(self, y):
            return np.round(y)

    class Grid(Rounded, gi.Euclidean):
        pass

    assert (Grid(1) * Grid(1, "z")).admit([1.2, 2.9]).tolist() == [1.0, 3.0]
