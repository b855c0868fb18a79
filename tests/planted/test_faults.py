"""Planted faults and drawn mutants apply to the code as it is; shares come with their interval."""

from __future__ import annotations

import argparse
import ast
import json
from pathlib import Path

import pytest

from tests.planted.draw import drawn
from tests.planted.faults import FAULTS, ROOT
from tests.planted.run import Reach, is_done, job_of, summary, wilson


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
    mutants = [*few, *drawn(1, 60, "src/geomint/run")]
    assert {m.risk for m in mutants} == {
        "sign", "comparison", "index", "dropped call", "swapped", "constant"
    }  # fmt: skip
    for mutant in mutants:
        before = (ROOT / mutant.path).read_text("utf-8")
        assert ast.dump(ast.parse(mutant.source)) != ast.dump(ast.parse(before))


@pytest.mark.parametrize(("seen", "count"), [(0, 7), (3, 10), (95, 100), (60, 60)])
def test_interval_has_the_shares_that_the_test_of_the_score_keeps(seen: int, count: int) -> None:
    for p in wilson(seen, count):
        off = abs(seen / count - p)
        assert off == pytest.approx(1.96 * (p * abs(1.0 - p) / count) ** 0.5, rel=1e-4, abs=1e-7)


def test_what_was_seen_or_slipped_through_as_many_tests_is_done() -> None:
    job = job_of(next(iter(FAULTS.values())))
    for by, row, narrow, done in (
        *(("a test", "fast", True, True), ("harmless: a hint", "fast", True, True)),
        *((None, "fast", True, False), (None, "fast", False, True), (None, "nightly", False, True)),
    ):
        known = {**job.told, "row": row, "narrow": narrow, "by": by}
        assert is_done(job, known, argparse.Namespace(row="fast", narrow=False)) == done
        assert not is_done(
            job, {**known, "new": "other"}, argparse.Namespace(row="fast", narrow=True)
        )
        night = argparse.Namespace(row="nightly", narrow=False)
        assert is_done(job, known, night) == (done and bool(by or row == "nightly"))


def test_files_that_run_the_changed_lines_come_first(tmp_path: Path) -> None:
    fault = FAULTS["density-sign"]
    both = (ROOT / fault.path).read_text("utf-8").splitlines(), fault.source().splitlines()
    line = 1 + [x == y for x, y in zip(*both, strict=True)].index(False)
    runs, other = "tests/run/test_solve.py", "tests/run/test_dense.py"
    told = [(str(fault.path), runs, [line]), (str(fault.path), other, [line + 1])]
    path = tmp_path / "reach.json"
    path.write_text(json.dumps({"lines": told, "seconds": {}}), "utf-8")
    job = job_of(fault)._replace(folder="tableaux")
    own, *rest = [p for p in Reach(path).ordered(job, False) if not p.startswith("tests/tableaux/")]
    assert (own, rest[0]) == (runs, other)
    assert runs in Reach(path).ordered(job, True)
    assert other not in Reach(path).ordered(job, True)


def test_summary_tells_the_share_and_what_slips() -> None:
    told = dict.fromkeys(("risk", "path", "place", "old", "new"), "x")
    found = summary([{"name": "one", "by": "a test", **told}, {"name": "two", "by": None, **told}])
    assert "1 of 2, 50.0% (95 %: 9.5% to 90.5%)" in found
    assert "slips: two" in found
