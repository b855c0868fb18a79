"""What is watched along a run: named functions of the state, reduced to windows on the fly."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from types import FunctionType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arguments import Array, check_name
from ..errors import DomainError, nearest
from ..kernels.compiling.bound import bind
from ..kernels.compiling.call import Call
from ..kernels.compiling.recorded import Recorded
from ..kernels.compiling.signatures import VALUE
from ..kernels.numbers.blocks import Block, scalar_block
from ..kernels.solve.sample import SAMPLE
from ..methods.stepper import Stepper, filled_block
from ..problems.evaluate import scale_of, states_around
from ..problems.forms import Measure
from ..problems.problem import Problem
from .drift import ROUNDOFF, Drift, drift_of_run, walk_level
from .measure import MeasureObserver
from .windows import Windows

__all__ = ["MEASURE", "Observers", "choose_observables", "expanded", "quantities_of"]

GROUPS = ("invariants", "constraints", "observables", "all")
MEASURE = "measure"
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


class Observers:
    """Evaluates what was chosen on chunks of states and keeps its windows."""

    def __init__(
        self,
        problem: Problem,
        chosen: Mapping[str, Recorded | Measure],
        y0: Array,
        stepper: Stepper,
        measure_steps: int | None = None,
        time: float = 0.0,
    ) -> None:
        self._problem, self._compiled, self._names = problem, stepper.compiled, list(chosen)
        functions = {name: f for name, f in chosen.items() if isinstance(f, Recorded)}
        sizes = {"params": len(problem.params), "y": problem.rows}
        self._functions = {name: bind(f, VALUE, **sizes) for name, f in functions.items()}
        self._measure = None
        if MEASURE in chosen:
            self._measure = MeasureObserver(problem, stepper, y0, measure_steps)
        self._y0, self._time, self._entries = y0, time, dict[str, Any]()
        self._sample: Call | None = None
        self.windows: dict[str, Windows] = {}
        self.scales: dict[str, float] = {}

    @property
    def samples(self) -> bool:
        """Whether something is to be sampled at some states."""
        return bool(self._functions)

    @property
    def needs_all_states(self) -> bool:
        """Whether the state after every step is needed, however seldom something is sampled."""
        return self._measure is not None

    def prepare(self) -> None:
        """Compile, or find in the cache, all functions, and evaluate them where the run begins."""
        if self._measure is not None:
            self._measure.prepare()
        if not self._functions or self._sample is not None:
            return
        problem = self._problem
        self._entries = {name: f.entry(self._compiled) for name, f in self._functions.items()}
        self._sample = SAMPLE.call(
            self._compiled,
            params=filled_block(problem.params),
            rows=problem.rows,
            work=scalar_block(problem.work),
        )
        states = states_around(self._y0)
        for name, values in self._values(np.full(len(states), self._time), states, self._entries):
            self.windows[name] = Windows(float(values[0]), self._time)
            self.scales[name] = scale_of(values, self._y0)

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
        late = [name for name, windows in self.windows.items() if windows.last_time != label]
        self._evaluate(np.array([time]), np.array([label]), state[None, :], late)

    def _evaluate(self, times: Array, labels: Array, states: Array, names: Iterable[str]) -> None:
        if not self._functions or not len(times):
            return
        for name, values in self._values(times, states, names):
            self.windows[name].add(labels, values)

    def _values(
        self, times: Array, states: Array, names: Iterable[str]
    ) -> Iterator[tuple[str, Array]]:
        """Yield the names of functions and their values at states, in memory that all share."""
        assert self._sample is not None
        count, stride = states.shape
        out = scalar_block(count)
        self._sample.set(
            times=Block(np.ascontiguousarray(times)),
            states=Block(np.ascontiguousarray(states).reshape(-1)),
            stride=stride,
            count=count,
            out=out,
        )
        for name in names:
            self._sample(value=self._entries[name])
            yield name, out.data

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
