"""Cases of single problems: steps of all sizes, and states where formulas divide by nothing.

geomint's own cases are those of all built-in scenes and all test problems.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain
from typing import Any

from ..arguments import Array
from ..errors import Gathered
from ..problems import testproblems
from ..problems.problem import Problem
from ..problems.systems import Model
from ..problems.time_scale import characteristic_time
from ..scene.load import load_scene, scene_names
from . import states
from .case import StressAxis, StressCase

STEP = StressAxis("step", "steps too small and too large", "step/characteristic time")
REST = StressAxis("rest", "pieces at rest", "their size, relative")
ZEROS = StressAxis("zeros", "zero and equal rows", "distance")
STEADY = StressAxis("steady", "steady motions and fixed points", "distance")

FRACTIONS = (1e-12, 1e-6, 1e-2, 0.1, 1.0, 10.0, 100.0, 1000.0)
FEW, MANY = 4, 20  # steps, of a characteristic time or longer, and shorter ones
DISTANCES = {REST: (1e-8, 1e-100, 0.0), ZEROS: (1e-10, 0.0), STEADY: (1e-1, 1e-6, 1e-12, 0.0)}
FRACTION, STEPS = 0.02, 50  # in times of the usual state: what stands still has none
MOST_ROWS = 30  # numbers of a state that is changed to a special one
QUICK = "neumann-3"  # the problem of quick runs: explicit, Gauss, RATTLE, splitting

Motion = tuple[str, str, Problem, Array]  # the system's name, the representation's, where it starts


def own_cases(problem: Problem, y0: Array) -> list[StressCase]:
    """Return the cases of one problem, for `geomint.stress.sweep.run_selection`.

    They are on the axes ``step``, ``rest``, ``zeros`` and ``steady``. The problem is sent to the
    processes that compute: its functions are those of modules, or any where cloudpickle is installed.

    Parameters
    ----------
    problem : Problem
    y0 : array
        A usual state, from which the special ones are made.

    Raises
    ------
    DomainError
        For a state that is not admitted, or has no characteristic time.
    """
    motion = problem.name, "own", problem, problem.canonical(y0)
    return [*_at_all_steps(*motion, True), *_at_special_states(*motion, True)]


def cases(
    examples: Callable[[], list[tuple[Problem, Array]]] = testproblems.examples,
) -> list[StressCase]:
    """Return all cases of this package, or those of all built-in scenes and of other examples.

    A problem that occurs with as many numbers before is not stressed again, and special states are
    those of its smallest size.
    """
    with Gathered(quiet=True):
        models = {f"scene:{name}": load_scene(name).model for name in scene_names()}
    models |= {f"test:{p.name}": Model({p.name: p}, {p.name: y}) for p, y in examples()}
    first: dict[object, Motion] = {}
    smallest: dict[object, Motion] = {}
    for source, model in models.items():
        for name, problem in model.problems.items():
            motion = source, name, problem, model.states[name]
            first.setdefault((problem.name, problem.rows), motion)
            kind = problem.name, *problem.slices
            if problem.rows < smallest.setdefault(kind, motion)[2].rows:
                smallest[kind] = motion
    stepped = (_at_all_steps(*m, m[1] == QUICK) for m in first.values())
    special = (_at_special_states(*m, m[1] == QUICK) for m in smallest.values())
    return [*chain(*stepped, *special)]


def _at_all_steps(
    source: str, name: str, problem: Problem, y0: Array, quick: bool
) -> Iterator[StressCase]:
    time = characteristic_time(problem, y0)
    for fraction in FRACTIONS:
        steps = MANY if fraction < 1.0 else FEW
        ends = quick and fraction in (FRACTIONS[0], FRACTIONS[-1])
        one = _case(source, name, problem, y0, ends)
        yield one(axis=STEP, value=fraction, step=fraction * time, steps=steps)


def _at_special_states(
    source: str, name: str, problem: Problem, y0: Array, quick: bool
) -> Iterator[StressCase]:
    """Yield special states, and those on the way from them to the usual one."""
    if problem.rows > MOST_ROWS:
        return
    step = FRACTION * characteristic_time(problem, y0)
    for axis, kind, special in _special_states(problem, y0):
        for distance in DISTANCES[axis]:
            away = distance * (y0 - special)
            if "g" in problem.slices:  # between two rotations there is none
                away[problem.slices["g"]] = 0.0
            y, exact = states.allowed(problem, special + away), distance == 0.0
            if y is not None:
                steady = axis is STEADY and exact and states.is_steady(problem, y)
                one = _case(f"{source}-{kind}", name, problem, y, quick and exact)
                yield one(axis=axis, value=distance, step=step, steps=STEPS, steady=steady)


def _case(
    system: str, name: str, problem: Problem, y: Array, quick: bool
) -> Callable[..., StressCase]:
    build, names = partial(Model, {name: problem}, {name: y}), (name,)
    chosen: dict[str, Any] = {"representations": names, "quick": names if quick else ()}
    return partial(StressCase, system, n=0, build=build, **chosen)


def _special_states(problem: Problem, y0: Array) -> Iterator[tuple[StressAxis, str, Array]]:
    for pieces in states.resting_pieces(problem, y0):
        yield REST, "-".join(pieces), states.resting(problem, y0, pieces)
    for kind, make in (("zero-rows", states.zero_rows), ("equal-rows", states.equal_rows)):
        yield from ((ZEROS, kind, y) for y in states.first(problem, y0, make))
    for special in states.first(problem, y0, states.on_axes):
        yield STEADY, "axes", special
        for pieces in states.resting_pieces(problem, special)[:1]:
            yield STEADY, "still", states.resting(problem, special, pieces)
