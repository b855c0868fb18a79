"""Compiled code follows every change: between processes, and between two runs of one process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.recorded import Recorded
from tests.kernels import ways

# Of each kind one; all of them are compiled at night.
COMPILED = (
    "global",
    "array",
    "closure",
    "helper defined anew",
    "function of a local alias",
    "module as an argument",
    "getattr",
    "numba function",
    "jitable",
    "address",
)


def run(folder: Path, task: str, seed: int, *names: str) -> dict:
    """Run the ways in a process of its own, with one cache folder for all."""
    done = subprocess.run(
        [sys.executable, "-W", "error", ways.__file__, str(folder), task, *names],
        env={
            **os.environ,
            "NUMBA_CACHE_DIR": str(folder / "cache"),
            "PYTHONHASHSEED": str(seed),
            "PYTHONDONTWRITEBYTECODE": "1",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout.splitlines()[-1])


def run_twice(folder: Path, task: str, *names: str) -> tuple[dict, dict]:
    """Run the ways, edit all their files, and run them again."""
    ways.write(folder)
    first = run(folder, task, 1, *names)
    ways.write(folder, "2.0", "3.0")
    return first, run(folder, task, 2, *names)


def test_fingerprints_follow_every_way(tmp_path: Path) -> None:
    """They change with what is reached, by an edit or in place, and with nothing else."""
    first, second = run_twice(tmp_path, "fingerprint")
    for name, way in ways.WAYS.items():
        if way.outcome == ways.FOLLOWED:
            assert first[name][0] != first[name][1], name
            assert first[name][0] != second[name][0], name
        if way.change in ("K = 3.0", ways.HLP):  # what the edit does too, in the other process
            assert first[name][1] == second[name][0] == second[name][1], name


def check_compiled(folder: Path, *names: str) -> None:
    """Check that compiled code is what Python gives, or that there is none."""
    outcomes = run_twice(folder, "compile", *names)
    for name in names or ways.WAYS:
        expected = ways.WAYS[name].outcome
        found = [result for outcome in outcomes for result in outcome[name]]
        if expected == ways.FOLLOWED:
            for compiled, plain in found:
                assert compiled == plain, name
            assert found[0] != found[1], name
        else:
            assert found == [expected] * 4, name


def test_compiled_code_follows(tmp_path: Path) -> None:
    """Four versions of each way: before and after a change, in two processes with an edit between."""
    check_compiled(tmp_path, *COMPILED)


@pytest.mark.nightly
def test_compiled_code_follows_every_way(tmp_path: Path) -> None:
    """The same for all that we know."""
    check_compiled(tmp_path)


VALUES = [
    "True", "1", "1.0", "1 + 0j", "np.float64(1)", "np.int64(1)", "np.float32(1)", "np.bool_(True)",
    "0.0", "-0.0", "math.nan", "math.inf", "0", "None", "...", "'1'", "b'1'", "10**5000",
    "()", "(1,)", "[1]", "{1}", "frozenset([1])", "{1: 2}", "((1, 2), 3)", "(1, (2, 3))", "(1, 2, 3)",
    "np.array([1.0])", "np.array([1])", "np.array(1.0)", "np.array([[1.0]])", "np.ones(3000)",
    "np.r_[np.ones(1500), 2.0, np.ones(1499)]", "np.ones((2, 2))", "np.ones((2, 2), order='F')",
"slice(1)", "range(1)", "np.float64", "np.float32", "np.dtype('f4')",
    "fractions.Fraction", "math.sin", "math.cos", "np.sin", "np.cos", "P(1)", "Q(1)", "P", "Q",
]  # fmt: skip


@pytest.mark.nojit
def test_values_have_fingerprints_of_their_own() -> None:
    """Equal numbers of other types, other bits, another nesting or layout are other values."""
    space = {"K": None}
    exec("def f(x):\n    return K\n", space)
    f, seen = Recorded(space["f"]), {}
    imports = "import fractions, math\nimport numpy as np\nfrom collections import namedtuple\n"
    imports += "P, Q = namedtuple('P', 'a'), namedtuple('Q', 'a')\n"
    for text in VALUES:
        for _ in range(2):  # made anew it is the same
            names: dict = {}
            exec(imports, names)
            space["K"] = eval(text, names)
            assert seen.setdefault(f.fingerprint, text) == text


@pytest.mark.nojit
def test_what_is_as_it_was_is_not_walked_again() -> None:
    """A second look compares; names that are set to an equal value lead to the same fingerprint."""
    space: dict = {"K": 2.0, "A": np.array([1.0])}
    exec("def f(x):\n    return K * A[0]\n", space)
    f = Recorded(space["f"])
    first = f.reach
    assert f.reach is first
    space["unused"] = 1.0
    assert f.reach is first
    space["K"] = float("2.0")
    assert f.reach is not first
    assert f.fingerprint == first.fingerprint
    space["A"][0] = 2.0
    assert f.fingerprint != first.fingerprint
    space["A"][0] = 1.0
    assert f.fingerprint == first.fingerprint


@pytest.mark.nojit
def test_arrays_that_are_not_copied_count_by_address() -> None:
    """Compiled code reads large and strided arrays where they are, not an equal one's memory."""
    for array, kept in ((np.ones(3), True), (np.ones(200_000), False), (np.ones(6)[::2], False)):
        space: dict = {"K": array}
        exec("def f(x):\n    return K\n", space)
        f = Recorded(space["f"])
        assert f.reach.kept == kept
        first = f.fingerprint
        assert f.fingerprint == first
        space["K"] = array.copy()
        assert (f.fingerprint == first) == kept


