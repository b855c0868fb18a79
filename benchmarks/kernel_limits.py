"""What a step of each kernel has to do, and how near it comes to what the processor can do.

Operations are counted by taking steps in plain Python with numbers that count: multiplications and
additions (a fused one is two), divisions and roots, and numbers read from or written to memory. The
limit is the time of the multiplications and additions at the rate that independent fused ones reach
(`vector_limit`), of single numbers, or of lanes for kernels whose stages are in lanes: what waits for
other results, or is not fused, takes longer. Bytes are those of a step's reads and writes, which the
compiler keeps in registers where it can. Steps have the default length, from a random state.
"""

from __future__ import annotations

import argparse
import json
import statistics
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

import chaplygin as ch
import geomint as gi
from geomint.kernels.numbers.blocks import Block, LaneBlock
from geomint.kernels.numbers.lanes import LANES
from geomint.methods import find_method
from geomint.problems.time_scale import characteristic_time
from machine import describe
from vector_limit import vector_limit

STEPS = 3  # that are counted: an iteration begins with what the step before found
A = (0.8, 1.1, 1.5)


def sphere(n: int) -> gi.Problem:
    """Return the Hamiltonised sphere."""
    a = A if n == 3 else np.linspace(0.8, 1.5, n)
    return ch.ChaplyginSphere(a=a, D=4.0).hamiltonized()


def ball(n: int) -> gi.Problem:
    """Return the ball in (k, γ)."""
    if n == 3:
        return ch.ChaplyginSphere(a=A, D=4.0).classical()
    return ch.ChaplyginSphere(a=np.linspace(0.8, 1.5, n), D=4.0).ball()


CASES: tuple[tuple[str, Any, str], ...] = (
    ("Hamiltonised sphere, n = 3", lambda: sphere(3), "gauss-8"),
    ("Hamiltonised sphere, n = 10", lambda: sphere(10), "gauss-8"),
    ("Hamiltonised sphere, n = 100", lambda: sphere(100), "gauss-8"),
    ("Hamiltonised sphere, n = 3", lambda: sphere(3), "verlet-4"),
    ("Hamiltonised sphere, n = 3", lambda: sphere(3), "rattle-4"),
    ("ball in (k, γ), so(3)", lambda: ball(3), "cf-4"),
    ("ball in (k, γ), so(3)", lambda: ball(3), "rkmk-4"),
    ("ball in (k, γ), so(3)", lambda: ball(3), "gauss-8"),
    ("ball in (k, γ), so(8)", lambda: ball(8), "gauss-8"),
    ("ball in (k, γ), so(16)", lambda: ball(16), "gauss-8"),
)


class Count:
    """A float64 number that counts what is done to it."""

    __slots__ = ("value",)
    __array_ufunc__ = None
    done: ClassVar[Counter[str]] = Counter()

    def __init__(self, value: float) -> None:
        self.value = float(value)

    def __float__(self) -> float:
        return self.value

    def __bool__(self) -> bool:
        return bool(self.value)


def _counted(name: str, kind: str, swapped: bool = False) -> Any:
    def operation(x: Count, y: Any) -> Any:
        if isinstance(y, np.ndarray):
            return np.array([operation(x, each) for each in y], dtype=object).view(type(y))
        Count.done[kind] += 1
        left, right = (float(y), x.value) if swapped else (x.value, float(y))
        with np.errstate(all="ignore"):
            return Count(getattr(np.float64(left), name)(np.float64(right)))

    return operation


for _name, _kind in (("add", "plain"), ("sub", "plain"), ("mul", "plain"), ("truediv", "slow")):
    setattr(Count, f"__{_name}__", _counted(f"__{_name}__", _kind))
    setattr(Count, f"__r{_name}__", _counted(f"__{_name}__", _kind, True))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(
        Count, f"__{_name}__",
        lambda x, y, name=f"__{_name}__": bool(getattr(x.value, name)(float(y))),
    )  # fmt: skip
Count.__neg__ = lambda x: Count(-x.value)  # type: ignore[attr-defined]
Count.__abs__ = lambda x: Count(abs(x.value))  # type: ignore[attr-defined]


