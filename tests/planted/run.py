"""Puts faults into copies of the checkout, and runs the tests that should see them.

    python -m tests.planted.run [NAMES] [--row fast|nightly] [--narrow] [--workers N] [--out FILE.json]

All files of the row run up to the first failure: first those of the fault's folder, then those that run
the changed lines, which `tests.planted.reach` has found, and of them the quick ones. A test that never
ends counts as one that fails. Results are written as they come: with the same `--out` an interrupted
run goes on, a wider one tries what has slipped, and faults that are named run again. What does no harm
is kept there by hand, with "harmless: …" as what has seen it.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any, NamedTuple

from tests.planted.faults import FAULTS, ROOT, Fault

# More arguments, and how many seconds of a processor a test may take.
ROWS: dict[str, tuple[list[str], int]] = {"fast": ([], 300), "nightly": (["-m", ""], 1500)}
OWN = ("tests/planted", "tests/test_weight.py")  # which see every change, for no user's sake
LEFT_OUT = shutil.ignore_patterns("__pycache__", ".*_cache", "_build", ".venv")
WAITING = 2  # times as many seconds of the clock
FIRST = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - |$)", re.MULTILINE)
Result = dict[str, Any]


class Job(NamedTuple):
    """A file of the checkout with other content, and the tests that should see it."""

    name: str
    place: str
    risk: str
    old: str
    new: str
    path: Path
    source: str
    folder: str = "-"

    @property
    def told(self) -> Result:
        """What is kept of it."""
        return {name: str(getattr(self, name)) for name in self._fields[:6]}


def job_of(fault: Fault) -> Job:
    """Return what is to be run for a planted fault."""
    name, folder, *told = fault
    return Job(name, *told, fault.path, fault.source(), folder)


def is_done(job: Job, known: Result, given: argparse.Namespace) -> bool:
    """Tell whether a fault was seen, does no harm, or slipped through no fewer tests."""
    row, narrow = known.get("row"), known.get("narrow", True)
    slipped = row in (given.row, "nightly") and narrow <= given.narrow
    return job.told.items() <= known.items() and bool(known["by"] or slipped)


def pytest_runtest_setup() -> None:
    """End the process where a test does not end: this module is a plugin of the rows that it runs."""
    seconds, most = int(os.environ["PLANTED_SECONDS"]), resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + seconds, most))
    signal.alarm(WAITING * seconds)


class Reach:
    """Which files of tests run what."""

    def __init__(self, path: Path) -> None:
        if not path.exists():
            print("finding which tests run which lines …", flush=True)
            command = ["-m", "pytest", "-q", "-p", "tests.planted.reach", "--reach"]
            subprocess.run([sys.executable, *command, str(path.absolute())], cwd=ROOT, check=True)
        found = json.loads(path.read_text("utf-8"))
        self._lines, self._seconds = found["lines"], found["seconds"]

    def ordered(self, job: Job, narrow: bool) -> list[str]:
        """Return the files of tests in the order in which they should run."""
        old, new = ((ROOT / job.path).read_text("utf-8").splitlines(), job.source.splitlines())
        first, last = (_alike(*each) for each in ((old, new), (old[::-1], new[::-1])))
        changed = {*range(first + 1, len(old) - last + 1)}
        runs = {
            test: changed & {*lines} for file, test, lines in self._lines if file == str(job.path)
        }

        def rank(path: str) -> tuple[bool, bool, bool, float]:
            own = f"{path}/".startswith(f"tests/{job.folder}/")
            runs_it = path in runs and bool(runs[path] or runs.get(""))  # "": when it is imported
            return not own, not runs_it, path not in runs, self._seconds.get(path, 0.0)

        found = sorted(
            (str(p.relative_to(ROOT)) for p in ROOT.glob("tests/**/test_*.py")), key=rank
        )
        return [p for p in found if not (narrow and all(rank(p)[:2])) and not p.startswith(OWN)]


def _alike(one: Sequence[str], other: Sequence[str]) -> int:
    """Return how many lines are the same before the first that differs."""
    same = [x == y for x, y in zip(one, other, strict=False)]
    return [*same, False].index(False)


class Copy:
    """A checkout of its own, with compiled code of its own."""

    def __init__(self, home: Path, given: argparse.Namespace) -> None:
        self.root, self._cache, self._given = home / "checkout", home / "cache", given
        shutil.copytree(ROOT, self.root, ignore=LEFT_OUT, symlinks=True)
        known = Path(os.environ.get("NUMBA_CACHE_DIR", "none"))
        if known.is_dir():
            shutil.copytree(known, self._cache)
        own = {"PYTHONPATH": str(self.root / "src"), "NUMBA_CACHE_DIR": str(self._cache)}
        own |= {"PYTHONPYCACHEPREFIX": str(home / "pyc"), "PYTHONDONTWRITEBYTECODE": ""}
        own |= {"PLANTED_SECONDS": str(ROWS[given.row][1]), "MPLBACKEND": "Agg"}
        self._environment = {**os.environ, **own}

    def look(self, job: Job, tests: Sequence[str]) -> Result:
        """Return whether a fault is seen, and by what."""
        place, begun = self.root / job.path, time.monotonic()
        before, compiled = place.read_bytes(), set(self._cache.glob("geomint/*"))
        place.write_text(job.source, "utf-8")
        try:
            seen = self._seen(job, tests) if tests else None
        finally:
            place.write_bytes(before)
            if "kernels" in job.path.parts:  # compiled code that nothing else runs
                for own in set(self._cache.glob("geomint/*")) - compiled:
                    shutil.rmtree(own, ignore_errors=True)
        seconds = round(time.monotonic() - begun)
        asked = {name: getattr(self._given, name) for name in ("row", "narrow")}
        return {**job.told, **asked, "by": seen, "seconds": seconds}

    def _seen(self, job: Job, tests: Sequence[str]) -> str | None:
        """Return the first test that fails, or None if all pass."""
        options = ["-x", "-q", "-p", "no:cacheprovider", "-n", self._given.processes]
        options += ["-p", "tests.planted.run", *ROWS[self._given.row][0]]
        code, said = self._run(["-m", "pytest", *options, *tests])
        first = FIRST.search(said)
        if code == 0:
            return None
        if code < 0:  # SIGXCPU and SIGALRM: a test takes too long
            return signal.Signals(-code).name
        if code == 1 or (code == 2 and first):
            return first[1] if first else "?"
        needed = f"import geomint, {job.place.partition(':')[0]}"
        if self._run(["-c", needed])[0]:  # by a `conftest.py` too
            return "cannot be imported"
        raise RuntimeError(f"pytest ended with {code}, not by a test that fails:\n{said[-3000:]}")

    def _run(self, arguments: Sequence[str]) -> tuple[int, str]:
        """Return the exit code and the output."""
        process = subprocess.Popen(
            [sys.executable, *arguments], cwd=self.root, env=self._environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True, errors="replace",
        )  # fmt: skip
        limit = 3 * ROWS[self._given.row][1]  # where pytest only imports its tests
        with contextlib.suppress(ProcessLookupError):
            resource.prlimit(process.pid, resource.RLIMIT_CPU, (limit, resource.RLIM_INFINITY))
        try:
            said, _ = process.communicate()
            return process.returncode, said
        finally:  # with all that it has started
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def run(jobs: Sequence[Job], given: argparse.Namespace) -> list[Result]:
    """Run what is not yet known, tell and keep what is found, and return all of it."""
    # Shells let background jobs ignore Ctrl-C: its tests would fail, and every fault would be seen.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    known: dict[str, Result] = {}
    with contextlib.suppress(FileNotFoundError):
        known = {r["name"]: r for r in json.loads(given.out.read_text("utf-8"))}
    old = [job.name for job in jobs if is_done(job, known.get(job.name, {}), given)]
    left = [job for job in jobs if job.name in given.names or job.name not in old]
    copies, reach = list[Copy](), Reach(given.reach)

    def look(job: Job) -> Result:
        copy = copies.pop()
        try:
            return copy.look(job, reach.ordered(job, given.narrow))
        finally:
            copies.append(copy)

    pool = ThreadPoolExecutor(given.workers)
    with tempfile.TemporaryDirectory(prefix="planted-") as home, contextlib.ExitStack() as ends:
        ends.callback(pool.shutdown, cancel_futures=True)
        copies += [Copy(Path(home, str(k)), given) for k in range(given.workers if left else 0)]
        for future in as_completed([pool.submit(look, job) for job in left]):
            r = future.result()
            known[r["name"]] = r
            given.out.write_text(json.dumps([*known.values()], indent=1), "utf-8")
            print(f"{r['name']:30}{r['seconds']:5} s  {r['by'] or 'SLIPS'}", flush=True)
    return [known[job.name] for job in jobs]


def wilson(seen: int, count: int) -> tuple[float, float]:
    """Return the interval that has the true share with 95 %, by Wilson's score."""
    z = 1.959963984540054
    centre = (seen + 0.5 * z * z) / (count + z * z)
    half = z / (count + z * z) * math.sqrt(seen * (count - seen) / count + 0.25 * z * z)
    return centre - half, centre + half


