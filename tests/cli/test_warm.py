"""`geomint warm`, and the line that is seen while functions are compiled."""

from __future__ import annotations

import io
import sys
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numba import config

import geomint as gi
from geomint.cli import main
from geomint.kernels.compiling import compile as compiling
from geomint.run.compiling_line import CompilingLine

SCENE = """
[system]
name = "chaplygin-sphere-hamiltonized"
a = [0.8, 1.1, 1.5]
D = 4.0
[initial]
gamma = [0.48, 0.6, 0.64]
p = [3.0, -4.0, 1.5]
[time]
tau_end = 125.0
[integrate]
method = "rk-4"
step = 0.03125
[observe]
quantities = ["energy", "measure"]
every = 2
"""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> set[tuple[str, int]]:
    """What code is asked for."""
    found: set[tuple[str, int]] = set()
    entry = compiling._entry

    def noted(recorded):
        dispatcher = entry(recorded)
        found.add((recorded.fingerprint, id(dispatcher)))
        return dispatcher

    monkeypatch.setattr(compiling, "_entry", noted)
    return found


@pytest.mark.parametrize("methods", [[], ["--methods", "rk-4,gauss-4"]])
def test_later_commands_ask_for_nothing_else(methods, asked, tmp_path) -> None:
    scene = tmp_path / "s.toml"
    scene.write_text(SCENE, encoding="utf-8")
    result = CliRunner().invoke(main, ["warm", str(scene), *methods])
    assert result.exit_code == 0
    assert ": ready, " in result.stdout
    warmed = set(asked)
    assert warmed
    asked.clear()
    out = ["--out", str(tmp_path / "report"), "--quiet"]
    assert CliRunner().invoke(main, ["drift", str(scene), *methods, *out]).exit_code == 0
    out = ["--out", str(tmp_path / "run.nc"), "--quiet"]
    assert CliRunner().invoke(main, ["run", str(scene), *out]).exit_code == 0
    assert asked <= warmed


def test_a_scene_that_cannot_be_run_does_not_end_the_others(tmp_path) -> None:
    scene = tmp_path / "s.toml"
    scene.write_text(SCENE, encoding="utf-8")
    result = CliRunner().invoke(main, ["warm", "no-such", str(scene)])
    assert result.exit_code == 2
    assert "no-such" in result.stderr
    assert f"{scene}: ready, " in result.stdout


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_line_counts_and_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Functions found in the cache are counted, and take no time."""
    monkeypatch.setattr(sys, "stderr", Terminal())
    line = CompilingLine(True, expected=5)
    seen = []
    for number, seconds in ((1, 2.8), (3, 2.0), (4, 1.0), (6, 1.0)):
        line.begins(number)
        seen.append(sys.stderr.getvalue().split("\r")[-1].removeprefix("\x1b[K"))
        line.ends(seconds)
    assert seen == [
        f"geomint: compiling {words} left (once, then kept in the cache)"
        for words in ("1/5, about 6 s", "3/5, about 6 s", "4/5, about 4 s", "6/6, about 2 s")
    ]
    line.clear()
    assert sys.stderr.getvalue().endswith("\r\x1b[K")
    written = sys.stderr.getvalue()
    line.clear()
    assert sys.stderr.getvalue() == written


@pytest.mark.parametrize(("shown", "lines"), [(True, 1), (False, 0)])
def test_where_nobody_looks_it_is_written_once(shown, lines, monkeypatch) -> None:
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    monkeypatch.setattr(compiling, "_announced", [])
    line = CompilingLine(shown)
    line.begins(1)
    line.ends(1.0)
    line.begins(2)
    line.clear()
    assert sys.stderr.getvalue().count("\n") == lines
    assert "\r" not in sys.stderr.getvalue()


LINE = "geomint: compiling (once, then kept in the cache)\n"


def new_problem() -> gi.Problem:
    """Return one of which nothing is in the cache."""
    new = float(np.random.default_rng().random())

    @gi.field
    def own(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = -new * y[0]

    return gi.Problem("own", (("x", 1),), field=own)


@pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")
def test_a_script_is_told_once_that_functions_are_compiled(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By whatever compiles first, where no terminal shows it; not where all is in the cache, nor where
    it is not wanted.
    """
    one, two = new_problem(), new_problem()
    given: dict[str, Any] = {"t_end": 1.0, "step": 0.1, "method": "rk-4"}
    monkeypatch.setattr(compiling, "_announced", [])
    gi.solve(new_problem(), [1.0], progress=False, **given)
    gi.solve(new_problem(), [1.0], t_end=1.0, progress=False)
    gi.solve_ensemble(new_problem(), [[1.0]], t_end=1.0, progress=False)
    gi.lyapunov(new_problem(), [1.0], t_end=1.0, step=0.1, progress=False)
    assert capsys.readouterr().err == ""
    for problem in (one, new_problem()):
        gi.solve(problem, [1.0], **given)
    assert capsys.readouterr().err == LINE
    monkeypatch.setattr(compiling, "_announced", [])
    gi.solve(one, [1.0], **given)
    assert capsys.readouterr().err == ""
    gi.Integrator(two, [1.0], step=0.1, method="rk-4").step()
    assert capsys.readouterr().err == LINE
    monkeypatch.setattr(compiling, "_announced", [])
    monkeypatch.setattr(sys, "stderr", None)  # closed
    gi.solve(new_problem(), [1.0], **given)
    assert capsys.readouterr() == ("", "")
