"""What a comparison leaves to a process that compiles beside it."""

from __future__ import annotations

import pytest

import geomint as gi
from geomint.compare import of_scene
from geomint.compare.ladder import STEP_FACTORS

NAMES = ["gauss-8", "rattle-4", "rk-4"]


@pytest.fixture
def scene() -> gi.Scene:
    return gi.load_scene("hamiltonized-n3")


@pytest.mark.parametrize(
    ("at", "left"),
    [
        ("reference solution in double-double arithmetic", NAMES),
        ("reference solution by the exact flow", NAMES[::-1]),
        ("", NAMES[::-1]),
        ("gauss-8, step 0.5", ["rk-4", "rattle-4"]),
        ("rattle-4, step 0.5", ["rk-4"]),
        ("rk-4, step 0.5", []),
    ],
)
def test_methods_that_are_still_to_come(scene: gi.Scene, at: str, left: list[str]) -> None:
    """From the other end, unless the reference comes first."""
    tasks = of_scene.warming(scene, NAMES, at)
    assert [gi.find_method(task.args[1]).name for task in tasks] == left


def test_the_scenes_own_method_keeps_its_options(scene: gi.Scene) -> None:
    own = scene.changed_integration("gauss-8", None)
    (task,) = of_scene.warming(own, ["gauss-8"], "")
    assert task.args[1] == own.method


def test_runs_are_those_of_the_comparison(scene: gi.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """To both ends, with what is watched; at the longest step, which may turn to Newton's method."""
    runs = []

    def noted(problem, y0, **options):
        runs.append((problem.name, options))
        assert not options["callback"](None)
        raise gi.ConvergenceError(0.0, 0, 1.0, 1, "as a step that is too long")

    monkeypatch.setattr(of_scene, "solve", noted)
    of_scene.warm_method(scene, gi.Gauss(8))
    (first, timed), (second, watched) = runs
    assert first == second == scene.problem.name
    assert timed["tau_end"] == scene.content.time.tau_end
    assert timed["clock"] is False
    assert "observe" not in timed
    assert watched["t_end"] > 0.0
    assert watched["observe"] == [*scene.problem.invariants, *scene.problem.constraints]
    own = gi.Gauss(8).default_step(scene.problem, scene.state, timed["tau_end"])
    assert (
        timed["step"] == watched["step"] == STEP_FACTORS[0] * (scene.content.integrate.step or own)
    )
    assert timed["progress"] is False
