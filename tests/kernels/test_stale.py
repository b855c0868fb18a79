"""Compiled code follows every change: between processes, and between two runs of one process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling import cache
from tests.kernels import ways

# Of each kind one; all of them are compiled at night.
COMPILED = (
    "global",
    "array",
    "helper defined anew",
    "function of a local alias",
    "module as an argument",
    "getattr",
    "numba function",
    "address",
)


def run(folder: Path, seed: int, *names: str) -> dict[str, Any]:
    """Run the ways in a process of its own, with one cache folder for all."""
    done = subprocess.run(
        [sys.executable, "-W", "error", ways.__file__, str(folder), *names],
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


@pytest.mark.parametrize(
    "names", [COMPILED, pytest.param([*ways.WAYS], marks=pytest.mark.nightly)], ids=["some", "all"]
)
def test_code_follows_every_way(names: list[str], tmp_path: Path) -> None:
    """Four versions of each way: before and after a change, in two processes with an edit between.

    Fingerprints change with what is reached, by an edit or in place, and with nothing else; compiled
    code is what Python gives, or there is none.
    """
    ways.write(tmp_path)
    first = run(tmp_path, 1, *names)
    ways.write(tmp_path, "2.0", "3.0")
    second = run(tmp_path, 2, *names)
    for name, way in ways.WAYS.items():
        prints, outcomes = zip(*first[name], *second[name], strict=True)
        if way.outcome == ways.FOLLOWED:
            assert prints[0] not in prints[1:3], name
        if way.change in ("K = 3.0", "hlp.K = 3.0"):  # what the edit does too
            assert prints[1] == prints[2] == prints[3], name
        if name not in names:
            continue
        if way.outcome == ways.FOLLOWED:
            assert all(compiled == plain for compiled, plain in outcomes), name
            assert outcomes[0] != outcomes[1], name
        else:
            assert outcomes == (way.outcome,) * 4, name


def of(text: str = "return K", **names: Any) -> tuple[Any, dict[str, Any]]:
    """A recorded function of x and y, and its global names."""
    space: dict[str, Any] = {"gi": gi, **names}
    exec(f"def f(x, y=1.0):\n    {text}\n", space)
    return gi.helper(space["f"]), space


VALUES = [
    "True", "1", "1.0", "1 + 0j", "np.float64(1)", "np.int64(1)", "np.float32(1)", "np.bool_(True)",
    "0.0", "-0.0", "math.nan", "math.inf", "0", "None", "...", "'1'", "b'1'", "10**5000",
    "()", "(1,)", "[1]", "{1}", "frozenset([1])", "{1: 2}", "((1, 2), 3)", "(1, (2, 3))", "(1, 2, 3)",
    "np.array([1.0])", "np.array([1])", "np.array(1.0)", "np.array([[1.0]])", "np.ones(3000)",
    "np.r_[np.ones(1500), 2.0, np.ones(1499)]", "np.ones((2, 2))", "np.ones((2, 2), order='F')",
    "slice(1)", "range(1)", "np.float64", "np.float32", "np.dtype('f4')",
    "fractions.Fraction", "math.sin", "math.cos", "np.sin", "np.cos", "P(1)", "Q(1)", "P", "Q",
]  # fmt: skip
CODES = [
    "return x + y", "return x - y", "return y - x", "return x + 1.0", "return x + 1.5", "return -x",
    "return gi.sin(x)", "return gi.cos(x)", "return x[0]", "return x[1]", "return x if y else 1.0",
    "return (lambda z: z + x)(y)", "return (lambda z: z - x)(y)", "return f(y, x)",
]  # fmt: skip


@pytest.mark.nojit
def test_values_and_code_have_fingerprints_of_their_own() -> None:
    """Equal numbers of other types, other bits, another nesting or layout are other values."""
    seen: dict[str, str] = {}
    imports = "import fractions, math\nimport numpy as np\nfrom collections import namedtuple\n"
    imports += "P, Q = namedtuple('P', 'a'), namedtuple('Q', 'a')\n"
    for text in VALUES:
        for _ in range(2):  # made anew it is the same
            names: dict[str, Any] = {}
            exec(imports, names)
            assert seen.setdefault(of(K=eval(text, names))[0].fingerprint, text) == text
    for text in CODES:
        for comment in ("", "  # a comment", "\n\n\ndef unused():\n    pass"):
            assert seen.setdefault(of(text + comment)[0].fingerprint, text) == text


@pytest.mark.nojit
def test_what_holds_itself_is_told_apart() -> None:
    """Though each part is as far as the other one's from what it holds."""
    a, b, c, d, e = ([float(i)] for i in (1, 2, 1, 2, 2))
    first, second = [a, b], [c, e]
    for one, other in ((a, b), (b, a), (c, d), (d, c), (e, second)):
        one.append(other)
    told = {gi.helper(lambda x, top=top: x + top[0][0]).fingerprint for top in (first, second)}
    assert len(told) == 2


