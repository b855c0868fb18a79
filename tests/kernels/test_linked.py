"""Machine code is made of what is called alone, and numba's own compilation goes on as it was."""

from __future__ import annotations

import gc
import os
import sys
from typing import Any

import numba
import pytest
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import cpu_target

import geomint as gi
from geomint.kernels import numba_inside
from geomint.kernels.compiling.compile import listen

pytestmark = pytest.mark.skipif(
    bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is compiled"
)


def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list that gets the names of libraries of which machine code is made."""
    names: list[str] = []
    finalize = JITCodeLibrary._finalize_specific

    def noted(self: JITCodeLibrary) -> None:
        names.append(self.name)
        finalize(self)

    monkeypatch.setattr(JITCodeLibrary, "_finalize_specific", noted)
    return names


def new() -> tuple[Any, float]:
    """Return a function that no cache knows, and what it makes of −2."""
    gain = 1.0 + int.from_bytes(os.urandom(4)) / 2**32

    @gi.helper
    def inner_helper_of_test(x):
        return gain * gi.maximum(x, -x)

    @gi.field
    def outer_field_of_test(params, t, y, out, work):
        out[0] = inner_helper_of_test(y[0])

    return outer_field_of_test, 2.0 * gain


@gi.field
def unknown(params, t, y, out, work):
    out[0] = missing(y[0])  # noqa: F821


def value(function: Any) -> float:
    return float(gi.pointwise(function, [], [[-2.0]], rows=1, check=False)[0, 0])


def refused(function: Any = unknown) -> None:
    with pytest.raises(gi.DeclarationError, match="missing"):
        value(function)


def test_helpers_have_no_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    names, (function, expected) = made(monkeypatch), new()
    assert value(function) == expected
    assert [name for name in names if "outer_field_of_test" in name]
    assert not [name for name in names if "inner_helper_of_test" in name]


def test_numba_is_left_as_it_was() -> None:
    """Also by what cannot be compiled."""
    codegen = cpu_target.target_context.codegen()
    with numba_inside.linked():
        assert codegen._library_class is numba_inside.Linked
    refused()
    assert codegen._library_class is JITCodeLibrary

    @numba.njit
    def own(x):
        return max(x, 0.5) + abs(x)

    value(new()[0])
    assert own(-2.0) == 2.5


@pytest.mark.parametrize("on", [True, False])
def test_collection_of_garbage_is_as_it_was(on: bool) -> None:
    """It rests while a function is compiled, also where that fails."""
    seen: list[bool] = []
    end = listen(lambda name, seconds: seen.append(gc.isenabled()))
    (gc.enable if on else gc.disable)()
    try:
        value(new()[0])
        refused()
        assert gc.isenabled() == on
    finally:
        gc.enable()
        end()
    assert seen
    assert not any(seen)


def test_the_depth_of_the_caller_does_not_matter() -> None:
    """Called where Python has a few dozen calls left; a function that fails there leaves the limit."""
    function, expected = new()
    value(new()[0])  # what is imported is

    def depth() -> int:
        frame, count = sys._getframe(), 0
        while frame := frame.f_back:
            count += 1
        return count

    def deep(left: int) -> None:
        if left:
            deep(left - 1)
        else:
            assert value(function) == expected
            refused()

    before = sys.getrecursionlimit()
    deep(before - depth() - 70)
    assert sys.getrecursionlimit() == before
