"""Comparisons: the same physical end for every method, and honest failures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.cli import find_command
from geomint.compare import reference
from geomint.compare.runs import compare
from geomint.reports.files import write

METHODS = ["gauss-8", "rattle-4", "cf-4", "rk-4"]
SCENE = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 5.0})


def reported(scene, found):
    compare = find_command("compare")
    return compare.report(compare.plan(scene), found, None)


@pytest.fixture(scope="module")
def model():
    return SCENE.model


@pytest.fixture(scope="module")
def comparison(model):
    return compare(model, {"tau_end": 10.0}, METHODS, repeats=1)


def test_the_docs_name_every_key_of_the_reference(comparison):
    page = (Path(__file__).parents[2] / "docs" / "drift-classes.md").read_text("utf-8")
    text = page.split("| key of `reference` |", 1)[1].split("\n## ", 1)[0]
    confirmation = comparison.reference["confirmation"]
    assert confirmation
    for key in (*comparison.reference, *confirmation):
        assert f"`{key}`" in text, key


def test_all_methods_converge_to_one_reference(comparison):
    """Four codes in three representations and two times: agreement is no accident."""
    for method in METHODS:
        errors = [p.error for p in comparison.points if p.method == method and p.error is not None]
        assert min(errors) < 1e-5, method
        assert errors[-1] < errors[0] or errors[0] < 1e-12, method
    assert {p.representation for p in comparison.points} >= {"hamiltonized"}
    assert any(p.representation != "hamiltonized" for p in comparison.points)


def test_reference_is_better_than_double(comparison):
    assert comparison.reference["error_estimate"] < 1e-17
    assert comparison.reference["known"] < 1e-16
    second = comparison.reference["confirmation"]
    assert second["agrees"]
    assert second["own_end"] == comparison.reference["own_end"]
    assert second["difference"] < second["accuracy"] < 1e-9
    assert comparison.reference["physical_end"] > 10.0

    for point in comparison.points:
        if point.status == "ok":
            assert point.seconds > 0.0
            assert point.steps
            assert point.evaluations
            assert point.repeats == 1


def test_the_exact_flow_is_the_same_reference(model, comparison):
    """Two references that share nothing agree to rounding, in τ and in t."""
    physical = comparison.reference["physical_end"]
    for end in ({"tau_end": 10.0}, {"t_end": physical}):
        given = {"steps": [0.0625], "repeats": 1, "observe": False, "reference": "exact"}
        other = compare(model, end, ["gauss-8"], **given)
        assert other.reference["method"] == "exact flow"
        assert other.reference["physical_end"] == pytest.approx(physical, rel=1e-14)
        assert 1e-16 < other.reference["error_estimate"] < 1e-11
        for name, expected in comparison.reference["quantities"].items():
            np.testing.assert_allclose(other.reference["quantities"][name], expected, atol=1e-12)
        assert min(p.bound for p in other.points) < 1e-12


def test_the_exact_flow_is_taken_where_the_other_would_take_minutes(model, monkeypatch):
    """As far as a default step tells that would have to be very short."""
    told = []
    monkeypatch.setattr(gi.Gauss, "default_step", lambda *given: 1e-5)
    result = compare(model, {"tau_end": 10.0}, ["rk-4"], steps=[0.5], repeats=1, report=told.append)
    assert result.reference["method"] == "exact flow"
    assert any("exact flow" in text for text in told)


def test_without_an_exact_flow_it_is_refused():
    with pytest.raises(gi.FormError, match="no exact flow"):
        compare(gi.load_scene("neumann-n3").model, {"t_end": 1.0}, ["rk-4"], reference="exact")


def test_an_end_in_t_needs_a_problem_in_t(model):
    name, problem = next(iter(model.problems.items()))
    alone = gi.Model({name: problem}, {name: model.states[name]})
    with pytest.raises(gi.FormError, match="expected tau_end"):
        compare(alone, {"t_end": 1.0}, ["gauss-8"], reference="extended")


def test_failure_is_shown_with_its_reason(model):
    method = gi.Gauss(8, iteration="fixed-point")
    result = compare(model, {"tau_end": 10.0}, [method], steps=[5.0, 0.25], repeats=1)
    failed, good = result.points
    assert failed.status.startswith("failed: ConvergenceError")
    assert "t = " in failed.status
    assert failed.error is None
    assert failed.seconds is None
    assert good.status == "ok"


def test_method_without_a_fitting_form_is_shown(model):
    reduced = gi.Model({"reduced": model.problems["reduced"]}, {"reduced": model.states["reduced"]})
    result = compare(reduced, {"t_end": 1.0}, ["rattle-2", "rk-4"], repeats=1)
    assert "needs the form 'hamiltonian'" in result.points[0].status
    assert result.points[-1].status == "ok"


def test_report_files(tmp_path):
    result = compare(SCENE.model, {"tau_end": 5.0}, ["gauss-8", "rk-4", "cf-4"], repeats=1)
    write(reported(SCENE, result), tmp_path)
    record = json.loads((tmp_path / "compare.json").read_text())
    assert set(record["orders"]) == {"gauss-8", "rk-4", "cf-4"}
    assert record["orders"]["cf-4"]["fitted"] == pytest.approx(4.0, abs=0.7)
    for row in record["best"]:
        assert row["exponent"] in (-3, -6, -9, -12)
        fit = [
            p["seconds"] for p in record["points"] if (p["bound"] or 1.0) <= 10.0 ** row["exponent"]
        ]
        assert row["seconds"] == min(fit)
    page = (tmp_path / "compare.html").read_text()
    assert "gauss-8" in page
    assert 'src="http' not in page
    second = record["reference"]["confirmation"]
    assert second["agrees"]
    for word in ("double-double", "SciPy", f"{second['accuracy']:.2g}", "Confirmed at its end"):
        assert word in page
    assert f"differ by {second['difference']:.2g}" in page
    for name in ("compare.png", "compare.svg", "compare-drift.png", "compare-drift.svg"):
        assert (tmp_path / name).stat().st_size > 1000


@pytest.mark.usefixtures("blank_pictures")
def test_why_a_longer_step_takes_longer(comparison, tmp_path):
    """Newton's method, or more iterations, as the page says; not a time that may be noise."""
    coarse, fine = [p for p in comparison.points if p.method == "gauss-8"][:2]
    assert fine.iterations / fine.steps > 10.0
    coarse = replace(coarse, newton=True, step=1.0, iterations=3 * fine.iterations)
    fine = replace(fine, step=0.5, newton=False)
    result = replace(comparison)
    slow, quick = replace(coarse, seconds=2.0), replace(fine, seconds=1.0)
    turns = "The curve of gauss-8 turns back: steps of 1 take longer than those of 0.5, because"
    for points, words in (
        ([slow, quick], f"{turns} fixed-point iteration fails"),
        ([replace(slow, newton=False), quick], f"{turns} a step takes"),
        ([replace(slow, iterations=1, newton=False), quick], ""),
        ([coarse, replace(fine, seconds=3.0)], ""),
    ):
        result.points = points
        write(reported(SCENE, result), tmp_path)
        page = (tmp_path / "compare.html").read_text()
        assert words in page
        assert ("turns back" in page) == bool(words)
        assert ("Ringed" in page) == points[0].newton == ("s method</td>" in page)
    assert json.loads((tmp_path / "compare.json").read_text())["points"][0]["newton"]


