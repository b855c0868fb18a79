"""Every key of ``[system]`` and ``[initial]`` of every system reaches every form that it concerns."""

from __future__ import annotations

import math
import tomllib
import warnings
from functools import cache
from typing import Any

import numpy as np
import pytest

import chaplygin
import geomint as gi
from chaplygin.ball.rolling_states import momentum_inverted
from geomint.problems.systems import find_system, system_names
from geomint.scene.load import builtin_scenes
from tests.asked.asked_support import seen

c, s = math.cos(0.7), math.sin(0.7)
ONE = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
TURN = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
TENSOR = [[1.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 2.0]]
GAMMA = [0.48, 0.6, 0.64]

OMEGA = momentum_inverted(
    chaplygin.SpecialInertia([0.8, 1.1, 1.5], 4.0),
    4.0,
    np.array(GAMMA),
    np.array([-3.72, -1.2, 3.46]),
).tolist()  # the ω of k = γ∧p

BALL = ({"a": [0.8, 1.1, 1.5], "D": 4.0}, {"gamma": GAMMA, "p": [3.0, -4.0, 1.5]})
BODY = ({"a": [0.8, 1.1, 1.5]}, BALL[1])
ON_SPHERE = {"q": [0.6, 0.0, 0.8], "v": [0.8, 1.0, -0.6]}
BASES = {
    "ball-on-group": BALL,
    "ball-poisson": BALL,
    "chaplygin-ball": BALL,
    "chaplygin-sphere-hamiltonized": BALL,
    "chaplygin-sphere-reduced": BALL,
    "clebsch": ({"a": [0.7, 1.0, 1.6], "x": 1.0, "y": 0.5}, ON_SPHERE),
    "ellipsoid": ({"a": [1.0, 2.0, 3.0]}, {"x": [1.0, 0.0, 0.0], "p": [0.0, 1.0, 0.5]}),
    "homogeneous-ball": ({"n": 3, "s": 2.0, "D": 4.0}, {"gamma": GAMMA, "k": [0.45, 0.3, 0.6]}),
    "neumann": ({"a": [0.7, 1.0, 1.6]}, ON_SPHERE),
    "rolling-ball": BALL,
    "rubber-ball": ({"inertia": [1.0, 1.5, 2.0], "D": 4.0}, BALL[1]),
    "veselova": BODY,
    "veselova-lr": (BODY[0], {"w": [0.45, 0.3, 0.0]}),
}

