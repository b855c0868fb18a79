"""Warnings as values: every kind is given, shown at the user's line, kept, saved and told again."""

from __future__ import annotations

import csv
import dataclasses
import json
import pickle
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import chaplygin as ch
import geomint as gi
from geomint.cli import find_command, main
from geomint.problems.testproblems import henon_heiles
from geomint.reports.drift_report import told_report
from geomint.reports.terminal import show

HENON = henon_heiles.problem()
SCENE: dict[str, Any] = {
    "system": {"name": "neumann", "a": [0.7, 1.0, 1.4], "strength": 2.0},
    "initial": {"q": [0.6, 0.0, 0.8], "v": [0.0, 1.0, 0.0]},
    "time": {"t_end": 40.0},
    "integrate": {"method": "rk-4", "step": 0.9},
}
NEUMANN = gi.Scene(**SCENE).problem
CLOCKED = gi.load_scene("hamiltonized-n3").problem
OFF = np.array([0.6, 0.0, -0.8 * (1.0 + 1e-9), 0.0, 0.5, 0.0])


@gi.field
def lorenz(params, t, y, out, work):
    out[0] = 10.0 * (y[1] - y[0])
    out[1] = y[0] * (28.0 - y[2]) - y[1]
    out[2] = y[0] * y[1] - params[0] * y[2]


CHAOS = gi.Problem("lorenz", (("y", 3),), params=[8.0 / 3.0], field=lorenz)


def projected() -> Any:
    return gi.solve(NEUMANN, OFF, t_end=0.5, step=0.1, method="rk-4", **PLAIN)


def coarse() -> Any:
    return gi.solve(HENON, henon_heiles.INITIAL, t_end=2000.0, method="rk-4", step=1.25)


def grown() -> Any:
    return gi.solve(CHAOS, [-5.0, -6.0, 22.0], t_end=60.0, tolerance=1e-9)


UNREACHED: dict[str, Any] = {"tau_end": 1.0, "step": 0.1, "t_eval": [0.5, 1e3], "method": "rk-4"}
PLAIN: dict[str, Any] = {"compiled": False}


def unreached() -> Any:
    return gi.solve(CLOCKED, CLOCKED.random_state(1), **UNREACHED, **PLAIN)


def slow() -> Any:
    @gi.field
    def single(params, t, y, out, work):
        out[0] = -y[0] if y[0] > 0.0 else -2.0 * y[0]

    problem = gi.Problem("single", (("y", 1),), field=single)
    return gi.solve(problem, [1.0], t_end=1.0, step=0.1)


def no_body() -> Any:
    return ch.ChaplyginSphere.from_moments([0.1, 0.1, 0.3], 1.0, 1.0)


CASES: dict[type[gi.GeomintWarning], tuple[Callable[[], Any], str]] = {
    gi.StateWarning: (projected, "q"),
    gi.StepWarning: (coarse, "energy"),
    gi.EndWarning: (grown, "end"),
    gi.LeftOutWarning: (unreached, "t_eval"),
    gi.SpeedWarning: (slow, "single"),
    gi.DeclarationWarning: (no_body, "moments"),
}


@pytest.mark.parametrize("kind", gi.GeomintWarning.__subclasses__())
def test_shown_once_at_the_line_of_the_user_and_kept(kind: Any, tmp_path: Path) -> None:
    make, quantity = CASES[kind]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    (one,) = [w for w in caught if type(w.message) is kind]
    told = one.message
    assert one.filename == __file__
    assert (told.kind, told.quantity, str(told)) == (kind.__name__, quantity, told.text)
    assert told.size is None or told.size > 0.0
    assert told == pickle.loads(pickle.dumps(told)) == gi.GeomintWarning.read(told.as_json())
    if kind is gi.DeclarationWarning:
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # kept whether or not it is shown
        sol = make()
    assert sol.warnings == made.warnings == (told,)
    assert f"1 {kind.__name__}" in " ".join(repr(sol).split())
    (of_json,) = json.loads(json.dumps(sol.provenance, allow_nan=False))["warnings"]
    assert gi.GeomintWarning.read(of_json) == told
    sol.save(tmp_path / "run.nc")
    read = gi.load(tmp_path / "run.nc")
    assert read.warnings == sol.warnings
    assert json.loads(read.words()["provenance"])["warnings"] == [of_json]
    if kind is gi.EndWarning:
        assert (told.size, told.time) == (sol.end_error.error, sol.end_error.until)
    if kind is gi.StepWarning:
        assert (0.01 < told.size < 1.0, told.time) == (True, 2000.0)


