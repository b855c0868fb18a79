"""What importing costs, and what is public."""

import subprocess
import sys

import pytest

import chaplygin

CODE = """
import sys
import chaplygin
heavy = {'numba', 'pydantic', 'matplotlib', 'scipy'}
assert not heavy & set(sys.modules), heavy & set(sys.modules)
assert 'numpy' not in sys.modules
sphere = chaplygin.ChaplyginSphere(a=[0.8, 1.1, 1.5], D=4.0)
for make in (sphere.reduced, sphere.hamiltonized, sphere.ball, sphere.classical):
    make()
body = chaplygin.Veselova(a=[0.8, 1.1, 1.5])
for make in (body.reduced, body.hamiltonized, body.classical):
    make()
chaplygin.ellipsoid_problem([1.0, 4.0, 9.0])
assert 'numba' not in sys.modules
import chaplygin.systems.ball, chaplygin.systems.sphere, chaplygin.systems.veselova
assert 'numba' not in sys.modules
"""


def test_importing_is_cheap():
    subprocess.run([sys.executable, "-c", CODE], check=True)


def test_public_names():
    assert set(chaplygin.__all__) <= set(dir(chaplygin))
    for name in chaplygin.__all__:
        assert getattr(chaplygin, name).__doc__
    with pytest.raises(AttributeError, match="nothing"):
        _ = chaplygin.nothing