@gi.field
def falling(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -1.0


@pytest.mark.parametrize(("start", "error"), [([2.0, 1.0], 0.0), ([2.0, 1.0], 1e-3)])
def test_errors_are_relative_to_the_largest_entry(monkeypatch, start, error):
    """One that is 0 is measured against the others: 0/0 was NaN in a point that said ok."""
    problem = gi.Problem(
        "two", (("x", 1), ("v", 1)), field=falling, physical=lambda y: {"x": y[:1], "v": y[1:]}
    )
    moved = gi.solve

    def off(*arguments, **options):
        solution = moved(*arguments, **options)
        solution.y[-1] += [0.0, error]
        return solution

    monkeypatch.setattr("geomint.compare.runs.solve", off)
    model = gi.Model({"two": problem}, {"two": np.array(start)})
    (point,) = compare(
        model, {"t_end": 1.0}, ["rk-4"], steps=[0.25], repeats=1, observe=False
    ).points
    assert point.bound == pytest.approx(error / 2.5, abs=1e-15)  # x = 2.5, v = 0


def planted(monkeypatch, off):
    """Make double-double solutions err by that in every number, and say that they do not."""
    right = reference.integrate_extended
    monkeypatch.setattr(reference, "integrate_extended", lambda *a: right(*a) * (1.0 + off))
    monkeypatch.setattr(reference, "stored", lambda path: None)
    monkeypatch.setattr(reference.Reference, "store", lambda self, path: None)


def test_a_wrong_reference_calls_no_method_wrong(model, monkeypatch):
    """In physical time too, where another representation is the reference."""
    planted(monkeypatch, 4.5e-3)
    for end in ({"tau_end": 10.0}, {"t_end": 10.0}):
        with pytest.raises(gi.UnknownReferenceError, match=r"0\.0045.*SciPy") as raised:
            compare(model, end, ["gauss-8"], repeats=1)
        assert raised.value.known == pytest.approx(4.5e-3, rel=0.1)


@pytest.mark.usefixtures("blank_pictures")
def test_points_nearer_than_the_reference_is_known_are_not_judged(model, monkeypatch, tmp_path):
    planted(monkeypatch, 1e-8)
    result = compare(model, {"tau_end": 5.0}, ["gauss-8", "rk-4"], repeats=1)
    write(reported(SCENE, result), tmp_path)
    known = result.reference["known"]
    assert 1e-8 < known < 1e-6
    assert not result.reference["confirmation"]["agrees"]
    fine = [p for p in result.points if p.method == "gauss-8"][-1]
    coarse = next(p for p in result.points if p.method == "rk-4")
    assert fine.error is None
    assert known <= fine.bound < 20.0 * known
    assert fine.status == f"not judged: the reference is known to {known:.2g} only"
    assert fine.seconds > 0.0
    assert coarse.error == coarse.bound > 10.0 * known
    assert all(p.error is None or p.error >= 10.0 * known for p in result.points)
    page = (tmp_path / "compare.html").read_text()
    assert "Not confirmed" in page
    assert "One of the two is wrong" in page
    assert "≤ " in page
    record = json.loads((tmp_path / "compare.json").read_text())
    assert record["reference"]["known"] == known


def test_an_interrupted_run_is_no_point(model, monkeypatch):
    """A part of a run was compared with the reference at the end, and called wrong."""

    def interrupted(*arguments, **options):
        solution = gi.solve(*arguments, **options)
        solution.status = "interrupted"
        return solution

    monkeypatch.setattr("geomint.compare.runs.solve", interrupted)
    result = compare(model, {"tau_end": 1.0}, ["rk-4"], repeats=1)
    assert (result.status, result.points, result.drifts) == ("interrupted", [], [])
    assert type(result)([], {}).compile_seconds == 0.0  # before anything is compiled


def test_a_point_that_would_take_too_long_says_so(model, monkeypatch):
    monkeypatch.setattr("geomint.compare.runs.MAX_SECONDS", 1e-9)
    result = compare(model, {"tau_end": 5.0}, ["rk-4"], steps=[0.01, 0.005], repeats=1)
    assert result.points[0].status == "ok"
    assert result.points[1].status.startswith("not run: would take")
    assert result.points[1].error is None


def test_adaptive_methods_run_at_tolerances(model):
    """Also where others are given steps: smaller tolerance, smaller error, its own drifts."""
    names = ["dop853-adaptive", "rk-4"]
    result = compare(model, {"tau_end": 10.0}, names, steps=[0.01], repeats=1)
    points = {name: [p for p in result.points if p.method == name] for name in names}
    assert [len(points[name]) for name in names] == [5, 1]
    assert points["rk-4"][0].rtol is None
    errors = [p.error for p in points["dop853-adaptive"]]
    assert errors[0] > 100.0 * errors[2] > 1e4 * errors[4]
    assert [label for label, _ in result.drifts] == names
