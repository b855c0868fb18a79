"""What is watched along a run: named functions of the state, reduced to windows on the fly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from .drift import Drift, measure_drift
from .errors import DomainError, nearest
from .evaluate import rounding_scale, value
from .kernels.blocks import Block, scalar_block
from .kernels.recorded import Recorded
from .kernels.sample import sample
from .methods.binding import bind_value
from .problem import Problem
from .windows import Windows

__all__ = ["Observers", "choose_observables"]

Array = npt.NDArray[np.float64]
GROUPS = ("invariants", "constraints", "observables", "all")


def choose_observables(problem: Problem, wanted: Any) -> dict[str, Recorded]:
    """Return the named functions that `wanted` asks for.

    Parameters
    ----------
    wanted : iterable of str, or mapping of str to recorded function
        Names of the problem's diagnostics; the groups ``"invariants"``, ``"constraints"``,
        ``"observables"`` and ``"all"``; or functions ``f(params, t, y, work)`` of the user's own.
    """
    if isinstance(wanted, str):
        wanted = [wanted]
    if not isinstance(wanted, Iterable):
        raise DomainError("observe", wanted, "names of quantities, or a mapping of functions")
    if isinstance(wanted, Mapping):
        return {name: _recorded(name, f) for name, f in wanted.items()}
    known = problem.diagnostics
    chosen: dict[str, Recorded] = {}
    for name in _expanded(problem, wanted):
        if name not in known:
            raise DomainError("observe", name, f"a quantity of the problem.{nearest(name, known)}")
        chosen[name] = known[name]
    return chosen


def _recorded(name: str, f: Any) -> Recorded:
    if isinstance(f, Recorded):
        return f
    if not callable(f):
        raise DomainError(f"observe[{name!r}]", f, "a function f(params, t, y, work)")
    return Recorded(f)


def _expanded(problem: Problem, wanted: Iterable[str]) -> Iterable[str]:
    for name in wanted:
        if name == "all":
            yield from problem.diagnostics
        elif name in GROUPS:
            yield from getattr(problem, name)
        else:
            yield name


class Observers:
    """Evaluates chosen functions on chunks of states and keeps their windows."""

    def __init__(
        self, problem: Problem, functions: Mapping[str, Recorded], y0: Array, compiled: bool = True
    ) -> None:
        self._problem, self._compiled, self._y0 = problem, compiled, y0
        self._functions = {
            name: bind_value(f, len(problem.params), problem.rows) for name, f in functions.items()
        }
        self._params = scalar_block(len(problem.params))
        self._params.data[:] = problem.params
        self._work = scalar_block(problem.work)
        self._entries: dict[str, Any] = {}
        self._sample: Any = None
        self.windows = {name: Windows(value(problem, f, y0)) for name, f in functions.items()}
        self.scales = {name: rounding_scale(problem, f, y0) for name, f in functions.items()}

    def prepare(self) -> None:
        """Compile, or find in the cache, all functions."""
        if not self._functions or self._sample is not None:
            return
        if not self._compiled:
            self._sample, self._entries = sample, dict(self._functions)
            return
        from numba.core import types

        from .kernels import signatures
        from .kernels.compile import SCALAR, compile_function

        value_signature = signatures.value(SCALAR)
        for name, f in self._functions.items():
            self._entries[name] = compile_function(f, value_signature)
        block, integer = SCALAR.block, types.int64
        self._sample = compile_function(
            sample,
            types.void(
                types.FunctionType(value_signature),
                block,
                block,
                block,
                integer,
                integer,
                integer,
                block,
                block,
            ),
        )

    def add(self, times: Array, labels: Array, states: Array) -> None:
        """Evaluate everything on `states` (one a row) at the problem's own `times`.

        `labels` are the times that drifts are measured in: the scene's own.
        """
        if not self._functions or not len(times):
            return
        self.prepare()
        count, stride = states.shape
        flat = Block(np.ascontiguousarray(states).reshape(-1))
        now, out = Block(np.ascontiguousarray(times)), scalar_block(count)
        for name, entry in self._entries.items():
            self._sample(
                entry, self._params, now, flat, stride, self._problem.rows, count, self._work, out
            )
            self.windows[name].add(labels, out.data)

    def drifts(self) -> dict[str, Drift]:
        """Return the drift of every quantity so far."""
        return {
            name: measure_drift(name, windows, self.scales[name])
            for name, windows in self.windows.items()
        }
