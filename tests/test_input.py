"""Arguments that nobody means are refused in words: what, where, and what would be right."""

from __future__ import annotations

import copy
import dataclasses
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import chaplygin as ch
import geomint as gi
from geomint.problems.testproblems import henon_heiles

LONGEST_MESSAGE = 3000  # characters
FIELD, Y0 = henon_heiles.problem(), henon_heiles.INITIAL
SPHERE = ch.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
MASKED = np.ma.masked_array([0.1, 0.2, 0.3, 0.4], mask=[False, True, False, False])
SCENE = {
    "system": {"name": "chaplygin-sphere-reduced", "a": [0.8, 1.1, 1.5], "D": 4.0},
    "initial": {"gamma": [0.6, 0.0, 0.8], "p": [0.8, 1.0, -0.6]},
    "time": {"t_end": 1.0},
}


class Mute:
    """An object without a text, a length or a number."""

    def __repr__(self) -> str:
        raise RuntimeError

    def __len__(self) -> int:
        raise RuntimeError


def nested(depth: int) -> list:
    value: list = []
    for _ in range(depth):
        value = [value]
    return value


def solved(y0=Y0, **given):
    options = {"t_end": 0.1, "step": 0.1, "method": "rk-4", "compiled": False, **given}
    return gi.solve(FIELD, y0, **options)


def observing(name: str) -> gi.Problem:
    f = FIELD.invariants["energy"]
    return dataclasses.replace(FIELD, invariants={name: f})


@gi.observable
def energy(params, t, y, work):
    return 1.0 * y[0]


