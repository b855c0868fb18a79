"""Where the members of an ensemble go: to memory, or to a store on disk."""

from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from typing import Any, Protocol

import numpy as np

from ...arguments import Integers
from .given import Asked, Members
from .outcome import NOT_RUN, Outcome, empty_outcome
from .spread import block_size


class Place(Protocol):
    """Takes what has become of members, block by block."""

    @property
    def fresh(self) -> bool:
        """Whether no member is done."""

    @property
    def left(self) -> Integers:
        """The numbers of members that are to be run."""

    @property
    def size(self) -> int:
        """How many members a block has, once it has begun."""

    @property
    def found(self) -> Any:
        """All that there is."""

    def begin(self) -> None:
        """Make ready, when it is known that there is something to be run."""

    def take(self, which: Integers, found: Outcome) -> None:
        """Take what has become of some members of one block."""


class Memory:
    """Arrays for all members."""

    fresh = True

    def __init__(self, given: Members, asked: Asked, workers: int) -> None:
        self._asked, self._given, self._workers = asked, given, workers
        self._merged = {name for name, reading in asked.readings.items() if reading.merges}
        self.size = 1
        self.found = empty_outcome(len(given), given.states.shape[1])

    @property
    def left(self) -> Integers:
        """The numbers of members that are to be run."""
        return np.flatnonzero(self.found.status == NOT_RUN)

    def begin(self) -> None:
        """Choose the size of blocks."""
        self.size = block_size(self._asked, self._given, self._workers)

    def take(self, which: Integers, found: Outcome) -> None:
        """Take what has become of some members."""
        self.found.take(which, found)
        self.found.take_readings(which, found, self._merged)


@contextmanager
def place_for(
    out: str | PathLike[str] | None, given: Members, asked: Asked, workers: int
) -> Iterator[Place]:
    """Give the place of an ensemble, see `geomint.run.ensemble.store.store`."""
    if out is None:
        yield Memory(given, asked, workers)
        return
    from .store.store import store_at

    with store_at(out, given, asked, workers) as store:
        yield store
