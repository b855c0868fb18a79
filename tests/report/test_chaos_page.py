"""Lyapunov exponents of scenes: from Python and from the command line, with what is in the folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import find_command, main

SCENE: dict[str, Any] = {
    "system": {"name": "chaplygin-sphere-hamiltonized", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.48, 0.6, 0.64], "p": [0.8, 1.0, -1.5375]},
    "time": {"tau_end": 400.0},
    "integrate": {"method": "rk-4", "step": 0.25},
}


@pytest.mark.usefixtures("blank_pictures")
def test_report(tmp_path: Path) -> None:
    """Every file, and what is in it: the numbers of `geomint.lyapunov`."""
    found = gi.chaos_report(SCENE, tmp_path / "out", paper=True)
    scene = gi.load_scene(SCENE)
    same = gi.lyapunov(scene.problem, scene.state, tau_end=400.0, step=0.25, method="rk-4")
    np.testing.assert_array_equal(found.exponents, same.exponents)
    record = json.loads((tmp_path / "out" / "chaos.json").read_text("utf-8"))
    assert record["exponents"] == found.exponents.tolist()
    assert (record["verdict"], record["steps"]) == ("regular", 1600)
    assert record["grown"] == pytest.approx(found.exponents[0] * 400.0)
    assert record["reference"] == pytest.approx(np.log(400.0 / found.unit) / 400.0)
    page = (tmp_path / "out" / "chaos.html").read_text("utf-8")
    page += "".join((tmp_path / "out" / f"chaos-{x}.tex").read_text() for x in ("caption", "table"))
    first, error, total = found.exponents[0], found.errors[0], np.sum(found.exponents)
    told = f"$\\lambda $1 & {first:.4g} & {error:.2g} \\\\\n", f"\nsum & {total:.2g} & --- "
    told += ("up to $\\tau $ = 400; dotted", "Method: rk-4, order 4, 1600 steps~")
    for word in (*told, "Regular", "rk-4", "λ4", "sum", "alignment index", "1600 steps"):
        assert word in page


GIVEN = ["chaos", "hamiltonized-n3", "--method", "rk-4", "--count", "1"]


@pytest.mark.usefixtures("blank_pictures")
def test_command(tmp_path: Path) -> None:
    """Of one exponent there is no sum."""
    given = [*GIVEN, "--tau-end", "10", "--step", "0.25", "--out", str(tmp_path)]
    result = CliRunner().invoke(main, given)
    assert result.exit_code == 0, result.output
    assert [w for w in ("λ1", "λ2", "sum", "alignment") if w in result.output] == ["λ1"]
    assert '<th scope="row">sum' not in (tmp_path / "chaos.html").read_text("utf-8")
    assert CliRunner().invoke(main, [*given, "--quiet"]).stdout == ""


@pytest.mark.parametrize(
    ("changes", "kind", "said"),
    [
        ({"time": {"t_end": 5.0}}, gi.SceneError, "tau_end"),
        ({"integrate": {"method": "dop853-adaptive"}}, gi.FormError, "steps of one length"),
        ({"integrate": {"exact": True}}, gi.FormError, "the exact flow does not take"),
        ({"integrate": {"method": "rkmk-4"}}, gi.FormError, "choose another method"),
    ],
)
def test_what_has_no_exponents(changes: dict[str, Any], kind: type, said: str) -> None:
    with pytest.raises(kind, match=said):
        find_command("chaos").plan(gi.load_scene({**SCENE, **changes}))


@pytest.mark.usefixtures("blank_pictures")
def test_a_failure_keeps_what_there_is(tmp_path: Path) -> None:
    """A step that is too large: the report of the time before, and exit code 2."""
    result = CliRunner().invoke(main, [*GIVEN, "--step", "1", "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert "Not all of the run: failed" in (tmp_path / "chaos.html").read_text("utf-8")
    assert "report (failed)" in result.output


def test_a_representation() -> None:
    """A part of the state has a part of the exponents."""
    ball = gi.load_scene("ball-3d")
    assert "g" in find_command("chaos").plan(ball).route.problem.slices
    part = find_command("chaos").plan(ball.changed(integrate={"representation": "classical"}))
    assert set(part.route.problem.slices) == {"k", "gamma"}
