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


def recorded_in(value: Any, place: str) -> Iterator[tuple[str, Any]]:
    """Yield the recorded functions of a problem, and where they are."""
    if hasattr(value, "fingerprint"):
        yield place, value
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from recorded_in(item, f"{place}/{name}")
    elif dataclasses.is_dataclass(value):
        for part in dataclasses.fields(value):
            yield from recorded_in(getattr(value, part.name), f"{place}/{part.name}")


def functions() -> Iterator[tuple[str, Any]]:
    """Yield the functions of all representations of all built-in scenes."""
    for scene in gi.scene_names():
        for name, problem in gi.load_scene(scene).model.problems.items():
            yield from recorded_in(problem, f"{scene}/{name}")


def test_fingerprints_are_those_of_another_process() -> None:
    """So compiled code is found on the disk; nothing that the systems reach is of unknown content."""
    found = {}
    for place, function in functions():
        found[place] = function.fingerprint
        assert function.reach.kept, place
        assert function.reach.compiled == [], place
    assert len(found) > 500
    environment = {**os.environ, "PYTHONHASHSEED": "1"}
    done = subprocess.run(
        [sys.executable, "-m", __name__],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert json.loads(done.stdout.splitlines()[-1]) == found


if __name__ == "__main__":
    print(json.dumps({place: function.fingerprint for place, function in functions()}))
