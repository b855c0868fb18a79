"""What the fast row of the tests takes, before the redesign and now: in all, and by folder.

The packages of this environment and the commit `BEFORE` of `floors.py` are used; compiled code is kept
in a new folder and the checkout's bytecode goes, so the first run of each is cold, as in a fresh clone.
Tests of the installation itself fail here, and are named. Nothing else may run on the machine.
Writes ``results/net.json`` and ``docs/images/net.png``; with ``--now`` the row of before is kept.
"""

from __future__ import annotations

import argparse
import json
import resource
import runpy
import shutil
import signal
import subprocess
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import matplotlib.pyplot as plt

from floors import ROOT, before
from machine import describe

MOST = 12  # folders in the picture


def row(checkout: Path, times: int) -> list[dict[str, Any]]:
    """Return what the row takes with nothing compiled, and again."""
    environment = runpy.run_path(str(ROOT / "tests" / "kept" / "compare.py"))["environment"]
    with tempfile.TemporaryDirectory() as home:
        given = environment(checkout, Path(home, "packages"), Path(home, "cache"), 0)
        del given["PYTHONPYCACHEPREFIX"]
        for folder in [
            p for name in ("src", "tests") for p in (checkout / name).rglob("__pycache__")
        ]:
            shutil.rmtree(folder)
        told, found = Path(home, "told.xml"), []
        for _ in range(times):
            used, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
            command = ["pytest", "-q", "--junitxml", str(told)]
            done = subprocess.run(
                command, env=given, cwd=checkout, stdout=subprocess.PIPE, text=True
            )
            print("\n".join(x for x in done.stdout.splitlines()[-40:] if x.startswith("FAILED")))
            minutes = (time.monotonic() - begun) / 60
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            processor = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
            took = {"processor": processor, "minutes": minutes}
            found.append(took | dict(zip(("folders", "tests"), folders(told), strict=True)))
    return found


def folders(told: Path) -> tuple[dict[str, float], int]:
    """Return the seconds of each folder of tests, and how many tests there are."""
    found, count = Counter[str](), 0
    for case in ElementTree.parse(told).iter("testcase"):
        name = case.get("classname", "").removeprefix("tests.").split(".")
        found[name[0] if len(name) > 1 else "others"] += float(case.get("time", "0"))
        count += 1
    return dict(found.most_common()), count


def draw(rows: dict[str, dict[str, Any]], path: Path) -> None:
    """Draw the seconds of the folders that take most."""
    figure, axes = plt.subplots(figsize=(8, 4.4), layout="constrained")
    total = Counter[str]()
    for each in rows.values():
        total.update(each["folders"])
    names = [name for name, _ in total.most_common(MOST)]
    for k, (label, each) in enumerate(rows.items()):
        values = [each["folders"].get(name, 0.0) for name in names]
        values.append(sum(each["folders"].values()) - sum(values))
        places = [i + 0.27 * (k - 1) for i in range(len(values))]
        axes.barh(places, values, 0.25, label=f"{label}: {each['minutes']:.1f} min")
    axes.set_yticks(range(len(names) + 1), [*names, "all others"])
    axes.invert_yaxis()
    axes.set(xlabel="seconds of tests, both cores together")
    axes.legend(loc="center right")
    figure.savefig(path, dpi=110)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--now", action="store_true", help="keep the row of before")
    known = parser.parse_args().now
    signal.signal(signal.SIGINT, signal.default_int_handler)  # tests send it; shells may ignore it
    path, name = ROOT / "benchmarks" / "results" / "net.json", "before, cold"
    old = json.loads(path.read_text("utf-8"))["rows"][name] if known else row(before(), 1)[0]
    rows = {name: old, **dict(zip(("now, cold", "now, warm"), row(ROOT, 2), strict=True))}
    record = {"machine": describe(["geomint", "numba", "pytest"]), "rows": rows}
    path.write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    draw(rows, ROOT / "docs" / "images" / "net.png")
    for name, took in rows.items():
        print(name, f"{took['processor']:.0f} s of processor time, {took['minutes']:.2f} min")


if __name__ == "__main__":
    main()
