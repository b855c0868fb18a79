"""Input that nobody means, by the hundred thousand: scenes, runs, calls, commands, saved runs.

Every case is made by a seed, a kind and a number, done in a process that may hang, crash or take
too much memory, and ends with one verdict. Writes ``results/fuzz.json``. The tests of
``tests/fuzz`` draw from the same mutations.

    python benchmarks/fuzz.py --scenes 100000 --runs 10000 --calls 100000
    python benchmarks/fuzz.py --only calls:123        # one case again, with its traceback
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

from geomint.stress.guard import guarded
from machine import describe  # it is the way to tests, too
from tests.fuzz.judge import BAD, VERDICTS, Judged, check_scene, run_scene

HERE = Path(__file__).parent

PACKAGES = ["geomint", "numpy", "scipy", "numba", "pydantic", "click", "tomli_w"]
KINDS = ("scenes", "runs", "compiled-runs", "calls", "commands", "files")
CAP = 60.0  # seconds after which a case has hung, compilations included
SOFT = 4.0  # seconds after which a run is interrupted, as by Ctrl-C
MEMORY = 6 << 30
Case = tuple[str, int, int]


def verdict(case: Case) -> Judged:
    """Return what a case ends with."""
    kind, seed, number = case
    rng = Random(f"{seed} {kind} {number}")
    if kind == "calls":
        from tests.fuzz.calls import call_verdict

        return call_verdict(rng, SOFT)
    if kind == "files":
        from tests.fuzz.saved import file_verdict

        return file_verdict(rng)
    if kind == "commands":
        from tests.fuzz.commands import line_verdict

        return line_verdict(rng, SOFT)
    from tests.fuzz.scenes import mutated_text

    if kind == "scenes":
        extra = rng.choice(([], [], ["--for-drift"], ["--methods", "gauss-4:0.1,rk-4"]))
        return check_scene(mutated_text(rng), extra)
    return run_scene(mutated_text(rng, run=True), SOFT)


def cases(kind: str, seed: int, count: int) -> list[Case]:
    """Return all cases of a kind."""
    return [(kind, seed, number) for number in range(count)]


def outcomes(kind: str, seed: int, count: int, workers: int) -> Iterator[tuple[Case, Judged]]:
    """Yield the verdict on each case of a kind."""
    os.environ["NUMBA_DISABLE_JIT"] = "1" if kind == "runs" else "0"
    items, cap = cases(kind, seed, count), CAP * (2.0 if kind == "commands" else 1.0)
    for outcome in guarded(verdict, items, seconds=cap, workers=workers, memory=MEMORY):
        if outcome.ending == "done":
            yield outcome.item, outcome.told
        else:
            name = {"hung": "hang", "raised": "traceback"}.get(outcome.ending, "died")
            yield outcome.item, Judged(name, outcome.told)


def progress(kind: str, done: int, count: int, counts: Counter[str], begun: float) -> None:
    """Show how far a kind is, on one line of a terminal."""
    bad = sum(counts[name] for name in BAD)
    rate = done / max(time.monotonic() - begun, 1e-9)
    text = f"{kind}: {done} of {count}, {bad} bad, {rate:.0f} a second"
    end = "\r" if sys.stderr.isatty() and done < count else "\n"
    if end == "\r" or done % max(count // 10, 1) == 0 or done == count:
        print(text, end=end, file=sys.stderr, flush=True)


def swept(kind: str, seed: int, count: int, workers: int) -> dict[str, Any]:
    """Return the counts of one kind, and its bad cases."""
    counts: Counter[str] = Counter()
    bad: list[dict[str, Any]] = []
    begun = time.monotonic()
    for done, (case, found) in enumerate(outcomes(kind, seed, count, workers), 1):
        counts[found.verdict] += 1
        if found.bad:
            bad.append({"case": f"{kind}:{case[2]}", **vars(found)})
            print(f"{kind}:{case[2]} {found.verdict}: {found.detail!a}", file=sys.stderr)
        progress(kind, done, count, counts, begun)
    return {
        "cases": count,
        "seconds": round(time.monotonic() - begun, 1),
        "counts": {name: counts[name] for name in VERDICTS if counts[name]},
        "bad": sorted(bad, key=lambda entry: (entry["verdict"], entry["detail"])),
    }


def main() -> None:
    """Do all kinds, write the JSON, and end with 1 if anything is bad."""
    parser = argparse.ArgumentParser(description=__doc__)
    for kind, count in zip(KINDS, (2000, 200, 50, 2000, 200, 2000), strict=True):
        parser.add_argument(f"--{kind}", type=int, default=count, metavar="COUNT")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=HERE / "results" / "fuzz.json")
    parser.add_argument("--only", metavar="KIND:NUMBER", help="one case, in this process")
    options = parser.parse_args()
    if options.only:
        kind, number = options.only.split(":")
        print(verdict((kind, options.seed, int(number))))
        return
    counts = {kind: getattr(options, kind.replace("-", "_")) for kind in KINDS}
    found = {}
    for kind in (kind for kind in KINDS if counts[kind]):
        found[kind] = swept(kind, options.seed, counts[kind], options.workers)
        record = {"seed": options.seed, "kinds": found, "provenance": describe(PACKAGES)}
        options.out.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    bad = sum(len(entry["bad"]) for entry in found.values())
    for kind, entry in found.items():
        print(f"{kind}: {entry['counts']}")
    print(f"{bad} bad; written: {options.out}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
