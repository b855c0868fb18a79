"""What scenes name: parameters, initial states, models, and the built-in scenes."""

import tomllib
import warnings
from importlib.metadata import entry_points
from importlib.resources import files

import numpy as np
import pydantic
import pytest

import geomint as gi
from chaplygin.manifold import wedge
from geomint.watch.quantities import kind_of
from tests.chaplygin.support import random_tangent, value_of

SYSTEMS = {
    point.name: point.load()
    for point in entry_points(group="geomint.systems")
    if point.value.startswith("chaplygin.")
}
SCENES = {
    path.name.removesuffix(".toml"): tomllib.loads(path.read_text(encoding="utf-8"))
    for path in files("chaplygin.scenes").iterdir()
    if path.name.endswith(".toml")
}


def test_systems_go_by_their_own_names():
    assert {name: system.name for name, system in SYSTEMS.items()} == {n: n for n in SYSTEMS}
    assert all(isinstance(system, gi.System) and system.summary for system in SYSTEMS.values())


def build(name, parameters, initial):
    system = SYSTEMS[name]
    return system.build(system.parameters(**parameters), system.initial(**initial))


def check(model):
    """All representations describe one state, and the states are theirs."""
    arrays = []
    least = min(p.space.dimension for p in model.problems.values() if p.space)
    for name, problem in model.problems.items():
        y = model.states[name]
        np.testing.assert_array_equal(problem.canonical(y), y)
        arrays.append(problem.physical_state(y))
        if "spatial-momentum" in problem.diagnostics:
            assert value_of(problem, "spatial-momentum", y) < 1e-15
    for physical in arrays:
        common = set(physical) & set(arrays[0])
        assert sum(np.size(physical[name]) for name in common) >= least  # they determine a state
        for name in common:
            np.testing.assert_allclose(physical[name], arrays[0][name], rtol=0, atol=4e-15)
    energies = [
        value_of(problem, "energy", model.states[name]) for name, problem in model.problems.items()
    ]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-13)
    return list(model.problems)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.filterwarnings("ignore::geomint.errors.GeomintWarning")
def test_scenes(scene):
    data = SCENES[scene]
    assert set(data) - {"drift"} == {
        "title", "description", "system", "initial", "time", "integrate", "observe"
    }  # fmt: skip
    assert data["title"]
    assert data["description"]
    parameters = dict(data["system"])
    model = build(parameters.pop("name"), parameters, data["initial"])
    first = check(model)[0]
    problem = model.problems[first]
    assert set(data["observe"]["quantities"]) <= set(problem.diagnostics)
    watched = data.get("drift", {}).get("quantities", [])
    assert set(watched) - {"measure"} <= set(problem.diagnostics)
    if "measure" in watched:
        assert problem.measure is not None
    ends = set(data["time"]) - {"clock"}
    assert ends == ({"tau_end"} if problem.time == "tau" else {"t_end"})


def test_six_scenes_show_the_four_kinds_of_drift():
    names = "ball-3d hamiltonized-n3 hamiltonized-n5 veselova-n3 veselova-n4 ellipsoid-n4"
    for name in names.split():
        scene = gi.load_scene(name)
        kinds = [kind_of(q, scene.problem) for q in scene.for_drift().content.observe.quantities]
        assert {"energy", "integrals", "constraints", "measure"} == set(kinds)


A3 = {"a": [0.8, 1.1, 1.5], "D": 4.0}
G3 = {"gamma": [0.6, 0.0, 0.8]}
P3 = {"p": [0.8, 1.0, -0.6]}
TANGENT = ["reduced", "hamiltonized"]


@pytest.mark.parametrize(
    ("name", "parameters", "initial", "expected"),
    [
        (
            "chaplygin-sphere-reduced", A3, G3 | P3,
            [*TANGENT, "classical", "ball", "classical-attitude", "ball-attitude"],
        ),
        (
            "chaplygin-sphere-hamiltonized", A3, G3 | P3,
            [*TANGENT[::-1], "classical", "ball", "classical-attitude", "ball-attitude"],
        ),
        (
            "chaplygin-ball", A3, G3 | P3,
            ["ball", "classical", *TANGENT, "ball-attitude", "classical-attitude"],
        ),
        (
            "chaplygin-ball", A3, G3 | {"k": [1.0, 2.0, 3.0]},
            ["ball", "classical", "ball-attitude", "classical-attitude"],
        ),
        (
            "chaplygin-ball", {"moments": [1.0, 2.0, 3.0], "D": 1.0}, G3 | {"k": [1.0, 2.0, 3.0]},
            ["classical", "ball", "classical-attitude", "ball-attitude"],
        ),
        (
            "chaplygin-ball", A3 | {"attitude": True}, G3 | P3,
            ["ball-attitude", "classical-attitude", "ball", "classical", *TANGENT],
        ),
        (
            "chaplygin-ball", {"inertia": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "m": 2.0, "rho": 1.0},
            {"gamma": [0.5, 0.5, 0.5, 0.5], "p": [1.0, -1.0, 0.5, -0.5]},
            ["ball", "reduced", "ball-attitude"],
        ),
        (
            "chaplygin-ball", {"J": [1.0, 2.0, 3.0, 4.0], "m": 2.0, "rho": 1.0},
            {"gamma": [0.5, 0.5, 0.5, 0.5], "omega": [1.0, -1.0, 0.5, -0.5, 2.0, 0.3]},
            ["ball", "ball-attitude"],
        ),
        (
            "homogeneous-ball", {"n": 2, "s": 1.0, "D": 1.0}, {"gamma": [0.6, 0.8], "k": [1.0]},
            ["ball", *TANGENT, "ball-attitude"],
        ),
        ("veselova", A3, G3 | P3, [*TANGENT, "classical", "multiplier"]),
        (
            "veselova",
            {"a": A3["a"]},
            G3 | {"w": [0.6, 0.0, -0.8]},
            [*TANGENT, "classical", "multiplier"],
        ),
        (
            "veselova", {"a": [1.0, 2.0, 3.0, 4.0]}, {"gamma": [0.5] * 4, "p": [1.0, -1.0, 2.0, -2.0]},
            TANGENT,
        ),
        (
            "veselova", {"moments": [2.0, 3.0, 5.0]}, G3 | {"w": [0.8, 1.0, -0.6]},
            ["classical", *TANGENT, "multiplier"],
        ),
        (
            "veselova", {"moments": [2.0, 3.0, 5.0], "f1": 1.0}, G3 | {"k": [0.6, 2.0, 0.8]},
            ["classical", "multiplier"],
        ),
        (
            "ellipsoid", {"a": [1.0, 4.0]}, {"x": [0.6, 1.6], "p": [0.4, -0.6]},
            ["geodesics"],
        ),
    ],
)  # fmt: skip
def test_models(name, parameters, initial, expected):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert check(build(name, parameters, initial)) == expected