def test_what_is_as_it_was_is_not_walked_again() -> None:
    """A second look compares; names that are set to an equal value lead to the same fingerprint."""
    f, space = of("return K * A[0]", K=2.0, A=np.array([1.0]))
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
        f, space = of(K=array)
        assert f.reach.kept == kept
        first = f.fingerprint
        assert f.fingerprint == first
        space["K"] = array.copy()
        assert (f.fingerprint == first) == kept


@pytest.mark.nojit
def test_containers_are_compared_by_what_they_hold() -> None:
    """Of whatever kind, however deep, and in a circle."""
    f, space = of(K={"a": ([1.0], {2.0})})
    seen = {f.fingerprint}
    for change in ("K['a'][0].append(2.0)", "K['a'][1].add(3.0)", "K['b'] = 1", "K['b'] = 1.0",
                   "K['a'][0].append(K)"):  # fmt: skip
        exec(change, space)
        assert f.fingerprint not in seen
        seen.add(f.fingerprint)


@pytest.mark.nojit
def test_recorded_functions_are_functions() -> None:
    """They can be called, keep name and doc, may be recorded again, and refer to each other."""

    @gi.helper
    def half(x):
        """Halve."""
        return 0.5 * x

    assert half(3.0) == 1.5
    assert (half.__name__, half.__doc__) == ("half", "Halve.")
    assert "half" in repr(half)
    assert gi.helper(half).function is half.function
    assert gi.helper(lambda x: x)(2) == 2
    for wrong in (np.sin, 3, None, "f"):
        with pytest.raises(TypeError, match="written with def"):
            gi.field(wrong)
    space: dict[str, Any] = {"gi": gi}
    exec("even = gi.helper(lambda n: n == 0 or odd(n - 1))", space)
    exec("odd = gi.helper(lambda n: n != 0 and even(n - 1))", space)
    assert space["even"].fingerprint != space["odd"].fingerprint
    exec("one, two = gi.helper(lambda n: two(n)), gi.helper(lambda n: back(n))", space)
    seen = {space.update(back=space[name]) or space["one"].fingerprint for name in ("one", "two")}
    assert len(seen) == 2


def test_code_of_edited_sources_is_not_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Looked at when it is wanted, and when it is written: what was imported may be another text."""

    def kept(factor: float, name: str) -> bool:
        def function(params, t, y, out, work):
            out[0] = factor * y[0]

        function.__name__ = name
        gi.pointwise(gi.field(function), [], [[1.0]], rows=1)
        return any(path.name.startswith(f"{name}-") for path in tmp_path.rglob("*.nbc"))

    kept(2.0, "usual")  # the kernel that calls it is kept where others look
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert kept(3.0, "before")
    times = {path: (0, *rest) for path, (_, *rest) in cache.STARTED.items()}
    monkeypatch.setattr(cache, "sources", lambda: times)
    monkeypatch.setattr(cache, "_notes", {})
    with pytest.warns(gi.GeomintWarning, match="changed after this process began"):
        assert not kept(4.0, "after")
    monkeypatch.undo()
    for started in ({}, times):  # a process that began with others, or could not see them
        with monkeypatch.context() as patch:
            patch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
            patch.setattr(cache, "STARTED", started)
            patch.setattr(cache, "_notes", {})
            cache.sources_edited.cache_clear()
            with pytest.warns(gi.GeomintWarning, match="changed after this process began"):
                assert not kept(5.0, "never")
            assert not kept(6.0, "never")
    cache.sources_edited.cache_clear()
