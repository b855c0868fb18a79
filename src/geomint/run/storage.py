"""Runs on disk: NetCDF files that any tool reads, with all that is needed to go on with them.

A file in the classic format with 64-bit offsets holds a run as variables with named dimensions:

=========================  ======================  ===================================================
variable                   dimensions              content
=========================  ======================  ===================================================
``t``                      (t)                     physical times of the saved states
``tau``                    (t), else (tau)         their own times, of a problem in τ
PIECE                      (t, k) or (t, i, j)     a piece of the state, such as ``gamma``
``PIECE_error``            as that of PIECE        its estimated error, if that was asked for
QUANTITY                   ()                      the first value; attributes are the drift's numbers
``QUANTITY_time``          (QUANTITY_time)         mean time of each window of steps
``QUANTITY_mean``          (QUANTITY_time)         mean deviation from the first value
``QUANTITY_maximum``       (QUANTITY_time)         largest absolute deviation
PARAMETER                  (), (k) or (i, j)       a parameter of the problem
``_restart_memory`` …      its own                 what the next step depends on; nodes before it
``_QUANTITY_last_window``  its own                 samples after the last full window
``_kept_states`` …         its own                 what dense output is made of
``_NAME_event``            its own                 events: τ, direction, t if it is known, the state
``_problem_params``        its own                 the flat parameters
``_problem_code`` …        its own                 where the functions are found again (a pickle);
                                                   none of a method that its name and options make
=========================  ======================  ===================================================

Where the clock was not integrated the dimension of states is ``tau``. A dimension of another length has
that in its name, as ``k6``; a name that is taken gets an underscore. Attributes of the file are
`problem`, `method`, `status`, `message` and, as JSON, `provenance`, `run` (numbers of the run),
`options` (of a method that is found by its name) and `layout` (what each variable is). `checksum` is
the SHA-256 of the whole file with 64 zeros in the place of its own digits.

A file brings no code. Methods are made by their names, problems by the system of their scene, or they
are given. The pickles are for files that you made yourself: they are read with ``trust=True`` alone,
and then by `Solution.problem`, `Solution.method`, `Solution.sol` and going on; what was loaded without
it is saved without them.
"""

import hashlib
import json
import os
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields
from math import prod
from os import PathLike, fspath
from pathlib import Path
from types import UnionType
from typing import Any, BinaryIO, ClassVar, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
from scipy.io import netcdf_file

from .. import __version__
from ..arguments import Array, file_path, switch
from ..errors import DomainError, GeomintError, GeomintWarning, OutputError, quoted
from ..methods.method import Method
from ..methods.registry import find_solver
from ..problems.problem import Problem
from ..watch.drift import Drift
from ..watch.windows import NOTHING, Windows
from .accuracy.accuracy import Accuracy
from .dense import Kept
from .files.inputs import note_input
from .files.outputs import whole_file, write_table
from .local_error import EndError, LocalError
from .met import Met
from .restart import Restart
from .result import Result, StepSizes
from .solution import Solution
from .stored import StoredMethod, StoredProblem, known
from .variables import WINDOWS, Variable, columns_of, variables_of

ENDINGS = (".nc", ".csv")
_FORMAT = "geomint-run-3"
_NO_CHECKSUM = "0" * 64
_SEAL = re.compile(rb"checksum\x00\x00\x00\x02\x00\x00\x00\x40([0-9a-f]{64})")
_KIND = re.compile(rb"geomint-run-[0-9]+")
_HEADER = 1 << 20  # bytes: the checksum, the first attribute, is found in them
_LARGEST = 2**31 - 4  # bytes of a variable, of the format
_OTHERWISE = (
    *("about", "by", "tau", "y", "drift", "physical"),
    *("restart", "kept", "events", "origin", "error_estimate"),
)
_PARTS = {"restart": Restart, "kept": Kept}
_ARRAYS = ("memory", "times", "states")  # of these
_RUN = tuple(f.name for f in fields(Result) if f.name not in _OTHERWISE)  # numbers and words
_open: Any = netcdf_file


