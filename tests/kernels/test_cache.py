"""Compiled code on disk: found by the next process, never stale, and never in the way."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

# Runs what is given, then prints what was compiled, what missed the cache, and the results.
REPORT = """
import json
from geomint.kernels.compiling import compile as _compile
compiled, entries, make_entry = [], {}, _compile._entry
_compile.listen(lambda name, seconds: compiled.append(name))
_compile._entry = lambda recorded: entries.setdefault(recorded, make_entry(recorded))


def report(*results):
    misses = sum(sum(e.stats.cache_misses.values()) for e in entries.values())
    hits = sum(sum(e.stats.cache_hits.values()) for e in entries.values())
    specialisations = max(len(e.overloads) for e in entries.values())
    print(json.dumps([compiled, misses, hits, specialisations, [float(r) for r in results]]))
"""
FIELD = """
import geomint as gi


@gi.field
def spring(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -params[0] * gi.sin(y[0])


@gi.field
def energy(params, t, y, work):
    return 0.5 * y[1] * y[1] - params[0] * gi.cos(y[0])
"""
SOLVE = """
problem = gi.Problem(
    "pendulum", (("q", 1), ("p", 1)), [1.5], field=spring, invariants={"energy": energy}
)
for method in ("rk-4", "gauss-2"):
    sol = gi.solve(problem, [0.5, 0.3], t_end=1.0, step=0.1, method=method, observe="invariants")
report(*sol.y[-1], sol.drift["energy"].final_error)
"""
SOLVE_ONCE = SOLVE.replace('"rk-4", "gauss-2"', '"rk-4",')
# What does without a stepper: two functions of a user, each compiled alone.
POINTS = """
@gi.field
def turn(params, t, y, out, work):
    out[0] = params[0] * y[1]
    out[1] = -y[0]


found = [gi.pointwise(f, [1.5], [[0.5, 0.3], [0.1, 0.2]], rows=2) for f in (spring, turn)]
report(*found[0].ravel(), *found[1].ravel())
"""


class Outcome:
    """What a process printed by ``report``."""

    def __init__(self, output: str) -> None:
        self.compiled, self.misses, self.hits, self.specialisations, self.results = json.loads(
            output
        )


COMPILING = "geomint: compiling (once, then kept in the cache)\n"  # what a script is told, once
# Every warning an error, but one: what a test changes need not keep the energy.
STRICT = ("-W", "error", "-W", "ignore:steps of", "-W", "ignore:the invariant")


def run(*arguments: str, cache: Path, check: bool = True, **environment: str) -> Outcome:
    """Run Python on a cache folder."""
    done = subprocess.run(
        [sys.executable, *STRICT, *arguments],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    if check:
        assert done.returncode == 0, done.stderr[-3000:]
        assert done.stderr in ("", COMPILING)
    return Outcome(done.stdout.splitlines()[-1])


def written(path: Path, *texts: str) -> str:
    path.write_text("\n".join(texts), encoding="utf-8")
    return str(path)


def assert_found(first: Outcome, second: Outcome) -> None:
    """The first process compiled, the second did not, and both came to the same bits."""
    assert first.compiled
    assert first.misses
    assert second.compiled == []
    assert second.misses == 0
    assert second.hits == first.hits + first.misses
    assert second.results == first.results


def test_a_second_process_compiles_nothing(tmp_path: Path) -> None:
    """Neither for a field of a module, nor of a script, nor of ``python -c``; kernels are shared."""
    cache = tmp_path / "cache"
    written(tmp_path / "fields.py", FIELD)
    script = written(tmp_path / "script.py", REPORT, "from fields import *", SOLVE)
    first, second = (run(script, cache=cache) for _ in range(2))
    assert_found(first, second)
    assert (
        len(set(first.compiled) - {"spring", "energy"}) == 3
    )  # two steppers and the observers' loop

    # The same function of another module counts as another one, in whatever way that is run; it
    # needs no kernel compiled anew.
    main = written(tmp_path / "main.py", REPORT, FIELD, SOLVE)
    again = run(main, cache=cache)
    assert set(again.compiled) == {"spring", "energy"}
    assert_found(again, run("-c", REPORT + FIELD + SOLVE, cache=cache))
    assert again.results == first.results
    other = run("-c", REPORT + FIELD.replace("gi.sin(y[0])", "y[0]") + SOLVE, cache=cache)
    assert set(other.compiled) == {"spring"}
    assert other.results != first.results


@pytest.mark.nightly
def test_nothing_is_specialised_to_a_function(tmp_path: Path) -> None:
    """A stepper is compiled once for all fields: a call adds no specialisation."""
    two = SOLVE + FIELD.replace("gi.sin(y[0])", "y[0]") + SOLVE
    outcome = run("-c", REPORT + FIELD + two, cache=tmp_path)
    assert outcome.specialisations <= 2  # a field: for scalars and for lanes
    counts = {name: outcome.compiled.count(name) for name in outcome.compiled}
    assert counts.pop("spring") > 4
    assert counts.pop("energy") <= 4  # watched, and looked at where steps are long
    assert set(counts.values()) == {2}  # begun and done; the same energy is found in the cache


# Two functions of one name, of one and of another process. What differs is in the field itself, in a
# helper, in a function of the kernel layer, or in a method of the same kernel.
NAMESAKES = {
    "field": ("-params[0] * y[0]", "-y[0] * y[0] * y[0]"),
    "function": ("-gi.sin(y[0])", "-gi.cos(y[0])"),
    "helper": ("first(y[0]) - first(t)", "second(y[0]) - second(t)"),
    "choice": ("-gi.select(y[0] > 0.2, y[0], 0.1)", "-gi.maximum(0.1, y[1])"),
}


@pytest.mark.nightly
@pytest.mark.parametrize("kind", NAMESAKES)
def test_namesakes_are_kept_apart(kind: str, tmp_path: Path) -> None:
    """A process that finds the code of two others in the cache runs each for itself."""
    # Too long to be inlined twice: what is inlined has no symbol that could be taken for another.
    body = "        q = q + sign * gi.sin(q) * gi.cos(2.0 * q)\n" * 12
    helpers = f"""
import geomint as gi


def made(sign):
    @gi.helper
    def force(q):
{body}        return q

    return force


first, second = made(-1.0), made(-2.0)
"""
    sources = []
    for force in NAMESAKES[kind]:
        field = FIELD.replace("-params[0] * gi.sin(y[0])", force)
        sources.append(
            field
            + SOLVE.replace('"rk-4", "gauss-2"', '"gauss-2",')
            .replace("report(", "results += list(")
            .replace("*sol.y[-1]", "sol.y[-1]")
            .replace(', sol.drift["energy"].final_error', "")
        )
    start = REPORT + helpers + "results = []\n"
    end = "\nreport(*results)\n"
    separate = [run("-c", start + source + end, cache=tmp_path) for source in sources]
    assert all(outcome.compiled for outcome in separate)
    together = run("-c", start + sources[0] + sources[1] + end, cache=tmp_path)
    assert together.compiled == []
    assert together.results == separate[0].results + separate[1].results
    assert separate[0].results != separate[1].results


@pytest.mark.parametrize(
    "filename",
    ["<ipython-input-1-abc>", pytest.param("/tmp/ipykernel_123/456.py", marks=pytest.mark.nightly)],
)
def test_a_notebook_cell(filename: str, tmp_path: Path) -> None:
    """Cells have no file, and live in __main__."""
    cell = f"""
{REPORT}
import __main__
for source in ({FIELD!r}, {SOLVE_ONCE!r}):
    exec(compile(source, {filename!r}, "exec"), vars(__main__))
"""
    assert_found(*(run("-c", cell, cache=tmp_path) for _ in range(2)))


@pytest.mark.nightly
def test_an_edited_helper_is_seen(tmp_path: Path) -> None:
    """Neither numba nor the field's own file would tell."""
    helper = (
        "import geomint as gi\n\nGAIN = 2.0\n\n\n@gi.helper\ndef force(q):\n    return -GAIN * q\n"
    )
    field = """
import geomint as gi
from helpers import force


@gi.field
def spring(params, t, y, out, work):
    out[0] = y[1]
    out[1] = force(y[0])


report(*gi.pointwise(spring, [], [[0.5, 0.3]], rows=2)[0])
"""
    script = written(tmp_path / "script.py", REPORT, field)
    results = []
    for text in (helper, helper.replace("2.0", "3.0"), helper.replace("-GAIN", "-0.5 * GAIN")):
        written(tmp_path / "helpers.py", text)
        outcome = run(script, cache=tmp_path / "cache", PYTHONDONTWRITEBYTECODE="1")
        assert outcome.compiled
        results.append(tuple(outcome.results))
    assert len(set(results)) == 3
    written(tmp_path / "helpers.py", helper)
    outcome = run(script, cache=tmp_path / "cache", PYTHONDONTWRITEBYTECODE="1")
    assert outcome.compiled == []
    assert tuple(outcome.results) == results[0]


def test_sources_that_are_younger_than_the_clock(tmp_path: Path) -> None:
    """As on a file system of a machine whose clock is ahead: their code is kept as that of others."""
    import geomint

    package = tmp_path / "src" / "geomint"
    shutil.copytree(
        Path(geomint.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__")
    )
    for path in package.rglob("*.py"):
        os.utime(path, (2.0**32, 2.0**32))
    command = ("-c", REPORT + FIELD + POINTS)
    own = {"PYTHONPATH": str(package.parent)}
    first, second = (run(*command, cache=tmp_path / "cache", **own) for _ in range(2))
    assert_found(first, second)


def test_an_edited_kernel_empties_the_cache(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The folder's name is a hash of the kernel layer's sources."""
    from geomint.kernels.compiling import cache

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    before = cache.cache_folder().path
    assert before.parent == tmp_path / "geomint"
    package = tmp_path / "kernels"
    shutil.copytree(Path(cache.__file__).parents[1], package)
    monkeypatch.setattr(cache, "_KERNELS", package)
    cache.kernel_stamp.cache_clear()
    try:
        assert cache.cache_folder().path == before
        (package / "solve" / "status.py").write_text("OK = 0\n", encoding="utf-8")
        cache.kernel_stamp.cache_clear()
        assert (after := cache.cache_folder().path) != before
        (package / ".#lock.py").symlink_to("nowhere")  # of an editor
        cache.kernel_stamp.cache_clear()
        assert cache.cache_folder().path == after
    finally:
        cache.kernel_stamp.cache_clear()


def test_the_default_folder_is_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Not beside the sources, which may not be writable."""
    from geomint.kernels.compiling import cache

    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert Path(cache.__file__).parent not in cache.cache_folder().path.parents
    if sys.platform.startswith("linux"):
        assert cache.cache_folder().path.parent == tmp_path / "geomint"


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    """Every process compiles, says so once, and comes to the same results."""
    good = run("-c", REPORT + FIELD + POINTS, cache=tmp_path / "cache")
    blocked = tmp_path / "file"
    blocked.write_text("in the way", encoding="utf-8")
    catching = f"""
import warnings
{REPORT}
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    exec({FIELD + POINTS!r})
from geomint import GeomintWarning
assert [issubclass(w.category, GeomintWarning) for w in caught] == [True], caught
assert "cannot be kept" in str(caught[0].message)
"""
    bad = run("-c", catching, cache=blocked, HOME=str(blocked), XDG_CACHE_HOME=str(blocked))
    assert bad.compiled == good.compiled
    assert bad.results == good.results


def test_methods_of_several_functions_compile_quietly(tmp_path: Path) -> None:
    """numba calls tuples of first-class functions experimental; users need not hear of it."""
    script = """
from geomint.problems.testproblems import pulsating_body

problem = pulsating_body.problem()
sol = gi.solve(problem, pulsating_body.INITIAL, t_end=1.0, step=0.1, method="cf-4")
report(*sol.y[-1])
"""
    command = ("-c", REPORT + "import geomint as gi" + script)
    assert_found(*(run(*command, cache=tmp_path) for _ in range(2)))


def test_the_environment_is_left_alone() -> None:
    """No variable is set, no warning filter is installed, by import or by use."""
    script = f"""
import os, sys, warnings
import numba  # which sets variables of its own
environment, filters = dict(os.environ), list(warnings.filters)
{REPORT}
{FIELD}
{SOLVE}
assert dict(os.environ) == environment
assert [f for f in warnings.filters if f not in filters] == []
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr in ("", COMPILING)


def test_code_is_loaded_without_a_module_of_the_name(tmp_path: Path) -> None:
    """What gives its functions the name of a module has it not imported."""
    (tmp_path / "other_thing.py").write_text("print('imported')")
    script = f"exec({FIELD + POINTS!r}, {{'__name__': 'other_thing', 'report': report}})"
    first, second = (run("-c", REPORT + script, cache=tmp_path / "cache") for _ in range(2))
    assert_found(first, second)


@pytest.mark.parametrize("name", ["../../../escape", "H/m", "ü" * 130, "a\nb", "\0", "\udcff"])
def test_names_of_functions_are_no_paths(name: str, tmp_path: Path) -> None:
    naming = f"for f in (spring, turn): f.function.__name__ = {name!r}\n"
    points = POINTS.replace("found = ", f"{naming}found = ")
    first, second = (run("-c", REPORT + FIELD + points, cache=tmp_path / "c") for _ in range(2))
    assert_found(first, second)
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert {path.parent.parent.name for path in files} == {"geomint"}