def test_a_text_steers_no_terminal_and_can_be_written() -> None:
    """Such as the name of a folder that is no UTF-8."""
    told = gi.GeomintWarning("kept in /a\udcff\x1b[31m")
    assert str(told) == r"kept in /a\udcff\x1b[31m"
    str(told).encode()


def test_a_run_that_fails_has_those_until_then() -> None:
    with pytest.warns(gi.StateWarning), pytest.raises(gi.StepError) as failed:
        gi.solve(NEUMANN, OFF, t_end=1000.0, step=10.0, method="rk-4", **PLAIN)
    assert [w.kind for w in failed.value.partial.warnings] == ["StateWarning"]


def test_one_that_begins_anew_says_nothing_twice() -> None:
    """From beside an axis, where the motion is slow."""
    state = np.array([1.0 + 1e-9, 0.0, 0.0, 0.0, 1e-3, 0.0])
    with pytest.warns(gi.StateWarning) as shown:
        sol = gi.solve(NEUMANN, state, t_end=60.0, method="rk-4")
    assert [w.kind for w in sol.warnings] == ["StateWarning"] * len(shown) == ["StateWarning"]


def two_of_three(**more: Any) -> gi.Ensemble:
    """Return an ensemble: of its members one is projected, and another has a late time asked for."""
    states = np.array([OFF, OFF, OFF])
    states[:2, 2] = -0.8
    states[1, 4] = 1.0
    with pytest.warns(gi.StateWarning, match=r"1 of 3 states were changed; states\[2\]"):
        return gi.solve_ensemble(NEUMANN, states, t_end=1.0, step=0.1, **more)


@pytest.mark.parametrize("more", [{}, {"observe": ["energy"]}])
def test_a_column_of_ensembles(more: dict[str, Any], tmp_path: Path) -> None:
    """In compiled steps of all members and in single runs; on disk as in memory."""
    many = two_of_three(**more)
    assert many.warned.tolist() == ["", "", "StateWarning"]
    assert list(many.warnings) == [2]
    (told,) = many.warnings[2]
    assert (type(told), told.quantity) == (gi.StateWarning, "q")
    pytest.importorskip("xarray")
    assert many.to_xarray()["warnings"].values.tolist() == many.warned.tolist()
    pytest.importorskip("zarr")
    stored = two_of_three(**more, out=tmp_path / "many.zarr")
    for one in (stored, gi.open_ensemble(tmp_path / "many.zarr")):
        assert dict(one.warnings) == many.warnings
        assert one.warned.tolist() == many.warned.tolist()


def test_what_members_say_is_shown_once() -> None:
    states = [CLOCKED.random_state(seed) for seed in range(3)]
    with pytest.warns(gi.LeftOutWarning) as shown:
        many = gi.solve_ensemble(CLOCKED, states, **UNREACHED)
    (one,) = shown
    assert one.filename == __file__
    assert str(one.message).startswith("3 of 3 members have `warnings`; member 0: the run ended")
    assert many.warned.tolist() == ["LeftOutWarning"] * 3


@pytest.mark.usefixtures("blank_pictures")
def test_reports_carry_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def printed_of(runs: gi.SeveralRuns) -> str:
        show(told_report(runs))
        return " ".join(capsys.readouterr().out.split())

    with pytest.warns(gi.StepWarning, match="energy"):
        runs = gi.drift_report(SCENE, tmp_path)
    (told,) = runs[0].solution.warnings
    run = json.loads((tmp_path / "drift.json").read_text("utf-8"))["methods"]["rk-4"]["run"]
    assert [gi.GeomintWarning.read(w) for w in run["warnings"]] == [told]
    page = (tmp_path / "report.html").read_text("utf-8")
    assert str(told) in page
    local = f"{run['local_error']['largest']:.2g}, at t = "
    assert local in page
    printed = printed_of(runs)
    steps, seconds, rate = re.search(r"(\d+) steps in (\S+) s \((\S+) a second\)", printed).groups()
    assert float(rate) == pytest.approx(int(steps) / float(seconds), rel=0.02)
    runs[0].solution.run_seconds = 0.0
    assert "steps in 0 s (0 a second)" in printed_of(runs)
    assert f"local error: {local}" in printed
    assert "warnings: 1 StepWarning" in printed


