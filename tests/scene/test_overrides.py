"""What is changed in a scene before it is checked, and that its model is built once."""

import dataclasses
from importlib.metadata import entry_points

import pytest
from click.testing import CliRunner

import geomint as gi
from geomint.cli import main
from geomint.scene.load import load_changed
from tests.cli.calls import offer
from tests.problems import spherical_pendulum

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
def built(monkeypatch):
    """Return a list that gets an entry for every model of the system `counted` that is built."""
    found = []
    (point,) = entry_points(group="geomint.systems", name="chaplygin-sphere-hamiltonized")
    system = point.load()

    def build(*given):
        found.append(given)
        return system.build(*given)

    counting = dataclasses.replace(system, name="counted", build=build)
    offer(monkeypatch, "geomint.systems", "counted", counting)
    return found


@pytest.fixture
def path(tmp_path):
    (tmp_path / "s.toml").write_text(SCENE, encoding="utf-8")
    return tmp_path / "s.toml"


def invoke(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments], env={"COLUMNS": "300"})


def test_a_drift_report_takes_the_method_that_is_chosen():
    line = ["--for-drift", "--method", "auto", "--tolerance", "1e-8", "--tau-end", "2"]
    result = invoke("check", "hamiltonized-n3", *line)
    assert (result.exit_code, "gauss-" in result.output) == (0, True), result.output


def test_what_is_given_leaves_nothing_of_the_section(path):
    """A recorded scene that is run again gives what was run."""
    for given in ({"method": "rk-4"}, {"step": 0.25}, {"tau_end": 2.0}, {"every": 3}):
        scene = load_changed(path, "drift", **given)
        again = load_changed(scene.sections, "drift")
        assert again.content == scene.content
    with pytest.raises(gi.SceneError, match="every = 0") as caught:
        load_changed(path, "drift", every=0)
    assert "[drift]" not in str(caught.value)


@pytest.mark.usefixtures("blank_pictures")
@pytest.mark.parametrize(
    "line",
    [
        "check {} --for-drift --method rk-4 --step 0.5 --t-end 2",
        "run {} --method rk-4 --step 0.5 --tau-end 2 --observe K",
        "drift {} --method rk-4 --step 0.5 --tau-end 2",
        "drift {} --methods rk-4:0.5,gauss-4:0.5,gauss-4 --tau-end 2",
    ],
)
def test_a_scene_with_overrides_is_built_once(line, built, path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path.write_text(SCENE.replace("chaplygin-sphere-hamiltonized", "counted"), encoding="utf-8")
    result = invoke(*line.format(path).split())
    assert result.exit_code == 0, result.output
    assert len(built) == 1


def test_another_system_or_state_is_built(built, path):
    path.write_text(SCENE.replace("chaplygin-sphere-hamiltonized", "counted"), encoding="utf-8")
    scene = gi.load_scene(path)
    for section in ({"initial": {"p": [0.8, 1.0, -0.5]}}, {"system": {"D": 4.5}}):
        assert scene.changed(**section).model is not scene.model
    assert len(built) == 3
    assert scene.changed(time={"tau_end": 2.0}).model is scene.model


def test_the_command_line_comes_after_the_section_for_drift(path):
    drift = gi.load_scene(path).for_drift()
    integrate = {"method": "gauss-8", "representation": "own"}
    assert drift.content.integrate.model_dump(exclude_none=True) == integrate
    assert drift.content.observe.model_dump() == {"quantities": ["K"], "every": 2}
    assert drift.content.time.model_dump(exclude_none=True) == {"t_end": 5.0}
    changed = load_changed(str(path), "drift", step=0.5, tau_end=3.0)
    assert changed.sections["time"] == {"tau_end": 3.0}
    assert changed.sections["integrate"]["step"] == 0.5
    tolerant = load_changed(str(path), "drift", tolerance=1e-6).sections["integrate"]
    assert ("step" in tolerant, tolerant["tolerance"]) == (False, 1e-6)


def test_overrides_leave_what_makes_no_sense_to_the_check(path):
    """It is told where it was written, and a longer key is another one."""
    for old, new, told in (
        ('method = "gauss-8"', "strep = 1.0", "[drift] strep = 1.0"),
        ('integrate = {method = "rattle-4"', 'integrate = {stepsize = 3, method = "rattle-4"',
         "[integrate] stepsize = 3"),
        ("time = {tau_end = 9.0}", "time = []", "[time] = []"),
    ):  # fmt: skip
        path.write_text(SCENE.replace(old, new), encoding="utf-8")
        for options in ((), ("--step", "-1", "--observe", "KK")):
            said = invoke("check", path, *options)
            assert said.exit_code == 2
            assert told in said.stderr
            assert ("--step = -1.0" in said.stderr) == ("--step" in options), said.stderr


def test_a_method_that_is_named_is_taken_even_if_it_is_the_default():
    """A problem without a field has another one where none is named."""
    problem = dataclasses.replace(spherical_pendulum.problem(), field=None)
    for method, taken in ((None, "lobatto-8"), ("gauss-8", "gauss-8")):
        given = problem, problem.random_state(0)
        assert load_changed(given, method=method, t_end=1.0).method.name == taken


def test_a_scene_that_is_not_changed_keeps_its_text(path):
    scene = gi.load_scene(path)
    assert load_changed(str(path), "run", step=None).toml() == SCENE
    assert load_changed(str(path), "run", step=0.5).toml() != SCENE
    assert load_changed(str(path), "drift") == scene.for_drift()
    assert load_changed(str(path), "drift").hash == scene.for_drift().hash
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
def test_a_plan_names_the_place_where_a_setting_was_written(options, told, untold, path):
    """The section for drifts, the command line, or where scenes have it."""
    path.write_text(SCENE + "step = 0.5\n", encoding="utf-8")
    result = invoke("check", path, *options.split())
    assert result.exit_code == 0, result.output
    assert [word for word in told if word not in result.stdout] == []
    assert [word for word in untold if word in result.stdout] == []


def test_places_follow_changes_of_a_scene(path):
    scene = gi.load_scene(path)
    drift = scene.for_drift()
    assert drift.place("observe", "every") == "[drift] every"
    assert scene.place("observe", "every") == "[observe] every"
    later = drift.changed(observe={"every": 3})
    assert later.place("observe", "every") == "[observe] every"
    assert later.place("observe", "quantities") == "[drift] quantities"
    other = drift.changed_observation(["energy"])
    assert other.place("observe", "quantities") == "[observe] quantities"


def test_a_flaw_is_told_where_it_was_written(path):
    assert "--observe[0] = 'KK'" in invoke("check", path, "--observe", "KK").stderr
    path.write_text(SCENE.replace('["K"]', '["KK"]'), encoding="utf-8")
    said = invoke("check", "--for-drift", path).stderr
    assert "[drift] quantities[0] = 'KK'" in said
    assert "[observe]" not in said
