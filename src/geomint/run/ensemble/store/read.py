"""What a store holds of members: read when it is asked for, not before."""

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from ....arguments import Array, Integers
from ....errors import GeomintError, GeomintWarning, UnknownNameError
from ...met import Met
from ..outcome import NOT_RUN
from .arrays import Arrays
from .columns import error_of, numbers_in, readable, words_in

R = TypeVar("R")


class StoredOutcome:
    """What has become of members, as `geomint.run.ensemble.outcome.Outcome` has it: from the disk.

    Nothing is kept: every look reads. Attributes are those of `Outcome`.
    """

    def __init__(self, arrays: Arrays) -> None:
        self.arrays = arrays

    def _numbers(self, role: str) -> Array:
        array = self.arrays.find(role)
        if array is None:  # nothing has been written yet
            tau, states = self.arrays.find("tau"), self.arrays.find("states")
            shape = (*tau.shape, states.shape[1]) if role == "y" else tau.shape
            return np.full(shape, np.nan)
        return numbers_in(array)

    def _counted(self, role: str) -> Integers:
        array = self.arrays.find(role)
        return np.zeros(self.arrays.members, np.int64) if array is None else numbers_in(array)

    @property
    def tau(self) -> Array:
        """Times of the saved states, the problems' own."""
        return self._numbers("tau")

    @property
    def physical(self) -> Array:
        """Physical times."""
        return self._numbers("t")

    @property
    def y(self) -> Array:
        """The saved states."""
        return self._numbers("y")

    @property
    def error_estimate(self) -> Array | None:
        """How far they are from the motion."""
        array = self.arrays.find("error_estimate")
        return None if array is None else numbers_in(array)

    @property
    def counts(self) -> Integers:
        """How many states of each were saved."""
        return self._counted("counts")

    @property
    def steps(self) -> Integers:
        """How many steps each took."""
        return self._counted("steps")

    @property
    def status(self) -> npt.NDArray[np.object_]:
        """How each ended."""
        return words_in(self.arrays.find("status"))

    @property
    def errors(self) -> dict[int, GeomintError]:
        """What ended members before their ends."""
        return self._told("error", error_of)

    @property
    def warnings(self) -> dict[int, tuple[GeomintWarning, ...]]:
        """What members have to say."""
        return self._told("warnings", lambda x: tuple(map(GeomintWarning.read, json.loads(x))))

    def _told(self, role: str, read: Callable[[str], R]) -> dict[int, R]:
        """Return what members have said in words, of those that have."""
        array = self.arrays.find(role)
        if array is None:
            return {}
        told = words_in(array)
        with readable(array.store_path):
            return {int(k): read(told[k]) for k in np.flatnonzero(told != "")}

    @property
    def readings(self) -> Mapping[str, Array]:
        """What was read off, each read when it is asked for."""
        return _Readings(self.arrays)

    @property
    def final(self) -> Array:
        """The last state of every member, found block by block."""
        counts, array = self.counts, self.arrays.find("y")
        final = np.full((self.arrays.members, self.arrays.find("states").shape[1]), np.nan)
        for block in range(self.arrays.blocks) if array is not None else ():
            first, last = self.arrays.bounds(block)
            of = np.maximum(counts[first:last] - 1, 0)
            here = numbers_in(array, slice(first, last))
            final[first:last] = here[np.arange(last - first), of]
        return final

    def met(self) -> dict[str, list[Met | None]]:
        """Return of each event what there is of it, member by member."""
        arrays = self.arrays.of_role("event")
        found = {}
        for name, part in arrays:
            if part != "met":
                continue
            counts = numbers_in(arrays[name, "count"])
            table, timed = numbers_in(arrays[name, part]), arrays[name, part].attrs["timed"]
            found[name] = [
                None if n < 0 else Met.of_table(table[k, :n], timed) for k, n in enumerate(counts)
            ]
        return found

    def drifts(self) -> dict[str, dict[str, Any]]:
        """Return of each observed quantity arrays over the members."""
        found: dict[str, dict[str, Any]] = {}
        for (name, part), array in self.arrays.of_role("drift").items():
            words = part == "class"
            found.setdefault(name, {})[part] = (
                words_in(array).astype(str) if words else numbers_in(array)
            )
        return found


class _Readings(Mapping[str, Array]):
    """Readings by names, of which the one that is asked for is read."""

    def __init__(self, arrays: Arrays) -> None:
        self._arrays = arrays
        self._own = {name: array for (name, _), array in arrays.of_role("reading").items()}
        self._merged = {name: array for (name, _), array in arrays.of_role("merged").items()}

    def __getitem__(self, name: str) -> Array:
        if name in self._merged:
            return _sum(self._arrays, self._merged[name])
        if name not in self._own:
            raise UnknownNameError("readings", name, self)
        return numbers_in(self._own[name])

    def __iter__(self) -> Iterator[str]:
        return iter((*self._own, *self._merged))

    def __len__(self) -> int:
        return len(self._own) + len(self._merged)


def _sum(arrays: Arrays, array: Any) -> Array:
    """Return the sum over blocks that are done, in their order."""
    status = words_in(arrays.find("status"))
    total = np.zeros(array.shape[1:])
    for block in range(arrays.blocks):
        if status[arrays.bounds(block)[0]] != NOT_RUN:  # else what is there may be half written
            total = total + numbers_in(array, block)
    return total
