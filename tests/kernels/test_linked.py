"""Machine code is made of what is called alone, and numba's own compilation goes on as it was."""

from __future__ import annotations

import gc
import os
import sys

import numba
import numpy as np
import pytest
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import cpu_target

import geomint as gi
from geomint.kernels.compiling import linked
from geomint.kernels.compiling.bound import Bound
from geomint.kernels.compiling.compile import listen
from geomint.kernels.compiling.signatures import FIELD
from geomint.kernels.numbers.blocks import Block, scalar_block

jitted = pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is compiled")


def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a list that gets the names of libraries of which machine code is made."""
    names: list[str] = []
    finalize = JITCodeLibrary._finalize_specific

    def noted(self: JITCodeLibrary) -> None:
        names.append(self.name)
        finalize(self)

    monkeypatch.setattr(JITCodeLibrary, "_finalize_specific", noted)
    return names


def new() -> float:
    """Return a number that no cache knows."""
    return 1.0 + int.from_bytes(os.urandom(4)) / 2**32


def problem(gain: float) -> tuple[Bound, gi.Problem]:
    @gi.helper
    def inner_helper_of_test(x):
        return gain * gi.maximum(x, -x)

    @gi.field
    def outer_field_of_test(params, t, y, out, work):
        out[0] = inner_helper_of_test(y[0])

    return Bound(outer_field_of_test, FIELD), gi.Problem(
        "linked", (("x", 1),), field=outer_field_of_test
    )


@jitted
def test_helpers_have_no_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    names = made(monkeypatch)
    gain = new()
    field, _ = problem(gain)
    out = scalar_block(1)
    call = field.call(
        params=scalar_block(0), t=0.0, y=Block(np.array([-2.0])), out=out, work=scalar_block(0)
    )
    call()
    assert out.data[0] == 2.0 * gain
    assert [name for name in names if "outer_field_of_test" in name]
    assert not [name for name in names if "inner_helper_of_test" in name]


@jitted
def test_numba_is_left_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    codegen = cpu_target.target_context.codegen()
    before = codegen._library_class
    with linked.linked():
        assert codegen._library_class is linked.Linked
    with pytest.raises(ZeroDivisionError), linked.linked():
        divmod(1, 0)
    assert codegen._library_class is before is JITCodeLibrary

    @numba.njit
    def own(x):
        return max(x, 0.5) + abs(x)

    field, _ = problem(1.5)
    field.entry()
    assert own(-2.0) == 2.5


@jitted
def test_without_what_it_needs_of_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    names = made(monkeypatch)
    monkeypatch.setattr(linked, "_NEEDED", ("not_there",))
    _, own = problem(new())
    end = gi.solve(own, [1.0], t_end=1.0, method="rk-4", step=0.5).y[-1, 0]
    assert end == gi.solve(own, [1.0], t_end=1.0, method="rk-4", step=0.5, compiled=False).y[-1, 0]
    assert [name for name in names if "inner_helper_of_test" in name]


@jitted
@pytest.mark.parametrize("on", [True, False])
def test_collection_of_garbage_is_as_it_was(on: bool) -> None:
    """It rests while a function is compiled, also where that fails."""
    seen = []

    @gi.field
    def seven(params, t, y, out, work):
        out[0] = 7.0 * y[0]

    @gi.field
    def none(params, t, y, out, work):
        out[0] = missing(y[0])  # noqa: F821

    end = listen(lambda name, seconds: seen.append(gc.isenabled()))
    (gc.enable if on else gc.disable)()
    try:
        Bound(seven, FIELD).entry()
        with pytest.raises(gi.DeclarationError):
            Bound(none, FIELD).entry()
        assert gc.isenabled() == on
    finally:
        gc.enable()
        end()
    assert seen
    assert not any(seen)


@jitted
def test_the_depth_of_the_caller_does_not_matter() -> None:
    """Called where Python has a few dozen calls left; a function that fails there leaves the limit."""
    bound, _ = problem(new())
    Bound(problem(new())[0].recorded, FIELD).entry()  # what is imported is

    @gi.field
    def none(params, t, y, out, work):
        out[0] = missing(y[0])  # noqa: F821

    def depth() -> int:
        frame, count = sys._getframe(), 0
        while frame := frame.f_back:
            count += 1
        return count

    def deep(left: int) -> None:
        if left:
            deep(left - 1)
        else:
            bound.entry()
            with pytest.raises(gi.DeclarationError, match="missing"):
                Bound(none, FIELD).entry()

    before = sys.getrecursionlimit()
    deep(before - depth() - 70)
    assert sys.getrecursionlimit() == before
