"""Every key of ``[system]`` and ``[initial]`` of every system reaches every form that it concerns."""

from __future__ import annotations

import math
import warnings
from importlib.metadata import entry_points
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.asked.asked_support import another, seen

c, s = math.cos(0.7), math.sin(0.7)
ONE = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
TURN = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
TENSOR = [[1.0, 0.1, 0.0], [0.1, 1.5, 0.0], [0.0, 0.0, 2.0]]
GAMMA, A, P = [0.48, 0.6, 0.64], [0.8, 1.1, 1.5], [3.0, -4.0, 1.5]
K, OMEGA = [-3.72, -1.2, 3.46], [-0.886025, -0.074858780487804878, 0.41744981707317073]  # γ∧p
BALL: tuple[dict[str, Any], dict[str, Any]] = ({"a": A, "D": 4.0}, {"gamma": GAMMA, "p": P})
BODY, ON_SPHERE = ({"a": A}, BALL[1]), {"q": [0.6, 0.0, 0.8], "v": [0.8, 1.0, -0.6]}
BASES = {
    "clebsch": ({"a": A, "x": 1.0, "y": 0.5}, ON_SPHERE), "neumann": ({"a": A}, ON_SPHERE),
    "ellipsoid": ({"a": [1.0, 2.0, 3.0]}, {"x": [1.0, 0.0, 0.0], "p": [0.0, 1.0, 0.5]}),
    "homogeneous-ball": ({"n": 3, "s": 2.0, "D": 4.0}, {"gamma": GAMMA, "k": [0.45, 0.3, 0.6]}),
    "rubber-ball": ({"inertia": [1.0, 1.5, 2.0], "D": 4.0}, BALL[1]), "veselova": BODY,
    "veselova-lr": (BODY[0], {"w": [0.45, 0.3, 0.0]}),
}  # fmt: skip
# Two values of a key, or one that has another one near; those of one system where it takes others.
VALUES = {
    "inertia": ([1.0, 1.5, 2.0], TENSOR), "moments": [1.0, 1.5, 2.0], "J": [0.6, 0.8, 1.0], "n": (3, 2),
    "m": 1.0, "rho": 2.0, "attitude": False, "multipliers": False, "strength": 1.0, "r": 1, "f1": 0.1,
    "gamma": (GAMMA, [0.6, 0.48, 0.64]), "p_tilde": P, "k": K, "omega": OMEGA, "w": K, "g": (ONE, TURN),
    "q": ([0.6, 0.0, 0.8], [0.6, 0.1, 0.8]), "D": 4.0, "a": A, "p": P, "v": ON_SPHERE["v"],
    "x": 1.0, "y": 0.5, "s": 2.0, "ellipsoid a": [1.0, 2.0, 3.0],
    "ellipsoid p": ([0.0, 1.0, 0.5], [0.0, 0.5, 0.5]),
    "ellipsoid x": ([1.0, 0.0, 0.0], [0.9, 0.5, 0.1]), "rubber-ball a": [0.3, 0.4, 0.45],
    **{f"{ball} r": ([0.0, 0.0], [0.5, -1.0]) for ball in ("rolling-ball", "rubber-ball")},
    "veselova D": (1.0, 2.0), "rubber-ball omega": K,
    **{f"veselova-lr {key}": [0.45, 0.3, 0.0] for key in "wk"},
}  # fmt: skip
EXCLUSIVE = [{"a", "inertia", "moments", "J"}, {"D", "m"}, {"D", "rho"}]
EXCLUSIVE += [{"p", "p_tilde", "k", "omega", "w"}]
# What a key needs beside it; initial states in place of those above.
BESIDE = {"m": {"rho": 2.0}, "rho": {"m": 1.0}, "f1": {"moments": [1.0, 1.5, 2.0]}}
TURNED = {"g": {"p": [1.0, 0.5, 0.0]}, "veselova-lr g": {"w": [0.45, 0.0, 0.0]}}
TURNED |= {"n": {"gamma": [0.6, 0.8], "k": [1.0]}}  # of n = 2
ORDER = {"attitude", "multipliers"}  # say which form is the scene's own, and change none
# Forms that do not carry what a key means.
PLAIN = {"ball", "classical", "reduced", "hamiltonized"}
UNTOUCHED = {
    "ball-on-group g": {"ball"}, "rolling-ball g": PLAIN, "rubber-ball g": PLAIN,
    "rolling-ball r": PLAIN | {"ball-attitude", "classical-attitude"}, "rubber-ball r": PLAIN,
    "veselova D": {"classical", "multiplier"},
}  # fmt: skip


def keys() -> list[tuple[str, str, str]]:
    """Return (system, section, key) for all that there is."""
    return [
        (point.name, section, key)
        for point in sorted(entry_points(group="geomint.systems"))
        for section, of in (("system", "parameters"), ("initial", "initial"))
        for key in getattr(point.load(), of).model_fields
    ]


def built(name: str, section: str, key: str, given: object) -> gi.Model:
    """Return the model of a base with that value of a key."""
    system, initial = BASES.get(name, BALL)
    other = {} if given == 3 else TURNED.get(f"{name} {key}", TURNED.get(key, {}))
    parts = {"system": dict(system), "initial": dict(other or initial)}
    for here, more in (("system", BESIDE.get(key, {})), (section, {key: given})):
        for name_of in more:
            gone = set().union(*(group for group in EXCLUSIVE if name_of in group))
            parts[here] = {k: x for k, x in parts[here].items() if k not in gone}
        parts[here] |= more
    if name == "homogeneous-ball":
        parts["system"].setdefault("n", 3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gi.GeomintWarning)
        parts["system"]["name"] = name
        return gi.Scene(**parts, time={"t_end": 1.0}, observe={"quantities": []}).model


def form(model: gi.Model, name: str) -> object:
    """Return what a form starts from and where it goes from there."""
    problem, y = model.problems[name], model.states[name]
    found = {key: gi.value(problem, f, y) for key, f in problem.diagnostics.items()}
    return repr(seen([y, problem.params, gi.derivative(problem, y), found]))


@pytest.mark.parametrize(("name", "section", "key"), keys())
def test_a_key_reaches_every_form(name: str, section: str, key: str) -> None:
    if (name, key) == ("rolling-ball", "v"):
        return  # says nothing new: tests/chaplygin/test_rolling_states.py
    values = VALUES.get(f"{name} {key}", VALUES.get(key))
    pair = values if isinstance(values, tuple) else (values, another(values))
    one, two = (built(name, section, key, given) for given in pair)
    if key in ORDER:
        assert list(one.problems) != list(two.problems)
        assert set(one.problems) == set(two.problems)
        return
    common = [form_name for form_name in one.problems if form_name in two.problems]
    assert common
    same = {n for n in common if form(one, n) == form(two, n)}
    assert same == UNTOUCHED.get(f"{name} {key}", set()) & set(common)


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
    given = {"system": {"name": "veselova", "moments": [1.0, 1.5, 2.0], "f1": 0.5, "D": 2.0}}
    with pytest.raises(gi.SceneError, match=r"\[system\] D = 2\.0: expected none with f1"):
        gi.Scene(**given, initial=BALL[1], time={"t_end": 1.0})
    start = {"gamma": GAMMA, "p_tilde": P}
    states = []
    for D in (1.0, 2.0):
        given["system"]["D"] = D
        states.append(gi.Scene(**given, initial=start, time={"t_end": 1.0}).state.tolist())
    assert states[0] != states[1]
