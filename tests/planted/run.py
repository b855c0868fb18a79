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
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from tests.planted.faults import FAULTS, ROOT, Fault

ROWS = {"fast": [], "nightly": ["-m", ""]}
OWN = ("tests/planted", "tests/test_weight.py")  # which see every change, for no user's sake
LEFT_OUT = shutil.ignore_patterns("__pycache__", ".*_cache", "_build", "results", "*.nc", ".venv")
LIMITS = {"narrow": 900.0, "row": 1800.0}  # seconds
FIRST = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)


class Job(NamedTuple):
    """A file of the checkout with other content, the tests that should see it, and what is told."""

    name: str
    path: Path
    source: str
    folders: tuple[str, ...]
    told: Mapping[str, Any]


def job_of(fault: Fault) -> Job:
    """Return what is to be run for a planted fault."""
    told = {key: getattr(fault, key) for key in ("place", "risk", "old", "new")}
    return Job(fault.name, fault.path, fault.source(), (f"tests/{fault.folder}",), told)


class Copy:
    """A checkout of its own, with compiled code of its own."""

    def __init__(self, home: Path, processes: str) -> None:
        self.root, self._processes = home / "checkout", processes
        shutil.copytree(ROOT, self.root, ignore=LEFT_OUT, symlinks=True)
        self._cache = home / "cache"
        own = {"PYTHONPATH": str(self.root / "src"), "NUMBA_CACHE_DIR": str(self._cache)}
        self._environment = {**os.environ, "MPLBACKEND": "Agg", **own}

    def look(self, job: Job, row: str, narrow: bool) -> dict[str, Any]:
        """Return whether a fault is seen, and by what."""
        place, begun = self.root / job.path, time.monotonic()
        before, kept = place.read_text("utf-8"), set(self._cache.glob("geomint/*"))
        place.write_text(job.source, "utf-8")
        try:
            seen = self._seen(job, self._files(job), ROWS[row], LIMITS["narrow"])
            if seen is None and not narrow:
                seen = self._seen(job, ["tests"], ROWS[row], LIMITS["row"])
        finally:
            place.write_text(before, "utf-8")
            if "kernels" in job.path.parts:  # compiled code of which nothing else runs
                for folder in set(self._cache.glob("geomint/*")) - kept:
                    shutil.rmtree(folder, ignore_errors=True)
        found = {"name": job.name, "row": row, "narrow": narrow, "by": seen, **job.told}
        return found | {"file": str(job.path), "seconds": round(time.monotonic() - begun)}

    def _files(self, job: Job) -> list[str]:
        """Return the files of its folders, first those that speak of the same things."""
        place = str(job.told["place"]).partition(":")[2]
        words = {w for w in re.split(r"\W|_", f"{job.path.stem}_{place}".lower()) if len(w) > 3}
        files: dict[str, float] = {}
        for folder in job.folders:
            home = self.root / folder
            for path in sorted(home.rglob("test_*.py")) if home.is_dir() else [home]:
                text = path.read_text("utf-8").lower()
                score = sum(min(text.count(w), 9) for w in words) / (2000 + len(text))
                files[str(path.relative_to(self.root))] = score
        return sorted(files, key=lambda file: -files[file])

    def _seen(
        self, job: Job, tests: Iterable[str], more: Sequence[str], limit: float
    ) -> str | None:
        """Return the first test that fails, or None if all pass."""
        ignored = [f"--ignore={path}" for path in OWN]
        options = ["-x", "-q", "-p", "no:cacheprovider", "-n", self._processes, *ignored, *more]
        code, said = self._run(["-m", "pytest", *options, *tests], limit)
        first = FIRST.search(said)
        if code == 0:
            return None
        if code is None:
            return f"hangs: still running after {limit:g} s"
        if code < 0:
            return f"{signal.Signals(-code).name}"
        if code == 1 or (code == 2 and first):
            return first[1] if first else "?"
        module = str(job.told["place"]).partition(":")[0]
        if self._run(["-c", f"import geomint, {module}"], limit)[0]:  # as `conftest.py` does
            return "cannot be imported"
        raise RuntimeError(
            f"pytest ended with {code}, which is no failure of a test:\n{said[-3000:]}"
        )

    def _run(self, arguments: Sequence[str], limit: float) -> tuple[int | None, str]:
        """Return the exit code, None after `limit` seconds, and the output."""
        process = subprocess.Popen(
            [sys.executable, *arguments], cwd=self.root, env=self._environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True, errors="replace",
        )  # fmt: skip
        try:
            said, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            return None, ""
        else:
            return process.returncode, said
        finally:  # with all that it has started
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def run(jobs: Sequence[Job], given: argparse.Namespace) -> list[dict[str, Any]]:
    """Run what is not yet known, tell and keep what is found, and return all of it."""
    out: Path = given.out
    known = {r["name"]: r for r in (json.loads(out.read_text("utf-8")) if out.exists() else [])}
    mode = {"row": given.row, "narrow": given.narrow}
    own = {
        job.name: known[job.name]
        for job in jobs
        if job.name in known
        and job.name not in getattr(given, "names", ())
        and all(known[job.name][key] == value for key, value in (job.told | mode).items())
    }
    copies: queue.SimpleQueue[Copy] = queue.SimpleQueue()

    def found(job: Job) -> dict[str, Any]:
        copy = copies.get()
        try:
            return copy.look(job, **mode)
        finally:
            copies.put(copy)

    pool = ThreadPoolExecutor(given.workers)
    with tempfile.TemporaryDirectory(prefix="planted-") as home, contextlib.ExitStack() as ends:
        ends.callback(pool.shutdown, cancel_futures=True)
        for k in range(given.workers):
            copies.put(Copy(Path(home, str(k)), given.processes))
        for result in pool.map(found, [job for job in jobs if job.name not in own]):
            own[result["name"]] = known[result["name"]] = result
            out.write_text(json.dumps([*known.values()], indent=1, ensure_ascii=False), "utf-8")
            print(
                f"{result['name']:30}{result['seconds']:5} s  {result['by'] or 'SLIPS'}", flush=True
            )
    return [own[job.name] for job in jobs]


