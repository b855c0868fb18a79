"""What is not finite is never part of a success: status, class, JSON, pages and exit code say so."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.plan import Plan
from tests.series import drift_of_series

NOT_FINITE = "not finite"


@gi.field
def turning(params, t, y, out, work):
    out[0] = y[1]
    out[1] = -y[0]


logarithm = gi.observable(lambda params, t, y, work: gi.log(y[0]))
area = gi.observable(lambda params, t, y, work: y[0] * y[0] + y[1] * y[1])
PROBLEM = gi.Problem("turning", (("q", 1), ("p", 1)), field=turning, invariants={"area": area},
                     observables={"logarithm": logarithm}, measure=gi.Measure(logarithm))  # fmt: skip


def solved(observe, **more):
    arguments = {"t_end": 10.0, "step": 0.01, "method": "rk-4", "compiled": False, **more}
    return gi.solve(PROBLEM, [1.0, 0.0], observe=observe, **arguments)


def test_an_observable_that_is_not_finite(tmp_path):
    """Status, message and drift say so, in a file too."""
    solution = solved("all", t_end=3.0, step=0.02)
    assert (solution.status, solution.success) == (NOT_FINITE, False)
    for name in ("logarithm", "measure"):
        found = solution.drift[name]
        assert found.drift_class == NOT_FINITE
        assert 1.5 < found.not_finite_from < 1.6  # ln cos t ends at π/2
        assert f"'{name}' is not finite from 1.5" in solution.message
    assert solution.drift["area"].drift_class != NOT_FINITE
    assert np.isfinite(solution.y).all()
    solution.plot_drift().canvas.draw()
    solution.save(tmp_path / "run.nc")
    saved = gi.load(tmp_path / "run.nc")
    assert saved.provenance["status"] == saved.drift["logarithm"].drift_class == NOT_FINITE
    assert saved.drift["logarithm"].windows.not_finite_from == found.not_finite_from
    assert solved("area").status == "success"


def test_what_is_finite_and_huge_is_measured():
    """Sums of deviations and slopes may be too large for a float where no deviation is."""
    huge = {
        "cosine": lambda params, t, y, work: 8e307 * y[0],
        "sine": lambda params, t, y, work: 1.7e308 * y[1],
        "line": lambda params, t, y, work: 8e307 * y[0] + 8e307 * (t / 100.0),
        "beyond": lambda params, t, y, work: 1.7e308 * y[0],
        "near 0": lambda params, t, y, work: y[1] + 1e-310,
        "never": lambda params, t, y, work: gi.log(-1.0 - y[0]),
    }
    solution = solved(huge, t_end=100.0, step=0.05)
    kinds = {name: drift.drift_class for name, drift in solution.drift.items()}
    finite = {"cosine": "bounded", "sine": "bounded", "line": "linear", "near 0": "bounded"}
    assert kinds == finite | {"beyond": NOT_FINITE, "never": NOT_FINITE}
    assert solution.status == NOT_FINITE
    assert solution.drift["never"].not_finite_from == 0.0
    assert 1.5 < solution.drift["beyond"].not_finite_from < 3.2
    assert solution.drift["line"].slope == pytest.approx(8e305, rel=0.05)
    assert solution.drift["cosine"].max_rel_error == pytest.approx(2.0, rel=1e-3)
    for name in ("sine", "beyond", "near 0"):
        assert solution.drift[name].max_rel_error is None


@pytest.mark.usefixtures("blank_pictures")
def test_a_report_and_the_command(tmp_path, monkeypatch):
    """The second of two methods loses its energy half-way; nothing of it counts as a success."""
    solve = Plan.solve

    def spoiled(plan, progress):
        solution = solve(plan, progress)
        if plan.scene.method.name == "rk-4":
            values = np.where(np.arange(100) < 50, 1e-9, np.nan)
            drift = drift_of_series("energy", np.arange(1.0, 101.0), values, 1.0)
            solution.drift["energy"] = drift
            solution.status, solution.message = NOT_FINITE, "'energy' is not finite from 51 on"
        return solution

    monkeypatch.setattr(Plan, "solve", spoiled)
    command = ["drift", "hamiltonized-n3", "--tau-end", "5", "--out", str(tmp_path)]
    for given, runs in ((["--methods", "gauss-8,rk-4"], 2), (["--method", "rk-4"], 1)):
        result = CliRunner().invoke(main, [*command, *given])
        assert result.exit_code == 2
        record = json.loads((tmp_path / "drift.json").read_text("utf-8"))
        entry, page = record["methods"]["rk-4"], (tmp_path / "report.html").read_text("utf-8")
        assert len(record["methods"]) == runs
        assert entry["run"]["status"] == entry["status"] == record["status"] == NOT_FINITE
        quantity = entry["quantities"]["energy"]
        assert (quantity["class"], quantity["not_finite_from"]) == (NOT_FINITE, 51.0)
        assert quantity["max_abs_error"] is quantity["final_error"] is None
        assert '<span class="kind not-finite">not finite</span>' in page
        assert "rk-4: not finite, not a success." in page
    assert "Infinite or not a number: energy (from τ = 51 on)" in " ".join(result.output.split())
