"""What stress judges by: references that are confirmed, and none that err."""

import numpy as np
import pytest

import geomint as gi
from geomint.compare import reference
from geomint.compare.reference_record import name_of
from geomint.stress import known_end as ends
from geomint.stress.judge import Cell, Trial, judge
from geomint.stress.known_end import field_rounding, known_end
from geomint.stress.references import references_in_words, references_of


@gi.field
def turning(params, t, y, out, work):
    """A point on a circle, at angular velocity 1."""
    out[0] = -y[1]
    out[1] = 1.0 * y[0]


PROBLEM = gi.Problem("circle", (("x", 2),), field=turning)
EAST = np.array([1.0, 0.0])


@pytest.fixture
def planted(monkeypatch, tmp_path):
    """Return a function that sets by how much, relative, double-double solutions err."""

    def plant(off):
        def turned(problem, y, end, h):
            c, s = np.cos(np.longdouble(end)), np.sin(np.longdouble(end))
            return np.array([c * y[0] - s * y[1], s * y[0] + c * y[1]]) * (1.0 + off)

        monkeypatch.setattr(reference, "integrate_extended", turned)
        monkeypatch.setattr(ends, "integrate_extended", turned)
        own = tmp_path.name  # a reference of this test alone
        monkeypatch.setattr(reference, "name_of", lambda *a: f"{own}-{name_of(*a)}")

    return plant


def test_a_reference_says_how_sure_it_is(planted):
    planted(0.0)
    found = known_end(PROBLEM, EAST, 2.0)
    assert found.known == 0.0
    assert 1e-16 < found.confirmed < 1e-11
    assert found.scaled({"x": 2.0}).confirmed == found.confirmed


@gi.field
def cancelling(params, t, y, out, work):
    """Two large numbers whose difference is 1 to 1e-8."""
    out[0] = (params[0] + y[0]) - params[0]
    out[1] = 1.0 * y[1]


def test_digits_that_a_field_loses_are_seen():
    if np.finfo(np.longdouble).eps > 1e-18:
        pytest.skip("no extended precision here")
    lossy = gi.Problem("lossy", (("x", 2),), params=[1e8 / 3.0], field=cancelling)
    assert 1e-10 < field_rounding(lossy, np.array([0.7, 1.0])) < 1e-7
    assert field_rounding(PROBLEM, EAST) <= 1e-15


@pytest.mark.parametrize("off", [4.5e-3, 1e-9])
def test_a_wrong_reference_is_refused(planted, off):
    planted(off)
    with pytest.raises(gi.UnknownReferenceError, match="SciPy"):
        known_end(PROBLEM, EAST, 2.0)


@pytest.mark.parametrize("off", [0.0, 4.5e-3, 1e-9])
def test_no_right_method_is_called_wrong_by_a_wrong_reference(planted, monkeypatch, off):
    def uncompiled(*arguments, **options):
        return gi.solve(*arguments, **options, compiled=False)

    monkeypatch.setattr("geomint.stress.judge.solve", uncompiled)
    planted(off)
    trial = Trial(PROBLEM, EAST)
    for name in ("rk-4", "dop853"):
        found = judge(trial, gi.find_method(name))
        assert found["verdict"] == "ok"
        assert ("no reference (UnknownReferenceError" in found["message"]) == (off > 0.0)
        assert (found.get("confirmed") is None) == (off > 0.0)


def test_the_report_counts_references():
    def cell(**found):
        return Cell("circle", "step", 1.0, "1", 2, "rk-4", "ok", **found)

    cells = [
        cell(known=1e-25, confirmed=1e-13),
        cell(known=2e-20, confirmed=1e-12),
        cell(known=0.0, confirmed=1e-14),
        cell(message="no reference (UnknownReferenceError: …): compared with a finer run"),
        cell(),
    ]
    found = references_of(cells)
    assert found == {
        "judged": 3, "known": 2e-20, "confirmed": 1e-13, "confirmed_worst": 1e-12, "without": 1,
    }  # fmt: skip
    told = references_in_words(found)
    for word in ("3 cells", "1e-19", "1e-13", "1e-12", "1 are compared"):
        assert word in told
    assert references_in_words(references_of([])) == "References: none."