@pytest.mark.nojit
def test_containers_are_compared_by_what_they_hold() -> None:
    """Of whatever kind, and however deep."""
    inner = [1.0]
    space: dict = {"K": {"a": (inner, {2.0})}}
    exec("def f(x):\n    return K\n", space)
    f = Recorded(space["f"])
    seen = {f.fingerprint}
    for change in ("K['a'][0].append(2.0)", "K['a'][1].add(3.0)", "K['b'] = 1", "K['b'] = 1.0"):
        exec(change, space)
        assert f.fingerprint not in seen
        seen.add(f.fingerprint)
    space["K"]["a"][0].append(space["K"])  # in a circle
    assert f.fingerprint not in seen


def test_edited_sources_are_not_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A process that may run other sources than lie on the disk writes nothing for others."""
    from geomint.kernels.compiling import cache
    from geomint.kernels.compiling.compile import _entry

    monkeypatch.setattr(cache, "STARTED", {})
    monkeypatch.setattr(cache, "_notes", {})
    cache.sources_edited.cache_clear()
    try:
        made = _entry(gi.helper(lambda x: x))
        assert getattr(getattr(made, "_cache", None), "_folder", None) is None
        assert "changed after this process began" in cache.take_note()
        assert cache.take_note() == ""
    finally:
        cache.sources_edited.cache_clear()


def test_code_after_an_edit_is_not_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Looked at when it is written: what was imported since may be another text."""
    from geomint.kernels.compiling import cache

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def before(params, t, y, out, work):
        out[0] = 3.0 * y[0]

    def after(params, t, y, out, work):
        out[0] = 4.0 * y[0]

    gi.pointwise(gi.field(before), [], [[1.0]], rows=1)
    times = {path: (0, *rest) for path, (_, *rest) in cache.STARTED.items()}
    monkeypatch.setattr(cache, "sources", lambda: times)
    monkeypatch.setattr(cache, "_notes", {})
    with pytest.warns(gi.GeomintWarning, match="changed after this process began"):
        gi.pointwise(gi.field(after), [], [[1.0]], rows=1)
    kept = {path.name.partition("-")[0] for path in tmp_path.rglob("*.nbc")}
    assert "before" in kept
    assert "after" not in kept
