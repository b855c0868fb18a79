"""The commands: what they print, write and return."""

import json
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import click
import numpy as np
import pytest
from click.testing import CliRunner
from pydantic import BaseModel, ConfigDict, field_validator

import geomint as gi
from chaplygin import scenes
from geomint.cli import group as group_module, main
from geomint.methods import methods
from geomint.watch.registry import plugged

# What is in pictures: tests/report.
pytestmark = pytest.mark.usefixtures("blank_pictures")

REPORT = {"report.html", "drift.json", "drift.png", "drift.svg"}


def invoke(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments], env={"COLUMNS": "120"})


def by_fixed_point(folder):
    """Write the scene sphere-n3 without Newton's method, so that long steps fail; return the file."""
    text = (Path(scenes.__file__).parent / "sphere-n3.toml").read_text(encoding="utf-8")
    file = folder / "sphere-n3.toml"
    file.write_text(text.replace("[integrate]", '[integrate]\niteration = "fixed-point"'), "utf-8")
    return file


def test_help_names_all_commands():
    result = invoke("--help")
    assert result.exit_code == 0
    for name in ("scenes", "methods", "check", "run", "drift", "compare"):
        assert f"  {name} " in result.stdout


def test_scenes():
    result = invoke("scenes")
    assert result.exit_code == 0
    for name in gi.scene_names():
        assert name in result.stdout


def test_methods():
    result = invoke("methods")
    assert result.exit_code == 0
    for name in gi.method_names():
        assert name in result.stdout
    heads = [line for line in result.stdout.splitlines() if "(needs " in line]
    assert {line.partition(" (")[0] for line in heads} == {m.family for m in methods().values()}
    assert "Crouch–Grossman (needs action): keeps group orbits and steady motions" in heads
    only = invoke("methods", "--form", "hamiltonian").stdout
    assert "rattle-4" in only
    assert "gauss-8" not in only
    assert invoke("methods", "--form", "acton").exit_code == 2


@pytest.mark.parametrize("name", gi.scene_names())
def test_check_says_what_and_why(name):
    result = invoke("check", name)
    assert result.exit_code == 0
    for word in ("representation", "method", "step", "steps", "watched", "why"):
        assert word in result.stdout


def shortened(name):
    """Return the options that make a built-in scene short."""
    scene = gi.load_scene(name)
    key = "tau_end" if scene.problem.time == "tau" else "t_end"
    return [f"--{key.replace('_', '-')}", "5"]


# One scene of each family of kernels; all others are among the slow tests.
SOON = {"ball-3d", "hamiltonized-n3", "sphere-n3", "rolling-ball-n3", "ellipsoid-n4", "clebsch-n4"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name not in SOON))
        for name in gi.scene_names()
    ],
)
def test_built_in_scenes_run_shortened(name, tmp_path):
    out = tmp_path / "run.nc"
    result = invoke("run", name, *shortened(name), "--out", out)
    assert result.exit_code == 0, result.output
    saved = gi.load(out)
    assert saved.provenance["status"] == "success"
    assert saved.tau[-1] == 5.0
    assert set(saved.drift) == set(gi.load_scene(name).content.observe.quantities)


@pytest.mark.parametrize("name", ["ball-3d", "hamiltonized-n3"])
def test_drift_shortened(name, tmp_path):
    out = tmp_path / "a" / "report"
    result = invoke("drift", name, *shortened(name), "--out", out)
    assert result.exit_code == 0, result.output
    assert {path.name for path in out.iterdir()} == REPORT
    assert str(out / "report.html") in result.stdout.replace("\n", "")


