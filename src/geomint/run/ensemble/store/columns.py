"""What has become of members as columns of numbers and words, and back."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .... import errors
from ....errors import GeomintError, quoted, raised
from ..given import Asked
from ..outcome import NOT_RUN, Outcome


@dataclass(frozen=True, eq=False)
class Column:
    """One variable of some members.

    Attributes
    ----------
    role, of, part : str
        What it is: ``"reading"`` and its name; ``"drift"``, of which quantity, and which number.
    values : array
        The first axis is that of the members; of what is merged that of blocks.
    axes : tuple of str
        Names of the other axes; those that begin with ``_`` are its own.
    fill : object
        What members have that are not there.
    """

    role: str
    values: Any
    axes: tuple[str, ...] = ()
    of: str = ""
    part: str = ""
    fill: Any = np.nan
    about: dict[str, Any] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """What it is called if nothing else is."""
        ending = {"drift": f"_{self.part}", "event": f"_{self.part}"}.get(self.role, "")
        name = f"{self.of or self.role}{ending}"
        return "".join("_" if c in '\\:*?"<>| ' else c for c in name)


def columns_of(found: Outcome, asked: Asked) -> Iterator[Column]:
    """Yield all of an outcome but the status, which is written when all else is."""
    yield Column("tau", found.tau, ("sample",))
    yield Column("t", found.physical, ("sample",))
    yield Column("y", found.y, ("sample", "row"), about={"coordinates": "tau t"})
    if found.error_estimate is not None:
        yield Column("error_estimate", found.error_estimate, ("sample", "row"))
    yield Column("counts", found.counts, fill=0)
    yield Column("steps", found.steps, fill=0)
    yield _words("message", found, found.errors, str)
    yield _words("error", found, found.errors, _told)
    if found.warnings:
        yield _words(
            "warnings", found, found.warnings, lambda w: json.dumps([x.as_json() for x in w])
        )
    yield from _drifts(found)
    yield from _events(found)
    for name, values in found.readings.items():
        reading = asked.readings[name]
        values = values[None] if reading.merges else values
        axes = tuple(f"_{i}" for i in range(values.ndim - 1))
        about = {"kind": getattr(reading, "kind", ""), "quantity": getattr(reading, "of", "")}
        role = "merged" if reading.merges else "reading"
        yield Column(role, values, axes, name, about={n: str(x) for n, x in about.items()})


def status_of(status: Any) -> Column:
    """Return the status of members, which says that all else of them is there."""
    return Column("status", status, fill=NOT_RUN)


@contextmanager
def readable(what: Any) -> Iterator[None]:
    """Make of whatever damaged files are found by one error that names them."""
    try:
        yield
    except GeomintError:
        raise
    except Exception as error:  # of the library, of JSON, of what decompresses
        reason = raised(error)
        raise GeomintError(
            f"{quoted(str(what))} is damaged, or cannot be read ({reason})"
        ) from error


def numbers_in(array: Any, here: Any = ...) -> Any:
    """Return an array of a store, or a part of it."""
    with readable(array.store_path):
        return np.asarray(array[here])


def words_in(array: Any, here: Any = ...) -> Any:
    """Return words of a store as an array of objects."""
    return numbers_in(array, here).astype(object)


def _words(role: str, found: Outcome, of: dict[int, Any], told: Callable[[Any], str]) -> Column:
    words = np.full(len(found.tau), "", dtype=object)
    for k, value in of.items():
        words[k] = told(value)
    return Column(role, words, fill="")


def _drifts(found: Outcome) -> Iterator[Column]:
    for name, drift in found.drifts().items():
        for part, values in drift.items():
            words = part == "class"
            values = values.astype(object) if words else values
            yield Column("drift", values, of=name, part=part, fill="" if words else np.nan)


def _events(found: Outcome) -> Iterator[Column]:
    for name, met in found.met().items():
        tables = [None if m is None else m.table for m in met]
        counts = np.array([-1 if table is None else len(table) for table in tables])
        some = [table for table in tables if table is not None]
        width = max(table.shape[1] for table in some)
        all_of = np.full((len(met), max(int(counts.max()), 1), width), np.nan)
        for k, table in enumerate(tables):
            if table is not None:
                all_of[k, : len(table)] = table
        timed = any(m is not None and m.t is not None for m in met)
        head = ["tau", "direction", *(["t"] if timed else [])]
        about = {"columns": " ".join([*head, "state"]), "timed": timed}
        yield Column("event", counts, of=name, part="count", fill=-1)
        yield Column("event", all_of, ("_0", "_1"), name, "met", about=about)


def _told(error: GeomintError) -> str:
    """Return an error in words and numbers alone: a store is read without running code of it."""
    kept = {k: x for k, x in vars(error).items() if isinstance(x, str | int | float | None)}
    return json.dumps({"type": type(error).__name__, "message": str(error), "numbers": kept})


def error_of(text: str) -> GeomintError:
    """Return the error that was told, without what it carried beside words and numbers."""
    told = json.loads(text)
    kind = getattr(errors, told["type"], None)
    message = told["message"]
    if not (isinstance(kind, type) and issubclass(kind, GeomintError)):
        kind, message = GeomintError, f"{told['type']}: {message}"
    error = kind.__new__(kind)
    error.args = (message,)
    vars(error).update(told["numbers"])
    return error
