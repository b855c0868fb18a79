"""Frequencies from runs: weighted Birkhoff averages and Laskar's method, against the exact ones.

Random states of integrable systems whose exact frequencies are known; signals are two components of γ
whose angle turns. Every frequency of a signal is a half whole combination of the exact ones: the error
is the distance from the nearest one, over the largest exact frequency. From samples of the exact flow
and from runs by gauss-8 at its default step, for growing numbers of samples, and beside them the peak
of a plain Fourier transform. Then what the digits tell: the system of Hénon and Heiles at three
energies, beside the verdict of Lyapunov exponents.
"""

from __future__ import annotations

import argparse
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np

import geomint as gi
from geomint.plots.canvas import new_figure
from geomint.plots.style import COLOURS, WIDTH
from geomint.problems.testproblems import henon_heiles
from henon_heiles_states import states
from machine import describe

SCENES = ("hamiltonized-n3", "sphere-n3", "veselova-n3")
COUNTS = (500, 1000, 2000, 4000, 8000, 16000, 32000)
PER_PERIOD, WHOLE = 12.0, 24  # samples; half whole combinations up to that
ENERGIES, END, STEP = (1.0 / 12.0, 1.0 / 8.0, 1.0 / 6.0), 10_000.0, 0.4


def plane(y: np.ndarray) -> np.ndarray:
    """Return the two components of γ whose angle is known best: the signal that a user would take."""
    pairs = [y[:, i] + 1j * y[:, j] for i, j in ((0, 1), (1, 2), (0, 2))]
    return max(pairs, key=lambda z: float(np.abs(z).min()))


def peak(z: np.ndarray, step: float) -> float:
    """Return the frequency of the largest line of a plain Fourier transform."""
    frequencies = 2.0 * np.pi * np.fft.fftfreq(len(z), step)
    return float(frequencies[int(np.argmax(np.abs(np.fft.fft(z))))])


def errors(name: str, seed: int) -> list[dict[str, Any]]:
    """Return errors of all methods for all numbers of samples from a random state."""
    problem = gi.load_scene(name).problem
    y0 = problem.random_state(seed)
    motion = problem.exact(y0)
    own = problem.time == "tau"
    omega = np.atleast_1d(motion.frequencies if own else motion.mean_frequencies)
    whole = 0.5 * np.arange(-WHOLE, WHOLE + 1)
    lines = np.add.outer(whole * omega[0], whole * omega[-1]).ravel()
    size = float(np.abs(omega).max())
    step = 2.0 * np.pi / (PER_PERIOD * size)
    times = step * np.arange(COUNTS[-1] + 1)
    end = {"tau_end" if own else "t_end": times[-1]}
    wanted = {"tau_eval" if own else "t_eval": times}
    run = gi.solve(
        problem, y0, **end, **wanted, method="gauss-8", **({"clock": False} if own else {})
    )
    exact = motion.at_tau(times) if own else motion(times)
    rows = []
    for source, samples in (("exact flow", exact), ("gauss-8", run.y)):
        for count in COUNTS:
            z = plane(samples[: count + 1])
            average = gi.rotation_number(z, step)
            found = {
                "birkhoff": average.value,
                "laskar": gi.frequencies(z, step, order=5)[0].frequency,
                "peak": peak(z, step),
            }
            off = {key: float(np.abs(lines - x).min()) / size for key, x in found.items()}
            rows.append({"scene": name, "seed": seed, "source": source, "samples": count,
                         "periods": count / PER_PERIOD, "digits": average.digits, **off})  # fmt: skip
    return rows


def verdicts(count: int) -> dict[str, Any]:
    """Return how often the digits and the exponents say what, and the digits of all motions."""
    problem, result = henon_heiles.problem(), {}
    for energy in ENERGIES:
        found = []
        for y0 in states(energy, count, 2):
            told = gi.lyapunov(problem, y0, t_end=END, method="gauss-8", step=STEP, count=1)
            run = gi.solve(problem, y0, t_end=END, method="gauss-8", step=STEP, save_every=1)
            average = gi.birkhoff_average(run.y**2)
            found.append([told.verdict, average.verdict, average.digits])
        pairs = [f"{a} by exponents, {b} by digits" for a, b, _ in found]
        counts = {pair: pairs.count(pair) for pair in sorted(set(pairs))}
        result[f"{energy:.6g}"] = {"counts": counts, "motions": found}
        print(f"energy {energy:.4f}: {counts}")
    return result


def table(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return geometric means and worst errors, of runs in which the angle turns."""
    result: dict[str, Any] = {}
    for source in ("exact flow", "gauss-8"):
        for count in COUNTS:
            here = [r for r in rows if r["source"] == source and r["samples"] == count]
            told = {}
            for key in ("birkhoff", "laskar", "peak"):
                values = np.maximum([r[key] for r in here], 1e-17)
                told[key] = {"mean": float(np.exp(np.log(values).mean())), "worst": values.max()}
            result.setdefault(source, {})[str(count)] = told
            print(source, count, {k: f"{v['mean']:.1e} {v['worst']:.1e}" for k, v in told.items()})
    return result


def picture(result: dict[str, Any], path: Path) -> None:
    """Draw errors over periods, and the digits of motions."""
    with new_figure(1.6 * WIDTH, 0.6 * WIDTH, layout="constrained") as figure:
        left, right = figure.subplots(1, 2)
        told = result["errors"]["exact flow"]
        periods = np.array([float(count) for count in told]) / PER_PERIOD
        names = {
            "peak": "peak of the transform",
            "laskar": "Laskar's method",
            "birkhoff": "weighted average",
        }
        for (key, label), color, marker in zip(names.items(), COLOURS, "sx.", strict=False):
            means, worst = (
                [one[key][which] for one in told.values()] for which in ("mean", "worst")
            )
            left.loglog(periods, means, marker=marker, color=color, label=label)
            left.loglog(periods, worst, ":", color=color)
        left.set(xlabel="periods", ylabel="relative error of a frequency", ylim=(1e-17, 1.0))
        left.legend(frameon=False, title="mean; dotted: worst")
        bins = np.arange(0.0, 16.5, 0.5)
        for (energy, one), color in zip(result["verdicts"].items(), COLOURS, strict=False):
            for verdict, filled in (("chaotic", False), ("regular", True)):
                digits = [d for said, _, d in one["motions"] if said == verdict]
                right.hist(digits, bins, histtype="stepfilled" if filled else "step", color=color,
                           alpha=0.5 if filled else 1.0, lw=1.4,
                           label=f"energy 1/{1 / float(energy):.0f}, {verdict}")  # fmt: skip
        right.set(xlabel="digits that a run and its halves agree in", ylabel="motions")
        right.legend(frameon=False, title="by exponents")
        figure.savefig(path, dpi=130)


def main() -> None:
    """Run the benchmark and write its results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--motions", type=int, default=80)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    images = Path(__file__).parents[1] / "docs" / "images"
    parser.add_argument("--images", type=Path, default=images)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore", gi.GeomintWarning)
    rows = [row for name in SCENES for seed in range(arguments.seeds) for row in errors(name, seed)]
    result = {
        "errors": table(rows),
        "verdicts": verdicts(arguments.motions),
        "states": arguments.seeds * len(SCENES),
        "machine": describe(["geomint", "numba", "numpy", "scipy"]),
    }
    path = arguments.out / "frequencies.json"
    path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    picture(result, arguments.images / "frequencies.png")


if __name__ == "__main__":
    main()
