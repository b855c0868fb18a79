"""The commands: what they print, write and return."""

import json

import pytest

import geomint as gi
from tests.cli.calls import alone, by_fixed_point, invoke

# What is in pictures: tests/report.
pytestmark = pytest.mark.usefixtures("blank_pictures")

# Scenes of five time units by methods that other tests compile too; others run at night.
SCENES = [
    pytest.param(name, marks=[pytest.mark.nightly] * (name not in ("ball-3d", "sphere-n3")))
    for name in gi.scene_names()
]


def test_lists_name_all_there_is():
    helped, scenes, listed = (invoke(word) for word in ("--help", "scenes", "methods"))
    assert [told.exit_code for told in (helped, scenes, listed)] == [0, 0, 0]
    for name in ("scenes", "methods", "check", "run", "drift", "compare"):
        assert f"  {name} " in helped.stdout
    said = " ".join(helped.stdout.split())
    assert "audit Check the formulas of Jovanović's paper" in said
    assert [name for name in gi.scene_names() if name not in scenes.stdout] == []
    assert [name for name in gi.method_names() if name not in listed.stdout] == []
    heads = [line for line in listed.stdout.splitlines() if "(needs " in line]
    families = {gi.find_method(name).family for name in gi.method_names()}
    assert {line.partition(" (")[0] for line in heads} == families
    assert "Crouch–Grossman (needs action): keeps group orbits and steady motions" in heads
    only = invoke("methods", "--form", "hamiltonian").stdout
    assert ("rattle-4" in only, "gauss-8" in only) == (True, False)
    assert invoke("methods", "--form", "acton").exit_code == 2


@pytest.mark.parametrize("name", SCENES)
def test_built_in_scenes_are_checked_and_run_shortened(name, tmp_path):
    told, scene, out = invoke("check", name), gi.load_scene(name), tmp_path / "run.nc"
    assert told.exit_code == 0
    for word in ("representation", "method", "step", "steps", "watched", "why"):
        assert word in told.stdout
    result = invoke("run", name, f"--{scene.problem.time}-end", "5", "--out", out, "--quiet")
    assert (result.exit_code, result.stdout) == (0, "")
    saved = gi.load(out)
    assert (saved.provenance["status"], saved.tau[-1]) == ("success", 5.0)
    assert set(saved.drift) == set(scene.content.observe.quantities)


def test_drift_of_several_methods(tmp_path, monkeypatch):
    """By default in the folder `report`."""
    monkeypatch.chdir(tmp_path)
    line = ("drift", by_fixed_point(tmp_path), "--t-end", 5, "--methods", "rk-4:0.05, gauss-8:40")
    result = invoke(*line)
    assert result.exit_code == 0, result.output
    out = tmp_path / "report"
    names = {path.name for path in out.iterdir()}
    assert names == {"report.html", "drift.json", "drift.png", "drift.svg"}
    assert "gauss-8: failed: the implicit step did not converge" in result.stderr
    for word in ("report: report/report.html", "a second", "energy", "rk-4"):
        assert word in result.stdout
    record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
    assert list(record["methods"]) == ["rk-4", "gauss-8"]
    run, provenance = record["methods"]["rk-4"]["run"], record["provenance"]
    assert (run["method"], run["step"], run["steps"]) == ("rk-4", 0.05, 100)
    assert provenance["scene"]["time"] == {"t_end": 5}
    assert provenance["command"].startswith("geomint")
    arguments = ("drift", "ball-3d", "--t-end", 1, "--methods", "rattle-2,rattle-4")
    assert invoke(*arguments, "--quiet", "--out", "all-failed").exit_code == 2


