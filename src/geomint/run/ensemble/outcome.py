"""What has become of some members of an ensemble."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ...arguments import MOST_NUMBERS, Array, Integers
from ...errors import DomainError, GeomintError, GeomintWarning

NOT_RUN, INTERRUPTED = "not run", "interrupted"
ENDED_EARLY = ("failed", INTERRUPTED, NOT_RUN)  # what members are that have no readings
DRIFT_NUMBERS = (
    "initial", "max_abs_error", "final_error", "scale", "slope", "slope_stderr", "trend_bound",
)  # fmt: skip


@dataclass(eq=False)
class Outcome:
    """Results with an axis of members; NaN where there is nothing.

    Attributes
    ----------
    tau, physical : array, shape (members, samples)
        Times of the saved states, the problem's own and physical.
    y : array, shape (members, samples, rows)
    counts, steps : array of int, shape (members,)
        How many states were saved, and steps taken.
    status : array of str, shape (members,)
    errors : dict of int to GeomintError
        What ended a member before its end.
    warnings : dict of int to tuple of GeomintWarning
    drift, events : dict of int to dict
        Of members that have some, as in `geomint.Solution`.
    error_estimate : array, shape (members, samples, rows), or None
    readings : dict of str to array
        What was read off, by names: with an axis of members, or added up over them.
    cut : bool
        Whether it was ended before all was read off.
    """

    tau: Array
    physical: Array
    y: Array
    counts: Integers
    steps: Integers
    status: npt.NDArray[np.object_]
    errors: dict[int, GeomintError] = field(default_factory=dict)
    warnings: dict[int, tuple[GeomintWarning, ...]] = field(default_factory=dict)
    drift: dict[int, dict[str, Any]] = field(default_factory=dict)
    events: dict[int, dict[str, Any]] = field(default_factory=dict)
    error_estimate: Array | None = None
    readings: dict[str, Array] = field(default_factory=dict)
    cut: bool = False

    @property
    def samples(self) -> int:
        """Room for states of each member."""
        return int(self.tau.shape[1])

    @property
    def final(self) -> Array:
        """The last state of every member; NaN of those that have none."""
        return self.last_of(self.y)

    def last_of(self, values: Array) -> Array:
        """Return what every member has where its last state is, of values at all samples."""
        return values[np.arange(len(self.tau)), np.maximum(self.counts - 1, 0)]

    def met(self) -> dict[str, list[Any]]:
        """Return of each event what there is of it, member by member."""
        names = dict.fromkeys(name for of in self.events.values() for name in of)
        count = len(self.tau)
        return {n: [self.events.get(k, {}).get(n) for k in range(count)] for n in names}

    def drifts(self) -> dict[str, dict[str, Any]]:
        """Return of each observed quantity arrays over the members."""
        names = dict.fromkeys(name for of in self.drift.values() for name in of)
        return {name: self._drift(name) for name in names}

    def _drift(self, name: str) -> dict[str, Any]:
        own = [self.drift.get(k, {}).get(name) for k in range(len(self.tau))]
        found = {}
        for key in DRIFT_NUMBERS:
            values = [getattr(d, key, None) for d in own]
            found[key] = np.array([np.nan if v is None else v for v in values])
        found["class"] = np.array(["" if d is None else d.drift_class for d in own])
        return found

    def of(self, which: Integers) -> Outcome:
        """Return some of the members, of which nothing is added up."""
        estimate = self.error_estimate
        found = Outcome(
            self.tau[which],
            self.physical[which],
            self.y[which],
            self.counts[which],
            self.steps[which],
            self.status[which],
            error_estimate=None if estimate is None else estimate[which],
            readings={name: values[which] for name, values in self.readings.items()},
        )
        for name in ("errors", "warnings", "drift", "events"):
            own, new = getattr(self, name), getattr(found, name)
            new.update((i, own[k]) for i, k in enumerate(which.tolist()) if k in own)
        return found

    def widened(self, samples: int) -> None:
        """Make room for more states of each member."""
        more = samples - self.samples
        if more <= 0:
            return
        check_room(len(self.tau), samples, self.y.shape[2])
        for name in ("tau", "physical", "y", "error_estimate"):
            values = getattr(self, name)
            if values is not None:
                wide = [(0, 0), (0, more)] + [(0, 0)] * (values.ndim - 2)
                setattr(self, name, np.pad(values, wide, constant_values=np.nan))

    def keep_last(self) -> None:
        """Forget all states but the last of each member."""
        for name in ("tau", "physical", "y", "error_estimate"):
            values = getattr(self, name)
            if values is not None:
                setattr(self, name, self.last_of(values)[:, None])
        self.counts = np.minimum(self.counts, 1)

    def take(self, which: Integers, other: Outcome) -> None:
        """Take what has become of some members from elsewhere."""
        self.widened(other.samples)
        here = slice(0, other.samples)
        self.tau[which, here], self.physical[which, here] = other.tau, other.physical
        self.y[which, here] = other.y
        self.counts[which], self.steps[which] = other.counts, other.steps
        if other.error_estimate is not None:
            if self.error_estimate is None:
                self.error_estimate = np.full_like(self.y, np.nan)
            self.error_estimate[which, here] = other.error_estimate
        self.status[which] = other.status
        for name in ("errors", "warnings", "drift", "events"):
            getattr(self, name).update((int(which[i]), x) for i, x in getattr(other, name).items())

    def take_readings(self, which: Integers, other: Outcome, merged: Set[str]) -> None:
        """Take what was read off some members elsewhere; what is `merged` is added up."""
        for name, values in other.readings.items():
            adds, before = name in merged, self.readings.get(name, values)
            first = 0 if adds else 1  # without the axis of members
            check_alike(name, values.shape[first:], before.shape[first:], adds)
            if adds:
                self.readings[name] = (
                    self.readings[name] + values if name in self.readings else values
                )
                continue
            if name not in self.readings:
                shape = (len(self.tau), *values.shape[1:])
                check_room(1, 1, int(np.prod(shape)))
                self.readings[name] = np.full(shape, np.nan)
            own = self.readings[name]
            wide = [
                (0, max(new - old, 0)) for new, old in zip(values.shape, own.shape, strict=True)
            ]
            wide[0] = (0, 0)
            if any(more for _, more in wide):  # such as one with more points than others
                own = self.readings[name] = np.pad(own, wide, constant_values=np.nan)
            here: Any = (which, *(slice(0, size) for size in values.shape[1:]))
            own[here] = values


def check_alike(name: str, shape: tuple[int, ...], before: tuple[int, ...], adds: bool) -> None:
    """Raise `DomainError` for a reading that cannot stand beside what it was for other members.

    What is added up has one shape, what is not one number of axes: it may be longer for some.
    """
    if len(shape) != len(before) or (adds and shape != before):
        expected = f"an array of shape {before} as of other members"
        raise DomainError(f"readings[{name!r}]", shape, expected)


def check_room(members: int, samples: int, rows: int) -> None:
    """Raise `DomainError` for more saved states than there is room for."""
    if members * samples * rows > MOST_NUMBERS:
        most = MOST_NUMBERS // (members * rows)
        expected = f"at most {most} of each of {members} members"
        raise DomainError("saved states", samples, expected)


def empty_outcome(members: int, rows: int) -> Outcome:
    """Return what is known of members that have not been run, with room for a state of each."""
    whole = np.zeros(members, dtype=np.int64)
    return Outcome(
        tau=np.full((members, 1), np.nan),
        physical=np.full((members, 1), np.nan),
        y=np.full((members, 1, rows), np.nan),
        counts=whole,
        steps=whole.copy(),
        status=np.full(members, NOT_RUN, dtype=object),
    )
