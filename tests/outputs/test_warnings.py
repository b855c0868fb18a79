"""Warnings as values: every kind is given, shown at the user's line, kept, saved and told again."""

from __future__ import annotations

import json
import pickle
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.compare.runs import compare
from geomint.problems.testproblems import henon_heiles, neumann
from geomint.report.compare_page import write_compare_report
from geomint.report.summary import print_runs
from geomint.run.provenance import run_record

HENON = henon_heiles.problem()
NEUMANN = neumann.problem([0.7, 1.0, 1.4])
OFF = np.array([0.6, 0.0, -0.8 * (1.0 + 1e-9), 0.0, 0.5, 0.0])


@gi.field
def lorenz(params, t, y, out, work):
    out[0] = 10.0 * (y[1] - y[0])
    out[1] = y[0] * (28.0 - y[2]) - y[1]
    out[2] = y[0] * y[1] - params[0] * y[2]


CHAOS = gi.Problem("lorenz", (("y", 3),), params=[8.0 / 3.0], field=lorenz)


def projected() -> Any:
    return gi.solve(NEUMANN, OFF, t_end=0.5, step=0.1)


def coarse() -> Any:
    return gi.solve(HENON, henon_heiles.INITIAL, t_end=2000.0, method="rk-4", step=1.25)


def grown() -> Any:
    return gi.solve(CHAOS, [-5.0, -6.0, 22.0], t_end=60.0, tolerance=1e-9)


@gi.field
def pace(params, t, y, work):
    return 1.0 + 0.0 * y[0]


UNREACHED: dict[str, Any] = {"tau_end": 1.0, "step": 0.1, "t_eval": [0.5, 1e3], "method": "rk-4"}


def clocked() -> gi.Problem:
    return gi.time_transformed(HENON, pace, henon_heiles.INITIAL)


def unreached() -> Any:
    return gi.solve(clocked(), henon_heiles.INITIAL, **UNREACHED)


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
RUNS = [kind for kind in CASES if kind is not gi.DeclarationWarning]


