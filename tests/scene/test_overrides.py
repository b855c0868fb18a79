"""What is changed in a scene before it is checked, and that its model is built once."""

import dataclasses

import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.scene import scene, validate
from geomint.scene.flaws import Flaws
from geomint.scene.load import load_changed
from geomint.scene.raw import drift_changes, overridden

SCENE = """
system = {name = "chaplygin-sphere-hamiltonized", a = [0.8, 1.1, 1.5], D = 4.0}
initial = {gamma = [0.6, 0.0, 0.8], p = [0.8, 1.0, -0.6]}
time = {tau_end = 9.0}
integrate = {method = "rattle-4", iteration_tolerance = 1e-13, representation = "own"}
observe = {quantities = ["energy", "measure"], measure = {steps = 3}}
[drift]
method = "gauss-8"
quantities = ["K"]
every = 2
t_end = 5.0
"""


@pytest.fixture
def counted(monkeypatch):
    """Return a list that gets an entry for every model built, and one for every check."""
    found = {"built": 0, "checked": 0}
    system_of, check_content = validate.find_system, validate.check_content

    def find_system(name):
        system = system_of(name)

        def build(*given):
            found["built"] += 1
            return system.build(*given)

        return dataclasses.replace(system, build=build)

    def checked(*given):
        found["checked"] += 1
        return check_content(*given)

    monkeypatch.setattr(validate, "find_system", find_system)
    monkeypatch.setattr(scene, "check_content", checked)
    return found


COMMANDS = {
    "check": ("check", "--for-drift", "--method", "rk-4", "--step", "0.5", "--t-end", "2"),
    "run": ("run", "--method", "gauss-4", "--step", "0.5", "--tau-end", "2", "--observe", "K"),
    "drift": ("drift", "--method", "gauss-4", "--step", "0.5", "--tau-end", "2"),
    "several": ("drift", "--methods", "gauss-4:0.5,rattle-2:0.5,gauss-4", "--tau-end", "2"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_scene_with_overrides_is_checked_and_built_once(name, counted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.toml").write_text(SCENE, encoding="utf-8")
    command, *options = COMMANDS[name]
    result = CliRunner().invoke(main, [command, "s.toml", *options])
    assert result.exit_code == 0, result.output
    assert counted["built"] == 1
    assert name == "several" or counted["checked"] == 1


def test_another_system_or_state_is_built(counted):
    scene = gi.load_scene("sphere-n3")
    for section in ({"initial": {"p": [3.0, -4.0, 1.4]}}, {"system": {"D": 4.5}}):
        changed = scene.changed(**section)
        assert changed.model is not scene.model
    assert counted["built"] == 3
    assert scene.changed(time={"t_end": 2.0}).model is scene.model


def test_the_command_line_comes_after_the_section_for_drift(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(SCENE, encoding="utf-8")
    scene = gi.load_scene(path)
    drift = scene.for_drift()
    assert drift.content.integrate.model_dump() == {
        "method": "gauss-8",
        "step": None,
        "tolerance": None,
        "representation": "own",
        "exact": None,
    }
    assert drift.content.observe.model_dump() == {
        "quantities": ["K"],
        "every": 2,
    }
    assert drift.content.time.t_end == 5.0
    assert drift.content.time.tau_end is None
    raw = overridden(drift.sections, step=0.5, tau_end=3.0)
    assert raw["time"] == {"tau_end": 3.0}
    assert raw["integrate"]["step"] == 0.5


def test_overrides_leave_what_makes_no_sense_to_the_check():
    for raw in ({"drift": 3}, {"drift": {"step": "x"}}, {"drift": {"strep": 1.0}}):
        assert drift_changes(raw) == {}
    nonsense = {"integrate": 3, "time": [], "observe": 4}
    assert overridden(nonsense, method="rk-4", t_end=1.0, quantities=["K"]) == nonsense
    assert overridden(nonsense) == nonsense


def test_a_scene_that_is_not_changed_keeps_its_text(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(SCENE, encoding="utf-8")
    scene = gi.load_scene(path)
    assert load_changed(str(path), False, step=None).toml() == SCENE
    assert load_changed(str(path), False, step=0.5).toml() != SCENE
    assert load_changed(str(path), True).hash == scene.for_drift().hash
    assert scene.changed_integration(representation="own") is scene


IN_DRIFT = ("[drift] step", "[drift] quantities", "[drift] every")


@pytest.mark.parametrize(
    ("options", "told", "untold"),
    [
        ("", ("[observe], after every step", "[integrate] repr"), ("[drift]", "--")),
        ("--for-drift", (*IN_DRIFT, "[integrate] repr"), ("[observe]", "[integrate] step")),
        (
            "--step 0.5 --observe K --representation own --method gauss-4",
            ("--step", "--observe", "--representation"),
            ("[drift]", "[observe]", "[integrate]"),
        ),
        ("--methods gauss-8:0.4,gauss-4:0.3", ("methods", *IN_DRIFT[1:]), ("[drift] step",)),
    ],
)
def test_a_plan_names_the_place_where_a_setting_was_written(options, told, untold, tmp_path):
    """The section for drifts, the command line, or where scenes have it."""
    path = tmp_path / "s.toml"
    path.write_text(SCENE + "step = 0.5\n", encoding="utf-8")
    given = ["check", str(path), *options.split()]
    result = CliRunner().invoke(main, given, env={"COLUMNS": "300"})
    assert result.exit_code == 0, result.output
    for word in told:
        assert word in result.stdout
    for word in untold:
        assert word not in result.stdout


def test_places_follow_changes_of_a_scene(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(SCENE, encoding="utf-8")
    scene = gi.load_scene(path)
    drift = scene.for_drift()
    assert drift.place("observe", "every") == "[drift] every"
    assert scene.place("observe", "every") == "[observe] every"
    later = drift.changed(observe={"every": 3})
    assert later.place("observe", "every") == "[observe] every"
    assert later.place("observe", "quantities") == "[drift] quantities"
    other = drift.changed_observation(["energy"])
    assert other.place("observe", "quantities") == "[observe] quantities"
    assert load_changed(str(path), True) == drift


def test_a_flaw_is_told_where_it_was_written(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(SCENE.replace('["K"]', '["KK"]'), encoding="utf-8")
    result = CliRunner().invoke(main, ["check", "--for-drift", str(path)])
    assert "[drift] quantities[0] = 'KK'" in result.stderr
    assert "[observe]" not in result.stderr
    path.write_text(SCENE, encoding="utf-8")
    result = CliRunner().invoke(main, ["check", str(path), "--observe", "KK"])
    assert "--observe[0] = 'KK'" in result.stderr


def test_a_longer_key_is_another_one():
    flaws = Flaws({"[integrate] step": "--step"})
    flaws += ["[integrate] step = -1.0: too small", "[integrate] stepsize: unknown key"]
    told = str(flaws.error("s"))
    assert "--step = -1.0: too small" in told
    assert "[integrate] stepsize: unknown key" in told
