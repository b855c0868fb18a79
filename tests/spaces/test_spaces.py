"""Spaces: every one of them is held to the public suite, and what the suite cannot know is here."""

import pytest

import geomint as gi
from geomint.testing import check_group, check_space

pytestmark = pytest.mark.nojit
SPACES = [
    gi.Euclidean(1),
    gi.Euclidean(4, "v", turned=True),
    *(space(n) for n in (2, 3, 5, 7) for space in (gi.Sphere, gi.TangentSphere, gi.Skew)),
    *(gi.Rotations(n) for n in (2, 3, 4)),
    gi.RigidMotions(3),
    *(
        space(n, r)
        for n, r in ((3, 2), (4, 2), (4, 4))
        for space in (gi.Stiefel, gi.TangentStiefel)
    ),
    gi.TangentBundle(gi.Rotations(3), "m"),
    gi.Skew(3) * gi.Sphere(3) * gi.Rotations(3) * gi.Euclidean(2, "r"),
    gi.Sphere(3, "x") * gi.Sphere(3, "w"),
    gi.Euclidean(2, "r") * gi.TangentSphere(4) * gi.Euclidean(1, "s") * gi.Sphere(2, "w"),
]


@pytest.mark.parametrize("space", SPACES, ids=repr)
def test_every_space_is_one(space):
    check_space(space)
    assert eval(repr(space), vars(gi) | {name: getattr(gi, name) for name in gi.__all__}) == space


GROUPS = [
    gi.so3(2),
    gi.so_n(2, "vector"),
    *(gi.so_n(n, "vector", "adjoint", "frame") for n in (3, 4)),
    gi.translations(2),
    gi.so_n(4, "frame") * gi.translations(3),
    gi.so3(1) * gi.translations(2),
    gi.translations(2) * gi.so_n(3, "adjoint"),
    gi.so_n(2, "vector") * gi.so_n(4, "vector") * gi.so3(1),
]


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.name)
def test_every_group_is_one(group):
    check_group(group, group.rows)