def test_moments_make_vectors():
    """With moments, k is a vector; with the same operator as a diagonal, the flat triangle."""
    gamma, p = random_tangent(3)
    vector = {"gamma": gamma.tolist(), "k": np.cross(p, gamma).tolist()}
    flat = {"gamma": gamma.tolist(), "k": wedge(gamma, p).tolist()}
    models = [
        build("chaplygin-ball", {"moments": [1.0, 2.0, 3.0], "D": 1.0}, vector),
        build("chaplygin-ball", {"moments": np.diag([1.0, 2.0, 3.0]).tolist(), "D": 1.0}, vector),
        build("chaplygin-ball", {"inertia": [3.0, 2.0, 1.0], "D": 1.0}, flat),
    ]
    energies = []
    for model in models:
        assert "reduced" in model.problems
        energies.append(value_of(model.problems["ball"], "energy", model.states["ball"]))
    np.testing.assert_allclose(energies, energies[0], rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "parameters", "initial"),
    [
        ("chaplygin-sphere-reduced", A3 | {"b": 1.0}, G3 | P3),
        ("chaplygin-sphere-hamiltonized", {"a": [1.0, 2.0]}, G3 | P3),
        ("chaplygin-sphere-reduced", {"a": ["1", "2"], "D": 3.0}, G3 | P3),
        ("chaplygin-sphere-reduced", {"a": [True, 2.0], "D": 3.0}, G3 | P3),
        ("chaplygin-sphere-reduced", {"a": [1.0, float("nan")], "D": 3.0}, G3 | P3),
        ("chaplygin-sphere-reduced", A3, P3),
        ("chaplygin-sphere-reduced", A3, G3 | P3 | {"x": [1.0]}),
        ("homogeneous-ball", {"n": 1, "s": 1.0, "D": 1.0}, G3 | P3),
        ("homogeneous-ball", {"n": 3.0, "s": 1.0, "D": 1.0}, G3 | P3),
        ("veselova", A3, G3 | {"omega": [1.0, 2.0, 3.0]}),
        ("veselova", {"a": A3["a"], "f1": "0"}, G3 | P3),
        ("ellipsoid", {"a": [1.0, 4.0]}, {"x": [0.6, 1.6]}),
    ],
)
def test_bad_keys_and_types(name, parameters, initial):
    with pytest.raises(pydantic.ValidationError):
        build(name, parameters, initial)


@pytest.mark.parametrize(
    ("name", "parameters", "initial", "text"),
    [
        ("chaplygin-sphere-reduced", {"a": [1.0, 2.0], "D": 2.0}, G3 | P3, r"a\[0\]\*a\[1\] is 2"),
        ("chaplygin-sphere-reduced", A3, G3, "exactly one of"),
        ("chaplygin-sphere-reduced", A3, G3 | P3 | {"k": [1.0]}, "exactly one of"),
        ("chaplygin-sphere-reduced", A3, G3 | {"k": [1.0, 2.0, 3.0]}, "zero SO"),
        ("chaplygin-sphere-reduced", A3, {"gamma": [1.0, 0.0]} | P3, "3 numbers"),
        ("chaplygin-ball", {"D": 1.0}, G3 | P3, "exactly one of"),
        ("chaplygin-ball", A3 | {"J": [1.0, 2.0, 3.0]}, G3 | P3, "exactly one of"),
        ("chaplygin-ball", {"a": [1.0, 1.1, 1.2]}, G3 | P3, "D, or m and rho"),
        ("chaplygin-ball", A3 | {"m": 1.0}, G3 | P3, "D, or m and rho"),
        ("chaplygin-ball", {"J": [1.0, 2.0, 3.0], "m": 1.0}, G3 | P3, "D, or m and rho"),
        ("homogeneous-ball", {"n": 3, "s": -1.0, "D": 1.0}, G3 | P3, "s = -1.0"),
        ("veselova", {"D": 1.0}, G3 | P3, "either a or moments"),
        ("veselova", A3 | {"moments": [1.0, 2.0, 3.0]}, G3 | P3, "either a or moments"),
        ("veselova", A3 | {"f1": 0.5}, G3 | P3, "f1 = 0.5"),
        ("veselova", A3, G3 | {"w": [0.8, 0.0, 0.6]}, "velocity"),
        ("ellipsoid", {"a": [1.0, -4.0]}, {"x": [0.6, 1.6], "p": [0.0, 0.0]}, r"a\[1\] is not"),
    ],
)
def test_bad_values(name, parameters, initial, text):
    with pytest.raises(gi.DomainError, match=text):
        build(name, parameters, initial)
