"""Compiled code on disk: found by the next process, never stale, and never in the way."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import geomint as gi
from geomint.kernels.compiling import cache
from geomint.kernels.compiling.compile import listen

FIELD = """
import geomint as gi


@gi.field
def spring(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * gi.sin(y[0])
"""
COMPILING = "geomint: compiling (once, then kept in the cache)\n"  # what a script is told, once
STRICT = ("-W", "error", "-W", "ignore:steps of")


def run(*arguments: str, cache: Path | None = None, **environment: str) -> Any:
    """Run Python on a cache folder; return what it prints."""
    own = {"NUMBA_CACHE_DIR": str(cache)} if cache else {}
    done = subprocess.run(
        [sys.executable, *STRICT, *arguments],
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **own, **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert done.stderr in ("", COMPILING)
    return json.loads(done.stdout)


def evaluated(
    source: str = FIELD, module: str = "__main__", file: str = "cell", name: str = "spring"
) -> tuple[list[str], list[float]]:
    """What is compiled, and what comes of it, for a function made anew, as another process does."""
    space: dict[str, Any] = {"__name__": module}
    exec(compile(source, file, "exec"), space)
    space["spring"].function.__name__ = name
    seen: list[str] = []
    end = listen(lambda name, seconds: seen.append(name))
    try:
        found = gi.pointwise(space["spring"], [1.5], [[0.5, 0.3], [0.1, 0.2]], rows=2)
    finally:
        end()
    return [each for each in seen if each == name], found.ravel().tolist()


# Two functions of one name, of one and of another process. What differs is in a helper, in a function
# of the kernel layer, or in a method of the same kernel. The helper comes first: until then both
# processes have compiled as many functions, so that symbols have the same numbers.
NAMESAKES = {
    "helper": ("first(y[0]) - first(t)", "second(y[0]) - second(t)"),
    "function": ("-gi.sin(y[0])", "-gi.cos(y[0])"),
    "choice": ("-gi.select(y[0] > 0.2, y[0], 0.1)", "-gi.maximum(0.1, y[1])"),
}
# Too long to be inlined twice: what is inlined has no symbol that could be taken for another.
BODY = "        q = q + sign * gi.sin(q) * gi.cos(2.0 * q)\n" * 12
SCRIPT = f"""
import json, os, sys, warnings
import numba  # which sets variables of its own
environment, filters = dict(os.environ), list(warnings.filters)
import geomint as gi
from geomint.kernels.compiling.compile import listen


def made(sign):
    @gi.helper
    def force(q):
{BODY}        return q

    return force


def evaluated():
    return gi.pointwise(spring, [1.5], [[0.5, 0.3]], rows=2).tolist()


def solved():
    problem = gi.Problem("pendulum", (("q", 1), ("p", 1)), [1.5], field=spring)
    return gi.solve(problem, [0.5, 0.3], t_end=1.0, step=0.1, method="heun-2").y[-1].tolist()


first, second = made(-1.0), made(-2.0)
seen, results = [], []
listen(lambda name, seconds: seen.append(name))
for name, *texts in map(json.loads, sys.argv[1:]):
    del seen[:]
    found = []
    for text in texts:
        exec(text)
        found.append(globals()[name]())
    results.append([[*seen], found])
assert dict(os.environ) == environment
assert [f for f in warnings.filters if f not in filters] == []
print(json.dumps(results))
"""


CALLER = """
import geomint as gi
from geomint.kernels.solve.own import scaled as one
from geomint.methods.own import scaled as two


@gi.field
def spring(params, t, y, out, work):
    out[0] = one(y[0])
    out[1] = two(y[0])
"""
KERNEL = """
from geomint.kernels.compiling.recorded import inlined
K = 2.0


@inlined
def scaled(x):
    return K * x
"""


def test_a_later_process_compiles_nothing(tmp_path: Path) -> None:
    """Nor where files are younger than the clock; variables, filters and streams are left alone.

    A process that finds the code of two others in the cache runs each for itself. Where a kernel was
    edited, wherever it stands, what calls it is compiled anew, and nothing else.
    """
    shutil.copytree(Path(gi.__file__).parent, tmp_path / "geomint")
    for path in (tmp_path / "geomint" / "kernels").rglob("*.py"):
        os.utime(path, (2.0**32, 2.0**32))
    (tmp_path / "fields.py").write_text(FIELD, encoding="utf-8")

    kernels = [tmp_path / "geomint" / room / "own.py" for room in ("kernels/solve", "methods")]
    for path in kernels:
        path.write_text(KERNEL, encoding="utf-8")
    scaled: list[Any] = []

    def told(*asked: list[str]) -> Any:
        own = {"cache": tmp_path / "cache", "PYTHONPATH": str(tmp_path)}
        texts = map(json.dumps, [*asked, ["evaluated", CALLER]])
        *found, (compiled, [[values]]) = run("-c", SCRIPT, *texts, **own)
        scaled.append([compiled, values])
        if kernels:
            kernels.pop().write_text(KERNEL.replace("2.0", "3.0"), encoding="utf-8")
        return found

    one, two = (
        [FIELD.replace("-params[0] * gi.sin(y[0])", forces[k]) for forces in NAMESAKES.values()]
        for k in (0, 1)
    )
    imported, other = "from fields import spring", FIELD.replace("gi.sin(y[0])", "y[0]")
    (seen, first), (compiled, ends) = told(["evaluated", *one], ["solved", imported])
    assert seen.count("spring") == 2 * len(NAMESAKES)
    assert len({*compiled} - {"spring"}) == 1  # a stepper
    (seen, second), again, changed = told(
        ["evaluated", *two], ["solved", imported], ["solved", other]
    )
    assert seen.count("spring") == 2 * len(NAMESAKES)
    assert again == [[], ends]
    assert {*changed[0]} == {"spring"}  # it needs no kernel compiled anew
    assert changed[1] != ends
    assert told(["evaluated", *one, *two]) == [[[], first + second]]
    assert all(x != y for x, y in zip(first, second, strict=True))
    anew = ["spring"] * 2
    assert scaled == [[anew, [1.0, 1.0]], [anew, [1.0, 1.5]], [anew, [1.5, 1.5]]]


ODD_NAMES = ("../../../escape", "H/m", "ü" * 130, "a\nb", "\0", "\udcff")


@pytest.mark.parametrize(
    "where",
    [
        {"file": "<ipython-input-1-abc>"},
        {"file": "/tmp/ipykernel_123/456.py"},
        {"module": "other_thing"},
        *({"name": name} for name in ODD_NAMES),
    ],
)
def test_functions_of_any_origin(
    where: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cells have no file; what gives a function a module's name is not imported; names are no paths."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "c"))
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "other_thing.py").write_text("raise SystemExit")
    (compiled, first), (found, second) = evaluated(**where), evaluated(**where)
    assert (len(compiled), found) == (2, [])
    assert first == second
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert {path.parent.parent.name for path in files} - {tmp_path.parent.name} == {"geomint"}
    assert "other_thing" not in sys.modules


def test_an_edited_compiler_empties_the_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The folder's name is a hash of its sources."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    before = cache.cache_folder().path
    assert before.parent == tmp_path / "geomint"
    shutil.copytree(Path(cache.__file__).parents[1], tmp_path / "kernels")
    (tmp_path / "kernels" / "numbers" / ".#lock.py").symlink_to("nowhere")  # of an editor
    own = cache.sources.__globals__
    monkeypatch.setitem(own, "__file__", str(tmp_path / "kernels" / "__init__.py"))

    def folder() -> Path:
        cache.kernel_stamp.cache_clear()
        return cache.cache_folder().path

    try:
        assert folder() == before
        for name in ("compiling/compile.py", "numbers/lanes.py"):
            (tmp_path / "kernels" / name).write_text("LANES = 8\n", encoding="utf-8")
            assert folder() != before
            before = folder()
    finally:
        cache.kernel_stamp.cache_clear()


def test_the_default_folder_is_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Not beside the sources, which may not be writable."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert Path(cache.__file__).parent not in cache.cache_folder().path.parents
    if sys.platform.startswith("linux"):
        assert cache.cache_folder().path.parent == tmp_path / "geomint"
