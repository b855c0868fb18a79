"""The floors of the work that is going on: each with its value, and whether it is met.

    python benchmarks/floors.py [NAME ...]

A name is that of a piece of work (``ground``, ``calls``) or of one floor (``calls.solve``); without
one all are measured. The exit code is 1 where a floor is not met.

Ratios are of new over old: this checkout, and the commit `BEFORE`, which is taken from git into the
user's cache folder. Both run on this machine in turns, by the packages of this environment. Calls
(`timed_calls.py`) are timed from 32 random states, from the second call on; of each state the median
counts, and of the states the geometric mean of the ratios; the worst is printed too. Nothing else may
run on the machine.
"""

from __future__ import annotations

import argparse
import functools
import io
import json
import os
import resource
import runpy
import statistics
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import platformdirs

from machine import describe

BEFORE = "16dabd600b4aba2abf1bce0d5a49bb5255f76a8e"  # before-redesign
ROOT = Path(__file__).resolve().parents[1]
CACHE = platformdirs.user_cache_path("geomint") / "floors"
ROUNDS, REPEATS = 5, 20
COLD = 8  # pairs of cold runs
DRIFT = ("-m", "geomint", "drift", "ball-3d", "--quiet")


class Found(NamedTuple):
    """A value that was measured, and what else is to be said."""

    value: float
    note: str = ""


class Floor(NamedTuple):
    """What a value may be at most."""

    most: float
    measure: Callable[[], Found]


@functools.cache
def before() -> Path:
    """Return the folder of the commit `BEFORE`."""
    folder = CACHE / BEFORE
    if not folder.exists():
        packed = subprocess.run(
            ["git", "archive", BEFORE], cwd=ROOT, check=True, capture_output=True
        ).stdout
        unfinished = Path(tempfile.mkdtemp(dir=_made(CACHE)))
        with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
            archive.extractall(unfinished, filter="data")
        unfinished.rename(folder)
    return folder


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def environment(checkout: Path, cache: Path) -> dict[str, str]:
    """Return the environment in which a process uses a checkout, with a cache of compiled code."""
    own = {"PYTHONPATH": str(checkout / "src"), "NUMBA_CACHE_DIR": str(cache), "MPLBACKEND": "Agg"}
    return {**os.environ, **own}


# --- calls ----------------------------------------------------------------------------------------


