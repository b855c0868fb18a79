"""Fingerprints: they follow everything that a function reaches, and nothing else."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import types
from pathlib import Path

import numpy as np
import pytest

import geomint as gi
from geomint.kernels.compiling.fingerprint import Reach
from geomint.kernels.compiling.recorded import Recorded

pytestmark = pytest.mark.nojit

SOURCE = """
import geomint as gi
import numpy as np
import helpers
import pack.deep
from helpers import imported

RATE = 2.0
TABLE = np.array([1.0, 2.0])
NAMES = ("a", 3)

def inner(x):
    return x + RATE

@gi.helper
def middle(x):
    return inner(x) * TABLE[0]

def outer(factor):
    def build(params, t, y, out, work, scale=1.5, *, power=2):
        def nested(x):
            return helpers.outside(x) + pack.deep.far(x) + imported(x)
        out[0] = factor * scale * power * gi.sin(middle(nested(y[0]))) + NAMES[1] + 7.0
    return build

field = outer(3.0)
"""
HELPERS = "GAIN = 4.0\ndef outside(x):\n    return GAIN * x\ndef imported(x):\n    return x - 1.0\n"
DEEP = "def far(x):\n    return x * 5.0\n"


def build(source: str = SOURCE, helpers: str = HELPERS, deep: str = DEEP) -> str:
    """Execute sources and return the fingerprint of their `field`."""
    modules = {name: types.ModuleType(name) for name in ("helpers", "pack", "pack.deep", "main")}
    exec(helpers, vars(modules["helpers"]))
    exec(deep, vars(modules["pack.deep"]))
    modules["pack"].deep = modules["pack.deep"]
    imports = {name: modules[name] for name in ("helpers", "pack", "pack.deep")}
    with pytest.MonkeyPatch.context() as patch:
        for name, module in imports.items():
            patch.setitem(sys.modules, name, module)
        exec(source, vars(modules["main"]))
    return Reach(vars(modules["main"])["field"]).fingerprint


def test_the_same_sources_give_the_same_fingerprint() -> None:
    """However often they are executed, and with comments, blank lines or other functions added."""
    assert build() == build()
    assert build(SOURCE.replace("RATE = 2.0", "# a comment\n\nRATE = 2.0\nUNUSED = 5")) == build()
    assert build(helpers=HELPERS + "def unused(x):\n    return x\n") == build()


@pytest.mark.parametrize(
    ("part", "old", "new"),
    [
        ("source", "x + RATE", "x - RATE"),
        ("source", "RATE = 2.0", "RATE = 2.5"),
        ("source", "RATE = 2.0", "RATE = -2.0"),
        ("source", "[1.0, 2.0]", "[1.0, 2.5]"),
        ("source", '("a", 3)', '("a", 4)'),
        ("source", "* TABLE[0]", "* TABLE[1]"),
        ("source", "outer(3.0)", "outer(3.5)"),
        ("source", "scale=1.5", "scale=1.75"),
        ("source", "power=2", "power=3"),
        ("source", "+ 7.0", "+ 7.5"),
        ("source", "gi.sin", "gi.cos"),
        ("source", "y[0]", "y[1]"),
        ("helpers", "GAIN = 4.0", "GAIN = 4.5"),
        ("helpers", "x - 1.0", "x - 2.0"),
        ("deep", "x * 5.0", "x * 6.0"),
    ],
)
def test_a_change_anywhere_changes_it(part: str, old: str, new: str) -> None:
    """Helpers, constants, closure values, defaults, nested functions, modules of modules."""
    text = {"source": SOURCE, "helpers": HELPERS, "deep": DEEP}[part]
    assert text.count(old) == 1
    assert build(**{part: text.replace(old, new)}) != build()


def test_other_processes_compute_the_same(tmp_path: Path) -> None:
    """Whatever was imported or evaluated before, and whatever the hash seed."""
    script = textwrap.dedent(
        """
        import sys
        import geomint as gi

        @gi.field
        def f(params, t, y, out, work):
            out[0] = gi.sqrt(y[0]) + gi.select(y[0] > 1.0, 0.5, 2.0)

        if "evaluate" in sys.argv:
            gi.sqrt, gi.select, gi.solve
        print(f.fingerprint)
        """
    )
    path = tmp_path / "script.py"
    path.write_text(script, encoding="utf-8")
    found = {
        subprocess.run(
            [sys.executable, str(path), *extra], check=True, capture_output=True, text=True
        ).stdout
        for extra in ([], ["evaluate"])
    }
    assert len(found) == 1


def test_recursion_ends() -> None:
    """Functions may refer to each other."""
    modules = types.ModuleType("loop")
    exec(
        "def even(n):\n    return n == 0 or odd(n - 1)\n"
        "def odd(n):\n    return n != 0 and even(n - 1)\n",
        vars(modules),
    )
    assert Reach(modules.even).fingerprint != Reach(modules.odd).fingerprint


def test_recorded_functions_are_functions() -> None:
    """They can be called, keep name and doc, and may be recorded again."""

    @gi.helper
    def half(x):
        """Halve."""
        return 0.5 * x

    assert half(3.0) == 1.5
    assert half.__name__ == "half"
    assert half.__doc__ == "Halve."
    assert "half" in repr(half)
    assert Recorded(half).function is half.function
    assert Recorded(lambda x: x)(2) == 2
    for wrong in (np.sin, 3, None, "f"):
        with pytest.raises(TypeError, match="written with def"):
            gi.field(wrong)