def save_solution(
    solution: Solution,
    path: str | PathLike[str],
    provenance: Mapping[str, Any] | None = None,
    *,
    own: bool = False,
) -> None:
    """Write a run to a NetCDF file, or of one whose name ends in ``.csv`` the saved states alone.

    Parameters
    ----------
    solution : Solution
    path : path
        A regular file that is there is replaced, once the new one is complete; symlinks are
        followed.
    provenance : mapping, optional
        Default: all that the solution knows by itself.
    own : bool
        Whether nothing but an unchanged run is replaced.

    Raises
    ------
    DomainError
        For a name with the ending of another format.
    OutputError
        If something else is there, or the file cannot be written; what was there is as it was.
    """
    variables = variables_of(solution)
    if file_path("path", path, ENDINGS, strict=False).suffix == ".csv":
        write_table(path, (columns := columns_of(variables)), columns.values())
        return
    problem, method = StoredProblem.of(solution.about), StoredMethod.of(solution.by)
    told = {
        role: dict(vars(part)) for role in _PARTS if (part := getattr(solution, role)) is not None
    }
    hidden = {
        ("params", "problem"): np.asarray(problem.params),
        ("code", "problem"): np.frombuffer(problem.content, np.int8),
        ("code", "method"): np.frombuffer(method.content, np.int8),
        **{(role, of): told[role].pop(of) for role in told for of in _ARRAYS if of in told[role]},
        **{("event", of): met.table for of, met in solution.events.items()},
        **{("last_window", of): drift.windows.last_window for of, drift in solution.drift.items()},
    }
    variables += list(_for_load(hidden, {variable.name for variable in variables}))
    attributes = {
        "checksum": _NO_CHECKSUM,
        "format": _FORMAT,
        "history": f"written by geomint {__version__}",
        **solution.words(provenance),
        **({"units": json.dumps(dict(problem.units))} if problem.units else {}),
        "run": json.dumps(
            {name: getattr(solution, name) for name in _RUN} | {"ranked": solution.local_error},
            default=GeomintWarning.as_json,
        ),
        **{role: json.dumps(told.get(role, {})) for role in _PARTS},
        "events": json.dumps({of: met.t is not None for of, met in solution.events.items()}),
        "options": json.dumps(method.options),
        "layout": json.dumps([[v.name, v.role, v.of] for v in variables]),
    }
    for variable in variables:
        if variable.values.nbytes > _LARGEST:
            raise OutputError(path, f"{variable.name!r} has more than 2 GiB: save fewer states")
    with whole_file(path) as unfinished:
        with unfinished.open("w+b") as stream:
            file = _open(stream, "w", version=2)
            _tell(file, attributes)
            for variable in variables:
                _write(file, variable)
            file.flush()
        _seal(unfinished)
        if own:  # as late as can be: a run of hours may have gone before
            check_own(Path(path))


def _for_load(hidden: Mapping[tuple[str, str], Array], taken: set[str]) -> Iterator[Variable]:
    """Yield what nobody but `load` reads, under names that are not taken."""
    for (role, of), values in hidden.items():
        name = f"_{role}_{of}" if role in _PARTS else f"_{of}_{role}"
        while name in taken:
            name = f"_{name}"
        if values.size:
            dimensions = tuple(f"{name}_{i}" for i in "ij"[: values.ndim])
            yield Variable(role, of, name, dimensions, values, {"long_name": "for load"})
            taken.add(name)


def _tell(target: Any, attributes: Mapping[str, Any]) -> None:
    """Write attributes: words as UTF-8, numbers as float64."""
    for name, value in attributes.items():
        told = value.encode() if isinstance(value, str) else np.float64(value)
        setattr(target, name, told)


def _write(file: Any, variable: Variable) -> None:
    """Write a variable, and its dimensions unless they are there; one of no states is unlimited."""
    dimensions = [_packed(name) for name in variable.dimensions]
    for name, length in zip(dimensions, variable.values.shape, strict=True):
        if name not in file.dimensions:
            file.createDimension(name, length or None)
    kind = "b" if variable.values.dtype == np.int8 else "d"
    written = file.createVariable(_packed(variable.name), kind, tuple(dimensions))
    if variable.values.size:
        written[...] = variable.values
    _tell(written, variable.attributes)
    if variable.role == "piece" and "t" in dimensions and "tau" in file.variables:
        written.coordinates = (
            b"tau"  # what xarray makes a coordinate of, beside the dimension's own
        )


def _packed(name: str) -> str:
    """Return a name as scipy has to have it so that its UTF-8 is in the file."""
    return name.encode().decode("latin-1")


def _seal(path: Path) -> None:
    """Put the checksum of a file into its header."""
    with path.open("r+b") as file:
        place = file.read(_HEADER).index(_NO_CHECKSUM.encode())
        file.seek(0)
        digits = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(place)
        file.write(digits.encode())


def check_own(path: Path) -> None:
    """Refuse to replace a file that is not a run, as it was written."""
    if path.exists():
        with path.open("rb") as file:
            try:
                _check_seal(file, str(path))
            except GeomintError:
                why = "another file is there, which is left alone; name one with --out"
                raise OutputError(path, why) from None