TOLD = gi.StepWarning("too long", "energy", 0.5, 3.0)


def told_before(monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    """Let a warning come before a report is written."""
    command = find_command(kind)
    report = command.report

    def reporting(plan: Any, found: Any, command: Any) -> Any:
        if kind == "scan":
            found.found.warnings[1] = (TOLD,)
        else:
            found = dataclasses.replace(found, warnings=(TOLD,))
        return report(plan, found, command)

    monkeypatch.setitem(vars(command), "report", reporting)


@pytest.mark.usefixtures("blank_pictures")
def test_scans_have_a_column(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told_before(monkeypatch, "scan")
    vary = {"initial.v[1]": [0.5, 1.0]}
    gi.scan_report(SCENE, tmp_path, progress=False, vary=vary, show=["drift:energy"])
    rows = csv.DictReader((tmp_path / "scan.csv").read_text("utf-8").splitlines())
    assert [row["warnings"] for row in rows] == ["", "StepWarning"]
    record = json.loads((tmp_path / "scan.json").read_text("utf-8"))
    (of_json,) = record["warnings"]
    assert (record["warned"], of_json["member"], of_json["initial.v[1]"]) == (1, 1, 1.0)
    assert {**of_json, **TOLD.as_json()} == of_json
    assert "initial.v[1] = 1: too long" in (tmp_path / "scan.html").read_text("utf-8")


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize("kind", ["section", "chaos"])
def test_sections_and_exponents_carry_them(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lossy: dict[str, Any] = {"method": "rk-4", "progress": False}
    motion = {
        "section": lambda *at, end, **more: gi.poincare_section(*at, "q[2]", end, **more),
        "chaos": lambda *at, end, **more: gi.lyapunov(*at, t_end=2.5 * end, **more),
    }[kind]
    with pytest.warns(gi.StateWarning):
        found = motion(NEUMANN, OFF, end=2, step=0.1, **lossy)
    assert [w.kind for w in found.warnings] == ["StateWarning"]
    scene = gi.Scene(**SCENE)
    with pytest.warns(gi.StepWarning, match="energy"):
        again = motion(scene.problem, scene.state, end=40, step=0.9, **lossy)
    assert {w.quantity for w in again.warnings} == {"energy"}
    told_before(monkeypatch, kind)
    keys = {"section": {"event": "q[2]", "points": 2}, "chaos": {}}[kind]
    with pytest.warns(gi.StepWarning, match="energy"):
        getattr(gi, f"{kind}_report")(scene, tmp_path, progress=False, **keys)
    record = json.loads((tmp_path / f"{kind}.json").read_text("utf-8"))
    assert record["warnings"] == [TOLD.as_json()]
    page = (tmp_path / f"{kind}.html").read_text("utf-8")
    assert "<strong>StepWarning.</strong> too long." in page


@pytest.mark.usefixtures("blank_pictures")
def test_comparisons_carry_them(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(gi.load_scene("sphere-n3").toml(), "utf-8")
    line = ["compare", str(path), "--methods", "rk-4", "--steps", "0.6,0.01", "--t-end", "40"]
    line += ["--repeats", "1", "--reference", "exact", "--out", str(tmp_path)]
    assert CliRunner().invoke(main, line).exit_code == 0
    found = json.loads((tmp_path / "compare.json").read_text("utf-8"))["points"]
    assert [[w["kind"] for w in point["warnings"]] for point in found] == [["StepWarning"], []]
    assert '<span class="small">StepWarning</span>' in (tmp_path / "compare.html").read_text(
        "utf-8"
    )
