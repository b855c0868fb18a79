"""Planted faults and drawn mutants apply to the code as it is; shares come with their interval."""

from __future__ import annotations

import ast

import pytest

from tests.planted.draw import drawn
from tests.planted.faults import FAULTS, ROOT
from tests.planted.run import summary, wilson


def test_every_fault_applies() -> None:
    """What no longer applies is listed: the commit that moved the code mends it."""
    lost = []
    for fault in FAULTS.values():
        try:
            fault.source()
        except (ValueError, SyntaxError) as error:
            lost.append(f"{fault.name}: {error}")
    assert not lost, "\n".join([f"{len(lost)} faults do not apply:", *lost])
    assert len(FAULTS) >= 65


def test_mutants_are_code_and_the_same_for_a_seed() -> None:
    few = [*drawn(2, 9, "src/geomint/kernels/solve")]
    assert few == [*drawn(2, 9, "src/geomint/kernels/solve")]
    mutants = [*few, *drawn(1, 60)]
    assert {m.risk for m in mutants} == {
        "sign", "comparison", "index", "dropped call", "swapped", "constant"
    }  # fmt: skip
    for mutant in mutants:
        before = (ROOT / mutant.path).read_text("utf-8")
        assert ast.dump(ast.parse(mutant.source)) != ast.dump(ast.parse(before))
        assert mutant.old != mutant.new


@pytest.mark.parametrize(("seen", "count"), [(0, 7), (3, 10), (95, 100), (60, 60)])
def test_interval_has_the_shares_that_the_test_of_the_score_keeps(seen: int, count: int) -> None:
    for p in wilson(seen, count):
        off = abs(seen / count - p)
        assert off == pytest.approx(1.96 * (p * abs(1.0 - p) / count) ** 0.5, rel=1e-4, abs=1e-7)


def test_summary_tells_the_share_and_what_slips() -> None:
    told = dict.fromkeys(("risk", "path", "place", "old", "new"), "x")
    found = summary([{"name": "one", "by": "a test", **told}, {"name": "two", "by": None, **told}])
    assert "1 of 2, 50.0% (95 %: 9.5% to 90.5%)" in found
    assert "slips: two" in found
