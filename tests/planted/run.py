"""Puts faults into copies of the checkout, and runs the tests that should see them.

    python -m tests.planted.run [NAMES] [--row fast|nightly] [--narrow] [--workers N] [--out FILE.json]

The folder of a fault runs first and stops at the first failure; only what slips runs the whole row.
A run that never ends counts as seen. Results are written as they come: with the same `--out` an
interrupted run goes on, and faults that are named run again.
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

# More arguments, and how many seconds of a processor the folder and the row may take.
ROWS: dict[str, tuple[list[str], int, int]] = {
    "fast": ([], 900, 3000),
    "nightly": (["-m", ""], 9000, 30_000),
}
OWN = ("tests/planted", "tests/test_weight.py")  # which see every change, for no user's sake
LEFT_OUT = shutil.ignore_patterns("__pycache__", ".*_cache", "_build", ".venv")
WAITING = 4.0  # times as many seconds of the clock
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
    folders: tuple[str, ...]

    @property
    def told(self) -> Result:
        """What is kept of it."""
        return {name: str(getattr(self, name)) for name in self._fields[:6]}


def job_of(fault: Fault) -> Job:
    """Return what is to be run for a planted fault."""
    name, folder, *told = fault
    return Job(name, *told, fault.path, fault.source(), (folder,))


def mode(given: argparse.Namespace) -> Result:
    """Return what a result depends on, beside the fault."""
    return {name: getattr(given, name) for name in ("row", "narrow", "files")}


class Copy:
    """A checkout of its own, with compiled code of its own."""

    def __init__(self, home: Path, given: argparse.Namespace) -> None:
        self.root, self._cache, self._given = home / "checkout", home / "cache", given
        shutil.copytree(ROOT, self.root, ignore=LEFT_OUT, symlinks=True)
        own = {"PYTHONPATH": str(self.root / "src"), "NUMBA_CACHE_DIR": str(self._cache)}
        self._environment = {**os.environ, "MPLBACKEND": "Agg", **own}

    def look(self, job: Job) -> Result:
        """Return whether a fault is seen, and by what."""
        place, begun = self.root / job.path, time.monotonic()
        more, folder, row = ROWS[self._given.row]
        before, compiled = place.read_bytes(), set(self._cache.glob("geomint/*"))
        place.write_text(job.source, "utf-8")
        try:
            seen = self._seen(job, [*more, *self._files(job)], folder)
            if seen is None and not self._given.narrow:
                seen = self._seen(job, [*more, "tests"], row)
        finally:
            place.write_bytes(before)
            if "kernels" in job.path.parts:  # compiled code that nothing else runs
                for own in set(self._cache.glob("geomint/*")) - compiled:
                    shutil.rmtree(own, ignore_errors=True)
        seconds = round(time.monotonic() - begun)
        return {**job.told, **mode(self._given), "by": seen, "seconds": seconds}

    def _files(self, job: Job) -> list[str]:
        """Return the files of its folders, first those that speak of the same things."""
        words = {word.lower() for word in re.findall("[A-Z]?[a-z]{4,}", job.place)}

        def alike(path: Path) -> float:
            text = path.read_text("utf-8").lower()
            counts = [min(text.count(w), 9) for w in words]
            return sum(w in path.stem for w in words) + sum(counts) / (2000 + len(text))

        homes = [self.root / "tests" / folder for folder in job.folders]
        found = [
            path for home in homes for path in (home, *home.rglob("test_*.py")) if path.is_file()
        ]
        return [*map(str, sorted(found, key=lambda path: (-alike(path), path)))][
            : self._given.files
        ]

    def _seen(self, job: Job, tests: list[str], limit: int) -> str | None:
        """Return the first test that fails, or None if all pass."""
        options = ["-x", "-q", "-p", "no:cacheprovider", "-n", self._given.processes]
        options += [f"--ignore={path}" for path in OWN]
        code, said = self._run(["-m", "pytest", *options, *tests], limit)
        first = FIRST.search(said)
        if code == 0:
            return None
        if code is None or code < 0:  # SIGXCPU: after `limit` seconds of a processor
            return f"hangs: no end after {limit} s" if code is None else signal.Signals(-code).name
        if code == 1 or (code == 2 and first):
            return first[1] if first else "?"
        needed = f"import geomint, {job.place.partition(':')[0]}"
        if self._run(["-c", needed], limit)[0]:  # by a `conftest.py` too
            return "cannot be imported"
        raise RuntimeError(f"pytest ended with {code}, not by a test that fails:\n{said[-3000:]}")

    def _run(self, arguments: Sequence[str], limit: int) -> tuple[int | None, str]:
        """Return the exit code, None if there is no end, and the output."""
        process = subprocess.Popen(
            [sys.executable, *arguments], cwd=self.root, env=self._environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True, errors="replace",
        )  # fmt: skip
        with contextlib.suppress(ProcessLookupError):
            resource.prlimit(process.pid, resource.RLIMIT_CPU, (limit, limit))
        try:
            said, _ = process.communicate(timeout=WAITING * limit)
            return process.returncode, said
        except subprocess.TimeoutExpired:
            return None, ""
        finally:  # with all that it has started
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def run(jobs: Sequence[Job], given: argparse.Namespace) -> list[Result]:
    """Run what is not yet known, tell and keep what is found, and return all of it."""
    known: dict[str, Result] = {}
    with contextlib.suppress(FileNotFoundError):
        known = {r["name"]: r for r in json.loads(given.out.read_text("utf-8"))}
    old = [j.name for j in jobs if (j.told | mode(given)).items() <= known.get(j.name, {}).items()]
    left = [job for job in jobs if job.name in given.names or job.name not in old]
    copies: list[Copy] = []

    def look(job: Job) -> Result:
        copy = copies.pop()
        try:
            return copy.look(job)
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
    parser.add_argument("--narrow", action="store_true", help="only the folders that should see it")
    parser.add_argument("--files", type=int, help="of these folders, the most: for a quick look")
    parser.add_argument("--workers", type=int, default=1, help="copies of the checkout at once")
    parser.add_argument("--processes", default="0", help="of each row: `-n` of pytest")
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
