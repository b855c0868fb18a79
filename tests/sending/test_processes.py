"""Runs in processes that are spawned: the same bits, by the code that another process compiled."""

from __future__ import annotations

import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
import pytest

import geomint as gi
from tests.sending.other_process import in_process, made, solved


@pytest.mark.filterwarnings(
    "ignore:steps of .* are so long:geomint.GeomintWarning", "ignore::geomint.DeclarationWarning"
)
def test_the_same_bits_by_the_same_code() -> None:
    ball = gi.load_scene("ball-3d")
    session: dict[str, Any] = {"gi": gi, "__name__": "__main__"}
    exec("@gi.field\ndef mine(params, t, y, out, work):\n    out[0] = -3.0 * y[0]", session)
    cases = [
        (ball.problem, ball.state, gi.CommutatorFree()),
        (made(2.0), np.array([1.0, 0.0]), gi.RungeKutta()),
        (gi.Problem("mine", (("y", 1),), field=session["mine"]), np.ones(1), gi.RungeKutta()),
    ]
    own = [solved(*case) for case in cases]
    context = multiprocessing.get_context("spawn")
    for again in (False, True):  # the first may compile what this one keeps elsewhere
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            for solution, case in zip(own, cases, strict=True):
                found, compiled = pool.submit(in_process, *case).result()
                assert found == solution
                assert found.y.tobytes() == solution.y.tobytes()
                assert not (again and compiled)
