"""Saved runs that are not what was written: damaged, or made by somebody who wants code to run."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
import hashlib
import inspect
import io
import pickle
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from random import Random

import numpy as np
from scipy.io import netcdf_file

import geomint as gi
from tests.fuzz.hostile import NUMBERS, STRINGS
from tests.fuzz.judge import Judged, judged
from tests.problems import examples

__all__ = ["MARK", "file_verdict", "genuine", "with_code"]

MARK = "code-was-run"
CODE = f"cposix\nmkdir\n(V{MARK}\ntR.".encode()
_SUM = b"checksum\x00\x00\x00\x02\x00\x00\x00\x40"


@cache
def genuine() -> bytes:
    """Return a run with events, drifts and dense output, of a method that no name gives."""
    problem, y0 = examples()[1]
    method = gi.find_method("gauss-2").with_options(max_iterations=77)
    run = {"t_end": 0.05, "step": 0.01, "method": method, "observe": "all", "dense": True}
    found = gi.solve(problem, y0, compiled=False, **run)
    with tempfile.TemporaryDirectory() as folder:
        found.save(Path(folder) / "run.nc")
        return (Path(folder) / "run.nc").read_bytes()


@cache
def with_code() -> bytes:
    """Return the same with other code in the place of problem and method, and a checksum that fits."""
    data, planted = bytearray(genuine()), 0
    with netcdf_file(io.BytesIO(bytes(data)), "r", mmap=False) as file:
        codes = [v[...].tobytes() for name, v in file.variables.items() if name.endswith("_code")]
    for code in codes:
        data[(at := data.index(code)) : at + len(CODE)] = CODE
        planted += 1
    assert planted
    return sealed(bytes(data))


def sealed(data: bytes) -> bytes:
    """Return a file with the checksum that fits."""
    place = data.find(_SUM) + len(_SUM)
    if place < len(_SUM):
        return data
    blank = data[:place] + b"0" * 64 + data[place + 64 :]
    return blank[:place] + hashlib.sha256(blank).hexdigest().encode() + blank[place + 64 :]


def damaged(rng: Random) -> tuple[bytes, bool]:
    """Return a run after something was done to it, and whether its checksum was made to fit."""
    data = bytearray(rng.choice((genuine, with_code))())
    at, length = rng.randrange(len(data)), rng.choice((1, 4, 64, 1000))
    what = rng.randrange(9)
    if what == 0:
        del data[at:]
    elif what == 1:
        del data[at : at + length]
    elif what == 2:
        data[at:at] = rng.randbytes(length)
    elif what == 3:
        data[at : at + length] = bytes(length)
    elif what == 4:
        data[at : at + length] = data[: len(data[at : at + length])]
    elif what == 5:
        number = rng.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1, rng.randrange(2**32)))
        data[at - at % 4 : at - at % 4 + 4] = number.to_bytes(4, "big")
    elif what == 6:
        _word(rng, data)
    else:
        for _ in range(length):
            place = rng.choice((rng.randrange(3000), rng.randrange(len(data))))
            data[place] ^= 1 << rng.randrange(8)
    fits = rng.random() < 0.7
    return sealed(bytes(data)) if fits else bytes(data), fits


def _word(rng: Random, data: bytearray) -> None:
    """Put another value of the same length into the JSON of the header."""
    header = range(400, min(len(data), 20_000))
    digits = [i for i in header if data[i : i + 1] in b'0123456789"{[,:']
    at = rng.choice(digits)
    word = rng.choice((*map(str, NUMBERS[:20]), *STRINGS[:30], "null", "NaN", "[]", "{}", "true"))
    data[at : at + len(word.encode())] = word.encode()


def _looked_at(run: gi.Solution, other: gi.Solution) -> None:
    """Do what shows, compares, copies and writes a run, but neither asks for code nor goes on."""
    looks = (
        lambda: repr(run), lambda: run == other, lambda: hash(run), lambda: copy.copy(run),
        lambda: copy.deepcopy(run), lambda: dataclasses.asdict(run),
        lambda: dataclasses.replace(run), lambda: inspect.getmembers(run),
        lambda: [getattr(run, name, None) for name in dir(run)], lambda: pickle.dumps(run),
        lambda: run.provenance, lambda: run.to_xarray(), lambda: run.to_dataframe(),
        lambda: run.as_saved(), lambda: run.save("again.nc"), lambda: gi.cite(run),
    )  # fmt: skip
    for look in looks:
        with contextlib.suppress(gi.GeomintError):
            look()


def _arrays(run: gi.Solution) -> Iterator[np.ndarray]:
    yield from (run.t, run.tau, run.y)
    for drift in run.drift.values():
        yield np.array([drift.initial, drift.final_error, drift.max_abs_error])


def file_verdict(rng: Random) -> Judged:
    """Return the verdict on reading a saved run, and on looking at what was read."""
    data, fits = damaged(rng)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("run.nc").write_bytes(data)
        Path("plain.nc").write_bytes(genuine())
        plain, read = gi.load("plain.nc"), []
        found = judged(lambda: read.append(gi.load("run.nc")))
        if read and not fits:
            a, b = ([x.tobytes() for x in _arrays(run)] for run in (read[0], plain))
            if a != b:
                return Judged("silent read", "a run that was damaged")
        if read:
            found = judged(lambda: _looked_at(read[0], plain))
        if Path(MARK).exists():
            return Judged("execution", found.detail)
    return found
