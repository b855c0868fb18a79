"""Fingerprints of all built-in systems: the same in every process, and nothing that is refused."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import geomint as gi
from geomint.kernels.compiling.bound import bind
from geomint.kernels.compiling.recorded import Recorded
from geomint.kernels.compiling.signatures import FIELD
from geomint.scene.load import builtin_scenes


def recorded_in(value: Any, place: str) -> Iterator[tuple[str, Recorded]]:
    """Yield the recorded functions of a problem, and where they are."""
    if isinstance(value, Recorded):
        yield place, value
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from recorded_in(item, f"{place}/{name}")
    elif dataclasses.is_dataclass(value):
        for part in dataclasses.fields(value):
            yield from recorded_in(getattr(value, part.name), f"{place}/{part.name}")


def functions() -> Iterator[tuple[str, Recorded]]:
    """Yield the functions of all representations of all built-in scenes; fields bound as in a run."""
    for scene in builtin_scenes():
        for name, problem in gi.load_scene(scene).model.problems.items():
            yield from recorded_in(problem, f"{scene}/{name}")
            if problem.field is not None:
                rows = problem.rows
                bound = bind(problem.field, FIELD, params=len(problem.params), y=rows, out=rows)
                yield f"{scene}/{name}/bound", bound.recorded


def test_fingerprints_are_those_of_another_process() -> None:
    """So compiled code is found on the disk; nothing that the systems reach is of unknown content."""
    found = {}
    for place, function in functions():
        found[place] = function.fingerprint
        assert function.reach.kept, place
        assert function.reach.compiled == [], place
        assert function.reach.holds()
    assert len(found) > 500
    done = subprocess.run(
        [sys.executable, __file__],
        env={**os.environ, "PYTHONHASHSEED": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout.splitlines()[-1]) == found


if __name__ == "__main__":
    print(json.dumps({place: function.fingerprint for place, function in functions()}))
