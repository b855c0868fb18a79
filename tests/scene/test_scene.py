"""Scenes from names, files, mappings and Python; their changes and hashes."""

import tomllib

import numpy as np
import pytest

import geomint as gi
from geomint.scene.load import load_changed

SECTIONS = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
    "time": {"t_end": 2.0},
}


@pytest.mark.parametrize("name", gi.scene_names())
def test_built_in_scenes_round_trip_through_toml(name):
    scene = gi.load_scene(name)
    assert scene.content.title
    assert scene.content.description
    assert scene.state.shape == (scene.problem.rows,)
    again = gi.Scene.from_content(name, tomllib.loads(scene.toml()))
    assert again.hash == scene.hash
    without_text = gi.Scene.from_content(name, scene.sections)
    assert tomllib.loads(without_text.toml()) == tomllib.loads(scene.toml())


def test_a_file_is_found_with_and_without_ending(tmp_path, monkeypatch):
    (tmp_path / "mine.toml").write_text(gi.Scene(**SECTIONS).toml(), encoding="utf-8")
    (tmp_path / "mine").write_text(gi.Scene(**SECTIONS).toml(), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    scene = gi.load_scene("mine")
    assert gi.load_scene(scene) is scene
    for source in ("mine.toml", "mine", tmp_path / "mine.toml", str(tmp_path / "mine")):
        assert gi.load_scene(source).name == "mine"


def test_arrays_and_numpy_numbers_are_lists_and_numbers():
    system = {**SECTIONS["system"], "a": np.array([0.8, 1.1, 1.5]), "D": np.float64(4)}
    scene = gi.Scene(**{**SECTIONS, "system": system, "save": {"t_eval": np.linspace(0, 2, 3)}})
    assert scene.hash_of("system") == gi.Scene(**SECTIONS).hash_of("system")
    assert scene.content.save.t_eval == [0.0, 1.0, 2.0]


def test_the_hash_stands_for_what_is_computed():
    scene = gi.Scene(**SECTIONS)
    system = {"D": 4, "a": [0.8, 1.1, 1.5], "name": SECTIONS["system"]["name"]}
    other = {**SECTIONS, "system": system, "integrate": {"method": "gauss-8"}}
    assert gi.Scene(name="other", title="Other words", **other).hash == scene.hash
    for section, change in (
        ("system", {"D": 4.0000001}),
        ("initial", {"p": [0.8, 1.0000001, -0.6]}),
        ("time", {"t_end": 3.0}),
        ("integrate", {"step": 0.1}),
        ("integrate", {"iteration_tolerance": 1e-12}),
        ("observe", {"every": 2}),
        ("save", {"every": 2}),
    ):
        assert scene.changed(**{section: change}).hash != scene.hash


def test_the_hash_is_stable_between_versions():
    # A change of this value invalidates every stored reference: know that you do it.
    assert gi.Scene(**SECTIONS).hash_of("system", "initial", "time") == "6f2219da399280a8"


def test_system_defaults_count_in_the_hash():
    ball = {
        "system": {"name": "chaplygin-ball", "moments": [1.0, 2.0, 3.0], "D": 1.0},
        "initial": {"gamma": [0.6, 0.0, 0.8], "k": [1.0, 0.7, -0.4]},
        "time": {"t_end": 1.0},
    }
    stated = {**ball, "system": {**ball["system"], "attitude": False}}
    assert gi.Scene(**ball).hash == gi.Scene(**stated).hash


def test_changes_replace_the_end_and_leave_the_scene_alone():
    scene = gi.Scene(**SECTIONS)
    assert scene.changed(time={"t_end": 7.0}).content.time.t_end == 7.0
    assert scene.content.time.t_end == 2.0
    hamiltonized = gi.load_scene("hamiltonized-n3").changed(time={"t_end": 7.0})
    assert hamiltonized.content.time.tau_end is None


def test_another_method_takes_its_own_default_step_and_options():
    scene = gi.Scene(**SECTIONS, integrate={"step": 0.1, "iteration_tolerance": 1e-10})
    other = scene.changed_integration("rk-4").content.integrate
    assert (other.step, other.options) == (None, {})
    assert scene.changed_integration("gauss-8").content.integrate.step == 0.1
    assert scene.changed_integration("rk-4", 0.5).content.integrate.step == 0.5


def test_options_reach_the_method():
    scene = gi.Scene(**SECTIONS, integrate={"iteration_tolerance": 1e-10, "max_iterations": 7})
    options = scene.method.options
    assert (options["iteration_tolerance"], options["max_iterations"]) == (1e-10, 7)
    given = {"method": "gauss-1-suzuki-4", "iteration_tolerance": 1e-9}
    composed = gi.Scene(**SECTIONS, integrate=given).method
    assert (composed.name, composed.options["iteration_tolerance"]) == ("gauss-1-suzuki-4", 1e-9)


def test_sections_for_other_uses():
    scene = gi.Scene(
        **SECTIONS,
        drift={"t_end": 100.0, "method": "rk-4", "step": 0.2, "every": 5},
        compare={"t_end": 3.0, "methods": ["gauss-8", "rk-4"], "steps": [0.1]},
    )
    drift = scene.for_drift()
    assert drift.content.time.t_end == 100.0
    assert (drift.method.name, drift.content.integrate.step) == ("rk-4", 0.2)
    assert drift.content.observe.every == 5
    assert load_changed(scene, "compare").content.time.t_end == 3.0
    assert gi.Scene(**SECTIONS).for_drift().hash == gi.Scene(**SECTIONS).hash


def test_projections_are_said():
    with pytest.warns(gi.GeomintWarning, match="gamma has length"):
        scene = gi.Scene(**{**SECTIONS, "initial": {"gamma": [1, 2, 3], "p": [3.0, 0.0, -1.0]}})
    assert len(scene.notes) == 1
    assert np.linalg.norm(scene.state[:3]) == pytest.approx(1.0, abs=1e-15)


def test_every_representation_starts_from_the_same_state():
    scene = gi.Scene(**SECTIONS)
    for name, problem in scene.model.problems.items():
        gamma = problem.physical_state(scene.model.states[name])["gamma"]
        np.testing.assert_allclose(gamma, [0.6, 0.0, 0.8], atol=1e-15)
