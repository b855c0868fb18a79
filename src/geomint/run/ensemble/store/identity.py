"""Which ensemble a store holds: all that the bits of its members depend on, and how two differ."""

import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .... import __version__
from ....errors import quoted, shortened
from ....kernels.compiling.digest import digest, versions_of_numbers
from ....methods import Exact
from ....problems.problem import Problem
from ...provenance import environment, finite_json, method_record
from ..given import Asked, Members

FORMAT = "geomint-ensemble-1"

Identity = Mapping[str, list[str]]

# Of a problem: not what makes states, of which those that are given are here themselves.
_FORMS = ("field", "action", "hamiltonian", "splitting", "work", "clock", "space")
_QUANTITIES = ("invariants", "constraints", "observables", "measure", "symplectic_form")
_WANTED = ("t_eval", "tau_eval", "events", "observe", "observe_every", "estimate_error")
LONGEST = 60  # characters of what is shown
SHOWN = 8  # that differ
MOST_TIMES = 10**5  # that the attributes list


def identity(given: Members, asked: Asked) -> dict[str, list[str]]:
    """Return by name what an ensemble is: of each a digest, and what is shown of it."""
    first = given.problem(0)
    found = {
        "number of members": _of(len(given)),
        "problem": _of((first.name, first.pieces, first.time), first.name),
        "functions of the problem": _functions(given, asked),
        "parameters": _arrays((problem.params for problem in given.problems), ""),
        "states": _arrays([given.states], ""),
        "method": _of(asked.method, repr(asked.method)),
    }
    found.update({name: _of(_plain(value)) for name, value in asked.shared.items()})
    found.update({name: _of(_plain(asked.wanted.get(name))) for name in _WANTED})
    readings = ", ".join(asked.readings) or "none"
    found["readings"] = _of(list(asked.readings.items()), readings)
    found["keep_states"] = _of(asked.keep_states)
    versions = f"geomint {__version__}, {versions_of_numbers()}"
    found["versions"] = [digest(versions), versions]
    return found


def about(given: Members, asked: Asked) -> dict[str, Any]:
    """Return what the attributes of a store say: in words, numbers and JSON."""
    first = given.problem(0)
    differ = given.differing()
    alike = {name: x for name, x in first.parameters.items() if name not in differ}
    times = {n: asked.wanted[n] for n in ("t_eval", "tau_eval") if n in asked.wanted}
    provenance = {
        **environment(),
        "problem": first.name,
        "pieces": [[name, rows] for name, rows in first.pieces],
        "parameters": finite_json(alike),
        "time": first.time,
        **method_record(asked.method),
        **finite_json({name: _plain(x) for name, x in asked.shared.items()}),
        **{name: finite_json(_plain(x)) for name, x in times.items() if np.size(x) <= MOST_TIMES},
    }
    return {
        "format": FORMAT,
        "problem": first.name,
        "method": asked.method.name,
        "adaptive": asked.method.adaptive,
        "time": first.time,
        "shapes": {name: list(shape) for name, shape in first.shapes.items()},
        "members": len(given),
        "provenance": json.dumps(provenance),
    }


def is_store(path: Path) -> bool:
    """Tell whether a folder holds the store of an ensemble."""
    try:
        told = json.loads((path / "zarr.json").read_text(encoding="utf-8"))
        return bool(told["attributes"]["format"] == FORMAT)
    except (OSError, ValueError, LookupError, TypeError):
        return False


def differences(there: Identity, asked: Identity) -> str:
    """Return in words how two ensembles differ; nothing if they are one."""
    told = []
    for name, (content, shown) in asked.items():
        old, old_shown = there.get(name, ("", "unknown"))
        if old == content:
            continue
        known = f"{name} ({old_shown} there, {shown} asked for)"
        told.append(known if shown and old_shown != shown else name)
    more = [f"and {len(told) - SHOWN} more"] if len(told) > SHOWN else []
    return ", ".join([*told[:SHOWN], *more])


def _of(value: Any, shown: str | None = None) -> list[str]:
    return [digest(value), shortened(quoted(value) if shown is None else shown, LONGEST)]


def _plain(value: Any) -> Any:
    """Return numbers as floats: 50 and 50.0 are one end, a list and an array the same times."""
    if isinstance(value, bool | str) or value is None:
        return value
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except Exception:  # of what is no number
        return value
    return numbers if numbers.ndim else float(numbers)


def _arrays(arrays: Any, shown: str) -> list[str]:
    found = hashlib.sha256()
    for array in arrays:
        found.update(f"{array.shape}".encode())
        found.update(np.ascontiguousarray(array).tobytes())
    return [found.hexdigest()[:32], shown]


def _functions(given: Members, asked: Asked) -> list[str]:
    """Return what the problems compute by; of many that share their functions, those once."""
    exact = ("make_exact",) if isinstance(asked.method, Exact) else ()
    names = (*_FORMS, *_QUANTITIES, *exact)

    def parts(problem: Problem) -> Iterator[Any]:
        return (getattr(problem, name) for name in names)

    seen = {}
    told = []
    for problem in given.problems:
        key = tuple(map(id, parts(problem)))  # all are held by their problems meanwhile
        if key not in seen:
            seen[key] = digest(list(parts(problem)))
        told.append(seen[key])
    return [hashlib.sha256(" ".join(told).encode()).hexdigest()[:32], ""]
