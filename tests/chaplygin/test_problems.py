"""Every problem that is made here is held to the public suite of geomint, and every space."""

from __future__ import annotations

import pytest

from chaplygin.related.ellipsoid import Ellipsoid
from geomint import TangentBundle
from geomint.testing import check_problem, check_space
from tests.chaplygin.support import CASES

SMALL = [case for case in CASES if case.sphere.n < 5 and "attitude" not in case.label]


@pytest.mark.parametrize("case", SMALL, ids=str)
def test_every_problem_is_one(case) -> None:
    one = "spatial-momentum" in case.problem.constraints  # k_0 is that of one state
    check_problem(case.problem, [case.y] if one else 2)


SPACES = {repr(case.problem.space): case.problem.space for case in SMALL}
SPACES["another ellipsoid"] = TangentBundle(Ellipsoid((0.3, 1.0, 2.5, 7.0)), "v")


@pytest.mark.parametrize("space", SPACES.values(), ids=SPACES)
def test_every_space_is_one(space) -> None:
    check_space(space, 2)
