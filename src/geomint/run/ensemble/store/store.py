"""An ensemble that is written to disk as it comes, and goes on where it was broken off.

One process writes, the one that called `geomint.solve_ensemble`; workers send it their blocks. Every
array has its chunks along the members, one for each block, so that no two blocks share a file. The
status of a block's members is written last, when all else is on the disk: who finds it finds the rest.
"""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ....arguments import Integers
from ....errors import DomainError, OutputError
from ....problems.problem import Problem
from ...files.outputs import check_folder, refused_as_output
from ...files.workplace import held, synced, undisturbed, workplace
from ..given import Asked, Members
from ..outcome import INTERRUPTED, NOT_RUN, Outcome, empty_outcome
from ..spread import block_size, expected_samples
from .arrays import CHUNK, ROW, Arrays, needed_zarr
from .columns import Column, columns_of, status_of, words_in
from .identity import about, differences, identity, is_store
from .read import StoredOutcome

UNDONE = (NOT_RUN, INTERRUPTED)
NAMED = 4096  # rows: of more nobody asks by name


class Store:
    """Where the members of an ensemble go."""

    def __init__(
        self,
        out: str | PathLike[str],
        given: Members,
        asked: Asked,
        workers: int,
        ends: ExitStack,
    ) -> None:
        # What messages name; the other stays where it is if the process goes to another folder.
        self._named, path = out, Path(os.path.realpath(out))
        self._path, self._given, self._asked = path, given, asked
        self._workers, self._ends = workers, ends
        self._identity = identity(given, asked)
        self._arrays: Arrays | None = None
        self._status = np.full(len(given), NOT_RUN, dtype=object)
        self.size = 1
        if path.exists() and any(path.iterdir()):
            self._go_on()

    @property
    def fresh(self) -> bool:
        """Whether no member is done."""
        return bool(np.isin(self._status, UNDONE).all())

    @property
    def left(self) -> Integers:
        """The numbers of members that are to be run."""
        return np.flatnonzero(np.isin(self._status, UNDONE))

    @property
    def found(self) -> Any:
        """What there is, to be read when it is asked for."""
        if self._arrays is None:
            return empty_outcome(len(self._given), self._given.states.shape[1])
        return StoredOutcome(self._arrays)

    def begin(self) -> None:
        """Make the store, if it is not there."""
        if self._arrays is not None:
            return
        self.size = block_size(self._asked, self._given, self._workers)
        with refused_as_output(self._named), workplace(self._path.parent) as place:
            if self._path.exists() and self._path.samefile(os.curdir):
                raise OutputError(self._named, "that is the current folder; expected another one")
            self._make(place / "new")
            with undisturbed():
                try:
                    os.rename(place / "new", self._path)  # takes the place of an empty folder too
                except FileExistsError:
                    raise OutputError(self._named, "somebody has just made it") from None
                synced(self._path.parent)
        self._hold()

    def _hold(self) -> None:
        self._ends.enter_context(held(self._path, self._named))
        self._arrays = Arrays(self._path, writing=True)

    def take(self, which: Integers, found: Outcome) -> None:
        """Write what has become of some members of one block, as far as it is whole."""
        assert self._arrays is not None
        done = ~np.isin(found.status.astype(str), UNDONE)
        block = int(which[0]) // self.size
        first, last = self._arrays.bounds(block)
        merges = any(reading.merges for reading in self._asked.readings.values())
        if found.cut and self._asked.readings:  # some may lack what would have been read off them
            return
        if not done.any() or (merges and not (done.all() and len(which) == last - first)):
            return  # sums are of whole blocks
        if not done.all():
            which, found = which[done], found.of(np.flatnonzero(done))
        with refused_as_output(self._named), undisturbed():
            self._write(block, which - first, found)
        self._status[which] = found.status

    def _write(self, block: int, which: Integers, found: Outcome) -> None:
        assert self._arrays is not None
        for column in columns_of(found, self._asked):
            self._arrays.put(column, block, which)
        self._arrays.sync()
        self._arrays.put(status_of(found.status), block, which)
        self._arrays.sync()

    def _go_on(self) -> None:
        """See whether what is there is this ensemble, and how much of it is done."""
        if not is_store(self._path):
            raise OutputError(self._named, "it holds something else, which is left alone")
        self._hold()
        arrays = self._arrays
        assert arrays is not None
        told = differences(arrays.about.get("identity", {}), self._identity)
        if told:
            reason = f"another ensemble is there, which is left alone: they differ in {told}"
            raise OutputError(self._named, reason)
        for folder in arrays.folders:
            for left in folder.glob(f"*.{'[0-9a-f]' * 32}.partial"):
                if left.is_file() and not left.is_symlink():  # of zarr, in a writer that was killed
                    left.unlink(missing_ok=True)
        self.size = arrays.size
        arrays.gathered()
        for block in range(arrays.blocks):
            first, last = arrays.bounds(block)
            try:
                self._status[first:last] = words_in(arrays.find("status"), slice(first, last))
            except Exception:  # a file that power has left half written: the block is not done
                name = arrays.find("status").metadata.encode_chunk_key((block,))
                (self._path / "status" / name).unlink(missing_ok=True)

    def _make(self, place: Path) -> None:
        """Write the store of an ensemble of which nothing is done."""
        told = about(self._given, self._asked)
        told |= {"block": self.size, "identity": self._identity}
        needed_zarr("out").create_group(os.fspath(place), attributes=told)
        arrays = Arrays(place, writing=True)
        rows = self._given.states.shape[1]
        if rows <= NAMED:
            names = _row_names(self._given.problem(0))
            arrays.make(Column(ROW, names, fill=""))[:] = names
        arrays.make(status_of(self._status[:1]))
        samples = expected_samples(self._asked, self._given) if self._asked.keep_states else 1
        chunk = max(min(samples, CHUNK // (self.size * rows)), 1)
        arrays.make(Column("tau", np.zeros((1, 1)), ("sample",)), chunk)
        arrays.make(Column("states", self._given.states, (ROW,)))[:] = self._given.states
        for name, values in self._given.differing().items():
            arrays.make(Column("parameter", values, of=name))[:] = values
        arrays.gathered()


def _row_names(problem: Problem) -> npt.NDArray[np.object_]:
    """Return the rows of a state as readings and events name them."""
    names = [
        name if rows == 1 else f"{name}[{i}]" for name, rows in problem.pieces for i in range(rows)
    ]
    return np.array(names, dtype=object)


@contextmanager
def store_at(
    out: str | PathLike[str], given: Members, asked: Asked, workers: int
) -> Iterator[Store]:
    """Give the store of an ensemble, a new one or that which is there.

    Raises
    ------
    DomainError, OutputError
        If nothing can be written there, or there is something else, another ensemble, another writer.
    MissingCodeError
        Without the library zarr.
    """
    needed_zarr("out")
    if isinstance(out, str) and "://" in out:
        raise DomainError("out", out, "a folder of this machine")
    with ExitStack() as ends:
        with refused_as_output(out):
            path = Path(os.path.realpath(out))
            check_folder(path if os.path.lexists(path) else path.parent)
            store = Store(out, given, asked, workers, ends)
        yield store
