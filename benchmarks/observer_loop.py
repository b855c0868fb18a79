"""What `ball-3d` costs: a million cached steps with all observers, the command, the cold start.

Floors: the loop 1 s per 10⁶ steps, the whole command 6 s, ``--help`` and a typo 0.4 s, compilation of
a cold first run 15 s.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import geomint as gi
from machine import describe

FLOORS = {"loop": 1.0, "command": 6.0, "help": 0.4, "typo": 0.4, "cold_compilation": 15.0}


def loop_seconds(repeats: int) -> list[float]:
    """Return the wall seconds of `solve` on the scene, everything compiled."""
    scene = gi.load_scene("ball-3d")
    content = scene.content
    arguments: dict[str, Any] = {
        "t_end": content.time.t_end,
        "method": scene.method,
        "step": content.integrate.step,
        "observe": content.observe.quantities,
        "progress": False,
    }
    seconds = []
    for i in range(repeats + 1):
        begun = time.perf_counter()
        solution = gi.solve(scene.problem, scene.state, **arguments)
        if i:  # the first compiles, or reads the cache
            seconds.append((time.perf_counter() - begun) * 1e6 / solution.steps)
    return seconds


def command_seconds(words: list[str], repeats: int, **environment: str) -> list[float]:
    """Return the wall seconds of a command line, started anew each time."""
    seconds = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            begun = time.perf_counter()
            subprocess.run(
                [sys.executable, "-m", "geomint", *words],
                cwd=folder,
                env={**os.environ, **environment},
                capture_output=True,
                check=False,
            )
            seconds.append(time.perf_counter() - begun)
    return seconds


def cold_compilation() -> tuple[float, float]:
    """Return (compile seconds, wall seconds) of the command with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "geomint", "drift", "ball-3d", "--out", folder],
            env={**os.environ, "NUMBA_CACHE_DIR": str(Path(folder) / "cache")},
            capture_output=True,
            check=True,
        )
        wall = time.perf_counter() - begun
        record = json.loads((Path(folder) / "drift.json").read_text(encoding="utf-8"))
    (entry,) = record["methods"].values()
    return entry["run"]["compile_seconds"], wall


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    n = arguments.repeats
    compiled, cold_wall = cold_compilation()
    measured = {
        "loop": statistics.median(loop_seconds(n)),
        "command": statistics.median(command_seconds(["drift", "ball-3d", "--out", "report"], n)),
        "help": statistics.median(command_seconds(["--help"], n)),
        "typo": statistics.median(command_seconds(["drift", "bal-3d", "--out", "report"], n)),
        "cold_compilation": compiled,
    }
    for name, seconds in measured.items():
        print(f"{name}: {seconds:.3f} s (floor {FLOORS[name]:g} s)")
    print(f"cold command: {cold_wall:.1f} s")
    result = {
        "benchmark": "observer-loop",
        "seconds": measured,
        "cold_command_seconds": cold_wall,
        "floors": FLOORS,
        "repeats": n,
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / "observer_loop.json"
    path.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
