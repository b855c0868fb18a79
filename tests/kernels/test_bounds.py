"""With ``NUMBA_BOUNDSCHECK=1`` every row index and every part is checked, in lanes too."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import numpy as np
from numba.core import types

import geomint as gi
from geomint.kernels.compiling import cache
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import LANE, SCALAR
from geomint.kernels.numbers.blocks import Block, LaneBlock, as_lanes, fixed_rows

assert cache.cache_folder().path.name.endswith("-boundscheck")


@gi.helper
def looked(y, out, way, i, n):
    if way == 0:
        out[0] = y[i]
    elif way == 1:
        out[i] = y[0]
    elif way == 2:
        out[0] = 1.0 * len(gi.part(y, i, n))
    elif way == 3:
        out[0] = gi.part(y, 0, n)[i]
    else:
        out[0] = fixed_rows(y, 2)[i]


@gi.helper
def as_lane_rows(y, out, way, i, n):
    out[0] = 1.0 * len(as_lanes(y, i, n))


def compiled(function, block):
    return compile_function(function, types.void(block, block, *[types.int64] * 3))


def outcomes(entry, make, way, cases):
    found = ""
    for i, n in cases:
        try:
            entry(make(), make(), way, i, n)
            found += "o"
        except IndexError:
            found += "x"
    return found


rows = [(0, 0), (3, 0), (4, 0), (-1, 0), (10**9, 0)]
parts = [(0, 4), (1, 3), (4, 0), (0, 5), (4, 1), (-1, 2), (2, -1), (5, 0)]
CASES = [
    *[(rows, "ooxxx")] * 2,
    (parts, "oooxxxxx"),
    ([(1, 2), (2, 2), (3, 2)], "oxx"),  # past the part
    ([(1, 0), (2, 0)], "ox"),  # past the fixed rows
]
for kind, make in (
    (LANE, lambda: LaneBlock(np.zeros((4, 8)))),
    (SCALAR, lambda: Block(np.zeros(4))),
):
    entry = compiled(looked, kind.block)
    for way, (cases, wanted) in enumerate(CASES):
        assert outcomes(entry, make, way, cases) == wanted, (kind, way)
lanes, entry = [(0, 2), (3, 1), (9, 1), (0, 3), (-1, 1)], compiled(as_lane_rows, SCALAR.block)
assert outcomes(entry, lambda: Block(np.zeros(16)), 0, lanes) == "ooxxx"


@gi.field
def wrong(params, t, y, out, work):
    out[0] = 1.0 + 0.0 * y[0]
    work[0] = y[0]
    if gi.top(work[0]) > 0.5:  # not at the start: the check of declarations cannot see it
        out[0] = y[1]


try:
    problem = gi.Problem("one", (("y", 1),), field=wrong, work=1)
    gi.solve(problem, [0.0], t_end=1.0, method="rk-4", step=0.1)
except IndexError:
    print("checked")
"""
KERNELS = """
import geomint as gi
from tests.problems import examples

families = {}
for name in gi.method_names():
    method = gi.find_method(name)
    families.setdefault((type(method), method.needs, method.adaptive), method)
runs = dict.fromkeys(families, 0)
for problem, y0 in examples():
    for family, method in families.items():
        if method.needs in problem.forms and runs[family] < 2:
            watched = list(problem.invariants) if runs[family] else "all"
            gi.solve(problem, y0, t_end=0.2, step=0.05, method=method, observe=watched)
            runs[family] += 1
print(sorted(set(runs.values())))
"""
ROOT = str(Path(__file__).parents[2])


@pytest.mark.parametrize(
    ("script", "said"),
    [(SCRIPT, "checked"), pytest.param(KERNELS, "[2]", marks=pytest.mark.nightly)],
)
def test_bounds_are_checked(script: str, said: str, tmp_path: Path) -> None:
    """An IndexError reaches the caller, through steppers too; no family of methods raises one."""
    path = tmp_path / "script.py"
    path.write_text(script, encoding="utf-8")
    places = os.pathsep.join([ROOT, os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "NUMBA_BOUNDSCHECK": "1", "PYTHONPATH": places}
    done = subprocess.run(
        [sys.executable, str(path)], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stdout == f"{said}\n"