def wilson(seen: int, count: int) -> tuple[float, float]:
    """Return the interval that has the true share with 95 %, by Wilson's score."""
    z = 1.959963984540054
    centre = (seen + 0.5 * z * z) / (count + z * z)
    half = z / (count + z * z) * math.sqrt(seen * (count - seen) / count + 0.25 * z * z)
    return centre - half, centre + half


def summary(results: Sequence[Mapping[str, Any]]) -> str:
    """Return the share that is seen, and what slips."""
    slipped = [r for r in results if r["by"] is None]
    seen, count = len(results) - len(slipped), len(results)
    low, high = wilson(seen, count)
    lines = [f"seen: {seen} of {count}, {seen / count:.1%} (95 %: {low:.1%} to {high:.1%})"]
    for r in slipped:
        lines += [f"slips: {r['name']}: {r['risk']}", f"  {r['file']}, {r['place']}"]
        lines += [f"  - {r['old']}", f"  + {r['new']}"]
    return "\n".join(lines)


def options(out: str) -> argparse.ArgumentParser:
    """Return what both commands take."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--row", choices=ROWS, default="fast")
    parser.add_argument("--narrow", action="store_true", help="only the folders that should see it")
    parser.add_argument("--workers", type=int, default=1, help="copies of the checkout at once")
    parser.add_argument("--processes", default="0", help="of each row, `-n` of pytest")
    parser.add_argument("--out", type=Path, default=Path(out))
    return parser


def tell(jobs: Sequence[Job], given: argparse.Namespace) -> None:
    """Run all; end with code 1 if something slips."""
    results = run(jobs, given)
    print(summary(results))
    sys.exit(any(r["by"] is None for r in results))


if __name__ == "__main__":
    parser = options("planted.json")
    parser.add_argument("names", nargs="*", metavar="NAMES")
    given = parser.parse_args()
    tell([job_of(FAULTS[name]) for name in given.names or FAULTS], given)
