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
import shlex
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
        seconds = {x: _seconds(x) for x in (both if i % 2 else both[::-1])}
        pairs.append([seconds[x] for x in both])
    pairs = pairs[1:]  # the first compile the sources, too
    old, new = (statistics.median(each) for each in zip(*pairs, strict=True))
    ratio = statistics.median(b / a for a, b in pairs)
    return Found(ratio, f"{old:.2f} to {new:.2f} s")


def _seconds(checkout: Path, cache: Path | None = None) -> float:
    """Return the processor seconds of one report: with an empty cache, or else without its steps."""
    with tempfile.TemporaryDirectory() as folder:
        given = environment(checkout, cache or Path(folder) / "cache")
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, *DRIFT, "--out", f"{folder}/report"]
        subprocess.run(command, env=given, cwd=folder, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        record = json.loads((Path(folder) / "report" / "drift.json").read_text("utf-8"))
    (run,) = (method["run"] for method in record["methods"].values())
    steps = 0.0 if cache is None else run["run_seconds"] + run["watching_seconds"]
    seconds: float = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime - steps
    return seconds


# --- weight --------------------------------------------------------------------------------------


def weight(folder: str, what: str) -> Found:
    """Return how many files, lines or tokens of code there are in a folder."""
    return Found(weights()[folder][what])


@functools.cache
def weights() -> dict[str, dict[str, int]]:
    """Return the numbers that `.ci/weight.py` counts."""
    found: dict[str, dict[str, int]] = runpy.run_path(str(ROOT / ".ci" / "weight.py"))["weights"]()
    return found


# --- the outside ----------------------------------------------------------------------------------

ROOMS = ("scene", "plan", "compare", "reports", "stress", "plots", "cli")
ROOMS += ("testing", "scipy", "references")


def room_lines() -> Found:
    """Return the code lines of what is around the core."""
    weigh = runpy.run_path(str(ROOT / ".ci" / "weight.py"))["weigh"]
    src = ROOT / "src" / "geomint"
    rooms = {r: [p.read_text("utf-8") for p in (src / r).rglob("*.py")] for r in ROOMS}
    lines = {room: sum(weigh(text)[0] for text in texts) for room, texts in rooms.items()}
    return Found(sum(lines.values()), ", ".join(f"{room} {n}" for room, n in lines.items()))


def template_lines() -> Found:
    """Return the lines of templates that are not blank."""
    folder = ROOT / "src" / "geomint" / "reports" / "templates"
    texts = [path.read_text("utf-8") for path in folder.rglob("*") if path.is_file()]
    return Found(sum(bool(line.strip()) for text in texts for line in text.splitlines()))


def help_seconds() -> Found:
    """Return the seconds of ``geomint --help``: the median of ten."""
    given, times = environment(ROOT, CACHE / "compiled-new"), []
    for _ in range(11):
        begun = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "geomint", "--help"], env=given, check=True, capture_output=True
        )
        times.append(time.perf_counter() - begun)
    return Found(statistics.median(times[1:]))


def shown(page: str) -> list[Any]:
    """Return the blocks of a page of the documentation."""
    sys.path.insert(0, str(ROOT))
    from tests.pages import blocks

    return blocks.blocks(blocks.page(page))


def command_lines() -> Found:
    """Return the lines of the command that a page adds."""
    file = next(block for block in shown("add-a-command") if block.info == "python")
    return Found(len(file.text.splitlines()))


def own_seconds() -> Found:
    """Return the seconds of the slowest report of one's own system, with nothing in the cache."""
    file = next(block for block in shown("my-own-system") if block.info == "python")
    console = next(block for block in shown("my-own-system") if block.info == "console")
    found = {}
    for line in console.text.splitlines():
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "mysys.py").write_text(file.text, "utf-8")
            words = shlex.split(line.removeprefix("$ geomint "))
            begun = time.perf_counter()
            subprocess.run(
                [sys.executable, "-m", "geomint", *words],
                env=environment(ROOT, Path(folder) / "cache"),
                cwd=folder,
                check=True,
                capture_output=True,
            )
            found[words[0]] = time.perf_counter() - begun
    return Found(max(found.values()), ", ".join(f"{k} {v:.1f}" for k, v in found.items()))


def warm_drift() -> Found:
    """Return the processor seconds of a drift report without those of its steps, new over old."""
    pairs = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(COLD + 1):
            both = [_seconds(x, Path(folder) / str(k)) for k, x in enumerate((before(), ROOT))]
            pairs.append(both)
    old, new = (statistics.median(each) for each in zip(*pairs[1:], strict=True))
    return Found(new / old, f"{old:.2f} to {new:.2f} s")


FLOORS: dict[str, dict[str, Floor]] = {
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
    "outside": {
        "rooms": Floor(8_000, room_lines),
        "templates": Floor(300, template_lines),
        "lines": Floor(40_850, lambda: weight("src", "lines")),
        "tokens": Floor(409_000, lambda: weight("src", "tokens")),
        "help": Floor(0.15, help_seconds),
        "command": Floor(80, command_lines),
        "own-system": Floor(15.0, own_seconds),
        "warm-drift": Floor(0.6, warm_drift),
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
