"""How often is the class of a drift false, and how often missed? Families of series with known growth.

Every family is drawn with many seeds at three lengths and three sizes: 20 ε, which is within round-off,
2 ε √samples, which a random walk of roundings may reach, and 1e-6, which it may not; the scale is 1,
and values are rounded to multiples of ε as those of a quantity near 1 are. Writes
``results/drift_classes.json`` and the tables of the page on drift classes,
``docs/drift-classes-table.md``.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import machine  # noqa: F401 - the way to tests
from geomint.watch.drift import Drift
from tests.series import drift_of_series

HERE = Path(__file__).parent
EPSILON = 2.0**-52
LENGTHS = (200, 2_000, 20_000)
SIZES: dict[str, Callable[[int], float]] = {
    "round-off": lambda samples: 20.0 * EPSILON,
    "walk": lambda samples: max(2.0 * EPSILON * samples**0.5, 34.0 * EPSILON),
    "large": lambda samples: 1e-6,
}
Array = Any
Series = Callable[[np.random.Generator, Array], Array]


class Family(NamedTuple):
    """Series of times t in (0, 1], and the class that is right; `trend` is their rise over the run."""

    right: str
    series: Series
    trend: float | None = None
    amplitude: bool = False  # whether that grows, and the mean does not
    offset: bool = False  # whether all is made in the first step


def wave(rng: np.random.Generator, t: Array, low: float, high: float | None = None) -> Array:
    """Return a sine of `low` to `high` periods, fewer than a third of the samples, at any phase."""
    top = low if high is None else max(low, min(high, len(t) / 3.0))
    periods = np.exp(rng.uniform(np.log(low), np.log(top)))
    return np.sin(2.0 * np.pi * periods * t + rng.uniform(0.0, 2.0 * np.pi))


def walk(rng: np.random.Generator, t: Array) -> Array:
    """Return a random walk that reaches about 1."""
    return np.cumsum(rng.normal(size=len(t))) / len(t) ** 0.5


def noise(rng: np.random.Generator, t: Array) -> Array:
    """Return independent normal numbers."""
    return rng.normal(size=len(t))


def waves(count: int, low: float, high: float) -> Series:
    """Return sines of random sizes."""
    return lambda rng, t: sum(rng.normal() * wave(rng, t, low, high) for _ in range(count))


def step(rng: np.random.Generator, t: Array) -> Array:
    """Return a jump by 1 at a random time, not within a twentieth of the ends."""
    return np.where(t > rng.uniform(0.05, 0.95), 1.0, 0.0)


def pericentres(rng: np.random.Generator, t: Array) -> Array:
    """Return spikes, as the energy errors of eccentric orbits have them."""
    return np.exp(5.0 * (wave(rng, t, 4.0, 200.0) - 1.0))


def outlier(rng: np.random.Generator, t: Array) -> Array:
    """Return one large value above a noise."""
    series = 0.01 * rng.normal(size=len(t))
    series[rng.integers(len(t))] = 1.0
    return series


def above(trend: Series, part: float, low: float, high: float | None = None) -> Series:
    """Return a trend and an oscillation `part` as large."""
    return lambda rng, t: trend(rng, t) + part * wave(rng, t, low, high)


def power(exponent: float) -> Series:
    """Return a power of time of either sign."""
    return lambda rng, t: rng.choice([-1.0, 1.0]) * t**exponent


LINE, SQUARE, HALF = (lambda rng, t: t), (lambda rng, t: t**2), (lambda rng, t: t**1.5)


def bounded(series: Series) -> Family:
    """Return a family without a trend."""
    return Family("bounded", series, 0.0)


def growing(right: str, size: Callable[[Array], Array], low: float) -> Family:
    """Return a family of oscillations about 0 of this size."""
    return Family(right, lambda rng, t: size(t) * wave(rng, t, low, 1000.0), amplitude=True)


FAMILIES: dict[str, Family] = {
    "line": Family("linear", LINE, 1.0),
    "t^1.5": Family("faster", power(1.5)),
    "t²": Family("faster", power(2.0)),
    "exponential": Family("faster", lambda rng, t: np.exp(rng.uniform(5.0, 20.0) * t)),
    "random walk": Family("sqrt", walk),
    "random walk and noise": Family("sqrt", lambda rng, t: walk(rng, t) + 0.3 * noise(rng, t)),
    "random walk and oscillation": Family("sqrt", above(walk, 0.3, 20.0, 1000.0)),
    "oscillation, 3–8 periods": bounded(lambda rng, t: wave(rng, t, 3.0, 8.0)),
    "oscillation, 8–30 periods": bounded(lambda rng, t: wave(rng, t, 8.0, 30.0)),
    "oscillation, 30–1000 periods": bounded(lambda rng, t: wave(rng, t, 30.0, 1000.0)),
    "oscillation off centre": bounded(lambda rng, t: 3.0 + wave(rng, t, 30.0, 1000.0)),
    "three frequencies": bounded(waves(3, 4.0, 100.0)),
    "eight frequencies": bounded(waves(8, 10.0, 1000.0)),
    "beats": bounded(lambda rng, t: wave(rng, t, 60.0, 1000.0) * wave(rng, t, 4.0, 30.0)),
    "amplitude that oscillates": bounded(
        lambda rng, t: (1.0 + 0.5 * wave(rng, t, 4.0, 8.0)) * wave(rng, t, 20.0, 1000.0)
    ),
    "spikes at pericentres": bounded(pericentres),
    "white noise": bounded(noise),
    "quantised noise": bounded(lambda rng, t: np.round(0.7 * noise(rng, t))),
    "outlier": bounded(outlier),
    "amplitude 1 + t": growing("linear", lambda t: 1.0 + t, 4.0),
    "amplitude t": growing("linear", lambda t: t, 4.0),
    "amplitude t²": growing("faster", lambda t: t**2, 20.0),
    "jump": Family("jump", step),
    "jump in the first step": Family(
        "jump", lambda rng, t: 1.0 + 1e-10 * walk(rng, t), offset=True
    ),
    "jump and noise": Family("jump", lambda rng, t: step(rng, t) + 0.1 * noise(rng, t)),
    "jump and oscillation": Family("jump", above(step, 0.3, 3.0, 1000.0)),
    "oscillation, 0.7–2 periods": Family("undetermined", lambda rng, t: wave(rng, t, 0.7, 2.0)),
    "levelling off": Family(
        "undetermined", lambda rng, t: 1.0 - np.exp(-rng.uniform(3.0, 12.0) * t)
    ),
    "line and 0.5 noise": Family("linear", lambda rng, t: t + 0.5 * noise(rng, t), 1.0),
    "line and 0.1 random walk": Family("linear", lambda rng, t: t + 0.1 * walk(rng, t), 1.0),
    "line and outlier": Family("linear", lambda rng, t: 0.3 * t + outlier(rng, t), 0.3),
    "line and 0.5 sine, 8.3 periods": Family("linear", above(LINE, 0.5, 8.3), 1.0),
    "line and 1 sine, 20.3 periods": Family("linear", above(LINE, 1.0, 20.3), 1.0),
    **{
        f"line and {part:g} sine": Family("linear", above(LINE, part, 3.0, 300.0), 1.0)
        for part in (0.1, 0.2, 0.3, 1.0, 3.0, 10.0)
    },
    **{
        f"t² and {part:g} sine": Family("faster", above(SQUARE, part, 3.0, 300.0))
        for part in (0.1, 0.3, 1.0, 3.0)
    },
    **{
        f"t^1.5 and {part:g} sine": Family("faster", above(HALF, part, 3.0, 300.0))
        for part in (0.3, 1.0)
    },
    "t² and 0.1 random walk": Family("faster", lambda rng, t: t**2 + 0.1 * walk(rng, t)),
}


def right_classes(family: Family, size: str) -> set[str]:
    """Return what a series of this family may be called at this size."""
    if family.right == "bounded" and size == "round-off":
        return {"roundoff"}
    if family.offset and size == "round-off":
        return {"roundoff", "jump"}  # one rounding, and no change after it
    if family.amplitude and size == "round-off":
        return {"roundoff", family.right}  # the means have no trend
    if family.right == "sqrt" and size == "large":
        return {"undetermined"}  # no rounding is so large
    return {family.right}


def drawn(family: Family, samples: int, size: str, seed: int) -> tuple[Drift, float | None]:
    """Return the drift of one series of the family, and its true trend over the run."""
    rng = np.random.default_rng([seed, samples])
    t = np.arange(1, samples + 1) / samples
    series = np.asarray(family.series(rng, t), dtype=np.float64)
    factor = SIZES[size](samples) / float(np.abs(series).max())
    values = EPSILON * np.round(series * factor / EPSILON)
    true = None if family.trend is None else abs(family.trend) * factor
    return drift_of_series("v", 100.0 * t, values, 1.0), true


def rates(name: str, samples: int, size: str, seeds: int) -> dict[str, Any]:
    """Return how often each class was said, and how often the trend bound was too small."""
    family = FAMILIES[name]
    said: Counter[str] = Counter()
    exceeded = 0
    for seed in range(seeds):
        drift, true = drawn(family, samples, size, seed)
        said[drift.drift_class] += 1
        exceeded += true is not None and (drift.trend_bound or 0.0) < true * (1.0 - 2.0 / samples)
    right = right_classes(family, size)
    missed = said["undetermined"] if "undetermined" not in right else 0
    good = sum(said[kind] for kind in right)
    return {
        "family": name,
        "samples": samples,
        "size": size,
        "right": sorted(right),
        "said": dict(said.most_common()),
        "missed": missed / seeds,
        "false": (seeds - good - missed) / seeds,
        "bound_too_small": None if family.trend is None else exceeded / seeds,
    }


def table(cells: list[dict[str, Any]], seeds: int) -> str:
    """Return the rates as Markdown: of each length over all sizes."""
    lines = [
        f"| family | right class | {' | '.join(f'{n} samples' for n in LENGTHS)} | false as |",
        "|---|---|" + "---|" * (len(LENGTHS) + 1),
    ]
    for name, family in FAMILIES.items():
        own = [cell for cell in cells if cell["family"] == name]
        parts = []
        for samples in LENGTHS:
            here = [cell for cell in own if cell["samples"] == samples]
            false, missed = (
                100.0 * np.mean([cell[key] for cell in here]) for key in ("false", "missed")
            )
            parts.append(f"{false:.1f} / {missed:.0f}")
        wrong: Counter[str] = Counter()
        for cell in own:
            others = {*cell["right"], "undetermined"}
            wrong.update({kind: n for kind, n in cell["said"].items() if kind not in others})
        lines.append(f"| {name} | `{family.right}` | {' | '.join(parts)} | {', '.join(wrong)} |")
    told = f"python benchmarks/drift_classes.py --seeds {seeds}"
    return "\n".join([f"<!-- made by {told} -->", "", *lines, "", *_by_class(cells)]) + "\n"


def _by_class(cells: list[dict[str, Any]]) -> list[str]:
    """Return for each class how often it is said where it is wrong."""
    lines = [
        "| class | said where it is wrong | most in a cell | in |",
        "|---|---|---|---|",
    ]
    for kind in ("roundoff", "bounded", "jump", "sqrt", "linear", "faster"):
        where = [cell for cell in cells if kind not in cell["right"]]
        shares = [cell["said"].get(kind, 0) / sum(cell["said"].values()) for cell in where]
        worst = where[int(np.argmax(shares))]
        place = f"{worst['family']}, {worst['samples']} samples" if max(shares) else "–"
        lines.append(
            f"| `{kind}` | {100.0 * np.mean(shares):.2f} % | {100.0 * max(shares):.0f} % | {place} |"
        )
    bounds = [c["bound_too_small"] for c in cells if c["bound_too_small"] is not None]
    told = (
        f"The trend bound was below the true trend in {100.0 * np.mean(bounds):.2f} % of the series"
    )
    return [*lines, "", f"{told} that have one, in a cell in {100.0 * max(bounds):.0f} % at most."]


def main() -> None:
    """Measure all cells and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--results", type=Path, default=HERE / "results")
    parser.add_argument("--docs", type=Path, default=HERE.parent / "docs")
    arguments = parser.parse_args()
    cells = []
    for name in FAMILIES:
        for samples in LENGTHS:
            cells += [rates(name, samples, size, arguments.seeds) for size in SIZES]
        told = [cell["false"] for cell in cells[-len(SIZES) * len(LENGTHS) :]]
        print(f"{name}: false {100.0 * np.mean(told):.1f} %", flush=True)
    content = {"seeds": arguments.seeds, "cells": cells}
    path = arguments.results / "drift_classes.json"
    path.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    text = table(cells, arguments.seeds)
    (arguments.docs / "drift-classes-table.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
