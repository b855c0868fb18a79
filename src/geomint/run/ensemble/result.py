"""What `geomint.solve_ensemble` returns: arrays with an axis of members."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arguments import Array, Integers, piece_rows, whole
from ...errors import ByName, DomainError, GeomintError, GeomintWarning, MissingCodeError
from ...problems.problem import Problem
from ...problems.shown import Shown
from ..reported import Reported
from ..solution import Solution
from ..solve import solve
from .dataset import as_dataset
from .given import Asked, Members
from .growth import EnsembleGrowth, growth_of_ensemble
from .outcome import Outcome
from .store.read import StoredOutcome


@dataclass(repr=False, eq=False)
class Ensemble(Shown, Reported):
    """The result of `geomint.solve_ensemble`: N members, one a row of every array.

    One with `out` is on disk: each of the arrays below is read when it is asked for, and not kept;
    `stored` reads parts of them.

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
    warnings : dict of int to tuple of GeomintWarning
        What members have to say, by their numbers, as `geomint.Solution.warnings`.
    events : dict of name to list of Met
        Of each event what `geomint.Solution` has of it, member by member.
    error_estimate : array, shape (N, m, rows), or None
        As that of `geomint.Solution`.
    readings : mapping of str to array
        What was read off: of each member a number or an array of them, NaN for those that have not
        come to their ends; histograms have no axis of members.
    run_seconds : float
        Wall time of all members together; of those of the last call.
    stored : zarr.Group or None
    """

    given: Members
    asked: Asked
    found: Outcome | StoredOutcome
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
    def counts(self) -> Integers:
        """How many states of each were saved."""
        return self.found.counts

    @property
    def steps(self) -> Integers:
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
    def warnings(self) -> Mapping[int, tuple[GeomintWarning, ...]]:
        """What members have to say, by their numbers."""
        return self.found.warnings

    @property
    def warned(self) -> npt.NDArray[np.str_]:
        """A column of kinds of warnings, such as ``"EndWarning StepWarning"``; most are empty."""
        kinds = np.full(len(self), "", dtype=object)
        for k, told in self.warnings.items():
            kinds[k] = " ".join(sorted({w.kind for w in told}))
        return kinds.astype(str)

    @property
    def error_estimate(self) -> Array | None:
        """How far the saved states are from the motion, if that was asked for."""
        return self.found.error_estimate

    @property
    def readings(self) -> Mapping[str, Array]:
        """What was read off every member, by names."""
        found = self.found.readings
        return found if self.stored is not None else ByName(found, "readings")

    @property
    def stored(self) -> Any:
        """The Zarr group of an ensemble on disk, of which parts can be read: ``stored["y"][:5]``."""
        return self.found.arrays.group if isinstance(self.found, StoredOutcome) else None

    @property
    def success(self) -> bool:
        """Whether every member got to its end."""
        return bool((self.found.status == "success").all())

    @property
    def final(self) -> Array:
        """The last state of every member, shape (N, rows); NaN of those that have none."""
        return self.found.final

    def piece(self, name: str) -> Array:
        """Return a piece of the saved states by its name, shape (N, m, numbers)."""
        return self.y[:, :, piece_rows(self.problems[0].slices, name)]

    @property
    def events(self) -> dict[str, list[Any]]:
        """Of each event what there is of it, member by member."""
        return ByName(self.found.met(), "events")

    @property
    def drift(self) -> dict[str, dict[str, Any]]:
        """Of each observed quantity arrays over the members: what `geomint.Drift` says of it."""
        return ByName(self.found.drifts(), "drift")

    def single(self, member: int, **more: Any) -> Solution:
        """Return the run of one member alone, to the same bits, with more arguments of `geomint.solve`.

        Raises
        ------
        DomainError
            For a number that no member has.
        StepError
            Where the member fails.
        MissingCodeError
            Of an ensemble of `geomint.open_ensemble`.
        """
        k = whole("member", member, 0, len(self) - 1)
        problem = self.given.problem(k)
        if not isinstance(problem, Problem):  # of `geomint.open_ensemble`
            reason = "a store has no code: solve_ensemble with the same arguments and out gives it"
            raise MissingCodeError(f"problem {problem.name!r}", reason)
        return solve(problem, self.states[k], **{**self.asked.arguments(), **more})

    def growth(self, name: str, since: float = 0.0, seed: int = 0) -> EnsembleGrowth:
        """Return how the deviation of a quantity grows over the members: rms ~ t^b, with b's error.

        Parameters
        ----------
        name : str
            Of a quantity, or of a reading, by `geomint.Windows`.
        since : float
            Windows that begin before that time, from the beginning, are left out.
        seed : int
            Of the samples of members that the error is found by.

        Raises
        ------
        DomainError
            Without such a reading, for fewer than eight members at their ends or eight windows, and for
            adaptive steps without `t_eval` or `tau_eval`.
        """
        return growth_of_ensemble(self, name, since, seed)

    def to_xarray(self) -> Any:
        """Return times, pieces and drifts as an `xarray.Dataset` with the dimension ``member``.

        Raises
        ------
        MissingCodeError
            Without the library xarray.
        """
        return as_dataset(self)

    def _shown(self) -> tuple[str, dict[str, Any]]:
        names, counts = np.unique(self.status, return_counts=True)
        seconds = self.run_seconds
        return f"ensemble of {len(self)} × {self.problems[0].name!r} by {self.asked.method.name}", {
            "status": ", ".join(f"{n} {s}" for s, n in zip(names, counts, strict=True)),
            "states": f"{int(self.counts.max(initial=0))} a member",
            "steps": f"{int(self.steps.sum())}{f' in {seconds:.3g} s' if seconds else ''}",
        }
