"""The benchmarks of Brouwer's law and of the invariant measure.

The fit finds known exponents, and its short form the law. The measure, globally: an ensemble drawn
from a density and pushed forward keeps it, over 1000 steps. A right method fails in one of a thousand
choices of seeds; the multiplier of this sphere, and what heun-2 makes of energies, are seen by 1000
draws in 3 of 3 choices each, at 5 %.
"""

from __future__ import annotations

import importlib
import json
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from geomint.tableaux import RUNGE_KUTTA

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def scripts() -> Iterator[dict[str, ModuleType]]:
    """The files of the benchmark as modules."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "benchmarks"))
        names = ("brouwer", "brouwer_fit", "last_digits", "measure_globally")
        yield {name: importlib.import_module(name) for name in names}


STEPS = 10.0 ** np.arange(1.0, 4.25, 0.5)
DRAWN = {
    "walk": (0.5, lambda noise, n: np.cumsum(noise, axis=0)),
    "phase of a walk": (1.5, lambda noise, n: np.cumsum(np.cumsum(noise, axis=0), axis=0)),
    "bias": (1.0, lambda noise, n: n + 0.3 * np.cumsum(noise, axis=0)),
    "no growth": (0.0, lambda noise, n: noise),
}


@pytest.mark.parametrize("name", DRAWN)
def test_exponents_of_random_walks(name: str, scripts: dict[str, ModuleType]) -> None:
    right, make = DRAWN[name]
    noise = np.random.default_rng(1).normal(size=(10_000, 64))
    series = make(noise, np.arange(1.0, 10_001.0)[:, None])
    b, error = scripts["brouwer_fit"].exponent(STEPS, series[STEPS.astype(int) - 1])
    assert 0.0 < error < 0.06
    assert abs(b - right) < 4.0 * error + 0.02
    common = scripts["brouwer_fit"].common_part  # which tells a bias
    assert abs(common(noise[:1])[0]) < 0.4
    assert common(3.0 + 0.1 * noise[:1])[0] > 0.99


def test_chosen_digits_meet_the_conditions(scripts: dict[str, ModuleType]) -> None:
    """Which coefficients rounded one by one do not, by some roundings."""
    digits = scripts["last_digits"]
    assert max(map(abs, digits.defects(RUNGE_KUTTA["dop853"]))) > 2e-16
    chosen = digits.chosen_digits()
    assert max(map(abs, digits.defects(chosen))) < 4e-19
    table = RUNGE_KUTTA["dop853"]
    s = table.used_stages
    A, b = table.A_float[:s, :s], table.b_float[:s]
    assert np.all(np.abs(chosen.A_float - A) <= 2.0 * np.spacing(np.abs(A)))
    assert np.all(np.abs(chosen.b_float - b) <= 2.0 * np.spacing(np.abs(b)))


def law(found: dict[str, dict[str, dict[str, float]]], part: str, names: tuple[str, ...]) -> None:
    """Assert exponents of a short run: within what 16 members and three decades leave open."""
    for name in names:
        right = 1.5 if name == "phase" else 0.5
        assert abs(found[name][part]["exponent"] - right) < 0.25, name


@pytest.mark.nightly
def test_the_quick_form(scripts: dict[str, ModuleType], tmp_path: Path) -> None:
    """It writes JSON and a picture, and keeps methods that are not run anew."""
    where, main = ["--out", str(tmp_path), "--images", str(tmp_path)], scripts["brouwer"].main
    main(["--quick", *where])
    main(["--quick", "--methods", "dop853", *where])
    record = json.loads((tmp_path / "brouwer.json").read_text("utf-8"))
    found = {name: method["quantities"] for name, method in record["methods"].items()}
    assert set(found) == set(scripts["brouwer"].WAYS)
    assert record["members"] == len(record["seeds"]) == 16
    assert (tmp_path / "brouwer.png").stat().st_size > 10_000
    for quantities in found.values():
        law(quantities, "random", ("energy", "K"))
        assert quantities["phase"]["random"]["exponent"] > 1.0
    law(found["gauss-8"], "all", ("energy", "K", "norm", "tangency", "phase"))
    law(found["dop853"], "random", ("norm", "phase"))
    for name in ("verlet-8", "rattle-2"):  # constraints are met anew in every step
        for key in ("norm", "tangency"):
            assert max(found[name][key]["all"]["rms"]) < 2.0**-51


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore:.*steps of .* are so long:geomint.GeomintWarning")
def test_of_densities_and_methods_the_right_ones_keep_the_measure(scripts: Any) -> None:
    chances = scripts["measure_globally"].chances
    for seed in range(2):
        assert chances("gauss-8", seed, [1000], 999)[0] > 1e-3
    for case in ("gauss-8, uniform density", "heun-2"):
        assert chances(case, 0, [1000])[0] <= 0.05
