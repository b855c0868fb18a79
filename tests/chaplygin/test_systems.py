"""What scenes name: parameters, initial states, models, and the built-in scenes."""

import tomllib
import warnings
from importlib.metadata import entry_points
from importlib.resources import files

import numpy as np
import pydantic
import pytest

import geomint as gi
from tests.chaplygin.support import flat_wedge, random_rotation, random_tangent

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
            assert gi.value(problem, "spatial-momentum", y) < 1e-15
    for physical in arrays:
        common = set(physical) & set(arrays[0])
        assert sum(np.size(physical[name]) for name in common) >= least  # they determine a state
        for name in common:
            np.testing.assert_allclose(physical[name], arrays[0][name], rtol=0, atol=4e-15)
    energies = [
        gi.value(problem, "energy", model.states[name]) for name, problem in model.problems.items()
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


A3 = {"a": [0.8, 1.1, 1.5], "D": 4.0}
G3 = {"gamma": [0.6, 0.0, 0.8]}
P3 = {"p": [0.8, 1.0, -0.6]}
ROLLING = {"moments": [0.4, 0.5, 0.7], "m": 2.0, "rho": 0.5}
PLACE = {"r": [1.0, 2.0]}


SPHERE, BALL = "chaplygin-sphere-", "chaplygin-ball"
VECTORS, HALF = {"k": [1.0, 2.0, 3.0]}, {"gamma": [0.5] * 4}
SIX = {"inertia": [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "m": 2.0, "rho": 1.0}
ANY, BODY = {"omega": [1.0, -1.0, 0.5, -0.5, 2.0, 0.3]}, {"moments": [2.0, 3.0, 5.0]}
CARRYING = "classical-attitude ball-attitude"
MODELS = [
    (SPHERE + "reduced", A3, G3 | P3, f"reduced hamiltonized classical ball {CARRYING}"),
    (SPHERE + "hamiltonized", A3, G3 | P3, f"hamiltonized reduced classical ball {CARRYING}"),
    (BALL, A3, G3 | P3, "ball classical reduced hamiltonized ball-attitude classical-attitude"),
    (BALL, A3, G3 | VECTORS, "ball classical ball-attitude classical-attitude"),
    (BALL, ROLLING, G3 | VECTORS, f"classical ball {CARRYING}"),
    (BALL, A3 | {"attitude": True}, G3 | P3,
     "ball-attitude classical-attitude ball classical reduced hamiltonized"),
    (BALL, SIX, HALF | {"p": [1.0, -1.0, 0.5, -0.5]}, "ball reduced ball-attitude"),
    (BALL, {"J": [1.0, 2.0, 3.0, 4.0], "D": 2.0}, HALF | ANY, "ball ball-attitude"),
    ("homogeneous-ball", {"n": 2, "s": 1.0, "D": 1.0}, {"gamma": [0.6, 0.8], "k": [1.0]},
     "ball reduced hamiltonized ball-attitude"),
    ("veselova", A3, G3 | P3, "reduced hamiltonized classical multiplier"),
    ("veselova", {"a": A3["a"]}, G3 | {"w": [0.6, 0.0, -0.8]},
     "reduced hamiltonized classical multiplier"),
    ("veselova", {"a": [1.0, 2.0, 3.0, 4.0]}, HALF | {"p": [1.0, -1.0, 2.0, -2.0]},
     "reduced hamiltonized"),
    ("veselova", BODY, G3 | {"w": [0.8, 1.0, -0.6]}, "classical reduced hamiltonized multiplier"),
    ("veselova", BODY | {"f1": 1.0}, G3 | {"k": [0.6, 2.0, 0.8]}, "classical multiplier"),
    ("ellipsoid", {"a": [1.0, 4.0]}, {"x": [0.6, 1.6], "p": [0.4, -0.6]}, "geodesics"),
    ("rolling-ball", ROLLING, G3 | PLACE | {"omega": [1.0, -2.0, 1.5]},
     f"rolling contact classical ball {CARRYING}"),
    ("rolling-ball", ROLLING | {"multipliers": False}, G3 | PLACE | P3,
     f"contact rolling classical ball reduced hamiltonized {CARRYING}"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "parameters", "initial", "expected"), MODELS)
def test_models(name, parameters, initial, expected):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert check(build(name, parameters, initial)) == expected.split()


def test_balls_on_the_plane():
    """With moments ω is a vector; r is kept, v is that of rolling or refused."""
    at = G3 | PLACE
    vectors = build("rolling-ball", ROLLING, at | {"omega": [1.0, -2.0, 1.5]})
    flat = {"inertia": [0.7, 0.5, 0.4], "m": 2.0, "rho": 0.5}
    triangles = build("rolling-ball", flat, at | {"omega": [-1.5, -2.0, -1.0]})
    assert set(triangles.problems) == set(vectors.problems)
    for name, y in vectors.states.items():
        np.testing.assert_allclose(y, triangles.states[name], rtol=0, atol=4e-14)
    for name in ("rolling", "contact"):
        r = vectors.problems[name].slices["r"]
        np.testing.assert_array_equal(vectors.states[name][r], [1.0, 2.0])
    parameters, omega = {"J": [1.0, 2.0, 3.0, 4.0], "D": 1.5}, [1.0, 0.0, -1.0, 0.5, 0.2, 0.3]
    turning = {"g": random_rotation(4).tolist(), "omega": omega}
    y = build("rolling-ball", parameters, turning)
    v = y.states["rolling"][y.problems["rolling"].slices["v"]].tolist()
    again = build("rolling-ball", parameters, turning | {"v": v})
    np.testing.assert_array_equal(again.states["rolling"], y.states["rolling"])
    with pytest.raises(gi.DomainError, match="slips at"):
        build("rolling-ball", parameters, turning | {"v": [0.0, 0.0, 0.0]})


def test_moments_make_vectors():
    """With moments, k is a vector; with the same operator as a diagonal, the flat triangle."""
    gamma, p = random_tangent(3)
    vector = {"gamma": gamma.tolist(), "k": np.cross(p, gamma).tolist()}
    flat = {"gamma": gamma.tolist(), "k": flat_wedge(gamma, p).tolist()}
    models = [
        build("chaplygin-ball", {"moments": [1.0, 2.0, 3.0], "D": 1.0}, vector),
        build("chaplygin-ball", {"moments": np.diag([1.0, 2.0, 3.0]).tolist(), "D": 1.0}, vector),
        build("chaplygin-ball", {"inertia": [3.0, 2.0, 1.0], "D": 1.0}, flat),
    ]
    energies = []
    for model in models:
        assert "reduced" in model.problems
        energies.append(gi.value(model.problems["ball"], "energy", model.states["ball"]))
    np.testing.assert_allclose(energies, energies[0], rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "parameters", "initial", "text"),
    [
        ("chaplygin-sphere-reduced", A3 | {"b": 1.0}, G3 | P3, "validation error"),
        ("chaplygin-sphere-hamiltonized", {"a": [1.0, 2.0]}, G3 | P3, "validation error"),
        ("chaplygin-sphere-reduced", {"a": ["1", "2"], "D": 3.0}, G3 | P3, "validation error"),
        ("chaplygin-sphere-reduced", {"a": [True, 2.0], "D": 3.0}, G3 | P3, "validation error"),
        (
            "chaplygin-sphere-reduced",
            {"a": [1.0, float("nan")], "D": 3.0},
            G3 | P3,
            "validation error",
        ),
        ("chaplygin-sphere-reduced", A3, P3, "validation error"),
        ("chaplygin-sphere-reduced", A3, G3 | P3 | {"x": [1.0]}, "validation error"),
        ("homogeneous-ball", {"n": 1, "s": 1.0, "D": 1.0}, G3 | P3, "validation error"),
        ("homogeneous-ball", {"n": 3.0, "s": 1.0, "D": 1.0}, G3 | P3, "validation error"),
        ("veselova", A3, G3 | {"omega": [1.0, 2.0, 3.0]}, "validation error"),
        ("veselova", {"a": A3["a"], "f1": "0"}, G3 | P3, "validation error"),
        ("ellipsoid", {"a": [1.0, 4.0]}, {"x": [0.6, 1.6]}, "validation error"),
        ("rolling-ball", ROLLING | {"attitude": True}, G3 | P3, "validation error"),
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
def test_bad_keys_types_and_values(name, parameters, initial, text):
    with pytest.raises((gi.DomainError, pydantic.ValidationError), match=text):
        build(name, parameters, initial)
