"""A scan: a scene with many values of its numbers, from many states, and what is read off all."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arguments import Array, Integers
from ..errors import SceneError, nearest, quoted
from ..kernels.compiling.sameness import Compared
from ..problems.problem import Problem
from ..run.draws import draw_states
from ..run.ensemble.readings.of_runs import ExponentErrors, Exponents, ExponentVerdict
from ..run.ensemble.readings.of_series import OfQuantity
from ..run.ensemble.readings.reading import Reading
from ..run.ensemble.readings.spelled import chosen_readings
from ..run.ensemble.result import Ensemble
from ..run.ensemble.solve_ensemble import solve_ensemble
from ..scene.scene import Scene
from ..scene.variation import Variation, chosen_variations, told_values, varied_models
from .choice import Asked, Route
from .representation import has, route_with
from .tolerance import wanted_step

MOST_KEYS = 2  # what a picture shows
OF_DRAWS = ("keep", "temperature", "seed")  # without draws they would do nothing


@dataclass(frozen=True, eq=False)
class ScanPlan(Compared):
    """How a scan is made.

    Attributes
    ----------
    route : Route
        What is integrated, of the scene as it is.
    variations : tuple of Variation
        At most two.
    readings : dict of str to Reading
    problems : tuple of Problem
        One for each member, or one for all.
    states : array, shape (members, rows)
        Where the members begin.
    values : array, shape (members, len(variations))
        Of the numbers that vary.
    draws : array of int, shape (members,)
        Which of the random states with these values it is; 0 without draws.
    notes : tuple of str
        What was changed to make states admissible, beyond what the scene itself tells.
    """

    scene: Scene
    route: Route
    variations: tuple[Variation, ...]
    readings: dict[str, Reading]
    problems: tuple[Problem, ...]
    states: Array
    values: Array
    draws: Integers
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.states)

    def run(self, progress: bool | None = None, workers: int | None = None) -> Ensemble:
        """Integrate all members; after Ctrl-C with those that are done."""
        content = self.scene.content
        method, step = wanted_step(self.scene, self.route.problem, self.route.state)
        return solve_ensemble(
            self.problems,
            self.states,
            **Asked(self.scene, "run").end,
            method=method,
            step=step,
            save_every=content.save.every,
            readings=self.readings,
            progress=progress,
            workers=workers,
        )


def plan_scan(scene: Scene, **keys: Any) -> ScanPlan:
    """Return how a scan of a scene is made.

    Parameters
    ----------
    scene : Scene
    **keys
        Of its ``[ensemble]``, in place of what is there; None leaves one as it is.

    Raises
    ------
    SceneError, FormError, DomainError
    """
    given = {key: value for key, value in keys.items() if value is not None}
    scene = scene.changed(ensemble=given) if given else scene
    section = scene.content.ensemble
    if scene.content.integrate.exact:
        raise SceneError(f"scene {quoted(scene.name)}: a scan takes steps: leave out exact")
    variations = tuple(chosen_variations(scene, section.vary))
    if not variations and section.draws is None:
        raise SceneError(f"scene {quoted(scene.name)}: nothing varies: give vary (--vary) or draws")
    if section.draws is None:
        for key in sorted(section.model_fields_set & {*OF_DRAWS}):
            what = f"[ensemble] {key} = {quoted(getattr(section, key))}"
            raise SceneError(
                f"scene {quoted(scene.name)}: {what}: expected draws with it (--draws)"
            )
    if len(variations) > MOST_KEYS:
        names = [v.key for v in variations]
        raise SceneError(f"vary: {quoted(names)}: expected at most {MOST_KEYS} of them")
    readings = _with_errors(chosen_readings(section.show or _usual(scene.problem)))
    asked = Asked(scene, "drift")
    route = _route(asked, readings)
    members = _members(scene, route, variations)
    return ScanPlan(scene, route, variations, readings, *members)


def _usual(problem: Problem) -> list[str]:
    """Return what is read off if nothing else is asked for: the drift of the first invariant."""
    names = list(problem.invariants)
    return [f"drift:{names[0]}"] if names else [f"final:{problem.pieces[0][0]}[0]"]


def _with_errors(readings: dict[str, Reading]) -> dict[str, Reading]:
    """Return readings with what says how sure exponents are, which costs nothing beside them."""
    found = {}
    for name, reading in readings.items():
        found[name] = reading
        if type(reading) is Exponents:
            for beside in (ExponentErrors(reading.count), ExponentVerdict(reading.count)):
                found.setdefault(beside.name, beside)
    return found


def _route(asked: Asked, readings: dict[str, Reading]) -> Route:
    """Return what is integrated: for exponents the scene's own, of which a part has other ones."""
    names = [reading.of for reading in readings.values() if isinstance(reading, OfQuantity)]
    problems = asked.model.problems.values()
    for name in names:
        if not any(has(problem, name) for problem in problems):
            known = dict.fromkeys(q for problem in problems for q in problem.diagnostics)
            raise SceneError(f"show: {quoted(name)}: no such quantity.{nearest(name, [*known])}")
    own = asked.scene.content.integrate.representation is None and any(
        isinstance(reading, Exponents) for reading in readings.values()
    )
    if own:
        asked = Asked(asked.scene.changed_integration(representation="own"), asked.purpose)
    return route_with(asked, names, "this scan", asked.end)


def _members(
    scene: Scene, route: Route, variations: Sequence[Variation]
) -> tuple[tuple[Problem, ...], Array, Array, Integers, tuple[str, ...]]:
    """Return problems and states of all members, the numbers that vary, the draws, and notes."""
    section, states = scene.content.ensemble, []
    problems: list[Problem] = []
    values: list[tuple[float, ...]] = []
    changed = []
    for numbers, model, note in varied_models(scene, variations):
        if route.name not in model.problems:
            where = told_values(variations, numbers)
            raise SceneError(f"with {where}: the system has no representation {route.name!r}")
        problem, state = model.problems[route.name], model.states[route.name]
        if problem.pieces != (problems or [problem])[0].pieces:
            where, before = told_values(variations, numbers), told_values(variations, values[0])
            raise SceneError(f"with {where}: the state has other pieces than with {before}")
        drawn = state[None, :]
        if section.draws is not None:
            drawn = draw_states(
                problem,
                section.draws,
                at=state,
                keep=section.keep,
                temperature=section.temperature,
                seed=section.seed,
            )
        if note and note not in scene.notes:
            changed.append(f"with {told_values(variations, numbers)}: {note}")
        problems.append(problem)
        states.append(drawn)
        values.append(numbers)
    each = len(states[0])
    found = np.repeat(np.array(values).reshape(len(values), -1), each, axis=0)
    repeated = [problem for problem in problems for _ in range(each)]
    many = tuple(repeated if variations else problems)
    draws = np.tile(np.arange(each), len(states))
    notes = (
        (f"{len(changed)} of {len(values)} states were changed; {changed[0]}",) if changed else ()
    )
    return many, np.concatenate(states), found, draws, notes