REFUSED = {
    # what the large fuzz found
    "huge name": (lambda: gi.as_vector(10**5000, "?", 3), "an integer of about 5000 digits"),
    "rows of petabytes": (lambda: gi.pointwise(energy, [1.0], np.ones((2, 3)), 2**53), "rows"),
    "work of petabytes": (lambda: dataclasses.replace(FIELD, work=2**53 - 1), "work"),
    "null-byte": (lambda: gi.load("a\0b"), "path"),
    "half-pair": (lambda: gi.load("\ud800"), "path"),
    "cube-tensor": (lambda: ch.ChaplyginSphere.from_moments(np.ones((3, 3, 1)), 1, 1), "tensor"),
    "flat-tensor": (lambda: ch.ChaplyginSphere.from_moments(np.ones((1, 9)), 1, 1), "tensor"),
    "row-of-J": (lambda: ch.ChaplyginSphere.from_tensor(np.ones((3, 3, 1)), 1, 1), "J"),
    "mute-states": (lambda: ch.frequency_map(SPHERE.hamiltonized(), Mute()), "states"),
    "admit-nothing": (lambda: dataclasses.replace(FIELD, admit=lambda: None), "admit"),
    "far-gaps": (
        lambda: ch.Spheroconical([0.8, 1.1, 1.5]).gamma(np.full((2, 3), 1e300), [1, 1, 1]),
        "gaps",
    ),
    # switches
    "compiled is a word": (lambda: solved(compiled="no"), "compiled = 'no': expected True or"),
    "clock is a number": (lambda: solved(clock=0), "clock = 0: expected True, False or None"),
    "progress is an array": (lambda: solved(progress=np.ones(2)), "progress = array"),
    "iteration is none": (
        lambda: gi.Gauss(8, iteration="picard"),
        "iteration = 'picard': expected one",
    ),
    "iteration is a list": (lambda: gi.Gauss(8, iteration=["auto"]), "iteration = "),
    "fused is a word": (lambda: gi.Gauss(8, fused="no"), "fused = 'no'"),
    "attitude is a list": (lambda: SPHERE.ball(attitude=[1]), "attitude = "),
    # counts
    "save_every of 2^63": (lambda: solved(save_every=2**63), "save_every = 9223.*from 1 to 2⁵³"),
    "observe_every of 2^63": (
        lambda: solved(observe="energy", observe_every=2**63),
        "observe_every = 9223.*from 1 to 2⁵³",
    ),
    "True iterations": (lambda: gi.Gauss(2, max_iterations=True), "max_iterations = True"),
    "True iterations of RATTLE": (lambda: gi.Rattle(max_iterations=True), "max_iterations = True"),
    "10^400 iterations": (lambda: gi.Rattle(max_iterations=10**400), "max_iterations = 1000"),
    "10^400 steps": (
        lambda: gi.Adaptive(gi.RungeKutta("dop853"), max_steps=10**400),
        "max_steps = 1000",
    ),
    "n of 2^53": (lambda: ch.ChaplyginSphere.homogeneous(2**53, 1.0, 1.0), "n = 9007.*2 to 1000"),
    "n of half": (lambda: ch.ChaplyginSphere.homogeneous(3.5, 1.0, 1.0), r"n = 3\.5: expected a w"),
    "so many axes": (
        lambda: ch.SpecialInertia([0.1] * 1200, 1.0),
        "n, from a, = 1200.* up to 1000",
    ),
    "such an operator": (lambda: ch.GeneralInertia([1.0] * 5050), "n, from inertia, = 101"),
    "rows of 2^62": (
        lambda: dataclasses.replace(FIELD, pieces=(("q", 2**62), ("p", 2))),
        "pieces = .* from 1 to 10⁷",
    ),
    "resonances of any order": (lambda: ch.resonances([1.0, 2.0], 2**53), "order = 9007"),
    # numbers
    "a tolerance of an array": (
        lambda: gi.Gauss(2, iteration_tolerance=np.zeros(2)),
        "iteration_tolerance = array",
    ),
    "a tolerance of None": (
        lambda: gi.Rattle(iteration_tolerance=None),
        "iteration_tolerance = None",
    ),
    "a state of 10^400": (lambda: solved([10**400, 0, 0, 0]), "state = .* expected 4 numbers"),
    "a masked state": (lambda: solved(MASKED), "state = masked_array.* none of them masked"),
    "masked params": (lambda: dataclasses.replace(FIELD, params=MASKED), "params = masked"),
    "a masked operator": (lambda: ch.Veselova(MASKED[:3]), "a = masked"),
    "a state of words": (lambda: solved(["1", "2", "3", "4"]), "expected 4 numbers"),
    "a mute state": (lambda: solved(Mute()), "state = <Mute: RuntimeError>"),
    "a time of text": (lambda: gi.derivative(FIELD, Y0, "now"), "t = 'now'"),
    "derivative by an action that is none": (
        lambda: gi.derivative(FIELD, Y0, 0.0, "action"),
        "form = 'action'",
    ),
    "derivative by a number": (lambda: gi.derivative(FIELD, Y0, 0.0, 3), "form = 3"),
    "derivative at a name": (lambda: gi.derivative(FIELD, ["a"] * 4), "y = "),
    "ragged inertia": (lambda: ch.GeneralInertia([[1.0], [1.0, 2.0], [3.0]]), "inertia = "),
    "ragged momentum": (lambda: SPHERE.ball().state(gamma=[1, 0, 0], k=[[1], [2, 3]]), "k = "),
    "1e308 in an operator": (
        lambda: ch.GeneralInertia(np.full((3, 3), 1e308)),
        "inertia = .* least eigenvalue",
    ),
    "angles that are none": (
        lambda: (
            SPHERE.hamiltonized()
            .exact(SPHERE.hamiltonized().state(gamma=[0.6, 0.0, 0.8], p=[0.8, 1.0, -0.6]))
            .at_angles([np.nan])
        ),
        "phi = ",
    ),
    "gaps that are none": (
        lambda: ch.Spheroconical([0.8, 1.1, 1.5]).gamma("?", [1, 1, 1]),
        "gaps = '\\?'",
    ),
    "energies that overflow": (lambda: ch.critical_energies([1, 2, 3], 1e-9, 1e308), "a, D, K"),
    "a seed that is nested": (lambda: SPHERE.ball().random_state(nested(10**5)), "rng = <list"),
    "a seed of text": (lambda: SPHERE.ball().random_state("γ"), "rng = 'γ'"),
    "states that are one number": (
        lambda: ch.frequency_map(SPHERE.hamiltonized(), np.array(3.0)),
        "states = array",
    ),
    "vectors of other shapes": (
        lambda: ch.attitude(np.ones((2, 3)), np.ones(3)),
        "k = .* as many vectors",
    ),
    "a discriminant that overflows": (
        lambda: ch.discriminant([1, 2, 3], 1e200, 1.0, 1.0),
        "K, H",
    ),
    # things
    "no problem": (lambda: gi.solve(None, Y0, t_end=1.0), "problem = None"),
    "no scene": (lambda: gi.load_scene(3), "scene 3: expected a name"),
    "no scene to plan": (lambda: gi.make_plan("ball-3d"), "scene = 'ball-3d'"),
    "no purpose": (lambda: gi.make_plan(gi.load_scene("ball-3d"), np.ones(2)), "purpose = "),
    "no tableau": (lambda: gi.CommutatorFree(3), "tableau = 3: expected a name or a Comm"),
    "no base": (lambda: gi.Compose(None, "suzuki-4"), "base = None"),
    "no composition": (lambda: gi.Compose(gi.Gauss(1), None), "no composition None"),
    "coordinates of an array": (lambda: gi.RKMK("rk-4", coordinates=np.ones(2)), "coordinates = "),
    "no piece": (lambda: gi.so_n(3, 5), "pieces = 5"),
    "a piece that is a list": (lambda: solved().piece([1]), "piece = "),
    "a quadrature of nothing": (lambda: gi.with_quadrature(FIELD, "s", None), "rate = None"),
    # what is observed
    "a builtin observer": (lambda: solved(observe={"x": len}), r"observe\['x'\] = <built-in"),
    "a number among names": (lambda: solved(observe=["energy", 3]), "observe = "),
    "a list among names": (lambda: solved(observe=[["energy"]]), "observe = "),
    "nothing to observe": (
        lambda: gi.solve(
            dataclasses.replace(FIELD, constraints={}), Y0, t_end=0.1, observe=["constraints"]
        ),
        "observe = \\['constraints'\\]: expected something that",
    ),
    # names of files' keys
    "an observer of two folders": (lambda: solved(observe={"a/b": energy}), "observe = 'a/b'"),
    "an observer without a name": (lambda: solved(observe={"": energy}), "observe = ''"),
    "an observer of 1000 characters": (lambda: solved(observe={"ж" * 1000: energy}), "1 to 100"),
    "a quantity of a null": (lambda: observing("a\x00b"), "invariants = 'a\\\\x00b'"),
    "a quantity of half a character": (lambda: observing("\ud800"), "invariants = "),
    "a piece of two folders": (
        lambda: dataclasses.replace(FIELD, pieces=(("q/1", 2), ("p", 2))),
        "pieces = 'q/1'",
    ),
    # methods
    "a composition of order 10^5000": (
        lambda: gi.Compose(gi.Gauss(1), 10**5000),
        "no composition <an integer of about 5000",
    ),
    "2000 compositions": (
        lambda: gi.find_method("gauss-1" + "-suzuki-4" * 2000),
        "no such method",
    ),
    "a method twice": (
        lambda: gi.run_methods(gi.load_scene("ball-3d"), ["cf-4", "cf-4"]),
        "methods = .* once",
    ),
    "a method that is mute": (lambda: gi.find_method(Mute()), "method = <Mute"),
    # scenes from Python
    "a cycle in a scene": (
        lambda: gi.Scene(**{**SCENE, "save": {"t_eval": (cycle := [], cycle.append(cycle))[0]}}),
        "nested at most 20 deep",
    ),
    "a masked scene": (
        lambda: gi.Scene(**{**SCENE, "save": {"t_eval": MASKED}}),
        r"\[save\] t_eval = .* none of them masked",
    ),
    "10^400 in a scene": (
        lambda: gi.Scene(**{**SCENE, "time": {"t_end": 10**400}}),
        r"\[time\] t_end = 1000.*below 10³⁰⁰",
    ),
    "keys that are none": (lambda: gi.Scene(**{**SCENE, "time": {Mute(): 1}}), r"\[time\]"),
    "a name of a million": (lambda: gi.load_scene("x" * 10**6), "neither a file nor"),
    "a path of a million": (lambda: gi.load_scene("x/" * 10**6), "cannot be read"),
    "a path of a null": (lambda: gi.load_scene("a\x00/b.toml"), "cannot be read"),
}


