#!/usr/bin/env python
"""Run the same things in two checkouts, and compare what they give, bit by bit.

    python tests/kept/compare.py OLD NEW                           # all
    python tests/kept/compare.py OLD NEW --quick                   # a part, for every landing
    python tests/kept/compare.py OLD NEW --only "exact/*" --only "methods/gauss-*"

Both checkouts run at the same time, each in a process of its own, with another seed of hashes and
in the opposite order: what depends on these differs too. Compiled code is kept in the user's cache
folder, for each checkout by itself; --cold empties it first. The exit code is 1 where something
differs, 2 where a run is there or succeeds on one side only.
"""

import argparse
import hashlib
import os
import pickle
import resource
import shutil
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatchcase
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import platformdirs
from rich.console import Console
from rich.progress import Progress

QUICK = ("methods/*", "along/*", "*/plain *", "values/*", "failures/*", "series/draws")
QUICK += ("exact/hamiltonized-n3", "carried/verlet-4", "compiled/RATTLE rods", "quick_commands/*")

# What differs on purpose, as patterns of "run: quantity", why, and by how much of their size numbers
# may; texts in any way. An entry goes when the older checkout has the change too.
CLOSE = 1e-9
EXPECTED = {
    "along/states*: warnings*": ("told by the end of the run, not by a saved state", CLOSE),
    "along/events*: warnings*": ("an energy that is no integral is told as such", CLOSE),
    "along/e*: *": ("roots of events are bracketed", CLOSE),
    "along/sav*: *events*": ("likewise", CLOSE),
    "along/states*: *default*": ("default steps look at nothing beyond a run", np.inf),
    "along/states*: own.y": ("times are met to a rounding", CLOSE),
    "*: *poisson*": ("derivatives of square roots", CLOSE),
    "*: *symplectic*": ("likewise", np.inf),
    "compiled/* rods: *": ("steps near to lost rank", CLOSE),
    "compiled/* body: *": ("last steps end within the run", CLOSE),
    "*lobatto-3 pendulum: *": ("when iterations end", np.inf),
    "carried/lyapunov: *": ("derivatives of square roots", CLOSE),
    "series/*: *": ("likewise, and which frequencies there are", CLOSE),
    "failures/*: *": ("what messages say", CLOSE),
    "along/scipy: *nfev": ("errors of steps from tolerances are looked at", np.inf),
    "[!a]*: warnings*": (
        "an energy that changes is no sign of long steps, if these err by little",
        CLOSE,
    ),
    "[!a]*: *measure*": ("explicit steps are watched one at a time, not eight", np.inf),
    "accuracy/*": ("trials are shorter, and runs begin anew", np.inf),
    "commands/run veselova-n4*tolerance*": ("likewise", np.inf),
    "*commands/*: *files*": ("local errors, and the measure, in what is written", CLOSE),
    "*: *drift*label*": ("axes say what they show in words", np.inf),
    "*commands/*: output": ("terminals show the tables of reports", np.inf),
    "*commands/*: messages": ("likewise, of numbers in lists", CLOSE),
}
SHOWN = 40  # differences


class Side(NamedTuple):
    """What the runs of one checkout have given: the names of all, values and seconds by name."""

    names: list[str]
    found: dict[str, dict[str, Any]]
    seconds: dict[str, float]
    code: int


def environment(checkout: Path, folder: Path, cache: Path, seed: int) -> dict[str, str]:
    """Return what lets Python import a checkout's packages, and find its own entry points."""
    project = tomllib.loads((checkout / "pyproject.toml").read_text("utf-8"))["project"]
    info = folder / f"{project['name']}-{project['version']}.dist-info"
    info.mkdir(parents=True)
    told = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    (info / "METADATA").write_text(told, "utf-8")
    groups = {"console_scripts": project["scripts"], **project["entry-points"]}
    lines = (
        f"[{group}]\n" + "\n".join(map(" = ".join, own.items())) for group, own in groups.items()
    )
    (info / "entry_points.txt").write_text("\n".join(lines), "utf-8")
    own = os.pathsep.join(map(str, (folder, checkout / "src", Path(__file__).parents[2])))
    paths = {"PYTHONPATH": own, "NUMBA_CACHE_DIR": str(cache)}
    paths |= {"PYTHONPYCACHEPREFIX": str(cache / "pyc"), "PYTHONDONTWRITEBYTECODE": ""}
    shown = {"COLUMNS": "100", "TERM": "dumb", "NO_COLOR": "1", "MPLBACKEND": "Agg"}
    return {**os.environ, **paths, **shown, "PYTHONHASHSEED": str(seed)}


def cache_of(checkout: Path, again: str = "") -> Path:
    """Return the folder of a checkout's compiled code."""
    name = hashlib.sha256(f"{checkout}{again}".encode()).hexdigest()[:12]
    return platformdirs.user_cache_path("geomint-kept") / name


def run(checkout: Path, patterns: list[str], cache: Path, seed: int, bar: Progress) -> Side:
    """Run one checkout, with an odd seed backwards."""
    side, code = Side([], {}, {}, 0), 0
    task = bar.add_task(str(checkout), total=None)
    words = [str(Path(__file__).with_name("runs.py")), str(checkout), *patterns]
    with tempfile.TemporaryDirectory() as folder:
        place = environment(checkout, Path(folder), cache, seed)
        command = [sys.executable, *words, *["--backwards"] * (seed % 2)]
        with subprocess.Popen(command, env=place, cwd=folder, stdout=subprocess.PIPE) as process:
            try:
                side.names.extend(pickle.load(process.stdout))
                bar.update(task, total=len(side.names))
                for _ in side.names:
                    name, side.found[name], side.seconds[name] = pickle.load(process.stdout)
                    bar.advance(task)
            except EOFError:  # it has ended before
                pass
        code = process.returncode
    return side._replace(code=code)


