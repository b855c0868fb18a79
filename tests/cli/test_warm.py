"""`geomint warm`, and the line that is seen while functions are compiled."""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import config
from pydantic import BaseModel

import geomint as gi
from tests.cli.calls import alone, invoke, offer

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


def new_problem() -> gi.Problem:
    """Return one of which nothing is in the cache."""
    new = float(np.random.default_rng().random())

    @gi.field
    def own(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = -new * y[0]

    @gi.observable
    def size(params: Any, t: Any, y: Any, work: Any) -> Any:
        return new * y[0]

    return gi.Problem("own", (("x", 1),), field=own, observables={"size": size})


class Nothing(BaseModel):
    pass


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("methods", [(), ("--methods", "rk-4,gauss-4")])
def test_later_commands_compile_nothing(
    methods: tuple[str, ...], tmp_path: Path, monkeypatch
) -> None:
    """And a scene that cannot be run does not end the others."""
    problem = new_problem()
    model = gi.Model({"own": problem}, {"own": np.array([1.0])})
    system = gi.System("new", "a new one", Nothing, Nothing, lambda parameters, initial: model)
    offer(monkeypatch, "geomint.systems", "new", system)
    path = tmp_path / "s.toml"
    path.write_text(
        '[system]\nname = "new"\n[time]\nt_end = 125.0\n[integrate]\nmethod = "rk-4"\n'
        'step = 0.03125\n[observe]\nquantities = ["size"]\nevery = 2\n',
        "utf-8",
    )
    result = invoke("warm", "no-such", path, *methods)
    assert (result.exit_code, "no-such" in result.stderr) == (2, True)
    assert f"{path}: ready, " in result.stdout
    scene = gi.load_scene(path)
    names = methods[1].split(",") if methods else None
    runs = gi.drift_report(scene, tmp_path / "report", progress=False, methods=names)
    spent = [
        run.compile_seconds for run in [gi.run_scene(scene, False), *(r.solution for r in runs)]
    ]
    assert set(spent) == {0.0}


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_the_line_counts_and_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    gi.solve(new_problem(), [1.0], t_end=1.0, step=0.1, method="rk-4", observe="all")
    lines = sys.stderr.getvalue().split("\r\x1b[K")
    assert (lines[0], lines[-1]) == ("", "")
    words = r"geomint: compiling (\d+)/(\d+), about \d+ s left \(once, then kept in the cache\)"
    counts = [tuple(map(int, re.fullmatch(words, line).groups())) for line in lines[1:-1]]
    assert counts == sorted(set(counts))
    assert all(1 <= done <= of for done, of in counts)


TOLD = """
from tests.cli.test_warm import new_problem
import geomint as gi
import sys
given = {"t_end": 1.0, "step": 0.1, "method": "rk-4"}
one = new_problem()
gi.solve(new_problem(), [1.0], progress=False, **given)
gi.solve_ensemble(new_problem(), [[1.0]], t_end=1.0, method="rk-4", step=0.1, progress=False)
print("before", file=sys.stderr)
gi.solve(one, [1.0], **given)
gi.Integrator(new_problem(), [1.0], step=0.1, method="rk-4").step()
sys.stderr = None  # closed
gi.solve(new_problem(), [1.0], **given)
"""


def test_a_script_is_told_once_that_functions_are_compiled() -> None:
    """Where no terminal shows it, and not where it is not wanted."""
    done = alone(Path(__file__).parents[2], TOLD, call=("-c",))
    assert done.returncode == 0, done.stderr
    assert done.stderr == "before\ngeomint: compiling (once, then kept in the cache)\n"
