"""The step that a scene wants: given, or such that a tolerance is met at its end."""

from typing import Any

from ..arguments import Array
from ..methods.method import Method
from ..problems.problem import Problem
from ..run.accuracy.asked import choose_for
from ..run.asked import Asked
from ..run.promise import Setting
from ..scene.scene import Scene


def chosen_for(
    scene: Scene,
    problem: Problem,
    state: Array,
    t_eval: Any = None,
    clock: bool | None = None,
    observe: Any = (),
) -> Setting | None:
    """Return what meets the tolerance of ``[integrate]`` at the end of the scene; None without one."""
    content = scene.content
    if content.integrate.tolerance is None:
        return None
    time, method = content.time, scene.method
    asked = Asked(
        0.0, time.t_end, time.tau_end, method, t_eval=t_eval, clock=clock, observe=observe
    )
    return choose_for(problem, state, asked, content.integrate.tolerance)


def wanted_step(scene: Scene, problem: Problem, state: Array) -> tuple[Method, float | None]:
    """Return the method and the step of ``[integrate]``, or those that meet its tolerance.

    For what goes on beyond the end of the scene, or from other states: the step is that of the scene.
    """
    chosen = chosen_for(scene, problem, state)
    if chosen is None:
        return scene.method, scene.content.integrate.step
    return chosen.method, chosen.step


def told_accuracy(chosen: Setting, scene: Scene) -> str:
    """Return in words why a step, or a local tolerance, was chosen for a scene."""
    assert chosen.accuracy is not None
    accuracy, name = chosen.accuracy, "rtol" if chosen.step is None else "step"
    tried = ", ".join(
        f"{name} {setting:.3g}: {'fails' if error is None else f'{error:.1e}'}"
        for setting, error in accuracy.trials
    )
    iteration = chosen.method.options.get("iteration_tolerance")
    stops = f"; its iteration stops at {iteration:.1e}" if iteration else ""
    note = f"; it may not be met: {accuracy.note}" if accuracy.note else ""
    return (
        f"{scene.place('integrate', 'tolerance')} = {accuracy.tolerance:g} at the end; expected "
        f"{accuracy.expected:.1e}, by trials on a stretch of the motion ({tried}){stops}{note}"
    )
