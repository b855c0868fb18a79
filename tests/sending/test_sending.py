"""What a run needs, sent to another process: functions by where they are found."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import pickletools
from typing import Any

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling import sending
from geomint.kernels.numbers.blocks import Block
from geomint.problems.systems import find_system, system_names
from geomint.stress.case import stress_cases
from tests.problems import examples

SCENES = gi.scene_names()
TEST_PROBLEMS = {problem.name: (problem, y0) for problem, y0 in examples()}


def again(value: Any) -> Any:
    """Return the value as another process gets it."""
    sending.kept.cache_clear()
    return pickle.loads(pickle.dumps(value))


def results(problem: gi.Problem, y0: Any) -> list[Any]:
    """Return what the functions of a problem make of a state."""
    y = Block(np.array(y0, dtype=np.float64))
    params, work = Block(np.array(problem.params)), Block(np.zeros(problem.work))
    found: list[Any] = [f(params, 0.0, y, work) for f in problem.diagnostics.values()]
    if problem.field is not None:
        out = Block(np.zeros(problem.rows))
        problem.field(params, 0.0, y, out, work)
        found += out.data.tolist()
    return [*found, *problem.canonical(y0).tolist(), sorted(problem.physical_state(np.array(y0)))]


@pytest.mark.parametrize("name", SCENES)
def test_scenes_models_and_plans(name: str) -> None:
    """All built-in ones, with every representation; each is another object with the same functions."""
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


@pytest.mark.parametrize("name", TEST_PROBLEMS)
def test_problems(name: str) -> None:
    problem, y0 = TEST_PROBLEMS[name]
    found = again(problem)
    assert found == problem
    assert results(found, y0) == results(problem, y0)


@pytest.mark.parametrize("name", system_names())
def test_systems(name: str) -> None:
    assert again(find_system(name)) == find_system(name)


def test_stress_cases() -> None:
    """The sweep sends numbers of cases; these themselves can be sent as well."""
    cases = stress_cases()
    assert again(cases) == cases


def test_solutions() -> None:
    """Of a run, with its problem, method and drifts; not its seconds, which no two runs share."""
    scene = gi.load_scene("ball-3d")
    problem, y0 = scene.problem, scene.state
    one, other = (
        gi.solve(problem, y0, t_end=0.5, method="cf-4", step=0.1, observe="all", compiled=False)
        for _ in range(2)
    )
    assert one == other
    found = again(one)
    assert found == one
    assert found.drift["energy"] == one.drift["energy"]
    assert found != gi.solve(problem, y0, t_end=0.5, method="cf-4", step=0.05, compiled=False)


def test_received_twice_is_one_object() -> None:
    """So that tasks of one worker share what is compiled."""
    problem = TEST_PROBLEMS["pulsating-body"][0]
    content = pickle.dumps(problem)
    assert pickle.loads(content) is pickle.loads(content)


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
    def made(depth: int) -> Any:
        def count(params: Any, t: Any, y: Any, work: Any) -> Any:
            return y[0] if depth == 0 else count.__name__

        return gi.observable(count)

    one, found = made(0), again(made(0))
    assert sending.received(sending.sent(found)).fingerprint == one.fingerprint


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
    """No code is in what is sent."""
    content = sending.sent(TEST_PROBLEMS["pulsating-body"][0])
    assert b"co_code" not in content
    assert b"CodeType" not in content
    assert len(content) < 4000


def test_another_version_is_refused() -> None:
    scene = gi.load_scene("ball-3d")
    content = sending.sent(scene.problem)
    digest = next(
        arg
        for _, arg, _ in pickletools.genops(content)
        if isinstance(arg, bytes) and len(arg) == 32
    )
    with pytest.raises(gi.SendingError, match="expected the same version"):
        pickle.loads(content.replace(digest, bytes(32)))


def test_functions_of_a_session(monkeypatch: pytest.MonkeyPatch) -> None:
    """With cloudpickle, else an error that names the function."""
    space: dict[str, Any] = {"gi": gi, "__name__": "no_such_module"}
    exec(
        "@gi.field\ndef mine(params, t, y, out, work):\n    out[0] = -factor * y[0]\nfactor = 3.0",
        space,
    )
    problem = gi.Problem("mine", (("y", 1),), field=space["mine"])
    sending.cloudpickle.cache_clear()
    try:
        found = again(problem)
        assert results(found, [2.0]) == results(problem, [2.0])
        monkeypatch.setattr(sending, "cloudpickle", lambda: None)
        with pytest.raises(
            gi.SendingError, match=r"'mine' of 'no_such_module' cannot be found.*clou"
        ):
            pickle.dumps(problem)
    finally:
        monkeypatch.undo()
        sending.cloudpickle.cache_clear()


def test_deep_copies() -> None:
    problem = TEST_PROBLEMS["pulsating-body"][0]
    assert copy.deepcopy(problem) == problem
    assert copy.copy(problem) == problem


EXACT = [name for name in SCENES if gi.load_scene(name).problem.make_exact is not None]


@pytest.mark.parametrize("name", EXACT)
def test_exact_motions(name: str) -> None:
    scene = gi.load_scene(name)
    motion = scene.problem.exact(scene.state)
    found = again(motion)
    times = np.array([0.0, 1.5])
    np.testing.assert_array_equal(found(times), motion(times))
    assert found == motion == scene.problem.exact(scene.state)
    assert hash(found) == hash(motion)
    assert scene.problem.exact(motion(0.5)) != motion
