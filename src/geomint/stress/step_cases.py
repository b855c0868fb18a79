"""All built-in scenes and all test problems, at steps of all sizes."""

import functools
from collections.abc import Callable, Iterable, Iterator
from functools import partial

from ..arguments import Array
from ..errors import Gathered
from ..problems.problem import Problem
from ..problems.systems import Model
from ..scene.load import load_scene, scene_names
from .case import Names, StressAxis, StressCase

Build = Callable[[], Model]
Source = tuple[str, Build]
Examples = Callable[[], list[tuple[Problem, Array]]]

STEP = StressAxis("step", "steps too small and too large", "step/characteristic time")

_FRACTIONS = (1e-12, 1e-6, 1e-2, 0.1, 1.0, 10.0, 100.0, 1000.0)
_QUICK = (1e-12, 1000.0)
QUICK = "neumann-3"  # the problem of quick runs: explicit, Gauss, RATTLE, splitting
_FEW, _MANY = 4, 20


def sources(examples: Examples) -> Iterator[Source]:
    """Yield the names of all built-in scenes and of examples, and how their models are built."""
    for name in scene_names():
        yield f"scene:{name}", partial(_scene, name)
    for i, (problem, _) in enumerate(examples()):
        yield f"test:{problem.name}", partial(_example, examples, i)


def steps(sources: Iterable[Source]) -> list[StressCase]:
    """Return steps of every size for every source.

    A representation that an earlier one has, with as many numbers, is not stressed again.
    """
    found = []
    seen: set[tuple[str, int]] = set()
    for source, build in sources:
        model = build()
        new = [r for r, p in model.problems.items() if (p.name, p.rows) not in seen]
        seen.update((problem.name, problem.rows) for problem in model.problems.values())
        found += _at_all_steps(source, build, tuple(new))
    return found


def _at_all_steps(name: str, build: Build, representations: Names) -> list[StressCase]:
    quick = tuple(name for name in representations if name == QUICK)
    return [
        StressCase(
            name,
            STEP,
            fraction,
            0,
            build,
            representations=representations,
            fraction=fraction,
            steps=_MANY if fraction < 1.0 else _FEW,
            quick=quick if fraction in _QUICK else (),
        )
        for fraction in _FRACTIONS
    ]


@functools.cache
def _scene(name: str) -> Model:
    with Gathered(quiet=True):
        return load_scene(name).model


@functools.cache
def _example(examples: Examples, i: int) -> Model:
    problem, y0 = examples()[i]
    return Model({problem.name: problem}, {problem.name: y0})