def _check_seal(file: BinaryIO, name: str) -> None:
    """Refuse a file that is not what was written, before anything in it is believed."""
    header = file.read(_HEADER)
    kind, found = _KIND.search(header), _SEAL.search(header)
    if kind is not None and kind[0] != _FORMAT.encode():
        raise GeomintError(
            f"{name!r} is of another version of geomint ({kind[0].decode()}, not {_FORMAT}): "
            "run it again, as its attribute 'provenance' says; readers of NetCDF read its numbers"
        )
    if kind is None or found is None:
        raise GeomintError(f"{name!r} holds no run of geomint")
    start, end = found.span(1)
    digest = hashlib.sha256(header[:start] + _NO_CHECKSUM.encode() + header[end:])
    while block := file.read(_HEADER):
        digest.update(block)
    if digest.hexdigest().encode() != found[1]:
        raise GeomintError(f"{name!r} is not what was written: its checksum differs")
    file.seek(0)


class _File(_open):  # type: ignore[misc]
    """A file that is read: no attribute of it becomes one of its reader, no data are read twice."""

    def _read_gatt_array(self) -> None:
        self.__dict__["_attributes"] = self._read_att_array()
        self.__dict__["_left"] = os.fstat(self.fp.fileno()).st_size

    def _read_var(self) -> Any:
        found = super()._read_var()
        lengths = [length for length in found[2] if length is not None]  # None: of records
        self.__dict__["_left"] -= prod(lengths) * found[5]
        if self._left < 0 or min(lengths, default=0) < 0:
            raise ValueError("its variables are larger than the file")
        return found


def load(
    path: str | PathLike[str],
    problem: Problem | None = None,
    *,
    method: str | Method | None = None,
    trust: bool = False,
) -> Solution:
    """Read a run that `Solution.save` or ``geomint run`` wrote.

    The solution is what it was, and `geomint.solve` goes on from it. No code comes from the file: its
    method is made by its name and options, its problem by the system of its scene. What is not known
    by a name, as the problem of a notebook, is given here, or else it has numbers only: whatever needs
    the functions is a `MissingCodeError`.

    Parameters
    ----------
    path : path
    problem : Problem, optional
        That of the run.
    method : Method or str, optional
        That of the run.
    trust : bool
        Whether functions are looked for by the pickle in the file, which can run anything: for files
        that you made yourself. Even then only `Solution.problem`, `Solution.method`, `Solution.sol`
        and going on read it.

    Raises
    ------
    GeomintError
        If the file is none, not complete, or not what was written.
    DomainError
        For a problem that has another name, other pieces or other parameters, a method of another
        name or other options.
    FileNotFoundError, OSError
        If there is none, or it cannot be opened.
    """
    if not isinstance(path, str | PathLike):
        raise DomainError("path", path, "the path of a file")
    place, name, trusted = Path(path), fspath(path), switch("trust", trust)
    if place.exists() and not place.is_file():
        raise GeomintError(f"{name!r} holds no run of geomint: it is no regular file")
    try:
        stream = place.open("rb")
    except ValueError:  # a null byte, half of a pair
        raise DomainError("path", path, "the path of a file") from None
    with stream:
        _check_seal(stream, name)
        note_input(place, copied=True)
        try:
            solution = _read(_File(stream, mmap=False), trusted)
        except Exception as error:  # of a writer with another idea of the content
            reason = quoted(error)
            raise GeomintError(f"{name!r} cannot be read as a run: {reason}") from error
    given = {"about": problem, "by": None if method is None else find_solver(method)}
    for of, value in given.items():
        there: Any = getattr(solution, of)
        if value is not None:
            if not isinstance(value, Problem | Method) or known(value) != known(there):
                expected = f"{there.name!r}, with the parameters of the run"
                raise DomainError(there.kind, value, expected)
            setattr(solution, of, value)
    return solution


