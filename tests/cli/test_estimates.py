"""How long a run takes is known before it starts, and said where it is long."""

import math

import numpy as np
import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main, options
from geomint.plan import estimate
from geomint.run import progress

# What is in pictures: tests/report.
pytestmark = pytest.mark.usefixtures("blank_pictures")

LONG = ["--method", "rk-4", "--step", "0.125"]


def invoke(*arguments, columns="80"):
    return CliRunner().invoke(main, [str(a) for a in arguments], env={"COLUMNS": columns})


def scene(**time):
    return gi.load_scene("hamiltonized-n3").changed(time=time)


def test_a_short_run_is_bounded_by_its_sizes_alone(monkeypatch):
    def never(*args, **kwargs):
        raise AssertionError("tried")

    monkeypatch.setattr("geomint.plan.duration.solve", never)
    found = estimate(gi.make_plan(scene(tau_end=1000.0)))
    assert not found.measured
    assert 0.0 < found.seconds < 60.0
    told = invoke("check", "hamiltonized-n3", "--tau-end", 1000).stdout
    assert f"at most {progress.time_in_words(found.seconds)}" in told


@pytest.mark.parametrize("end", [{"tau_end": 1e12}, {"t_end": 4e12}, {"t_end": -4e12}])
def test_a_long_one_is_tried(end):
    """In proportion to its end, whichever time that is in."""
    seconds = []
    for factor in (1.0, 100.0):
        long = scene(**{name: factor * value for name, value in end.items()})
        found = estimate(gi.make_plan(long.changed_integration("rk-4", 0.125)))
        assert found.measured
        seconds.append(found.seconds)
    assert math.isfinite(seconds[1])
    assert 10.0 < seconds[1] / seconds[0] < 1000.0


@pytest.mark.parametrize("command", ["run", "drift", "compare"])
def test_beyond_a_day_needs_a_word(command, tmp_path):
    """Nothing is written then."""
    extra = LONG if command != "compare" else ["--reference", "extended"]
    out = tmp_path / "out"
    done = invoke(command, "hamiltonized-n3", *extra, "--tau-end", 1e13, "--out", out)
    assert done.exit_code == 2
    assert "this takes about" in done.stderr
    assert "give --yes for more than a day" in done.stderr
    assert not out.exists()


def test_all_methods_of_a_report_count(tmp_path):
    methods = ["--methods", "cf-4:40,gauss-8:0.125"]
    done = invoke(
        "drift", "hamiltonized-n3", *methods, "--tau-end", 1e13, "--out", tmp_path / "out"
    )
    assert done.exit_code == 2
    assert "give --yes" in done.stderr


def test_beyond_an_hour_is_said(monkeypatch, tmp_path):
    monkeypatch.setattr(progress, "HOUR", 1e-9)
    done = invoke("run", "sphere-n3", "--t-end", 5, "--out", tmp_path / "out.nc")
    assert done.exit_code == 0
    assert "note: this takes at most" in done.stderr
    assert done.stderr.count("takes") == 1


def test_a_run_warns_of_more_than_a_day(monkeypatch):
    """Once, by its own pace; here after no time, of more than no time."""
    monkeypatch.setattr(progress, "_DELAY", 0.0)
    arguments = {"t_end": 100.0, "method": "rk-4", "step": 0.01}
    problem = gi.load_scene("sphere-n3")
    gi.solve(problem.problem, problem.state, **arguments)
    monkeypatch.setattr(progress, "DAY", 1e-9)
    with pytest.warns(gi.GeomintWarning, match="at its pace this run takes about") as caught:
        gi.solve(problem.problem, problem.state, **arguments)
    assert [w.filename for w in caught] == [__file__]


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.0381, "0.038 seconds"),
        (119.0, "119 seconds"),
        (3600.0, "60 minutes"),
        (1.5e4, "4.2 hours"),
        (1e6, "12 days"),
        (1e13, "3.2e+05 years"),
    ],
)
def test_words(seconds, words):
    assert progress.time_in_words(seconds) == words


def test_a_large_scene_is_checked_at_once():
    """Its tables would have n³/2 numbers for each of two representations."""
    n = 400
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
    with options.patience("planning"):
        for _ in range(1000):
            if "planning" in capsys.readouterr().err:
                return
            __import__("time").sleep(0.01)
    pytest.fail("nothing was said")


@pytest.mark.nightly
def test_compare_says_what_does_not_fit(tmp_path):
    arguments = ["--methods", "rk-4,rattle-4", "--steps", "0.5,0.25", "--repeats", 1, "--t-end", 5]
    arguments += ["--reference", "exact"]
    done = invoke("compare", "ball-3d", *arguments, "--out", tmp_path)
    assert done.exit_code == 2
    assert "geomint: rattle-4: no result: method 'rattle-4' needs the form" in done.stderr
    assert done.stdout.count(" rk-4 ") == 2
    assert "does not fit" in done.stdout
    assert max(map(len, done.stdout.split("reference:")[0].splitlines())) <= 80
    fitting = invoke("compare", "ball-3d", *arguments, "--methods", "rk-4", "--out", tmp_path)
    assert fitting.exit_code == 0


def test_titles_do_not_steer_the_terminal(tmp_path):
    text = gi.load_scene("sphere-n3").changed(
        title="a\x1b[31mb\x9bc\u202ed", description="e\x1b]0;f\x07"
    )
    path = tmp_path / "scene.toml"
    path.write_text(text.toml(), encoding="utf-8")
    for command in (["check"], ["run", "--t-end", 5, "--out", tmp_path / "o.nc"]):
        done = invoke(command[0], path, *command[1:])
        assert done.exit_code == 0
        assert r"a\x1b[31mb\x9bc\u202ed" in done.stdout
        assert not {"\x1b", "\x9b", "\x07", "\u202e"} & set(done.stdout + done.stderr)


def test_help_says_what_other_packages_commands_do():
    told = " ".join(invoke("--help").stdout.split())
    assert "audit Check the formulas of Jovanović's paper" in told
    assert "inertia Convert principal moments" in told
    assert "From chaplygin" not in told


@pytest.mark.parametrize(
    "arguments",
    [["methods"], ["scenes"], ["check", "ball-3d"], ["check", "ball-3d", "--t-end", "1e12"]],
    ids=" ".join,
)
def test_tables_fit_80_columns(arguments):
    lines = invoke(*arguments).stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert "…" not in "".join(lines)


@pytest.mark.parametrize("methods", [[], ["--methods", "gauss-8,rk-4"]], ids=["one", "two"])
def test_drifts_fit_80_columns(methods, tmp_path):
    done = invoke("drift", "ball-3d", "--t-end", 20, *methods, "--out", tmp_path)
    table = done.stdout.split("report:")[0]
    assert max(map(len, table.splitlines())) <= 80
    assert "undetermined" in table
    assert "…" not in table