class Child:
    """A process that times calls in one checkout."""

    def __init__(self, checkout: Path) -> None:
        key = "new" if checkout == ROOT else BEFORE
        self._process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("timed_calls.py"))],
            env=environment(checkout, _made(CACHE / f"compiled-{key}")),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def times(self, row: str, repeats: int = REPEATS) -> list[float]:
        """Return for each state the median of the seconds of a call."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{row} {repeats}\n")
        self._process.stdin.flush()
        found: list[float] = json.loads(self._process.stdout.readline())
        return found


@functools.cache
def children() -> tuple[Child, Child]:
    """Return the processes of the old checkout and of this one."""
    return Child(before()), Child(ROOT)


@functools.cache
def timed(row: str) -> tuple[list[float], list[float]]:
    """Return the times of a call from many states, old and new."""
    both = children()
    for child in both:
        child.times(row, 1)
    rounds = [[child.times(row) for child in both] for _ in range(ROUNDS)]
    old, new = (
        [statistics.median(times) for times in zip(*each, strict=True)]
        for each in zip(*rounds, strict=True)
    )
    return old, new


def ratios(row: str) -> list[float]:
    """Return the times of a call, new over old, for each state."""
    return [b / a for a, b in zip(*timed(row), strict=True)]


def call(row: str) -> Found:
    """Return the time of a call, new over old."""
    found = ratios(row)
    medians = [1e6 * statistics.median(each) for each in timed(row)]
    note = f"worst {max(found):.3f}; {medians[0]:.4g} to {medians[1]:.4g} µs"
    return Found(statistics.geometric_mean(found), note)


def beside_steps() -> Found:
    """Return what a call with a tolerance takes beside its steps, new over old."""
    old, new = (
        [a - b for a, b in zip(*x, strict=True)]
        for x in zip(timed("tolerance"), timed("its-steps"), strict=True)
    )
    medians = [1e6 * statistics.median(each) for each in (old, new)]
    ratio = statistics.geometric_mean(b / a for a, b in zip(old, new, strict=True))
    return Found(ratio, f"{medians[0]:.4g} to {medians[1]:.4g} µs")


@functools.cache
def cold_drift() -> Found:
    """Return the processor seconds of a cold drift report, new over old."""
    pairs = []
    for i in range(COLD + 1):  # in turns: who comes first in one pair comes last in the next
        both = [before(), ROOT]
        seconds = {x: _cold_seconds(x) for x in (both if i % 2 else both[::-1])}
        pairs.append([seconds[x] for x in both])
    pairs = pairs[1:]  # the first compile the sources, too
    old, new = (statistics.median(each) for each in zip(*pairs, strict=True))
    ratio = statistics.median(b / a for a, b in pairs)
    return Found(ratio, f"{old:.2f} to {new:.2f} s")


def _cold_seconds(checkout: Path) -> float:
    """Return the processor seconds of one run with an empty cache of compiled code."""
    with tempfile.TemporaryDirectory() as folder:
        given = environment(checkout, Path(folder) / "cache")
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, *DRIFT, "--out", f"{folder}/report"]
        subprocess.run(command, env=given, cwd=folder, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime


# --- weight --------------------------------------------------------------------------------------


def weight(folder: str, what: str) -> Found:
    """Return how many files, lines or tokens of code there are in a folder."""
    return Found(weights()[folder][what])


@functools.cache
def weights() -> dict[str, dict[str, int]]:
    """Return the numbers that `.ci/weight.py` counts."""
    found: dict[str, dict[str, int]] = runpy.run_path(str(ROOT / ".ci" / "weight.py"))["weights"]()
    return found


# --- tests ----------------------------------------------------------------------------------------


def kept(name: str) -> Any:
    """Return what a benchmark of some twenty minutes wrote when it was last run."""
    return json.loads((ROOT / "benchmarks" / "results" / f"{name}.json").read_text("utf-8"))


def suite_seconds() -> Found:
    """Return the processor seconds of the fast row, new over old."""
    rows = kept("net")["rows"]
    old, new = (rows[name]["processor"] for name in ("before, cold", "now, cold"))
    return Found(new / old, f"{old:.0f} to {new:.0f} s when net.py was run last")


def suite_minutes(name: str) -> Found:
    """Return the minutes of the fast row."""
    return Found(kept("net")["rows"][name]["minutes"])


def whole_check() -> Found:
    """Return the minutes of `.ci/run` in a fresh clone."""
    with tempfile.TemporaryDirectory() as home:
        subprocess.run(["git", "clone", "-q", str(ROOT), home], check=True)
        begun = time.monotonic()
        subprocess.run([".ci/run"], cwd=home, check=True, capture_output=True)
        return Found((time.monotonic() - begun) / 60)


def slips(kind: str, row: str) -> Found:
    """Return the share of faults that the tests did not see, when they were last put in."""
    found = kept(kind)
    harmful = [r for r in found if not (r["by"] or "").startswith("harmless")]
    slipped = [r for r in harmful if r["by"] is None or r["row"] not in ("fast", row)]
    note = f"{len(slipped)} of {len(harmful)}; {len(found) - len(harmful)} more do no harm"
    return Found(len(slipped) / len(harmful), note)


def inner_modules() -> Found:
    """Return how many modules that are not public the tests import."""
    sys.path.insert(0, str(ROOT))
    from tests.test_inside import seen

    return Found(len({module for names in seen().values() for module, _ in names}))


def test_lines() -> Found:
    """Return the code lines of the tests, without the audit and the test problems."""
    weigh = runpy.run_path(str(ROOT / ".ci" / "weight.py"))["weigh"]
    paths = [p.relative_to(ROOT / "tests") for p in (ROOT / "tests").rglob("*.py")]
    own = [p for p in paths if p.parts[0] not in ("paper", "problems")]
    return Found(sum(weigh((ROOT / "tests" / p).read_text("utf-8"))[0] for p in own))


FLOORS: dict[str, dict[str, Floor]] = {
    "net": {
        "seconds": Floor(1 / 3, suite_seconds),
        "cold": Floor(4.0, lambda: suite_minutes("now, cold")),
        "warm": Floor(2.0, lambda: suite_minutes("now, warm")),
        "check": Floor(12.0, whole_check),
        "planted": Floor(0.05, lambda: slips("planted", "fast")),
        "planted-nightly": Floor(0.0, lambda: slips("planted", "nightly")),
        "drawn": Floor(0.2, lambda: slips("drawn", "fast")),
        "drawn-nightly": Floor(0.1, lambda: slips("drawn", "nightly")),
        "modules": Floor(60, inner_modules),
        "lines": Floor(32_000, test_lines),
    },
    "calls": {
        "solve": Floor(0.2, lambda: call("solve")),
        "observe": Floor(0.1, lambda: call("observe")),
        "physical-end": Floor(0.2, lambda: call("physical-end")),
        "tolerance": Floor(0.25, beside_steps),
        "integrator": Floor(1.0, lambda: call("integrator")),
        "steps": Floor(1.02, lambda: call("steps")),
        "cold-drift": Floor(0.95, cold_drift),
        "lines": Floor(44_100, lambda: weight("src", "lines")),
        "tokens": Floor(442_000, lambda: weight("src", "tokens")),
    },
}


@contextmanager
def quiet_line(text: str) -> Iterator[None]:
    """Show on a terminal what is being measured, until it is."""
    shown = sys.stderr.isatty()
    if shown:
        print(f"\r\x1b[K{text} …", end="", file=sys.stderr, flush=True)
    yield
    if shown:
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def main() -> int:
    """Measure the floors that are asked for."""
    known = {f"{work}.{name}": f for work, some in FLOORS.items() for name, f in some.items()}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join((*FLOORS, *known))}")
    names = parser.parse_args().names or list(FLOORS)
    chosen = [key for key in known if key in names or key.split(".")[0] in names]
    if unknown := [n for n in names if n not in FLOORS and n not in known]:
        parser.error(f"no such floor: {', '.join(unknown)}; one of {', '.join((*FLOORS, *known))}")
    machine = describe(["geomint", "numba", "numpy"])
    print(f"{machine['cpu']}, Python {machine['python']}, {machine['versions']}; old: {BEFORE}")
    print(f"{'floor':22} {'value':>10} {'at most':>10}  met")
    missed = 0
    for key in chosen:
        with quiet_line(key):
            found = known[key].measure()
        met = found.value <= known[key].most
        missed += not met
        value, most = (
            f"{x:.4g}" if x < 1e3 else f"{x:.0f}" for x in (found.value, known[key].most)
        )
        print(
            f"{key:22} {value:>10} {most:>10}  {'yes' if met else 'NO':3}  {found.note}", flush=True
        )
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
