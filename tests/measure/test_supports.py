"""Rows that conditions depend on: gradients are 0 elsewhere, and reflections have rows enough."""

from __future__ import annotations

import numpy as np
import pytest
from exact_maps import PROBLEMS

import geomint as gi
from geomint.kernels.compiling.recorded import Recorded, helper
from geomint.methods.supports import find_supports
from geomint.problems.derivatives import slopes_of
from geomint.problems.problem import Problem
from geomint.scene.load import scene_names

SCENES = {name: gi.load_scene(name) for name in scene_names()}
KNOWN = {name: (scene.problem, scene.state) for name, scene in SCENES.items()} | PROBLEMS
WITH_CONDITIONS = {name: p for name, (p, _) in KNOWN.items() if p.measure and p.measure.conditions}


def supports(problem: Problem, f: Recorded | None, m: int) -> list[np.ndarray]:
    """Return what is found, after checks that hold of any."""
    lows, pivots, ends, free, most = find_supports(problem, f, m, np.full(problem.rows, 0.5))
    assert ((lows <= pivots) & (pivots < ends)).all()
    assert sorted([*pivots, *free]) == list(range(problem.rows))
    assert most[0] == max(ends - lows, default=0)
    for a in range(m):  # what a reflection of one changes of another, the latter has rows for
        for b in range(m):
            assert (lows[a], ends[a]) == (lows[b], ends[b]) or min(ends[a], ends[b]) <= max(
                lows[a], lows[b]
            )
    return [lows, pivots, ends]


@pytest.mark.parametrize("name", WITH_CONDITIONS)
def test_gradients_are_zero_elsewhere(name: str) -> None:
    p = WITH_CONDITIONS[name]
    m = p.measure.conditions
    lows, _, ends = supports(p, p.measure.manifold, m)
    y = np.random.default_rng(3).normal(size=p.rows)
    for a, row in enumerate(slopes_of(p, p.measure.manifold, y, 0.3, m)):
        assert set(np.flatnonzero(row)) <= set(range(lows[a], ends[a]))


def test_pieces_apart_are_apart() -> None:
    p = WITH_CONDITIONS["ball-3d"]
    lows, pivots, ends = supports(p, p.measure.manifold, 7)
    assert [*zip(lows, pivots, ends, strict=True)] == [
        (3, 3, 6),
        *((6, 6 + k, 15) for k in range(6)),
    ]


def written(*rules) -> Recorded:
    """Conditions, each of them a function of the state."""

    @helper
    def conditions(params, t, y, out, work):
        for a, rule in enumerate(rules):
            out[a] = rule(y)

    return conditions


PIECES = WITH_CONDITIONS["ball-3d"]  # k, gamma, g: 3, 3 and 9 rows


def whole(y):
    return 0.0 * int(y[4]) + y[0]


@pytest.mark.parametrize(
    ("rules", "ranges"),
    [
        ([lambda y: y[1], lambda y: y[3], lambda y: y[14]], [(0, 3), (3, 6), (6, 15)]),
        ([lambda y: y[1] * y[14], lambda y: y[3]], [(0, 15), (0, 15)]),
        ([lambda y: y[1] * y[3], lambda y: y[4] * y[6]], [(0, 15), (0, 15)]),
        ([lambda y: 1.0], [(0, 15)]),  # of nothing
        ([lambda y: y[4]] * 4, [(0, 15)] * 4),  # more than there are rows
        ([lambda y: y[4], lambda y: y[4]], [(3, 6), (3, 6)]),
        ([whole], [(0, 15)]),  # no whole number of NaN
        ([], []),
    ],
)
def test_conditions_of_any_kind(rules: list, ranges: list[tuple[int, int]]) -> None:
    lows, _, ends = supports(PIECES, written(*rules) if rules else None, len(rules))
    assert [*zip(lows, ends, strict=True)] == ranges
