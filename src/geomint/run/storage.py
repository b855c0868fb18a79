"""Runs on disk: NetCDF files that any tool reads, with all that is needed to make them again.

A file in the classic format with 64-bit offsets holds

=====================  ======================  ==================================================
variable               dimensions              content
=====================  ======================  ==================================================
``tau``                (state)                 own times of the saved states
``t``                  (state)                 their physical times, where they are known
``y``                  (state, row)            the states; its attribute `pieces` names the rows
``row_label``          (row, label)            such as ``gamma[0]``, as characters
``QUANTITY.time``      (QUANTITY.window)       mean time of each window of steps
``QUANTITY.mean``      (QUANTITY.window)       mean deviation from the initial value
``QUANTITY.maximum``   (QUANTITY.window)       largest absolute deviation
=====================  ======================  ==================================================

for every watched QUANTITY, whose numbers (initial value, errors, slope, class) are the attribute
`drift` of its ``mean``, as JSON. The global attribute `provenance` is JSON too; `status` and
`message` say how the run ended; `checksum` is the SHA-256 of the whole file with 64 zeros in the
place of its own digits.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.io import netcdf_file  # type: ignore[attr-defined]

from .. import __version__
from ..arguments import Array
from ..errors import DomainError, GeomintError, quoted
from ..kernels.compiling.sameness import Compared
from ..watch.drift import Drift
from ..watch.windows import Windows
from .files.outputs import whole_file
from .result import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["SavedSolution", "as_saved", "load", "load_solution", "save_solution"]

_FORMAT = "geomint-run-2"
_NO_CHECKSUM = "0" * 64
_SEAL = re.compile(rb"checksum\x00\x00\x00\x02\x00\x00\x00\x40([0-9a-f]{64})")
_HEADER = 1 << 20  # bytes: the checksum, the first attribute, is found in them
_open: Any = netcdf_file


@dataclass(frozen=True, repr=False, eq=False)
class SavedSolution(Compared):
    """A run that was read from a file.

    Attributes
    ----------
    tau, t : array, shape (m,)
        Own and physical times of the saved states; `t` is None if it was not integrated.
    y : array, shape (m, rows)
        The saved states.
    pieces : tuple of (name, rows)
        The order of a state.
    drift : dict of name to Drift
        With their windows.
    provenance : dict
        Scene, versions, method, step, costs, status.
    """

    tau: Array
    t: Array | None
    y: Array
    pieces: tuple[tuple[str, int], ...]
    drift: dict[str, Drift]
    provenance: dict[str, Any]

    def __repr__(self) -> str:
        words, end = self.provenance, f"{len(self.tau)} states"
        if len(self.tau):
            end += f" to {words.get('time', 't')} = {self.tau[-1]:.9g}"
        return (
            f"<saved solution of {words.get('problem')!r} by {words.get('method')}: {self.status}, "
            f"{end}, {len(self.drift)} drifts>"
        )

    @property
    def status(self) -> str:
        """How the run ended, as `geomint.Solution.status`."""
        return str(self.provenance.get("status"))

    @property
    def message(self) -> str:
        """Why it did not reach its end, if so."""
        return str(self.provenance.get("message", ""))

    @property
    def success(self) -> bool:
        """Whether the end was reached, and all that was observed is finite."""
        return self.status == "success"

    def piece(self, name: str) -> Array:
        """Return the saved values of one piece of the state, one a row."""
        start = 0
        for piece, rows in self.pieces:
            if piece == name:
                return self.y[:, start : start + rows]
            start += rows
        raise DomainError("piece", name, f"one of {[piece for piece, _ in self.pieces]}")

    def plot_drift(self) -> Figure:
        """Plot the drifts, as `geomint.Solution.plot_drift` does."""
        from ..plots.drift_plots import drift_figure

        label = str(self.provenance.get("method", ""))
        time = self.provenance.get("drift_time", "t")
        return drift_figure([(label, self.drift)], time, self.status)


def save_solution(
    solution: Result,
    path: str | PathLike[str],
    provenance: Mapping[str, Any] | None = None,
) -> None:
    """Write a run to a NetCDF file.

    Parameters
    ----------
    solution : Result
    path : path
        A regular file that is there is replaced, once the new one is complete; symlinks are
        followed.
    provenance : mapping, optional
        Default: all that the solution knows by itself.

    Raises
    ------
    OutputError
        If something else is there, or the file cannot be written; what was there is as it was.
    """
    if provenance is None:
        from .provenance import run_provenance

        provenance = run_provenance(solution)
    with whole_file(path) as unfinished:
        with unfinished.open("w+b") as stream:
            file = _open(stream, "w", version=2)
            file.checksum = _NO_CHECKSUM
            file.format = _FORMAT
            file.history = f"written by geomint {__version__}"
            file.status, file.message = solution.status, solution.message.encode()
            file.provenance = json.dumps(provenance)
            _write_states(file, solution)
            for name, drift in solution.drift.items():
                _write_drift(file, _packed(name), drift)
            file.flush()
        _seal(unfinished)


def as_saved(solution: Result) -> SavedSolution:
    """Return what a file of a run holds, without the file."""
    from .provenance import run_provenance

    return SavedSolution(
        tau=solution.tau,
        t=solution.physical,
        y=solution.y,
        pieces=solution.problem.pieces,
        drift=solution.drift,
        provenance=run_provenance(solution),
    )


def _seal(path: Path) -> None:
    """Put the checksum of a file into its header."""
    with path.open("r+b") as file:
        place = file.read(_HEADER).index(_NO_CHECKSUM.encode())
        file.seek(0)
        digits = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(place)
        file.write(digits.encode())


def _check_seal(path: Path) -> None:
    """Refuse a file that is not what was written, before anything in it is believed."""
    name = fspath(path)
    if path.exists() and not path.is_file():
        raise GeomintError(f"{name!r} holds no run of geomint: it is no regular file")
    with path.open("rb") as file:
        header = file.read(_HEADER)
        found = _SEAL.search(header)
        if found is None:
            if b"geomint-run-1" in header:
                raise GeomintError(f"{name!r} is of an earlier geomint, without a checksum")
            raise GeomintError(f"{name!r} holds no run of geomint")
        start, end = found.span(1)
        digest = hashlib.sha256(header[:start] + _NO_CHECKSUM.encode() + header[end:])
        while block := file.read(_HEADER):
            digest.update(block)
    if digest.hexdigest().encode() != found[1]:
        raise GeomintError(f"{name!r} is not what was written: its checksum differs")


def _packed(name: str) -> str:
    """Return a name as scipy has to have it so that its UTF-8 is in the file."""
    return name.encode().decode("latin-1")


def _unpacked(name: str) -> str:
    return name.encode("latin-1").decode()


def _write_states(file: Any, solution: Result) -> None:
    labels = [
        f"{name}[{i}]" for name, rows in solution.problem.pieces for i in range(rows)
    ]  # fmt: skip
    width = max(len(label.encode()) for label in labels)
    file.createDimension("state", len(solution.tau))
    file.createDimension("row", len(labels))
    file.createDimension("label", width)
    _write(file, "tau", solution.tau, ("state",), "own time of the problem")
    if solution.physical is not None:
        _write(file, "t", solution.physical, ("state",), "physical time")
    y = _write(file, "y", solution.y, ("state", "row"), "states")
    y.pieces = json.dumps([[name, rows] for name, rows in solution.problem.pieces])
    characters = file.createVariable("row_label", "c", ("row", "label"))
    padded = [list(label.encode().ljust(width, b"\0")) for label in labels]
    characters[:] = np.array(padded, dtype=np.uint8).view("S1")


def _write_drift(file: Any, name: str, drift: Drift) -> None:
    windows = drift.windows
    dimension = f"{name}.window"
    file.createDimension(dimension, len(windows.times))
    _write(file, f"{name}.time", windows.times, (dimension,), "mean time of the window")
    _write(file, f"{name}.maximum", windows.maxima, (dimension,), "largest |deviation|")
    mean = _write(file, f"{name}.mean", windows.means, (dimension,), "mean deviation")
    numbers = drift.as_json()
    mean.drift = json.dumps({**numbers, "length": windows.length})


def _write(file: Any, name: str, values: Array, dimensions: tuple[str, ...], about: str) -> Any:
    variable = file.createVariable(name, "d", dimensions)
    variable[:] = values
    variable.long_name = about
    variable.units = "1"
    return variable


def load_solution(path: str | PathLike[str]) -> SavedSolution:
    """Read a run that `save_solution` wrote.

    Raises
    ------
    GeomintError
        If the file is none, not complete, or not what was written.
    FileNotFoundError
    """
    if not isinstance(path, str | PathLike):
        raise DomainError("path", path, "the path of a file")
    place = Path(path)
    try:
        _check_seal(place)
    except ValueError:  # a null byte, half of a pair
        raise DomainError("path", path, "the path of a file") from None
    try:
        with _open(fspath(place), "r", mmap=False) as file:
            return _read(file)
    except (TypeError, ValueError, KeyError, AttributeError, IndexError) as error:
        reason = quoted(error)  # of a writer with another idea of the content
        raise GeomintError(f"{fspath(place)!r} cannot be read as a run: {reason}") from error


load = load_solution


def _read(file: Any) -> SavedSolution:
    variables = file.variables
    pieces = tuple((str(name), int(rows)) for name, rows in json.loads(variables["y"].pieces))
    names = [key.removesuffix(".mean") for key in variables if key.endswith(".mean")]
    return SavedSolution(
        tau=_array(variables["tau"]),
        t=_array(variables["t"]) if "t" in variables else None,
        y=_array(variables["y"]),
        pieces=pieces,
        drift={_unpacked(name): _read_drift(variables, name) for name in names},
        provenance=json.loads(file.provenance),
    )


def _read_drift(variables: Any, name: str) -> Drift:
    numbers = json.loads(variables[f"{name}.mean"].drift)
    windows = Windows.restored(
        initial=numbers["initial"],
        length=numbers.pop("length"),
        samples=numbers.pop("samples"),
        last=(numbers.pop("until"), numbers["final_error"]),
        largest=numbers["max_abs_error"],
        not_finite_from=numbers.get("not_finite_from"),
        closed=np.array(
            [_array(variables[f"{name}.{part}"]) for part in ("time", "mean", "maximum")]
        ),
    )
    return Drift(name=_unpacked(name), drift_class=numbers.pop("class"), windows=windows, **numbers)


def _array(variable: Any) -> Array:
    return np.array(variable[:], dtype=np.float64)
