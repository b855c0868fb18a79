"""The Poincaré section of a scene: its event, what is integrated for it, and from which states."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import Array
from ..errors import SceneError, quoted
from ..kernels.compiling.sameness import Compared
from ..methods import Exact
from ..run.events import Event
from ..run.level import states_on_level
from ..run.poincare import poincare_section
from ..run.section import Section
from ..scene.scene import Scene
from .choice import Asked, Route
from .representation import route_with
from .tolerance import wanted_step


@dataclass(frozen=True, eq=False)
class SectionPlan(Compared):
    """How the section of a scene is made.

    Attributes
    ----------
    route : Route
        What is integrated: the scene's own representation or one that it contains, in the same time.
    name, event : str, Event
    states : array, shape (motions, rows)
        Where the motions begin; the first is the scene's own.
    """

    scene: Scene
    route: Route
    name: str
    event: Event
    states: Array

    @property
    def exact(self) -> bool:
        """Whether the exact flow is followed, in place of the method's steps."""
        return bool(self.scene.content.integrate.exact)

    def run(self, progress: bool | None = None) -> Section:
        """Return the section; after Ctrl-C what was found by then."""
        content, problem = self.scene.content, self.route.problem
        exact = (Exact(), None)
        method, step = exact if self.exact else wanted_step(self.scene, problem, self.route.state)
        return poincare_section(
            problem,
            self.states,
            {self.name: self.event},
            content.section.points,
            method=method,
            step=step,
            progress=progress,
        )


def plan_section(scene: Scene, **keys: Any) -> SectionPlan:
    """Return how the section of a scene is made.

    Parameters
    ----------
    scene : Scene
    **keys
        Of its ``[section]``, in place of what is there; None leaves one as it is.

    Raises
    ------
    SceneError, FormError, DomainError
    """
    given = {key: value for key, value in keys.items() if value is not None}
    scene = scene.changed(section=given) if given else scene
    section = scene.content.section
    name, event = _event(scene)
    asked = Asked(scene, "drift")
    route = route_with(asked, [event.what, *(section.axes or [])], "this section")
    problem, state = route.problem, route.state
    states = state[None, :]
    if section.motions > 1:
        others = states_on_level(problem, state, section.motions - 1, section.keep, section.seed)
        states = np.concatenate((states, others))
    return SectionPlan(scene, route, name, event, states)


def _event(scene: Scene) -> tuple[str, Event]:
    """Return the event of a section: that of ``[section]``, or the only one of ``[events]``."""
    events, section = scene.events, scene.content.section
    name = section.event or (next(iter(events)) if len(events) == 1 else None)
    if name is None:
        expected = f"one of {', '.join(events)}" if events else "a component such as gamma[2]"
        raise SceneError(f"scene {quoted(scene.name)} does not say at which event: give {expected}")
    known = events.get(name, Event(name))
    level = known.level if section.level is None else section.level
    event = Event(known.what, section.direction or known.direction, level=level)
    return name if name in events else event.name, event
