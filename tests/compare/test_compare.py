"""Comparisons: the same physical end for every method, and honest failures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.compare.of_scene import compare_scene
from geomint.compare.runs import compare
from geomint.problems.systems import find_system
from geomint.report.compare_page import write_compare_report

METHODS = ["gauss-8", "gauss-4", "rattle-6", "cf-4", "rkmk-4", "dop853", "rk-4"]


@pytest.fixture(scope="module")
def model():
    system = find_system("chaplygin-sphere-hamiltonized")
    parameters = system.parameters(a=[0.8, 1.1, 1.5], D=4.0)
    with pytest.warns(gi.GeomintWarning):
        return system.build(parameters, system.initial(gamma=[1.0, 2.0, 3.0], p=[1.8, -3.0, 1.2]))


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
    """Six codes in three representations and two times: agreement is no accident."""
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


def test_times_and_counts_are_there(comparison):
    for point in comparison.points:
        if point.status == "ok":
            assert point.seconds is not None
            assert point.seconds > 0.0
            assert point.steps
            assert point.evaluations
            assert point.repeats == 1


def test_physical_end_gives_the_same_points(model, comparison):
    other = compare(
        model,
        {"t_end": comparison.reference["physical_end"]},
        ["gauss-8"],
        steps=[0.25],
        repeats=1,
        observe=False,
    )
    assert other.points[0].error < 1e-12


def test_the_exact_flow_is_the_same_reference(model, comparison):
    """Two references that share nothing agree to rounding, in τ and in t."""
    physical = comparison.reference["physical_end"]
    for end in ({"tau_end": 10.0}, {"t_end": physical}):
        other = compare(model, end, ["gauss-8"], repeats=1, observe=False, reference="exact")
        assert other.reference["method"] == "exact flow"
        assert other.reference["physical_end"] == pytest.approx(physical, rel=1e-14)
        assert 1e-16 < other.reference["error_estimate"] < 1e-11
        for name, expected in comparison.reference["quantities"].items():
            np.testing.assert_allclose(other.reference["quantities"][name], expected, atol=1e-12)


def test_the_exact_flow_is_taken_where_the_other_would_take_minutes(model, monkeypatch):
    asked = []
    monkeypatch.setattr("geomint.compare.endpoint.MOST_EXTENDED_STEPS", 10)
    result = compare(
        model, {"tau_end": 1e4}, ["gauss-8"], steps=[0.5], repeats=1, observe=False,
        report=asked.append,
    )  # fmt: skip
    assert result.reference["method"] == "exact flow"
    assert result.points[0].error < 1e-5
    assert any("exact flow" in text for text in asked)


def test_without_an_exact_flow_it_is_refused():
    system = find_system("neumann")
    parameters = system.parameters(a=[0.7, 1.0, 1.6], strength=2.0)
    model = system.build(parameters, system.initial(q=[0.6, 0.0, 0.8], v=[0.8, 1.0, -0.6]))
    with pytest.raises(gi.FormError, match="no exact flow"):
        compare(model, {"t_end": 1.0}, ["rk-4"], reference="exact")
    with pytest.raises(gi.DomainError, match="auto"):
        compare(model, {"t_end": 1.0}, ["rk-4"], reference="best")


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
    result = compare(reduced, {"t_end": 1.0}, ["rattle-2", "gauss-8"], repeats=1)
    assert "needs the form 'hamiltonian'" in result.points[0].status
    assert result.points[-1].status == "ok"


def test_report_files(tmp_path):
    scene = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 5.0})
    result = compare_scene(scene, ["gauss-8", "rk-4", "cf-4"], repeats=1)
    write_compare_report(result, scene, tmp_path)
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


def test_why_a_longer_step_takes_longer(tmp_path):
    """Newton's method, or more iterations, as the page says; not a time that may be noise."""
    scene = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 5.0})
    result = compare_scene(scene, ["gauss-8"], [1.0, 0.5], repeats=1)
    coarse, fine = result.points
    assert (coarse.newton, fine.newton) == (True, False)
    assert coarse.iterations / coarse.steps > 2.0 * fine.iterations / fine.steps > 10.0
    slow, quick = replace(coarse, seconds=2.0), replace(fine, seconds=1.0)
    turns = "The curve of gauss-8 turns back: steps of 1 take longer than those of 0.5, because"
    for points, words in (
        ([slow, quick], f"{turns} fixed-point iteration fails"),
        ([replace(slow, newton=False), quick], f"{turns} a step takes"),
        ([replace(slow, iterations=1, newton=False), quick], ""),
        ([coarse, replace(fine, seconds=3.0)], ""),
    ):
        result.points = points
        write_compare_report(result, scene, tmp_path)
        page = (tmp_path / "compare.html").read_text()
        assert words in page
        assert ("turns back" in page) == bool(words)
        assert ("Ringed" in page) == points[0].newton == ("s method</td>" in page)
    assert json.loads((tmp_path / "compare.json").read_text())["points"][0]["newton"]