@pytest.mark.parametrize(("call", "words"), REFUSED.values(), ids=REFUSED)
def test_is_refused_in_words(call, words):
    with pytest.raises(gi.GeomintError, match=f"(?s){words}") as caught:
        call()
    assert len(str(caught.value)) <= LONGEST_MESSAGE


@pytest.mark.parametrize("name", ["γ²", "|k|", "f-1-2", "a.b", "r 1", "[x]", "ж" * 100])
def test_what_may_be_a_name_is_saved(tmp_path, name):
    solution = solved(observe={name: energy})
    solution.save(tmp_path / "run.nc")
    assert list(gi.load(tmp_path / "run.nc").drift) == [name]


def test_messages_are_bounded():
    for value in ("ж" * 10**6, [0.5] * 10**6, 7**20_000, nested(10**5), Mute()):
        assert len(str(gi.DomainError("x", value, "y"))) <= 350
    for error in (gi.SceneError("x" * 10**6), gi.DomainError("x" * 10**6, 1, "y" * 10**6)):
        assert len(str(error)) < 1.1 * LONGEST_MESSAGE
        assert str(copy.copy(error)) == str(error)


def test_sizes_that_are_large():
    """Each is looked at in its own unit: warnings are errors here."""
    problem = ch.ellipsoid_problem([1.0, 4.0, 9.0])
    with pytest.warns(gi.GeomintWarning, match=r"√\(x, x/a\) is 1e\+308"):
        state = problem.state(x=[1e308, 0.0, 0.0], p=[0.0, 1.0, 0.0])
    assert state.tolist() == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    for size in (1e308, 1e-308):
        ch.ChaplyginSphere.from_moments(size * np.eye(3), 1, 1)


def test_what_is_a_number_is_taken():
    """Whatever has one value as a float, of any kind that numpy and Python have."""
    y0 = [Fraction(1, 10), Decimal("0.25"), np.float32(0.5), np.int64(0)]
    assert solved(y0).success
    unmasked = np.ma.masked_array([0.1, 0.25, 0.5, 0.0], mask=False)
    assert solved(unmasked, step=Fraction(1, 10)).success
    assert gi.Gauss(np.int64(2), max_iterations=np.int64(5), fused=np.False_).name == "gauss-2"
