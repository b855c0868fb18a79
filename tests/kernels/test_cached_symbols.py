"""Functions of one name that different processes compiled do not run for each other.

The field with and without the clock's row have one name and one signature; each is the first that
its process compiles.
"""

import os
import subprocess
import sys

import pytest

SOLVE = """
import sys
import geomint as gi

scene = gi.load_scene("hamiltonized-n3")
for clock in sys.argv[1:]:
    solution = gi.solve(
        scene.problem, scene.state, tau_end=5.0, step=0.25, clock=clock == "clock", progress=False
    )
    print(clock, solution.physical)
"""


def solved(cache, *clocks):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", SOLVE, *clocks]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


@pytest.mark.nightly
def test_cached_functions_of_one_name(tmp_path):
    with_clock = solved(tmp_path, "clock")[0]
    without = solved(tmp_path, "none")[0]
    assert float(with_clock.split("[")[1].rstrip("]")) > 10.0
    assert solved(tmp_path, "none", "clock") == [without, with_clock]
    assert solved(tmp_path, "clock", "none", "clock") == [with_clock, without, with_clock]