def test_error_is_relative_to_the_largest_entry(model):
    from geomint.compare.endpoint import Endpoint

    problem = model.problems["hamiltonized"]
    y = model.states["hamiltonized"]
    truth = problem.physical_state(y)
    endpoint = Endpoint(problem, {"tau_end": 1.0}, 1.0, truth)
    assert endpoint.error(problem, y) == 0.0
    moved = y.copy()
    moved[0] += 1e-6
    assert endpoint.error(problem, moved) == pytest.approx(
        max(
            np.max(np.abs(problem.physical_state(moved)[k] - truth[k])) / np.max(np.abs(truth[k]))
            for k in truth
        )
    )


def test_a_quantity_that_is_zero_is_measured_against_the_others():
    """0/0 was NaN in a point that said ok."""
    from geomint.compare.endpoint import Endpoint

    problem = gi.Problem(
        "two", (("x", 1), ("v", 1)), field=falling, physical=lambda y: {"x": y[:1], "v": y[1:]}
    )
    endpoint = Endpoint(problem, {"t_end": 1.0}, 1.0, {"x": np.array([2.0]), "v": np.zeros(1)})
    assert endpoint.error(problem, np.array([2.0, 0.0])) == 0.0
    assert endpoint.error(problem, np.array([2.0, 1e-3])) == pytest.approx(5e-4)


@gi.field
def falling(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -1.0


def planted(monkeypatch, off):
    """Make double-double solutions err by that in every number, and say that they do not."""
    from geomint.compare import reference

    right = reference.integrate_extended
    monkeypatch.setattr(reference, "integrate_extended", lambda *a: right(*a) * (1.0 + off))
    monkeypatch.setattr(reference, "stored", lambda path: None)
    monkeypatch.setattr(reference.Reference, "store", lambda self, path: None)


def test_a_wrong_reference_calls_no_method_wrong(model, monkeypatch):
    planted(monkeypatch, 4.5e-3)
    with pytest.raises(gi.UnknownReferenceError, match=r"0\.0045.*SciPy") as raised:
        compare(model, {"tau_end": 10.0}, ["gauss-8"], repeats=1)
    assert raised.value.known == pytest.approx(4.5e-3, rel=0.1)


def test_a_wrong_reference_in_physical_time_calls_no_method_wrong(model, monkeypatch):
    """Where the scene's own problem is in τ, another representation is the reference."""
    planted(monkeypatch, 4.5e-3)
    with pytest.raises(gi.UnknownReferenceError, match="SciPy"):
        compare(model, {"t_end": 10.0}, ["gauss-8"], repeats=1)


def test_points_nearer_than_the_reference_is_known_are_not_judged(model, monkeypatch, tmp_path):
    planted(monkeypatch, 1e-8)
    scene = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 5.0})
    result = compare_scene(scene, ["gauss-8", "rk-4"], repeats=1)
    write_compare_report(result, scene, tmp_path)
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


def test_a_point_that_would_take_too_long_says_so(model, monkeypatch):
    monkeypatch.setattr("geomint.compare.runs.MAX_SECONDS", 1e-9)
    result = compare(model, {"tau_end": 5.0}, ["rk-4"], steps=[0.01, 0.005], repeats=1)
    assert result.points[0].status == "ok"
    assert result.points[1].status.startswith("not run: would take")
    assert result.points[1].error is None


def test_adaptive_methods_run_at_tolerances(model):
    """Also where others are given steps: smaller tolerance, smaller error, its own drifts."""
    names = ["dop853-adaptive", "rkmk-dop853-adaptive", "rk-4"]
    result = compare(model, {"tau_end": 10.0}, names, steps=[0.01], repeats=1)
    points = {name: [p for p in result.points if p.method == name] for name in names}
    assert [len(points[name]) for name in names] == [5, 5, 1]
    assert points["rk-4"][0].rtol is None
    for name in names[:2]:
        assert [p.rtol for p in points[name]] == [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
        assert all(p.status == "ok" and p.step > 0.0 for p in points[name])
        errors = [p.error for p in points[name]]
        assert errors[0] > 100.0 * errors[2] > 1e4 * errors[4]
    assert [label for label, _ in result.drifts] == names
