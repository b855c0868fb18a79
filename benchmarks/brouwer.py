"""Brouwer's law: how rounding errors of 64 random motions grow from 10⁴ to 10⁷ steps.

    python benchmarks/brouwer.py [--quick] [--methods NAME …]

D. Brouwer (Astron. J. 46 (1937) 149): where roundings are random, integrals err as √n after n steps,
and angles as n^1.5. One method of each family on the sphere of `hamiltonized_n3`, |p̃| = 1 at first: in
τ on the Hamiltonised flow, group methods in t on the reduced one; the exact flow is the truth.

- Errors are means over the states of the last tenth of n steps: those are rounded one by one, which a
  mean forgets, and so it does most of what truncation makes oscillate. Quantities are evaluated in
  long doubles. The phase is the distance of γ from that of the exact flow, rms over these states.
- Half of the members have a *twin* that begins 2⁻⁴⁸ faster. Truncation does the same to both, and so
  does whatever every step rounds alike; other roundings have nothing in common. So the difference of
  their errors, over √2, is the random part of one, whatever lies on top of it.
- Motions whose condition number is above 5, next to a separatrix, are left out.

``--quick`` goes to 10⁵ steps with 16 members, some seconds, and writes nothing but to ``--out`` and
``--images``. ``--methods`` runs some anew and keeps what there is of others; without a name after it
the picture alone is drawn anew.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import geomint as gi
import last_digits
from brouwer_fit import Array, common_part, exponent, rms
from brouwer_picture import picture
from brouwer_states import CONDITION, seeds, sphere, starts
from geomint.kernels.numbers.blocks import Block
from machine import describe

HERE = Path(__file__).parent
MEMBERS, STEPS = 64, 10_000_000
SAVED = 10_000  # states of a run
LATEST = 0.9  # errors at n are those from here to n
LOOKS = 20  # at so many of the states the exact flow is asked, at some twice where there are fewer


class Way(NamedTuple):
    """A method with its step, and the form of the sphere that it moves."""

    family: str
    method: str | gi.Method
    step: float
    physical: bool = False


# Steps at which truncation is below the random part at all numbers of steps, where there are such: not
# for methods of order 2 and 4, whose steps keep the phase below a turn.
DIGITS = last_digits.chosen_digits()
WAYS = {
    "dop853": Way("explicit Runge–Kutta", "dop853", 0.01),
    "dop853-digits": Way("the same, other last digits", gi.RungeKutta(DIGITS), 0.01),
    "verlet-8": Way("splitting, composed", "verlet-8", 0.02),
    "rattle-2": Way("RATTLE", "rattle-2", 0.002),
    "gauss-8": Way("Gauss", "gauss-8", 0.15),
    "rkmk-dop853": Way("Runge–Kutta–Munthe-Kaas", "rkmk-dop853", 0.05, physical=True),
    "rkmk-dop853-digits": Way("the same, other last digits", gi.RKMK(DIGITS), 0.05, physical=True),
    "cf-4": Way("commutator-free", "cf-4", 0.05, physical=True),
}
QUANTITIES = ("energy", "K", "norm", "tangency", "phase")


def quantities(problem: gi.Problem, y: Array) -> dict[str, Any]:
    """Return what the flow keeps at states, shape (..., 6), in long doubles."""
    rows = np.moveaxis(y, -1, 0).astype(np.longdouble)
    params, work = Block(problem.params), Block(np.zeros(problem.work))
    found = {k: problem.invariants[k](params, 0.0, Block(rows), work) for k in ("energy", "K")}
    gamma, p = rows[:3], rows[3:]
    found["norm"] = np.sum(gamma * gamma, axis=0) - 1.0
    found["tangency"] = np.sum(gamma * p, axis=0) / np.sqrt(np.sum(p * p, axis=0))
    return found


def legs(steps: int) -> Iterator[tuple[int, int, list[float]]]:
    """Yield steps of two runs, how many lie between saved states, and where errors are looked at.

    The shorter run is the beginning of the longer one, with more states.
    """
    powers = steps / 10.0 ** np.arange(3.0, -0.5, -0.5)
    short = steps // 100
    for length, wanted in ((short, powers[:3]), (steps, powers[3:])):
        yield length, max(length // SAVED, 1), wanted.tolist()


def errors(name: str, way: Way, given: Array, steps: int) -> tuple[Array, dict[str, Array]]:
    """Return numbers of steps and the errors there: (points, members), of the phase (…, looks, 3)."""
    problem = sphere(way.physical)
    truths = [problem.exact(y) for y in given]
    first = quantities(problem, given)
    numbers, found = [], {key: [] for key in QUANTITIES}
    for length, every, wanted in legs(steps):
        end = {"t_end" if way.physical else "tau_end": length * way.step}
        many = gi.solve_ensemble(
            problem, given, method=way.method, step=way.step, save_every=every, clock=False, **end
        )
        if not many.success:
            raise SystemExit(f"{name}: {many}")
        for n in wanted:
            late = slice(int(LATEST * n / every), round(n / every) + 1)
            for key, values in quantities(problem, many.y[:, late]).items():
                scale = first[key] if key in ("energy", "K") else np.longdouble(1.0)
                off = np.mean(values - first[key][:, None], axis=1) / scale
                found[key].append(off.astype(np.float64))
            found["phase"].append(off_course(truths, many, late, way.physical))
            numbers.append(n)
    return np.array(numbers), {key: np.array(values) for key, values in found.items()}


def off_course(truths: list[Any], many: Any, late: slice, physical: bool) -> Array:
    """Return by how much γ is off the exact flow at some of the states, (members, looks, 3)."""
    at = np.linspace(late.start, late.stop - 1, LOOKS).astype(int)
    times = many.tau[0, at]
    true = [exact(times) if physical else exact.at_tau(times) for exact in truths]
    return np.asarray(many.y[:, at, :3] - np.array(true)[..., :3])


def summary(numbers: Array, found: dict[str, Array], members: int) -> dict[str, Any]:
    """Return sizes and exponents of all errors, and of the random part of each."""
    pairs = members // 2
    result: dict[str, Any] = {}
    for key, off in found.items():
        whole, apart = off[:, :members], (off[:, :pairs] - off[:, members:]) / np.sqrt(2.0)
        record: dict[str, Any] = {}
        if key == "phase":
            whole, apart = (
                np.sqrt(np.mean(np.sum(d**2, axis=-1), axis=-1)) for d in (whole, apart)
            )
        else:
            record["common part"] = common_part(whole).tolist()
        for part, values in (("all", whole), ("random", apart)):
            b, error = exponent(numbers, values)
            record[part] = {"rms": rms(values).tolist(), "exponent": b, "error": error}
        result[key] = record
    return result


def show(name: str, record: dict[str, Any]) -> None:
    """Print the exponents of a method, and the sizes at the end."""
    print(f"{name}, step {record['step']:g}, {record['seconds']:.0f} s")
    for key, found in record["quantities"].items():
        parts = [
            f"{part} {one['rms'][-1]:.1e} ~ n^{one['exponent']:.2f}±{one['error']:.2f}"
            for part, one in ((part, found[part]) for part in ("all", "random"))
        ]
        common = found.get("common part", [np.nan])[-1]
        print(f"  {key:9} {parts[0]}   {parts[1]}   common part {common:+.2f}", flush=True)


def measured(names: Sequence[str], chosen: list[int], steps: int) -> dict[str, Any]:
    """Return what is found of each method."""
    found = {}
    for name in names:
        way, begun = WAYS[name], time.perf_counter()
        numbers, off = errors(name, way, starts(chosen, way.physical), steps)
        found[name] = {
            "family": way.family,
            "step": way.step,
            "time": "t" if way.physical else "tau",
            "steps": numbers.tolist(),
            "quantities": summary(numbers, off, len(chosen)),
            "seconds": time.perf_counter() - begun,
        }
        show(name, found[name])
    return found


def with_others(result: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return a result with what a file has of methods that were not run, in their order."""
    before = json.loads(path.read_text("utf-8")) if path.exists() else {"methods": {}}
    found = {**before["methods"], **result["methods"]}
    ran = result if result["methods"] else before
    return {**ran, "methods": {name: found[name] for name in WAYS if name in found}}


def main(given: Sequence[str] | None = None) -> dict[str, Any]:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--methods", nargs="*", choices=list(WAYS), default=list(WAYS))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--images", type=Path)
    arguments = parser.parse_args(given)
    out, images = arguments.out, arguments.images
    if not arguments.quick:
        out, images = out or HERE / "results", images or HERE.parent / "docs" / "images"
    members, steps = (16, 100_000) if arguments.quick else (MEMBERS, STEPS)
    chosen = seeds(members)
    print(f"{members} members, {steps} steps, seeds {chosen}", flush=True)
    result = {
        "benchmark": "brouwer",
        "members": members,
        "twins": members // 2,
        "seeds": chosen,
        "condition": CONDITION,
        "digits": last_digits.summary(),
        "methods": measured(arguments.methods, chosen, steps),
        "machine": describe(["geomint", "numba", "numpy"]),
    }
    if out is not None:
        path = out / "brouwer.json"
        result = with_others(result, path)
        path.write_text(json.dumps(result, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(f"wrote {path}")
    if images is not None:
        picture(result, images / "brouwer.png")
    return result


if __name__ == "__main__":
    main()
