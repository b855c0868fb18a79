"""What importing costs, and what is public."""

import subprocess
import sys

import pytest

import chaplygin

CODE = """
import sys
from importlib.metadata import entry_points
import chaplygin
assert not {'numba', 'pydantic', 'matplotlib', 'scipy', 'numpy'} & set(sys.modules)
sphere, body = chaplygin.ChaplyginSphere([0.8, 1.1, 1.5], 4.0), chaplygin.Veselova([0.8, 1.1, 1.5])
for system in (sphere, body):
    for make in (system.reduced, system.hamiltonized, system.classical):
        make()
sphere.ball(), chaplygin.ellipsoid_problem([1.0, 4.0, 9.0])
for point in entry_points(group='geomint.systems'):
    if point.value.startswith('chaplygin.'):
        point.load()
assert 'numba' not in sys.modules
"""


def test_importing_is_cheap():
    subprocess.run([sys.executable, "-c", CODE], check=True)


def test_public_names():
    assert set(chaplygin.__all__) <= set(dir(chaplygin))
    assert all(getattr(chaplygin, name).__doc__ for name in chaplygin.__all__)
    with pytest.raises(AttributeError, match="nothing"):
        _ = chaplygin.nothing
