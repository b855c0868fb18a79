"""What a run needs, sent to another process: functions by where they are found."""

from __future__ import annotations

import dataclasses
import pickle
import pickletools
import sys
from importlib.metadata import entry_points
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling import sending
from tests.problems import examples

SCENES = gi.scene_names()
LATE = {name for name in SCENES if name[-1] != "3" and f"{name[:-1]}3" in SCENES}
TEST_PROBLEMS = {problem.name: (problem, y0) for problem, y0 in examples()}


def again(value: Any) -> Any:
    """Return the value as another process gets it."""
    sending.kept.cache_clear()
    return pickle.loads(pickle.dumps(value))


def results(problem: gi.Problem, y0: Any) -> list[Any]:
    """Return what the functions of a problem make of a state."""
    found = [gi.value(problem, name, y0) for name in problem.diagnostics]
    rates = [gi.derivative(problem, y0, 0.0, form).tolist() for form in problem.forms]
    return [found, rates, problem.canonical(y0).tolist(), sorted(problem.physical_state(y0))]


@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=[pytest.mark.nightly] * (x in LATE)) for x in SCENES]
)
def test_scenes_models_and_plans(name: str) -> None:
    """With every representation, and exact motions; each is another object with the same functions."""
    scene = gi.load_scene(name)
    found = again(scene)
    assert found == scene
    assert found.model is not scene.model
    assert again(gi.make_plan(scene)) == gi.make_plan(scene)
    for key, problem in scene.model.problems.items():
        sent = found.model.problems[key]
        assert sent is not problem
        assert hash(sent) == hash(problem)
        assert results(sent, scene.model.states[key]) == results(problem, scene.model.states[key])
        fingerprints = [f.fingerprint for f in problem.diagnostics.values()]
        assert [f.fingerprint for f in sent.diagnostics.values()] == fingerprints
    if scene.problem.make_exact is not None:
        motion, own = scene.problem.exact(scene.state), again(scene.problem.exact(scene.state))
        assert own == motion == scene.problem.exact(scene.state)
        assert hash(own) == hash(motion)
        assert scene.problem.exact(motion(0.5)) != motion
        np.testing.assert_array_equal(own([0.0, 1.5]), motion([0.0, 1.5]))


@pytest.mark.parametrize("name", TEST_PROBLEMS)
def test_problems(name: str) -> None:
    problem, y0 = TEST_PROBLEMS[name]
    found = again(problem)
    assert found == problem
    assert results(found, y0) == results(problem, y0)


@pytest.mark.parametrize("group", ["geomint.systems", "geomint.stress"])
def test_systems_and_stress_cases(group: str) -> None:
    """The sweep sends cases to its processes."""
    for point in entry_points(group=group):
        value = point.load()() if group == "geomint.stress" else point.load()
        assert again(value) == value, point.name


def test_solutions() -> None:
    """Of a run, with its problem, method and drifts; not its seconds, which no two runs share."""
    scene, run = gi.load_scene("ball-3d"), {"t_end": 0.5, "method": "cf-4", "compiled": False}
    problem, y0 = scene.problem, scene.state
    one, other = (gi.solve(problem, y0, step=0.1, observe="all", **run) for _ in range(2))
    assert one == other
    found = again(one)
    assert found == one
    assert found.drift["energy"] == one.drift["energy"]
    assert found != gi.solve(problem, y0, step=0.05, **run)


def test_differences_are_seen() -> None:
    """In a parameter, a function, a value that a function holds."""

    def made(factor: float) -> gi.Problem:
        @gi.field
        def growing(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
            out[0] = factor * y[0]

        return gi.Problem("growing", (("y", 1),), params=[1.0], field=growing)

    assert made(2.0) == made(2.0)
    assert made(2.0) != made(3.0)
    assert again(made(2.0)) == made(2.0)
    assert results(again(made(2.0)), [1.5]) == results(made(2.0), [1.5])

    def in_session(factor: float) -> Any:
        space: dict[str, Any] = {"gi": gi, "__name__": "__main__", "factor": factor}
        exec("@gi.observable\ndef mine(params, t, y, work):\n    return factor * y[0]", space)
        return dataclasses.replace(made(2.0), observables={"mine": space["mine"]})

    assert in_session(1.0) == in_session(1.0)
    assert in_session(1.0) != in_session(2.0)
    problem = made(2.0)
    object.__setattr__(problem, "params", np.array([np.nextafter(1.0, 2.0)]))
    assert problem != made(2.0)


def test_functions_that_hold_themselves() -> None:
    @gi.field
    def still(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = 0.0 * y[0]

    def count(params: Any, t: Any, y: Any, work: Any) -> Any:
        return y[0] if len(y) < 9 else count.__name__

    own = {"count": gi.observable(count)}
    problem = gi.Problem("still", (("y", 1),), field=still, observables=own)
    found = again(again(problem))
    assert found == problem
    assert found.observables["count"].fingerprint == own["count"].fingerprint


LAMBDA = lambda y: {"y": y}  # noqa: E731 - functions of a module may be written so


class Maker:
    """Functions of classes, and inside of their methods."""

    @staticmethod
    def admit(y: Any) -> Any:
        return y

    def physical(self) -> Any:
        return lambda y: {"of": y, "two": [f(y) for f in ((lambda y: y), (lambda y: 2 * y))]}


def test_functions_of_modules_and_classes() -> None:
    @gi.field
    def still(params: Any, t: Any, y: Any, out: Any, work: Any) -> None:
        out[0] = 0.0 * y[0]

    for admit, physical in ((Maker.admit, LAMBDA), (None, Maker().physical())):
        problem = gi.Problem("still", (("y", 1),), field=still, admit=admit, physical=physical)
        found = again(problem)
        assert found == problem
        y = np.array([3.0])
        assert repr(found.physical(y)) == repr(problem.physical(y))


def test_by_place_not_by_content() -> None:
    """No code is in what is sent; what is at the place is held to what was."""
    content = pickle.dumps(TEST_PROBLEMS["pulsating-body"][0])
    assert b"co_code" not in content
    assert b"CodeType" not in content
    assert len(content) < 4000
    inner = max((x for _, x, _ in pickletools.genops(content) if isinstance(x, bytes)), key=len)
    held = [x for _, x, _ in pickletools.genops(inner) if isinstance(x, bytes) and len(x) == 32]
    for digest in held:
        with pytest.raises(gi.SendingError, match="expected the same version"):
            pickle.loads(content.replace(digest, bytes(32)))
    assert held


def test_functions_of_a_session(monkeypatch: pytest.MonkeyPatch) -> None:
    """With cloudpickle, else an error that names the function."""
    space: dict[str, Any] = {"gi": gi, "__name__": "no_such_module"}
    exec(
        "@gi.field\ndef mine(params, t, y, out, work):\n    out[0] = -factor * y[0]\nfactor = 3.0",
        space,
    )
    problem = gi.Problem("mine", (("y", 1),), field=space["mine"])
    found = again(problem)
    assert results(found, [2.0]) == results(problem, [2.0])
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    with pytest.raises(gi.SendingError, match=r"'mine' of 'no_such_module' cannot be found.*clou"):
        pickle.dumps(problem)
