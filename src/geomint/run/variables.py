"""A solution as named variables with named dimensions: what files, xarray and pandas are made of."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import Array
from ..errors import MissingCodeError
from ..problems.problem import Time
from ..watch.drift import Drift

if TYPE_CHECKING:
    from .result import Result

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


class _Unnamed(NamedTuple):
    """A variable before it has a name: the one that it should have.

    `along` is role and owner of the variable whose name its first dimension has. What has no values
    takes its name all the same.
    """

    role: str
    of: str
    name: str
    values: Array | None
    about: str
    along: tuple[str, str] | None = None
    numbers: Mapping[str, Any] = {}


def time_of(solution: Result) -> Time:
    """Return the dimension of states: physical time, or τ where the clock was not integrated."""
    return "tau" if solution.physical is None else "t"


def variables_of(solution: Result) -> list[Variable]:
    """Return times, states, parameters and drifts as variables.

    A name that is taken gets a ``_``, and no dimension of another length has the name of a variable.
    """
    drifts = [list(_drift(name, drift)) for name, drift in solution.drift.items()]
    given = [
        _Unnamed("parameter", name, name, value, "parameter")
        for name, value in _numbers(solution.about.parameters).items()
    ]
    before = [*_times(solution), *_states(solution)]
    firsts, windows = [own[0] for own in drifts], [w for own in drifts for w in own[1:]]
    names: dict[tuple[str, str], str] = {}
    for one in (*before, *firsts, *windows, *given):
        name = one.name
        while name in names.values():
            name += "_"
        names[one.role, one.of] = name
    lengths = dict.fromkeys(names.values(), 0)  # of dimensions
    return [
        _named(one, names, lengths)
        for one in (*before, *itertools.chain(*drifts), *given)
        if one.values is not None
    ]


def _named(
    one: _Unnamed, names: Mapping[tuple[str, str], str], lengths: dict[str, int]
) -> Variable:
    """Return a variable with its name, and names for its dimensions: k of vectors, i, j of matrices."""
    assert one.values is not None
    dimensions: tuple[str, ...] = () if one.along is None else (names[one.along],)
    shape = one.values.shape[len(dimensions) :]
    for letter, length in zip("k" if len(shape) == 1 else "ij", shape, strict=False):
        letters = (letter + "_" * n for n in itertools.count())
        tried = (name for x in letters for name in (x, f"{x}{length}"))
        dimensions += (next(name for name in tried if lengths.setdefault(name, length) == length),)
    about = {"long_name": one.about, "units": "1", **one.numbers}
    return Variable(one.role, one.of, names[one.role, one.of], dimensions, one.values, about)


def _times(solution: Result) -> Iterator[_Unnamed]:
    tau = solution.tau if solution.about.time == "tau" else None
    along = "time", time_of(solution)
    yield _Unnamed("time", "t", "t", solution.physical, "physical time", along)
    yield _Unnamed("time", "tau", "tau", tau, "own time of the problem", along)


def _states(solution: Result) -> Iterator[_Unnamed]:
    for name, shape in solution.about.shapes.items():
        rows, along = solution.about.slices[name], ("time", time_of(solution))
        values = solution.y[:, rows].reshape(-1, *shape)
        yield _Unnamed("piece", name, name, values, name, along)
        if solution.error_estimate is not None:
            off = solution.error_estimate[:, rows].reshape(-1, *shape)
            yield _Unnamed("error", name, f"{name}_error", off, f"estimated error of {name}", along)


def _drift(name: str, drift: Drift) -> Iterator[_Unnamed]:
    windows = drift.windows
    numbers = {f.name: getattr(drift, f.name) for f in fields(Drift)[1:] if f.name != "windows"}
    numbers |= {"length": windows.length, "samples": windows.samples, "until": windows.last_time}
    told = {key: number for key, number in numbers.items() if number is not None}
    about = f"first value of {name}; its drift in attributes"
    yield _Unnamed("drift", name, name, np.array(drift.initial), about, numbers=told)
    for part, what in WINDOWS.items():
        values = getattr(windows, part) if len(windows.times) else None
        along = "times", name
        yield _Unnamed(part, name, name + ENDINGS[part], values, f"{what} of {name}", along)


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


def to_xarray(variables: list[Variable], about: Mapping[str, Any]) -> Any:
    """Return an `xarray.Dataset`."""
    xarray = optional("xarray", "Solution.to_xarray")
    data = {v.name: (v.dimensions, v.values, v.attributes) for v in variables}
    times = [v.name for v in variables if v.role in ("time", "times")]
    return xarray.Dataset(data, attrs=dict(about)).set_coords(times)


def to_dataframe(variables: list[Variable], about: Mapping[str, Any]) -> Any:
    """Return a `pandas.DataFrame`, a row for each state."""
    pandas = optional("pandas", "Solution.to_dataframe")
    frame = pandas.DataFrame(columns_of(variables)).set_index(variables[0].name)
    frame.attrs = dict(about)
    return frame


def columns_of(variables: list[Variable]) -> dict[str, Array]:
    """Return times and components of the saved states by their names."""
    columns = {}
    for variable in variables:
        if variable.role in ("time", "piece"):
            for index in np.ndindex(variable.values.shape[1:]):
                place = f"[{','.join(map(str, index))}]" if index else ""
                columns[variable.name + place] = variable.values[:, *index]
    return columns


def optional(library: str, what: str, extra: str = "notebook") -> Any:
    """Return an optional library, or raise `MissingCodeError` that says how to get it."""
    import importlib

    try:
        return importlib.import_module(library)
    except ImportError as error:
        reason = f"needs {library}: pip install {library}, or geomint[{extra}]"
        raise MissingCodeError(what, reason) from error
