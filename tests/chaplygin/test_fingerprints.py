"""Fingerprints of all built-in systems, the same in every process; what importing costs, and is public.

Nothing that the systems reach is of unknown content, so that compiled code is found on the disk.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest

import chaplygin
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


# Importing is cheap, and making a system.
CHILD = f"""
import sys
from importlib.metadata import entry_points
import chaplygin
assert not {{'numba', 'pydantic', 'matplotlib', 'scipy', 'numpy'}} & set(sys.modules)
sphere, body = chaplygin.ChaplyginSphere([0.8, 1.1, 1.5], 4.0), chaplygin.Veselova([0.8, 1.1, 1.5])
for system in (sphere, body):
    for make in (system.reduced, system.hamiltonized, system.classical):
        make()
sphere.ball(), chaplygin.ellipsoid_problem([1.0, 4.0, 9.0])
for point in entry_points(group='geomint.systems'):
    if point.value.startswith('chaplygin.'):
        point.load()
assert 'numba' not in sys.modules
from {__name__} import functions
import json
print(json.dumps({{place: function.fingerprint for place, function in functions()}}))
"""


def test_fingerprints_are_those_of_another_process() -> None:
    found = {}
    for place, function in functions():
        found[place] = function.fingerprint
        assert function.reach.kept, place
        assert function.reach.compiled == [], place
    assert len(found) > 500
    environment = {**os.environ, "PYTHONHASHSEED": "1"}
    told = subprocess.run([sys.executable, "-c", CHILD], env=environment, capture_output=True)
    assert told.returncode == 0, told.stderr
    assert json.loads(told.stdout.splitlines()[-1]) == found


def test_public_names() -> None:
    assert set(chaplygin.__all__) <= set(dir(chaplygin))
    assert all(getattr(chaplygin, name).__doc__ for name in chaplygin.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        _ = chaplygin.nothing