def given(kind: type[gi.GeomintWarning]) -> tuple[Any, list[Any]]:
    """Return what a case makes, and the warnings of its kind that were shown."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = CASES[kind][0]()
    return made, [w for w in caught if type(w.message) is kind]


def test_every_kind_has_a_case() -> None:
    assert set(CASES) == set(gi.GeomintWarning.__subclasses__())


@pytest.mark.parametrize("kind", CASES)
def test_shown_once_at_the_line_of_the_user(kind: type[gi.GeomintWarning]) -> None:
    _, shown = given(kind)
    (one,) = shown
    told = one.message
    assert one.filename == __file__
    assert told.kind == kind.__name__
    assert told.quantity == CASES[kind][1]
    assert str(told) == told.text
    assert told.size is None or told.size > 0.0
    assert told == pickle.loads(pickle.dumps(told)) == gi.GeomintWarning.read(told.as_json())


def test_a_text_steers_no_terminal_and_can_be_written() -> None:
    """Such as the name of a folder that is no UTF-8."""
    told = gi.GeomintWarning("kept in /a\udcff\x1b[31m")
    assert str(told) == r"kept in /a\udcff\x1b[31m"
    str(told).encode()


@pytest.mark.parametrize("kind", RUNS)
def test_kept_whether_or_not_it_is_shown(kind: type[gi.GeomintWarning], tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sol = CASES[kind][0]()
    (told,) = sol.warnings
    assert type(told) is kind
    assert f"1 {kind.__name__}" in " ".join(repr(sol).split())
    (of_json,) = json.loads(json.dumps(run_record(sol), allow_nan=False))["warnings"]
    assert gi.GeomintWarning.read(of_json) == told
    sol.save(tmp_path / "run.nc")
    read = gi.load(tmp_path / "run.nc")
    assert read.warnings == sol.warnings
    assert json.loads(read.words()["provenance"])["warnings"] == [of_json]


def test_times_and_sizes_are_those_of_the_run() -> None:
    sol, _ = given(gi.EndWarning)
    (end,) = sol.warnings
    assert (end.size, end.time) == (sol.end_error.error, sol.end_error.until)
    sol, _ = given(gi.StepWarning)
    (step,) = sol.warnings
    assert 0.01 < step.size < 1.0
    assert step.time == 2000.0


def test_a_run_that_fails_has_those_until_then() -> None:
    with pytest.warns(gi.StateWarning), pytest.raises(gi.StepError) as failed:
        gi.solve(NEUMANN, OFF, t_end=50.0, step=30.0)
    assert [w.kind for w in failed.value.partial.warnings] == ["StateWarning"]


def test_one_that_begins_anew_says_nothing_twice() -> None:
    """From beside an axis, where the motion is slow."""
    state = np.array([1.0 + 1e-9, 0.0, 0.0, 0.0, 1e-3, 0.0])
    with pytest.warns(gi.StateWarning) as shown:
        sol = gi.solve(NEUMANN, state, t_end=60.0, method="rk-4")
    assert [w.kind for w in sol.warnings] == ["StateWarning"] * len(shown) == ["StateWarning"]


def test_nothing_to_say() -> None:
    assert gi.solve(HENON, henon_heiles.INITIAL, t_end=1.0, step=0.1).warnings == ()


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
    states = np.multiply.outer([0.5, 1.0, 1.5], henon_heiles.INITIAL)
    with pytest.warns(gi.LeftOutWarning) as shown:
        many = gi.solve_ensemble(clocked(), states, **UNREACHED)
    (one,) = shown
    assert one.filename == __file__
    assert str(one.message).startswith("3 of 3 members have `warnings`; member 0: the run ended")
    assert many.warned.tolist() == ["LeftOutWarning"] * 3


SCENE: dict[str, Any] = {
    "system": {"name": "neumann", "a": [0.7, 1.0, 1.4], "strength": 2.0},
    "initial": {"q": [0.6, 0.0, 0.8], "v": [0.0, 1.0, 0.0]},
    "time": {"t_end": 40.0},
    "integrate": {"method": "rk-4", "step": 0.9},
}


def test_reports_carry_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.warns(gi.StepWarning, match="energy"):
        runs = gi.drift_report(SCENE, tmp_path)
    (told,) = runs[0].solution.warnings
    run = json.loads((tmp_path / "drift.json").read_text("utf-8"))["methods"]["rk-4"]["run"]
    assert [gi.GeomintWarning.read(w) for w in run["warnings"]] == [told]
    page = (tmp_path / "report.html").read_text("utf-8")
    assert str(told) in page
    local = f"{run['local_error']['largest']:.2g}, at t = "
    assert local in page
    print_runs(runs)
    printed = " ".join(capsys.readouterr().out.split())
    assert f"local error: {local}" in printed
    assert "warnings: 1 StepWarning" in printed


def test_sections_and_exponents_carry_them(tmp_path: Path) -> None:
    quiet: dict[str, Any] = {"step": 0.1, "progress": False}
    with pytest.warns(gi.StateWarning):
        section = gi.poincare_section(NEUMANN, OFF, "q[2]", 2, **quiet)
    with pytest.warns(gi.StateWarning):
        found = gi.lyapunov(NEUMANN, OFF, t_end=1.0, **quiet)
    assert [w.kind for w in (*section.warnings, *found.warnings)] == 2 * ["StateWarning"]
    scene, quiet = gi.Scene(**SCENE), {"progress": False}
    with pytest.warns(gi.StepWarning, match="energy"):
        section = gi.section_report(scene, tmp_path, event="q[2]", points=40, **quiet)
    with pytest.warns(gi.StepWarning, match="energy"):
        found = gi.chaos_report(scene.changed(time={"t_end": 100.0}), tmp_path, **quiet)
    for name, one in (("section", section), ("chaos", found)):
        (told,) = one.warnings
        assert told.quantity == "energy"
        record = json.loads((tmp_path / f"{name}.json").read_text("utf-8"))
        assert record["warnings"] == [told.as_json()]
        page = (tmp_path / f"{name}.html").read_text("utf-8")
        assert f"<strong>StepWarning.</strong> {told.text[:20]}" in page


def test_comparisons_carry_them(tmp_path: Path) -> None:
    scene = gi.Scene(**SCENE)
    found = compare(scene.model, {"t_end": 40.0}, ["rk-4"], steps=[0.9, 0.01], repeats=1)
    coarse, fine = found.points
    assert [w["kind"] for w in coarse.warnings] == ["StepWarning"]
    assert fine.warnings == ()
    write_compare_report(found, scene, tmp_path)
    assert json.loads((tmp_path / "compare.json").read_text("utf-8"))["points"][0]["warnings"]
    assert "; StepWarning</td>" in (tmp_path / "compare.html").read_text("utf-8")
