"""What is not finite is never part of a success: status, class, JSON, pages and exit code say so."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.plan import Plan
from geomint.watch import functions
from geomint.watch.growth import NOT_FINITE
from geomint.watch.windows import Series
from tests.series import drift_of_series


@gi.field
def turning(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -y[0]


@gi.observable
def logarithm(params, t, y, work):
    return gi.log(y[0])


@gi.observable
def area(params, t, y, work):
    return y[0] * y[0] + y[1] * y[1]


@gi.observable
def density(params, t, y, work):
    return gi.log(y[0])


PROBLEM = gi.Problem(
    name="turning",
    pieces=(("q", 1), ("p", 1)),
    field=turning,
    invariants={"area": area},
    observables={"logarithm": logarithm},
    measure=gi.Measure(density),
)


def solved(observe, **more):
    arguments = {"t_end": 10.0, "step": 0.01, "method": "rk-4", "compiled": False, **more}
    return gi.solve(PROBLEM, [1.0, 0.0], observe=observe, **arguments)


def test_an_observable_that_is_not_finite():
    solution = solved("all", t_end=3.0, step=0.02)
    assert solution.status == NOT_FINITE
    assert not solution.success
    for name in ("logarithm", "measure"):
        found = solution.drift[name]
        assert found.drift_class == NOT_FINITE
        assert 1.5 < found.not_finite_from < 1.6  # ln cos t ends at π/2
        assert f"'{name}' is not finite from 1.5" in solution.message
    assert solution.drift["area"].drift_class != NOT_FINITE
    assert np.isfinite(solution.y).all()
    assert solved("area").status == "success"


def test_what_is_finite_and_huge_is_measured():
    """Sums of deviations and slopes may be too large for a float where no deviation is."""
    huge = {
        "cosine": lambda params, t, y, work: 8e307 * y[0],
        "sine": lambda params, t, y, work: 1.7e308 * y[1],
        "line": lambda params, t, y, work: 8e307 * y[0] + 8e307 * (t / 100.0),
        "beyond": lambda params, t, y, work: 1.7e308 * y[0],
        "near 0": lambda params, t, y, work: y[1] + 1e-310,
    }
    solution = solved(huge, t_end=100.0, step=0.05)
    kinds = {name: drift.drift_class for name, drift in solution.drift.items()}
    assert kinds == {
        "cosine": "bounded",
        "sine": "bounded",
        "line": "linear",
        "beyond": NOT_FINITE,
        "near 0": "bounded",
    }
    assert solution.status == NOT_FINITE
    assert solution.drift["line"].slope == pytest.approx(8e305, rel=0.05)
    assert solution.drift["cosine"].max_rel_error == pytest.approx(2.0, rel=1e-3)
    for name in ("sine", "beyond", "near 0"):
        assert solution.drift[name].max_rel_error is None


def test_a_clock_that_stands_still_loses_no_run():
    """Drifts are per unit of a time that does not go on: nothing is known of them."""
    grows = gi.field(lambda params, t, y, out, work: out.__setitem__(0, y[0] * y[0]))
    still = gi.observable(lambda params, t, y, work: 0.0 * y[0])
    problem = gi.Problem("still", (("y", 1),), field=grows, time="tau", clock=still)
    own = {"own": lambda params, t, y, work: 1.0 / y[0]}
    run = {"t_end": 5.0, "step": 0.01, "method": "rk-4", "compiled": False}
    with pytest.raises(gi.NonFiniteError) as caught:
        gi.solve(problem, [1.0], observe=own, **run)
    found = caught.value.partial.drift["own"]
    assert found.windows.samples > 64
    assert (found.drift_class, found.slope) == ("undetermined", None)


def test_it_is_kept_in_a_file(tmp_path):
    solution = solved(["logarithm"], t_end=3.0)
    solution.save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc")
    assert saved.provenance["status"] == NOT_FINITE
    assert saved.drift["logarithm"].drift_class == NOT_FINITE
    assert saved.drift["logarithm"].windows.not_finite_from == pytest.approx(1.58)
    assert solution.plot_drift().axes


@pytest.fixture
def _vanishing(monkeypatch):
    """The second method of several loses its measure half-way."""
    solve = Plan.solve

    def spoiled(plan, progress):
        solution = solve(plan, progress)
        if plan.scene.method.name == "rk-4":
            scale = solution.drift["energy"].scale
            values = np.where(np.arange(100) < 50, 1e-9, np.nan)
            spoiled = drift_of_series("energy", np.arange(1.0, 101.0), values, scale)
            solution.drift["energy"] = spoiled
            solution.status, solution.message = NOT_FINITE, "'energy' is not finite from 51 on"
        return solution

    monkeypatch.setattr(Plan, "solve", spoiled)


@pytest.mark.usefixtures("_vanishing")
def test_a_report_of_several_methods(tmp_path):
    scene = gi.load_scene("hamiltonized-n3").changed(time={"tau_end": 20.0})
    runs = gi.drift_report(scene, tmp_path, False, methods=["gauss-8", "rk-4"])
    assert runs["rk-4"].status == NOT_FINITE
    assert runs["rk-4"].title == "rk-4 (not finite)"
    assert runs.status == NOT_FINITE
    record = json.loads((tmp_path / "drift.json").read_text("utf-8"))
    entry = record["methods"]["rk-4"]
    assert (entry["status"], record["status"]) == (NOT_FINITE, NOT_FINITE)
    quantity = entry["quantities"]["energy"]
    assert quantity["class"] == NOT_FINITE
    assert quantity["max_abs_error"] is None
    assert quantity["not_finite_from"] == 51.0
    page = (tmp_path / "report.html").read_text("utf-8")
    assert '<span class="kind not-finite">not finite</span>' in page
    assert "rk-4: not finite, not a success." in page


class Vanishing(Series):
    """Series of quantities that are infinite from time 30 on."""

    def add(self, times, values):
        super().add(times, np.where(times < 30.0, values, np.inf))


def test_a_report_and_the_command(tmp_path, monkeypatch):
    monkeypatch.setattr(functions, "Series", Vanishing)
    command = ["drift", "hamiltonized-n3", "--tau-end", "50", "--out", str(tmp_path)]
    result = CliRunner().invoke(main, command)
    assert result.exit_code == 2
    assert "Infinite or not a number: energy (from τ = 30 on)" in " ".join(result.output.split())
    record = json.loads((tmp_path / "drift.json").read_text("utf-8"))
    (entry,) = record["methods"].values()
    assert entry["run"]["status"] == entry["status"] == record["status"] == NOT_FINITE
    energy = entry["quantities"]["energy"]
    assert energy["class"] == NOT_FINITE
    assert energy["not_finite_from"] == pytest.approx(30.0, abs=0.3)
    assert energy["final_error"] is None
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "not a success" in page
    assert '<span class="kind not-finite">not finite</span>' in page
