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
`drift` of its ``mean``, as JSON. The global attribute `provenance` is JSON too.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from scipy.io import netcdf_file  # type: ignore[attr-defined]

from . import __version__
from .drift import Drift
from .errors import DomainError, GeomintError
from .windows import Windows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .solution import Solution

__all__ = ["SavedSolution", "load", "load_solution", "save_solution"]

Array = npt.NDArray[np.float64]
_FORMAT = "geomint-run-1"
_open: Any = netcdf_file


@dataclass(frozen=True)
class SavedSolution:
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
        from .report.plots import drift_figure

        label = str(self.provenance.get("method", ""))
        return drift_figure([(label, self.drift)], self.provenance.get("drift_time", "t"))


def save_solution(
    solution: Solution,
    path: str | PathLike[str],
    provenance: Mapping[str, Any] | None = None,
) -> None:
    """Write a run to a NetCDF file.

    Parameters
    ----------
    solution : Solution
    path : path
        Replaced if it is there, once the new file is complete.
    provenance : mapping, optional
        Default: all that the solution knows by itself.
    """
    if provenance is None:
        from .report.provenance import run_provenance

        provenance = run_provenance(solution)
    target = Path(path)
    unfinished = target.with_name(target.name + ".part")
    try:
        with _open(fspath(unfinished), "w", version=2) as file:
            file.format = _FORMAT
            file.history = f"written by geomint {__version__}"
            file.provenance = json.dumps(provenance)
            _write_states(file, solution)
            for name, drift in solution.drift.items():
                _write_drift(file, name, drift)
        unfinished.replace(target)
    finally:
        unfinished.unlink(missing_ok=True)


def _write_states(file: Any, solution: Solution) -> None:
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
        If the file is none, or not complete.
    FileNotFoundError
    """
    try:
        with _open(fspath(path), "r", mmap=False) as file:
            if getattr(file, "format", b"").decode() != _FORMAT:
                raise GeomintError(f"{fspath(path)!r} holds no run of geomint")
            return _read(file)
    except (TypeError, ValueError, KeyError, AttributeError, IndexError) as error:
        raise GeomintError(f"{fspath(path)!r} cannot be read as a run: {error}") from error


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
        drift={name: _read_drift(variables, name) for name in names},
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
    return Drift(name=name, kind=numbers.pop("class"), windows=windows, **numbers)


def _array(variable: Any) -> Array:
    return np.array(variable[:], dtype=np.float64)
