"""The Lyapunov exponents of a scene: what is integrated for them, and how far."""

from dataclasses import dataclass

from ..errors import FormError, SceneError, quoted
from ..kernels.compiling.sameness import Compared
from ..run.exponents import Lyapunov
from ..run.lyapunov import lyapunov
from ..scene.scene import Scene
from .choice import Asked, Route
from .fitting import unfit
from .tolerance import wanted_step


@dataclass(frozen=True, eq=False)
class ChaosPlan(Compared):
    """How the exponents of a scene are found.

    Attributes
    ----------
    route : Route
        What is integrated: the scene's own representation unless another one is asked for. A part of
        the state has a part of the exponents.
    count : int or None
        How many exponents, the largest; None: all.
    """

    scene: Scene
    route: Route
    count: int | None = None

    def run(self, progress: bool | None = None) -> Lyapunov:
        """Return the exponents; after Ctrl-C those of the time until then."""
        method, step = wanted_step(self.scene, self.route.problem, self.route.state)
        return lyapunov(
            self.route.problem,
            self.route.state,
            **Asked(self.scene, "drift").end,
            method=method,
            step=step,
            count=self.count,
            progress=progress,
        )


def plan_chaos(scene: Scene, count: int | None = None) -> ChaosPlan:
    """Return how the exponents of a scene are found.

    Raises
    ------
    SceneError, FormError
        For an end in physical time of a problem in τ, and where the method takes no steps of a given
        length.
    """
    asked, content = Asked(scene, "drift"), scene.content
    if content.integrate.exact or scene.method.adaptive:
        name = "the exact flow" if content.integrate.exact else repr(scene.method.name)
        raise FormError(f"exponents are those of steps of one length, which {name} does not take")
    route = asked.route(asked.representation or asked.own)
    obstacle = unfit(route.problem, scene.method, {})
    if obstacle:
        raise FormError(f"{route.name!r} {obstacle}: choose another method or representation")
    if route.problem.time == "tau" and "tau_end" not in asked.end:
        expected = "tau_end, as exponents are those of the problem's own time (--tau-end)"
        raise SceneError(
            f"scene {quoted(scene.name)} ends at t = {asked.end['t_end']:g}: expected {expected}"
        )
    return ChaosPlan(scene, route, count)
