"""A solution as named variables with named dimensions: what files, xarray and pandas are made of."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..errors import MissingCodeError
from ..watch.drift import Drift
from ..watch.windows import Windows

if TYPE_CHECKING:
    from .result import Result

__all__ = [
    "Variable",
    "drift_of",
    "optional",
    "time_of",
    "to_dataframe",
    "to_xarray",
    "variables_of",
]

WINDOWS = {"times": "mean time of a window", "means": "mean deviation from the first value",
           "maxima": "largest |deviation|"}  # fmt: skip
ENDINGS = {"times": "_time", "means": "_mean", "maxima": "_maximum"}


class Variable(NamedTuple):
    """One variable.

    Attributes
    ----------
    role, of : str
        What it is to a solution, and the name of what it belongs to there: a piece, a drift and a
        parameter may have one name.
    name : str
        No other variable of the solution has it.
    """

    role: str
    of: str
    name: str
    dimensions: tuple[str, ...]
    values: Array
    attributes: dict[str, Any]


class _Names:
    """Names of variables and dimensions, each given once: a name that is taken gets a ``_``."""

    def __init__(self) -> None:
        self._taken: set[str] = set()
        self._lengths: dict[str, int] = {}

    def free(self, name: str) -> str:
        """Return a name that nothing has, and take it."""
        while name in self._taken:
            name += "_"
        self._taken.add(name)
        return name

    def dimensions(self, shape: tuple[int, ...]) -> tuple[str, ...]:
        """Return names of dimensions of these lengths: k of vectors, i, j of matrices, or k6."""
        return tuple(
            self._dimension(name, length)
            for name, length in zip("k" if len(shape) == 1 else "ij", shape, strict=False)
        )

    def _dimension(self, name: str, length: int) -> str:
        for candidate in (name, f"{name}{length}"):
            if (
                candidate not in self._taken
                and self._lengths.setdefault(candidate, length) == length
            ):
                return candidate
        return self._dimension(f"{name}_", length)


def time_of(solution: Result) -> str:
    """Return the dimension of states: physical time, or τ where the clock was not integrated."""
    return "tau" if solution.physical is None else "t"


def variables_of(solution: Result) -> list[Variable]:
    """Return times, states, parameters and drifts as variables."""
    # Names of all variables first: no dimension of another length may have one of them.
    problem, drifts, names = solution.about, solution.drift, _Names()
    parameters = _numbers(problem.parameters)
    times = [names.free("t"), names.free("tau")]
    pieces = {name: names.free(name) for name in problem.shapes}
    watched = {name: names.free(name) for name in drifts}
    windows = {
        name: {part: names.free(name + ENDINGS[part]) for part in WINDOWS} for name in drifts
    }
    given = {name: names.free(name) for name in parameters}
    return [
        *_times(solution, times),
        *_states(solution, pieces, names),
        *itertools.chain.from_iterable(
            _drift(name, watched[name], windows[name], drift) for name, drift in drifts.items()
        ),
        *(
            Variable(
                "parameter",
                name,
                given[name],
                names.dimensions(value.shape),
                value,
                _about("parameter"),
            )
            for name, value in parameters.items()
        ),
    ]


def _about(what: str) -> dict[str, Any]:
    return {"long_name": what, "units": "1"}


def _times(solution: Result, names: list[str]) -> Iterator[Variable]:
    own = time_of(solution)
    if solution.physical is not None:
        yield Variable("time", "t", names[0], (own,), solution.physical, _about("physical time"))
    if solution.about.time == "tau":
        yield Variable(
            "time", "tau", names[1], (own,), solution.tau, _about("own time of the problem")
        )


def _states(solution: Result, names: Mapping[str, str], known: _Names) -> Iterator[Variable]:
    for name, shape in solution.about.shapes.items():
        values = solution.y[:, solution.about.slices[name]].reshape(-1, *shape)
        dimensions = (time_of(solution), *known.dimensions(shape))
        about = _about(name)
        yield Variable("piece", name, names[name], dimensions, values, about)


def _drift(name: str, own: str, parts: Mapping[str, str], drift: Drift) -> Iterator[Variable]:
    windows = drift.windows
    numbers = {f.name: getattr(drift, f.name) for f in fields(Drift)[1:] if f.name != "windows"}
    numbers |= {"length": windows.length, "samples": windows.samples, "until": windows.last_time}
    told = {key: number for key, number in numbers.items() if number is not None}
    about = {**_about(f"first value of {name}; its drift in attributes"), **told}
    yield Variable("drift", name, own, (), np.array(drift.initial), about)
    if len(windows.times):
        for part, what in WINDOWS.items():
            values = getattr(windows, part)
            yield Variable(
                part, name, parts[part], (parts["times"],), values, _about(f"{what} of {name}")
            )


def _numbers(parameters: Mapping[str, Any]) -> dict[str, Array]:
    """Return the parameters that are numbers, as arrays."""
    found = {}
    for name, value in parameters.items():
        try:
            numbers = np.asarray(value)
        except Exception:  # of a foreign object
            continue
        if numbers.dtype.kind in "iuf" and numbers.size and numbers.ndim <= 2:
            found[name] = numbers.astype(np.float64)
    return found


def drift_of(
    name: str, numbers: Mapping[str, Any], closed: list[Array], last_window: Array | None
) -> Drift:
    """Return a drift that was written: its numbers, and times, means and maxima of its windows."""
    own = {f.name: None if f.default is MISSING else f.default for f in fields(Drift)}
    own |= {name: numbers[name] for name in own if name in numbers}
    own["own_noise"] = bool(own["own_noise"])  # attributes are words and numbers
    windows = Windows.restored(
        initial=numbers["initial"],
        length=int(numbers["length"]),
        samples=int(numbers["samples"]),
        last=(numbers["until"], numbers["final_error"]),
        largest=numbers["max_abs_error"],
        not_finite_from=numbers.get("not_finite_from"),
        closed=np.array(closed) if closed else np.zeros((3, 0)),
        last_window=last_window,
    )
    return Drift(**{**own, "name": name, "windows": windows})  # type: ignore[arg-type]


def to_xarray(variables: list[Variable], about: Mapping[str, Any]) -> Any:
    """Return an `xarray.Dataset`."""
    xarray = optional("xarray", "Solution.to_xarray")
    data = {v.name: (v.dimensions, v.values, v.attributes) for v in variables}
    times = [v.name for v in variables if v.role in ("time", "times")]
    return xarray.Dataset(data, attrs=dict(about)).set_coords(times)


def to_dataframe(variables: list[Variable], about: Mapping[str, Any]) -> Any:
    """Return a `pandas.DataFrame`, a row for each state."""
    pandas = optional("pandas", "Solution.to_dataframe")
    columns = {}
    for variable in variables:
        if variable.role in ("time", "piece"):
            for index in np.ndindex(variable.values.shape[1:]):
                place = f"[{','.join(map(str, index))}]" if index else ""
                columns[variable.name + place] = variable.values[:, *index]
    frame = pandas.DataFrame(columns).set_index(variables[0].name)
    frame.attrs = dict(about)
    return frame


def optional(library: str, what: str) -> Any:
    """Return an optional library, or raise `MissingCodeError` that says how to get it."""
    import importlib

    try:
        return importlib.import_module(library)
    except ImportError as error:
        reason = f"needs {library}: pip install {library}, or geomint[notebook]"
        raise MissingCodeError(what, reason) from error
