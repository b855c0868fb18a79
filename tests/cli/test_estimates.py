"""How long a run takes is known before it starts, and said where it is long."""

import re
import time
import warnings

import numpy as np
import pytest

import geomint as gi
from geomint.cli import options
from tests.cli.calls import invoke

LONG = ("--method", "rk-4", "--step", "0.125")
UNITS = {"seconds": 1.0, "minutes": 60.0, "hours": 3600.0, "days": 86400.0, "years": 31557600.0}


@pytest.fixture(autouse=True)
def hurry(monkeypatch):
    """Let the clock run faster: trials and warnings come sooner."""
    clock = time.perf_counter
    monkeypatch.setattr(time, "perf_counter", lambda: 25.0 * clock())


def expected(*line):
    """Return the time that `check` tells, how it knows it, and its number and unit."""
    row = re.search(r"^ time +(at most|about) (\S+) (\w+)", invoke("check", *line).stdout, re.M)
    how, number, unit = row.groups()
    return float(number) * UNITS[unit], how, float(number), unit


def test_a_short_run_is_bounded_by_its_sizes_alone():
    """In proportion to its end, in units of which there are two or more."""
    ends = 1e2, 1e5, 1e6, 1e7
    found = [expected("sphere-n3", "--t-end", end) for end in ends]
    seconds, how, numbers, units = zip(*found, strict=True)
    assert ({"seconds", "minutes"} <= set(units), set(how)) == (True, {"at most"})
    np.testing.assert_allclose(np.divide(seconds, ends), seconds[0] / ends[0], rtol=0.11)
    assert all(n >= 2.0 or unit == "seconds" for n, unit in zip(numbers, units, strict=True))


def test_a_run_warns_of_more_than_a_day():
    """Once, by its own pace, after a second."""
    scene, run = gi.load_scene("sphere-n3"), {"t_end": 1e12, "method": "rk-4", "step": 0.01}
    seen = []

    def callback(reached):
        seen.append(time.perf_counter())
        return seen[-1] > seen[0] + 3.0

    with pytest.warns(gi.GeomintWarning, match="at its pace this run takes about") as caught:
        gi.solve(scene.problem, scene.state, **run, callback=callback)
    assert [w.filename for w in caught] == [__file__]


def test_a_long_one_is_tried():
    """In proportion to its end, whichever time that is in."""
    tau, t = (
        expected("hamiltonized-n3", *LONG, *end)
        for end in (("--tau-end", 1e12), ("--t-end", -4e14))
    )
    assert [tau[1], t[1]] == ["about", "about"]
    assert t[0] / tau[0] > 10.0


def test_beyond_a_day_needs_a_word(tmp_path, monkeypatch):
    """Nothing is written then. All methods of a report count."""
    monkeypatch.setattr(type(gi.make_plan(gi.load_scene("sphere-n3"))), "solve", pytest.fail)
    line = ("drift", "sphere-n3", "--methods", "rk-4:0.5,rk-4:1e-6", "--t-end", 1e7)
    done = invoke(*line, "--out", tmp_path / "out")
    assert (done.exit_code, list(tmp_path.iterdir())) == (2, [])
    assert "this takes about" in done.stderr
    assert "give --yes for more than a day" in done.stderr


def test_beyond_an_hour_is_said(tmp_path):
    """In place of the warning of that run only: later ones are heard."""
    (tmp_path / "file").touch()
    before, out = list(warnings.filters), tmp_path / "file" / "out.nc"
    done = invoke("run", "hamiltonized-n3", *LONG, "--tau-end", 2e9, "--yes", "--out", out)
    assert done.exit_code == 2
    assert done.stderr.count("note: this takes about") == done.stderr.count("takes") == 1
    assert "give --yes" not in done.stderr
    assert warnings.filters == before


def test_a_large_scene_is_checked_at_once():
    """Its tables would have n³/2 numbers for each of two representations."""
    n = 200
    rng = np.random.default_rng(0)
    large = gi.Scene(
        system={"name": "chaplygin-sphere-reduced", "a": np.linspace(0.5, 1.5, n), "D": 4.0},
        initial={"gamma": [1.0] + [0.0] * (n - 1), "p": [0.0, *rng.normal(size=n - 1)]},
        time={"t_end": 10.0},
    )
    for problem in large.model.problems.values():
        assert len(problem.params) < 2 * n**2
    assert set(large.problem.invariants) == {"energy", "K"}


def test_what_lasts_is_said(monkeypatch, capsys):
    monkeypatch.setattr(options, "PATIENCE", 0.0)
    said, end = "", time.monotonic() + 10.0
    with options.patience("planning"):
        while "geomint: planning …" not in said:
            assert time.monotonic() < end
            said += capsys.readouterr().err
            time.sleep(0.01)


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize(
    "line",
    [
        "methods",
        "scenes",
        "check ball-3d",
        "drift sphere-n3 --t-end 20",
        "drift sphere-n3 --t-end 20 --methods gauss-8,rk-4",
    ],
)
def test_tables_fit_80_columns(line, tmp_path):
    out = ("--out", tmp_path) if line.startswith("drift") else ()
    table = invoke(*line.split(), *out, columns="80").stdout.split("report:")[0]
    assert max(map(len, table.splitlines())) <= 80
    assert "…" not in table
    assert ("undetermined" in table) == bool(out)
