"""The kept runs find a change of one last bit, wherever it is planted."""

from __future__ import annotations

import re
import shutil
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pytest

from tests.kept import compare

pytestmark = pytest.mark.nightly
ROOT = Path(__file__).parents[2]
# Where a number is moved to its neighbour, as a pattern of the sources whose group is the number, or
# what computes it; a run of the quick ones that finds it; what is written there, if it is no number.
PLANTS = {
    "coefficients of tableaux": (r"return read_only\(\[(float\(value\)) for", "methods/rk-4", None),
    "RATTLE": (r"half = like\((0\.5) \* h, q\[0\]\)", "methods/rattle-2", None),
    "the series of dexp⁻¹": (r"even, 1 / 30240\.0\), (1 / 12\.0)\)", "methods/rkmk-4", None),
    "the exponential of SO(3)": (r"fma\(q, a_odd, (1 / 6\.0)\)", "methods/cf-4", None),
    "half a step of a splitting": (r"half = (0\.5) \* whole\n    first", "methods/verlet-2", None),
    "sine": (r"rest \+= cube \* (1\.6666\d*e-01)\n", "values/functions", None),
    "the default step": (r"return (self\.step_fraction) \* char", "along/states rk-4", None),
    "windows of drifts": (r"times\[:used\], (deviations\[:, :used\])\n", "watch/plain rk-4", None),
    "the root of an event": (
        r"theta = (root\(orbit, node, a, b, .*\))\n",
        "along/events rk-4",
        "(1.0 + 2.0**-50) * {}",  # of the root's last bit times lose some
    ),
    "seeds of draws": (
        r"1\), np\.random\.default_rng\((whole\(.*\))\)\n",
        "series/draws",
        "1 + {}",
    ),
    "angles of exact motions": (r"start\[j\] \+ (4\.0) \* np\.pi", "exact/hamiltonized-n3", None),
    "digits of the terminal": (
        r"digits: int = (3)\) -> str",
        "quick_commands/drift neumann-n3 --t-end*",
        "4",
    ),
    "numbers of JSON": (
        r"return (value) if math\.isfinite",
        "quick_commands/drift neumann-n3 --t-end*",
        None,
    ),
}


def planted(text: str, start: int, end: int, other: str | None) -> str:
    """Return a source with a number moved up by one last bit, or with something else there."""
    own = text[start:end]
    try:
        moved = repr(float(np.nextafter(float(own), np.inf)))
    except ValueError:
        moved = f"{1.0 + 2.0**-52!r} * {own}"
    return text[:start] + (other.format(own) if other else moved) + text[end:]


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("compiled")


@pytest.mark.parametrize("name", PLANTS)
def test_a_planted_bit_is_found(name: str, cache: Path, tmp_path: Path) -> None:
    """In a copy of this checkout."""
    pattern, runs, other = PLANTS[name]
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    shutil.copytree(ROOT / "src", tmp_path / "src")
    sources = [(path, path.read_text("utf-8")) for path in tmp_path.rglob("*.py")]
    found = [(path, match) for path, text in sources for match in re.finditer(pattern, text)]
    assert len(found) == 1, f"{name!r} applies no more: {len(found)} places have {pattern}"
    path, match = found[0]
    path.write_text(planted(match.string, *match.span(1), other), "utf-8")
    old, new = compare.both([ROOT, tmp_path], [runs], [cache, cache])
    assert all(any(fnmatchcase(run, quick) for quick in compare.QUICK) for run in new.names)
    assert compare.compare(old, new, strict=True) == 1


def test_a_checkout_is_as_itself(cache: Path) -> None:
    """Whatever the order of runs and the seed of hashes are."""
    patterns = ["along/*4", "values/*", "failures/*", "quick_commands/run*"]
    old, new = compare.both([ROOT, ROOT], patterns, [cache, cache])
    assert sorted(old.names) == sorted(new.names)
    assert list(old.found) == list(new.found)[::-1]
    assert compare.compare(old, new) == 0
