"""What is watched along a run: named functions of the state, reduced to windows on the fly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import FunctionType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arguments import Array, check_name
from ..errors import DomainError, nearest
from ..kernels.compiling.bound import bind
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import FIELD
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.sample import SAMPLE
from ..methods.stepper import Stepper
from ..problems.evaluate import rounding_scale, value
from ..problems.forms import Measure
from ..problems.problem import Problem
from ..problems.spaces.conditions import written
from .drift import ROUNDOFF, Drift, drift_of_run, walk_level
from .measure import MeasureObserver
from .windows import Windows

__all__ = [
    "MEASURE",
    "Observers",
    "choose_observables",
    "expanded",
    "quantities_of",
    "together",
]

GROUPS = ("invariants", "constraints", "observables", "all")
MEASURE = "measure"
MANY = 1_000_000  # calls saved, at some 15 ns each: they pay for compiling another function
NOISE = 4.0  # times the level of its noise: how large a random walk of the measure may be just that


def quantities_of(problem: Problem) -> list[str]:
    """Return the names of all that can be observed: the diagnostics, and the measure if it has one."""
    return [*problem.diagnostics, *([MEASURE] if problem.measure is not None else [])]


def choose_observables(problem: Problem, wanted: Any) -> dict[str, Recorded | Measure]:
    """Return the named functions that `wanted` asks for.

    Parameters
    ----------
    wanted : iterable of str, or mapping of str to recorded function
        Names of the problem's diagnostics; ``"measure"``, the sum of log(density ratio × Jacobian
        determinant) of the numerical steps (`geomint.watch.measure`), if the problem has a measure; the
        groups ``"invariants"``, ``"constraints"``, ``"observables"`` and ``"all"``; or functions
        ``f(params, t, y, work)`` of the user's own.

    Raises
    ------
    DomainError
        For a name that the problem does not have.
    """
    if isinstance(wanted, str):
        wanted = [wanted]
    if not isinstance(wanted, Iterable):
        raise DomainError("observe", wanted, "names of quantities, or a mapping of functions")
    if isinstance(wanted, Mapping):
        return {name: _recorded(name, f) for name, f in wanted.items()}
    try:
        names = list(wanted)
    except Exception:  # whatever a foreign object raises there
        names = [None]
    if not all(isinstance(name, str) for name in names):
        raise DomainError("observe", wanted, "names of quantities, or a mapping of functions")
    known: dict[str, Recorded | Measure] = dict(problem.diagnostics)
    if problem.measure is not None:
        known[MEASURE] = problem.measure
    chosen: dict[str, Recorded | Measure] = {}
    for name in expanded(problem, names):
        if name == MEASURE and name not in known:
            raise DomainError(
                "observe", name, f"one of {list(known)}: {problem.name!r} states no measure"
            )
        if name not in known:
            raise DomainError("observe", name, f"a quantity of the problem.{nearest(name, known)}")
        chosen[name] = known[name]
    if names and not chosen and "all" not in names:
        raise DomainError("observe", names, f"something that {problem.name!r} has: it has none")
    return chosen


def _recorded(name: str, f: Any) -> Recorded:
    check_name("observe", name)
    if name == MEASURE:
        raise DomainError("observe", name, "another name: it is that of the problem's own measure")
    if isinstance(f, Recorded):
        return f
    expected = "a Python function f(params, t, y, work), written with def"
    if not isinstance(f, FunctionType):
        raise DomainError(f"observe[{name!r}]", f, expected)
    return Recorded(f)


def expanded(problem: Problem, wanted: Iterable[str]) -> Iterable[str]:
    """Yield the names of quantities, those of `GROUPS` in place of these."""
    for name in wanted:
        if name == "all":
            yield from quantities_of(problem)
        elif name in GROUPS:
            yield from getattr(problem, name)
        else:
            yield name


def together(names: Iterable[str], samples: float) -> list[tuple[str, ...]]:
    """Return which quantities are evaluated by one function: all, if so many states are watched.

    What they share, such as the angular velocity, is then computed once; but that function is
    compiled for these quantities alone.
    """
    known = tuple(names)
    return [known] if (len(known) - 1) * samples >= MANY else [(name,) for name in known]


class Observers:
    """Evaluates what was chosen on chunks of states and keeps its windows.

    `samples` is how many states will be watched, about.
    """

    def __init__(
        self,
        problem: Problem,
        chosen: Mapping[str, Recorded | Measure],
        y0: Array,
        stepper: Stepper,
        measure_steps: int | None = None,
        samples: float = 0.0,
    ) -> None:
        self._problem, self._compiled, self._names = problem, stepper.compiled, list(chosen)
        functions = {name: f for name, f in chosen.items() if isinstance(f, Recorded)}
        sizes = {"params": len(problem.params), "y": problem.rows}
        self._functions = {
            names: bind(written(*map(functions.get, names)), FIELD, **sizes, out=len(names))
            for names in together(functions, samples)
        }
        self._measure = None
        if MEASURE in chosen:
            self._measure = MeasureObserver(problem, stepper, y0, measure_steps)
        self._params = scalar_block(len(problem.params))
        self._params.data[:] = problem.params
        self._work = scalar_block(problem.work)
        self._entries: dict[tuple[str, ...], Any] = {}
        self._sample: Any = None
        self.windows = {name: Windows(value(problem, f, y0)) for name, f in functions.items()}
        self.scales = {name: rounding_scale(problem, f, y0) for name, f in functions.items()}

    @property
    def needs_all_states(self) -> bool:
        """Whether the state after every step is needed, however seldom something is sampled."""
        return self._measure is not None

    def prepare(self) -> None:
        """Compile, or find in the cache, all functions."""
        if self._measure is not None:
            self._measure.prepare()
        if not self._functions or self._sample is not None:
            return
        self._entries = {names: f.entry(self._compiled) for names, f in self._functions.items()}
        self._sample = SAMPLE.entry(self._compiled)

    def add(
        self,
        times: Array,
        labels: Array,
        states: Array,
        watched: npt.NDArray[np.bool_],
        step: float = 0.0,
    ) -> None:
        """Evaluate everything on the `watched` of `states` (one a row) at the problem's own `times`.

        `labels` are the times that drifts are measured in: the scene's own. `step` is the length of
        the steps that led to the states, 0 if that is not known better than by their times.
        """
        self.prepare()
        if self._measure is not None and len(times):
            self._measure.add(times, labels, states, watched, step)
        self._evaluate(times[watched], labels[watched], states[watched], self._entries)

    def add_end(self, time: float, label: float, state: Array) -> None:
        """Sample the last state of a run, however seldom something is sampled.

        What has been sampled there already is left alone: the end counts once.
        """
        if self._measure is not None:
            self._measure.add_end()
        late = [names for names in self._entries if self.windows[names[0]].last_time != label]
        self._evaluate(np.array([time]), np.array([label]), state[None, :], late)

    def _evaluate(
        self, times: Array, labels: Array, states: Array, groups: Iterable[tuple[str, ...]]
    ) -> None:
        if not self._functions or not len(times):
            return
        count, stride = states.shape
        flat = Block(np.ascontiguousarray(states).reshape(-1))
        now, rows = Block(np.ascontiguousarray(times)), self._problem.rows
        for names in groups:
            width = len(names)
            out = scalar_block(count * width)
            entry = self._entries[names]
            self._sample(
                entry, self._params, now, flat, stride, rows, count, self._work, out, width
            )
            for name, values in zip(names, out.data.reshape(count, width).T, strict=True):
                self.windows[name].add(labels, values)

    def drifts(self, steps: int) -> dict[str, Drift]:
        """Return the drift of every quantity over `steps` steps."""
        drifts = {
            name: drift_of_run(name, windows, scale, walk_level(scale, steps))
            for (name, windows), scale in zip(
                self.windows.items(), self.scales.values(), strict=True
            )
        }
        if self._measure is not None:
            scale = self._measure.scale  # the noise of all steps
            level = NOISE * ROUNDOFF * scale
            drifts[MEASURE] = drift_of_run(MEASURE, self._measure.windows, scale, level)
        return {name: drifts[name] for name in self._names}