# Two values of each key; those of one system where it takes others.
BOTH = {
    "a": ([0.8, 1.1, 1.5], [0.8, 1.1, 1.4]),
    "inertia": ([1.0, 1.5, 2.0], TENSOR),
    "moments": ([1.0, 1.5, 2.0], [1.0, 1.4, 2.0]),
    "J": ([0.6, 0.8, 1.0], [0.6, 0.8, 1.1]),
    "D": (4.0, 5.0),
    "m": (1.0, 1.5),
    "rho": (2.0, 2.5),
    "attitude": (False, True),
    "multipliers": (True, False),
    "n": (3, 2),
    "s": (2.0, 3.0),
    "strength": (1.0, 2.0),
    "x": (1.0, 1.5),
    "y": (0.5, 1.0),
    "r": (1, 2),
    "f1": (0.0, 0.5),
    "gamma": (GAMMA, [0.6, 0.48, 0.64]),
    "p": ([3.0, -4.0, 1.5], [2.0, -2.4, 0.75]),
    "p_tilde": ([3.0, -4.0, 1.5], [2.0, -2.4, 0.75]),
    "k": ([-3.72, -1.2, 3.46], [-1.86, -0.6, 1.73]),  # γ∧p
    "omega": (OMEGA, [0.5 * x for x in OMEGA]),
    "w": ([-3.72, -1.2, 3.46], [-1.86, -0.6, 1.73]),
    "g": (ONE, TURN),
    "q": ([0.6, 0.0, 0.8], [0.6, 0.1, 0.8]),
    "v": ([0.8, 1.0, -0.6], [0.8, 0.5, -0.6]),
}
OTHERS = {
    ("ellipsoid", "a"): ([1.0, 2.0, 3.0], [1.0, 2.0, 3.5]),
    ("ellipsoid", "x"): ([1.0, 0.0, 0.0], [0.9, 0.5, 0.1]),
    ("ellipsoid", "p"): ([0.0, 1.0, 0.5], [0.0, 0.5, 0.5]),
    ("rolling-ball", "r"): ([0.0, 0.0], [0.5, -1.0]),
    ("rubber-ball", "r"): ([0.0, 0.0], [0.5, -1.0]),
    ("veselova", "D"): (1.0, 2.0),
    ("rubber-ball", "a"): ([0.3, 0.4, 0.45], [0.3, 0.4, 0.4]),
    ("rubber-ball", "omega"): ([-3.72, -1.2, 3.46], [-1.86, -0.6, 1.73]),
    ("veselova-lr", "w"): ([0.45, 0.3, 0.0], [0.45, 0.2, 0.0]),
    ("veselova-lr", "k"): ([0.45, 0.3, 0.0], [0.45, 0.2, 0.0]),
}
EXCLUSIVE = [
    {"a", "inertia", "moments", "J"},
    {"D", "m"},
    {"D", "rho"},
    {"p", "p_tilde", "k", "omega", "w"},
]
PARTNERS = {  # what a key needs beside it
    "m": {"rho": 2.0},
    "rho": {"m": 1.0},
    "f1": {"moments": [1.0, 1.5, 2.0]},
}
BESIDE = {  # initial states that a key needs
    ("ball-on-group", "g"): {"p": [1.0, 0.5, 0.0]},
    ("rolling-ball", "g"): {"p": [1.0, 0.5, 0.0]},
    ("rubber-ball", "g"): {"p": [1.0, 0.5, 0.0]},
    ("veselova-lr", "g"): {"w": [0.45, 0.0, 0.0]},
    ("homogeneous-ball", "n"): {"gamma": [0.6, 0.8], "k": [1.0]},  # of n = 2
}
ORDER = {"attitude", "multipliers"}  # say which form is the scene's own, and change none

# Forms that do not carry what a key means.
PLAIN = {"ball", "classical", "reduced", "hamiltonized"}
UNTOUCHED = {
    ("ball-on-group", "g"): {"ball"},
    ("rolling-ball", "g"): PLAIN,
    ("rolling-ball", "r"): PLAIN | {"ball-attitude", "classical-attitude"},
    ("rubber-ball", "g"): PLAIN,
    ("rubber-ball", "r"): PLAIN,
    ("veselova", "D"): {"classical", "multiplier"},
}


def keys() -> list[tuple[str, str, str]]:
    """Return (system, section, key) for all that there is."""
    return [
        (name, section, key)
        for name in system_names()
        for section, model in (
            ("system", find_system(name).parameters),
            ("initial", find_system(name).initial),
        )
        for key in model.model_fields
    ]