class _Functions:
    eps = 2.0**-52

    @staticmethod
    def sqrt(x: Count) -> Count:
        Count.done["slow"] += 1
        return Count(np.sqrt(x.value))


Count.context = property(lambda x: _Functions)  # type: ignore[attr-defined]


def counting(values: Any) -> Block:
    """Return a block of counting numbers."""
    return Block(np.array([Count(v) for v in np.ravel(values)], dtype=object))


@contextmanager
def watched_memory() -> Iterator[None]:
    """Count numbers that are read from and written to blocks."""
    kept = [(cls, name, getattr(cls, name)) for cls in (Block, LaneBlock)
            for name in ("__getitem__", "__setitem__") if name in vars(cls)]  # fmt: skip

    def seen(method: Any) -> Any:
        def instead(block: Block, row: int, *value: Any) -> Any:
            Count.done["memory"] += LANES if np.ndim(block.data) > 1 else 1
            return method(block, row, *value)

        return instead

    for cls, name, method in kept:
        setattr(cls, name, seen(method))
    try:
        yield
    finally:
        for cls, name, method in kept:
            setattr(cls, name, method)


def operations(problem: gi.Problem, y0: Any, name: str, h: float) -> dict[str, float]:
    """Return what a step does, by kind, in the mean over some steps."""
    flow = find_method(name).on(problem, y0, compiled=False)
    stepper = flow.begin(y0, 0.0, h)
    memory, work = counting(0.0 * stepper.memory.data), counting(0.0 * stepper.work.data)
    memory.data[: len(stepper.state)] = counting(stepper.state).data
    functions = tuple(f.recorded for f in flow.functions)
    Count.done = Counter()
    with watched_memory():
        for step in range(1 + STEPS):
            if step == 1:
                Count.done = Counter()  # the first has nothing to begin with
            flow.kernel(
                functions, Block(flow.params.data), Block(flow.coefficients.data),
                Block(flow.fractions.data), memory, work, flow.rows, step * h, h, 0, 1, 2,
                memory,
            )  # fmt: skip
    return {kind: count / STEPS for kind, count in Count.done.items()}


def seconds(problem: gi.Problem, y0: Any, name: str, h: float, repeats: int) -> float:
    """Return the time of a step, without observers."""
    steps = max(200, int(20_000 * (6 / problem.rows) ** 2))
    end = {"tau_end" if problem.time == "tau" else "t_end": steps * h}
    asked: dict[str, Any] = {"method": name, "step": h, "clock": False, "progress": False}
    runs = [gi.solve(problem, y0, **asked, **end) for _ in range(repeats + 1)]
    return statistics.median(run.run_seconds / run.steps for run in runs[1:])


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    rates, rows = vector_limit(), []
    for title, make, name in CASES:
        problem = make()
        y0 = np.asarray(problem.random_state(0))
        h = gi.find_method(name).step_fraction * characteristic_time(problem, y0)
        done = operations(problem, y0, name, h)
        flow = find_method(name).on(problem, y0, compiled=False)
        rate = rates["lanes" if flow.stages_in_lanes else "single"]
        took = seconds(problem, y0, name, h, arguments.repeats)
        limit = 0.5 * done["plain"] / rate
        rows.append({
            "system": title, "method": name, "step": h, "in_lanes": flow.stages_in_lanes,
            "operations": done["plain"], "divisions_and_roots": done.get("slow", 0.0),
            "bytes": 8.0 * done["memory"], "limit_ns": 1e9 * limit, "step_ns": 1e9 * took,
            "ratio": took / limit,
        })  # fmt: skip
        print(
            {k: v if isinstance(v, str) else round(v, 1) for k, v in rows[-1].items()}, flush=True
        )
    path = arguments.out / "kernel_limits.json"
    record = {
        "benchmark": "kernel-limits", "rates": rates, "rows": rows,
        "machine": describe(["geomint", "numba", "numpy"]),
    }  # fmt: skip
    path.write_text(json.dumps(record, indent=1), encoding="utf-8")
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
