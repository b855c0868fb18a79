"""The arrays of a store: made when they are first needed, found by what they are, widened."""

import json
import os
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from itertools import product
from pathlib import Path
from typing import Any

from ....errors import GeomintError, MissingCodeError, quoted
from ...files.workplace import synced
from ...variables import optional
from ..dataset import free_name
from ..outcome import check_alike
from .columns import Column, readable

MEMBER, BLOCK, ROW = "member", "block", "row"
CHUNK = 1 << 20  # numbers: 8 MB
FIRST = ("tau", "states", "status")  # arrays that a store has from the beginning
AT_ONCE = 8  # files brought to the disk: it takes them together, in a fifth of the time
_DIMENSIONS = {MEMBER, BLOCK, ROW, "sample"}
# Zarr's own, which are read: by others the packages that have them may unpickle what is there.
_CODECS = {"bytes", "vlen-utf8", "zstd", "gzip", "blosc", "crc32c"}


def needed_zarr(what: str) -> Any:
    """Return the library zarr, or raise `MissingCodeError`."""
    zarr = optional("zarr", what, "zarr")
    if not hasattr(zarr, "create_group"):
        raise MissingCodeError(what, "needs zarr 3.1 or newer: pip install geomint[zarr]")
    return zarr


class Arrays:
    """The arrays of a store, each with the attributes `role`, `of` and `part` that say what it is.

    Parameters
    ----------
    root : Path
        Of a Zarr group.
    writing : bool

    Attributes
    ----------
    members, size : int
        How many there are in all, and in a block: a chunk of every array.

    Raises
    ------
    GeomintError
        For a store that is damaged.
    """

    def __init__(self, root: Path, writing: bool) -> None:
        self._zarr = needed_zarr("an ensemble on disk")
        self._root = root
        mode = "r+" if writing else "r"
        self._known = {}
        with readable(root), warnings.catch_warnings():
            _check_layout(root)
            warnings.simplefilter("ignore")  # about what a killed process has left in the folder
            self.group = self._zarr.open_group(os.fspath(root), mode=mode, use_consolidated=False)
            self.about = dict(self.group.attrs)
            for _, array in self.group.arrays():
                told = dict(array.attrs)
                self._known[told.get("role", ""), told.get("of", ""), told.get("part", "")] = array
            self.members, self.size = int(self.about["members"]), int(self.about["block"])
            for role in FIRST if self._known else ():  # none of one that is being made
                self._known[role, "", ""]
        self._touched: set[Path] = set()

    @property
    def folders(self) -> list[Path]:
        """Those of its arrays."""
        return [self._place(array) for array in self._known.values()]

    @property
    def blocks(self) -> int:
        """How many blocks there are."""
        return -(-self.members // self.size)

    def bounds(self, block: int) -> tuple[int, int]:
        """Return the first member of a block, and that after its last."""
        return block * self.size, min((block + 1) * self.size, self.members)

    def find(self, role: str, of: str = "", part: str = "") -> Any:
        """Return an array of the store, or None."""
        return self._known.get((role, of, part))

    def of_role(self, role: str) -> dict[tuple[str, str], Any]:
        """Return all arrays of a kind, by owner and part, in the order of their names."""
        found = {(of, part): a for (r, of, part), a in self._known.items() if r == role}
        return dict(sorted(found.items()))

    def put(self, column: Column, block: int, which: Any) -> None:
        """Write what there is of some members of a block, numbered within it."""
        array, widened = self._room_for(column), column.values.shape[1:]
        region = tuple(slice(0, n) for n in widened)
        first, last = self.bounds(block)
        if column.role == "merged":
            array[(slice(block, block + 1), *region)] = column.values
        elif len(which) == last - first:
            array[(slice(first, last), *region)] = column.values
        else:
            there = array[first:last]
            there[(which, *region)] = column.values
            array[first:last] = there
            widened = there.shape[1:]
        chunks = [range(-(-n // c)) for n, c in zip(widened, array.chunks[1:], strict=True)]
        for place in product([block], *chunks):
            self._touched.add(self._place(array) / array.metadata.encode_chunk_key(place))

    def _place(self, array: Any) -> Path:
        return self._root / str(array.path)

    def _room_for(self, column: Column) -> Any:
        """Return the array of a column, made or widened if it has to be."""
        shape, key = column.values.shape[1:], (column.role, column.of, column.part)
        if key not in self._known:
            self.make(column)
            self.gathered()
        array = self._known[key]
        if column.role in ("reading", "merged"):
            check_alike(column.of, shape, array.shape[1:], column.role == "merged")
        wider = [max(n, old) for n, old in zip(shape, array.shape[1:], strict=True)]
        if list(array.shape[1:]) != wider:
            if "sample" in column.axes:  # one axis of several arrays
                self._lengthen(wider[column.axes.index("sample")])
            else:
                array.resize((array.shape[0], *wider))
                self._touched.add(self._place(array) / "zarr.json")
            self.gathered()
        return self._known[key]

    def _lengthen(self, samples: int) -> None:
        for array in self._known.values():
            if "sample" in array.metadata.dimension_names:
                array.resize((array.shape[0], samples, *array.shape[2:]))
                self._touched.add(self._place(array) / "zarr.json")

    def make(self, column: Column, sample_chunk: int = 1) -> Any:
        """Make the array of a column, for all members; of one that names rows, for these."""
        taken = {str(array.path) for array in self._known.values()} | _DIMENSIONS
        taken |= {n for a in self._known.values() for n in a.metadata.dimension_names}
        name = free_name(column.name, taken)
        shape = list(column.values.shape[1:])
        chunks = [max(n, 1) for n in shape]
        if "sample" in column.axes:
            here, tau = column.axes.index("sample"), self.find("tau")
            chunks[here] = sample_chunk if tau is None else tau.chunks[1]
            shape[here] = max(shape[here], 0 if tau is None else tau.shape[1])
        axes = [name + axis if axis.startswith("_") else axis for axis in column.axes]
        count, size, along = self.members, self.size, MEMBER
        if column.role == "merged":
            count, size, along = self.blocks, 1, BLOCK
        elif column.role == ROW:
            count, size, along, name = len(column.values), len(column.values), ROW, ROW
        words = column.values.dtype.hasobject
        array = self.group.create_array(
            name,
            shape=(count, *shape),
            chunks=(size, *chunks),
            dtype=str if words else column.values.dtype,
            fill_value=column.fill,
            dimension_names=(along, *axes),
            chunk_key_encoding={"name": "default", "separator": "."},
            attributes={"role": column.role, "of": column.of, "part": column.part, **column.about},
        )
        self._known[column.role, column.of, column.part] = array
        self._touched.add(self._place(array) / "zarr.json")
        return array

    def gathered(self) -> None:
        """Tell readers that look at one place alone, such as xarray, which arrays there are."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that this is an agreement, not in the format
            self._zarr.consolidate_metadata(self.group.store)
        self._touched.add(self._root / "zarr.json")

    def sync(self) -> None:
        """Bring what was written to the disk: only then it may be said to be there."""
        folders = {path.parent for path in self._touched}
        with ThreadPoolExecutor(AT_ONCE) as pool:
            list(pool.map(_sync, self._touched))
            list(pool.map(synced, folders))
        self._touched.clear()


def _check_layout(root: Path) -> None:
    """Refuse a store that is not as they are written here, before the library reads any of it."""
    for place in (root, *filter(Path.is_dir, root.iterdir())):
        own = not list(place.glob(".z*"))  # of format 2
        if (place / "zarr.json").exists():
            told = json.loads((place / "zarr.json").read_text("utf-8"))
            gathered = told.get("consolidated_metadata") or {"metadata": {}}
            for node in (told, *gathered["metadata"].values()):
                own &= {codec["name"] for codec in node.get("codecs", ())} <= _CODECS
                own &= node.get("data_type", "string") in ("float64", "int64", "string")
                own &= node["zarr_format"] == 3
        if not own:
            reason = "is not read: it is not as geomint writes ensembles, in Zarr's format 3"
            raise GeomintError(f"{quoted(os.fspath(place))} {reason}")


def _sync(path: Path) -> None:
    with suppress(FileNotFoundError):  # a chunk in which nothing is: it is not written
        descriptor = os.open(path, os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
