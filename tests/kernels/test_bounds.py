"""With ``NUMBA_BOUNDSCHECK=1`` every row index and every part is checked, in lanes too."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import sys

import numpy as np
from numba.core import types

import geomint as gi
from geomint.kernels.numbers.blocks import Block, LaneBlock, as_lanes, fixed_rows, part
from geomint.kernels.compiling.cache import cache_folder
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.compiling.recorded import helper

assert cache_folder().path.name.endswith("-boundscheck")


@helper
def read(y, out, i, n):
    out[0] = y[i]


@helper
def write(y, out, i, n):
    out[i] = y[0]


@helper
def cut(y, out, i, n):
    out[0] = 1.0 * len(part(y, i, n))


@helper
def past_the_part(y, out, i, n):
    out[0] = part(y, 0, n)[i]


@helper
def past_the_fixed(y, out, i, n):
    out[0] = fixed_rows(y, 2)[i]


@helper
def as_lane_rows(y, out, i, n):
    out[0] = 1.0 * len(as_lanes(y, i, n))


def outcomes(function, kind, cases):
    block = LANE.block if kind == "L" else SCALAR.block
    entry = compile_function(function, types.void(block, block, types.int64, types.int64))
    make = (lambda r: LaneBlock(np.zeros((r, 8)))) if kind == "L" else (lambda r: Block(np.zeros(r)))
    found = ""
    for i, n in cases:
        try:
            entry(make(4), make(4), i, n)
            found += "o"
        except IndexError:
            found += "x"
    return found


rows = [(0, 0), (3, 0), (4, 0), (-1, 0), (10**9, 0)]
for kind in "SL":
    for function in (read, write):
        assert outcomes(function, kind, rows) == "ooxxx", (kind, function)
    parts = [(0, 4), (1, 3), (4, 0), (0, 5), (4, 1), (-1, 2), (2, -1), (5, 0)]
    assert outcomes(cut, kind, parts) == "oooxxxxx", kind
    assert outcomes(past_the_part, kind, [(1, 2), (2, 2), (3, 2)]) == "oxx", kind
    assert outcomes(past_the_fixed, kind, [(1, 0), (2, 0)]) == "ox", kind
entry = compile_function(
    as_lane_rows, types.void(SCALAR.block, SCALAR.block, types.int64, types.int64)
)
for i, n, good in ((0, 2, True), (3, 1, True), (9, 1, False), (0, 3, False), (-1, 1, False)):
    try:
        entry(Block(np.zeros(16)), Block(np.zeros(1)), i, n)
        assert good, (i, n)
    except IndexError:
        assert not good, (i, n)


@gi.field
def wrong(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    work[0] = y[0]
    if gi.top(work[0]) > 0.5:  # not at the start: the check of declarations cannot see it
        out[0] = y[1]


for method in ("rk-4", "gauss-2"):
    try:
        problem = gi.Problem("one", (("y", 1),), field=wrong, work=1)
        gi.solve(problem, [0.0], t_end=1.0, method=method, step=0.1)
    except IndexError:
        continue
    raise AssertionError(method)
print("checked")
"""


def test_bounds_are_checked(tmp_path: Path) -> None:
    """An IndexError reaches the caller, through steppers too."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1"}
    done = subprocess.run(
        [sys.executable, "-W", "error", str(script)],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout == "checked\n"


@pytest.mark.nightly
def test_kernels_stay_within_their_blocks(tmp_path: Path) -> None:
    """One method of each family on two problems, with every access checked; the measure once."""
    script = tmp_path / "script.py"
    script.write_text(
        """
import geomint as gi
from geomint.stress.sweep import family_of
from tests.problems import examples

families = {}
for name in gi.method_names():
    method = gi.find_method(name)
    families.setdefault((family_of(method), method.adaptive), method)
runs = dict.fromkeys(families, 0)
for problem, y0 in examples():
    for family, method in families.items():
        if method.needs in problem.forms and runs[family] < 2:
            watched = list(problem.invariants) if runs[family] else "all"
            gi.solve(problem, y0, t_end=0.2, step=0.05, method=method, observe=watched)
            runs[family] += 1
print(sorted(set(runs.values())))
""",
        encoding="utf-8",
    )
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1", "PYTHONPATH": root}
    done = subprocess.run(
        [sys.executable, str(script)], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout == "[2]\n"
