"""What `geomint.solve_ensemble` returns: arrays with an axis of members."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arguments import Array, whole
from ...errors import DomainError, GeomintError
from ...problems.problem import Problem
from ...problems.shown import Shown
from ..solution import Solution
from ..solve import solve
from ..variables import optional
from .given import Asked, Members
from .outcome import Outcome

__all__ = ["Ensemble"]

_NUMBERS = (
    "initial", "max_abs_error", "final_error", "scale", "slope", "slope_stderr", "trend_bound",
)  # fmt: skip


@dataclass(repr=False, eq=False)
class Ensemble(Shown):
    """The result of `geomint.solve_ensemble`: N members, one a row of every array.

    Attributes
    ----------
    problems : tuple of Problem
        One for each member, or one for all.
    states : array, shape (N, rows)
        Where the members began.
    tau : array, shape (N, m)
        Times of the saved states in the problems' own time.
    t : array, shape (N, m)
        Physical times, where they were integrated.
    y : array, shape (N, m, rows)
        The saved states. Members that have fewer than others end in NaN.
    counts, steps : array of int, shape (N,)
        How many states were saved, and steps taken.
    status : array of str, shape (N,)
        As that of `geomint.Solution`, or ``"not run"``: after Ctrl-C, or where workers have ended.
    errors : dict of int to GeomintError
        What ended members before their ends, by their numbers.
    events : dict of name to list of Met
        Of each event what `geomint.Solution` has of it, member by member.
    error_estimate : array, shape (N, m, rows), or None
        As that of `geomint.Solution`.
    readings : dict of str to array
        What was read off: of each member a number or an array of them, NaN for those that have not
        come to their ends; histograms have no axis of members.
    run_seconds : float
        Wall time of all members together.
    """

    given: Members
    asked: Asked
    found: Outcome
    run_seconds: float = 0.0

    def __len__(self) -> int:
        return len(self.given)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """One for each member, or one for all."""
        return self.given.problems

    @property
    def states(self) -> Array:
        """Where the members began."""
        return self.given.states

    @property
    def tau(self) -> Array:
        """Times of the saved states, the problems' own."""
        return self.found.tau

    @property
    def t(self) -> Array:
        """Physical times of the saved states."""
        physical = self.found.physical
        if self.problems[0].time == "tau" and np.isnan(physical).all() and self.found.counts.any():
            raise DomainError("clock", False, "clock=True: physical time was not integrated")
        return physical

    @property
    def y(self) -> Array:
        """The saved states."""
        return self.found.y

    @property
    def counts(self) -> npt.NDArray[np.int64]:
        """How many states of each were saved."""
        return self.found.counts

    @property
    def steps(self) -> npt.NDArray[np.int64]:
        """How many steps each took."""
        return self.found.steps

    @property
    def status(self) -> npt.NDArray[np.str_]:
        """How each ended."""
        return self.found.status.astype(str)

    @property
    def errors(self) -> Mapping[int, GeomintError]:
        """What ended members before their ends, by their numbers."""
        return self.found.errors

    @property
    def error_estimate(self) -> Array | None:
        """How far the saved states are from the motion, if that was asked for."""
        return self.found.error_estimate

    @property
    def readings(self) -> dict[str, Array]:
        """What was read off every member, by names."""
        return dict(self.found.readings)

    @property
    def success(self) -> bool:
        """Whether every member got to its end."""
        return bool((self.found.status == "success").all())

    @property
    def final(self) -> Array:
        """The last state of every member, shape (N, rows); NaN of those that have none."""
        last = np.maximum(self.counts - 1, 0)
        final: Array = self.y[np.arange(len(self)), last]
        return final

    def piece(self, name: str) -> Array:
        """Return a piece of the saved states by its name, shape (N, m, numbers)."""
        slices = self.problems[0].slices
        if not (isinstance(name, str) and name in slices):
            raise DomainError("piece", name, f"one of {list(slices)}")
        return self.y[:, :, slices[name]]

    @property
    def events(self) -> dict[str, list[Any]]:
        """Of each event what there is of it, member by member."""
        own = self.found.events
        names = dict.fromkeys(name for of in own.values() for name in of)
        return {name: [own.get(k, {}).get(name) for k in range(len(self))] for name in names}

    @property
    def drift(self) -> dict[str, dict[str, Any]]:
        """Of each observed quantity arrays over the members: what `geomint.Drift` says of it."""
        names = dict.fromkeys(name for of in self.found.drift.values() for name in of)
        return {name: self._drift(name) for name in names}

    def _drift(self, name: str) -> dict[str, Any]:
        own = [self.found.drift.get(k, {}).get(name) for k in range(len(self))]
        found: dict[str, Any] = {}
        for key in _NUMBERS:
            values = [getattr(d, key, None) for d in own]
            found[key] = np.array([np.nan if v is None else v for v in values])
        found["class"] = np.array(["" if d is None else d.drift_class for d in own])
        return found

    def single(self, member: int, **more: Any) -> Solution:
        """Return the run of one member alone, to the same bits, with more arguments of `geomint.solve`.

        Raises
        ------
        DomainError
            For a number that no member has.
        StepError
            Where the member fails.
        """
        k = whole("member", member, 0, len(self) - 1)
        return solve(self.given.problem(k), self.states[k], **{**self.asked.arguments(), **more})

    def to_xarray(self) -> Any:
        """Return times, pieces and drifts as an `xarray.Dataset` with the dimension ``member``.

        Raises
        ------
        MissingCodeError
            Without the library xarray.
        """
        xarray = optional("xarray", "Ensemble.to_xarray")
        data: dict[str, Any] = {"tau": (("member", "sample"), self.tau)}
        data["steps"], data["status"] = ("member", self.steps), ("member", self.status)
        if np.isfinite(self.found.physical).any():
            data["t"] = ("member", "sample"), self.found.physical
        shapes = self.problems[0].shapes
        taken = {
            "member",
            "sample",
            *(f"{n}_{i}" for n, s in shapes.items() for i in range(len(s))),
        }
        for name, shape in shapes.items():
            values = self.piece(name).reshape(*self.tau.shape, *shape)
            axes = tuple(f"{name}_{i}" for i in range(len(shape)))
            data[_free(name, taken | data.keys())] = ("member", "sample", *axes), values
        for name, drift in self.drift.items():
            for key, values in drift.items():
                data[_free(f"{name}_{key}", taken | data.keys())] = ("member",), values
        for name, numbers in self._parameters().items():
            data[_free(name, taken | data.keys())] = ("member",), numbers
        for name, values in self.readings.items():
            merged = self.asked.readings[name].merges
            rest = [f"{name}_{i}" for i in range(values.ndim - (0 if merged else 1))]
            axes = tuple(rest) if merged else ("member", *rest)
            data[_free(name, taken | {*rest} | data.keys())] = axes, values
        about = {"problem": self.problems[0].name, "method": self.asked.method.name}
        return xarray.Dataset(data, attrs=about).set_coords([n for n in ("tau", "t") if n in data])

    def _parameters(self) -> dict[str, Array]:
        """Return the parameters that differ between members and are single numbers."""
        found = {}
        for name in self.problems[0].parameters if len(self.problems) > 1 else ():
            values = [problem.parameters.get(name) for problem in self.problems]
            if all(isinstance(v, int | float) for v in values) and len(set(values)) > 1:
                found[name] = np.array(values, dtype=np.float64)
        return found

    def _shown(self) -> tuple[str, dict[str, Any]]:
        names, counts = np.unique(self.status, return_counts=True)
        return f"ensemble of {len(self)} × {self.problems[0].name!r} by {self.asked.method.name}", {
            "status": ", ".join(f"{n} {s}" for s, n in zip(names, counts, strict=True)),
            "states": f"{int(self.counts.max(initial=0))} a member",
            "steps": f"{int(self.steps.sum())} in {self.run_seconds:.3g} s",
        }


def _free(name: str, taken: Set[str]) -> str:
    """Return a name that neither a dimension has nor another variable."""
    while name in taken:
        name += "_"
    return name
