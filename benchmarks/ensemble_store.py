"""Ensembles larger than memory: time and memory of those on disk, beside those in memory."""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.problems.testproblems import henon_heiles
from machine import describe

RUN = {"method": "rk-4", "step": 0.05, "progress": False}
READINGS = ["drift:energy", "final:q[0]", gi.Histogram("q[0]", np.linspace(-1.0, 1.0, 9))]
CASES: dict[str, tuple[int, dict[str, Any]]] = {
    "readings": (10**6, {"t_end": 5.0, "readings": READINGS}),
    "states": (6400, {"t_end": 200.0, "save_every": 1}),
}


def measured(case: str, stored: bool) -> dict[str, float]:
    """Return seconds, and by how much the peak of this process's memory has grown, in MB."""
    members, more = CASES[case]
    states = np.random.default_rng(2).uniform(-0.2, 0.2, (members, 4))
    problem = henon_heiles.problem()
    gi.solve_ensemble(problem, states[:64], **RUN, **more)  # compiles
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/many.zarr" if stored else None
        many = gi.solve_ensemble(problem, states, **RUN, **more, out=out)
        files = sum(path.is_file() for path in Path(folder).rglob("*"))
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    return {"members": members, "seconds": many.run_seconds, "grown_mb": grown, "files": files}


def alone(case: str, stored: bool) -> dict[str, float]:
    """Return what is measured in a process of its own, whose peak nothing else has raised."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(measured, (case, stored))


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    result: dict[str, Any] = {"benchmark": "ensemble_store"}
    for case in CASES:
        for place, stored in (("memory", False), ("disk", True)):
            found = alone(case, stored)
            result.setdefault(case, {})[place] = found
            print(case, place, {k: round(v, 1) for k, v in found.items()}, flush=True)
    result["machine"] = describe(["geomint", "numba", "numpy", "zarr"])
    path = arguments.out / "ensemble_store.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