@cache
def shown(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what the built-in scenes of a system say: a system of which no table above speaks."""
    scenes = (tomllib.loads(path.read_text("utf-8")) for path in builtin_scenes().values())
    mine = [scene for scene in scenes if scene["system"]["name"] == name]
    assert mine, f"no built-in scene shows {name!r}"
    for scene in mine:
        del scene["system"]["name"]
    return mine[0]["system"], mine[0]["initial"]


def other(x: Any) -> Any:
    """Return another value, near the one that a scene gives."""
    if isinstance(x, list):
        return [other(x[0]), *x[1:]]
    if isinstance(x, bool):
        return not x
    return x + 1 if isinstance(x, int) else 1.05 * x or 0.05


def pair_of(name: str, key: str) -> tuple[Any, Any]:
    """Return two values of a key."""
    given = {} if name in BASES else {k: x for part in shown(name) for k, x in part.items()}
    if key in given:
        return given[key], other(given[key])
    found = OTHERS.get((name, key)) or BOTH.get(key)
    assert found, f"no built-in scene of {name!r} gives {key!r}"
    return found


def built(name: str, section: str, key: str, given: object) -> gi.Model:
    """Return the model of a base with that value of a key."""
    system, initial = BASES.get(name) or shown(name)
    parts = {"system": dict(system), "initial": dict(initial)}
    beside = BESIDE.get((name, key), {}) if given != 3 else {}
    if beside:
        parts["initial"] = dict(beside)
    for other, value_of in {**PARTNERS.get(key, {}), key: given}.items():
        here = parts["system" if other in PARTNERS.get(key, {}) else section]
        for group in EXCLUSIVE:
            for gone in group if other in group else ():
                here.pop(gone, None)
        here[other] = value_of
    if name == "homogeneous-ball":
        parts["system"].setdefault("n", 3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        return gi.Scene(
            system={"name": name, **parts["system"]}, initial=parts["initial"], time={"t_end": 1.0},
            observe={"quantities": []},
        ).model  # fmt: skip


def form(model: gi.Model, name: str) -> object:
    """Return what a form starts from and where it goes from there."""
    problem, y = model.problems[name], model.states[name]
    found = {key: gi.value(problem, f, y) for key, f in problem.diagnostics.items()}
    return seen([y, problem.params, gi.derivative(problem, y), found])


@pytest.mark.parametrize(("name", "section", "key"), keys())
def test_a_key_reaches_every_form(name: str, section: str, key: str) -> None:
    if (name, key) == ("rolling-ball", "v"):
        return  # says nothing new: see the test below
    one, two = (built(name, section, key, given) for given in pair_of(name, key))
    if key in ORDER:
        assert list(one.problems) != list(two.problems)
        assert set(one.problems) == set(two.problems)
        return
    common = [form_name for form_name in one.problems if form_name in two.problems]
    assert common
    same = {n for n in common if form(one, n) == form(two, n)}
    assert same == UNTOUCHED.get((name, key), set()) & set(common)


def test_a_velocity_is_that_of_rolling_or_an_error() -> None:
    own = built("rolling-ball", "initial", "g", ONE)
    y = own.states["rolling"]
    v = y[own.problems["rolling"].slices["v"]].tolist()
    start = {"g": ONE, "p": [1.0, 0.5, 0.0]}
    system = {"name": "rolling-ball", **BALL[0]}
    same = gi.Scene(system=system, initial={**start, "v": v}, time={"t_end": 1.0})
    np.testing.assert_array_equal(same.state, y)
    with pytest.raises(gi.SceneError, match="slips"):
        gi.Scene(system=system, initial={**start, "v": [x + 1.0 for x in v]}, time={"t_end": 1.0})


def test_attitudes_of_all_forms_are_the_one_that_is_given() -> None:
    """And the momentum in space is that of the start in all of them."""
    model = built("rolling-ball", "initial", "g", TURN)
    carrying = [name for name, problem in model.problems.items() if "g" in problem.slices]
    assert set(carrying) == {"rolling", "contact", "ball-attitude", "classical-attitude"}
    for name in carrying:
        problem, y = model.problems[name], model.states[name]
        np.testing.assert_array_equal(y[problem.slices["g"]], np.ravel(TURN))
        assert gi.value(problem, problem.diagnostics["spatial-momentum"], y) < 1e-14


def test_a_unit_of_time_that_nothing_is_measured_in_is_refused() -> None:
    system = {"name": "veselova", "moments": [1.0, 1.5, 2.0], "f1": 0.5, "D": 2.0}
    start = {"gamma": GAMMA, "p": [3.0, -4.0, 1.5]}
    with pytest.raises(gi.SceneError, match=r"\[system\] D = 2\.0: expected none with f1"):
        gi.Scene(system=system, initial=start, time={"t_end": 1.0})
    tilde = {"gamma": GAMMA, "p_tilde": [3.0, -4.0, 1.5]}
    states = [
        gi.Scene(system={**system, "D": D}, initial=tilde, time={"t_end": 1.0}).state.tolist()
        for D in (1.0, 2.0)
    ]
    assert states[0] != states[1]
