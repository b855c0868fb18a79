"""Errors of elementary functions in units in the last place, and what a call costs.

Truth is numpy's `longdouble` of 64 bits of mantissa (x86-64). A call of one number waits for the one
before, as in a field; eight numbers are a lane value. The C library is called by numba, numpy for
arrays of 4096 numbers. Writes ``results/elementary.json`` and ``docs/images/elementary-functions.png``.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from numba import njit

import geomint as gi
from geomint.kernels.compiling.compile import compile_function
from geomint.kernels.compiling.number_types import SCALAR
from geomint.kernels.compiling.recorded import Recorded, helper
from geomint.kernels.compiling.signatures import BLOCK, takes
from geomint.kernels.numbers.arithmetic import of_numpy
from geomint.kernels.numbers.blocks import as_lanes, scalar_block
from machine import describe

ROOT = Path(__file__).parents[1]
SAMPLES, TIMED, REPEATS = 1_048_576, 4096, 200
SIGNATURE = takes(x=BLOCK, y=BLOCK, out=BLOCK).of(SCALAR)
Numbers = np.ndarray[Any, np.dtype[np.float64]]


def drawn(name: str, n: int) -> tuple[Numbers, Numbers, Numbers, str]:
    """Return two arguments (the second may not count), what they are drawn over, and its name."""
    rng = np.random.default_rng(7)
    u, v = rng.uniform(-1.0, 1.0, (2, n))
    if name == "exp":
        x = 707.0 * u * np.abs(v)
        return x, x, x, "x"
    if name == "log":
        x = 10.0 ** (300.0 * u * np.abs(v))
        return x, x, np.log10(x), "log₁₀ x"
    if name == "pow":
        x = np.where(v < 0.0, 10.0 ** (30.0 * u), 1.0 + 0.5 * u)
        power = 700.0 * rng.uniform(-1.0, 1.0, n)
        return x, power / np.log(x), power, "y log x"
    if name == "tan":
        x = 12.0 * u
        return x, x, x, "x"
    if name == "tanh":
        x = 22.0 * u * np.abs(v)
        return x, x, x, "x"
    x, y = rng.normal(size=(2, n)) * 10.0 ** (100.0 * v)
    return y, x, np.arctan2(y, x), "angle"


def in_lanes(function: Callable[..., Any], two: bool) -> Any:
    """Return compiled code that takes two blocks of numbers, eight at a time."""

    @helper
    def of_one(a, b, c):
        for i in range(len(c)):
            c[i] = function(a[i])

    @helper
    def of_two(a, b, c):
        for i in range(len(c)):
            c[i] = function(a[i], b[i])

    rows = of_two if two else of_one

    @helper
    def blocks(x, y, out):
        n = len(x) // 8
        rows(as_lanes(x, 0, n), as_lanes(y, 0, n), as_lanes(out, 0, n))

    return compile_function(blocks, SIGNATURE)


def one_by_one(function: Callable[..., Any], two: bool) -> Recorded:
    """Return code in which each call waits for the last."""

    @helper
    def of_one(x, y, out):
        last = 0.0
        for i in range(len(x)):
            last = function(x[i] + 0.0 * last)
            out[i] = last

    @helper
    def of_two(x, y, out):
        last = 0.0
        for i in range(len(x)):
            last = function(x[i] + 0.0 * last, y[i])
            out[i] = last

    return of_two if two else of_one


def nanoseconds(call: Callable[[], object], count: int) -> float:
    """Return the least time of a call, by number."""
    taken = []
    for _ in range(REPEATS):
        begun = time.perf_counter_ns()
        call()
        taken.append(time.perf_counter_ns() - begun)
    return min(taken) / count


def errors(found: Numbers, truth: Any) -> Numbers:
    """Return errors in units in the last place."""
    near = truth.astype(float)
    return np.abs((found - truth) / np.spacing(np.abs(near))).astype(float)


def measured(name: str, axes: Any) -> dict[str, float]:
    """Draw the errors of a function, and return the largest and what calls cost."""
    function, two = getattr(gi, name), name in ("pow", "atan2")
    x, y, over, label = drawn(name, SAMPLES)
    blocks = [scalar_block(SAMPLES) for _ in range(3)]
    blocks[0].data[:], blocks[1].data[:] = x, y
    eight = in_lanes(function, two)
    eight(*blocks)
    given = (x, y) if two else (x,)
    of_arrays = of_numpy(function)
    truth = of_arrays(*(v.astype(np.longdouble) for v in given))
    library = np.vectorize(getattr(math, name), otypes=[float])(*(v[: SAMPLES // 4] for v in given))
    own, theirs = errors(blocks[2].data, truth), errors(library, truth[: SAMPLES // 4])
    axes.plot(over[:6000], own[:6000], ".", ms=1.2, color="0.65", rasterized=True)
    edges = np.linspace(over.min(), over.max(), 61)
    for values, places, style, of in (
        (theirs, over[: SAMPLES // 4], {"color": "C1", "lw": 1.0}, "C library, largest"),
        (own, over, {"color": "C0", "lw": 1.6}, "geomint, largest"),
    ):
        place = np.clip(np.digitize(places, edges) - 1, 0, 59)
        most = [values[place == k].max(initial=0.0) for k in range(60)]
        axes.step(edges[:-1], most, where="post", label=of, **style)
    axes.set(title=f"gi.{name}", xlabel=label, ylim=(0.0, 1.05))
    x, y = x[:TIMED].copy(), y[:TIMED].copy()
    some = [scalar_block(TIMED) for _ in range(3)]
    some[0].data[:], some[1].data[:] = x, y
    chained = compile_function(one_by_one(function, two), SIGNATURE)
    chain: Any = njit(one_by_one(getattr(math, name), two).function)
    out = np.empty(TIMED)
    chain(x, y, out)
    numbers = (x, y) if two else (x,)
    return {
        "largest_error": float(own.max()),
        "library_error": float(theirs.max()),
        "one": nanoseconds(lambda: chained(*some), TIMED),
        "eight": nanoseconds(lambda: eight(*some), TIMED),
        "library": nanoseconds(lambda: chain(x, y, out), TIMED),
        "numpy": nanoseconds(lambda: of_arrays(*numbers), TIMED),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks" / "results")
    parser.add_argument("--images", type=Path, default=ROOT / "docs" / "images")
    given = parser.parse_args()
    figure, axes = plt.subplots(2, 3, figsize=(11, 5.6), layout="constrained", sharey=True)
    names = ("exp", "log", "pow", "tan", "tanh", "atan2")
    with np.errstate(all="ignore"):
        rows = {name: measured(name, part) for name, part in zip(names, axes.flat, strict=True)}
    for part in axes[:, 0]:
        part.set_ylabel("error (units in the last place)")
    axes[0, 0].legend(loc="upper center", fontsize="small")
    figure.savefig(given.images / "elementary-functions.png", dpi=110)
    record = {"machine": describe(["geomint", "numba", "numpy"]), "samples": SAMPLES, "rows": rows}
    (given.out / "elementary.json").write_text(json.dumps(record, indent=1) + "\n", "utf-8")
    for name, row in rows.items():
        print(name, *(f"{key} {value:.3g}" for key, value in row.items()))


if __name__ == "__main__":
    main()
