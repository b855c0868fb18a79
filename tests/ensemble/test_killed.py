"""Writers of ensembles that are killed at any moment, and what they hold in memory."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.problems.testproblems import henon_heiles

ASKED = """
import numpy as np
import geomint as gi
from geomint.problems.testproblems import henon_heiles
HENON = henon_heiles.problem()
STATES = np.random.default_rng(2).uniform(-0.2, 0.2, (400, 4))
STATES[::50] = [0.0, 40.0, 0.0, 60.0]
RUN = dict(t_end=20.0, method="rk-4", step=0.05, workers=2, keep_states=True, save_every=20)
RUN["readings"] = ["drift:energy", gi.Histogram("q[0]", np.linspace(-1, 1, 9))]
"""
RUNS = f"""{ASKED}
import sys
from geomint.run.ensemble import spread
spread.LEAST = 8
print("begins", flush=True)
gi.solve_ensemble(HENON, STATES, **RUN, out=sys.argv[1])
"""


def killed(script: str, out: Path, after: float) -> bool:
    """Run a script and kill it so many seconds after its work has begun; tell whether it lived."""
    child = subprocess.Popen([sys.executable, "-c", script, str(out)], stdout=subprocess.PIPE)
    assert child.stdout is not None
    assert child.stdout.readline() == b"begins\n"
    time.sleep(after)
    lived = child.poll() is None
    child.kill()
    child.communicate()
    return lived


@pytest.mark.parametrize(
    ("rounds", "seed"),
    [(1, 1), *(pytest.param(12, seed, marks=pytest.mark.nightly) for seed in range(2, 6))],
)
def test_killed_at_random_moments(rounds: int, seed: int, tmp_path: Path) -> None:
    asked: dict = {}
    exec(ASKED, asked)
    run, states, out = asked["RUN"], asked["STATES"], tmp_path / "a.zarr"
    known = gi.solve_ensemble(asked["HENON"], states, **run)
    moments = np.random.default_rng(seed)
    before, lived = 0, 0
    for _ in range(rounds):
        lived += killed(RUNS, out, moments.uniform(0.0, 0.5))
        if not out.exists():
            continue
        seen = gi.open_ensemble(out)
        done = seen.status != "not run"
        assert done.sum() >= before
        before = done.sum()
        if "drift:energy" in seen.readings:
            of = seen.readings["drift:energy"][done]
            np.testing.assert_array_equal(of, known.readings["drift:energy"][done])
            np.testing.assert_array_equal(seen.y[done], known.y[done])
    assert lived
    found = gi.solve_ensemble(asked["HENON"], states, **run, out=out)
    for name in ("tau", "t", "y", "counts", "steps", "status"):
        np.testing.assert_array_equal(getattr(known, name), getattr(found, name))
    for name, numbers in known.readings.items():
        np.testing.assert_array_equal(numbers, found.readings[name])
    assert [*map(str, found.errors.values())] == [*map(str, known.errors.values())]
    assert not list(out.glob("**/*.partial"))
    assert [path.name for path in tmp_path.iterdir() if not path.name.startswith(".")] == ["a.zarr"]


MEASURED = """
import resource, sys
import numpy as np
import geomint as gi
from geomint.problems.testproblems import henon_heiles
from geomint.run.ensemble import spread

spread.NUMBERS_STREAMED = 1 << 18
states = np.random.default_rng(2).uniform(-0.2, 0.2, (int(sys.argv[2]), 4))
run = dict(method="rk-4", step=0.05, workers=2, progress=False, t_end=100.0, save_every=1)
gi.solve_ensemble(henon_heiles.problem(), states[:32], **run, out=sys.argv[1] + "-first")
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
many = gi.solve_ensemble(henon_heiles.problem(), states, **run, out=sys.argv[1])
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
assert many.success
print(after - before, many.found.arrays.size)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="peaks of memory are asked of Unix")
def test_states_of_all_members_are_never_in_memory(tmp_path: Path) -> None:
    """40 times a block, 120 MB: some copies of the blocks under way are there at a time."""
    rows, samples, members = 4, 2001, 1280
    given = [sys.executable, "-c", MEASURED, str(tmp_path / "a.zarr"), str(members)]
    grown, block = subprocess.run(given, check=True, capture_output=True).stdout.split()
    whole = members * samples * (rows + 2) * 8
    assert members >= 40 * int(block)
    assert int(grown) * 1024 < whole / 3
    some = gi.open_ensemble(tmp_path / "a.zarr")
    alone = gi.solve(henon_heiles.problem(), some.states[-1], t_end=100.0, method="rk-4", step=0.05)
    assert np.array_equal(some.stored["y"][-1, -1], alone.y[-1])
