"""Look at the store of an ensemble, without the code of its problem."""

import json
import os
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from ....arguments import Array
from ....errors import DomainError, GeomintError, quoted
from ...stored import StoredMethod, StoredProblem
from ..given import Asked, Members
from ..result import Ensemble
from .arrays import Arrays, needed_zarr
from .columns import numbers_in, readable
from .identity import is_store
from .read import StoredOutcome


@dataclass(frozen=True)
class _Read:
    """What is known of a reading."""

    merges: bool
    kind: str
    of: str


@dataclass(frozen=True, eq=False)
class _Known(Members):
    """Members whose parameters are known by their numbers."""

    parameters: dict[str, Array] = field(default_factory=dict)

    def differing(self) -> dict[str, Array]:
        return self.parameters


def open_ensemble(path: str | PathLike[str]) -> Ensemble:
    """Look at an ensemble that `geomint.solve_ensemble` has written, or is writing, to `out`.

    A store holds no code, so that there is nothing to trust: a folder of another layout, of Zarr's
    format 2, or with codecs that are not Zarr's own, is refused before it is read. The code of its
    problem need not be there. Arrays are read when they are asked for; their numbers have no checksum.
    To go on, or for `Ensemble.single`, call `geomint.solve_ensemble` again.

    Parameters
    ----------
    path : path

    Raises
    ------
    GeomintError
        If there is none, one of another layout, or one whose files cannot be read.
    MissingCodeError
        Without the library zarr.

    Examples
    --------
    >>> import geomint as gi
    >>> gi.open_ensemble("nothing.zarr")
    Traceback (most recent call last):
    geomint.errors.GeomintError: 'nothing.zarr' holds no ensemble of geomint
    """
    needed_zarr("open_ensemble")
    if not isinstance(path, str | PathLike):
        raise DomainError("path", path, "the path of a folder")
    with readable(path):
        place = Path(os.path.realpath(path))
    if not is_store(place):
        raise GeomintError(f"{quoted(os.fspath(path))} holds no ensemble of geomint")
    with readable(path):
        arrays = Arrays(place, writing=False)
        about = arrays.about
        shapes = {name: tuple(shape) for name, shape in about["shapes"].items()}
        problem: Any = StoredProblem(about["problem"], shapes=shapes, time=about["time"])
        method: Any = StoredMethod(about["method"], adaptive=about["adaptive"])
        differing = {of: numbers_in(a) for (of, _), a in arrays.of_role("parameter").items()}
        states = numbers_in(arrays.find("states"))
        given = _Known((problem,), states, (states == states).all(axis=1), parameters=differing)
        readings = {
            of: _Read(role == "merged", str(a.attrs["kind"]), str(a.attrs["quantity"]))
            for role in ("reading", "merged")
            for (of, _), a in arrays.of_role(role).items()
        }
        known = json.loads(about["provenance"])
        shared = {
            name: known.get(name) for name in ("t0", "t_end", "tau_end", "step", "save_every")
        }
        wanted = {name: known[name] for name in ("t_eval", "tau_eval") if name in known}
        asked = Asked(method, shared, arrays.members, wanted, readings, streamed=True)
    return Ensemble(given, asked, StoredOutcome(arrays))
