"""Groups and their products, held to the public suite."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

import geomint as gi
from geomint.testing import check_group

pytestmark = pytest.mark.nojit
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
def test_every_group_is_one(group: gi.Group) -> None:
    check_group(group, group.rows)


def helper(function):
    """Return a function of ξ (or a second vector x) and y that gives each number of the result."""

    @gi.helper
    def written(layout, x, y, out, work):
        for i in range(3):
            out[i] = function(x, y, i)

    return written


@gi.helper
def shifts(layout, xi, y, out, work):
    for i in range(len(y)):
        out[i] = 1e-9 + 0.0 * y[i]


backwards = helper(
    lambda x, y, i: y[(i + 1) % 3] * x[(i + 2) % 3] - y[(i + 2) % 3] * x[(i + 1) % 3]
)
squared = helper(lambda x, y, i: x[i] * y[i])
unlike = helper(lambda x, y, i: y[i] + 0.1 * x[i])
unwritten = gi.helper(lambda layout, xi, y, out, work: out.__setitem__(0, 0.0 * y[0]))


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"act": shifts, "cayley": None}, "moves a state where ξ is 0"),
        ({"act": unwritten, "cayley": None}, "leaves rows unwritten"),
        ({"act": gi.so3(2).cayley}, "is not exp"),
        ({"bracket": squared}, r"\[x, y\] \+ \[y, x\]"),
        ({"bracket": backwards}, "the bracket .* is not that of its action"),
        ({"cayley": gi.translations(3).act, "dcayinv": None}, "cay|unwritten"),
        ({"dexpinv": unlike}, "dexpinv .* is not the inverse differential"),
        ({"dcayinv": gi.so3(2).dexpinv}, "dcayinv .* is not the inverse differential"),
        ({"rows": 5}, "acts on 5 rows"),
    ],
)
def test_a_broken_group_is_noticed(changes: dict, text: str) -> None:
    with pytest.raises(AssertionError, match=text):
        check_group(replace(gi.so3(2), **changes), 6)


def test_factors_need_their_rows() -> None:
    with pytest.raises(gi.DomainError, match="the length of the states"):
        replace(gi.so3(2), rows=None) * gi.translations(1)


@pytest.mark.parametrize(("one", "other"), [(4, 5), (4, 3), (3, 4), (2, 3)])
def test_coordinates_of_a_product_end_with_those_of_either_factor(one: int, other: int) -> None:
    """Turns too large for coordinates fail a step, in either factor; not in SO(3), SO(2)."""
    space = gi.Sphere(one) * gi.Sphere(other, "w")
    first, second = (gi.so3(1) if n == 3 else gi.so_n(n, "vector") for n in (one, other))
    sizes = one * (one - 1) // 2, other * (other - 1) // 2

    @gi.field
    def turning(params, t, y, out, work):
        for i in range(sum(sizes)):
            out[i] = params[int(i >= sizes[0])] + 0.0 * y[0]

    for long, n in enumerate((one, other)):
        params = [10.0, 1e-3][:: -1 if long else 1]
        action = gi.GroupAction(turning, first * second)
        problem = gi.Problem("t", space=space, params=params, action=action)
        with pytest.raises(gi.StepSizeError) if n > 3 else nullcontext():
            y0 = problem.random_state(1)
            gi.solve(problem, y0, t_end=1.0, step=1.0, method="rkmk-4", compiled=False)


@gi.field
def turning_and_shifting(params, t, y, out, work):
    for i in range(3):
        out[i] = params[i] * (1.0 + 0.5 * gi.cos(t)) + 0.2 * y[i] * y[3]
    out[3] = y[0] * y[1]


def test_methods_take_products() -> None:
    """SO(3) × R by joined functions and by the kernel of SO(n) × R^m are one motion."""

    def generator(params, t, y, out, work):
        turning_and_shifting(params, t, y, out, work)
        first = out[0]
        out[0] = -out[2]
        out[2] = -first

    ends = []
    for group, xi in (
        (gi.so3(1) * gi.translations(1), turning_and_shifting),
        (gi.so_n(3, "vector") * gi.translations(1), gi.field(generator)),
    ):
        problem = gi.Problem(
            "screw",
            space=gi.Sphere(3) * gi.Euclidean(1, "s"),
            params=[0.3, -0.4, 0.8],
            action=gi.GroupAction(xi, group),
        )
        for method in ("cf-4", "rkmk-4", "rkmk-cayley-4"):
            y0 = [0.6, 0.0, 0.8, 0.1]
            plain = {"t_end": 1.0, "step": 0.02, "compiled": False}
            ends.append(gi.solve(problem, y0, method=method, **plain).y[-1])
    for end in ends:
        assert abs(end[:3] @ end[:3] - 1.0) < 1e-14
        np.testing.assert_allclose(end, ends[0], rtol=0, atol=1e-7)
    np.testing.assert_allclose(ends[3:], ends[:3], rtol=0, atol=1e-14)