def summary(results: Sequence[Mapping[str, Any]]) -> str:
    """Return the share that is seen, and what slips."""
    count, slipped = len(results), [r for r in results if r["by"] is None]
    seen = count - len(slipped)
    low, high = wilson(seen, count)
    lines = [f"seen: {seen} of {count}, {seen / count:.1%} (95 %: {low:.1%} to {high:.1%})"]
    for r in slipped:
        lines += [f"slips: {r['name']}: {r['risk']}", f"  {r['path']}, {r['place']}"]
        lines += [f"  - {r['old']}", f"  + {r['new']}"]
    return "\n".join(lines)


def options(out: str) -> argparse.ArgumentParser:
    """Return what both commands take."""
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", metavar="NAMES")
    parser.add_argument("--row", choices=ROWS, default="fast")
    parser.add_argument("--narrow", action="store_true", help="only what is known to run the lines")
    parser.add_argument("--workers", type=int, default=1, help="copies of the checkout at once")
    parser.add_argument("--processes", default="0", help="of each row: `-n` of pytest")
    parser.add_argument(
        "--reach", type=Path, default=Path("reach.json"), help="is written if missing"
    )
    parser.add_argument("--out", type=Path, default=Path(out))
    return parser


def tell(jobs: Sequence[Job], given: argparse.Namespace) -> None:
    """Run those that are named, or all; end with code 1 if something slips."""
    own = {job.name: job for job in jobs}
    results = run([own[name] for name in given.names] or jobs, given)
    print(summary(results))
    sys.exit(any(r["by"] is None for r in results))


if __name__ == "__main__":
    tell([*map(job_of, FAULTS.values())], options("planted.json").parse_args())