def _read(file: Any, trusted: bool) -> Solution:
    words = {name: value.decode() for name, value in file._attributes.items()}
    run, order = json.loads(words["run"]), json.loads(words["layout"])
    found: dict[str, dict[str, Any]] = defaultdict(dict)
    values: dict[str, dict[str, Array]] = defaultdict(dict)
    if not _is(order, list[list[str]]):
        raise TypeError("its layout is none")
    for name, role, of in order:
        found[role][of] = variable = file.variables.pop(_packed(name))
        values[role][of] = np.array(variable[...], variable.data.dtype.newbyteorder("="))
    pieces, times = values["piece"], values["time"]
    for name, kind in (("step_sizes", StepSizes), ("ranked", LocalError), ("end_error", EndError)):
        run[name] = kind(*run[name]) if run.get(name) else None
    run["accuracy"] = Accuracy.read(run.get("accuracy"))
    run["warnings"] = tuple(map(GeomintWarning.read, run.get("warnings", ())))
    origin = json.loads(words["provenance"])
    code: dict[str, Any] = {of: content.tobytes() for of, content in values["code"].items()}
    for role, part in _PARTS.items():
        told = {**json.loads(words.get(role, "{}")), **values[role]}
        run[role] = part(**told) if told else None
    y = _joined(pieces)
    met = json.loads(words.get("events", "{}"))
    scene = origin.get("scene") or {}
    solution = Solution(
        about=StoredProblem(
            words["problem"],
            code.get("problem", b""),
            trusted,
            shapes={name: piece.shape[1:] for name, piece in pieces.items()},
            time=words["time"],
            parameters=values["parameter"],
            params=values["params"].get("problem", np.zeros(0)),
            system=scene.get("system"),
            initial=scene.get("initial"),
            units=json.loads(words.get("units", "{}")),
        ),
        by=StoredMethod(
            words["method"],
            code.get("method", b""),
            trusted,
            adaptive=json.loads(words["adaptive"].lower()),
            options=json.loads(words.get("options", "null")),
        ),
        tau=times[words["time"]],
        y=y,
        drift={name: _drift(name, found, values) for name in found["drift"]},
        physical=times.get("t"),
        error_estimate=_joined(values["error"]) if values["error"] else None,
        events={
            of: Met.of_table(values["event"].get(of, np.zeros((0, 2 + timed + y.shape[1]))), timed)
            for of, timed in met.items()
        },
        origin=origin,
        **run,
    )
    if not (_is(solution, Solution) and _fitting(solution)):
        raise ValueError("its numbers, words and shapes are not those of a run")
    return solution


def _is(value: Any, kind: Any) -> bool:
    """Tell whether what was read is what annotations say, with all that it is made of."""
    origin, inner = get_origin(kind), [one for one in get_args(kind) if one is not ...]
    if origin in (Union, UnionType):
        return any(_is(value, one) for one in inner)
    if kind is Any or origin in (ClassVar, Literal):
        return origin is not Literal or value in inner
    if type(value) is int:
        return kind in (int, float) and value.bit_length() < 64
    if not isinstance(value, origin or kind):
        return False
    if isinstance(value, np.ndarray):
        return bool(value.dtype == np.float64)
    if isinstance(value, str):
        return value.encode().decode() == value  # no halves of pairs
    if origin is None:
        hints = get_type_hints(kind).items()
        return all(_is(getattr(value, name), hint) for name, hint in hints)
    parts = value.values() if isinstance(value, Mapping) else value
    return all(_is(part, inner[-1]) for part in parts)


def _fitting(s: Solution) -> bool:
    """Tell whether arrays have the shapes that they have in a run: compiled code does not look."""
    m, rows = s.y.shape
    nodes: list[Any] = [x for x in (s.restart, s.kept) if x is not None and len(x.times)]
    series = (s.tau, (m,)), (s.physical, (m,)), (s.error_estimate, (m, rows))
    fit = [x is None or x.shape == shape for x, shape in series]
    fit += [met.y.shape[1] == rows for met in s.events.values()]
    fit += [x.states.shape in ((len(x.times), rows), (len(x.times), rows + 1)) for x in nodes]
    return all(fit)


def _joined(pieces: dict[str, Array]) -> Array:
    """Return the flat states, one a row, of their pieces."""
    return np.hstack([x.reshape(len(x), prod(x.shape[1:])) for x in pieces.values()])


def _drift(
    name: str, found: dict[str, dict[str, Any]], values: dict[str, dict[str, Array]]
) -> Drift:
    """Return a drift that was written: its numbers, and times, means and maxima of its windows."""
    told = found["drift"][name]._attributes.items()
    numbers: dict[str, Any]
    numbers = {key: x.decode() if isinstance(x, bytes) else float(x) for key, x in told}
    closed = [values[part][name] for part in WINDOWS] if name in values["times"] else []
    windows = Windows(
        numbers["initial"],
        numbers["until"],
        numbers["final_error"],
        int(numbers["length"]),
        int(numbers["samples"]),
        numbers["max_abs_error"],
        numbers.get("not_finite_from"),
        np.array(closed) if closed else np.zeros((3, 0)),
        values["last_window"].get(name, NOTHING),
    )
    numbers["own_noise"] = bool(numbers.get("own_noise"))  # attributes are words and numbers
    numbers |= {"name": name, "windows": windows}
    own: Any = ((f.name, None if f.default is MISSING else f.default) for f in fields(Drift))
    return Drift(**{key: numbers.get(key, default) for key, default in own})