def test_drift_of_several_methods(tmp_path):
    result = invoke(
        *("drift", "sphere-n3", "--t-end", 5, "--methods", "gauss-8, rk-4:0.05,cf-4,lobatto-3:40"),
        *("--out", tmp_path),
    )
    assert result.exit_code == 0, result.output
    assert {path.name for path in tmp_path.iterdir()} == REPORT
    assert "lobatto-3: failed: the implicit step did not converge" in result.stderr
    for word in ("a second", "energy", "rk-4", "no larger than 32 ε × scale: gauss-8"):
        assert word in result.stdout
    record = json.loads((tmp_path / "drift.json").read_text(encoding="utf-8"))
    assert list(record["methods"]) == ["gauss-8", "rk-4", "cf-4", "lobatto-3"]
    assert record["provenance"]["command"].startswith("geomint")


def test_if_every_method_fails_so_does_the_command(tmp_path):
    arguments = ("drift", "ball-3d", "--t-end", 1, "--methods", "rattle-2,rattle-4")
    assert invoke(*arguments, "--quiet", "--out", tmp_path).exit_code == 2


def test_methods_of_the_scene_and_of_the_command_line(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(
        drift={"methods": ["gauss-8", "gauss-4:0.2"], "quantities": ["energy"], "t_end": 2.0}
    )
    path, out = tmp_path / "scene.toml", tmp_path / "report"
    path.write_text(scene.toml(), encoding="utf-8")
    told = invoke("check", path, "--for-drift").stdout
    assert "0.2 in t" in told
    assert told.count("representation") == 2
    assert invoke("check", path).stdout.count("representation") == 1
    assert invoke("drift", path, "--quiet", "--out", out).exit_code == 0
    record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
    assert set(record["kinds"]) == {"energy"}
    assert invoke("drift", path, "--method", "gauss-8", "--quiet", "--out", out).exit_code == 0
    record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
    assert list(record["methods"]) == ["gauss-8"]


def test_check_of_several_methods():
    told = invoke("check", "hamiltonized-n3", "--methods", "gauss-8,cf-4,euler-wrong")
    assert told.exit_code == 2
    told = invoke("check", "ball-3d", "--methods", "cf-4,rattle-4").stdout
    assert "not possible: no representation" in told
    told = invoke("check", "hamiltonized-n3", "--methods", "gauss-8,cf-4").stdout
    assert "about t = 8818" in told
    assert "estimated by the rate at the start" in " ".join(told.split())


def test_a_representation_can_be_forced_and_quantities_changed():
    arguments = ("check", "ball-3d", "--for-drift", "--observe", "energy, K")
    assert "classical: k (3)" in invoke(*arguments).stdout
    assert "classical-attitude: k (3)" in invoke(*arguments, "--representation", "own").stdout
    assert "ball-attitude: k (3)" in invoke(*arguments, "--representation", "ball-attitude").stdout


def test_options_change_the_scene(tmp_path):
    result = invoke(
        *("drift", "sphere-n3", "--method", "rk-4", "--step", 0.01, "--t-end", 2, "--quiet"),
        *("--out", tmp_path),
    )
    assert result.exit_code == 0
    assert result.stdout == ""
    record = json.loads((tmp_path / "drift.json").read_text())
    run = record["methods"]["rk-4"]["run"]
    assert (run["method"], run["step"], run["steps"]) == ("rk-4", 0.01, 200)
    assert record["provenance"]["scene"]["time"] == {"t_end": 2}


def test_projections_are_said(tmp_path):
    scene = gi.load_scene("sphere-n3").changed(initial={"gamma": [1.0, 2.0, 2.0], "p": [2, -1, 0]})
    path = tmp_path / "scene.toml"
    path.write_text(scene.toml(), encoding="utf-8")
    result = invoke("check", path)
    assert result.exit_code == 0
    assert "note: gamma has length 3" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["chek", "ball-3d"], "Did you mean 'check'?"),
        (["check", "ball-3d", "--step", "abc"], "'abc'"),
        (["check", "ball-3d", "--step", "-1"], "step = -1.0"),
        (["check", "ball-3d", "--method", "cf4"], "'cf-4'"),
        (["check", "ball-3d", "--t-end", "1", "--tau-end", "2"], "one of them"),
        (["check", "ball-3d", "--tau-end", "2"], "--tau-end = 2.0"),
        (["check", "ball-3d", "--method", "rattle-4"], "no form 'hamiltonian'"),
        (["check", "nothing.toml"], "does not exist"),
        (["check", "ball-3d", "--representation", "bal"], "Did you mean 'ball'?"),
        (["check", "ball-3d", "--observe", "enrgy"], "Did you mean 'energy'?"),
        (["drift", "ball-3d", "--methods", "cf-4,cf4"], "Did you mean 'cf-4'?"),
        (["drift", "ball-3d", "--methods", "cf-4:fast"], "the step of 'cf-4' = 'fast'"),
        (["drift", "ball-3d", "--methods", ","], "at least one method"),
        (["drift", "ball-3d", "--methods", "cf-4", "--step", "1"], "write NAME:STEP"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_bad_command_lines(arguments, word):
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr
    assert word in result.stderr


def test_out_must_be_a_folder(tmp_path):
    path = tmp_path / "file"
    path.touch()
    assert invoke("drift", "sphere-n3", "--out", path).exit_code == 2
    inside = invoke("drift", "sphere-n3", "--t-end", 1, "--out", path / "report")
    assert inside.exit_code == 2
    assert "Traceback" not in inside.stderr


def test_debug_shows_the_traceback():
    assert "Traceback" in invoke("--debug", "check", "bal-3d").stderr
    assert "Traceback" in invoke("check", "bal-3d", "--debug").stderr


@pytest.mark.parametrize("command", ["run", "drift"])
def test_a_failed_run_says_why_and_leaves_what_it_did(command, tmp_path):
    out = tmp_path / ("out.nc" if command == "run" else "report")
    result = invoke(command, by_fixed_point(tmp_path), "--step", 40, "--out", out)
    assert result.exit_code == 2
    assert "Traceback" not in result.stderr
    for word in ("did not converge", "t = 0", "step 0", "residual", "iterations", "h = 40"):
        assert word in result.stderr
    if command == "run":
        assert gi.load(out).provenance["status"] == "failed"
    else:
        assert {path.name for path in out.iterdir()} == REPORT
        page = (out / "report.html").read_text(encoding="utf-8")
        assert "gauss-8: failed." in page
        assert "did not converge" in page
        record = json.loads((out / "drift.json").read_text(encoding="utf-8"))
        assert record["status"] == record["methods"]["gauss-8"]["run"]["status"] == "failed"


def test_commands_of_other_packages(monkeypatch):
    @click.command("hello")
    def hello():
        click.echo("hello")

    class Point(EntryPoint):
        def load(self):
            return hello

    points = [Point("hello", "other.package:hello", "geomint.commands")]
    monkeypatch.setattr(group_module, "entry_points", lambda group: points)
    assert "hello" in invoke("--help").stdout
    assert invoke("hello").stdout == "hello\n"


@pytest.mark.filterwarnings("default::geomint.LeftOutWarning")
@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("absent_module:x", "ModuleNotFoundError"),
        ("of_bad_syntax:x", "SyntaxError"),
        ("that_exits:x", "SystemExit"),
        ("that_fails:x", "KeyError"),
        ("that_is_skipped:x", "Skipped"),
        ("without_words:x", "Dumb: ?"),
        ("of_two_lines:x", "ValueError: one two"),
        ("json:loads", "is not a"),
        ("no value", "no value"),
    ],
)
def test_a_package_that_is_broken_loses_its_own_names(value, words, tmp_path, monkeypatch):
    """One line and exit code 2 for who names what it registers; the rest is as it was."""
    sources = {
        "of_bad_syntax": "x =", "that_exits": "exit()", "that_fails": "{}[0]",
        "that_is_skipped": "class Skipped(BaseException): pass\nraise Skipped",
        "without_words": "class Dumb(Exception):\n    __str__ = None\nraise Dumb",
        "of_two_lines": r"raise ValueError('one\ntwo')",
    }  # fmt: skip
    for name, text in sources.items():
        (tmp_path / f"{name}.py").write_text(f'"""Of a package."""\n{text}\n', encoding="utf-8")
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n", "utf-8")
    groups = ("systems", "scenes", "methods", "commands", "watchers", "stress")
    entries = "".join(f"[geomint.{group}]\nbad = {value}\n" for group in groups)
    (info / "entry_points.txt").write_text(f"{entries}[geomint.methods]\nrk-4 = {value}\n", "utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    scene = tmp_path / "scene.toml"
    scene.write_text('[system]\nname = "bad"\n[time]\nt_end = 1.0\n', encoding="utf-8")
    caches = methods, plugged
    for cached in caches:
        cached.cache_clear()
    try:
        told = {
            c: invoke(*c.split())
            for c in ("--help", "methods", "scenes", "check sphere-n3", "bad", f"check {scene}",
                      "check sphere-n3 --observe energy,bad", "check sphere-n3 --method bad",
                      "stress --axis momentum --systems no-such")
        }  # fmt: skip
        assert methods()["rk-4"].order == 4
    finally:
        for cached in caches:
            cached.cache_clear()
    assert all(isinstance(t.exception, SystemExit | None) for t in told.values()), told
    for command in ("--help", "methods", "scenes", "check sphere-n3"):
        assert told[command].exit_code == 0
    assert "sphere-n3" in told["scenes"].stdout
    assert "'bad' of the group geomint.scenes is left out" in told["scenes"].stderr or "j" in value
    assert "'bad' of the group geomint.methods is left out" in told["methods"].stderr
    for command in ("bad", f"check {scene}", "check sphere-n3 --observe energy,bad"):
        said = [line for line in told[command].stderr.splitlines() if "warning" not in line]
        assert (told[command].exit_code, len(said)) == (2, 1), told[command].stderr
        assert words in said[0] or "expected a geomint.Watcher" in said[0]
    assert told["check sphere-n3 --method bad"].exit_code == 2


def test_a_system_of_another_package(monkeypatch, tmp_path):
    from geomint.problems import systems

    class Strict(BaseModel):
        model_config = ConfigDict(extra="forbid")

    class Frequency(Strict):
        omega: float

    class Position(Strict):
        q: float

    @gi.field
    def oscillator(params, t, y, out, work):
        out[0] = y[1]
        out[1] = -params[0] * params[0] * y[0]

    @gi.field
    def energy(params, t, y, work):
        return 0.5 * (y[1] * y[1] + params[0] * params[0] * y[0] * y[0])

    def build(parameters, initial):
        problem = gi.Problem(
            name="oscillator",
            pieces=(("q", 1), ("v", 1)),
            params=[parameters.omega],
            field=oscillator,
            invariants={"energy": energy},
        )
        return gi.Model({"own": problem}, {"own": problem.state(q=initial.q, v=0.0)})

    system = gi.System("oscillator", "a harmonic oscillator", Frequency, Position, build)

    class Point(EntryPoint):
        def load(self):
            return system

    points = [Point("oscillator", "other.package:OSCILLATOR", "geomint.systems")]
    monkeypatch.setattr(systems, "entry_points", lambda group: points)
    path = tmp_path / "scene.toml"
    path.write_text(
        '[system]\nname = "oscillator"\nomega = 2.0\n[initial]\nq = 1.0\n[time]\nt_end = 10.0\n'
    )
    result = invoke("drift", path, "--out", tmp_path / "report")
    assert result.exit_code == 0, result.output
    assert "energy" in result.stdout


def test_a_scene_without_a_field_takes_the_method_that_fits(tmp_path, monkeypatch):
    from geomint.problems import systems

    class Nothing(BaseModel):
        model_config = ConfigDict(extra="forbid")

    def build(parameters, initial):
        return gi.Model({"own": SPRING}, {"own": np.array([1.0, 0.0])})

    system = gi.System("spring", "a spring", Nothing, Nothing, build)

    class Point(EntryPoint):
        def load(self):
            return system

    points = [Point("spring", "other.package:SPRING", "geomint.systems")]
    monkeypatch.setattr(systems, "entry_points", lambda group: points)
    path = tmp_path / "spring.toml"
    path.write_text('[system]\nname = "spring"\n[time]\nt_end = 3.0\n[observe]\nquantities = []\n')
    result = invoke("run", path, "--out", tmp_path / "run.nc")
    assert result.exit_code == 0, result.output
    assert gi.load(tmp_path / "run.nc").method.name == "verlet-8"
    assert "verlet-8" in invoke("check", path).stdout


class Skipped(BaseException):
    """As modules of tests raise it, where they are not to be run."""


class Empty(BaseModel):
    pass


class Dumb(Exception):  # noqa: N818
    __str__ = None


class Checking(BaseModel):
    x: float

    @field_validator("x")
    @classmethod
    def checked(cls, x):
        raise KeyError("from a check")


def failing(error):
    def build(parameters, initial):
        raise error

    return build


def of_itself(parameters, initial):
    return of_itself(parameters, initial)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (failing(TypeError("one\ntwo")), "TypeError: one two"),
        (failing(KeyError("key")), "KeyError: 'key'"),
        (failing(SystemExit(3)), "SystemExit: 3"),
        (failing(Skipped("later")), "Skipped: later"),
        (failing(Dumb()), "Dumb: ?"),
        (of_itself, "RecursionError"),
        (lambda: None, "takes 0 positional arguments"),
        (lambda parameters, initial: None, "None, which is no Model"),
        (lambda parameters, initial: gi.Model({}, {}), "problems = {}: expected"),
        (lambda parameters, initial: gi.Model({"own": 3}, {"own": 0.0}), "problems = {'own': 3}"),
        (lambda parameters, initial: gi.Model(dict.fromkeys("a", SPRING), {}), "for each of ['a']"),
        (Checking, "[system]: its checks failed, KeyError: 'from a check'"),
    ],
)
def test_a_system_that_is_broken_is_told_in_one_line(build, words, tmp_path, monkeypatch):
    from geomint.problems import systems

    keys = Checking if build is Checking else Empty
    system = gi.System("broken", "a broken one", keys, Empty, build)
    point = SimpleNamespace(name="broken", value="other:BROKEN", load=lambda: system)
    monkeypatch.setattr(systems, "entry_points", lambda group: [point])
    path = tmp_path / "broken.toml"
    path.write_text('[system]\nname = "broken"\nx = 1.0\n[time]\nt_end = 3.0\n', "utf-8")
    for command in ("check", "run", "scan"):
        told = invoke(command, path)
        assert told.exit_code == 2, (command, told.exception)
        assert words in told.stderr.strip().rpartition("\n")[2]
        assert len(told.stderr.splitlines()) == 1


@pytest.mark.parametrize("given", [(int, Empty, dict), (Empty, {}, dict), (Empty, Empty, 3)])
def test_a_system_is_made_of_models_and_a_function(given):
    with pytest.raises(gi.DomainError, match=r"BaseModel|a function"):
        gi.System("none", "no system", *given)


def pull(params, t, q, out, work):
    out[0] = -1.0 * q[0]


SPRING = gi.Problem("spring", (("q", 1), ("v", 1)), splitting=gi.natural_in_space(gi.helper(pull)))


def test_outputs_have_default_places(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert invoke("drift", "sphere-n3", "--t-end", 5).exit_code == 0
    assert invoke("run", "sphere-n3", "--t-end", 5).exit_code == 0
    assert (tmp_path / "report" / "report.html").exists()
    assert (tmp_path / "sphere-n3.nc").exists()