def test_methods_of_the_scene_and_of_the_command_line(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(
        drift={"methods": ["gauss-8", "rk-4:0.2"], "quantities": ["energy"], "t_end": 2.0}
    )
    path, out = tmp_path / "scene.toml", tmp_path / "report"
    path.write_text(scene.toml(), encoding="utf-8")
    told = invoke("check", path, "--for-drift").stdout
    assert ("0.2 in t" in told, told.count("representation")) == (True, 2)
    assert invoke("check", path).stdout.count("representation") == 1
    for more, methods in (((), ["gauss-8", "rk-4:0.2"]), (("--method", "gauss-8"), ["gauss-8"])):
        assert invoke("drift", path, *more, "--quiet", "--out", out).exit_code == 0
        record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
        assert (set(record["kinds"]), len(record["methods"])) == ({"energy"}, len(methods))


CHECKS = {
    "ball-3d --methods cf-4,rattle-4": ["not possible: no representation"],
    "hamiltonized-n3 --methods gauss-8,cf-4": ["t = 8818", "estimated by the rate at the start"],
    "ball-3d --for-drift --observe energy,K": [" classical: k (3)"],
    "ball-3d --for-drift --representation own": [" classical-attitude: k (3)"],
    "ball-3d --for-drift --representation ball-attitude": ["ball-attitude: k (3)"],
    "projected.toml": ["note: gamma has length 3"],
}


def test_checks_say_what_is_special(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = gi.load_scene("sphere-n3").changed(initial={"gamma": [1.0, 2.0, 2.0], "p": [2, -1, 0]})
    (tmp_path / "projected.toml").write_text(scene.toml(), encoding="utf-8")
    for line, words in CHECKS.items():
        told = invoke("check", *line.split())
        said = " ".join(told.output.split())
        assert (told.exit_code, [word for word in words if word not in said]) == (0, []), line


BAD_LINES = {
    "check hamiltonized-n3 --methods cf-4,euler-wrong": "'euler-wrong'",
    "chek ball-3d": "Did you mean 'check'?",
    "check ball-3d --step abc": "'abc'",
    "check ball-3d --step -1": "step = -1.0",
    "check ball-3d --method cf4": "'cf-4'",
    "check ball-3d --t-end 1 --tau-end 2": "one of them",
    "check sphere-n3 --methods rk-4 --method rk-4": "write NAME:STEP",
    "drift sphere-n3 --observe spatial-momentum --representation reduced": "nothing to show",
    "compare sphere-n3 --t-end 1 --tau-end 1": "expected one of them",
    "compare sphere-n3 --tau-end 1": "expected t_end",
    "compare sphere-n3 --methods ,": "names with commas",
    "compare sphere-n3 --steps 0.1,a": "--steps = '0.1,a'",
    "compare sphere-n3 --steps -0.1": "--steps",
    "compare sphere-n3 --methods dop853-adaptive --steps 0.1": "choose their steps",
    "compare neumann-n3 --reference exact --t-end 1": "no exact flow",
    "exact hamiltonized-n3 --frames 5": "--frames",
    "exact ball-3d --paper": "--out",
    "audit --brief --quiet": "--brief",
    "stress --systems neumann --axis nothing": "no such axis",
    "stress --systems ellipsoid-n3 --axis step": "no case has these",
    "stress --methods rattle-2 --systems ball-full-n4": "fits any of these cases",
    "stress --seconds 0": "--seconds",
    "inertia --a 1,2 --moments 1,2,3": "exactly one",
    "inertia --a 1,2 --d 1 --m 1": "--m and --rho alone",
    "check ball-3d --tau-end 2": "--tau-end = 2.0",
    "check ball-3d --method rattle-4": "no form 'hamiltonian'",
    "check nothing.toml": "does not exist",
    "check ball-3d --representation bal": "Did you mean 'ball'?",
    "check ball-3d --observe enrgy": "Did you mean 'energy'?",
    "check ball-3d --observe=": "--observe = '': expected names",
    "drift ball-3d --methods cf-4,cf4": "Did you mean 'cf-4'?",
    "drift ball-3d --methods cf-4:fast": "the step of 'cf-4' = 'fast'",
    "drift ball-3d --methods cf-4 --step 1": "write NAME:STEP",
    "stress --systems , --axis no-such": "--systems = ',': expected names",
    "compare sphere-n3 --methods rk-4,zzz": "`geomint methods` lists them",
}


@pytest.mark.parametrize("line", BAD_LINES)
def test_bad_command_lines(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = invoke(*line.split())
    assert (result.exit_code, BAD_LINES[line] in result.stderr) == (2, True), result.stderr
    assert all(len(text) < 400 for text in result.stderr.splitlines())
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_debug_shows_the_traceback_once(tmp_path, monkeypatch):
    """Of an error before the run as of one that ends it."""
    assert "Traceback" in invoke("--debug", "check", "bal-3d").stderr
    scene = by_fixed_point(tmp_path)
    for step in (40, -1):
        call = ["drift", scene, "--debug", "--quiet", "--step", step, "--out", tmp_path]
        monkeypatch.setattr("sys.argv", ["geomint", *map(str, call)])
        result = invoke(*call)
        assert result.exit_code == 2
        assert result.stderr.count("Traceback") == 1
        assert result.stderr.count("\ngeomint: ") == 1


@pytest.mark.parametrize("command", ["run", "drift"])
def test_a_failed_run_says_why_and_leaves_what_it_did(command, tmp_path):
    """In every file, and before it says what is written."""
    out = tmp_path / ("out.nc" if command == "run" else "report")
    result = invoke(command, by_fixed_point(tmp_path), "--step", 40, "--out", out)
    assert result.exit_code == 2
    for word in ("did not converge", "t = 0", "step 0", "residual", "iterations", "h = 40"):
        assert word in result.stderr
    said = result.output  # both streams, in order
    failed = said.index("geomint: gauss-8: failed: the implicit step did not")
    assert failed < said.index("(failed): ")
    if command == "run":
        assert gi.load(out).provenance["status"] == "failed"
        return
    page = (out / "report.html").read_text(encoding="utf-8")
    assert page.index("gauss-8: failed.") < page.index("did not converge")
    record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
    assert record["status"] == record["methods"]["gauss-8"]["run"]["status"] == "failed"


PICTURES = ("MPLBACKEND=nope", "drift sphere-n3 --t-end 1", "geomint: pictures: ValueError")


@pytest.mark.parametrize(
    ("setting", "words", "told"),
    [
        ("NUMBA_NUM_THREADS=0", "run sphere-n3 --t-end 1", "settings around geomint: ValueError"),
        ("_GEOMINT_COMPLETE=bash_complete", "", "settings around geomint: KeyError: 'COMP_WORDS'"),
        pytest.param(*PICTURES, marks=pytest.mark.nightly),
    ],
)
def test_settings_that_are_broken_are_one_line(setting, words, told, tmp_path):
    """Those of pictures are told before anything is computed."""
    done = alone(tmp_path, *words.split(), **dict([setting.split("=")]))
    assert (done.returncode, told in done.stderr) == (2, True), done.stderr
    said = [line for line in done.stderr.splitlines() if not line.endswith("…")]  # of what lasts
    assert (done.stdout, len(said)) == ("", 1)


@pytest.mark.filterwarnings("error")
def test_warnings_of_a_run_are_lines_whatever_python_makes_of_warnings(tmp_path):
    line = ("run", "sphere-n3", "--method", "rk-4", "--step", 6, "--t-end", 5)
    done = invoke(*line, "--out", tmp_path / "run.nc")
    assert done.exit_code == 0, done.output
    assert done.stderr.startswith("geomint: warning: step = 6 is longer than the run")


@pytest.mark.nightly
def test_a_report_without_docstrings_tells_the_rule(tmp_path):
    """Python leaves them out under -OO."""
    line = ("drift", "sphere-n3", "--t-end", "5", "--quiet")
    done = alone(tmp_path, *line, call=("-OO", "-m", "geomint"))
    assert done.returncode == 0, done.stderr
    assert "The window means" in (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