def both(checkouts: list[Path], patterns: list[str], caches: list[Path]) -> list[Side]:
    """Run two checkouts at the same time."""
    with Progress(console=Console(stderr=True)) as bar, ThreadPoolExecutor(2) as pool:
        return list(pool.map(run, checkouts, [patterns] * 2, caches, (0, 1), (bar, bar)))


def differences(a: dict[str, Any], b: dict[str, Any]) -> list[tuple[str, str, float]]:
    """Return which quantities differ, how, and by how much of their size; infinite for texts."""
    found = []
    for name in {**a, **b}:
        x, y = a.get(name, "nothing"), b.get(name, "nothing")
        if isinstance(x, str) or isinstance(y, str) or (x.shape, x.dtype) != (y.shape, y.dtype):
            if str(x) != str(y) or type(x) is not type(y):
                pairs = enumerate(zip_longest(str(x).splitlines(), str(y).splitlines()), 1)
                line, (one, other) = next(((i, p) for i, p in pairs if p[0] != p[1]), (0, (x, y)))
                found.append((name, f"line {line}:\n    {one!r}\n    {other!r}", np.inf))
        elif x.tobytes() != y.tobytes():
            found.append((name, *first_number(x.ravel(), y.ravel())))
    return found


def first_number(x: Any, y: Any) -> tuple[str, float]:
    """Return the first number that differs, in full, and the largest relative difference."""
    if x.dtype.kind == "c":
        x, y = x.view(np.float64), y.view(np.float64)
    if x.dtype != np.float64:
        k = int(np.argmax(x != y))
        return f"[{k}] {x[k]!r} and {y[k]!r}", np.inf
    bits = [z.view(np.int64) for z in (x, y)]
    different = np.flatnonzero(bits[0] != bits[1])
    k = different[0]
    one, other = (int(b[k]) if b[k] >= 0 else -(2**63) - int(b[k]) for b in bits)  # in their order
    with np.errstate(all="ignore"):
        size = np.abs(x - y).max() / np.abs([x, y]).max()
    there = f"[{k}] {float(x[k])!r} and {float(y[k])!r}, {abs(one - other)} ulp"
    return f"{there}; {len(different)} of {len(x)}", size if size >= 0.0 else np.inf


def compare(old: Side, new: Side, strict: bool = False) -> int:
    """Show what differs, and return the exit code."""
    lines, expected, broken = [], dict.fromkeys(EXPECTED, 0), bool(old.code or new.code)
    for name in dict.fromkeys([*old.names, *new.names]):
        a, b = old.found.get(name, {"error": "no run"}), new.found.get(name, {"error": "no run"})
        broken |= ("error" in a) != ("error" in b)
        for quantity, text, size in differences(a, b):
            known = [p for p in EXPECTED if fnmatchcase(f"{name}: {quantity}", p) and not strict]
            near = max((EXPECTED[p][1] for p in known), default=-1.0)
            if size <= near or (known and isinstance(a.get(quantity), str)):
                expected[known[0]] += 1
            else:
                lines.append(f"{name}: {quantity} {text}")
    print(*lines[:SHOWN], *(["…"] if lines[SHOWN:] else []), sep="\n")
    for pattern, count in expected.items():
        print(f"expected, {count} times: {pattern}: {EXPECTED[pattern][0]}")
    failed = sum("error" in found for found in old.found.values())
    told = f"{len(old.names)} runs, of which {failed} end with an error; {len(lines)} differences"
    print(f"{told}; exit codes {old.code} and {new.code}")
    return 2 if broken or not old.names else bool(lines)


def main() -> int:
    """Compare the checkouts of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("old", type=Path, metavar="OLD")
    parser.add_argument("new", type=Path, metavar="NEW")
    parser.add_argument("--quick", action="store_true", help="a part, in less than two minutes")
    parser.add_argument("--only", action="append", metavar="PATTERN", help="of names of runs")
    parser.add_argument("--cold", action="store_true", help="compile everything anew")
    parser.add_argument("--seconds", action="store_true", help="show the dearest runs")
    parser.add_argument("--strict", action="store_true", help="nothing is expected to differ")
    given = parser.parse_args()
    checkouts = [given.old.resolve(), given.new.resolve()]
    caches = [
        cache_of(checkouts[0]),
        cache_of(checkouts[1], " again" * (checkouts[0] == checkouts[1])),
    ]
    for cache in caches if given.cold else ():
        shutil.rmtree(cache, ignore_errors=True)
    patterns = given.only or (list(QUICK) if given.quick else ["*"])
    old, new = both(checkouts, patterns, caches)
    code = compare(old, new, given.strict)
    for name in sorted(old.seconds, key=old.seconds.__getitem__)[-30:] if given.seconds else ():
        print(f"{old.seconds[name]:8.2f} {new.seconds.get(name, 0.0):8.2f} {name}")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{used.ru_utime + used.ru_stime:.0f} s of processor time")
    return code


if __name__ == "__main__":
    sys.exit(main())
